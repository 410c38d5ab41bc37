//! The judge: reads the question and the phases of the answer, knows nothing of any planner.
//!
//! Everything is in closed form, nothing is sampled: the acceleration is linear in a phase, so its
//! extremes are at the ends; the velocity has its own at the ends and where the acceleration is zero.

#[cfg(test)]
mod test;

use crate::case::Axis;
use crate::plan::{Phase, Plan};

/// More than this is a violation: relative to the limit, or to the scale of what jumps.
pub const TOLERANCE: f64 = 1e-9;
/// An end further away than this has been missed (Ruckig itself accepts 1e-8).
pub const MISSED: f64 = 1e-6;

/// How far an answer is from what was asked; zero is perfect. Of several axes, the worst of each.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Amounts {
    /// 1 if a number is not finite, a length is negative, or the axes are not as many as asked.
    pub malformed: f64,
    /// |jerk| above its limit, relative to it.
    pub jerk: f64,
    /// Acceleration outside its limits, relative to the one it left.
    pub acceleration: f64,
    /// Velocity outside its limits, relative to the one it left.
    pub velocity: f64,
    /// Position, velocity or acceleration jumping at the start or between phases, relative to the
    /// scale of each.
    pub jump: f64,
    /// The phases of an axis not being as long as the motion, s, relative to it if above 1 s.
    pub duration: f64,
    /// Position at the end, in the axis' unit.
    pub end_p: f64,
    /// Velocity at the end, relative to its limit if that is above 1.
    pub end_v: f64,
    /// Acceleration at the end, relative to its limit if that is above 1.
    pub end_a: f64,
}

impl Amounts {
    /// Names, in the order of [`list`](Self::list).
    pub const NAMES: [&str; 9] = [
        "malformed",
        "jerk",
        "acceleration",
        "velocity",
        "jump",
        "duration",
        "end position",
        "end velocity",
        "end acceleration",
    ];

    /// All of them.
    #[must_use]
    pub fn list(&self) -> [f64; 9] {
        [
            self.malformed,
            self.jerk,
            self.acceleration,
            self.velocity,
            self.jump,
            self.duration,
            self.end_p,
            self.end_v,
            self.end_a,
        ]
    }

    /// Which of them are violations.
    #[must_use]
    pub fn violations(&self) -> [bool; 9] {
        let mut allowed = [TOLERANCE; 9];
        allowed[6..].fill(MISSED);
        let mut found = [false; 9];
        for ((found, amount), allowed) in found.iter_mut().zip(self.list()).zip(allowed) {
            *found = amount > allowed;
        }
        found
    }

    /// Whether none of them is a violation.
    #[must_use]
    pub fn pass(&self) -> bool {
        !self.violations().contains(&true)
    }

    /// The largest error at the end.
    #[must_use]
    pub fn end(&self) -> f64 {
        larger(self.end_p, larger(self.end_v, self.end_a))
    }
}

/// Judges a plan.
#[must_use]
pub fn judge(case: &[Axis], plan: &Plan) -> Amounts {
    let mut amounts = Amounts::default();
    if plan.axes.len() != case.len() {
        amounts.malformed = 1.0;
    }
    for (axis, phases) in case.iter().zip(&plan.axes) {
        judge_axis(axis, phases, plan.duration, &mut amounts);
    }
    amounts
}

fn judge_axis(axis: &Axis, phases: &[Phase], duration: f64, amounts: &mut Amounts) {
    let sound =
        |x: &Phase| [x.t, x.j, x.a0, x.v0, x.p0].iter().all(|x| x.is_finite()) && x.t >= 0.0;
    if !phases.iter().all(sound) || !duration.is_finite() {
        amounts.malformed = 1.0;
        return;
    }
    let scale = State {
        p: largest([1.0, axis.p0.abs(), axis.p1.abs()]),
        v: largest([axis.v_max, -axis.v_min, axis.v0.abs()]),
        a: largest([axis.a_max, -axis.a_min, axis.a0.abs()]),
    };
    let mut state = State {
        p: axis.p0,
        v: axis.v0,
        a: axis.a0,
    };
    let mut corridor = Corridor::new(axis);
    corridor.enter(state, amounts);
    let mut length = 0.0;
    for phase in phases {
        let begin = State {
            p: phase.p0,
            v: phase.v0,
            a: phase.a0,
        };
        let jump = largest([
            (begin.p - state.p).abs() / scale.p,
            (begin.v - state.v).abs() / scale.v,
            (begin.a - state.a).abs() / scale.a,
        ]);
        amounts.jump = larger(amounts.jump, jump);
        if phase.t > 0.0 {
            amounts.jerk = larger(amounts.jerk, phase.j.abs() / axis.j_max - 1.0);
        }
        corridor.enter(begin, amounts);
        let level = -phase.a0 / phase.j;
        if level > 0.0 && level < phase.t {
            let turn = after(phase, level);
            corridor.enter(State { a: 0.0, ..turn }, amounts);
        }
        state = after(phase, phase.t);
        corridor.enter(state, amounts);
        length += phase.t;
    }
    amounts.duration = larger(
        amounts.duration,
        (length - duration).abs() / larger(1.0, duration),
    );
    let missed = State {
        p: (state.p - axis.p1).abs(),
        v: (state.v - axis.v1).abs() / larger(1.0, scale.v),
        a: (state.a - axis.a1).abs() / larger(1.0, scale.a),
    };
    amounts.end_p = larger(amounts.end_p, missed.p);
    amounts.end_v = larger(amounts.end_v, missed.v);
    amounts.end_a = larger(amounts.end_a, missed.a);
}

#[derive(Clone, Copy)]
struct State {
    p: f64,
    v: f64,
    a: f64,
}

fn after(phase: &Phase, tau: f64) -> State {
    State {
        p: phase.p0 + tau * (phase.v0 + tau * (0.5 * phase.a0 + tau * phase.j / 6.0)),
        v: phase.v0 + tau * (phase.a0 + tau * 0.5 * phase.j),
        a: phase.a0 + tau * phase.j,
    }
}

/// Where velocity and acceleration may be: between the limits, or, if the start does not allow that,
/// not further outside than before, and outside only until they are inside for the first time.
struct Corridor {
    above: Side,
    below: Side,
}

impl Corridor {
    fn new(axis: &Axis) -> Self {
        let side = |v_limit, a_limit| Side {
            v_limit,
            a_limit,
            jerk: axis.j_max,
            v_ceiling: f64::INFINITY,
            a_ceiling: f64::INFINITY,
        };
        Self {
            above: side(axis.v_max, axis.a_max),
            below: side(-axis.v_min, -axis.a_min),
        }
    }

    fn enter(&mut self, state: State, amounts: &mut Amounts) {
        self.above.enter(state.v, state.a, amounts);
        self.below.enter(-state.v, -state.a, amounts);
    }
}

/// The upper limits, or, with all signs turned, the lower ones.
///
/// A velocity v with an acceleration a > 0 will reach w = v + a²/(2·j), whatever is done: while that is
/// above the limit, w is what must not grow (it does not as long as the jerk is −j), and from the
/// moment when it is not above any more, the velocity must not be above the limit.
struct Side {
    v_limit: f64,
    a_limit: f64,
    jerk: f64,
    /// The least value so far of what must not grow; infinite at the start.
    v_ceiling: f64,
    a_ceiling: f64,
}

impl Side {
    fn enter(&mut self, v: f64, a: f64, amounts: &mut Amounts) {
        let outside = self.v_ceiling > self.v_limit * (1.0 + TOLERANCE);
        let (value, ceiling) = if outside {
            let coming = if a > 0.0 { a } else { 0.0 };
            (v + coming * coming / (2.0 * self.jerk), self.v_ceiling)
        } else {
            (v, self.v_limit)
        };
        amounts.velocity = larger(amounts.velocity, (value - ceiling) / self.v_limit);
        self.v_ceiling = smaller(ceiling, larger(value, self.v_limit));

        amounts.acceleration = larger(amounts.acceleration, (a - self.a_ceiling) / self.a_limit);
        self.a_ceiling = smaller(self.a_ceiling, larger(a, self.a_limit));
    }
}

/// The larger of two; what is not a number is larger than anything.
fn larger(x: f64, y: f64) -> f64 {
    if x > y || x.is_nan() { x } else { y }
}

fn smaller(x: f64, y: f64) -> f64 {
    if x < y { x } else { y }
}

fn largest<const N: usize>(all: [f64; N]) -> f64 {
    all.into_iter().fold(0.0, larger)
}
