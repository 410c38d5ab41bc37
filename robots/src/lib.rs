//! What is moved: geometry, kinematics, transmissions, limits and constants of each robot.
//!
//! A robot is *data* ([`RobotDescription`]: one [`AxisDescription`] an axis) and *closed-form
//! kinematics* (the trait [`Robot`]). Nothing here keeps state, reads a clock or allocates; `libm`
//! everywhere, so host and microcontroller agree bit for bit.
//!
//! # The three spaces
//!
//! ```text
//!   Motors<N>  ──joints()──▶  Joints<N>  ──forward()──▶  Pose
//!   rad, shaft ◀─motors()───  rad or m   ◀─inverse()───  flange in the robot's base frame
//! ```
//!
//! - **motor**: angle of the motor shaft, rad; 0 where homing ended.
//! - **joint**: each link against the one before it (Denavit–Hartenberg relative), rad; m for a track.
//! - **gear coordinate**: what the gear of an axis really drives. With a parallelogram that is the
//!   angle of the link against the horizontal, not against the link before it ([`Reference`]).
//! - **flange**: the frame the tool is bolted to; columns of its rotation are N, O, A.
//!
//! # Example
//!
//! ```
//! use robots::{Irp6Postument, Joints, Robot};
//!
//! let robot = Irp6Postument;
//! let front = Joints([0.0, -1.57, 0.0, 1.56, 1.57, -1.57]);
//! let flange = robot.forward(&front);
//! let found = robot.inverse(&flange, &front)?;
//! let motors = robot.motors(&found.nearest())?;
//! robot.check_motors(&motors)?;
//! # Ok::<(), robots::KinematicError>(())
//! ```
#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    deny(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::indexing_slicing
    )
)]

mod along;
pub mod assumed;
mod conveyor;
pub mod description;
pub mod dynamics;
pub mod error;
mod gearing;
pub mod guard;
pub mod irp6;
mod jet;
mod narrow;
mod orientation;
mod planning;
pub mod polycrank;
mod quadratic;
mod registry;
pub mod report;
pub mod rnt;
mod robot;
mod screw;
mod slider;
mod sources;
mod space;
pub mod urdf;

pub use along::{JointsAlong, PoseAlong};
pub use assumed::{ASSUMED, Assumed};
pub use conveyor::Conveyor;
pub use description::{
    AxisDescription, AxisHoming, Gearing, JointKind, Range, Reference, RobotDescription,
};
pub use error::{KinematicError, Quantity};
pub use guard::JointGuard;
pub use irp6::{Irp6Arm, Irp6Gripper, Irp6Postument, Irp6Track, TrackRule};
pub use planning::{CURVATURE_SHARE, VELOCITY_SHARE, VelocityFactor};
pub use polycrank::Polycrank;
pub use quadratic::Quadratic;
pub use registry::{RobotKind, RobotVisitor, UnknownRobot};
pub use rnt::Rnt;
pub use robot::{Inverse, MAX_BRANCHES, Robot, distance};
pub use screw::{ScrewTriangle, Travel};
pub use sources::{Source, Sources};
pub use space::{JointMotion, Joints, MotorMotion, Motors};
