//! The IRp-6 on its postument (a fixed pedestal): six axes.

use motion::Pose;
use nalgebra::{ArrayStorage, SMatrix};

use super::data::{column, lower_arm, machine, upper_arm, wrist_n, wrist_t, wrist_v};
use super::{arm, inverse};
use crate::along::{JointsAlong, PoseAlong};
use crate::description::{HomingSequence, RobotDescription};
use crate::dynamics::{Chain, IRP6_POSTUMENT};
use crate::error::KinematicError;
use crate::robot::{Inverse, Robot};
use crate::sources::Sources;
use crate::space::Joints;

/// The IRp-6 on its postument: column, lower arm, upper arm, T, V, N.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Irp6Postument;

static DESCRIPTION: RobotDescription<6> = RobotDescription {
    name: "irp6-postument",
    long_name: "IRp-6 on its postument",
    sources: Sources::IRP6,
    servo_step_us: 2000,
    macrostep: 10,
    axes: [
        column(machine(-15.9, 15_000, 200.0)),
        lower_arm(machine(-5.0, 18_000, 150.0)),
        upper_arm(machine(-8.527, 10_000, 180.0)),
        wrist_t(machine(151.31, 10_000, 170.0)),
        wrist_v(machine(435.25, 10_000, 110.0)),
        wrist_n(machine(791.0, 10_000, 11.0)),
    ],
    homing: HomingSequence {
        order: [1, 2, 3, 4, 5, 0],
        ramp_steps: 10,
        stop_steps: 250,
        settle_steps: 25,
        debounce_steps: 3,
    },
    tool_offset_m: [0.0, 0.0, 0.25],
    base_position_m: [-0.0728, 2.1063, -0.0302],
    cartesian_velocity: 5.0,
    cartesian_acceleration: 5.0,
};

impl Robot<6> for Irp6Postument {
    fn description(&self) -> &'static RobotDescription<6> {
        &DESCRIPTION
    }

    fn forward(&self, joints: &Joints<6>) -> Pose {
        arm::forward(&joints.0)
    }

    fn inverse(&self, flange: &Pose, near: &Joints<6>) -> Result<Inverse<6>, KinematicError> {
        let found = inverse::solve(flange, &near.0, &DESCRIPTION.axes, 0)?;
        Inverse::new(found.iter().map(Joints), near).ok_or(KinematicError::Unreachable)
    }

    fn inverse_near(&self, flange: &Pose, near: &Joints<6>) -> Result<Joints<6>, KinematicError> {
        match inverse::continuing(flange, &near.0, &DESCRIPTION.axes) {
            Some(plain) => Ok(Joints(plain.joints)),
            None => self
                .inverse(flange, near)
                .map(|solution| solution.nearest()),
        }
    }

    fn inverse_along(
        &self,
        flange: &PoseAlong,
        near: &Joints<6>,
    ) -> Result<JointsAlong<6>, KinematicError> {
        match inverse::continuing(&flange.pose, &near.0, &DESCRIPTION.axes) {
            Some(plain) => Ok(JointsAlong {
                position: Joints(plain.joints),
                rates: plain.rates(flange),
            }),
            None => self
                .inverse(&flange.pose, near)
                .map(|solution| JointsAlong::at(solution.nearest())),
        }
    }

    fn chain(&self) -> Option<Chain<6>> {
        Some(IRP6_POSTUMENT)
    }

    fn jacobian(&self, joints: &Joints<6>) -> SMatrix<f64, 6, 6> {
        SMatrix::from_array_storage(ArrayStorage(arm::jacobian(&joints.0)))
    }
}
