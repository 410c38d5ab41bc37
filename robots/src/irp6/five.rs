//! The five-axis IRp-6 (MRROC++ `irp6m`): the same links and gears without N.
//!
//! Five axes place the flange's origin and the direction of its A, the tool's axis; the turn about A
//! follows. The inverse is that of six axes, of which N, free and without limits, is left out: with
//! t6 = 0 the flange differs from the one asked for by a turn about A only.

use motion::Pose;
use nalgebra::{ArrayStorage, SMatrix};

use super::data::{column, free_wrist_n, lower_arm, machine, upper_arm, wrist_t_of, wrist_v};
use super::{arm, inverse};
use crate::along::{JointsAlong, PoseAlong};
use crate::description::{AxisDescription, HomingSequence, RobotDescription};
use crate::dynamics::{Chain, IRP6_ARM};
use crate::error::KinematicError;
use crate::robot::{Inverse, Robot};
use crate::sources::{Source, Sources};
use crate::space::Joints;

/// The five-axis IRp-6: column, lower arm, upper arm, T, V.
///
/// It reaches positions and directions of A; the rotation of a pose about its own A is not looked at.
/// A tool whose tip lies off A, or whose turn about A matters, is not for this robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Irp6Arm;

static DESCRIPTION: RobotDescription<5> = RobotDescription {
    name: "irp6-arm",
    long_name: "IRp-6 with five axes",
    sources: Sources {
        base: Source::Assumed,
        motor: Source::Assumed,
        overcurrent: Source::Assumed,
        following_error: Source::Assumed,
        homing_coarse: Source::Assumed,
        homing_fine: Source::Assumed,
        pwm_regulator: Source::Assumed,
        current_gain: Source::Assumed,
        current_limit: Source::Assumed,
        ..Sources::IRP6
    },
    servo_step_us: 2000,
    macrostep: 10,
    axes: [
        // currents and gains as on the postument: ASSUMED, see crate::ASSUMED
        column(machine(-16.0, 15_000, 200.0)),
        lower_arm(machine(4.0, 18_000, 150.0)),
        upper_arm(machine(9.0, 10_000, 180.0)),
        wrist_t_of(machine(170.0, 10_000, 170.0), 90.1),
        wrist_v(machine(357.0, 10_000, 110.0)),
    ],
    homing: HomingSequence {
        order: [1, 2, 3, 4, 0],
        ramp_steps: 10,
        stop_steps: 250,
        settle_steps: 25,
        debounce_steps: 3,
    },
    tool_offset_m: [0.0, 0.0, 0.25],
    base_position_m: [0.0, crate::assumed::ARM_BASE_Y_M, 0.0],
    cartesian_velocity: 5.0,
    cartesian_acceleration: 5.0,
};

/// The axes, and an N that turns freely.
fn with_free_n() -> [AxisDescription; 6] {
    let [a, b, c, d, e] = DESCRIPTION.axes;
    [a, b, c, d, e, free_wrist_n()]
}

fn six([a, b, c, d, e]: [f64; 5]) -> [f64; 6] {
    [a, b, c, d, e, 0.0]
}

fn five([a, b, c, d, e, _]: [f64; 6]) -> Joints<5> {
    Joints([a, b, c, d, e])
}

impl Robot<5> for Irp6Arm {
    fn description(&self) -> &'static RobotDescription<5> {
        &DESCRIPTION
    }

    fn forward(&self, joints: &Joints<5>) -> Pose {
        arm::forward(&six(joints.0))
    }

    fn inverse(&self, flange: &Pose, near: &Joints<5>) -> Result<Inverse<5>, KinematicError> {
        let found = inverse::solve(flange, &six(near.0), &with_free_n(), 0)?;
        Inverse::new(found.iter().map(five), near).ok_or(KinematicError::Unreachable)
    }

    fn inverse_near(&self, flange: &Pose, near: &Joints<5>) -> Result<Joints<5>, KinematicError> {
        match inverse::continuing(flange, &six(near.0), &with_free_n()) {
            Some(plain) => Ok(five(plain.joints)),
            None => self
                .inverse(flange, near)
                .map(|solution| solution.nearest()),
        }
    }

    fn inverse_along(
        &self,
        flange: &PoseAlong,
        near: &Joints<5>,
    ) -> Result<JointsAlong<5>, KinematicError> {
        match inverse::continuing(&flange.pose, &six(near.0), &with_free_n()) {
            Some(plain) => Ok(JointsAlong {
                position: five(plain.joints),
                rates: plain
                    .rates(flange)
                    .map(|rates| rates.map(|[a, b, c, d, e, _]| [a, b, c, d, e])),
            }),
            None => self
                .inverse(&flange.pose, near)
                .map(|solution| JointsAlong::at(solution.nearest())),
        }
    }

    fn chain(&self) -> Option<Chain<5>> {
        Some(IRP6_ARM)
    }

    fn jacobian(&self, joints: &Joints<5>) -> SMatrix<f64, 6, 5> {
        let [a, b, c, d, e, _] = arm::jacobian(&six(joints.0));
        SMatrix::from_array_storage(ArrayStorage([a, b, c, d, e]))
    }
}
