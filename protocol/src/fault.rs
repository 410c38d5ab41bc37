//! Causes, reactions and refusals, as typed codes.
//!
//! A *refusal* (R0) rejects one command and changes nothing. A *fault* latches and has a reaction.
//! Codes are stable and never reused; every [`Cause`] has a page in `docs/faults/`.

use serde::{Deserialize, Serialize};

// schema: begin

/// What the node does about a fault; ordered: a reaction never de-escalates by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Reaction {
    /// R1: stop on the path within the limits, then hold with torque on (stop category 2).
    PathStop,
    /// R2: quick stop, every axis at its greatest deceleration, then brake and torque off
    /// (stop category 1).
    QuickStop,
    /// R3: torque off and brakes at once (stop category 0).
    TorqueOff,
}

/// MRROC++'s error classes, told by who must act.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ErrorClass {
    /// A command was refused; nothing changed.
    NonFatal,
    /// Motion was ended and is latched until acknowledged.
    Fatal,
    /// The node or its hardware must be restarted or mended.
    System,
}

// schema: end

macro_rules! causes {
    ($( $(#[doc = $doc:literal])+ $name:ident = $code:literal, $class:ident, $reaction:ident; )+) => {
        /// Why a node stopped by itself. The discriminant is the code on the wire.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
        #[serde(into = "u16", try_from = "u16")]
        #[repr(u16)]
        pub enum Cause { $( $(#[doc = $doc])+ $name = $code, )+ }

        impl Cause {
            /// Every cause, in the order of the codes.
            pub const ALL: &[Self] = &[$( Self::$name ),+];

            /// The code on the wire and in `docs/faults/`.
            #[must_use]
            pub const fn code(self) -> u16 { self as u16 }

            /// The cause of a code.
            #[must_use]
            pub const fn from_code(code: u16) -> Option<Self> {
                match code { $( $code => Some(Self::$name), )+ _ => None }
            }

            /// Who must act.
            #[must_use]
            pub const fn class(self) -> ErrorClass {
                match self { $( Self::$name => ErrorClass::$class, )+ }
            }

            /// The least reaction; several causes at once take the strongest.
            #[must_use]
            pub const fn reaction(self) -> Reaction {
                match self { $( Self::$name => Reaction::$reaction, )+ }
            }

            /// What happened, in one line.
            #[must_use]
            pub const fn text(self) -> &'static str {
                match self { $( Self::$name => causes!(@first $($doc),+), )+ }
            }
        }
    };
    (@first $first:literal $(, $rest:literal)*) => { $first.trim_ascii() };
}

impl From<Cause> for u16 {
    fn from(cause: Cause) -> Self {
        cause.code()
    }
}

/// A number that is no [`Cause`]'s code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnknownCause(pub u16);

impl core::fmt::Display for UnknownCause {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "no cause has the code {}", self.0)
    }
}
impl core::error::Error for UnknownCause {}

impl TryFrom<u16> for Cause {
    type Error = UnknownCause;

    fn try_from(code: u16) -> Result<Self, UnknownCause> {
        Self::from_code(code).ok_or(UnknownCause(code))
    }
}

// schema: begin

causes! {
    /// the MP's lease expired: no valid cyclic message in time
    LeaseExpired = 10, Fatal, PathStop;
    /// the set-point queue ran empty while moving
    Underrun = 11, Fatal, PathStop;
    /// the error condition of the running program holds
    ErrorCondition = 13, Fatal, PathStop;
    /// an emergency stop was commanded
    EmergencyStop = 14, Fatal, QuickStop;
    /// the plan of a macrostep was not ready in time
    PlanLate = 15, Fatal, PathStop;
    /// a set-point broke the position limit
    PositionLimit = 20, Fatal, QuickStop;
    /// a set-point broke the velocity limit
    VelocityLimit = 21, Fatal, PathStop;
    /// a set-point broke the acceleration limit
    AccelerationLimit = 22, Fatal, PathStop;
    /// a set-point broke the jerk limit
    JerkLimit = 23, Fatal, PathStop;
    /// a computed value was not a finite number
    NotFinite = 24, Fatal, QuickStop;
    /// the generator asked for a pose without a solution
    Unreachable = 25, Fatal, PathStop;
    /// the following error left its window
    FollowingError = 30, Fatal, QuickStop;
    /// the encoder moved further in one step than the axis can
    EncoderJump = 31, Fatal, QuickStop;
    /// the motor current exceeded its limit
    OverCurrent = 32, Fatal, QuickStop;
    /// the axis moves away from where it is told to go
    Runaway = 33, Fatal, TorqueOff;
    /// the drive reported a fault
    DriveFault = 40, Fatal, QuickStop;
    /// the drive stopped sending its actual values
    DriveSilent = 41, Fatal, QuickStop;
    /// the drive's heartbeat was lost or never heard
    DriveHeartbeat = 42, System, QuickStop;
    /// the drive refused its configuration
    DriveConfiguration = 43, System, TorqueOff;
    /// the drive left the operation-enabled state by itself
    DriveDisabled = 44, Fatal, QuickStop;
    /// homing: the switch was not found within the travel
    HomingSwitchNotFound = 50, Fatal, PathStop;
    /// homing: the switch changed while the axis stood still
    HomingSwitchUnstable = 51, Fatal, PathStop;
    /// homing: the switch did not release while backing off
    HomingSwitchStuck = 52, Fatal, PathStop;
    /// homing: no index pulse within one turn
    HomingIndexNotFound = 53, Fatal, PathStop;
    /// homing: another axis moved or reported its switch
    HomingForeignSwitch = 54, Fatal, PathStop;
    /// the force sensor is silent, saturated or has failed
    ForceSensor = 60, Fatal, PathStop;
}

/// A latched fault: who, what, when, and what it interrupted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fault {
    /// What happened.
    pub cause: Cause,
    /// The axis at fault, if one is, counted from 0 in the robot's axis order.
    pub axis: Option<u8>,
    /// The servo step in which it was detected.
    pub step: u32,
    /// What the node was doing.
    pub during: crate::message::NodeState,
}

/// The quantity a limit bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Quantity {
    /// Motor-shaft position, rad.
    MotorPosition,
    /// Joint position, rad or m.
    JointPosition,
    /// Velocity, rad/s or m/s.
    Velocity,
    /// Acceleration, rad/s² or m/s².
    Acceleration,
    /// Jerk, rad/s³ or m/s³.
    Jerk,
}

/// Why a command was refused (R0). Nothing moved and nothing changed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Refusal {
    /// Another MP holds the lease.
    LeaseHeld {
        /// The holder's node id.
        holder: u8,
    },
    /// The sender does not hold the lease, or speaks of an old epoch.
    NoLease {
        /// The epoch now valid.
        epoch: u32,
    },
    /// The command is not allowed in this state.
    WrongState {
        /// The state the node is in.
        state: crate::message::NodeState,
    },
    /// Only relative motor moves are allowed before synchronisation.
    NotSynchronised,
    /// A fault is latched: acknowledge it first.
    FaultLatched {
        /// The first fault.
        cause: Cause,
    },
    /// The cause of the fault is still present: it cannot be acknowledged.
    CausePresent {
        /// The cause that is still present.
        cause: Cause,
    },
    /// The command carries the wrong number of axes.
    AxisCount {
        /// Axes of the robot.
        expected: u8,
        /// Axes in the command.
        got: u8,
    },
    /// A number is NaN or infinite.
    NotFinite {
        /// The axis or coordinate, from 0.
        index: u8,
    },
    /// A number is outside its range.
    OutOfRange {
        /// The axis or coordinate, from 0.
        index: u8,
        /// The value.
        value: f32,
        /// The lower bound.
        lower: f32,
        /// The upper bound.
        upper: f32,
    },
    /// The target, or the way to it, breaks a limit.
    Limit {
        /// The axis, from 0.
        axis: u8,
        /// Which limit.
        quantity: Quantity,
        /// The value that was asked for.
        value: f64,
        /// The limit it breaks.
        limit: f64,
    },
    /// The pose, or a pose on the way, is outside the workspace.
    Unreachable,
    /// The way passes a singular pose.
    Singular,
    /// The command id was used before in this epoch, or is older than the last.
    Stale {
        /// The last accepted id.
        last: u32,
    },
    /// The command's start time has passed.
    Late,
    /// No room in the queue.
    QueueFull,
    /// The knots' times do not increase.
    NotMonotone,
    /// The first knot does not continue the present state.
    Discontinuous {
        /// The axis, from 0.
        axis: u8,
    },
    /// No program of that number is linked into this node.
    UnknownProgram {
        /// The number.
        program: u16,
    },
    /// No servo law or parameter set of that number.
    UnknownServoLaw,
    /// The instruction was ended by a stop or a fault before it was complete.
    Aborted,
    /// An element of a path cannot be part of it.
    Path {
        /// Its number, from 0.
        element: u32,
        /// Why.
        problem: PathProblem,
    },
    /// There is no force sensor that can be read.
    NoForce,
}

/// What can be wrong with an element of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum PathProblem {
    /// A number of it is NaN, infinite, or far too large.
    NotFinite,
    /// It goes nowhere.
    NoLength,
    /// The three points of an arc lie on a line, or two of them coincide.
    NotAnArc,
    /// The tool turns by more than a radian from one point to the next.
    TurnTooLarge,
    /// A tolerance is negative, or the corner cannot be rounded within it.
    Corner,
    /// A feed is not greater than 0, or not finite.
    Feed,
}

// schema: end
