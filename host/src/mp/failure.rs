//! How a job of the Master Process fails: who, what, when, and what to do about it, on one line.

mod words;

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
    /// More of a path.
    Path,
    /// The feed rate.
    FeedOverride,
    /// Digital outputs.
    Outputs,
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

impl std::error::Error for Failure {}

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
