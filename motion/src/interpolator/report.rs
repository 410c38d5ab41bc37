//! What an interpolator answers: outputs, status, refusals.

use crate::angle::Angle;
use crate::knot::{Quantity, Setpoint};
use core::fmt;

/// What one step of the interpolator gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Output<const N: usize> {
    /// Where to be now.
    pub setpoint: Setpoint<N>,
    /// What the interpolator is doing.
    pub status: Status,
}

/// What the interpolator is doing.
///
/// ```text
///  Idle ──start──► Waiting ──time──► Following ◄──► Changing ◄──► Held
///   ▲ ▲                                 │ │ (any of the three)
///   │ └────── end of path, at rest ─────┘ ├── end of path, moving ─► Stopping(Underrun) ─► Stopped(Underrun)
///   └── flush, from rest                  └── quick_stop ──────────► Stopping(QuickStop) ► Stopped(QuickStop)
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Status {
    /// At rest, holding a position; no path.
    Idle,
    /// At rest until the path begins.
    Waiting {
        /// When it begins, µs.
        starts_at_us: u64,
    },
    /// On the path at a constant feed rate in (0, 1].
    Following {
        /// Path time per time.
        rate: f32,
    },
    /// On the path while the feed rate changes; a target of 0 is a feed hold.
    Changing {
        /// Path time per time, now.
        rate: f32,
        /// And when the change has ended.
        target: f32,
    },
    /// At rest on the path, feed rate 0: the path can be resumed.
    Held,
    /// Coming to rest without being asked to (or off the path); nothing can be resumed.
    Stopping {
        /// Why.
        cause: StopCause,
    },
    /// At rest after a stop, until [`flush`](super::Interpolator::flush).
    Stopped {
        /// Why it stopped.
        cause: StopCause,
    },
}

/// Why a path ended before its time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopCause {
    /// The last knot passed while moving, and no other was there.
    Underrun,
    /// [`quick_stop`](super::Interpolator::quick_stop).
    QuickStop,
}

/// How a quick stop is carried out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QuickStop {
    /// Every axis stops as fast as it can: the path is left.
    OffPath,
    /// An axis would leave its position limits that way: stopping on the path by a feed hold instead,
    /// which cannot.
    OnPath,
    /// Everything was at rest; the path, if any, is cancelled.
    AtRest,
}

/// Where and when everything would come to rest without another knot, at the present feed rate 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StopTail<const N: usize> {
    /// The positions at rest.
    pub position: [Angle; N],
    /// Path time at rest, µs.
    pub at_us: u64,
}

/// Why a path cannot begin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StartError {
    /// There is a path already, or a stop has not been flushed.
    NotIdle,
    /// The time is over.
    Late,
}

/// Why a knot is refused, or the piece to it; the path is as it was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PushError {
    /// No path has begun: [`start`](super::Interpolator::start) first.
    NotStarted,
    /// A stop has ended the path: [`flush`](super::Interpolator::flush) first.
    Stopped {
        /// Why.
        cause: StopCause,
    },
    /// The queue has no room.
    Full,
    /// Not later than the knot before.
    NotMonotone {
        /// Time of the knot before, µs.
        previous_us: u64,
    },
    /// The path does not end where the piece begins: it was made for another.
    Stale,
    /// Its time has passed.
    Late {
        /// Path time now, µs.
        path_us: u64,
    },
    /// Infinite or not a number.
    NotFinite {
        /// Which axis.
        axis: usize,
    },
    /// The segment to the knot would leave a limit somewhere.
    Limit {
        /// Which axis.
        axis: usize,
        /// What.
        quantity: Quantity,
        /// The extreme value.
        value: f64,
        /// The plan limit (or position limit).
        limit: f64,
    },
    /// A cubic segment would begin, or end at rest, with too large a step of acceleration.
    AccelerationStep {
        /// Which axis.
        axis: usize,
        /// The step, by magnitude.
        value: f64,
        /// The largest allowed.
        limit: f64,
    },
    /// The segment lasts longer than the 71 minutes (2³² µs) for which there is fixed point.
    Long,
    /// The segment begins, or goes, farther than fixed point reaches.
    Far {
        /// Which axis.
        axis: usize,
        /// Where it begins, or the sum of its polynomial's coefficients; by magnitude.
        value: f64,
        /// What that may be.
        limit: f64,
    },
    /// Stopping behind the knot would leave the position limits.
    NoRoomToStop {
        /// Which axis.
        axis: usize,
        /// How far the stop may go.
        value: f64,
        /// The position limit.
        limit: f64,
    },
}

/// Refused because the set-point is moving.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Moving;

impl fmt::Display for StopCause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Underrun => "underrun",
            Self::QuickStop => "quick stop",
        })
    }
}

impl fmt::Display for StartError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotIdle => "a path is under way",
            Self::Late => "the start time has passed",
        })
    }
}

impl fmt::Display for PushError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotStarted => f.write_str("no path has begun"),
            Self::Stopped { cause } => write!(f, "the path was ended by {cause}"),
            Self::Full => f.write_str("the queue is full"),
            Self::NotMonotone { previous_us } => {
                write!(f, "not later than the knot before, {previous_us} µs")
            }
            Self::Stale => f.write_str("the path does not end where the piece begins"),
            Self::Late { path_us } => write!(f, "path time is {path_us} µs already"),
            Self::NotFinite { axis } => write!(f, "axis {axis}: not finite"),
            Self::Limit {
                axis,
                quantity,
                value,
                limit,
            } => write!(
                f,
                "axis {axis}: {quantity} would reach {value}, limit {limit}"
            ),
            Self::AccelerationStep { axis, value, limit } => write!(
                f,
                "axis {axis}: acceleration would step by {value}, limit {limit}"
            ),
            Self::Long => f.write_str("the segment would last longer than 71 minutes"),
            Self::Far { axis, value, limit } => write!(
                f,
                "axis {axis}: the segment would go as far as {value}, fixed point {limit}"
            ),
            Self::NoRoomToStop { axis, value, limit } => write!(
                f,
                "axis {axis}: a stop would reach position {value}, limit {limit}"
            ),
        }
    }
}

impl core::error::Error for StartError {}
impl core::error::Error for PushError {}

impl fmt::Display for Moving {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the set-point is moving")
    }
}

impl core::error::Error for Moving {}
