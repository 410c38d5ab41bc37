//! Pieces of a path, made and checked where there is time for it: ahead of the servo steps that follow them.

use super::Range;
use super::fixed::{FixedSegment, Unfixable};
use super::report::PushError;
use super::segment::{End, Excess, Segment, reach_from};
use super::tail::{Tail, TailLimits};
use crate::angle::Angle;
use crate::knot::{AxisEnvelope, EnvelopeError, Knot};

/// Where a path ends, as far as it is known: what the next piece of it is made from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tip<const N: usize> {
    /// Counts the ends that the path has had.
    pub(super) generation: u32,
    pub(super) end: End<N>,
}

impl<const N: usize> Tip<N> {
    /// Of no path.
    #[must_use]
    pub const fn nowhere() -> Self {
        Self {
            generation: 0,
            end: End {
                at_us: 0,
                position: [0.0; N],
                velocity: [0.0; N],
                acceleration: [0.0; N],
            },
        }
    }

    /// Path time there, µs.
    #[must_use]
    pub const fn at_us(&self) -> u64 {
        self.end.at_us
    }

    /// The same of a path that will [start](super::Interpolator::start) there, at this time: where set-points stand then.
    #[must_use]
    pub fn starting_at(&self, at_us: u64) -> Self {
        let stands = |position: f64| Angle::bound(position).to_f64();
        Self {
            generation: self.generation,
            end: End::at_rest(at_us, self.end.position.map(stands)),
        }
    }
}

/// A piece of a path that has been checked, and the stop behind it; in the numbers that a servo step computes with.
#[derive(Clone, Copy, Debug)]
pub struct Piece<const N: usize> {
    /// Of the tip from which it was made.
    pub(super) generation: u32,
    pub(super) fixed: FixedSegment<N>,
    pub(super) end: End<N>,
    pub(super) tail: Tail<N>,
}

impl<const N: usize> Piece<N> {
    /// Where a path ends that has it as its last piece.
    #[must_use]
    pub const fn tip(&self) -> Tip<N> {
        Tip {
            generation: self.generation.wrapping_add(1),
            end: self.end,
        }
    }

    /// Path time at which it was made to begin, µs.
    #[must_use]
    pub const fn begins_us(&self) -> u64 {
        self.fixed.start_us()
    }

    /// Positions where it ends.
    #[must_use]
    pub const fn end(&self) -> &[f64; N] {
        &self.end.position
    }
}

/// A piece, and what it means.
#[derive(Clone, Copy, Debug)]
pub struct Made<const N: usize> {
    /// The piece.
    pub piece: Piece<N>,
    /// Step of acceleration of each axis where it begins, by magnitude: zero to rounding for a knot with accelerations,
    /// bounded by [`AxisEnvelope::acceleration_step`] without.
    pub acceleration_step: [f64; N],
}

/// What a path may ask of the axes: envelopes that have been found good.
#[derive(Clone, Copy, Debug)]
pub struct PathLimits<const N: usize> {
    axes: [AxisEnvelope; N],
    tails: [TailLimits; N],
}

impl<const N: usize> PathLimits<N> {
    /// # Errors
    /// [`EnvelopeError`]: senseless limits, or plan limits that leave no room to stop.
    // one function: the node's setup asks for it, and each of its plans
    #[inline(never)]
    pub fn new(axes: [AxisEnvelope; N]) -> Result<Self, EnvelopeError> {
        for (axis, envelope) in (0..N).zip(&axes) {
            envelope.validate(axis)?;
        }
        Ok(Self {
            axes,
            tails: axes.each_ref().map(TailLimits::new),
        })
    }

    /// The envelopes.
    #[must_use]
    pub const fn axes(&self) -> &[AxisEnvelope; N] {
        &self.axes
    }

    /// The positions that the envelopes allow.
    #[must_use]
    pub fn ranges(&self) -> [Range; N] {
        let bounds = |axis: &AxisEnvelope| (Angle::bound(axis.lower), Angle::bound(axis.upper));
        self.axes.each_ref().map(bounds)
    }

    /// The piece from the end of a path to a knot, if it and the stop behind it keep all limits. Knot times are path
    /// time: see [`path_time_us`](super::Interpolator::path_time_us).
    ///
    /// # Errors
    /// [`PushError`]: what the knot breaks.
    pub fn piece(&self, from: &Tip<N>, knot: &Knot<N>) -> Result<Made<N>, PushError> {
        let Tip { generation, end } = from;
        if let Some(axis) = not_finite(knot) {
            return Err(PushError::NotFinite { axis });
        }
        if knot.at_us <= end.at_us {
            return Err(PushError::NotMonotone {
                previous_us: end.at_us,
            });
        }
        let mut segment = Segment::new(end, knot);
        let reach = reach_from(&self.axes, &end.position);
        if let Some(excess) = segment.excess(&self.axes, &reach) {
            let Excess {
                axis,
                quantity,
                value,
                limit,
            } = excess;
            return Err(PushError::Limit {
                axis,
                quantity,
                value,
                limit,
            });
        }
        let acceleration_step = segment.acceleration_step(end);
        if knot.acceleration.is_none() {
            self.bounded(&acceleration_step)?;
            if knot.velocity.iter().all(|v| v.abs() <= 0.0) {
                // at rest: the acceleration left by the cubic ends in a step
                self.bounded(&segment.end.acceleration)?;
                segment.end.acceleration = [0.0; N];
            }
        }
        let (tail, goes) = Tail::new(&segment.end, &self.tails).map_err(unfixable)?;
        for (axis, ((low, high), (lower, upper))) in (0..N).zip(goes.iter().zip(&reach)) {
            let (value, limit) = if low < lower {
                (*low, *lower)
            } else {
                (*high, *upper)
            };
            if low < lower || high > upper {
                return Err(PushError::NoRoomToStop { axis, value, limit });
            }
        }
        Ok(Made {
            piece: Piece {
                generation: *generation,
                fixed: FixedSegment::new(&segment).map_err(unfixable)?,
                end: segment.end,
                tail,
            },
            acceleration_step,
        })
    }

    fn bounded(&self, steps: &[f64; N]) -> Result<(), PushError> {
        for (axis, (step, envelope)) in (0..N).zip(steps.iter().zip(&self.axes)) {
            let (value, limit) = (step.abs(), envelope.acceleration_step);
            if value > limit {
                return Err(PushError::AccelerationStep { axis, value, limit });
            }
        }
        Ok(())
    }
}

fn unfixable(unfixable: Unfixable) -> PushError {
    match unfixable {
        Unfixable::Long => PushError::Long,
        Unfixable::Far { axis, value, limit } => PushError::Far { axis, value, limit },
    }
}

fn not_finite<const N: usize>(knot: &Knot<N>) -> Option<usize> {
    let finite = |values: &[f64; N]| values.iter().position(|x| !x.is_finite());
    finite(&knot.position)
        .or_else(|| finite(&knot.velocity))
        .or_else(|| knot.acceleration.as_ref().and_then(finite))
}
