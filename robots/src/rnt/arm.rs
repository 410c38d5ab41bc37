//! The serial chain: central leg, platform, wrist.

use motion::Pose;
use nalgebra::{Matrix3, Vector3};

use super::assumed::{WRIST_CENTRE_M, WRIST_MOUNT_RAD};
use crate::irp6::arm::{about_x, about_y, about_z};

fn turn_x(angle: f64) -> Matrix3<f64> {
    let (s, c) = libm::sincos(angle);
    about_x(s, c)
}

fn turn_y(angle: f64) -> Matrix3<f64> {
    let (s, c) = libm::sincos(angle);
    about_y(s, c)
}

fn turn_z(angle: f64) -> Matrix3<f64> {
    let (s, c) = libm::sincos(angle);
    about_z(s, c)
}

/// Axes of the platform in the base: Y(ty)·X(tx).
pub(super) fn platform(ty: f64, tx: f64) -> Matrix3<f64> {
    turn_y(ty) * turn_x(tx)
}

/// Axes of the wrist's base in the base frame.
pub(super) fn wrist_base(ty: f64, tx: f64) -> Matrix3<f64> {
    platform(ty, tx) * turn_y(WRIST_MOUNT_RAD)
}

/// Flange in the base frame.
pub(super) fn forward([ty, tx, reach, w1, w2, w3]: &[f64; 6]) -> Pose {
    let platform = platform(*ty, *tx);
    Pose {
        position: platform.column(2) * -(reach + WRIST_CENTRE_M),
        rotation: platform * turn_y(WRIST_MOUNT_RAD) * turn_z(*w1) * turn_y(*w2) * turn_z(*w3),
    }
}

/// Columns (linear; angular) of the geometric Jacobian, in axis order.
///
/// The tilts turn about y and about the platform's x, both through the base's origin, so they move the
/// flange at p by w × p; the reach moves it along −n; the wrist's three axes meet in the flange's origin.
pub(super) fn jacobian([ty, tx, reach, w1, w2, w3]: &[f64; 6]) -> [[f64; 6]; 6] {
    let column = |v: Vector3<f64>, w: Vector3<f64>| [v.x, v.y, v.z, w.x, w.y, w.z];
    let platform = platform(*ty, *tx);
    let away = -platform.column(2);
    let position = away * (reach + WRIST_CENTRE_M);
    let tilting = |axis: Vector3<f64>| column(axis.cross(&position), axis);
    let turning = |axis: Vector3<f64>| column(Vector3::zeros(), axis);
    let first = platform * turn_y(WRIST_MOUNT_RAD);
    let second = first * turn_z(*w1);
    let third = second * turn_y(*w2) * turn_z(*w3);
    [
        tilting(Vector3::y()),
        // turning about an axis leaves it where it is
        tilting(platform.column(0).into_owned()),
        column(away, Vector3::zeros()),
        turning(first.column(2).into_owned()),
        turning(second.column(1).into_owned()),
        turning(third.column(2).into_owned()),
    ]
}
