//! An exact judge of finished profiles: reads phases and bounds, nothing else.

use super::{AxisBounds, Boundary, Phase};
use crate::scalar::{larger, smaller};
use core::fmt;

/// Relative rounding allowed; what a planner gains by cheating below it is not measurable.
const TOLERANCE: f64 = 1e-12;
/// Some units in the last place, of what the limits would allow in the time of the motion: an instant is
/// known to a unit in the last place of that time.
const UNIT: f64 = 2e-15;

/// How a profile breaks its promise; phases are numbered from 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Violation {
    /// A number of the phase is infinite or not a number, or its length is negative.
    Malformed {
        /// Which phase.
        phase: usize,
    },
    /// |jerk| above the limit.
    Jerk {
        /// Which phase.
        phase: usize,
        /// The value reached.
        value: f64,
        /// The value allowed.
        limit: f64,
    },
    /// Acceleration outside the limits.
    Acceleration {
        /// Which phase.
        phase: usize,
        /// The value reached.
        value: f64,
        /// The value allowed.
        limit: f64,
    },
    /// Velocity outside the limits, at an end of the phase or where its acceleration is zero.
    Velocity {
        /// Which phase.
        phase: usize,
        /// The value reached.
        value: f64,
        /// The value allowed.
        limit: f64,
    },
    /// Position outside the range, at an end of the phase or where its velocity is zero.
    Position {
        /// Which phase.
        phase: usize,
        /// The value reached.
        value: f64,
        /// The value allowed.
        limit: f64,
    },
    /// Position, velocity or acceleration jumps where the phase begins, or is not that of the start.
    Jump {
        /// Which phase.
        phase: usize,
    },
    /// The motion does not end in the asked state.
    End,
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (phase, what, value, limit) = match *self {
            Self::Malformed { phase } => return write!(f, "phase {phase} is not a motion"),
            Self::Jump { phase } => return write!(f, "a jump where phase {phase} begins"),
            Self::End => return f.write_str("does not end in the asked state"),
            Self::Jerk {
                phase,
                value,
                limit,
            } => (phase, "jerk", value, limit),
            Self::Acceleration {
                phase,
                value,
                limit,
            } => (phase, "acceleration", value, limit),
            Self::Velocity {
                phase,
                value,
                limit,
            } => (phase, "velocity", value, limit),
            Self::Position {
                phase,
                value,
                limit,
            } => (phase, "position", value, limit),
        };
        write!(f, "phase {phase}: {what} {value} beyond {limit}")
    }
}

impl core::error::Error for Violation {}

/// Proves that a chain of phases leads from one state to another within the bounds.
///
/// In closed form, without sampling: |j| in every phase; a at its ends (it is linear between); v at its
/// ends and where a is zero; p at its ends and where v is zero; continuity and the end state. Equality
/// is up to 1e-12 of the largest value reached, and to some units in the last place of what the bounds
/// allow in the time.
///
/// A start outside the bounds of acceleration or velocity is followed by phases that bring it back: in each of
/// them, acceleration and velocity may reach what cannot be avoided from where it begins, and no more than before.
///
/// # Errors
/// The first [`Violation`] in the order of the phases.
pub fn check(
    phases: &[Phase],
    start: &Boundary,
    end: &Boundary,
    bounds: &AxisBounds,
) -> Result<(), Violation> {
    let scale = Scale::of(phases, start, end, bounds);
    let mut outside = !admits(bounds, start);
    let mut allowed = widened(bounds, start, &UNBOUNDED);
    let mut at = *start;
    for (number, phase) in phases.iter().enumerate() {
        outside &= !admits(bounds, &at);
        // what has come back inside stays there
        allowed = if outside {
            widened(bounds, &at, &allowed)
        } else {
            *bounds
        };
        within_bounds(number, phase, &allowed, &scale)?;
        if scale.differ(
            &at,
            &Boundary {
                p: phase.p0,
                v: phase.v0,
                a: phase.a0,
            },
        ) {
            return Err(Violation::Jump { phase: number });
        }
        let state = phase.at(phase.t);
        at = Boundary {
            p: state.p,
            v: state.v,
            a: state.a,
        };
    }
    if scale.differ(&at, end) {
        return Err(Violation::End);
    }
    Ok(())
}

/// What counts as equal, for position, velocity and acceleration.
struct Scale {
    p: f64,
    v: f64,
    a: f64,
    /// What the rounding of an instant adds to `v` where velocities meet: the acceleration times that.
    instant: f64,
}

impl Scale {
    fn of(phases: &[Phase], start: &Boundary, end: &Boundary, bounds: &AxisBounds) -> Self {
        let mut reached = Boundary {
            p: 0.0,
            v: 0.0,
            a: 0.0,
        };
        let mut raise = |p: f64, v: f64, a: f64| {
            reached.p = larger(reached.p, p.abs());
            reached.v = larger(reached.v, v.abs());
            reached.a = larger(reached.a, a.abs());
        };
        raise(start.p, start.v, start.a);
        raise(end.p, end.v, end.a);
        let mut time = 0.0;
        for phase in phases {
            raise(phase.p0, phase.v0, phase.a0);
            time += phase.t;
        }
        let a = smaller(larger(bounds.a_max, -bounds.a_min), bounds.j_max * time);
        let v = smaller(larger(bounds.v_max, -bounds.v_min), a * time);
        Self {
            p: TOLERANCE * reached.p + UNIT * v * time,
            v: TOLERANCE * reached.v + UNIT * v,
            a: TOLERANCE * reached.a + UNIT * bounds.j_max * time,
            instant: UNIT * a * time,
        }
    }

    fn differ(&self, one: &Boundary, other: &Boundary) -> bool {
        exceeds((one.p - other.p).abs(), self.p)
            || exceeds((one.v - other.v).abs(), self.v + self.instant)
            || exceeds((one.a - other.a).abs(), self.a)
    }
}

/// The velocity that a state comes to when its acceleration is brought to zero.
fn unavoidable(state: &Boundary, bounds: &AxisBounds) -> f64 {
    state.v + 0.5 * state.a * state.a.abs() / bounds.j_max
}

/// Whether a state is within bounds of acceleration and velocity and can stay there.
fn admits(bounds: &AxisBounds, state: &Boundary) -> bool {
    let (a, v, next) = (state.a, state.v, unavoidable(state, bounds));
    let below = |value: f64, limit: f64| value <= limit + TOLERANCE * limit.abs();
    let above = |value: f64, limit: f64| value >= limit - TOLERANCE * limit.abs();
    below(a, bounds.a_max)
        && above(a, bounds.a_min)
        && below(larger(v, next), bounds.v_max)
        && above(smaller(v, next), bounds.v_min)
}

/// No bounds at all.
const UNBOUNDED: AxisBounds = AxisBounds {
    v_min: f64::NEG_INFINITY,
    v_max: f64::INFINITY,
    a_min: f64::NEG_INFINITY,
    a_max: f64::INFINITY,
    j_max: f64::INFINITY,
    p_min: f64::NEG_INFINITY,
    p_max: f64::INFINITY,
};

/// The bounds, wider by what cannot be avoided from a state, but no wider than they were before.
fn widened(bounds: &AxisBounds, state: &Boundary, before: &AxisBounds) -> AxisBounds {
    let next = unavoidable(state, bounds);
    AxisBounds {
        v_min: larger(smaller(bounds.v_min, smaller(state.v, next)), before.v_min),
        v_max: smaller(larger(bounds.v_max, larger(state.v, next)), before.v_max),
        a_min: larger(smaller(bounds.a_min, state.a), before.a_min),
        a_max: smaller(larger(bounds.a_max, state.a), before.a_max),
        ..*bounds
    }
}

/// Whether a value is above a bound, or one of them is not a number.
fn exceeds(value: f64, bound: f64) -> bool {
    value > bound || value.is_nan() || bound.is_nan()
}

fn within_bounds(
    number: usize,
    phase: &Phase,
    bounds: &AxisBounds,
    scale: &Scale,
) -> Result<(), Violation> {
    let finite = [phase.t, phase.j, phase.a0, phase.v0, phase.p0]
        .iter()
        .all(|x| x.is_finite());
    if !finite || phase.t < 0.0 {
        return Err(Violation::Malformed { phase: number });
    }
    let beyond = |value: f64, low: f64, high: f64, spare: f64| {
        if exceeds(value, high + TOLERANCE * high.abs() + spare) {
            Some(high)
        } else if exceeds(-value, TOLERANCE * low.abs() + spare - low) {
            Some(low)
        } else {
            None
        }
    };
    if let Some(limit) = beyond(phase.j, -bounds.j_max, bounds.j_max, 0.0) {
        return Err(Violation::Jerk {
            phase: number,
            value: phase.j,
            limit,
        });
    }
    let end = phase.at(phase.t);
    for value in [phase.a0, end.a] {
        if let Some(limit) = beyond(value, bounds.a_min, bounds.a_max, scale.a) {
            return Err(Violation::Acceleration {
                phase: number,
                value,
                limit,
            });
        }
    }
    let inside = |tau: &f64| *tau > 0.0 && *tau < phase.t;
    let still = Some(-phase.a0 / phase.j).filter(inside);
    let extreme = still.map_or(end.v, |tau| phase.at(tau).v);
    for value in [phase.v0, extreme, end.v] {
        if let Some(limit) = beyond(value, bounds.v_min, bounds.v_max, scale.v) {
            return Err(Violation::Velocity {
                phase: number,
                value,
                limit,
            });
        }
    }
    let turns =
        turning_points(phase).map(|tau| tau.filter(inside).map_or(end.p, |tau| phase.at(tau).p));
    let [first, second] = turns;
    for value in [phase.p0, first, second, end.p] {
        if let Some(limit) = beyond(value, bounds.p_min, bounds.p_max, scale.p) {
            return Err(Violation::Position {
                phase: number,
                value,
                limit,
            });
        }
    }
    Ok(())
}

/// Where the velocity of a phase is zero: v0 + a0·τ + j·τ²/2 = 0.
pub(super) fn turning_points(phase: &Phase) -> [Option<f64>; 2] {
    let square = phase.a0 * phase.a0 - 2.0 * phase.j * phase.v0;
    if square < 0.0 {
        return [None, None];
    }
    let root = libm::sqrt(square);
    // the sum without cancellation; one root from it, the other from the product of both
    let sum = if phase.a0 < 0.0 {
        root - phase.a0
    } else {
        -root - phase.a0
    };
    [Some(sum / phase.j), Some(2.0 * phase.v0 / sum)].map(|tau| tau.filter(|tau| tau.is_finite()))
}
