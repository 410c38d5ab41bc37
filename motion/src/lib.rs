//! How it moves: poses, interpolation between knots, jerk-limited profiles, paths.
//!
//! Pure functions of time; no allocation; libm everywhere, so host and MCU agree bit for bit.
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

pub mod interpolator;
pub mod knot;
pub mod line;
mod polynomial;
pub mod pose;
pub mod profile;
mod ramp;
mod scalar;

pub use interpolator::{Interpolator, Output, Status};
pub use knot::{AxisEnvelope, Knot, Setpoint};
pub use line::{Line, Twist};
pub use pose::Pose;
