//! When one axis can arrive: the earliest time, and the next possible one after any time.
//!
//! In a given time the reachable distances form an interval (motions within the limits form a convex
//! set), from the nearest to the farthest motion. So an arrival at T is possible when T is a time in which
//! the ends can be joined at all, and the distance lies in that interval. As both ends of it are known
//! without search ([`super::farthest`]), planning is finding the time at which one of them passes the
//! distance.

use super::farthest::{Farthest, Task, Upward};
use super::search::Search;
use crate::scalar::larger;

/// A distance is met when it is missed by less than this times what rounding can make of it.
const ROUNDING: f64 = 4e-16;

/// The times in which velocities and accelerations of both ends can be joined, whatever the distance.
#[derive(Clone, Copy, Debug)]
pub(super) struct Joinable {
    pub(super) from: f64,
    /// No motion is possible in a time strictly between these.
    pub(super) gap: Option<(f64, f64)>,
}

impl Joinable {
    pub(super) fn of(task: &Task) -> Self {
        let Task {
            v0,
            a0,
            v1,
            a1,
            a_up,
            a_down,
            ..
        } = *task;
        let gain = v1 - v0;
        // what is gained when the acceleration goes from one value to the other directly
        let direct = 0.5 * (a1 - a0) * (a1 + a0) * if a1 < a0 { -1.0 } else { 1.0 };
        if gain > direct || (gain >= direct && a0 + a1 > 0.0) {
            Self::rising(gain, a0, a1, a_up, a_down)
        } else {
            Self::rising(-gain, -a0, -a1, a_down, a_up)
        }
    }

    /// The acceleration rises first and falls then.
    fn rising(gain: f64, a0: f64, a1: f64, a_up: f64, a_down: f64) -> Self {
        let mean = 0.5 * (a0 * a0 + a1 * a1);
        let square = larger(gain + mean, 0.0);
        let from = if square > a_up * a_up {
            a_up - a0 + (a_up - a1) + (square - a_up * a_up) / a_up
        } else {
            let peak = larger(larger(libm::sqrt(square), a0), a1);
            (peak - a0) + (peak - a1)
        };
        // The other way round, falling first: possible with the valley between zero and both ends, or below zero,
        // but with no valley between.
        let square = mean - gain;
        let gap = (a0 > 0.0 && a1 > 0.0 && square >= 0.0).then(|| {
            let valley = libm::sqrt(square);
            let deep = if square > a_down * a_down {
                a0 + a1 + 2.0 * a_down + (square - a_down * a_down) / a_down
            } else {
                a0 + a1 + 2.0 * valley
            };
            (larger(a0 + a1 - 2.0 * valley, from), deep)
        });
        Self { from, gap }
    }

    fn end_of_branch(&self, time: f64) -> f64 {
        match self.gap {
            Some((from, to)) if time < to => from,
            _ => f64::INFINITY,
        }
    }
}

/// One axis and its extremal motions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arrival {
    pub(super) up: Upward,
    pub(super) down: Upward,
    joinable: Joinable,
}

/// The motions of some length that a distance lies between.
#[derive(Clone, Copy, Debug)]
pub(super) enum Between {
    /// It is that of the farthest motion.
    Farthest(Farthest),
    /// It is that of the nearest motion, the farthest of the mirrored axis.
    Nearest(Farthest),
    /// Farthest and nearest motion.
    Both(Farthest, Farthest),
}

/// What is known about an arrival at some time.
#[derive(Clone, Copy, Debug)]
pub(super) enum Verdict {
    /// Possible, by a mean of these motions.
    Possible(Between),
    /// Not before this later time.
    NotBefore(f64),
    /// Not at any time that floating point can hold.
    Never,
}

impl Verdict {
    /// The same about a motion that begins with `seconds` of something else.
    pub(super) fn after(self, seconds: f64) -> Self {
        match self {
            Self::NotBefore(time) => Self::NotBefore(time + seconds),
            other => other,
        }
    }
}

impl Arrival {
    pub(super) fn new(task: Task) -> Self {
        Self {
            up: Upward::new(task),
            down: Upward::new(task.mirrored()),
            joinable: Joinable::of(&task),
        }
    }

    /// The earliest arrival, s.
    pub(super) fn earliest(&self) -> Option<f64> {
        let mut time = self.joinable.from;
        for _ in 0..2 {
            // in this moment there is but one motion: the farthest is the nearest
            let only = self.up.in_time(time);
            let missing = self.up.task.distance - only.distance;
            if libm::fabs(missing) <= allowance(&self.up.task, time, only.slope) {
                return Some(time);
            }
            let end = self.joinable.end_of_branch(time);
            let found = if missing > 0.0 {
                Search {
                    side: &self.up,
                    end,
                }
                .beyond(time, &only)
            } else {
                Search {
                    side: &self.down,
                    end,
                }
                .beyond(time, &self.down.in_time(time))
            };
            if found.is_some() {
                return found;
            }
            time = self.joinable.gap?.1;
        }
        None
    }

    /// Whether the axis can arrive at `time`, which is not before the [earliest](Self::earliest).
    pub(super) fn at(&self, time: f64) -> Verdict {
        if let Some((from, to)) = self.joinable.gap
            && from < time
            && time < to
        {
            return Verdict::NotBefore(to);
        }
        let far = self.up.in_time(time);
        let spare = far.distance - self.up.task.distance;
        let allowed = allowance(&self.up.task, time, far.slope);
        if spare < -allowed {
            return self.later(&self.up, time, &far);
        }
        if spare <= allowed {
            return Verdict::Possible(Between::Farthest(far));
        }
        let near = self.down.in_time(time);
        let spare = near.distance - self.down.task.distance;
        let allowed = allowance(&self.down.task, time, near.slope);
        if spare < -allowed {
            return self.later(&self.down, time, &near);
        }
        Verdict::Possible(if spare <= allowed {
            Between::Nearest(near)
        } else {
            Between::Both(far, near)
        })
    }

    fn later(&self, side: &Upward, time: f64, farthest: &Farthest) -> Verdict {
        let end = self.joinable.end_of_branch(time);
        match (
            Search { side, end }.beyond(time, farthest),
            self.joinable.gap,
        ) {
            (Some(later), _) => Verdict::NotBefore(later),
            (None, Some((_, to))) if time < to => Verdict::NotBefore(to),
            _ => Verdict::Never,
        }
    }
}

/// What rounding can make of a distance covered in `time` at speeds up to about `slope`.
pub(super) fn allowance(task: &Task, time: f64, slope: f64) -> f64 {
    ROUNDING * (task.distance.abs() + time * (task.v0.abs() + task.v1.abs() + slope.abs()))
}
