//! Rotations as they are given to an inverse, and angles as it gives them back.

use core::f64::consts::TAU;

use nalgebra::Matrix3;

use crate::error::KinematicError;
use crate::gearing::finite;

/// A whole turn, rad.
pub(crate) const TURN: f64 = TAU;
/// Greatest deviation of `RᵀR` from I that still counts as a rotation written with few digits.
const ROTATION_SLACK: f64 = 1e-6;

/// The nearest rotation, or an error when there is none near.
pub(crate) fn orthonormal(r: &Matrix3<f64>) -> Result<Matrix3<f64>, KinematicError> {
    finite(r.as_slice())?;
    let off = r.transpose() * r - Matrix3::identity();
    let deviation = off.iter().fold(
        0.0,
        |most: f64, v| if v.abs() > most { v.abs() } else { most },
    );
    let near = off.iter().all(|v| v.abs() <= ROTATION_SLACK);
    if !near {
        return Err(KinematicError::NotARotation { deviation });
    }
    if r.column(0).cross(&r.column(1)).dot(&r.column(2)) < 0.0 {
        return Err(KinematicError::NotARotation { deviation: 2.0 });
    }
    // one Newton step towards the polar factor: what is left of the deviation is its square
    Ok(r * (Matrix3::identity() - off * 0.5))
}

/// `angle` plus the whole number of turns that brings it nearest to `to`.
pub(crate) fn wrapped(angle: f64, to: f64) -> f64 {
    let off = angle - to;
    if libm::fabs(off) < 0.5 * TURN {
        return angle;
    }
    angle - TURN * libm::round(off / TURN)
}
