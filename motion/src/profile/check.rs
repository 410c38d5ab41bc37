//! An exact judge of finished profiles: reads phases and limits, nothing else.

use super::{AxisLimits, Phase};
use crate::scalar::larger;
use core::fmt;

/// Relative rounding allowed; what a planner gains by cheating below it is not measurable.
const TOLERANCE: f64 = 1e-12;

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
    /// |acceleration| above the limit.
    Acceleration {
        /// Which phase.
        phase: usize,
        /// The value reached.
        value: f64,
        /// The value allowed.
        limit: f64,
    },
    /// |velocity| above the limit, at an end of the phase or where its acceleration is zero.
    Velocity {
        /// Which phase.
        phase: usize,
        /// The value reached.
        value: f64,
        /// The value allowed.
        limit: f64,
    },
    /// Position, velocity or acceleration jumps where the phase begins.
    Jump {
        /// Which phase.
        phase: usize,
    },
    /// The motion does not end at rest at the asked distance.
    End,
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Malformed { phase } => write!(f, "phase {phase} is not a motion"),
            Self::Jerk {
                phase,
                value,
                limit,
            } => write!(f, "phase {phase}: jerk {value} above {limit}"),
            Self::Acceleration {
                phase,
                value,
                limit,
            } => write!(f, "phase {phase}: acceleration {value} above {limit}"),
            Self::Velocity {
                phase,
                value,
                limit,
            } => write!(f, "phase {phase}: velocity {value} above {limit}"),
            Self::Jump { phase } => write!(f, "a jump where phase {phase} begins"),
            Self::End => f.write_str("does not end at rest at the asked distance"),
        }
    }
}

impl core::error::Error for Violation {}

/// Proves that a chain of phases goes from rest at 0 to rest at `distance` within the limits.
///
/// In closed form, without sampling: |j| in every phase, |a| at its ends (it is linear between), |v|
/// at its ends and where a crosses zero; continuity of p, v, a and the end state to 1e-12 of the largest
/// value each reaches. `distance` may be negative.
///
/// # Errors
/// The first [`Violation`] in the order of the phases.
pub fn check(phases: &[Phase], distance: f64, limits: &AxisLimits) -> Result<(), Violation> {
    let (mut scale_v, mut scale_a) = (0.0, 0.0);
    for phase in phases {
        let end = phase.at(phase.t);
        scale_v = larger(scale_v, larger(phase.v0.abs(), end.v.abs()));
        scale_a = larger(scale_a, larger(phase.a0.abs(), end.a.abs()));
    }
    let scale_p = distance.abs();
    let apart = |x: f64, y: f64, scale: f64| exceeds((x - y).abs(), TOLERANCE * scale);
    let (mut p, mut v, mut a) = (0.0, 0.0, 0.0);
    for (number, phase) in phases.iter().enumerate() {
        within_limits(number, phase, limits)?;
        if apart(p, phase.p0, scale_p) || apart(v, phase.v0, scale_v) || apart(a, phase.a0, scale_a)
        {
            return Err(Violation::Jump { phase: number });
        }
        let end = phase.at(phase.t);
        (p, v, a) = (end.p, end.v, end.a);
    }
    if apart(p, distance, scale_p) || apart(v, 0.0, scale_v) || apart(a, 0.0, scale_a) {
        return Err(Violation::End);
    }
    Ok(())
}

/// Whether a value is above a bound, or one of them is not a number.
fn exceeds(value: f64, bound: f64) -> bool {
    value > bound || value.is_nan() || bound.is_nan()
}

fn within_limits(number: usize, phase: &Phase, limits: &AxisLimits) -> Result<(), Violation> {
    let finite = [phase.t, phase.j, phase.a0, phase.v0, phase.p0]
        .iter()
        .all(|x| x.is_finite());
    if !finite || phase.t < 0.0 {
        return Err(Violation::Malformed { phase: number });
    }
    let above = |value: f64, limit: f64| exceeds(value.abs(), limit * (1.0 + TOLERANCE));
    let end = phase.at(phase.t);
    if above(phase.j, limits.j) {
        return Err(Violation::Jerk {
            phase: number,
            value: phase.j,
            limit: limits.j,
        });
    }
    for value in [phase.a0, end.a] {
        if above(value, limits.a) {
            return Err(Violation::Acceleration {
                phase: number,
                value,
                limit: limits.a,
            });
        }
    }
    let turning = -phase.a0 / phase.j;
    let inside = turning > 0.0 && turning < phase.t;
    let extreme = if inside { phase.at(turning).v } else { end.v };
    for value in [phase.v0, extreme, end.v] {
        if above(value, limits.v) {
            return Err(Violation::Velocity {
                phase: number,
                value,
                limit: limits.v,
            });
        }
    }
    Ok(())
}
