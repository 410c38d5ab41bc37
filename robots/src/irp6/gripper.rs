//! The two-finger grippers of both IRp-6: one motor that opens two jaws through a crank.
//!
//! Sources: MRROC++ `kinematic_model_irp6_tfg`, `regulator_irp6*_tfg`, `const_irp6*_tfg.h`;
//! `irp6_robot` for motor, gain and clamp. The rest is ASSUMED, see [`crate::ASSUMED`].

use motion::Pose;
use nalgebra::{SMatrix, Vector3};

use crate::assumed::{
    GRIPPER_ACCELERATION_HARD, GRIPPER_ACCELERATION_PLANNING, GRIPPER_FINE_VELOCITY,
    GRIPPER_JERK_HARD, GRIPPER_JERK_PLANNING, GRIPPER_VELOCITY_PLANNING,
};
use crate::description::{
    AxisDescription, AxisHoming, CurrentRegulator, Gearing, HomingSequence, JointKind, Motor,
    MotorLimits, PwmRegulator, Range, Reference, RobotDescription,
};
use crate::error::KinematicError;
use crate::quadratic::Quadratic;
use crate::robot::{Inverse, Robot};
use crate::slider;
use crate::sources::{Source, Sources};
use crate::space::Joints;

/// The gripper of an IRp-6, a robot of its own. Its joint is the opening between the jaws, m; its
/// flange is one jaw seen from the other, along y.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Irp6Gripper {
    /// Of the IRp-6 on the track.
    Track,
    /// Of the IRp-6 on the postument.
    Postument,
}

/// j = 0.074 − 1.451910074·10⁻⁵·m − 2.8313·10⁻⁹·m², m and rad.
const JAWS: Quadratic = Quadratic {
    constant: 0.074,
    linear: -1.451_910_074e-5,
    square: -2.8313e-9,
};

const fn description(name: &'static str, long_name: &'static str) -> RobotDescription<1> {
    RobotDescription {
        name,
        long_name,
        sources: Sources {
            geometry: Source::Definition,
            tool: Source::Definition,
            base: Source::Definition,
            plan_rates: Source::Assumed,
            following_error: Source::Assumed,
            homing_fine: Source::Assumed,
            ..Sources::IRP6
        },
        servo_step_us: 2000,
        macrostep: 10,
        axes: [AxisDescription {
            name: "jaws",
            kind: JointKind::Prismatic,
            reference: Reference::Joint,
            gearing: Gearing::Quadratic(JAWS),
            synchro_motor_position: 0.0,
            increments_per_turn: 128,
            motor_position: Range {
                lower: -2000.0,
                upper: 5000.0,
            },
            joint_position: Range {
                lower: 0.053,
                upper: 0.091,
            },
            hard_limits: MotorLimits {
                // 20 rad in a 2 ms step
                velocity: 10_000.0,
                acceleration: GRIPPER_ACCELERATION_HARD,
                jerk: GRIPPER_JERK_HARD,
            },
            planning_limits: MotorLimits {
                velocity: GRIPPER_VELOCITY_PLANNING,
                acceleration: GRIPPER_ACCELERATION_PLANNING,
                jerk: GRIPPER_JERK_PLANNING,
            },
            joint_velocity: 1.5,
            joint_acceleration: 7.0,
            overcurrent_ma: 200,
            max_increments_per_step: 1000,
            following_error_increments: 1000,
            motor: Motor {
                torque_constant_nm_a: 0.105,
                rotor_kg_m2: 5.0e-7,
                gear_kg_m2: 0.0,
                load_kg_m2: 1.0e-7,
                viscous_nms_rad: 2.0e-6,
                coulomb_nm: 2.0e-4,
            },
            homing: AxisHoming::Switch {
                // 0.5 rad a 2 ms step; MRROC++ comes back with 0.2
                coarse_velocity: -250.0,
                fine_velocity: GRIPPER_FINE_VELOCITY,
            },
            pwm_regulator: PwmRegulator {
                epsilon: 0.020,
                a: 0.2,
                b0: 15.984_375,
                b1: 15.784_375,
                limit: 190.0,
            },
            current_regulator: CurrentRegulator {
                gain_ma: 0.33,
                limit_ma: 60.0,
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
        base_position_m: [0.0, 0.0, 0.0],
        cartesian_velocity: 5.0,
        cartesian_acceleration: 5.0,
    }
}

static TRACK: RobotDescription<1> =
    description("irp6-track-gripper", "gripper of the IRp-6 on its track");
static POSTUMENT: RobotDescription<1> = description(
    "irp6-postument-gripper",
    "gripper of the IRp-6 on its postument",
);

impl Robot<1> for Irp6Gripper {
    fn description(&self) -> &'static RobotDescription<1> {
        match self {
            Self::Track => &TRACK,
            Self::Postument => &POSTUMENT,
        }
    }

    fn forward(&self, joints: &Joints<1>) -> Pose {
        slider::forward(Vector3::y(), *joints)
    }

    fn inverse(&self, flange: &Pose, near: &Joints<1>) -> Result<Inverse<1>, KinematicError> {
        let [jaws] = &self.description().axes;
        slider::inverse(Vector3::y(), jaws, flange, *near)
    }

    fn jacobian(&self, _: &Joints<1>) -> SMatrix<f64, 6, 1> {
        slider::jacobian(Vector3::y())
    }
}
