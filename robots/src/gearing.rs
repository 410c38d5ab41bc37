//! Motor ↔ joint, from the description alone: positions, and the exact chain rule for velocities and
//! accelerations.
//!
//! Two maps in a row. Joint → gear coordinate is affine ([`Reference`]), so rates follow by the same
//! sums without the offsets. Gear coordinate → motor travel is [`Gearing`]; for a screw with m = m(x),
//!
//! ```text
//!   ṁ = m'·ẋ          m̈ = m''·ẋ² + m'·ẍ
//!   ẋ = ṁ / m'        ẍ = (m̈ − m''·ẋ²) / m'
//! ```
//!
//! where m' ≠ 0 everywhere between the dead centres; likewise for a quadratic.
//!
//! Where the gear drives a leg of a platform ([`Reference::Leg`]), the functions here take and give the
//! leg's length, m, in the place of the joint: what joints have to do with it is the robot's own code.

use crate::description::{AxisDescription, Gearing, Reference, RobotDescription};
use crate::error::KinematicError;
use crate::screw::{OutOfRange, Travel};
use crate::space::{JointMotion, Joints, MotorMotion, Motors};

/// Refuses infinities and NaN.
pub(crate) fn finite(values: &[f64]) -> Result<(), KinematicError> {
    if values.iter().all(|v| v.is_finite()) {
        Ok(())
    } else {
        Err(KinematicError::NotFinite)
    }
}

/// The error of a nonlinear gear, at its axis.
pub(crate) fn at_axis(
    axis: usize,
    description: &AxisDescription,
) -> impl Fn(OutOfRange) -> KinematicError {
    let name = description.name;
    move |out| KinematicError::Limit {
        axis,
        name,
        quantity: out.quantity,
        value: out.value,
        lower: out.lower,
        upper: out.upper,
    }
}

/// Gear coordinates of joint positions, rad or m.
pub(crate) fn gear_positions<const N: usize>(
    robot: &RobotDescription<N>,
    joints: &[f64; N],
) -> [f64; N] {
    let mut x = [0.0; N];
    let mut previous = 0.0;
    for ((x, q), axis) in x.iter_mut().zip(joints).zip(&robot.axes) {
        *x = match axis.reference {
            Reference::Joint => *q,
            Reference::ArmPlane { offset } => q + previous + offset,
            Reference::Leg { reference_length_m } => q - reference_length_m,
        };
        previous = *x;
    }
    x
}

/// Rates of the gear coordinates from rates of the joints, and likewise of any derivative.
pub(crate) fn gear_rates<const N: usize>(
    robot: &RobotDescription<N>,
    rates: &[f64; N],
) -> [f64; N] {
    let mut x = [0.0; N];
    let mut previous = 0.0;
    for ((x, q), axis) in x.iter_mut().zip(rates).zip(&robot.axes) {
        *x = match axis.reference {
            Reference::Joint | Reference::Leg { .. } => *q,
            Reference::ArmPlane { .. } => q + previous,
        };
        previous = *x;
    }
    x
}

/// Motor angles of joint positions.
pub(crate) fn motors<const N: usize>(
    robot: &RobotDescription<N>,
    joints: &Joints<N>,
) -> Result<Motors<N>, KinematicError> {
    finite(&joints.0)?;
    let x = gear_positions(robot, &joints.0);
    let mut motors = [0.0; N];
    let mut previous = 0.0;
    for (k, ((m, x), axis)) in (0..N).zip(motors.iter_mut().zip(x).zip(&robot.axes)) {
        let travel = match axis.gearing {
            Gearing::Linear { ratio } => ratio * x,
            Gearing::OnPrevious { ratio } => previous + ratio * x,
            Gearing::Screw(screw) => screw.travel(x).map_err(at_axis(k, axis))?.travel,
            Gearing::Quadratic(law) => law.travel(x).map_err(at_axis(k, axis))?.travel,
        };
        *m = axis.synchro_motor_position + travel;
        previous = travel;
    }
    finite(&motors)?;
    Ok(Motors(motors))
}

/// Joint positions of motor angles.
pub(crate) fn joints<const N: usize>(
    robot: &RobotDescription<N>,
    motors: &Motors<N>,
) -> Result<Joints<N>, KinematicError> {
    finite(&motors.0)?;
    let mut joints = [0.0; N];
    let (mut previous_travel, mut previous_x) = (0.0, 0.0);
    for (k, ((q, m), axis)) in (0..N).zip(joints.iter_mut().zip(motors.0).zip(&robot.axes)) {
        let travel = m - axis.synchro_motor_position;
        let x = match axis.gearing {
            Gearing::Linear { ratio } => travel / ratio,
            Gearing::OnPrevious { ratio } => (travel - previous_travel) / ratio,
            Gearing::Screw(screw) => screw.angle(travel).map_err(at_axis(k, axis))?,
            Gearing::Quadratic(law) => law.position(travel).map_err(at_axis(k, axis))?,
        };
        *q = match axis.reference {
            Reference::Joint => x,
            Reference::ArmPlane { offset } => x - previous_x - offset,
            Reference::Leg { reference_length_m } => x + reference_length_m,
        };
        (previous_travel, previous_x) = (travel, x);
    }
    finite(&joints)?;
    Ok(Joints(joints))
}

/// ṁ and m̈ from ẋ and ẍ.
fn curved(m: &Travel, dx: f64, ddx: f64) -> (f64, f64) {
    (m.first * dx, m.second * dx * dx + m.first * ddx)
}

/// ẋ and ẍ from ṁ and m̈.
fn curved_back(m: &Travel, dm: f64, ddm: f64) -> (f64, f64) {
    let dx = dm / m.first;
    (dx, (ddm - m.second * dx * dx) / m.first)
}

/// Motion of the motors from the motion of the joints.
pub(crate) fn motor_motion<const N: usize>(
    robot: &RobotDescription<N>,
    motion: &JointMotion<N>,
) -> Result<MotorMotion<N>, KinematicError> {
    let position = motors(robot, &motion.position)?;
    let x = gear_positions(robot, &motion.position.0);
    let dx = gear_rates(robot, &motion.velocity);
    let ddx = gear_rates(robot, &motion.acceleration);
    let (mut velocity, mut acceleration) = ([0.0; N], [0.0; N]);
    let mut previous = (0.0, 0.0);
    let motors = velocity.iter_mut().zip(&mut acceleration);
    let gears = motors.zip(&robot.axes).zip(x).zip(dx.into_iter().zip(ddx));
    for (k, ((((dm, ddm), axis), x), (dx, ddx))) in (0..N).zip(gears) {
        previous = match axis.gearing {
            Gearing::Linear { ratio } => (ratio * dx, ratio * ddx),
            Gearing::OnPrevious { ratio } => (previous.0 + ratio * dx, previous.1 + ratio * ddx),
            Gearing::Screw(screw) => curved(&screw.travel(x).map_err(at_axis(k, axis))?, dx, ddx),
            Gearing::Quadratic(law) => curved(&law.travel(x).map_err(at_axis(k, axis))?, dx, ddx),
        };
        (*dm, *ddm) = previous;
    }
    finite(&velocity)?;
    finite(&acceleration)?;
    Ok(MotorMotion {
        position,
        velocity,
        acceleration,
    })
}

/// Motion of the joints from the motion of the motors.
pub(crate) fn joint_motion<const N: usize>(
    robot: &RobotDescription<N>,
    motion: &MotorMotion<N>,
) -> Result<JointMotion<N>, KinematicError> {
    let position = joints(robot, &motion.position)?;
    let x = gear_positions(robot, &position.0);
    let (mut velocity, mut acceleration) = ([0.0; N], [0.0; N]);
    let (mut previous_m, mut previous_x) = ((0.0, 0.0), (0.0, 0.0));
    let joints = velocity.iter_mut().zip(&mut acceleration);
    let motors = motion.velocity.into_iter().zip(motion.acceleration);
    let gears = joints.zip(&robot.axes).zip(x).zip(motors);
    for (k, ((((dq, ddq), axis), x), (dm, ddm))) in (0..N).zip(gears) {
        let (dx, ddx) = match axis.gearing {
            Gearing::Linear { ratio } => (dm / ratio, ddm / ratio),
            Gearing::OnPrevious { ratio } => {
                ((dm - previous_m.0) / ratio, (ddm - previous_m.1) / ratio)
            }
            Gearing::Screw(screw) => {
                curved_back(&screw.travel(x).map_err(at_axis(k, axis))?, dm, ddm)
            }
            Gearing::Quadratic(law) => {
                curved_back(&law.travel(x).map_err(at_axis(k, axis))?, dm, ddm)
            }
        };
        (*dq, *ddq) = match axis.reference {
            Reference::Joint | Reference::Leg { .. } => (dx, ddx),
            Reference::ArmPlane { .. } => (dx - previous_x.0, ddx - previous_x.1),
        };
        (previous_m, previous_x) = ((dm, ddm), (dx, ddx));
    }
    finite(&velocity)?;
    finite(&acceleration)?;
    Ok(JointMotion {
        position,
        velocity,
        acceleration,
    })
}
