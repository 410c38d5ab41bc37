//! How `mrroc plan` fails.

use std::fmt;
use std::io;

use process::{End, exit};

use super::motion::NoMotion;
use crate::jsonl::JsonlError;

/// Why `mrroc plan` failed.
#[derive(Debug)]
pub(crate) enum PlanError {
    /// Flags are missing, or have the wrong number of values or impossible ones.
    Usage(String),
    /// There is no motion as the flags ask for it.
    NoMotion(String),
    /// The checker refuses what the planner made: what, and in how many lines if there are lines.
    Unproved {
        /// How many motions.
        motions: usize,
        /// What the first is.
        what: String,
    },
    /// Lines were not all answered.
    Jsonl(JsonlError),
    /// The node would refuse the path, here or on the way: nothing would move beyond.
    Refused(String),
    /// A file cannot be read, or the picture cannot be written.
    Host(host::error::Error),
}

impl PlanError {
    /// The process' exit code.
    pub(crate) fn exit_code(&self) -> u8 {
        match self {
            Self::Usage(_) => exit::USAGE,
            Self::NoMotion(_) => exit::DATA,
            Self::Refused(_) => exit::REFUSED,
            Self::Unproved { .. } => exit::INTERNAL,
            Self::Jsonl(error) => error.exit_code(),
            Self::Host(error) => error.exit_code(),
        }
    }
}

impl fmt::Display for PlanError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Usage(text) | Self::NoMotion(text) | Self::Refused(text) => f.write_str(text),
            Self::Unproved { motions: 1, what } => f.write_str(what),
            Self::Unproved { motions, what } => {
                write!(f, "{motions} motions are wrong, the first: {what}")
            }
            Self::Jsonl(error) => error.fmt(f),
            Self::Host(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for PlanError {}

impl From<PlanError> for End {
    fn from(error: PlanError) -> Self {
        Self::new(error.exit_code(), error.to_string())
    }
}

impl From<NoMotion> for PlanError {
    fn from(error: NoMotion) -> Self {
        let what = error.to_string();
        match error {
            NoMotion::Refused(_) => Self::NoMotion(what),
            NoMotion::Unproved { .. } => Self::Unproved { motions: 1, what },
        }
    }
}

impl From<JsonlError> for PlanError {
    fn from(error: JsonlError) -> Self {
        Self::Jsonl(error)
    }
}

impl From<io::Error> for PlanError {
    fn from(error: io::Error) -> Self {
        Self::Jsonl(error.into())
    }
}

impl From<host::error::Error> for PlanError {
    fn from(error: host::error::Error) -> Self {
        Self::Host(error)
    }
}
