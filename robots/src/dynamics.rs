//! Rigid-body dynamics of the robots: torques of a motion, motion of torques, as joints and as motors
//! see them.
//!
//! A [`Chain`] is constant data: links with mass, centre and inertia, each on the one before it.
//! [`Chain::at`] takes the sines and cosines of joint positions once; the [`Posture`] it gives answers
//! everything else:
//!
//! | question | algorithm |
//! |---|---|
//! | [`Posture::inverse_dynamics`], [`Posture::gravity_torques`], [`Posture::bias_torques`] | recursive Newton–Euler |
//! | [`Posture::mass_matrix`] | composite rigid body |
//! | [`Posture::forward_dynamics`] | both, and a factorisation L·D·Lᵀ |
//! | [`Posture::link_poses`], [`Posture::flange`], [`Posture::jacobian`] | products of frames |
//! | [`Posture::kinetic_energy`], [`Posture::potential_energy`] | sums over the links |
//!
//! [`MotorModel`] answers the first as seen at the motors, in f32, for a microcontroller.
//!
//! Forces between joints and motors are in [`Transmission`], which [`Robot::transmission`](crate::Robot::transmission) gives. The chains of the robots: [`IRP6_TRACK`],
//! [`IRP6_POSTUMENT`], [`IRP6_ARM`], [`POLYCRANK`], [`rnt_chain`]. Their masses are [`ASSUMED`].
//!
//! ```
//! use nalgebra::Vector3;
//! use robots::Joints;
//! use robots::dynamics::{IRP6_POSTUMENT, STANDARD_GRAVITY};
//!
//! let upright = IRP6_POSTUMENT.at(&Joints([0.0, -1.57, 0.0, 0.0, 0.0, 0.0]));
//! let hold = upright.gravity_torques(&STANDARD_GRAVITY);
//! assert!(hold[0].abs() < 1e-9, "gravity does not turn the column");
//! ```

mod algebra;
mod assumed;
mod body;
mod chain;
mod forward;
mod inverse;
mod irp6;
mod legs;
mod model;
mod polycrank;
mod rnt;
mod transmission;

use nalgebra::Vector3;

pub use assumed::ASSUMED;
pub use body::{Body, Inertia, Shape};
pub use chain::{Chain, Link, Placement, Posture};
pub use inverse::Wrench;
pub use irp6::{IRP6_ARM, IRP6_POSTUMENT, IRP6_TRACK};
pub(crate) use legs::Legs;
pub use model::MotorModel;
pub use polycrank::POLYCRANK;
pub use rnt::rnt_chain;
pub use transmission::{Transmission, joints_by_motors};

/// Standard gravity where z is up, m/s² (CGPM 1901).
pub const STANDARD_GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -9.806_65);
