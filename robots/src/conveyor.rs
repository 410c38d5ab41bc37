//! The conveyor: one belt that runs without end.
//!
//! Sources: MRROC++ `kinematic_model_conveyor`, `regulator_conv`, `sg_conv`, `const_conveyor.h`;
//! `irp6_robot` for the motor. The rest is ASSUMED, see [`crate::ASSUMED`].

use motion::Pose;
use nalgebra::{SMatrix, Vector3};

use crate::assumed::{
    CONVEYOR_BASE_Y_M, CONVEYOR_CURRENT_MA, MOTOR_ACCELERATION_HARD, MOTOR_JERK_HARD,
    MOTOR_JERK_PLANNING,
};
use crate::description::{
    AxisDescription, AxisHoming, CurrentRegulator, Gearing, HomingSequence, JointKind, Motor,
    MotorLimits, PwmRegulator, Range, Reference, RobotDescription,
};
use crate::error::KinematicError;
use crate::robot::{Inverse, Robot};
use crate::slider;
use crate::sources::{Source, Sources};
use crate::space::Joints;

/// The conveyor. Its flange is a point of the belt, which moves along x of the base; there are no
/// limits, and homing makes 0 of wherever the belt stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Conveyor;

/// Motor turn for a metre of belt, rad/m.
const RATIO: f64 = 2250.0;

static DESCRIPTION: RobotDescription<1> = RobotDescription {
    name: "conveyor",
    long_name: "conveyor",
    sources: Sources {
        geometry: Source::Definition,
        tool: Source::Definition,
        base: Source::Assumed,
        overcurrent: Source::Assumed,
        following_error: Source::Assumed,
        current_gain: Source::Assumed,
        current_limit: Source::Assumed,
        ..Sources::IRP6
    },
    servo_step_us: 2000,
    macrostep: 10,
    axes: [AxisDescription {
        name: "belt",
        kind: JointKind::Prismatic,
        reference: Reference::Joint,
        gearing: Gearing::Linear { ratio: RATIO },
        synchro_motor_position: 0.0,
        increments_per_turn: 4000,
        motor_position: Range::UNLIMITED,
        joint_position: Range::UNLIMITED,
        hard_limits: MotorLimits {
            velocity: 250.0,
            acceleration: MOTOR_ACCELERATION_HARD,
            jerk: MOTOR_JERK_HARD,
        },
        planning_limits: MotorLimits {
            velocity: 200.0,
            acceleration: 150.0,
            jerk: MOTOR_JERK_PLANNING,
        },
        joint_velocity: 1.5,
        joint_acceleration: 7.0,
        overcurrent_ma: 10_000,
        max_increments_per_step: 1000,
        following_error_increments: 1000,
        motor: Motor {
            torque_constant_nm_a: 0.105,
            rotor_kg_m2: 1.5e-4,
            gear_kg_m2: 0.0,
            load_kg_m2: 1.0e-4,
            viscous_nms_rad: 0.01,
            coulomb_nm: 0.02,
        },
        homing: AxisHoming::InPlace,
        pwm_regulator: PwmRegulator {
            epsilon: 0.008,
            a: 0.548_946_716_233,
            b0: 0.945_759_6,
            b1: 0.881_159_4,
            limit: 190.0,
        },
        current_regulator: CurrentRegulator {
            gain_ma: 120.0,
            limit_ma: CONVEYOR_CURRENT_MA,
        },
    }],
    homing: HomingSequence {
        order: [0],
        ramp_steps: 10,
        stop_steps: 250,
        settle_steps: 25,
        debounce_steps: 3,
    },
    tool_offset_m: [0.0, 0.0, 0.0],
    base_position_m: [0.0, CONVEYOR_BASE_Y_M, 0.0],
    cartesian_velocity: 5.0,
    cartesian_acceleration: 5.0,
};

impl Robot<1> for Conveyor {
    fn description(&self) -> &'static RobotDescription<1> {
        &DESCRIPTION
    }

    fn forward(&self, joints: &Joints<1>) -> Pose {
        slider::forward(Vector3::x(), *joints)
    }

    fn inverse(&self, flange: &Pose, near: &Joints<1>) -> Result<Inverse<1>, KinematicError> {
        let [belt] = &DESCRIPTION.axes;
        slider::inverse(Vector3::x(), belt, flange, *near)
    }

    fn jacobian(&self, _: &Joints<1>) -> SMatrix<f64, 6, 1> {
        slider::jacobian(Vector3::x())
    }
}
