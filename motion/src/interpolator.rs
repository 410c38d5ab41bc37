//! From knots to set-points at a fixed step: on the path, within limits, and always able to stop.
//!
//! The interpolator runs every servo step on the controller node. It follows polynomial segments between
//! queued [`Knot`](crate::Knot)s: quintic (C2) or, for knots without accelerations, cubic (C1).
//!
//! **Two kinds of limits.** Knots are held to the *plan* limits: the exact extrema of every segment are
//! compared when it is made, before anything moves. Set-points keep the *hard* limits, whatever happens:
//! the room between is what stopping on the path needs (see [`AxisEnvelope`](crate::AxisEnvelope)).
//!
//! **The path never just ends.** Behind the last knot lies a stop tail: C2 with the path, along its tangent,
//! to rest, within hard limits and, checked with the piece, within the position limits. It exists for every end
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
//! **Numbers.** Knots come and are checked in f64, which takes a microcontroller two servo steps: so it is done ahead of
//! them, by [`PathLimits::piece`]. What comes of it is a [`Piece`] in fixed point ([`Angle`]) and f32, which cost a fiftieth;
//! the servo step only takes it over, if the path still [ends](Tip) where it was made to begin. Set-points on the path, on
//! its stop tail and in a quick stop are made of integers and f32 too, and so is what changes the feed rate.
//!
//! Times are the caller's integer microseconds; at rate 1, path time is that time less a constant.

mod braking;
mod command;
mod fixed;
mod piece;
mod query;
mod queue;
mod rate;
mod rate_ramp;
mod report;
mod segment;
mod span;
mod step;
mod stop;
mod tail;

pub use braking::Braking;
pub use fixed::EVALUATION_QUANTA;
pub use piece::{Made, PathLimits, Piece, Tip};
pub use report::{Moving, Output, PushError, QuickStop, StartError, Status, StopCause, StopTail};

use crate::angle::Angle;
use crate::knot::Setpoint;
use queue::Queue;
use rate::{FeedRate, PathClock};
use segment::End;
use stop::AxisStop;
use tail::Tail;

/// Fixed-step interpolation of N axes with room for Q segments.
///
/// ```
/// use motion::interpolator::{Braking, PathLimits};
/// use motion::profile::AxisLimits;
/// use motion::{Angle, AxisEnvelope, Interpolator, Knot, Status};
/// let hard = AxisLimits { v: 100.0, a: 1000.0, j: 50_000.0 };
/// let limits = PathLimits::new([AxisEnvelope::new(-10.0, 10.0, hard)])?;
/// let mut edp = Interpolator::<1, 8>::new(Braking::new(limits.axes()));
/// edp.hold_anew(&limits.ranges(), [Angle::ZERO]);
/// edp.start(0)?;
/// let knot = Knot { at_us: 100_000, position: [0.2], velocity: [0.0], acceleration: Some([0.0]) };
/// let made = limits.piece(&edp.tip(), &knot)?;
/// edp.push(&made.piece, 0)?;
/// let half_way = edp.step(50_000);
/// assert!((half_way.setpoint.position[0].to_f64() - 0.1).abs() < 1e-11);
/// assert_eq!(Some(edp.step(100_000).setpoint.position[0]), Angle::nearest(0.2));
/// assert_eq!(edp.step(102_000).status, Status::Idle);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Interpolator<const N: usize, const Q: usize> {
    braking: Braking<N>,
    /// Position limits of the axes.
    ranges: [Range; N],
    clock: PathClock,
    feed_override: FeedRate,
    hold: bool,
    queue: Queue<N, Q>,
    /// State at the last knot, and the way to rest from there.
    end: End<N>,
    tail: Tail<N>,
    /// How often `end` has become another state.
    generation: u32,
    /// Position limits of the present path, which may have begun outside.
    reach: [Range; N],
    mode: Mode,
    off_path: OffPath<N>,
    now_us: u64,
    setpoint: Setpoint<N>,
}

/// Where an axis may be: from, to.
pub type Range = (Angle, Angle);

#[derive(Clone, Copy, Debug)]
enum Mode {
    Idle,
    Waiting { starts_at_us: u64 },
    OnPath,
    OnTail,
    OffPath,
    Stopped { cause: StopCause },
}

/// The quick stop under way, or the last: the velocity of each axis goes to zero.
#[derive(Clone, Copy, Debug)]
struct OffPath<const N: usize> {
    since_us: u64,
    /// How long the last axis takes, µs.
    duration_us: u64,
    from: [Angle; N],
    axes: [AxisStop; N],
}

impl<const N: usize, const Q: usize> Interpolator<N, Q> {
    /// Idle at 0, where no axis may move: a place in which to [hold](Self::hold_anew).
    #[must_use]
    pub fn new(braking: Braking<N>) -> Self {
        Self {
            braking,
            ranges: [(Angle::ZERO, Angle::ZERO); N],
            clock: PathClock::new(braking.rate),
            feed_override: FeedRate::FULL,
            hold: false,
            queue: Queue::new(),
            end: End::at_rest(0, [0.0; N]),
            tail: Tail::at_rest([Angle::ZERO; N]),
            generation: 0,
            reach: [(Angle::ZERO, Angle::ZERO); N],
            mode: Mode::Idle,
            off_path: OffPath {
                since_us: 0,
                duration_us: 0,
                from: [Angle::ZERO; N],
                axes: [AxisStop::NONE; N],
            },
            now_us: 0,
            setpoint: Setpoint::at_rest([Angle::ZERO; N]),
        }
    }

    /// Idle, holding a position, in the place of what there was. A position outside its range may be held; motion
    /// then only leads back. The ranges are [those](PathLimits::ranges) of the limits by which pieces are made.
    pub fn hold_anew(&mut self, ranges: &[Range; N], hold: [Angle; N]) {
        self.ranges = *ranges;
        self.clock.reset();
        self.feed_override = FeedRate::FULL;
        self.hold = false;
        self.mode = Mode::Idle;
        self.now_us = 0;
        self.setpoint = Setpoint::at_rest(hold);
        self.begin(0);
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
        // idle, it ends where it stands
        self.end.at_us = at_us;
        self.renew();
        self.clock.start(at_us, self.rate_asked());
        self.mode = Mode::Waiting {
            starts_at_us: at_us,
        };
        Ok(())
    }

    /// An empty path at rest at the present position: another end.
    fn begin(&mut self, at_us: u64) {
        self.end = End::at_rest(at_us, self.setpoint.position.map(Angle::to_f64));
        self.generation = self.generation.wrapping_add(1);
        self.renew();
    }

    /// Nothing is left of the path before, and its limits are those of where it stands.
    fn renew(&mut self) {
        self.queue.clear();
        self.tail = Tail::at_rest(self.setpoint.position);
        let positions = &self.setpoint.position;
        for ((reach, range), p) in self.reach.iter_mut().zip(&self.ranges).zip(positions) {
            *reach = (range.0.min(*p), range.1.max(*p));
        }
    }

    /// Appends a piece that was made from where the path ends.
    ///
    /// # Errors
    /// [`PushError`]; a refused piece changes nothing.
    pub fn push(&mut self, piece: &Piece<N>, now_us: u64) -> Result<(), PushError> {
        if piece.fixed.start_us() != self.end.at_us {
            self.may_continue()?;
            return Err(PushError::Stale);
        }
        self.push_whenever(piece, now_us)
    }

    /// The same, whenever the path ends: the piece lasts as long as it was made to last.
    ///
    /// # Errors
    /// As [`push`](Self::push).
    pub fn push_whenever(&mut self, piece: &Piece<N>, now_us: u64) -> Result<(), PushError> {
        self.may_continue()?;
        if piece.generation != self.generation {
            return Err(PushError::Stale);
        }
        if self.queue.is_full() {
            return Err(PushError::Full);
        }
        let fixed = piece.fixed.begun_at(self.end.at_us);
        let path_us = self.path_time_us(now_us);
        if fixed.end_us() <= path_us {
            return Err(PushError::Late { path_us });
        }
        self.end = End {
            at_us: fixed.end_us(),
            ..piece.end
        };
        self.tail = piece.tail;
        self.generation = self.generation.wrapping_add(1);
        self.queue.push(fixed);
        Ok(())
    }

    fn may_continue(&self) -> Result<(), PushError> {
        let cause = match self.mode {
            Mode::Waiting { .. } | Mode::OnPath => return Ok(()),
            Mode::Idle => return Err(PushError::NotStarted),
            Mode::OnTail => StopCause::Underrun,
            Mode::OffPath => StopCause::QuickStop,
            Mode::Stopped { cause } => cause,
        };
        Err(PushError::Stopped { cause })
    }
}
