//! How a job of the Master Process fails: who, what, when, and what to do about it, on one line.

use core::fmt;
use protocol::fault::{Fault, Refusal};
use protocol::id::NodeId;
use protocol::message::StopKind;
use robots::KinematicError;

/// A robot, for messages.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Who {
    /// Its index in the configuration.
    pub robot: usize,
    /// Its name.
    pub name: String,
    /// Its number on the wire.
    pub node: NodeId,
}

impl fmt::Display for Who {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} (node {})", self.name, self.node)
    }
}

/// What the coordinator asks for, without the contents.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Asked {
    /// Who are you?
    Identify,
    /// The lease.
    Acquire,
    /// The lease back.
    Release,
    /// Torque on.
    Enable,
    /// Torque off.
    Disable,
    /// Homing.
    Synchronise,
    /// An instruction.
    Execute,
    /// The end of an instruction.
    EndMotion,
    /// A stop.
    Stop,
    /// Acknowledgement of a fault.
    Acknowledge,
    /// A servo law.
    SelectServo,
    /// A tool.
    SetTool,
    /// A trace.
    Trace,
}

impl fmt::Display for Asked {
    /// The name of the request on the wire.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self, f)
    }
}

/// Something the coordinator waited for in vain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Awaited {
    /// The answer to Identify.
    Identity,
    /// The drives configured.
    Drives,
    /// Torque on.
    Torque,
    /// Every axis homed.
    Homing,
    /// The robot at rest.
    Rest,
}

/// Why a job of the Master Process ended in error.
#[derive(Clone, Debug, PartialEq)]
pub enum Failure {
    /// A node refused a request; nothing changed on it.
    Refused {
        /// Which robot.
        who: Who,
        /// What was asked for.
        asked: Asked,
        /// Why it was refused.
        refusal: Refusal,
    },
    /// A request was repeated and never answered.
    Unanswered {
        /// Which robot.
        who: Who,
        /// What was asked for.
        asked: Asked,
        /// How often.
        tries: u32,
    },
    /// Something did not come about in time.
    TimedOut {
        /// Which robot.
        who: Who,
        /// What.
        awaited: Awaited,
        /// How long was waited, ms.
        span_ms: u32,
        /// How far it came.
        seen: String,
    },
    /// The node is not the one of the configuration.
    Mismatch {
        /// Which robot.
        who: Who,
        /// What differs.
        item: &'static str,
        /// As configured, or as this program was built.
        expected: String,
        /// As the node says.
        got: String,
        /// What to do.
        hint: &'static str,
    },
    /// A fault latched on a node.
    Fault {
        /// Which robot.
        who: Who,
        /// What happened.
        fault: Fault,
        /// The name of the axis at fault.
        axis: Option<&'static str>,
    },
    /// No image of a robot for too long.
    Lost {
        /// Which robot.
        who: Who,
        /// How long, ms.
        span_ms: u32,
    },
    /// The node no longer knows our lease.
    LeaseLost {
        /// Which robot.
        who: Who,
        /// The epoch now valid on the node; 0 = nobody holds the lease.
        epoch: u32,
    },
    /// An instruction ended without completing.
    Instruction {
        /// Which robot.
        who: Who,
        /// Why.
        refusal: Refusal,
    },
    /// A pose the coordinator computed has no configuration, or one outside the limits.
    Kinematics {
        /// Which robot.
        who: Who,
        /// Where: step, node, share of a way.
        at: String,
        /// Why.
        error: KinematicError,
    },
    /// A motion the coordinator computed is faster than the robot may move.
    TooFast {
        /// Which robot.
        who: Who,
        /// The name of the axis.
        axis: &'static str,
        /// How many times the ceiling.
        times: f64,
        /// `velocity`, `acceleration` or `jerk`.
        quantity: &'static str,
    },
    /// A sensor that a motion depends on is silent.
    SensorStale {
        /// Which sensor.
        sensor: String,
    },
    /// The operator stopped it.
    Stopped {
        /// How.
        kind: StopKind,
    },
}

impl Failure {
    /// The robot concerned, if it is one.
    #[must_use]
    pub const fn who(&self) -> Option<&Who> {
        match self {
            Self::Refused { who, .. }
            | Self::Unanswered { who, .. }
            | Self::TimedOut { who, .. }
            | Self::Mismatch { who, .. }
            | Self::Fault { who, .. }
            | Self::Lost { who, .. }
            | Self::LeaseLost { who, .. }
            | Self::Instruction { who, .. }
            | Self::Kinematics { who, .. }
            | Self::TooFast { who, .. } => Some(who),
            Self::SensorStale { .. } | Self::Stopped { .. } => None,
        }
    }

    /// The exit code of a program that ends with this (see [`crate::error`]).
    #[must_use]
    pub const fn exit_code(&self) -> u8 {
        match self {
            Self::Refused {
                refusal: Refusal::LeaseHeld { .. },
                ..
            }
            | Self::LeaseLost { .. } => 75,
            Self::Instruction {
                refusal: Refusal::Aborted,
                ..
            }
            | Self::Fault { .. }
            | Self::SensorStale { .. } => 10,
            Self::Refused { .. }
            | Self::Instruction { .. }
            | Self::Kinematics { .. }
            | Self::TooFast { .. } => 11,
            Self::Stopped { .. } => 12,
            Self::Unanswered { .. } | Self::TimedOut { .. } | Self::Lost { .. } => 69,
            Self::Mismatch { item, .. } => match item.as_bytes() {
                b"protocol version" | b"message set" => 76,
                _ => 78,
            },
        }
    }
}

/// A span for people: `2.0 s`.
pub(super) fn seconds(span_ms: u32) -> String {
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
            } => {
                let span = seconds(*span_ms);
                match awaited {
                    Awaited::Identity => write!(
                        f,
                        "{who} does not answer Identify: no frame in {span}; is mrroc-node running on this bus?"
                    ),
                    Awaited::Drives => write!(
                        f,
                        "{who} does not get its drives ready in {span} ({seen}); are the drives powered and on the node's drive bus?"
                    ),
                    Awaited::Torque => write!(
                        f,
                        "{who} does not switch torque on in {span} ({seen}); is the emergency stop released?"
                    ),
                    Awaited::Homing => write!(f, "{who} is not homed after {span} ({seen})"),
                    Awaited::Rest => write!(f, "{who} is not at rest {span} after a stop ({seen})"),
                }
            }
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
            Self::Fault { who, fault, axis } => {
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

impl std::error::Error for Failure {}

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
            Refusal::Aborted => f.write_str("ended by a stop or a fault"),
        }
    }
}

#[cfg(test)]
mod test {
    use super::*;
    use protocol::fault::Cause;
    use protocol::message::NodeState;

    fn who() -> Who {
        Who {
            robot: 0,
            name: "irp6-track".into(),
            node: NodeId::effector(1).unwrap(),
        }
    }

    #[test]
    fn every_failure_is_one_line() {
        let silent = Failure::TimedOut {
            who: who(),
            awaited: Awaited::Identity,
            span_ms: 2000,
            seen: String::new(),
        };
        assert_eq!(
            silent.to_string(),
            "irp6-track (node 11) does not answer Identify: no frame in 2.0 s; is mrroc-node running on this bus?"
        );
        let fault = Failure::Fault {
            who: who(),
            fault: Fault {
                cause: Cause::FollowingError,
                axis: Some(1),
                step: 77,
                during: NodeState::Moving,
            },
            axis: Some("column"),
        };
        assert_eq!(
            fault.to_string(),
            "irp6-track (node 11): fault 30: the following error left its window, axis 2 (column), in servo step 77 while Moving"
        );
        assert_eq!((silent.exit_code(), fault.exit_code()), (69, 10));
    }

    #[test]
    fn a_lease_held_by_another_is_worth_another_try() {
        let held = Failure::Refused {
            who: who(),
            asked: Asked::Acquire,
            refusal: Refusal::LeaseHeld { holder: 2 },
        };
        assert_eq!(held.exit_code(), 75);
        assert!(
            held.to_string().contains("node 2 holds the command lease"),
            "{held}"
        );
    }
}
