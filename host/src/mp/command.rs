//! `yC_0`: what the coordinator demands of its robots in one macrostep.

use super::failure::Failure;
use motion::Pose;
use protocol::message::{
    Decision, Instruction, KnotMessage, PATH_BATCH, PathElement, ServoLaw, StopKind,
};
use protocol::time::Micros;

/// What one robot is told.
#[derive(Clone, Debug, PartialEq)]
pub enum RobotCommand {
    /// Who are you?
    Identify,
    /// Take the command lease.
    Acquire,
    /// Give the lease back.
    Release,
    /// Torque on.
    Enable,
    /// Torque off.
    Disable,
    /// Home every axis that is not homed.
    Synchronise,
    /// `f** = const`: begin the program linked into the node, and go on alone.
    Start {
        /// Its number.
        program: u16,
        /// Its argument.
        argument: f64,
    },
    /// Run one instruction of the ECP's library.
    Execute {
        /// Which.
        instruction: Instruction,
        /// When; 0 = at once.
        start_at: Micros,
    },
    /// End the running instruction.
    EndMotion,
    /// Loose coordination: a decision, repeated in every cyclic message until the next one.
    Loose(Decision),
    /// Tight coordination: the next locations, in the order of their instants.
    Tight(Vec<KnotMessage>),
    /// Stop.
    Stop(StopKind),
    /// Acknowledge the latched fault.
    Acknowledge,
    /// Close the loops by this law.
    SelectServo(ServoLaw),
    /// `t_flange_tool`
    SetTool(Pose),
    /// Publish the demand every n-th servo step; 0 = never.
    Trace(u16),
    /// More of the path of the running `FollowPath`.
    Path {
        /// Number of the first element.
        first: u32,
        /// The elements.
        elements: heapless::Vec<PathElement, PATH_BATCH>,
    },
    /// The feed rate on a path, as a share of the programmed one: -1 to 1.
    FeedOverride(f32),
    /// Digital outputs, only at rest.
    Outputs {
        /// Those that change.
        mask: u16,
        /// Those of them that are switched on.
        on: u16,
    },
}

/// `yC_0`: at most one command per robot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Commands {
    /// Robot index and what it is told.
    pub robots: Vec<(usize, RobotCommand)>,
    /// The behaviour cannot go on: the job ends with this error in this very macrostep, and its
    /// robots are stopped.
    pub give_up: Option<Failure>,
}

impl Commands {
    /// Nothing for anyone.
    #[must_use]
    pub const fn none() -> Self {
        Self {
            robots: Vec::new(),
            give_up: None,
        }
    }

    /// One command for one robot.
    #[must_use]
    pub fn one(robot: usize, command: RobotCommand) -> Self {
        Self {
            robots: vec![(robot, command)],
            give_up: None,
        }
    }

    /// The end of the job in error.
    #[must_use]
    pub const fn give_up(failure: Failure) -> Self {
        Self {
            robots: Vec::new(),
            give_up: Some(failure),
        }
    }

    /// Both; of two failures the first.
    #[must_use]
    pub fn and(mut self, other: Self) -> Self {
        self.robots.extend(other.robots);
        self.give_up = self.give_up.or(other.give_up);
        self
    }
}
