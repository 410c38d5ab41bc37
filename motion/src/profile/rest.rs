//! From rest to rest over a distance, with different limits of accelerating and braking.

use super::farthest::{Farthest, Task, pulse};
use crate::scalar::{cube_root, larger, smaller};

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
    /// Nothing if the axis moves at either end.
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
        let (motion, time) = fastest(&task);
        Some(Self {
            task,
            motion,
            sign,
            time,
        })
    }
}

/// The motion over the distance of a task, and its time, in units of the jerk limit.
///
/// With w the highest velocity, each pulse lasts w/A + A where it meets its limit A, 2√w where not, and
/// covers w/2 times that.
fn fastest(task: &Task) -> (Farthest, f64) {
    let Task {
        distance,
        v_up,
        a_up,
        a_down,
        ..
    } = *task;
    let (low, high) = (smaller(a_up, a_down), larger(a_up, a_down));
    let lasts = |(peak, hold): (f64, f64)| 2.0 * peak + hold;
    let (mut up, mut down) = (pulse(v_up, 0.0, a_up), pulse(v_up, 0.0, a_down));
    let full = 0.5 * v_up * (lasts(up) + lasts(down));
    let mut cruise = 0.0;
    if distance >= full {
        cruise = (distance - full) / v_up;
    } else {
        // at w = low² the lower limit is met, at w = high² the other, too
        let one = 2.0 * low * low * low;
        let both = 0.5 * high * high * (high * high / low + low + 2.0 * high);
        if distance <= one {
            let peak = cube_root(0.5 * distance);
            (up, down) = ((peak, 0.0), (peak, 0.0));
        } else {
            let velocity = if distance >= both {
                // w²·(1/A + 1/B)/2 + w·(A + B)/2 = D
                let (slow, span) = (1.0 / low + 1.0 / high, low + high);
                4.0 * distance / (span + libm::sqrt(span * span + 8.0 * slow * distance))
            } else {
                let root = limited_once(distance, low, high);
                root * root
            };
            (up, down) = (pulse(velocity, 0.0, a_up), pulse(velocity, 0.0, a_down));
        }
    }
    let motion = Farthest {
        peak: up.0,
        hold_peak: up.1,
        valley: -down.0,
        hold_valley: down.1,
        cruise,
        distance,
        slope: up.0 * (up.0 + up.1),
    };
    (motion, lasts(up) + lasts(down) + cruise)
}

/// y = √w of y⁴/A + A·y² + 2·y³ = 2·D, between A and B: convex and rising, by Newton from above.
fn limited_once(distance: f64, low: f64, high: f64) -> f64 {
    let f = |y: f64| y * y * (y * y / low + low + 2.0 * y) - 2.0 * distance;
    let slope = |y: f64| 2.0 * y * (2.0 * y * y / low + low + 3.0 * y);
    // y⁴/A ≥ y³ and A·y² ≤ y³ there: no more than what y³·(1 + 2) gives, nor than the end
    let mut y = smaller(high, cube_root(2.0 / 3.0 * distance));
    for _ in 0..MOST_NEWTON {
        let step = f(y) / slope(y);
        if step <= 1e-9 * y || step.is_nan() {
            return y - step;
        }
        y -= step;
    }
    y
}

/// The error shrinks at least to 3/4 in each step of Newton's iteration on a quartic from above.
const MOST_NEWTON: u32 = 64;
