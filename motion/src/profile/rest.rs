//! From rest to rest: in closed form where accelerating and braking are limited alike.

use super::earliest::{Arrival, Between, Verdict};
use super::farthest::{Farthest, Task};

/// The fastest motion of an axis from rest to rest.
#[derive(Clone, Copy, Debug)]
pub(super) struct RestToRest {
    /// The task, seen so that it goes up, and its motion.
    pub(super) task: Task,
    pub(super) motion: Farthest,
    /// 1, or -1 where the task was mirrored.
    pub(super) sign: f64,
    pub(super) time: f64,
}

impl RestToRest {
    /// Nothing if the axis moves at either end, or the time cannot be represented.
    pub(super) fn of(task: &Task) -> Option<Self> {
        if [task.v0, task.a0, task.v1, task.a1]
            .iter()
            .any(|x| *x != 0.0)
        {
            return None;
        }
        let (task, sign) = if task.distance < 0.0 {
            (task.mirrored(), -1.0)
        } else {
            (*task, 1.0)
        };
        let alike = task.a_up <= task.a_down && task.a_down <= task.a_up;
        let (motion, time) = if alike {
            symmetric(task.distance, task.v_up, task.a_up)
        } else {
            let arrival = Arrival::new(task);
            let time = arrival.earliest()?;
            match arrival.at(time) {
                Verdict::Possible(Between::Farthest(far) | Between::Both(far, _)) => (far, time),
                _ => return None,
            }
        };
        Some(Self {
            task,
            motion,
            sign,
            time,
        })
    }
}

/// Motion and time over a distance, both in units of the jerk limit.
fn symmetric(distance: f64, v: f64, a: f64) -> (Farthest, f64) {
    let full = a * a;
    // jerk and hold when the velocity limit is reached
    let (mut jerk, mut hold) = if full <= v {
        (a, v / a - a)
    } else {
        (libm::sqrt(v), 0.0)
    };
    let mut cruise = 0.0;
    let ramp = v * (2.0 * jerk + hold);
    if distance >= ramp {
        cruise = (distance - ramp) / v;
    } else if full <= v && distance >= 2.0 * a * full {
        jerk = a;
        // (jerk + hold)² + jerk·(jerk + hold) = distance/a
        hold = 0.5 * libm::sqrt(full + 4.0 * (distance / a)) - 1.5 * a;
        hold = if hold > 0.0 { hold } else { 0.0 };
    } else {
        (jerk, hold) = (libm::cbrt(0.5 * distance), 0.0);
    }
    let motion = Farthest {
        peak: jerk,
        hold_peak: hold,
        valley: -jerk,
        hold_valley: hold,
        cruise,
        distance,
        slope: jerk * (jerk + hold),
    };
    (motion, 4.0 * jerk + 2.0 * hold + cruise)
}
