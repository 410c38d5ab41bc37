//! Limits for planning in joint space, such that motor limits hold.
//!
//! With gear coordinates x and motor travel m, along any motion
//!
//! ```text
//!   ṁ = m'·ẋ      m̈ = m'·ẍ + m''·ẋ²      d³m/dt³ = m'·d³x/dt³ + 3·m''·ẋ·ẍ + m'''·ẋ³
//! ```
//!
//! where only screw triangles and quadratics have m'' and m'''. The hard acceleration is shared out in three: the
//! plan's own m'·ẍ (the planning ceiling, a sixth), the curvature m''·ẋ² ([`CURVATURE_SHARE`]), and
//! the rest for a stop on the path. Velocity may use [`VELOCITY_SHARE`] of the hard limit. Jerk needs
//! no such care: the planning jerk is a 40th of the hard limit and the two curvature terms, bounded by
//! the velocities and accelerations above, stay below a tenth as well (a test holds them to it).

use crate::description::{AxisDescription, Gearing, Range, Reference, RobotDescription};
use crate::error::KinematicError;
use crate::gearing::{at_axis, finite, gear_positions, gear_rates};
use crate::screw::ScrewTriangle;
use crate::space::Joints;
use motion::AxisLimits;

/// ASSUMED: share of the hard velocity limit that a plan may use.
pub const VELOCITY_SHARE: f64 = 0.95;
/// ASSUMED: share of the hard acceleration limit left to the curvature of the screw triangles.
pub const CURVATURE_SHARE: f64 = 1.0 / 6.0;

/// The part of every motor's hard velocity limit that is in force, in (0, 1]: MRROC++'s
/// `velocity_limit_global_factor`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VelocityFactor(f64);

impl VelocityFactor {
    /// What MRROC++ uses when nothing is configured: 50 rad/s of 250 rad/s.
    pub const DEFAULT: Self = Self(0.2);
    /// The whole of the hard limit.
    pub const FULL: Self = Self(1.0);

    /// From a number in (0, 1]; nothing for any other.
    #[must_use]
    pub fn new(factor: f64) -> Option<Self> {
        (0.0 < factor && factor <= 1.0).then_some(Self(factor))
    }

    /// The number.
    #[must_use]
    pub const fn value(self) -> f64 {
        self.0
    }
}

impl Default for VelocityFactor {
    fn default() -> Self {
        Self::DEFAULT
    }
}

pub(crate) fn least(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

pub(crate) fn greatest(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

fn ordered(a: f64, b: f64) -> (f64, f64) {
    if b < a { (b, a) } else { (a, b) }
}

/// One axis' transmission over its range: greatest |m'| and |m''| by the gear coordinate.
#[derive(Clone, Copy, Debug)]
struct Transmission {
    slope: f64,
    curvature: f64,
}

/// The gear coordinates joint and motor limits leave to a screw.
fn screw_range(screw: &ScrewTriangle, motor: Range, synchro: f64, reach: Range) -> Range {
    let at = |m: f64| screw.angle(m - synchro);
    let (low, high) = screw.angles();
    Range {
        lower: greatest(at(motor.lower).unwrap_or(low), reach.lower),
        upper: least(at(motor.upper).unwrap_or(high), reach.upper),
    }
}

/// Every axis' transmission over what joint and motor limits leave.
fn transmissions<const N: usize>(robot: &RobotDescription<N>) -> [Transmission; N] {
    let mut found = [Transmission {
        slope: 0.0,
        curvature: 0.0,
    }; N];
    let mut previous = Range {
        lower: 0.0,
        upper: 0.0,
    };
    for (out, axis) in found.iter_mut().zip(&robot.axes) {
        let joint = axis.joint_position;
        let reach = match axis.reference {
            Reference::Joint | Reference::Leg { .. } => joint,
            Reference::ArmPlane { offset } => Range {
                lower: joint.lower + previous.lower + offset,
                upper: joint.upper + previous.upper + offset,
            },
        };
        previous = reach;
        *out = match axis.gearing {
            Gearing::Linear { ratio } | Gearing::OnPrevious { ratio } => Transmission {
                slope: ratio.abs(),
                curvature: 0.0,
            },
            Gearing::Screw(screw) => {
                let range = screw_range(
                    &screw,
                    axis.motor_position,
                    axis.synchro_motor_position,
                    reach,
                );
                previous = range;
                // the whole triangle's bounds, should the range touch a dead centre
                Transmission {
                    slope: screw
                        .slopes(range.lower, range.upper)
                        .map_or(screw.steepest(), |(_, most)| most),
                    curvature: screw
                        .curvature(range.lower, range.upper)
                        .unwrap_or(screw.most_curved()),
                }
            }
            // a quadratic's joint limits keep it off its dead centre: a test holds them to it
            Gearing::Quadratic(law) => Transmission {
                slope: law
                    .slopes(reach.lower, reach.upper)
                    .map_or(f64::INFINITY, |(low, high)| greatest(-low, high)),
                curvature: law
                    .curvature(reach.lower, reach.upper)
                    .unwrap_or(f64::INFINITY),
            },
        };
    }
    found
}

/// See [`crate::Robot::motor_slopes`].
pub(crate) fn motor_slopes<const N: usize>(robot: &RobotDescription<N>) -> [f64; N] {
    transmissions(robot).map(|t| t.slope)
}

/// Bounds of |m'·ẋ| and |m''·ẋ²| of every motor for joints no faster than `rates`, all ≥ 0.
fn motor_bounds<const N: usize>(
    robot: &RobotDescription<N>,
    transmissions: &[Transmission; N],
    rates: &[f64; N],
) -> ([f64; N], [f64; N]) {
    let x = gear_rates(robot, rates);
    let (mut linear, mut curved) = ([0.0; N], [0.0; N]);
    let mut previous = (0.0, 0.0);
    for ((((linear, curved), axis), t), x) in linear
        .iter_mut()
        .zip(&mut curved)
        .zip(&robot.axes)
        .zip(transmissions)
        .zip(x)
    {
        let own = (t.slope * x, t.curvature * x * x);
        previous = match axis.gearing {
            Gearing::OnPrevious { .. } => (previous.0 + own.0, previous.1 + own.1),
            Gearing::Linear { .. } | Gearing::Screw(_) | Gearing::Quadratic(_) => own,
        };
        (*linear, *curved) = previous;
    }
    (linear, curved)
}

/// What each joint may use of the motors' budgets when all use them at once; `own` is the joints'
/// ceiling and `per_joint[j][k]` is C(k, j). See [`crate::Robot::joint_limits_for_planning`].
fn share<const N: usize>(per_joint: &[[f64; N]; N], own: [f64; N], budgets: &[f64; N]) -> [f64; N] {
    let mut alone = own;
    let mut total = [0.0; N];
    for (alone, c) in alone.iter_mut().zip(per_joint) {
        for (c, budget) in c.iter().zip(budgets).filter(|(c, _)| **c > 0.0) {
            *alone = least(*alone, budget / c);
        }
        for (total, c) in total.iter_mut().zip(c) {
            *total += c * *alone;
        }
    }
    scaled(
        per_joint,
        alone,
        core::array::from_fn(|k| {
            let (budget, total) = (budgets.get(k), total.get(k));
            budget
                .zip(total)
                .map_or(1.0, |(budget, total)| budget / total)
        }),
    )
}

/// Every joint's value times the least factor, at most 1, of the motors it turns.
fn scaled<const N: usize>(
    per_joint: &[[f64; N]; N],
    mut values: [f64; N],
    factors: [f64; N],
) -> [f64; N] {
    for (value, c) in values.iter_mut().zip(per_joint) {
        let turned = c.iter().zip(factors).filter(|(c, _)| **c > 0.0);
        *value *= turned.fold(1.0, |most, (_, factor)| least(most, factor));
    }
    values
}

/// See [`crate::Robot::joint_limits_for_planning`].
pub(crate) fn joint_limits<const N: usize>(
    robot: &RobotDescription<N>,
    factor: VelocityFactor,
) -> [AxisLimits; N] {
    let transmissions = transmissions(robot);
    let per_joint: [[f64; N]; N] = core::array::from_fn(|j| {
        let only = core::array::from_fn(|i| if i == j { 1.0 } else { 0.0 });
        motor_bounds(robot, &transmissions, &only).0
    });
    let curved = |rates: &[f64; N]| motor_bounds(robot, &transmissions, rates).1;
    shared_limits(&robot.axes, &per_joint, curved, factor)
}

/// What every joint may use when all move at once; `per_joint[j][k]` is C(k, j), and `curved` gives the
/// bound of |Σ ∂²m/∂q∂q·q̇·q̇| of every motor for joints no faster than its argument.
pub(crate) fn shared_limits<const N: usize>(
    axes: &[AxisDescription; N],
    per_joint: &[[f64; N]; N],
    curved: impl Fn(&[f64; N]) -> [f64; N],
    factor: VelocityFactor,
) -> [AxisLimits; N] {
    let velocity = share(
        per_joint,
        axes.map(|a| a.joint_velocity),
        &axes.map(|a| velocity_budget(&a, factor)),
    );
    let curved = curved(&velocity);
    let mut slow_down = axes.map(|a| CURVATURE_SHARE * a.hard_limits.acceleration);
    for (factor, curved) in slow_down.iter_mut().zip(curved) {
        *factor = if curved > *factor {
            libm::sqrt(*factor / curved)
        } else {
            1.0
        };
    }
    let velocity = scaled(per_joint, velocity, slow_down);
    let acceleration = share(
        per_joint,
        axes.map(|a| a.joint_acceleration),
        &axes.map(|a| a.planning_limits.acceleration),
    );
    let jerk = share(
        per_joint,
        [f64::INFINITY; N],
        &axes.map(|a| a.planning_limits.jerk),
    );
    let mut limits = [AxisLimits {
        v: 0.0,
        a: 0.0,
        j: 0.0,
    }; N];
    for (out, ((v, a), j)) in limits
        .iter_mut()
        .zip(velocity.into_iter().zip(acceleration).zip(jerk))
    {
        *out = AxisLimits { v, a, j };
    }
    limits
}

/// What a plan may ask of a motor, rad/s.
fn velocity_budget(axis: &AxisDescription, factor: VelocityFactor) -> f64 {
    least(
        axis.planning_limits.velocity,
        VELOCITY_SHARE * factor.value() * axis.hard_limits.velocity,
    )
}

/// See [`crate::Robot::limits_along`].
///
/// q̇ = d·ṡ with d = to − from, so ẋ is a constant times ṡ, and m' between its extremes on the
/// line gives an interval of dm/ds, exact in sign where motors are coupled.
pub(crate) fn limits_along<const N: usize>(
    robot: &RobotDescription<N>,
    from: &Joints<N>,
    to: &Joints<N>,
    factor: VelocityFactor,
) -> Result<Option<AxisLimits>, KinematicError> {
    let Some(direction) = direction(from, to)? else {
        return Ok(None);
    };
    let (start, end) = (gear_positions(robot, &from.0), gear_positions(robot, &to.0));
    let along = gear_rates(robot, &direction);
    let mut limits = UNLIMITED;
    let mut previous = (0.0, 0.0);
    let ends = start.into_iter().zip(end);
    let ways = robot.axes.iter().zip(direction).zip(along).zip(ends);
    for (k, (((axis, dq), dx), (a, b))) in (0..N).zip(ways) {
        let mut curvature = 0.0;
        previous = match axis.gearing {
            Gearing::Linear { ratio } => (ratio * dx, ratio * dx),
            Gearing::OnPrevious { ratio } => (previous.0 + ratio * dx, previous.1 + ratio * dx),
            Gearing::Screw(screw) => {
                let (low, high) = screw.slopes(a, b).map_err(at_axis(k, axis))?;
                curvature = screw.curvature(a, b).map_err(at_axis(k, axis))? * dx * dx;
                ordered(low * dx, high * dx)
            }
            Gearing::Quadratic(law) => {
                let (low, high) = law.slopes(a, b).map_err(at_axis(k, axis))?;
                curvature = law.curvature(a, b).map_err(at_axis(k, axis))? * dx * dx;
                ordered(low * dx, high * dx)
            }
        };
        let slope = greatest(previous.0.abs(), previous.1.abs());
        cap(&mut limits, axis, factor, [slope, curvature, dq]);
    }
    Ok(Some(limits))
}

/// No limits of a path parameter yet.
pub(crate) const UNLIMITED: AxisLimits = AxisLimits {
    v: f64::INFINITY,
    a: f64::INFINITY,
    j: f64::INFINITY,
};

/// to − from, or nothing where they are equal.
pub(crate) fn direction<const N: usize>(
    from: &Joints<N>,
    to: &Joints<N>,
) -> Result<Option<[f64; N]>, KinematicError> {
    finite(&from.0)?;
    finite(&to.0)?;
    let mut direction = to.0;
    for (d, from) in direction.iter_mut().zip(from.0) {
        *d -= from;
    }
    finite(&direction)?;
    Ok(direction.iter().any(|d| *d != 0.0).then_some(direction))
}

/// Lowers the limits of a path parameter s to what an axis allows, from the bounds of |dm/ds| and
/// |d²m/ds²| of its motor, both ≥ 0, and dq/ds of its joint.
pub(crate) fn cap(
    limits: &mut AxisLimits,
    axis: &AxisDescription,
    factor: VelocityFactor,
    [slope, curvature, dq]: [f64; 3],
) {
    let cap = |limit: &mut f64, budget: f64, by: f64| {
        if by > 0.0 {
            *limit = least(*limit, budget / by);
        }
    };
    cap(&mut limits.v, velocity_budget(axis, factor), slope);
    cap(&mut limits.v, axis.joint_velocity, dq.abs());
    let room = CURVATURE_SHARE * axis.hard_limits.acceleration;
    cap(&mut limits.v, libm::sqrt(room), libm::sqrt(curvature));
    cap(&mut limits.a, axis.planning_limits.acceleration, slope);
    cap(&mut limits.a, axis.joint_acceleration, dq.abs());
    cap(&mut limits.j, axis.planning_limits.jerk, slope);
}

#[cfg(test)]
mod test {
    use super::*;
    use crate::gearing::motor_motion;
    use crate::{Irp6Postument, JointMotion, Robot};
    use proptest::prelude::*;

    /// The postument with motors so fast that curvature, not speed, is what limits the arm.
    fn fast() -> RobotDescription<6> {
        let mut robot = *Irp6Postument.description();
        for axis in &mut robot.axes {
            axis.hard_limits.velocity = 2500.0;
            axis.planning_limits.velocity = 2000.0;
            axis.joint_velocity = 15.0;
        }
        robot
    }

    proptest! {
        #[test]
        fn curvature_takes_its_share_and_no_more(
            t2 in -2.2..-0.9f64, t3 in -0.4..0.5f64, signs in prop::array::uniform4(-1.0..1.0f64),
        ) {
            let robot = fast();
            let limits = joint_limits(&robot, VelocityFactor::FULL);
            let [_, lower, upper, ..] = limits;
            let sign = signs.map(f64::signum);
            let motion = JointMotion {
                position: Joints([0.0, t2, t3 - t2 - core::f64::consts::FRAC_PI_2, 0.0, 0.0, 0.0]),
                velocity: [0.0, sign[0] * lower.v, sign[1] * upper.v, 0.0, 0.0, 0.0],
                acceleration: [
                    0.0, sign[2] * lower.a, sign[3] * upper.a, 0.0, 0.0, 0.0,
                ],
            };
            let got = motor_motion(&robot, &motion).unwrap();
            for (a, axis) in got.acceleration.iter().zip(&robot.axes) {
                prop_assert!(a.abs() <= axis.hard_limits.acceleration * 2.0 / 3.0 + 1e-9, "{a}");
            }
        }
    }

    #[test]
    fn curvature_is_the_limit_of_a_fast_arm() {
        let robot = fast();
        let limits = joint_limits(&robot, VelocityFactor::FULL);
        let (_, curved) = motor_bounds(&robot, &transmissions(&robot), &limits.map(|l| l.v));
        let most = curved.iter().fold(0.0, |most, c| greatest(most, *c));
        // the worst screw uses all of its share
        assert!((most / 150.0 - 1.0).abs() < 1e-9, "{most}");
    }
}
