//! What happened to the robots, for people and observers. Read with [`super::Mp::events`].

use super::failure::Failure;
use protocol::fault::Fault;
use protocol::message::{DriveFinding, DriveIdentity, HomingPhase, NodeState, StopKind};
use protocol::time::Micros;

/// Something that happened, and when (bus time).
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// When the coordinator learnt of it.
    pub at: Micros,
    /// What.
    pub what: What,
}

/// What happened. Robots are indices in the configuration, axes count from 0.
#[derive(Clone, Debug, PartialEq)]
pub enum What {
    /// A node said who it is.
    Identified {
        /// Which robot.
        robot: usize,
    },
    /// We hold a robot's command lease.
    Leased {
        /// Which robot.
        robot: usize,
        /// The epoch.
        epoch: u32,
    },
    /// A robot's command lease is no longer ours.
    LeaseLost {
        /// Which robot.
        robot: usize,
        /// The epoch now valid on the node, 0 = none.
        epoch: u32,
    },
    /// A node went silent.
    Lost {
        /// Which robot.
        robot: usize,
    },
    /// A node booted.
    Booted {
        /// Which robot.
        robot: usize,
    },
    /// A node changed its state.
    State {
        /// Which robot.
        robot: usize,
        /// From, if it was known.
        from: Option<NodeState>,
        /// To.
        to: NodeState,
    },
    /// A drive is ready.
    DriveReady {
        /// Which robot.
        robot: usize,
        /// Which axis.
        axis: u8,
    },
    /// Something was found out about who a drive is.
    DriveFound {
        /// Which robot.
        robot: usize,
        /// What, where, and which identities.
        found: DriveFound,
    },
    /// Homing of an axis entered a phase.
    Homing {
        /// Which robot.
        robot: usize,
        /// Which axis.
        axis: u8,
        /// Which phase.
        phase: HomingPhase,
    },
    /// A fault latched.
    Fault {
        /// Which robot.
        robot: usize,
        /// What happened.
        fault: Fault,
    },
    /// Everyone was told to stop: by us, or by another participant.
    StopAll {
        /// How.
        kind: StopKind,
        /// By another participant?
        by_other: bool,
    },
    /// The job ended in error and its robots were told to stop.
    Failed {
        /// Which job.
        job: String,
        /// Why.
        failure: Failure,
    },
}

/// What a node has found out about who a drive is; `Display` is one line, with the axis counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DriveFound {
    /// The drive bus, from 0.
    pub bus: u8,
    /// The axis, from 0; none of a drive that no axis names.
    pub axis: Option<u8>,
    /// What.
    pub finding: DriveFinding,
    /// The identity that is named for the axis.
    pub expected: Option<DriveIdentity>,
    /// The identity that was read.
    pub got: Option<DriveIdentity>,
}

impl core::fmt::Display for DriveFound {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "drive bus {}", self.bus)?;
        if let Some(axis) = self.axis {
            write!(f, ", axis {}", u16::from(axis) + 1)?;
        }
        write!(f, ": {}", self.finding)?;
        match (&self.expected, &self.got) {
            (Some(expected), Some(got)) => write!(f, " (expected {expected}; got {got})"),
            (Some(expected), None) => write!(f, " ({expected})"),
            (None, Some(got)) => write!(f, " ({got})"),
            (None, None) => Ok(()),
        }
    }
}
