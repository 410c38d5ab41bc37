//! What the set-points of a robot may do: the bounds of the gate, and the envelopes that leave a path room to stop within
//! them.

use crate::edp::limits::Bounds;
use motion::interpolator::Range;
use motion::profile::AxisLimits;
use motion::{Angle, AxisEnvelope};
use robots::RobotDescription;

/// What a path between knots may use of the hard acceleration and jerk; the rest is room to stop
/// on the path.
const PLAN_ACCELERATION: f64 = 0.4;
const PLAN_JERK: f64 = 0.3;
/// What a path may use of the hard velocity: a stop tail that begins at full acceleration still
/// gains 32/27·a²/j = 4.4 rad/s at the IRp-6's limits (a = 360, j = 34800), of 50 rad/s.
pub(super) const PLAN_VELOCITY: f64 = 0.91;
/// Before homing there are no position limits to keep; a bound for the arithmetic, rad.
const UNBOUNDED_RAD: i32 = 100_000;
/// The same in quanta.
pub(super) const UNBOUNDED: Range = {
    let bound = (UNBOUNDED_RAD as i64) << Angle::FRACTION_BITS;
    (Angle::of_quanta(-bound), Angle::of_quanta(bound))
};

/// What the gate lets pass; `factor` is the share of the hard velocity that may be used.
pub(crate) fn bounds<const N: usize>(
    description: &RobotDescription<N>,
    factor: f64,
    homed: bool,
) -> [Bounds; N] {
    description.axes.each_ref().map(|axis| Bounds {
        lower: if homed {
            axis.motor_position.lower
        } else {
            f64::from(-UNBOUNDED_RAD)
        },
        upper: if homed {
            axis.motor_position.upper
        } else {
            f64::from(UNBOUNDED_RAD)
        },
        velocity: axis.hard_limits.velocity * factor,
        acceleration: axis.hard_limits.acceleration,
        jerk: axis.hard_limits.jerk,
    })
}

/// Where the motors may be, once homed.
pub(super) fn ranges<const N: usize>(description: &RobotDescription<N>) -> [Range; N] {
    description.axes.each_ref().map(|axis| {
        let range = axis.motor_position;
        (Angle::bound(range.lower), Angle::bound(range.upper))
    })
}

/// What a path may ask of the motors.
// one function: the setup asks for it, and each plan
#[inline(never)]
pub(crate) fn envelopes<const N: usize>(
    description: &RobotDescription<N>,
    factor: f64,
    homed: bool,
) -> [AxisEnvelope; N] {
    bounds(description, factor, homed).map(|b| {
        let hard = AxisLimits {
            v: b.velocity,
            a: b.acceleration,
            j: b.jerk,
        };
        let plan = AxisLimits {
            v: hard.v * PLAN_VELOCITY,
            a: hard.a * PLAN_ACCELERATION,
            j: hard.j * PLAN_JERK,
        };
        AxisEnvelope {
            lower: b.lower,
            upper: b.upper,
            hard,
            plan,
            acceleration_step: plan.a,
        }
    })
}
