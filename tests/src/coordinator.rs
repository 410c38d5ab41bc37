//! An MP of a few lines: it commands one robot in lock step and lets the [`Watch`] look on.

use crate::emulator::node::in_process;
use crate::watch::Watch;
use board::boot::Boot;
use bus::wire::Kind;
use firmware::process::{NodeProcess, drive_buses};
use firmware::{DriveAddress, Station};
use hil_sim::cell::Cell;
use protocol::id::NodeId;
use protocol::link::{Endpoint, Message, Role};
use protocol::message::{
    AxisSpeeds, Command, Coordination, Feedback, Instruction, KnotMessage, NodeState, Progress,
    Reply, Request, ServoLaw, StopKind,
};
use protocol::time::Micros;
use protocol::transfer::Mtu;
use robots::{RobotKind, TrackRule};
use std::collections::VecDeque;

/// The velocity factor of these tests.
pub const FACTOR: f64 = 0.2;
/// Its macrostep.
const MACROSTEP: Micros = Micros::from_millis(20);

/// Commands one robot.
#[derive(Debug)]
pub struct Coordinator {
    /// The robot, its drives and buses.
    pub cell: Cell,
    /// Who looks on.
    pub watch: Watch,
    /// Does it send cyclic messages? Without them the lease expires.
    pub talks: bool,
    node: NodeId,
    link: Endpoint<16>,
    epoch: u32,
    sequence: u16,
    feedback: Option<Feedback>,
    reply: Option<Reply>,
    next_id: u32,
    knots: VecDeque<KnotMessage>,
}

impl Coordinator {
    /// A robot just switched on.
    ///
    /// # Panics
    /// If the cell cannot be built.
    #[must_use]
    pub fn new(kind: RobotKind, law: ServoLaw, seed: u64) -> Self {
        Self::as_fast_as(kind, law, seed, FACTOR)
    }

    /// A robot just switched on, with a velocity factor of its own.
    ///
    /// # Panics
    /// If the cell cannot be built.
    #[must_use]
    pub fn as_fast_as(kind: RobotKind, law: ServoLaw, seed: u64, factor: f64) -> Self {
        let station = Station {
            effector: 1,
            unique_id: seed,
            mtu: Mtu::Fd,
            law,
            velocity_factor: factor,
            one_wire: false,
            track: TrackRule::Keep,
        };
        let boot = Boot {
            now: Micros(0),
            kind,
            station,
            buses: drive_buses(kind),
        };
        let (node, drives) = in_process(&boot).expect("a node");
        Self::with_node(&boot, node, &drives)
    }

    /// A robot just switched on, with a node of one's own that was booted so.
    ///
    /// # Panics
    /// If the cell cannot be built.
    #[must_use]
    pub fn with_node(
        boot: &Boot,
        node: Box<dyn NodeProcess + Send>,
        drives: &[DriveAddress],
    ) -> Self {
        let (kind, station) = (boot.kind, &boot.station);
        let mut cell = Cell::new(Kind::Fd);
        cell.add_node(kind, node, drives, station.unique_id)
            .expect("a cell of one robot");
        Self {
            cell,
            watch: Watch::new(
                kind,
                1,
                station.law,
                station.velocity_factor,
                1,
                &boot.buses,
            ),
            talks: true,
            node: NodeId::effector(1).expect("the first effector"),
            link: Endpoint::new(NodeId::MP, Role::Coordinator, Mtu::Fd),
            epoch: 0,
            sequence: 0,
            feedback: None,
            reply: None,
            next_id: 0,
            knots: VecDeque::new(),
        }
    }

    /// The latest feedback.
    ///
    /// # Panics
    /// Before the first.
    #[must_use]
    pub fn feedback(&self) -> &Feedback {
        self.feedback.as_ref().expect("a node that has spoken")
    }

    /// The node's state.
    #[must_use]
    pub fn state(&self) -> Option<NodeState> {
        self.feedback.as_ref().map(|f| f.state)
    }

    /// The epoch of its lease.
    #[must_use]
    pub const fn epoch(&self) -> u32 {
        self.epoch
    }

    /// One cyclic message, and its macrostep.
    ///
    /// # Panics
    /// If a message cannot be sent.
    pub fn macrostep(&mut self) {
        let mut frames = Vec::new();
        if self.epoch != 0 && self.talks {
            self.sequence = self.sequence.wrapping_add(1);
            let coordination = self
                .knots
                .pop_front()
                .map_or(Coordination::None, Coordination::Tight);
            let command = Command {
                epoch: self.epoch,
                sequence: self.sequence,
                valid_until: self.cell.now() + Micros(50_000),
                coordination,
            };
            let sent = self
                .link
                .send_command(self.node, &command, &mut |f| frames.push(f));
            sent.expect("a cyclic message");
        }
        for frame in frames {
            self.cell.send(frame);
        }
        self.cell
            .advance(self.cell.now() + MACROSTEP, &mut self.watch);
        let received: Vec<_> = self.cell.receive().collect();
        for (at, frame) in received {
            match self
                .link
                .receive(&frame, at)
                .map(|incoming| incoming.message)
            {
                Some(Message::Feedback(f)) => self.feedback = Some(f),
                Some(Message::Reply { reply, .. }) => self.reply = Some(reply),
                _ => {}
            }
        }
    }

    /// Sends a request now and waits for its reply.
    ///
    /// # Panics
    /// Without a reply.
    pub fn request(&mut self, request: &Request) -> Reply {
        let reply = self.try_request(request);
        reply.unwrap_or_else(|| panic!("no reply to {request:?}"))
    }

    /// Sends a request now and waits for its reply, if any comes.
    ///
    /// # Panics
    /// If it cannot be sent.
    pub fn try_request(&mut self, request: &Request) -> Option<Reply> {
        let mut frames = Vec::new();
        let sent = self
            .link
            .send_request(self.node, request, &mut |f| frames.push(f));
        sent.expect("a request");
        for frame in frames {
            self.cell.send(frame);
        }
        self.reply = None;
        for _ in 0..5 {
            self.macrostep();
            if let Some(reply) = self.reply.take() {
                return Some(reply);
            }
        }
        None
    }

    /// Lets macrosteps pass until the feedback shows something.
    ///
    /// # Panics
    /// If it does not within so many seconds of virtual time.
    pub fn wait(&mut self, what: &str, seconds: f64, mut done: impl FnMut(&Feedback) -> bool) {
        let until = self.cell.now().as_secs_f64() + seconds;
        while self.cell.now().as_secs_f64() < until {
            self.macrostep();
            if self.feedback.as_ref().is_some_and(&mut done) {
                return;
            }
        }
        panic!("{what}: not within {seconds} s: {:?}", self.feedback);
    }

    /// Waits for a state.
    pub fn wait_for(&mut self, state: NodeState) {
        self.wait(&format!("{state:?}"), 90.0, |f| f.state == state);
    }

    /// Takes the lease (100 ms) and asks for the demand of every servo step.
    ///
    /// # Panics
    /// If the node refuses.
    pub fn acquire(&mut self) {
        self.talks = true;
        let reply = self.request(&Request::Acquire {
            nonce: 1,
            lease_ms: 100,
            takeover: false,
        });
        let Reply::Lease { epoch } = reply else {
            panic!("{reply:?}")
        };
        self.epoch = epoch;
        self.next_id = 0;
        self.accepted(|epoch| Request::Trace { epoch, every: 1 });
    }

    /// Makes a request that must be accepted.
    ///
    /// # Panics
    /// If it is not.
    pub fn accepted(&mut self, request: impl FnOnce(u32) -> Request) {
        let request = request(self.epoch);
        let reply = self.request(&request);
        assert_eq!(reply, Reply::Accepted, "{request:?}");
    }

    /// Lease and torque, from the start.
    pub fn enable(&mut self) {
        self.wait_for(NodeState::Disabled);
        self.acquire();
        self.accepted(|epoch| Request::Enable { epoch });
        self.wait_for(NodeState::Unsynchronised);
    }

    /// Homes the robot.
    pub fn home(&mut self) {
        self.accepted(|epoch| Request::Synchronise { epoch });
        self.wait_for(NodeState::Holding);
    }

    /// Begins an instruction; what the node replies.
    ///
    /// # Panics
    /// Without a reply.
    pub fn begin(&mut self, instruction: Instruction) -> Reply {
        self.try_begin(instruction).expect("a reply")
    }

    /// Begins an instruction; what the node replies, if anything.
    pub fn try_begin(&mut self, instruction: Instruction) -> Option<Reply> {
        self.next_id += 1;
        let (id, epoch) = (self.next_id, self.epoch);
        self.try_request(&Request::Execute {
            epoch,
            id,
            start_at: Micros(0),
            instruction,
        })
    }

    /// Carries out an instruction.
    ///
    /// # Panics
    /// If it is not carried out.
    pub fn execute(&mut self, instruction: Instruction) {
        let what = format!("{instruction:?}");
        let reply = self.begin(instruction);
        assert_eq!(reply, Reply::Accepted, "{what}");
        self.finish(&what);
    }

    /// Waits for the end of the latest instruction.
    ///
    /// # Panics
    /// If it fails.
    pub fn finish(&mut self, what: &str) {
        let id = self.next_id;
        self.wait(what, 120.0, |f| {
            f.instruction == id && !matches!(f.progress, Progress::Pending | Progress::Running)
        });
        assert_eq!(
            self.feedback().progress,
            Progress::Done,
            "{what}: {:?}",
            self.feedback()
        );
        let rest = [NodeState::Holding, NodeState::Unsynchronised];
        self.wait("rest", 10.0, |f| rest.contains(&f.state));
    }

    /// Follows knots, one a macrostep from 100 ms ahead; `knot` gives the k-th, from 1, or the end.
    ///
    /// # Panics
    /// If the node does not.
    pub fn follow(&mut self, mut knot: impl FnMut(u64) -> Option<KnotMessage>) {
        assert_eq!(self.begin(Instruction::Follow), Reply::Accepted);
        let start = self.cell.now().0 + 100_000;
        for k in 1.. {
            let Some(mut knot) = knot(k) else { break };
            knot.at = Micros(start + k * MACROSTEP.0);
            self.knots.push_back(knot);
        }
        while !self.knots.is_empty() {
            self.macrostep();
        }
        self.accepted(|epoch| Request::EndMotion { epoch });
        self.finish("follow");
    }

    /// Stops, and waits for rest or torque off.
    pub fn stop(&mut self, kind: StopKind) {
        self.accepted(|_| Request::Stop { kind });
        self.wait("stopped", 10.0, |f| {
            !matches!(
                f.state,
                NodeState::Moving | NodeState::Stopping | NodeState::Synchronising
            )
        });
    }

    /// Back to torque, whatever was latched.
    ///
    /// # Panics
    /// If there is no way.
    pub fn recover(&mut self) {
        let late = self.cell.now().as_secs_f64() + 10.0;
        while self.cell.now().as_secs_f64() < late {
            // what was asked for last shows in the feedback by then
            self.macrostep();
            self.macrostep();
            if self.feedback().epoch != self.epoch {
                self.epoch = 0;
                self.acquire();
            }
            let epoch = self.epoch;
            match self.state() {
                Some(NodeState::Faulted) => self.accepted(|epoch| Request::Acknowledge { epoch }),
                Some(NodeState::Disabled) => {
                    // the brakes may not have closed yet
                    let _ = self.request(&Request::Enable { epoch });
                }
                Some(NodeState::Holding | NodeState::Unsynchronised) => return,
                _ => {}
            }
        }
        panic!("no way back to torque: {:?}", self.feedback);
    }
}

/// The same speeds for every axis.
#[must_use]
pub fn speeds(axes: usize, velocity: f32, acceleration: f32) -> AxisSpeeds {
    AxisSpeeds {
        velocity: core::iter::repeat_n(velocity, axes).collect(),
        acceleration: core::iter::repeat_n(acceleration, axes).collect(),
    }
}
