//! The image of a robot in the Master Process: `e_c` of \[Z1\] (10), what `C_0` knows of `E_j`
//! through `C_j`.

use super::arm::{Arm, motor_angles};
use super::config::{RobotConfig, Timing};
use super::failure::{Asked, Who};
use agent::Reading;
use protocol::fault::{Fault, Refusal};
use protocol::message::{Feedback, HomingPhase, Identity, NodeState, Progress};
use protocol::time::Micros;
use protocol::units::PerAxis;

/// Where the exchange with a node stands.
///
/// ```text
///          identity                 lease
///  Silent ──────────▶ Identified ──────────▶ Leased
///    ▲ ▲   silence        │  ▲                │ │
///    │ └──────────────────┘  └── lease lost ──┘ │
///    └───────────── silence ────────────────────┘
/// ```
#[derive(Clone, Debug, PartialEq)]
pub enum Link {
    /// Nothing is known of the node, or nothing was heard for too long.
    Silent,
    /// The node said who it is.
    Identified {
        /// What it said.
        identity: Identity,
    },
    /// We hold its command lease.
    Leased {
        /// Who it is.
        identity: Identity,
        /// The epoch of the lease.
        epoch: u32,
        /// Since when, bus time.
        since: Micros,
    },
}

/// The latest request to a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Request {
    /// None yet.
    Idle,
    /// On its way.
    Pending {
        /// What was asked for.
        asked: Asked,
    },
    /// Accepted.
    Accepted {
        /// What was asked for.
        asked: Asked,
    },
    /// Refused.
    Refused {
        /// What was asked for.
        asked: Asked,
        /// Why.
        refusal: Refusal,
    },
    /// Repeated and never answered.
    Unanswered {
        /// What was asked for.
        asked: Asked,
        /// How often.
        tries: u32,
    },
}

/// What a node wants of the path that is streamed to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PathWanted {
    /// Number of the element wanted next.
    pub next: u32,
    /// How many were welcome when it said so.
    pub room: u16,
}

/// The image of one robot.
#[derive(Clone, Debug)]
pub struct Image {
    config: RobotConfig,
    robot: usize,
    feedback: agent::Image<Feedback>,
    i: u32,
    pub(super) link: Link,
    pub(super) request: Request,
    /// The number of the latest instruction in this epoch.
    pub(super) issued: u32,
    /// Instructions up to this number are no concern of the running job.
    settled: u32,
    pub(super) homing: Option<(u8, HomingPhase)>,
    pub(super) drives_ready: u8,
    pub(super) heard_at: Option<Micros>,
    pub(super) lease_lost: Option<u32>,
    pub(super) path: Option<PathWanted>,
}

impl Image {
    /// The image of a robot of which nothing is known.
    #[must_use]
    pub fn new(robot: usize, config: RobotConfig, timing: &Timing) -> Self {
        Self {
            config,
            robot,
            feedback: agent::Image::lasting(timing.steps(timing.stale_ms)),
            i: 0,
            link: Link::Silent,
            request: Request::Idle,
            issued: 0,
            settled: 0,
            homing: None,
            drives_ready: 0,
            heard_at: None,
            lease_lost: None,
            path: None,
        }
    }

    /// What the node wants of the path of the running instruction; nothing before its first answer.
    #[must_use]
    pub const fn path(&self) -> Option<PathWanted> {
        self.path
    }

    /// Its configuration.
    #[must_use]
    pub const fn config(&self) -> &RobotConfig {
        &self.config
    }

    /// Its geometry.
    #[must_use]
    pub fn arm(&self) -> &'static dyn Arm {
        self.config.arm
    }

    /// Who it is, for messages.
    #[must_use]
    pub fn who(&self) -> Who {
        Who {
            robot: self.robot,
            name: self.config.name.clone(),
            node: self.config.node,
        }
    }

    /// The exchange with its node.
    #[must_use]
    pub const fn link(&self) -> &Link {
        &self.link
    }

    /// Who its node says it is.
    #[must_use]
    pub const fn identity(&self) -> Option<&Identity> {
        match &self.link {
            Link::Silent => None,
            Link::Identified { identity } | Link::Leased { identity, .. } => Some(identity),
        }
    }

    /// The epoch of our lease.
    #[must_use]
    pub const fn epoch(&self) -> Option<u32> {
        match self.link {
            Link::Leased { epoch, .. } => Some(epoch),
            Link::Silent | Link::Identified { .. } => None,
        }
    }

    /// The latest request.
    #[must_use]
    pub const fn request(&self) -> &Request {
        &self.request
    }

    /// Is a request unanswered as yet?
    #[must_use]
    pub const fn is_asked(&self) -> bool {
        matches!(self.request, Request::Pending { .. })
    }

    /// The latest feedback with its age in macrosteps: fresh, stale or absent.
    #[must_use]
    pub fn feedback(&self) -> Reading<&Feedback> {
        self.feedback.at(self.i)
    }

    /// The latest feedback, however old: for messages, not for motion.
    #[must_use]
    pub fn last(&self) -> Option<&Feedback> {
        match self.feedback() {
            Reading::Fresh { value, .. } | Reading::Stale { value, .. } => Some(value),
            Reading::Absent => None,
        }
    }

    /// The state of its node, if known freshly.
    #[must_use]
    pub fn state(&self) -> Option<NodeState> {
        self.feedback().fresh().map(|f| f.state)
    }

    /// The latched fault, if known freshly.
    #[must_use]
    pub fn fault(&self) -> Option<Fault> {
        self.feedback().fresh().and_then(|f| f.fault)
    }

    /// The name of the axis at fault.
    #[must_use]
    pub fn axis_name(&self, axis: u8) -> Option<&'static str> {
        self.arm().axes().get(usize::from(axis)).map(|a| a.name)
    }

    /// Is every axis homed?
    #[must_use]
    pub fn is_homed(&self) -> bool {
        self.feedback()
            .fresh()
            .is_some_and(|f| f.synchronised.count_ones() as usize >= self.arm().axes().len())
    }

    /// Is the arm at rest, or without torque?
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        matches!(
            self.state(),
            Some(
                NodeState::Boot
                    | NodeState::Configuring
                    | NodeState::Disabled
                    | NodeState::Unsynchronised
                    | NodeState::Holding
                    | NodeState::Faulted
            )
        )
    }

    /// What homing does now.
    #[must_use]
    pub const fn homing(&self) -> Option<(u8, HomingPhase)> {
        self.homing
    }

    /// Axes whose drives are ready, a bit each.
    #[must_use]
    pub const fn drives_ready(&self) -> u8 {
        self.drives_ready
    }

    /// The progress of the latest instruction of ours; nothing until the node speaks of it.
    #[must_use]
    pub fn progress(&self) -> Option<Progress> {
        let feedback = self.feedback().fresh()?;
        let ours = Some(feedback.epoch) == self.epoch() && feedback.instruction == self.issued;
        (ours && self.issued > self.settled).then_some(feedback.progress)
    }

    /// The number of the latest instruction given in this epoch.
    #[must_use]
    pub const fn issued(&self) -> u32 {
        self.issued
    }

    /// Demanded motor angles, rad.
    #[must_use]
    pub fn demanded_motors(&self) -> Option<PerAxis<f64>> {
        motor_angles(self.arm().axes(), &self.feedback().fresh()?.demand)
    }

    /// Demanded joint positions, rad or m.
    #[must_use]
    pub fn demanded_joints(&self) -> Option<PerAxis<f64>> {
        self.arm().joints(&self.demanded_motors()?).ok()
    }

    /// Measured motor angles, rad.
    #[must_use]
    pub fn actual_motors(&self) -> Option<PerAxis<f64>> {
        motor_angles(self.arm().axes(), &self.feedback().fresh()?.actual)
    }

    /// A new job begins: what was refused to an earlier one is no concern of it.
    pub(super) fn settle(&mut self) {
        if matches!(self.progress(), Some(Progress::Failed(_))) {
            self.settled = self.issued;
        }
        if !self.is_asked() {
            self.request = Request::Idle;
        }
    }

    /// We hold the lease now, of this epoch.
    pub(super) fn lease(&mut self, epoch: u32, since: Micros) {
        if let Some(identity) = self.identity().cloned() {
            self.link = Link::Leased {
                identity,
                epoch,
                since,
            };
            self.issued = 0;
            self.settled = 0;
            self.lease_lost = None;
        }
    }

    pub(super) const fn set_instant(&mut self, i: u32) {
        self.i = i;
    }

    pub(super) fn receive(&mut self, i: u32, now: Micros, feedback: Feedback) {
        self.heard_at = Some(now);
        self.feedback.receive(i, feedback);
    }
}
