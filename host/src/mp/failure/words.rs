//! Failures in words, one line each.

use super::{Awaited, Failure, Who};
use crate::error::text::path_problem;
use core::fmt;
use protocol::fault::{Fault, Refusal};

/// A span for people: `2.0 s`.
fn seconds(span_ms: u32) -> String {
    format!("{:.1} s", f64::from(span_ms) * 1e-3)
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Refused {
                who,
                asked,
                refusal: Refusal::LeaseHeld { holder },
            } => write!(
                f,
                "{who} refuses {asked}: node {holder} holds the command lease; end the other program, or take over at standstill"
            ),
            Self::Refused {
                who,
                asked,
                refusal,
            } => {
                write!(f, "{who} refuses {asked}: {}", Shown(refusal))
            }
            Self::Unanswered { who, asked, tries } => write!(
                f,
                "{who} does not answer {asked}: no reply to {tries} requests; is the bus overloaded or cut?"
            ),
            Self::TimedOut {
                who,
                awaited,
                span_ms,
                seen,
            } => awaited.missed(f, who, *span_ms, seen),
            Self::Mismatch {
                who,
                item,
                expected,
                got,
                hint,
            } => {
                write!(
                    f,
                    "{who}: {item} differs (expected {expected}, got {got}); {hint}"
                )
            }
            Self::Fault { who, fault, axis } => fault_line(f, who, fault, *axis),
            Self::Lost { who, span_ms } => write!(
                f,
                "{who} is lost: no feedback for {}; did its process or its bus end?",
                seconds(*span_ms)
            ),
            Self::LeaseLost { who, epoch: 0 } => write!(
                f,
                "{who}: the command lease expired; was this program halted for longer than the lease?"
            ),
            Self::LeaseLost { who, epoch } => {
                write!(
                    f,
                    "{who}: another coordinator took the command lease (epoch {epoch})"
                )
            }
            Self::Instruction { who, refusal } => {
                write!(f, "{who}: the instruction failed: {}", Shown(refusal))
            }
            Self::Kinematics { who, at, error } => write!(f, "{who}: {at}: {error}"),
            Self::TooFast {
                who,
                axis,
                times,
                quantity,
            } => write!(
                f,
                "{who}: {quantity} of {axis} would be {times:.2} times its ceiling; allow more time"
            ),
            Self::SensorStale { sensor } => write!(f, "virtual sensor {sensor} is stale"),
            Self::Stopped { kind } => write!(f, "stopped by the operator ({kind:?})"),
        }
    }
}

fn fault_line(
    f: &mut fmt::Formatter<'_>,
    who: &Who,
    fault: &Fault,
    axis: Option<&'static str>,
) -> fmt::Result {
    write!(
        f,
        "{who}: fault {}: {}",
        fault.cause.code(),
        fault.cause.text()
    )?;
    if let (Some(index), Some(name)) = (fault.axis, axis) {
        write!(f, ", axis {} ({name})", u32::from(index) + 1)?;
    }
    write!(f, ", in servo step {} while {:?}", fault.step, fault.during)
}

impl Awaited {
    /// That it did not come about, and what may be the reason.
    fn missed(
        self,
        f: &mut fmt::Formatter<'_>,
        who: &Who,
        span_ms: u32,
        seen: &str,
    ) -> fmt::Result {
        let span = seconds(span_ms);
        match self {
            Self::Identity => write!(
                f,
                "{who} does not answer Identify: no frame in {span}; is mrroc-node running on this bus?"
            ),
            Self::Drives => write!(
                f,
                "{who} does not get its drives ready in {span} ({seen}); are the drives powered and on the node's drive bus?"
            ),
            Self::Torque => write!(
                f,
                "{who} does not switch torque on in {span} ({seen}); is the emergency stop released?"
            ),
            Self::Homing => write!(f, "{who} is not homed after {span} ({seen})"),
            Self::Rest => write!(f, "{who} is not at rest {span} after a stop ({seen})"),
        }
    }
}

/// A refusal in words.
struct Shown<'a>(&'a Refusal);

impl fmt::Display for Shown<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let axis = |axis: u8| u32::from(axis) + 1;
        match *self.0 {
            Refusal::LeaseHeld { holder } => write!(f, "node {holder} holds the lease"),
            Refusal::NoLease { epoch } => write!(f, "no lease (the valid epoch is {epoch})"),
            Refusal::WrongState { state } => write!(f, "not allowed while {state:?}"),
            Refusal::NotSynchronised => {
                f.write_str("not homed: only relative motor moves are allowed")
            }
            Refusal::FaultLatched { cause } => {
                write!(
                    f,
                    "a fault is latched ({}); acknowledge it first",
                    cause.text()
                )
            }
            Refusal::CausePresent { cause } => {
                write!(
                    f,
                    "the cause of the fault is still present ({})",
                    cause.text()
                )
            }
            Refusal::AxisCount { expected, got } => {
                write!(f, "wrong number of axes (expected {expected}, got {got})")
            }
            Refusal::NotFinite { index } => write!(f, "value {} is no number", axis(index)),
            Refusal::OutOfRange {
                index,
                value,
                lower,
                upper,
            } => write!(
                f,
                "value {} out of range (expected {lower} to {upper}, got {value})",
                axis(index)
            ),
            Refusal::Limit {
                axis: k,
                quantity,
                value,
                limit,
            } => write!(
                f,
                "{quantity:?} of axis {} would be {value}, the limit is {limit}",
                axis(k)
            ),
            Refusal::Unreachable => f.write_str("the pose, or one on the way, is out of reach"),
            Refusal::Singular => f.write_str("the way passes a singular pose"),
            Refusal::Stale { last } => write!(f, "its number was used before (last {last})"),
            Refusal::Late => f.write_str("its time has passed"),
            Refusal::QueueFull => f.write_str("no room in the queue"),
            Refusal::NotMonotone => f.write_str("the knots' times do not increase"),
            Refusal::Discontinuous { axis: k } => {
                write!(
                    f,
                    "the first knot does not continue the present state of axis {}",
                    axis(k)
                )
            }
            Refusal::UnknownProgram { program } => {
                write!(f, "program {program} is not linked into this node")
            }
            Refusal::UnknownServoLaw => f.write_str("unknown servo law"),
            Refusal::NoForce => f.write_str("there is no force sensor that can be read"),
            Refusal::Aborted => f.write_str("ended by a stop or a fault"),
            Refusal::Path { element, problem } => {
                write!(
                    f,
                    "element {element} of the path: {}",
                    path_problem(problem)
                )
            }
        }
    }
}
