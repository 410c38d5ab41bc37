//! Kinematics of a robot of one sliding axis: its flange is moved along one direction, and not turned.

use motion::Pose;
use nalgebra::{Matrix3, SMatrix, Vector3};

use crate::description::AxisDescription;
use crate::error::{KinematicError, Quantity};
use crate::gearing::finite;
use crate::orientation::orthonormal;
use crate::robot::Inverse;
use crate::space::Joints;

/// How well a pose must be on the line and unturned, m and 1.
const VERIFY: f64 = 1e-8;

/// The flange at q along the unit vector `direction`.
pub(crate) fn forward(direction: Vector3<f64>, Joints([q]): Joints<1>) -> Pose {
    Pose {
        position: direction * q,
        rotation: Matrix3::identity(),
    }
}

/// The one q of a pose on the line.
pub(crate) fn inverse(
    direction: Vector3<f64>,
    axis: &AxisDescription,
    flange: &Pose,
    near: Joints<1>,
) -> Result<Inverse<1>, KinematicError> {
    finite(&near.0)?;
    finite(flange.position.as_slice())?;
    let rotation = orthonormal(&flange.rotation)?;
    let q = direction.dot(&flange.position);
    let off = flange.position - direction * q;
    let turned = rotation - Matrix3::identity();
    if !off.iter().chain(turned.iter()).all(|v| v.abs() <= VERIFY) {
        return Err(KinematicError::Unreachable);
    }
    let range = axis.joint_position;
    if !range.contains(q) {
        return Err(KinematicError::Limit {
            axis: 0,
            name: axis.name,
            quantity: Quantity::Joint,
            value: q,
            lower: range.lower,
            upper: range.upper,
        });
    }
    Inverse::new(core::iter::once(Joints([q])), &near).ok_or(KinematicError::Unreachable)
}

/// Linear velocity along the direction.
pub(crate) fn jacobian(direction: Vector3<f64>) -> SMatrix<f64, 6, 1> {
    SMatrix::<f64, 6, 1>::new(direction.x, direction.y, direction.z, 0.0, 0.0, 0.0)
}
