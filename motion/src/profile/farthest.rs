//! How far one axis can come in a given time: the extremal motions every plan is made of.
//!
//! Units here: everything is divided by the jerk limit, which therefore is 1. A distance is in s³, a
//! velocity in s², an acceleration in s.
//!
//! Among all motions of length T that join the given velocities and accelerations within the limits,
//! the one that comes farthest raises its acceleration to a peak, lowers it to a valley, raises it
//! to its end (Pontryagin: the costate of the acceleration is a convex parabola), staying at an
//! acceleration limit where it meets one, and at the velocity limit, if that is reached, between peak
//! and valley. With α the peak and ω the valley,
//!
//! ```text
//! c = α − ω = (T + a0 − a1)/2,   K = (v1 − v0) + (a0² − a1²)/2 = (α + ω)(α − ω)
//! ```
//!
//! so α and ω follow without search; a limit of acceleration replaces one of them and adds a square
//! root. The nearest motion is the farthest of the mirrored axis.

use crate::scalar::{SIXTH, larger, smaller};

/// One axis to be moved: ends and limits, in units of the jerk limit. Limits are magnitudes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Task {
    pub(super) v0: f64,
    pub(super) a0: f64,
    pub(super) v1: f64,
    pub(super) a1: f64,
    pub(super) distance: f64,
    pub(super) v_up: f64,
    pub(super) v_down: f64,
    pub(super) a_up: f64,
    pub(super) a_down: f64,
}

impl Task {
    /// The same task seen from the other side: up becomes down.
    pub(super) fn mirrored(&self) -> Self {
        Self {
            v0: -self.v0,
            a0: -self.a0,
            v1: -self.v1,
            a1: -self.a1,
            distance: -self.distance,
            v_up: self.v_down,
            v_down: self.v_up,
            a_up: self.a_down,
            a_down: self.a_up,
        }
    }
}

/// The farthest motion of some length.
#[derive(Clone, Copy, Debug)]
pub(super) struct Farthest {
    /// Highest and lowest acceleration, and how long each is held.
    pub(super) peak: f64,
    pub(super) hold_peak: f64,
    pub(super) valley: f64,
    pub(super) hold_valley: f64,
    /// Time at the velocity limit, between peak and valley.
    pub(super) cruise: f64,
    /// How far it comes.
    pub(super) distance: f64,
    /// How much farther it would come per second more: d(distance)/dT.
    ///
    /// The derivative of the optimal value by the time is the costate of the position's inverse, which
    /// the Hamiltonian at the middle of the falling phase gives: v + c²/8 there.
    pub(super) slope: f64,
}

/// The motion that just reaches the velocity limit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Full {
    motion: Farthest,
    pub(super) time: f64,
}

impl Full {
    pub(super) fn distance(&self) -> f64 {
        self.motion.distance
    }
}

/// All farthest motions of one task.
#[derive(Clone, Copy, Debug)]
pub(super) struct Upward {
    pub(super) task: Task,
    /// K of the head of this file.
    pub(super) k: f64,
}

impl Upward {
    pub(super) fn new(task: Task) -> Self {
        Self {
            task,
            k: (task.v1 - task.v0) + 0.5 * (task.a0 - task.a1) * (task.a0 + task.a1),
        }
    }

    /// The farthest motion of `time` s; `time` must be one in which the ends can be joined.
    pub(super) fn in_time(&self, time: f64) -> Farthest {
        let found = self.without_cruise(time);
        if found.valley < 0.0 && found.peak > 0.0 {
            let top = self.task.v0 + found.peak * (found.peak + found.hold_peak)
                - 0.5 * self.task.a0 * self.task.a0;
            if top > self.task.v_up {
                return self.cruising(&self.full(), time);
            }
        }
        found
    }

    /// The same, knowing the motion that just reaches the velocity limit.
    pub(super) fn in_time_below(&self, full: &Full, time: f64) -> Farthest {
        if time >= full.time {
            self.cruising(full, time)
        } else {
            self.without_cruise(time)
        }
    }

    /// The motion that just reaches the velocity limit: as fast as possible up to it, and down.
    pub(super) fn full(&self) -> Full {
        let Task {
            v0,
            a0,
            v1,
            a1,
            v_up,
            a_up,
            a_down,
            ..
        } = self.task;
        let (rise, fall) = ((v_up - v0) + 0.5 * a0 * a0, (v_up - v1) + 0.5 * a1 * a1);
        let (peak, hold_peak) = pulse(rise, larger(a0, 0.0), a_up);
        let (valley, hold_valley) = pulse(fall, larger(-a1, 0.0), a_down);
        let time = (2.0 * peak - a0 + hold_peak) + (2.0 * valley + a1 + hold_valley);
        Full {
            motion: self.travelled(peak, hold_peak, -valley, hold_valley),
            time,
        }
    }

    fn cruising(&self, full: &Full, time: f64) -> Farthest {
        let cruise = larger(time - full.time, 0.0);
        Farthest {
            cruise,
            distance: full.motion.distance + self.task.v_up * cruise,
            slope: self.task.v_up,
            ..full.motion
        }
    }

    fn without_cruise(&self, time: f64) -> Farthest {
        let Task {
            a0,
            a1,
            a_up,
            a_down,
            ..
        } = self.task;
        let k = self.k;
        let c = 0.5 * (time + (a0 - a1));
        if c <= 0.0 {
            return self.travelled(larger(a0, a1), 0.0, a1, 0.0);
        }
        let sum = k / c;
        let (mut peak, mut valley) = (0.5 * (sum + c), 0.5 * (sum - c));
        // The peak is not below a0 and the valley not above a1: so when c is but rounding, and K/c anything.
        if peak < a0 {
            (peak, valley) = (a0, a0 - c);
        } else if valley > a1 {
            (peak, valley) = (a1 + c, a1);
        }
        let (mut hold_peak, mut hold_valley) = (0.0, 0.0);
        if peak > a_up || valley < -a_down {
            let over_valley = a_up - root(2.0 * a_up * c - k);
            let under_peak = root(k + 2.0 * a_down * c) - a_down;
            if peak > a_up && over_valley >= -a_down {
                (peak, valley) = (a_up, over_valley);
                hold_peak = 2.0 * (c - (a_up - valley));
            } else if valley < -a_down && under_peak <= a_up {
                (peak, valley) = (under_peak, -a_down);
                hold_valley = 2.0 * (c - (peak + a_down));
            } else {
                let span = a_up + a_down;
                let holds = 2.0 * (c - span);
                hold_peak = (k - (a_up - a_down) * span + a_down * holds) / span;
                hold_valley = holds - hold_peak;
                (peak, valley) = (a_up, -a_down);
            }
        }
        self.travelled(
            larger(peak, a0),
            larger(hold_peak, 0.0),
            smaller(valley, a1),
            larger(hold_valley, 0.0),
        )
    }

    /// Distance and slope of the motion with these accelerations.
    fn travelled(&self, peak: f64, hold_peak: f64, valley: f64, hold_valley: f64) -> Farthest {
        let Task { v0, a0, a1, .. } = self.task;
        let up = peak - a0;
        let v_a = v0 + 0.5 * up * (peak + a0);
        let v_b = v_a + peak * hold_peak;
        let down = peak - valley;
        let v_c = v_b + 0.5 * down * (peak + valley);
        let v_d = v_c + valley * hold_valley;
        let last = a1 - valley;
        let distance = up * (v0 + up * (0.5 * a0 + up * SIXTH))
            + hold_peak * (v_a + 0.5 * peak * hold_peak)
            + down * (v_b + down * (0.5 * peak - down * SIXTH))
            + hold_valley * (v_c + 0.5 * valley * hold_valley)
            + last * (v_d + last * (0.5 * valley + last * SIXTH));
        Farthest {
            peak,
            hold_peak,
            valley,
            hold_valley,
            cruise: 0.0,
            distance,
            slope: v_b + 0.5 * peak * down,
        }
    }
}

/// Peak and hold of an acceleration pulse that ends at 0 and gains `gain` from where it was 0.
pub(super) fn pulse(gain: f64, least: f64, limit: f64) -> (f64, f64) {
    let square = larger(gain, 0.0);
    if square > limit * limit {
        (limit, (square - limit * limit) / limit)
    } else {
        (larger(root(square), least), 0.0)
    }
}

fn root(x: f64) -> f64 {
    if x > 0.0 { libm::sqrt(x) } else { 0.0 }
}
