//! What the tests across crates share. Whoever looks on here decodes frames by its own few lines,
//! from the documents of the wires: a mistake of the product must not hide itself.
//!
//! | module | one line |
//! |---|---|
//! | [`binary`] | the operator's command, built once and run as a process |
//! | [`coordinator`] | an MP of a few lines, to command one robot in lock step |
//! | [`job`] | a whole task in this process, looked on |
//! | [`stalls`] | scenarios in real time, on a machine that others use too |
//! | [`watch`] | the independent observer of set-points: limits by finite differences |
//! | [`digest`] | a record as one number |
//! | [`emulator`] | the node on an emulated microcontroller |
#![forbid(unsafe_code)]

pub mod binary;
pub mod coordinator;
pub mod digest;
pub mod emulator;
pub mod job;
pub mod stalls;
pub mod watch;

use std::path::{Path, PathBuf};

/// The root of the workspace.
#[must_use]
pub fn workspace() -> PathBuf {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR"));
    tests
        .parent()
        .map_or_else(|| tests.to_path_buf(), Path::to_path_buf)
}
