//! A scripted peer of the Master Process: what a node says, over `protocol::link`, without drives
//! and dynamics. It is written from the documentation of the messages, not from the node.

pub(crate) mod path;
mod request;

use crate::mp::arm::{Arm, arm, unit_rad};
use motion::{Line, Pose};
use protocol::clock::Clock;
use protocol::fault::{Cause, Fault, Refusal};
use protocol::frame::Frame;
use protocol::id::NodeId;
use protocol::link::{Endpoint, Message, Role};
use protocol::message::{
    Command, Coordination, Event, Feedback, HomingPhase, Identity, Instruction, KnotMessage,
    NodeState, PoseMessage, PoseReference, Progress, Reply, StopKind,
};
use protocol::schema::{PROTOCOL, SCHEMA_HASH};
use protocol::time::Micros;
use protocol::transfer::Mtu;
use protocol::units::PerAxis;
use robots::RobotKind;

/// What a test makes the peer do.
#[derive(Clone, Debug, Default)]
pub(crate) struct Script {
    pub(crate) silent: bool,
    pub(crate) schema: Option<u64>,
    pub(crate) held_by: Option<u8>,
    pub(crate) refuse: Option<Refusal>,
    pub(crate) drives_never: bool,
    pub(crate) fault_at: Option<Micros>,
    pub(crate) homed: bool,
    pub(crate) path: path::PathScript,
}

#[derive(Clone, Debug, PartialEq)]
enum Doing {
    Nothing,
    Enabling {
        until: Micros,
    },
    Homing {
        until: Micros,
    },
    Waiting {
        start: Micros,
        instruction: Instruction,
    },
    Moving {
        until: Micros,
        target: Option<PerAxis<f64>>,
    },
    Following {
        end: bool,
    },
    /// On a path; when the element at its head is passed.
    Path {
        next: Option<Micros>,
    },
    Stopping {
        until: Micros,
    },
}

pub(crate) struct Peer {
    pub(crate) arm: &'static dyn Arm,
    link: Endpoint<16>,
    clock: Clock,
    pub(crate) script: Script,
    pub(crate) state: NodeState,
    doing: Doing,
    pub(crate) fault: Option<Fault>,
    synchronised: u8,
    lease: Option<(u8, u32, Micros, Micros)>,
    last_sequence: Option<u16>,
    pub(crate) instruction: u32,
    pub(crate) progress: Progress,
    pub(crate) motors: PerAxis<f64>,
    next_feedback: Micros,
    steps: u32,
    pub(crate) knots: Vec<KnotMessage>,
    pub(crate) knot_margin: Vec<i64>,
    pub(crate) started: Vec<(Micros, Instruction)>,
    pub(crate) stopped: Vec<Micros>,
    pub(crate) decisions: Vec<u16>,
    epoch: u32,
    pub(crate) feedback_on: bool,
    pub(crate) path: path::Taken,
}

/// How long a motion takes, unless it says so itself.
const MOTION: Micros = Micros::from_millis(300);

impl Peer {
    pub(crate) fn new(kind: RobotKind, node: NodeId, script: Script) -> Self {
        let arm = arm(kind);
        Self {
            arm,
            link: Endpoint::new(node, Role::Node, Mtu::Fd),
            clock: Clock::default(),
            state: NodeState::Configuring,
            doing: Doing::Nothing,
            fault: None,
            synchronised: if script.homed { 0xFF } else { 0 },
            script,
            lease: None,
            last_sequence: None,
            instruction: 0,
            progress: Progress::Idle,
            motors: arm.axes().iter().map(|_| 0.0).collect(),
            next_feedback: Micros(0),
            steps: 0,
            knots: Vec::new(),
            knot_margin: Vec::new(),
            started: Vec::new(),
            stopped: Vec::new(),
            decisions: Vec::new(),
            epoch: 0x100,
            feedback_on: true,
            path: path::Taken::default(),
        }
    }

    fn identity(&self) -> Identity {
        Identity {
            robot: self.arm.kind().name().try_into().unwrap(),
            unique_id: 7,
            protocol: PROTOCOL,
            schema_hash: self.script.schema.unwrap_or(SCHEMA_HASH),
            config_crc: 0xC0FF_EE00,
            firmware: (0, 1, 0),
            axes: u8::try_from(self.arm.axes().len()).unwrap(),
            servo_step_us: self.arm.servo_step_us(),
            macrostep: 10,
        }
    }

    fn rest(&self) -> NodeState {
        if self.synchronised == 0 {
            NodeState::Unsynchronised
        } else {
            NodeState::Holding
        }
    }

    pub(crate) fn step(&mut self, now: Micros, frames: &[Frame], tx: &mut dyn FnMut(Frame)) {
        if self.script.silent {
            return;
        }
        let mut tx = |frame: Frame| tx(frame);
        for frame in frames {
            let Some(incoming) = self.link.receive(frame, now) else {
                continue;
            };
            match incoming.message {
                Message::Command(command) => self.command(now, command),
                Message::TimeSync(sync) => self.clock.receive(now, &sync),
                Message::StopAll(stop) => self.stop(now, stop.kind),
                Message::Request {
                    transfer_id,
                    request,
                } => {
                    let from = incoming.from;
                    let reply = self
                        .request(now, from.get(), request)
                        .unwrap_or_else(Reply::Refused);
                    self.link
                        .send_reply(from, transfer_id, &reply, &mut tx)
                        .unwrap();
                }
                _ => {}
            }
        }
        self.live(now, &mut tx);
        if now >= self.next_feedback && self.feedback_on {
            self.next_feedback = now + Micros::from_millis(10);
            self.link
                .send_feedback(&self.feedback(now), &mut tx)
                .unwrap();
        }
        self.steps += 1;
    }

    fn command(&mut self, now: Micros, command: Command) {
        let Some((_, epoch, term, expires)) = &mut self.lease else {
            return;
        };
        if command.epoch != *epoch || command.valid_until < now {
            return;
        }
        if self
            .last_sequence
            .is_some_and(|last| command.sequence.wrapping_sub(last) > 0x7FFF)
        {
            return;
        }
        self.last_sequence = Some(command.sequence);
        *expires = now + *term;
        match command.coordination {
            Coordination::None => {}
            Coordination::Loose(decision) => {
                if self.decisions.last() != Some(&u16::try_from(decision.variant).unwrap()) {
                    self.decisions
                        .push(u16::try_from(decision.variant).unwrap());
                }
            }
            Coordination::Tight(knot) => {
                if !matches!(self.doing, Doing::Following { .. }) {
                    return;
                }
                if self.knots.last().is_none_or(|last| last.at < knot.at) {
                    let margin = i64::try_from(knot.at.0).unwrap() - i64::try_from(now.0).unwrap();
                    self.knot_margin.push(margin);
                    self.knots.push(knot);
                }
            }
        }
    }

    fn stop(&mut self, now: Micros, kind: StopKind) {
        match self.doing {
            Doing::Nothing | Doing::Stopping { .. } => return,
            _ => {}
        }
        self.stopped.push(now);
        if matches!(self.progress, Progress::Running | Progress::Pending) {
            self.progress = Progress::Failed(Refusal::Aborted);
        }
        self.state = NodeState::Stopping;
        self.doing = Doing::Stopping {
            until: now + Micros::from_millis(100),
        };
        if kind != StopKind::Path {
            self.raise(now, Cause::EmergencyStop);
        }
    }

    pub(crate) fn raise(&mut self, now: Micros, cause: Cause) {
        let fault = Fault {
            cause,
            axis: Some(1),
            step: self.steps,
            during: self.state,
        };
        self.fault.get_or_insert(fault);
        if matches!(self.progress, Progress::Running | Progress::Pending) {
            self.progress = Progress::Failed(Refusal::Aborted);
        }
        self.state = NodeState::Stopping;
        self.doing = Doing::Stopping {
            until: now + Micros::from_millis(100),
        };
    }

    fn live(&mut self, now: Micros, tx: &mut impl FnMut(Frame)) {
        if self.state == NodeState::Configuring && now.0 > 100_000 && !self.script.drives_never {
            self.state = if self.script.homed {
                NodeState::Holding
            } else {
                NodeState::Disabled
            };
            for axis in 0..self.arm.axes().len() {
                let axis = u8::try_from(axis).unwrap();
                self.link
                    .send_event(&Event::DriveReady { axis }, tx)
                    .unwrap();
            }
        }
        if let Some((.., expires)) = self.lease
            && now > expires
        {
            self.lease = None;
            if matches!(
                self.doing,
                Doing::Moving { .. }
                    | Doing::Following { .. }
                    | Doing::Path { .. }
                    | Doing::Homing { .. }
            ) {
                self.raise(now, Cause::LeaseExpired);
            }
        }
        if self.script.fault_at.is_some_and(|at| now >= at) {
            self.script.fault_at = None;
            self.raise(now, Cause::FollowingError);
        }
        match self.doing.clone() {
            Doing::Enabling { until } | Doing::Stopping { until } if now >= until => {
                self.doing = Doing::Nothing;
                self.state = match self.fault {
                    Some(_) => NodeState::Faulted,
                    None => self.rest(),
                };
            }
            Doing::Homing { until } if now >= until => {
                let event = Event::Homing {
                    axis: 0,
                    phase: HomingPhase::Done,
                };
                self.link.send_event(&event, tx).unwrap();
                self.synchronised = 0xFF;
                self.state = NodeState::Holding;
                self.doing = Doing::Nothing;
            }
            Doing::Waiting { start, instruction } if self.clock.to_bus(now) >= start => {
                self.started.push((now, instruction.clone()));
                self.state = NodeState::Moving;
                self.progress = Progress::Running;
                self.begin(now, &instruction);
            }
            Doing::Moving { until, target } if now >= until => {
                if let Some(target) = target {
                    self.motors = target;
                }
                self.done();
            }
            Doing::Following { end } => {
                if let Some(knot) = self.knots.iter().rfind(|k| k.at <= now) {
                    self.motors = self.arm.motors(&knot.position).unwrap();
                }
                if end && self.knots.last().is_none_or(|last| last.at <= now) {
                    self.done();
                }
            }
            Doing::Path { next } => self.pass(now, next),
            _ => {}
        }
    }

    fn done(&mut self) {
        self.progress = Progress::Done;
        self.state = self.rest();
        self.doing = Doing::Nothing;
    }

    fn begin(&mut self, now: Micros, instruction: &Instruction) {
        let sum = |a: &[f64], b: &[f64], relative: bool| -> PerAxis<f64> {
            a.iter()
                .zip(b)
                .map(|(a, b)| if relative { a + b } else { *b })
                .collect()
        };
        let target = match instruction {
            Instruction::Follow => {
                self.knots.clear();
                self.knot_margin.clear();
                self.doing = Doing::Following { end: false };
                return;
            }
            Instruction::FollowPath { .. } => {
                self.path = path::Taken::default();
                self.doing = Doing::Path { next: None };
                return;
            }
            Instruction::MoveMotors {
                target, relative, ..
            } => Some(sum(&self.motors, target, *relative)),
            Instruction::MoveJoints {
                target, relative, ..
            } => {
                let joints = self.arm.joints(&self.motors).unwrap();
                Some(self.arm.motors(&sum(&joints, target, *relative)).unwrap())
            }
            Instruction::MovePose {
                target, reference, ..
            }
            | Instruction::MoveUntilForce {
                target, reference, ..
            } => {
                let goal = pose(target);
                let goal = if *reference == PoseReference::Tool {
                    self.tool() * goal
                } else {
                    goal
                };
                Some(self.straight_to(goal))
            }
            _ => None,
        };
        self.doing = Doing::Moving {
            until: now + MOTION,
            target,
        };
    }

    /// `t_base_tool`
    fn tool(&self) -> Pose {
        let joints = self.arm.joints(&self.motors).unwrap();
        self.arm.forward(&joints).unwrap() * self.arm.default_tool()
    }

    /// The motors at a pose of the tool, on the branch of the inverse that a straight line leads to.
    fn straight_to(&self, goal: Pose) -> PerAxis<f64> {
        let t_flange_tool = self.arm.default_tool();
        let line = Line::new(self.tool(), goal);
        let joints = self.arm.joints(&self.motors).unwrap();
        let joints = (1..=100).fold(joints, |near, k| {
            let flange = line.at(f64::from(k) / 100.0) * t_flange_tool.inverse();
            self.arm.inverse(&flange, &near).unwrap()
        });
        self.arm.motors(&joints).unwrap()
    }

    #[expect(
        clippy::cast_possible_truncation,
        reason = "positions of tests are small"
    )]
    fn feedback(&self, now: Micros) -> Feedback {
        let units: PerAxis<i64> = self
            .motors
            .iter()
            .zip(self.arm.axes())
            .map(|(motor, axis)| (motor / unit_rad(axis)).round() as i64)
            .collect();
        Feedback {
            step: self.steps,
            sampled_at: now,
            state: self.state,
            fault: self.fault,
            synchronised: self.synchronised,
            epoch: self.lease.map_or(0, |(_, epoch, ..)| epoch),
            instruction: self.instruction,
            progress: self.progress,
            horizon_us: 0,
            actual: units.clone(),
            current_ma: units.iter().map(|_| 0).collect(),
            following_error: units.iter().map(|_| 0).collect(),
            demand: units,
            limit_violations: 0,
            acceleration_step: 0.0,
            lost: 0,
            force_n: None,
        }
    }
}

fn pose(message: &PoseMessage) -> Pose {
    Pose::from_rotation_vector(message.position_m.into(), message.rotation_rad.into())
}
