//! How every command of this project ends: a documented exit code, and one line that says why.
//!
//! | module | one line |
//! |---|---|
//! | [`exit`] | the exit codes |
//! | [`End`] | why a process ends, other than as it should |
#![forbid(unsafe_code)]

#[cfg(feature = "clap")]
mod command_line;
mod end;
pub mod exit;

pub use end::End;
