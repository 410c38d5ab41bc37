//! How it moves: poses, interpolation between knots, jerk-limited profiles, paths.
//!
//! Pure functions of time; no allocation, no panic; libm everywhere, so host and MCU agree bit for bit.
//!
//! | module | what |
//! |---|---|
//! | [`angle`] | a position in fixed point: what a servo step computes with |
//! | [`pose`] | the pose of one frame in another, rotation vectors |
//! | [`mod@line`] | the straight line between two poses, turning about one axis |
//! | [`twist`] | the derivative of a pose |
//! | [`path`] | tool paths with exact derivatives: lines, arcs, blended corners, curves through points |
//! | [`profile`] | time-optimal jerk-limited motion between any states, and its checker |
//! | [`feed`] | jerk-limited speed along a path, from a stream of samples of its derivatives |
//! | [`knot`] | what an interpolator is asked to pass through, and may be asked |
//! | [`interpolator`] | from knots to set-points at a fixed step, always able to stop |
//!
//! A motion is planned, sampled into knots, and interpolated:
//!
//! ```
//! use motion::interpolator::{Braking, PathLimits};
//! use motion::profile::PhaseSynchronised;
//! use motion::{Angle, AxisEnvelope, AxisLimits, Interpolator, Knot, Status};
//! let hard = AxisLimits { v: 2.0, a: 20.0, j: 1000.0 };
//! let axes = [AxisEnvelope::new(-3.0, 3.0, hard); 2];
//! let limits = axes.map(|axis| axis.for_planning(20_000));
//! let plan = PhaseSynchronised::new([0.0, 0.0], [1.0, -0.5], &limits)?;
//!
//! let path = PathLimits::new(axes)?;
//! let mut edp = Interpolator::<2, 4>::new(Braking::new(&axes));
//! edp.hold_anew(&path.ranges(), [Angle::ZERO; 2]);
//! edp.start(0)?;
//! let mut next_us = 0;
//! for now_us in (0..).step_by(2_000) {
//!     while edp.room() > 0 && (next_us as f64) < plan.duration() * 1e6 {
//!         next_us += 20_000;
//!         let state = plan.at(next_us as f64 * 1e-6);
//!         let knot = Knot {
//!             at_us: next_us,
//!             position: state.map(|axis| axis.p),
//!             velocity: state.map(|axis| axis.v),
//!             acceleration: Some(state.map(|axis| axis.a)),
//!         };
//!         let made = path.piece(&edp.tip(), &knot)?;
//!         edp.push(&made.piece, now_us)?;
//!     }
//!     let output = edp.step(now_us);
//!     if output.status == Status::Idle {
//!         assert_eq!(output.setpoint.position.map(Angle::to_f64), [1.0, -0.5]);
//!         break;
//!     }
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
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

pub mod angle;
pub mod feed;
pub mod interpolator;
pub mod knot;
pub mod line;
pub mod path;
mod polynomial;
pub mod pose;
pub mod profile;
pub mod ramp;
mod scalar;
pub mod twist;

pub use angle::Angle;
pub use interpolator::{Interpolator, Output, Status};
pub use knot::{AxisEnvelope, Knot, Setpoint};
pub use line::Line;
pub use pose::Pose;
pub use profile::AxisLimits;
pub use twist::Twist;
