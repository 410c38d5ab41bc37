//! The IRp-6 on its track: seven axes, the first of them redundant.
//!
//! The track carries the whole arm along y. A pose alone does not say how far, so the inverse leaves
//! the track where `near` has it; whoever wants it elsewhere says so by `near`.

use motion::Pose;
use nalgebra::{ArrayStorage, SMatrix, Vector3};

use super::data::{column, lower_arm, machine, track, upper_arm, wrist_n, wrist_t, wrist_v};
use super::{arm, inverse};
use crate::description::{HomingSequence, RobotDescription};
use crate::error::{KinematicError, Quantity};
use crate::gearing::finite;
use crate::robot::{Inverse, Robot};
use crate::space::Joints;

/// The IRp-6 on its track: track, column, lower arm, upper arm, T, V, N.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Irp6Track;

static DESCRIPTION: RobotDescription<7> = RobotDescription {
    name: "irp6-track",
    long_name: "IRp-6 on its track",
    servo_step_us: 2000,
    macrostep: 10,
    axes: [
        track(machine(0.0, 25_000, 200.0)),
        column(machine(-10.819, 15_000, 200.0)),
        lower_arm(machine(-4.012, 18_000, 100.0)),
        upper_arm(machine(-6.219, 10_000, 120.0)),
        wrist_t(machine(158.997, 10_000, 170.0)),
        wrist_v(machine(479.5, 10_000, 110.0)),
        wrist_n(machine(769.7, 10_000, 11.0)),
    ],
    homing: HomingSequence {
        order: [2, 3, 4, 5, 6, 0, 1],
        ramp_steps: 10,
        stop_steps: 250,
        settle_steps: 25,
        debounce_steps: 3,
    },
    tool_offset_m: [0.0, 0.0, 0.25],
    base_position_m: [0.0, 0.0, 0.0],
    cartesian_velocity: 5.0,
    cartesian_acceleration: 5.0,
};

impl Robot<7> for Irp6Track {
    fn description(&self) -> &'static RobotDescription<7> {
        &DESCRIPTION
    }

    fn forward(&self, joints: &Joints<7>) -> Pose {
        let [along, arm @ ..] = &joints.0;
        let from_shoulder = arm::forward(arm);
        Pose {
            position: from_shoulder.position + Vector3::new(0.0, *along, 0.0),
            ..from_shoulder
        }
    }

    fn inverse(&self, flange: &Pose, near: &Joints<7>) -> Result<Inverse<7>, KinematicError> {
        finite(&near.0)?;
        let [along, near_arm @ ..] = near.0;
        let [track, axes @ ..] = &DESCRIPTION.axes;
        let range = track.joint_position;
        if !range.contains(along) {
            return Err(KinematicError::Limit {
                axis: 0,
                name: track.name,
                quantity: Quantity::Joint,
                value: along,
                lower: range.lower,
                upper: range.upper,
            });
        }
        let from_shoulder = Pose {
            position: flange.position - Vector3::new(0.0, along, 0.0),
            rotation: flange.rotation,
        };
        let found = inverse::solve(&from_shoulder, &near_arm, axes, 1)?;
        let joined = found
            .iter()
            .map(|[q1, q2, q3, q4, q5, q6]| Joints([along, q1, q2, q3, q4, q5, q6]));
        Inverse::new(joined, near).ok_or(KinematicError::Unreachable)
    }

    fn inverse_near(&self, flange: &Pose, near: &Joints<7>) -> Result<Joints<7>, KinematicError> {
        let [along, near_arm @ ..] = near.0;
        let [track, axes @ ..] = &DESCRIPTION.axes;
        let from_shoulder = Pose {
            position: flange.position - Vector3::new(0.0, along, 0.0),
            rotation: flange.rotation,
        };
        let inside = track.joint_position.contains(along);
        match inverse::continuing(&from_shoulder, &near_arm, axes) {
            Some([q1, q2, q3, q4, q5, q6]) if inside => Ok(Joints([along, q1, q2, q3, q4, q5, q6])),
            _ => self
                .inverse(flange, near)
                .map(|solution| solution.nearest()),
        }
    }

    fn jacobian(&self, joints: &Joints<7>) -> SMatrix<f64, 6, 7> {
        let [_, arm @ ..] = &joints.0;
        let [a, b, c, d, e, f] = arm::jacobian(arm);
        let along = [0.0, 1.0, 0.0, 0.0, 0.0, 0.0];
        SMatrix::from_array_storage(ArrayStorage([along, a, b, c, d, e, f]))
    }
}
