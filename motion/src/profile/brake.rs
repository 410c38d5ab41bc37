//! From outside the limits back inside, as soon as possible.

use super::farthest::Task;
use crate::scalar::{larger, smaller};

/// What the ends may exceed a limit by, relative, and still count as inside: rounding of the caller.
pub(super) const INSIDE: f64 = 1e-13;

/// A jerk for `times[0]`, then the acceleration reached held for `times[1]`; in units of the jerk limit.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Brake {
    pub(super) jerk: f64,
    pub(super) times: [f64; 2],
}

impl Brake {
    /// What brings the start of a task within acceleration and velocity limits in the shortest time.
    ///
    /// Within velocity limits means also that the velocity will not leave them while the acceleration
    /// is brought to zero.
    pub(super) fn of(task: &Task) -> Self {
        if is_inside(task) {
            return Self::default();
        }
        if let Some(times) = downwards(task) {
            return Self { jerk: -1.0, times };
        }
        downwards(&task.mirrored()).map_or_else(Self::default, |times| Self { jerk: 1.0, times })
    }

    pub(super) fn duration(&self) -> f64 {
        let [first, second] = self.times;
        first + second
    }

    /// The same task after the brake.
    pub(super) fn applied(&self, task: &Task) -> Task {
        let [t0, t1] = self.times;
        let j = self.jerk;
        let a = task.a0 + j * t0;
        let v = task.v0 + t0 * (task.a0 + 0.5 * j * t0);
        let covered =
            t0 * (task.v0 + t0 * (0.5 * task.a0 + j * t0 / 6.0)) + t1 * (v + 0.5 * a * t1);
        Task {
            v0: v + a * t1,
            a0: a,
            distance: task.distance - covered,
            ..*task
        }
    }
}

fn is_inside(task: &Task) -> bool {
    let Task {
        v0,
        a0,
        v_up,
        v_down,
        a_up,
        a_down,
        ..
    } = *task;
    let spare = |limit: f64| limit + INSIDE * limit;
    let top = v0 + 0.5 * larger(a0, 0.0) * a0;
    let bottom = v0 - 0.5 * smaller(a0, 0.0) * a0;
    a0 <= spare(a_up) && -a0 <= spare(a_down) && top <= spare(v_up) && -bottom <= spare(v_down)
}

/// How long to lower the acceleration, and how long to hold it then; `None` if this is not the way.
fn downwards(task: &Task) -> Option<[f64; 2]> {
    let Task {
        v0,
        a0,
        v_up,
        v_down,
        a_up,
        a_down,
        ..
    } = *task;
    if -a0 > a_down {
        return None;
    }
    let at_zero = v0 + 0.5 * a0 * a0;
    if a0 > a_up {
        let first = a0 - a_up;
        let v = v0 + 0.5 * first * (a0 + a_up);
        if at_zero > v_up {
            return Some(slow_down(task));
        }
        if v < -v_down {
            // still too fast the other way: keep accelerating
            let inside = (-v_down - v) / a_up;
            let latest = (v_up - v) / a_up - 0.5 * a_up;
            return Some([first, larger(smaller(inside, latest), 0.0)]);
        }
        return Some([first, 0.0]);
    }
    let too_fast = v0 > v_up && v0 - 0.5 * a0 * a0 > -v_down;
    (too_fast || a0 > 0.0 && at_zero > v_up).then(|| slow_down(task))
}

/// Lower the acceleration until the velocity is inside, or would leave the limits on the other side.
fn slow_down(task: &Task) -> [f64; 2] {
    let Task {
        v0,
        a0,
        v_up,
        v_down,
        a_down,
        ..
    } = *task;
    let to_upper = a0 + libm::sqrt(larger(a0 * a0 + 2.0 * (v0 - v_up), 0.0));
    let to_lower = a0 + libm::sqrt(larger(0.5 * a0 * a0 + (v0 + v_down), 0.0));
    let to_limit = a0 + a_down;
    let until = smaller(to_upper, to_lower);
    if until <= to_limit {
        return [larger(until, 0.0), 0.0];
    }
    let v = v0 + 0.5 * to_limit * (a0 - a_down);
    let inside = (v - v_up) / a_down;
    let latest = (v + v_down) / a_down - 0.5 * a_down;
    [to_limit, larger(smaller(inside, latest), 0.0)]
}
