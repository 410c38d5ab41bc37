//! A JSON object a line in, one a line out.
//!
//! A line that cannot be read is answered with `{"error":"malformed",…}`, the rest is still done, and
//! the first of them is told at the end.

use std::fmt;
use std::io::{self, BufRead, Write};

use process::exit;
use serde::Serialize;

/// Why lines were not all answered.
#[derive(Debug)]
pub(crate) enum JsonlError {
    /// Lines of stdin could not be read as cases.
    Malformed {
        /// How many.
        lines: usize,
        /// The first of them, counted from 1.
        first: usize,
        /// What was expected there and what was found.
        what: String,
    },
    /// stdin or stdout failed.
    Stream(io::Error),
}

impl JsonlError {
    /// The process' exit code.
    pub(crate) fn exit_code(&self) -> u8 {
        match self {
            Self::Malformed { .. } => exit::DATA,
            Self::Stream(_) => exit::IO,
        }
    }
}

impl fmt::Display for JsonlError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Malformed {
                lines: 1,
                first,
                what,
            } => write!(f, "line {first} of stdin: {what}"),
            Self::Malformed { lines, first, what } => write!(
                f,
                "{lines} lines of stdin are malformed, the first is line {first}: {what}"
            ),
            Self::Stream(error) => write!(f, "stdin or stdout: {error}"),
        }
    }
}

impl std::error::Error for JsonlError {}

impl From<io::Error> for JsonlError {
    fn from(error: io::Error) -> Self {
        Self::Stream(error)
    }
}

/// The answer to a line that cannot be read.
#[derive(Serialize)]
struct Unread {
    error: &'static str,
    message: String,
}

/// Answers every line; `answer` says of a line that cannot be read what is wrong with it.
///
/// # Errors
/// [`JsonlError`]; malformed lines are reported after the last one.
pub(crate) fn each_line<A: Serialize>(
    out: &mut dyn Write,
    input: &mut dyn BufRead,
    mut answer: impl FnMut(&[u8]) -> Result<A, String>,
) -> Result<(), JsonlError> {
    let mut malformed: Option<(usize, usize, String)> = None;
    let mut line = Vec::new();
    for number in 1.. {
        line.clear();
        if input.read_until(b'\n', &mut line)? == 0 {
            break;
        }
        match answer(&line) {
            Ok(answer) => write_line(out, &answer)?,
            Err(what) => {
                let unread = Unread {
                    error: "malformed",
                    message: format!("line {number} of stdin: {what}"),
                };
                write_line(out, &unread)?;
                let (count, first, text) = malformed.unwrap_or((0, number, what));
                malformed = Some((count + 1, first, text));
            }
        }
    }
    out.flush()?;
    match malformed {
        Some((lines, first, what)) => Err(JsonlError::Malformed { lines, first, what }),
        None => Ok(()),
    }
}

/// Writes one JSON value and the end of the line.
///
/// # Errors
/// `out` cannot be written.
pub(crate) fn write_line(out: &mut dyn Write, answer: &impl Serialize) -> io::Result<()> {
    serde_json::to_writer(&mut *out, answer)?;
    out.write_all(b"\n")
}
