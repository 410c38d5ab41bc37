//! A coordinator that is only an endpoint on a bus, with a time of its own.

use super::child::PATIENCE;
use bus::hub::HubClient;
use bus::{Bus, BusError};
use protocol::clock::Master;
use protocol::frame::Frame;
use protocol::id::NodeId;
use protocol::link::{Endpoint, Message, Role};
use protocol::message::{
    AxisSpeeds, Command, Coordination, Event, Feedback, Instruction, NodeState, Progress, Reply,
    Request,
};
use protocol::time::Micros;
use protocol::transfer::Mtu;
use std::thread;
use std::time::Duration;

/// The lease: generous, for a noisy machine.
const LEASE_MS: u16 = 500;
/// One cycle of the coordinator.
const CYCLE: Micros = Micros(20_000);

/// One node as its coordinator sees it.
pub(crate) struct Robot {
    pub(crate) node: NodeId,
    pub(crate) axes: usize,
    pub(crate) feedback: Option<Feedback>,
    pub(crate) fault_events: usize,
    epoch: u32,
    sequence: u16,
    reply: Option<Reply>,
    instruction: u32,
}

impl Robot {
    pub(crate) fn state(&self) -> Option<NodeState> {
        self.feedback.as_ref().map(|feedback| feedback.state)
    }

    pub(crate) fn demand(&self) -> Vec<i64> {
        let feedback = self.feedback.as_ref().unwrap();
        feedback.demand.iter().copied().collect()
    }
}

pub(crate) struct Coordinator {
    bus: Box<dyn Bus>,
    link: Endpoint<32>,
    master: Master,
    origin: Micros,
    next: Micros,
    pub(crate) robots: Vec<Robot>,
}

impl Coordinator {
    /// Joins a hub's channel `mp`.
    pub(crate) fn join(port: u16, robots: &[(u8, usize)]) -> Self {
        Self::on(Self::hub(port), Mtu::Classic, robots)
    }

    /// A hub's channel `mp`.
    pub(crate) fn hub(port: u16) -> Box<dyn Bus> {
        let patience = Micros(u64::try_from(PATIENCE.as_micros()).unwrap());
        let bus = HubClient::connect("127.0.0.1", port, "mp", bus::now() + patience);
        Box::new(bus.unwrap())
    }

    /// Joins a bus; its time starts at 0, as that of any process.
    pub(crate) fn on(bus: Box<dyn Bus>, mtu: Mtu, robots: &[(u8, usize)]) -> Self {
        let origin = bus::now();
        let robot = |&(effector, axes): &(u8, usize)| Robot {
            node: NodeId::effector(effector).unwrap(),
            axes,
            feedback: None,
            fault_events: 0,
            epoch: 0,
            sequence: 0,
            reply: None,
            instruction: 0,
        };
        Self {
            bus,
            link: Endpoint::new(NodeId::MP, Role::Coordinator, mtu),
            master: Master::default(),
            origin,
            next: Micros(0),
            robots: robots.iter().map(robot).collect(),
        }
    }

    fn now(&self) -> Micros {
        bus::now().since(self.origin)
    }

    /// Sends a frame; while there is no bus it is lost, as anybody's.
    fn send(&mut self, frame: &Frame) {
        match self.bus.send(frame) {
            Ok(()) | Err(BusError::Down { .. }) => {}
            Err(error) => panic!("{error}"),
        }
    }

    /// One cycle: time and leases out, images in.
    pub(crate) fn cycle(&mut self) {
        let mut frames = Vec::new();
        let sync = self.master.message();
        self.link
            .send_time_sync(&sync, &mut |frame| frames.push(frame))
            .unwrap();
        let valid_until = self.now() + Micros::from_millis(300);
        for robot in self.robots.iter_mut().filter(|robot| robot.epoch != 0) {
            robot.sequence = robot.sequence.wrapping_add(1);
            let command = Command {
                epoch: robot.epoch,
                sequence: robot.sequence,
                valid_until,
                coordination: Coordination::None,
            };
            let out = &mut |frame| frames.push(frame);
            self.link.send_command(robot.node, &command, out).unwrap();
        }
        self.master.sent(self.now());
        for frame in frames {
            self.send(&frame);
        }
        self.next = self.next + CYCLE;
        let left = self.next.since(self.now());
        if left == Micros(0) {
            self.next = self.now();
        }
        thread::sleep(Duration::from_micros(left.0));
        while let Some(received) = self.bus.receive().unwrap() {
            let Some(incoming) = self.link.receive(&received.frame, received.at) else {
                continue;
            };
            let from = self
                .robots
                .iter_mut()
                .find(|robot| robot.node == incoming.from);
            let Some(robot) = from else { continue };
            match incoming.message {
                Message::Feedback(feedback) => robot.feedback = Some(feedback),
                Message::Reply { reply, .. } => robot.reply = Some(reply),
                Message::Event(Event::Fault(_)) => robot.fault_events += 1,
                _ => {}
            }
        }
    }

    /// Waits until something holds of every robot.
    pub(crate) fn wait(&mut self, what: &str, holds: impl Fn(&Robot) -> bool) {
        let until = bus::now() + Micros(u64::try_from(PATIENCE.as_micros()).unwrap());
        while !self
            .robots
            .iter()
            .all(|robot| robot.feedback.is_some() && holds(robot))
        {
            assert!(bus::now() < until, "never {what}: {:#?}", self.images());
            self.cycle();
        }
    }

    fn images(&self) -> Vec<&Option<Feedback>> {
        self.robots.iter().map(|robot| &robot.feedback).collect()
    }

    /// Asks every robot and returns its answers.
    pub(crate) fn ask(&mut self, request: impl Fn(&Robot) -> Request) -> Vec<Reply> {
        for k in 0..self.robots.len() {
            self.robots[k].reply = None;
            let (node, request) = (self.robots[k].node, request(&self.robots[k]));
            let mut frames = Vec::new();
            self.link
                .send_request(node, &request, &mut |frame| frames.push(frame))
                .unwrap();
            for frame in frames {
                self.send(&frame);
            }
        }
        let until = bus::now() + Micros(u64::try_from(PATIENCE.as_micros()).unwrap());
        while self.robots.iter().any(|robot| robot.reply.is_none()) {
            assert!(bus::now() < until, "no answer: {:#?}", self.images());
            self.cycle();
        }
        self.robots
            .iter_mut()
            .filter_map(|robot| robot.reply.take())
            .collect()
    }

    /// Asks every robot for what none of them may refuse.
    pub(crate) fn demand(&mut self, request: impl Fn(&Robot, u32) -> Request) {
        let replies = self.ask(|robot| request(robot, robot.epoch));
        assert!(
            replies.iter().all(|reply| *reply == Reply::Accepted),
            "{replies:?}"
        );
    }

    /// Takes the lease of every robot.
    pub(crate) fn acquire(&mut self) {
        let request = Request::Acquire {
            nonce: 7,
            lease_ms: LEASE_MS,
            takeover: false,
        };
        let replies = self.ask(|_| request.clone());
        for (robot, reply) in self.robots.iter_mut().zip(replies) {
            let Reply::Lease { epoch } = reply else {
                panic!("{reply:?}")
            };
            (robot.epoch, robot.sequence, robot.instruction) = (epoch, 0, 0);
        }
    }

    /// Starts a relative move: axis k by (k + 1) times `rad`, all arriving together.
    pub(crate) fn start(&mut self, rad: f64) {
        for robot in &mut self.robots {
            robot.instruction += 1;
        }
        self.demand(|robot, epoch| Request::Execute {
            epoch,
            id: robot.instruction,
            start_at: Micros(0),
            instruction: Instruction::MoveMotors {
                target: shape(robot.axes).map(|share| share * rad).collect(),
                relative: true,
                speeds: AxisSpeeds {
                    velocity: core::iter::repeat_n(0.5, robot.axes).collect(),
                    acceleration: core::iter::repeat_n(0.5, robot.axes).collect(),
                },
            },
        });
    }

    /// The move that was started has been completed.
    pub(crate) fn done(&mut self) {
        self.wait("done", |robot| {
            let feedback = robot.feedback.as_ref().unwrap();
            assert_eq!(feedback.fault, None);
            feedback.instruction == robot.instruction && feedback.progress == Progress::Done
        });
    }
}

/// The shares of the axes in a move.
fn shape(axes: usize) -> impl Iterator<Item = f64> {
    (0..axes).map(|k| 1.0 - 0.1 * f64::from(u8::try_from(k).unwrap()))
}
