//! How a run goes and ends.

use crate::mp::failure::Failure;
use crate::program::plan::PlanError;

/// Why a run ended in error.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RunError {
    /// The task cannot be run from where the robots are; nothing moved.
    #[error(transparent)]
    Plan(PlanError),
    /// A robot, a node or the operator ended it.
    #[error("{}{failure}", .step.as_ref().map_or_else(String::new, |step| format!("step \"{step}\": ")))]
    Failure {
        /// The step in which it happened.
        step: Option<String>,
        /// What happened.
        failure: Failure,
    },
}

impl RunError {
    /// The exit code of the program.
    #[must_use]
    pub const fn exit_code(&self) -> u8 {
        match self {
            Self::Plan(error) => error.exit_code(),
            Self::Failure { failure, .. } => failure.exit_code(),
        }
    }
}

/// What a run does.
#[derive(Clone, Debug, PartialEq)]
pub enum RunStatus {
    /// It goes on: call again.
    Running,
    /// The task is done, the robots are at rest and the leases given back.
    Done,
    /// It ended in error; the robots are at rest and the leases given back, as far as they answer.
    Failed(RunError),
}
