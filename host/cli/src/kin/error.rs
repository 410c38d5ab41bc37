//! How `mrroc kin` fails.

use std::fmt;
use std::io;

use process::{End, exit};
use robots::KinematicError;

use crate::jsonl::JsonlError;

/// Why `mrroc kin` failed.
#[derive(Debug)]
pub(crate) enum KinError {
    /// There is no such robot, or flags are missing or have the wrong number of values.
    Usage(String),
    /// The one case given by flags has no answer.
    NoAnswer(KinematicError),
    /// Lines were not all answered.
    Jsonl(JsonlError),
}

impl KinError {
    /// The process' exit code.
    pub(crate) fn exit_code(&self) -> u8 {
        match self {
            Self::Usage(_) => exit::USAGE,
            Self::NoAnswer(_) => exit::DATA,
            Self::Jsonl(error) => error.exit_code(),
        }
    }
}

impl fmt::Display for KinError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Usage(text) => f.write_str(text),
            Self::NoAnswer(error) => error.fmt(f),
            Self::Jsonl(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for KinError {}

impl From<KinError> for End {
    fn from(error: KinError) -> Self {
        Self::new(error.exit_code(), error.to_string())
    }
}

impl From<JsonlError> for KinError {
    fn from(error: JsonlError) -> Self {
        Self::Jsonl(error)
    }
}

impl From<io::Error> for KinError {
    fn from(error: io::Error) -> Self {
        Self::Jsonl(error.into())
    }
}
