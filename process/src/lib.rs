//! How every command of this project begins and ends: real-time priority for those who ask for it, how late it was,
//! a documented exit code, and one line that says why.
//!
//! | module | one line |
//! |---|---|
//! | [`exit`] | the exit codes |
//! | [`take_priority`] | `SCHED_FIFO` and locked memory |
//! | [`Lateness`] | how late it was called |
//! | [`End`] | why a process ends, other than as it should |
#![forbid(unsafe_code)]

#[cfg(feature = "clap")]
mod command_line;
mod end;
pub mod exit;
mod lateness;
mod priority;

pub use end::End;
pub use lateness::Lateness;
pub use priority::take_priority;
