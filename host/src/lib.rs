//! Under construction.
#![forbid(unsafe_code)]

pub mod error;
pub mod input;
pub mod instruct;
pub mod task;
pub mod trj;
