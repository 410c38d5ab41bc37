//! From knots to set-points at a fixed step: on the path, within limits, and always able to stop.
//!
//! The interpolator runs every servo step on the controller node. It follows polynomial segments between
//! queued [`Knot`]s: quintic (C2) or, for knots without accelerations, cubic (C1).
//!
//! **Two kinds of limits.** Knots are held to the *plan* limits: the exact extrema of every segment are
//! compared when it is pushed, before anything moves. Set-points keep the *hard* limits, whatever happens:
//! the room between is what stopping on the path needs (see [`AxisEnvelope`]).
//!
//! **The path never just ends.** Behind the last knot lies a stop tail: C2 with the path, along its tangent,
//! to rest, within hard limits and, checked at push, within the position limits. It exists for every end
//! that the plan limits allow. So at any time a stop is known that needs no further message. An underrun
//! is nothing but the path going on into its tail.
//!
//! **Feed rate.** Path time runs at a rate r in \[0, 1\]. [`feed_hold`](Interpolator::feed_hold),
//! [`resume`](Interpolator::resume) and [`set_override`](Interpolator::set_override) change it with
//! limited ṙ and r̈, interruptible at any moment without a jump. With position p(s), ds/dt = r:
//! velocity p'·r, acceleration p''·r² + p'·ṙ, jerk p'''·r³ + 3·p''·r·ṙ + p'·r̈. The limits of ṙ and r̈ are
//! constants, such that these stay within the hard limits wherever on the path, or tail, the rate changes.
//! (Steps of acceleration in cubic segments come on top of the jerk.)
//!
//! **Numbers.** Knots come and are checked in f64; set-points are made of them in fixed point ([`Angle`]) and f32, which cost a
//! microcontroller a fiftieth. The stop tail and a quick stop, which are rare, are computed in f64 and end in the same numbers.
//!
//! Times are the caller's integer microseconds; at rate 1, path time is that time less a constant.

mod command;
mod fixed;
mod query;
mod queue;
mod rate;
mod report;
mod segment;
mod step;
mod tail;

pub use fixed::EVALUATION_QUANTA;
pub use report::{
    Accepted, Moving, Output, PushError, QuickStop, StartError, Status, StopCause, StopTail,
};

use crate::angle::Angle;
use crate::knot::{AxisEnvelope, EnvelopeError, Knot, Setpoint};
use crate::ramp::Ramp;
use fixed::{FixedSegment, Unfixable};
use queue::Queue;
use rate::{PathClock, RateLimits};
use segment::{End, Excess, Segment, reach_from};
use tail::{Tail, TailLimits};

/// Fixed-step interpolation of N axes with room for Q segments.
///
/// ```
/// use motion::profile::AxisLimits;
/// use motion::{Angle, AxisEnvelope, Interpolator, Knot, Status};
/// let hard = AxisLimits { v: 100.0, a: 1000.0, j: 50_000.0 };
/// let mut edp = Interpolator::<1, 8>::new([AxisEnvelope::new(-10.0, 10.0, hard)], [Angle::ZERO])?;
/// edp.start(0)?;
/// edp.push(
///     Knot { at_us: 100_000, position: [0.2], velocity: [0.0], acceleration: Some([0.0]) },
///     0,
/// )?;
/// let half_way = edp.step(50_000);
/// assert!((half_way.setpoint.position[0].to_f64() - 0.1).abs() < 1e-11);
/// assert_eq!(Some(edp.step(100_000).setpoint.position[0]), Angle::nearest(0.2));
/// assert_eq!(edp.step(102_000).status, Status::Idle);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Interpolator<const N: usize, const Q: usize> {
    axes: [AxisEnvelope; N],
    tails: [TailLimits; N],
    clock: PathClock,
    hold_s: f64,
    feed_override: f64,
    hold: bool,
    queue: Queue<N, Q>,
    /// State at the last knot, and the way to rest from there.
    end: End<N>,
    tail: Tail<N>,
    /// Position limits of the present path, which may have begun outside.
    reach: [(Angle, Angle); N],
    mode: Mode<N>,
    now_us: u64,
    setpoint: Setpoint<N>,
}

/// How fast the feed rate of a path may change: a constant of the envelopes' hard and plan limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FeedPace {
    limits: RateLimits,
    /// How long a feed hold takes from rate 1, s.
    hold_s: f64,
}

impl FeedPace {
    /// The pace with the shortest feed hold. Of no use where [`Interpolator::new`] refuses the envelopes.
    #[must_use]
    pub fn new<const N: usize>(axes: &[AxisEnvelope; N]) -> Self {
        let limits = RateLimits::new(axes);
        Self {
            limits,
            hold_s: Ramp::new(1.0, 0.0, 0.0, limits.first, limits.second).duration(),
        }
    }
}

#[derive(Clone, Copy, Debug)]
enum Mode<const N: usize> {
    Idle,
    Waiting { starts_at_us: u64 },
    OnPath,
    OnTail,
    OffPath(OffPath<N>),
    Stopped { cause: StopCause },
}

/// A quick stop under way: the velocity of each axis goes to zero.
#[derive(Clone, Copy, Debug)]
struct OffPath<const N: usize> {
    since_us: u64,
    /// How long the last axis takes, s.
    duration: f64,
    from: [Angle; N],
    velocity: [Ramp; N],
}

impl<const N: usize, const Q: usize> Interpolator<N, Q> {
    /// Idle, holding a position. A position outside its limits may be held; motion then only leads back.
    ///
    /// # Errors
    /// [`EnvelopeError`]: senseless limits, or plan limits that leave no room to stop.
    pub fn new(axes: [AxisEnvelope; N], hold: [Angle; N]) -> Result<Self, EnvelopeError> {
        Self::with_pace(axes, hold, FeedPace::new(&axes))
    }

    /// The same with a pace that was found before, of envelopes that differ from these in the limits of position
    /// at most: finding it costs a hundred times what is left to do here.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_pace(
        axes: [AxisEnvelope; N],
        hold: [Angle; N],
        pace: FeedPace,
    ) -> Result<Self, EnvelopeError> {
        let mut interpolator = Self::nothing(pace);
        interpolator.hold_anew(axes, hold)?;
        Ok(interpolator)
    }

    /// Idle at 0, where no axis may move: a place in which to [hold](Self::hold_anew) with this pace.
    #[must_use]
    pub fn nothing(pace: FeedPace) -> Self {
        Self {
            axes: [AxisEnvelope::NOWHERE; N],
            tails: [TailLimits::NOWHERE; N],
            clock: PathClock::new(pace.limits),
            hold_s: pace.hold_s,
            feed_override: 1.0,
            hold: false,
            queue: Queue::new(),
            end: End::at_rest(0, [0.0; N]),
            tail: Tail::NONE,
            reach: [(Angle::ZERO, Angle::ZERO); N],
            mode: Mode::Idle,
            now_us: 0,
            setpoint: Setpoint::at_rest([Angle::ZERO; N]),
        }
    }

    /// As [`with_pace`](Self::with_pace), in the place of what there was, with its pace.
    ///
    /// # Errors
    /// As [`new`](Self::new); nothing has changed then.
    pub fn hold_anew(
        &mut self,
        axes: [AxisEnvelope; N],
        hold: [Angle; N],
    ) -> Result<(), EnvelopeError> {
        for (axis, envelope) in (0..N).zip(&axes) {
            envelope.validate(axis)?;
        }
        self.axes = axes;
        self.tails = axes.each_ref().map(TailLimits::new);
        self.clock.reset();
        self.feed_override = 1.0;
        self.hold = false;
        self.mode = Mode::Idle;
        self.now_us = 0;
        self.setpoint = Setpoint::at_rest(hold);
        self.begin(0);
        Ok(())
    }

    /// Begins a path: the held position becomes its first knot, at `at_us`.
    ///
    /// # Errors
    /// [`StartError::NotIdle`] unless idle, [`StartError::Late`] when a later step has been made.
    pub fn start(&mut self, at_us: u64) -> Result<(), StartError> {
        if !matches!(self.mode, Mode::Idle) {
            return Err(StartError::NotIdle);
        }
        if at_us < self.now_us {
            return Err(StartError::Late);
        }
        self.begin(at_us);
        self.clock.start(at_us, self.rate_asked());
        self.mode = Mode::Waiting {
            starts_at_us: at_us,
        };
        Ok(())
    }

    /// An empty path at rest at the present position.
    fn begin(&mut self, at_us: u64) {
        self.queue.clear();
        self.end = End::at_rest(at_us, self.setpoint.position.map(Angle::to_f64));
        self.tail = Tail::new(&self.end, &self.tails);
        let reach = reach_from(&self.axes, &self.end.position);
        self.reach = reach.map(|(lower, upper)| (Angle::bound(lower), Angle::bound(upper)));
    }

    /// Appends a knot, if the segment to it and the stop behind it keep all limits.
    ///
    /// Knot times are path time: see [`path_time_us`](Self::path_time_us).
    ///
    /// # Errors
    /// [`PushError`]; a refused knot changes nothing.
    pub fn push(&mut self, knot: Knot<N>, now_us: u64) -> Result<Accepted<N>, PushError> {
        self.may_continue()?;
        if self.queue.is_full() {
            return Err(PushError::Full);
        }
        if let Some(axis) = not_finite(&knot) {
            return Err(PushError::NotFinite { axis });
        }
        if knot.at_us <= self.end.at_us {
            return Err(PushError::NotMonotone {
                previous_us: self.end.at_us,
            });
        }
        let path_us = self.path_time_us(now_us);
        if knot.at_us <= path_us {
            return Err(PushError::Late { path_us });
        }
        let mut segment = Segment::new(&self.end, &knot);
        let reach = reach_from(&self.axes, &self.end.position);
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
        let acceleration_step = segment.acceleration_step(&self.end);
        if knot.acceleration.is_none() {
            self.bounded(&acceleration_step)?;
            if knot.velocity.iter().all(|v| v.abs() <= 0.0) {
                // at rest: the acceleration left by the cubic ends in a step
                self.bounded(&segment.end.acceleration)?;
                segment.end.acceleration = [0.0; N];
            }
        }
        let tail = Tail::new(&segment.end, &self.tails);
        for (axis, ((low, high), (lower, upper))) in
            tail.reach(&segment.end).zip(&reach).enumerate()
        {
            let (value, limit) = if low < *lower {
                (low, *lower)
            } else {
                (high, *upper)
            };
            if low < *lower || high > *upper {
                return Err(PushError::NoRoomToStop { axis, value, limit });
            }
        }
        let fixed = FixedSegment::new(&segment).map_err(|unfixable| match unfixable {
            Unfixable::Long => PushError::Long,
            Unfixable::Far { axis, value, limit } => PushError::Far { axis, value, limit },
        })?;
        self.end = segment.end;
        self.tail = tail;
        self.queue.push(fixed);
        Ok(Accepted { acceleration_step })
    }

    fn may_continue(&self) -> Result<(), PushError> {
        let cause = match self.mode {
            Mode::Waiting { .. } | Mode::OnPath => return Ok(()),
            Mode::Idle => return Err(PushError::NotStarted),
            Mode::OnTail => StopCause::Underrun,
            Mode::OffPath(_) => StopCause::QuickStop,
            Mode::Stopped { cause } => cause,
        };
        Err(PushError::Stopped { cause })
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

fn not_finite<const N: usize>(knot: &Knot<N>) -> Option<usize> {
    let finite = |values: &[f64; N]| values.iter().position(|x| !x.is_finite());
    finite(&knot.position)
        .or_else(|| finite(&knot.velocity))
        .or_else(|| knot.acceleration.as_ref().and_then(finite))
}
