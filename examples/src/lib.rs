//! What every example runs on: a Master Process and a simulated cell on one virtual clock.
//!
//! | item | one line |
//! |---|---|
//! | [`Arm`] | a simulated arm whose node has programs of the user linked in |
//! | [`World`] | arms, their drives and mechanics, the buses, and the Master Process |
//! | [`nod()`] | a motion as a function of time, for the first two examples |
//! | [`summary`], [`apart`] | what is said about a recorded joint |
//!
//! The examples themselves are in `examples/examples`, numbered, smallest first.
#![forbid(unsafe_code)]

mod curve;
mod nod;
mod world;

pub use curve::{apart, summary};
pub use nod::{DURATION_S, STEP_S, WRIST, nod};
pub use world::{Arm, World};
