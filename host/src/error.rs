//! What can go wrong on the host, and the exit code that tells it to scripts.
//!
//! Every error prints as one line.

use crate::input::{DataError, InputError, LoadError, Problem};
use process::End;
use protocol::fault::{Fault, Refusal};
use protocol::maintenance::MaintenanceRefusal;
use std::io;
use std::path::{Path, PathBuf};

pub(crate) mod text;

pub use process::exit;
pub use text::{fault_text, refusal_text};

/// An error of the host library.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The command line asks for what there is not.
    #[error("{what} (expected {expected}, got {got})")]
    Usage {
        /// What is wrong.
        what: String,
        /// What was expected.
        expected: String,
        /// What was given.
        got: String,
    },
    /// A file has wrong contents.
    #[error(transparent)]
    Data(#[from] DataError),
    /// A file cannot be read.
    #[error(transparent)]
    Input(#[from] InputError),
    /// A file cannot be created.
    #[error("{}: error: cannot create the file: {source}", path.display())]
    Create {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// Writing to a file failed.
    #[error("{}: error: cannot write: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A bus cannot be opened, or has gone.
    #[error("bus {bus}: {reason}")]
    Bus {
        /// Its name.
        bus: String,
        /// What the transport says.
        reason: String,
    },
    /// A node does not answer.
    #[error("{robot}: no answer from its node (expected one in {waited_ms} ms, got none)")]
    Silent {
        /// The robot.
        robot: String,
        /// How long the MP waited.
        waited_ms: u32,
    },
    /// Another MP holds the lease.
    #[error("{robot}: commanded by another MP, node {holder}; stop that one or try again later")]
    LeaseHeld {
        /// The robot.
        robot: String,
        /// Node id of the holder.
        holder: u8,
    },
    /// A node speaks another protocol.
    #[error("{robot}: its node has another {what} (expected {expected}, got {got})")]
    Protocol {
        /// The robot.
        robot: String,
        /// Version, schema hash, …
        what: &'static str,
        /// Ours.
        expected: String,
        /// Its.
        got: String,
    },
    /// A node is not what the cell says.
    #[error("{robot}: its node has another {what} than the cell (expected {expected}, got {got})")]
    Cell {
        /// The robot.
        robot: String,
        /// Name, number of axes, configuration, …
        what: &'static str,
        /// The cell's.
        expected: String,
        /// The node's.
        got: String,
    },
    /// A node refused an instruction; nothing moved for it.
    #[error(
        "{}{robot}: refused, nothing moved: {}",
        Step(step),
        refusal_text(refusal)
    )]
    Refused {
        /// The robot.
        robot: String,
        /// The step of the task, if there is one.
        step: Option<String>,
        /// The node's reason.
        refusal: Refusal,
    },
    /// A node refused what was asked of its keeper; nothing changed.
    #[error("{robot}: refused: {refusal}")]
    Maintenance {
        /// The robot.
        robot: String,
        /// The node's reason.
        refusal: MaintenanceRefusal,
    },
    /// A fault ended the motion.
    #[error("{}{robot}: {}", Step(step), fault_text(fault))]
    Fault {
        /// The robot.
        robot: String,
        /// The step of the task, if there is one.
        step: Option<String>,
        /// What its node latched.
        fault: Fault,
    },
    /// Stopped by the operator, at rest.
    #[error("{}stopped by the operator", Step(step))]
    Stopped {
        /// The step of the task, if there is one.
        step: Option<String>,
    },
    /// What cannot be, if this program is right.
    #[error("internal error: {0}; please report it")]
    Internal(String),
}

impl From<Error> for End {
    fn from(error: Error) -> Self {
        Self::new(error.exit_code(), error.to_string())
    }
}

impl From<LoadError> for Error {
    fn from(error: LoadError) -> Self {
        match error {
            LoadError::Input(error) => Self::Input(error),
            LoadError::Data(error) => Self::Data(error),
        }
    }
}

impl Error {
    /// A file that could not be created.
    #[must_use]
    pub fn create(path: &Path, source: io::Error) -> Self {
        Self::Create {
            path: path.to_path_buf(),
            source,
        }
    }

    /// A file that could not be written.
    #[must_use]
    pub fn write(path: &Path, source: io::Error) -> Self {
        Self::Write {
            path: path.to_path_buf(),
            source,
        }
    }

    /// The exit code: one of [`exit`].
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Usage { .. } => exit::USAGE,
            Self::Data(error) if error.problem == Problem::Unreadable => exit::NO_INPUT,
            Self::Data(_) => exit::DATA,
            Self::Input(error) => match error {
                InputError::Absent(_) | InputError::NotAFile(_) => exit::NO_INPUT,
                InputError::Refused(_) => exit::PERMISSION,
                InputError::TooLarge(..) | InputError::NotText(..) => exit::DATA,
                InputError::Io(..) => exit::IO,
            },
            Self::Create { source, .. } if source.kind() == io::ErrorKind::PermissionDenied => {
                exit::PERMISSION
            }
            Self::Create { .. } => exit::CANNOT_CREATE,
            Self::Write { .. } => exit::IO,
            Self::Bus { .. } | Self::Silent { .. } => exit::UNAVAILABLE,
            Self::LeaseHeld { .. } => exit::TEMPORARY,
            Self::Protocol { .. } => exit::PROTOCOL,
            Self::Cell { .. } => exit::CONFIG,
            Self::Refused { refusal, .. } => match refusal {
                Refusal::LeaseHeld { .. } | Refusal::NoLease { .. } => exit::TEMPORARY,
                _ => exit::REFUSED,
            },
            Self::Maintenance { refusal, .. } => match refusal {
                MaintenanceRefusal::NoLease { .. } => exit::TEMPORARY,
                MaintenanceRefusal::WrongRobot | MaintenanceRefusal::WrongTarget => exit::CONFIG,
                MaintenanceRefusal::WrongLength { .. } | MaintenanceRefusal::WrongCrc { .. } => {
                    exit::DATA
                }
                MaintenanceRefusal::Storage => exit::IO,
                _ => exit::REFUSED,
            },
            Self::Fault { .. } => exit::FAULT,
            Self::Stopped { .. } => exit::STOPPED,
            Self::Internal(_) => exit::INTERNAL,
        }
    }
}

/// The step as a prefix.
struct Step<'a>(&'a Option<String>);

impl std::fmt::Display for Step<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.0 {
            Some(step) => write!(f, "step `{}`: ", step.escape_debug()),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod test {
    use super::*;
    use protocol::fault::{Cause, Quantity};
    use protocol::message::NodeState;

    fn samples() -> Vec<Error> {
        let name = || "irp6-track".to_owned();
        let io = |kind| io::Error::from(kind);
        let path = PathBuf::from("x");
        let data = |problem| {
            Error::Data(DataError {
                path: None,
                line: 1,
                column: 2,
                problem,
                what: "w".into(),
                expected: "e".into(),
                got: "g".into(),
            })
        };
        let refused = |refusal| Error::Refused {
            robot: name(),
            step: Some("a\nb".into()),
            refusal,
        };
        vec![
            Error::Usage {
                what: "unknown robot".into(),
                expected: "`irp6-track`".into(),
                got: "`x`".into(),
            },
            data(Problem::Syntax),
            data(Problem::Unreadable),
            Error::Input(InputError::Refused(path.clone())),
            Error::create(&path, io(io::ErrorKind::NotFound)),
            Error::write(&path, io(io::ErrorKind::StorageFull)),
            Error::Bus {
                bus: "vcan0".into(),
                reason: "no such interface".into(),
            },
            Error::Silent {
                robot: name(),
                waited_ms: 500,
            },
            Error::LeaseHeld {
                robot: name(),
                holder: 1,
            },
            Error::Protocol {
                robot: name(),
                what: "schema hash",
                expected: "1".into(),
                got: "2".into(),
            },
            Error::Cell {
                robot: name(),
                what: "number of axes",
                expected: "7".into(),
                got: "6".into(),
            },
            refused(Refusal::Limit {
                axis: 0,
                quantity: Quantity::JointPosition,
                value: 2.0,
                limit: 1.21,
            }),
            refused(Refusal::Unreachable),
            Error::Fault {
                robot: name(),
                step: None,
                fault: Fault {
                    cause: Cause::LeaseExpired,
                    axis: Some(2),
                    step: 99,
                    during: NodeState::Moving,
                },
            },
            Error::Stopped { step: None },
            Error::Internal("x".into()),
            Error::Maintenance {
                robot: name(),
                refusal: MaintenanceRefusal::WrongCrc { got: 0xCAFE },
            },
        ]
    }

    #[test]
    fn every_error_is_one_line() {
        for error in samples() {
            assert!(!error.to_string().contains('\n'), "{error}");
        }
        let texts: Vec<_> = samples().iter().map(ToString::to_string).collect();
        assert!(
            texts[11].contains(
                "axis 1 would break its JointPosition limit (expected at most 1.21, got 2)"
            ),
            "{}",
            texts[11]
        );
        assert_eq!(
            texts[13],
            "irp6-track: fault 10 on axis 3 while Moving, servo step 99: the MP's lease expired: no valid cyclic message in time"
        );
    }

    #[test]
    fn every_code_is_given_by_some_error() {
        let given: Vec<u8> = samples().iter().map(Error::exit_code).collect();
        let codes = exit::ALL.into_iter().map(|(code, _)| code);
        // a difference is a result
        for code in codes.filter(|code| ![exit::OK, exit::DIFFERENT].contains(code)) {
            assert!(given.contains(&code), "no error gives {code}");
        }
    }
}
