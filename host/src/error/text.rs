//! What nodes say, in words.

use protocol::fault::{Fault, PathProblem, Refusal};

/// A fault in one line; axes are counted from 1 for people.
#[must_use]
pub fn fault_text(fault: &Fault) -> String {
    let axis = fault.axis.map_or_else(String::new, |axis| {
        format!(" on axis {}", u16::from(axis) + 1)
    });
    format!(
        "fault {}{axis} while {:?}, servo step {}: {}",
        fault.cause.code(),
        fault.during,
        fault.step,
        fault.cause.text()
    )
}

/// A refusal in one line; axes are counted from 1 for people.
#[must_use]
pub fn refusal_text(refusal: &Refusal) -> String {
    let number = |index: u8| u16::from(index) + 1;
    match refusal {
        Refusal::LeaseHeld { holder } => format!("node {holder} holds the command lease"),
        Refusal::NoLease { epoch } => {
            format!("the command lease is not ours (epoch {epoch} is valid)")
        }
        Refusal::WrongState { state } => format!("not possible while {state:?}"),
        Refusal::NotSynchronised => {
            "not homed: only relative moves of the motors are possible".into()
        }
        Refusal::FaultLatched { cause } => {
            format!("fault {} is latched: {}", cause.code(), cause.text())
        }
        Refusal::CausePresent { cause } => {
            format!("fault {} is still present: {}", cause.code(), cause.text())
        }
        Refusal::AxisCount { expected, got } => {
            format!("wrong number of axes (expected {expected}, got {got})")
        }
        Refusal::NotFinite { index } => {
            format!("value {} is not a finite number", number(*index))
        }
        Refusal::OutOfRange {
            index,
            value,
            lower,
            upper,
        } => format!(
            "value {} out of range (expected {lower} to {upper}, got {value})",
            number(*index)
        ),
        Refusal::Limit {
            axis,
            quantity,
            value,
            limit,
        } => format!(
            "axis {} would break its {quantity:?} limit (expected at most {limit}, got {value})",
            number(*axis)
        ),
        Refusal::Unreachable => "the pose, or one on the way, is outside the workspace".into(),
        Refusal::Singular => "the way passes a singular pose".into(),
        Refusal::Stale { last } => format!("an old command (the last was {last})"),
        Refusal::Late => "the start time has passed".into(),
        Refusal::QueueFull => "no room in the node's queue".into(),
        Refusal::NotMonotone => "the times of the knots do not increase".into(),
        Refusal::Discontinuous { axis } => format!(
            "the first knot does not continue the present state of axis {}",
            number(*axis)
        ),
        Refusal::UnknownProgram { program } => {
            format!("no program {program} is linked into the node")
        }
        Refusal::UnknownServoLaw => "the node does not have this servo law".into(),
        Refusal::NoForce => "there is no force sensor that can be read".into(),
        Refusal::Aborted => "ended by a stop or a fault before it was complete".into(),
        Refusal::Path { element, problem } => {
            format!("element {element} of the path: {}", path_problem(*problem))
        }
    }
}

/// What is wrong with an element of a path.
pub(crate) fn path_problem(problem: PathProblem) -> &'static str {
    match problem {
        PathProblem::NotFinite => "a number of it is not finite, or far too large",
        PathProblem::NoLength => "it goes nowhere",
        PathProblem::NotAnArc => "no arc goes through its three points",
        PathProblem::TurnTooLarge => {
            "it turns the tool by more than a radian from the point before"
        }
        PathProblem::Corner => "its corner cannot be rounded within the tolerance",
        PathProblem::Feed => "its feed is not a finite number greater than 0",
    }
}
