//! A change of velocity in a given time: the extremal pulses of acceleration.
//!
//! Units as in [`super::farthest`]. Among all accelerations of length T between given ends, the one that
//! gains most velocity rises with full jerk and falls with full jerk; the one that gains least falls and
//! rises. Every gain between is a mean of both.

use super::brake::Brake;
use super::earliest::{Joinable, Verdict};
use super::farthest::Task;
use crate::scalar::{larger, within};

/// An acceleration that rises, is held, and falls.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pulse {
    pub(super) a0: f64,
    pub(super) peak: f64,
    pub(super) hold: f64,
    pub(super) a1: f64,
}

impl Pulse {
    fn in_time(a0: f64, a1: f64, limit: f64, time: f64) -> Self {
        let peak = 0.5 * (time + (a0 + a1));
        if peak > limit {
            Self {
                a0,
                peak: limit,
                hold: 2.0 * (peak - limit),
                a1,
            }
        } else {
            Self {
                a0,
                peak: larger(larger(peak, a0), a1),
                hold: 0.0,
                a1,
            }
        }
    }

    fn gain(&self) -> f64 {
        self.peak * (self.peak + self.hold) - 0.5 * (self.a0 * self.a0 + self.a1 * self.a1)
    }
}

/// One axis on its way to a velocity.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gain {
    pub(super) brake: Brake,
    task: Task,
    joinable: Joinable,
}

impl Gain {
    pub(super) fn new(task: &Task) -> Self {
        // Only the acceleration has to be brought inside first: the velocity is going to its end anyway.
        let (jerk, time) = if task.a0 > task.a_up {
            (-1.0, task.a0 - task.a_up)
        } else if -task.a0 > task.a_down {
            (1.0, -task.a0 - task.a_down)
        } else {
            (0.0, 0.0)
        };
        let brake = Brake {
            jerk,
            times: [time, 0.0],
        };
        let task = brake.applied(task);
        Self {
            brake,
            task,
            joinable: Joinable::of(&task),
        }
    }

    pub(super) fn earliest(&self) -> f64 {
        self.joinable.from
    }

    /// Whether it must arrive in that very moment, because it arrives with an acceleration.
    pub(super) fn is_timed(&self) -> bool {
        libm::fabs(self.task.a1) > 0.0
    }

    /// The way that ends its acceleration first, and can then wait.
    pub(super) fn paused(&self) -> Paused {
        let Task { v0, a0, .. } = self.task;
        let lasts = libm::fabs(a0);
        let steady = Task {
            v0: v0 + 0.5 * a0 * lasts,
            a0: 0.0,
            ..self.task
        };
        let after = Self {
            brake: self.brake,
            task: steady,
            joinable: Joinable::of(&steady),
        };
        Paused {
            jerk: if a0 > 0.0 { -1.0 } else { 1.0 },
            lasts,
            change: after.change(after.earliest(), 0.0),
            earliest: lasts + after.earliest(),
        }
    }

    /// The change of velocity in `time`, or the next possible time.
    ///
    /// Without an acceleration at the end it is made as soon as possible and the velocity kept: so the
    /// velocity stays between its ends, whatever the time.
    pub(super) fn at(&self, time: f64) -> Result<Change, Verdict> {
        let kept = if self.is_timed() {
            0.0
        } else {
            larger(time - self.joinable.from, 0.0)
        };
        let time = time - kept;
        if let Some((from, to)) = self.joinable.gap
            && from < time
            && time < to
        {
            return Err(Verdict::NotBefore(to));
        }
        Ok(self.change(time, kept))
    }

    fn change(&self, time: f64, kept: f64) -> Change {
        let Task {
            v0,
            a0,
            v1,
            a1,
            a_up,
            a_down,
            ..
        } = self.task;
        let rising = Pulse::in_time(a0, a1, a_up, time);
        let falling = Pulse::in_time(-a0, -a1, a_down, time);
        let (most, least) = (rising.gain(), -falling.gain());
        let share = if most > least {
            (v1 - v0 - least) / (most - least)
        } else {
            1.0
        };
        Change {
            rising,
            falling,
            share: within(share, 0.0, 1.0),
            kept,
        }
    }
}

/// The acceleration of the start ended, the velocity then kept as long as need be, and the fastest change from
/// there: it keeps every limit of velocity that can be kept.
#[derive(Clone, Copy, Debug)]
pub(super) struct Paused {
    /// How the acceleration is ended, and how long that lasts.
    pub(super) jerk: f64,
    pub(super) lasts: f64,
    pub(super) change: Change,
    /// How long it takes without a pause.
    pub(super) earliest: f64,
}

/// A mean of two pulses, and then a velocity kept.
#[derive(Clone, Copy, Debug)]
pub(super) struct Change {
    pub(super) rising: Pulse,
    pub(super) falling: Pulse,
    /// Of the rising one.
    pub(super) share: f64,
    /// How long the velocity is kept.
    pub(super) kept: f64,
}
