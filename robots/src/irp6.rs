//! The IRp-6: on its track, on its postument, with five axes, and the grippers of the first two.
//!
//! # Geometry
//!
//! Frame of the base: origin at the shoulder's height on the column's axis, x forward, y along the
//! track, z up. With X, Y, Z the turns about the axes, Y(t) takes x to (cos t, 0, −sin t): an angle t
//! of a link in the arm's plane counts *downwards* from the horizontal.
//!
//! ```text
//!   t1 = q1                     column, about z
//!   t2 = q2                     lower arm a2
//!   t3 = q3 + t2 + π/2          upper arm a3
//!   t4 = q4 + t3                wrist pitch T, link d5
//!   t5 = q5                     wrist V, about d5
//!   t6 = q6                     flange N, about its own A
//! ```
//!
//! T, V and N: three turns about y, x and y again,
//!
//! ```text
//!   R = Z(t1)·Y(t4)·X(t5)·Y(t6)·Π,   Π = columns (z, x, y)
//!   p = Z(t1)·(r, 0, h) + (0, d0, 0)
//!   r = a2·cos t2 + a3·cos t3 + d5·cos t4
//!   h = −(a2·sin t2 + a3·sin t3 + d5·sin t4)
//! ```
//!
//! with d0 the track's position (0 on the postument). At t4 = t5 = t6 = 0 the flange's A is along y.

pub(crate) mod arm;
pub(crate) mod data;
mod five;
mod gripper;
pub(crate) mod inverse;
mod postument;
mod track;

pub use five::Irp6Arm;
pub use gripper::Irp6Gripper;
pub use postument::Irp6Postument;
pub use track::{BEND_M, Irp6Track, TrackRule};
