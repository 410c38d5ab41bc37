//! How `mrroc kin` fails.

use std::fmt;
use std::io;

use process::{End, exit};
use robots::KinematicError;

/// Why `mrroc kin` failed.
#[derive(Debug)]
pub(crate) enum KinError {
    /// There is no such robot, or flags are missing or have the wrong number of values.
    Usage(String),
    /// Lines of stdin could not be read as cases.
    Malformed {
        /// How many.
        lines: usize,
        /// The first of them, counted from 1.
        first: usize,
        /// What was expected there and what was found.
        what: String,
    },
    /// The one case given by flags has no answer.
    NoAnswer(KinematicError),
    /// stdin or stdout failed.
    Stream(io::Error),
}

impl KinError {
    /// The process' exit code.
    pub(crate) fn exit_code(&self) -> u8 {
        match self {
            Self::Usage(_) => exit::USAGE,
            Self::Malformed { .. } | Self::NoAnswer(_) => exit::DATA,
            Self::Stream(_) => exit::IO,
        }
    }
}

impl fmt::Display for KinError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Usage(text) => f.write_str(text),
            Self::Malformed {
                lines: 1,
                first,
                what,
            } => write!(f, "line {first} of stdin: {what}"),
            Self::Malformed { lines, first, what } => {
                write!(
                    f,
                    "{lines} lines of stdin are malformed, the first is line {first}: {what}"
                )
            }
            Self::NoAnswer(error) => error.fmt(f),
            Self::Stream(error) => write!(f, "stdin or stdout: {error}"),
        }
    }
}

impl std::error::Error for KinError {}

impl From<KinError> for End {
    fn from(error: KinError) -> Self {
        Self::new(error.exit_code(), error.to_string())
    }
}

impl From<io::Error> for KinError {
    fn from(error: io::Error) -> Self {
        Self::Stream(error)
    }
}
