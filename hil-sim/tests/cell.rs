//! A node in its cell, commanded over the wire by a coordinator that is only an endpoint.

use bus::wire::confinement::State;
use bus::wire::{Disturbance, Fault as LineFault, Kind};
use firmware::Station;
use firmware::config::ForceAddress;
use firmware::process::drive_buses;
use hil_sim::cell::{Cell, Observer, Wiring};
use hil_sim::drive::DriveFault;
use hil_sim::drive::quirk::Quirks;
use protocol::budget::{self, Rates};
use protocol::canopen::emcy::ErrorCode;
use protocol::fault::{Cause, Refusal};
use protocol::frame::{Frame, Id};
use protocol::id::NodeId;
use protocol::link::{Endpoint, Message, Role};
use protocol::message::{
    AxisSpeeds, Command, Coordination, Feedback, Instruction, NodeState, Progress, Reply, Request,
    ServoLaw,
};
use protocol::time::Micros;
use protocol::transfer::Mtu;
use robots::{RobotKind, TrackRule};

#[path = "cell/bus_faults.rs"]
mod bus_faults;
#[path = "cell/encoder_faults.rs"]
mod encoder_faults;
#[path = "cell/fast.rs"]
mod fast;
#[path = "cell/force.rs"]
mod force;
#[path = "cell/layer.rs"]
mod layer;
#[path = "cell/quirks.rs"]
mod quirks;
#[path = "cell/runaway.rs"]
mod runaway;
#[path = "cell/scenario.rs"]
mod scenario;
#[path = "cell/stored.rs"]
mod stored;

const NODE: NodeId = match NodeId::effector(1) {
    Some(node) => node,
    None => panic!(),
};

struct Coordinator {
    cell: Cell,
    link: Endpoint<16>,
    epoch: u32,
    sequence: u16,
    feedback: Option<Feedback>,
    reply: Option<Reply>,
    next_id: u32,
}

impl Coordinator {
    fn new(kind: RobotKind, law: ServoLaw) -> Self {
        Self::with(kind, law, Quirks::default())
    }

    fn with(kind: RobotKind, law: ServoLaw, quirks: Quirks) -> Self {
        Self::wired(kind, law, quirks, None)
    }

    fn wired(kind: RobotKind, law: ServoLaw, quirks: Quirks, force: Option<ForceAddress>) -> Self {
        let mut cell = Cell::new(Kind::Fd).with_quirks(quirks);
        let station = Station {
            effector: 1,
            unique_id: 7,
            mtu: Mtu::Fd,
            law,
            velocity_factor: 0.2,
            one_wire: false,
            track: TrackRule::Keep,
        };
        let buses = drive_buses(kind);
        cell.add(
            kind,
            &station,
            &Wiring {
                force,
                ..Wiring::classic(&buses)
            },
            1,
        )
        .unwrap();
        let link = Endpoint::new(NodeId::MP, Role::Coordinator, Mtu::Fd);
        Self {
            cell,
            link,
            epoch: 0,
            sequence: 0,
            feedback: None,
            reply: None,
            next_id: 0,
        }
    }

    fn macrostep(&mut self, observer: &mut impl Observer) {
        let mut frames = Vec::new();
        if self.epoch != 0 {
            self.sequence = self.sequence.wrapping_add(1);
            let command = Command {
                epoch: self.epoch,
                sequence: self.sequence,
                valid_until: self.cell.now() + Micros(50_000),
                coordination: Coordination::None,
            };
            self.link
                .send_command(NODE, &command, &mut |f| frames.push(f))
                .unwrap();
        }
        for frame in frames {
            self.cell.send(frame);
        }
        self.cell
            .advance(self.cell.now() + Micros(20_000), observer);
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

    fn request(&mut self, request: &Request) -> Reply {
        let mut frames = Vec::new();
        self.link
            .send_request(NODE, request, &mut |f| frames.push(f))
            .unwrap();
        for frame in frames {
            self.cell.send(frame);
        }
        self.reply = None;
        for _ in 0..5 {
            self.macrostep(&mut ());
            if let Some(reply) = self.reply.take() {
                return reply;
            }
        }
        panic!("no reply to {request:?}");
    }

    fn state(&self) -> Option<NodeState> {
        self.feedback.as_ref().map(|f| f.state)
    }

    fn wait(&mut self, what: &str, seconds: f64, mut done: impl FnMut(&Feedback) -> bool) {
        let until = self.cell.now().as_secs_f64() + seconds;
        while self.cell.now().as_secs_f64() < until {
            self.macrostep(&mut ());
            if self.feedback.as_ref().is_some_and(&mut done) {
                return;
            }
        }
        panic!("{what}: not within {seconds} s: {:?}", self.feedback);
    }

    fn enable(&mut self) {
        self.wait("disabled", 5.0, |f| f.state == NodeState::Disabled);
        let reply = self.request(&Request::Acquire {
            nonce: 1,
            lease_ms: 100,
            takeover: false,
        });
        let Reply::Lease { epoch } = reply else {
            panic!("{reply:?}")
        };
        self.epoch = epoch;
        assert_eq!(self.request(&Request::Enable { epoch }), Reply::Accepted);
        self.wait("enabled", 3.0, |f| f.state == NodeState::Unsynchronised);
    }

    fn home(&mut self) {
        let epoch = self.epoch;
        assert_eq!(
            self.request(&Request::Synchronise { epoch }),
            Reply::Accepted
        );
        self.wait("homed", 90.0, |f| f.state == NodeState::Holding);
    }

    fn execute(&mut self, instruction: Instruction) -> Feedback {
        self.next_id += 1;
        let (id, epoch) = (self.next_id, self.epoch);
        let request = Request::Execute {
            epoch,
            id,
            start_at: Micros(0),
            instruction,
        };
        assert_eq!(self.request(&request), Reply::Accepted);
        self.wait("executed", 60.0, |f| {
            f.instruction == id && !matches!(f.progress, Progress::Pending | Progress::Running)
        });
        self.feedback.clone().unwrap()
    }
}

fn speeds(axes: usize, fraction: f32) -> AxisSpeeds {
    let all = core::iter::repeat_n(fraction, axes);
    AxisSpeeds {
        velocity: all.clone().collect(),
        acceleration: all.collect(),
    }
}

fn homes_and_moves(kind: RobotKind, law: ServoLaw, target: &[f64]) {
    let mut c = Coordinator::new(kind, law);
    c.enable();
    assert_eq!(c.state(), Some(NodeState::Unsynchronised));
    c.home();
    let rest: Vec<f64> = c.cell.robots().next().unwrap().1.motor_rad().to_vec();
    for (axis, rad) in rest.iter().enumerate() {
        // one encoder increment is 1.6 to 3.1 mrad; gravity and friction leave a few
        assert!(
            rad.abs() < 0.1,
            "axis {axis} rests at {rad} rad, not on its index"
        );
    }
    let done = c.execute(Instruction::MoveJoints {
        target: target.iter().copied().collect(),
        relative: false,
        speeds: speeds(kind.axes(), 0.2),
    });
    assert_eq!(done.progress, Progress::Done, "{done:?}");
    assert_eq!(done.fault, None);
    assert_eq!(done.limit_violations, 0);
    assert_eq!(c.cell.refused(), []);
}

const FRONT: [f64; 6] = [0.0, -1.57, 0.0, 1.56, 1.57, -1.57];

#[test]
fn the_postument_homes_and_moves_with_every_law() {
    for law in [
        ServoLaw::DrivePosition,
        ServoLaw::Original,
        ServoLaw::FeedForward,
    ] {
        homes_and_moves(RobotKind::Irp6Postument, law, &FRONT);
    }
}

#[test]
fn the_track_homes_and_moves() {
    let target = [0.1, 0.0, -1.57, 0.0, 1.56, 1.57, -1.57];
    homes_and_moves(RobotKind::Irp6Track, ServoLaw::DrivePosition, &target);
}

#[test]
fn every_bus_has_rates_of_its_own() {
    // the first frame of each bus: the nodes announce themselves and talk to their drives
    let first = |changed: Option<usize>| {
        let mut c = Coordinator::new(RobotKind::Irp6Track, ServoLaw::DrivePosition);
        if let Some(bus) = changed {
            let half = Rates {
                nominal: 500_000,
                data: 2_500_000,
            };
            assert!(c.cell.set_rates(bus, half));
        }
        let mut heard = FirstFrames(vec![None; c.cell.bus_names().len()]);
        c.macrostep(&mut heard);
        heard.0
    };
    let usual = first(None);
    assert_eq!(usual.len(), 3);
    for bus in 0..usual.len() {
        for (other, (at, was)) in first(Some(bus)).into_iter().zip(&usual).enumerate() {
            let (at, was) = (at.unwrap(), was.unwrap());
            // all are sent in the node's first step, and last whole nanoseconds a bit
            let began = was.0 - was.1;
            let lasts = if other == bus { 2 * was.1 } else { was.1 };
            assert_eq!(
                at.0,
                began + lasts,
                "bus {other} with the rates of {bus} halved"
            );
        }
    }
    let mut cell = Cell::new(Kind::Fd);
    assert!(cell.set_rates(0, Rates::FD_1M_8M));
    assert!(!cell.set_rates(1, Rates::CLASSIC_1M), "there is no robot");
}

/// When the first frame of each bus ended, and how long it lasts at the usual rates, ns.
struct FirstFrames(Vec<Option<(u64, u64)>>);

impl Observer for FirstFrames {
    fn frame(&mut self, bus: usize, at_ns: u64, frame: &Frame) {
        let lasts = Rates::FD_1M_5M.duration_ns(budget::exact(frame));
        self.0[bus].get_or_insert((at_ns, lasts));
    }
}

#[test]
fn a_tripped_drive_stops_the_robot_and_is_brought_back_by_acknowledging() {
    let mut c = Coordinator::new(RobotKind::Irp6Postument, ServoLaw::DrivePosition);
    c.enable();
    c.home();
    let (id, epoch) = (1, c.epoch);
    let instruction = Instruction::MoveJoints {
        target: FRONT.iter().copied().collect(),
        relative: false,
        speeds: speeds(6, 0.2),
    };
    let request = Request::Execute {
        epoch,
        id,
        start_at: Micros(0),
        instruction,
    };
    assert_eq!(c.request(&request), Reply::Accepted);
    c.wait("moving", 2.0, |f| f.state == NodeState::Moving);
    let over_current = DriveFault::Trip(ErrorCode::OVER_CURRENT);
    assert!(c.cell.robot_mut(0).unwrap().inject(2, Some(over_current)));
    c.wait("faulted", 3.0, |f| f.state == NodeState::Faulted);
    let fault = c.feedback.as_ref().and_then(|f| f.fault).unwrap();
    assert_eq!((fault.cause, fault.axis), (Cause::DriveFault, Some(2)));
    assert_eq!(fault.during, NodeState::Moving);
    // nothing but an acknowledgement leads on
    let enable = Request::Enable { epoch };
    assert_eq!(
        c.request(&enable),
        Reply::Refused(Refusal::FaultLatched {
            cause: Cause::DriveFault
        })
    );
    assert!(c.cell.robot_mut(0).unwrap().inject(2, None));
    assert_eq!(c.request(&Request::Acknowledge { epoch }), Reply::Accepted);
    c.wait("configured", 5.0, |f| f.state == NodeState::Disabled);
    assert_eq!(c.request(&enable), Reply::Accepted);
    // it is still homed: the drive kept counting
    c.wait("enabled", 3.0, |f| f.state == NodeState::Holding);
    c.next_id = id;
    let done = c.execute(Instruction::MoveJoints {
        target: FRONT.iter().copied().collect(),
        relative: false,
        speeds: speeds(6, 0.2),
    });
    assert_eq!(done.progress, Progress::Done);
}

/// The drive bus of a robot with one, and the node's tap on it.
const DRIVE_BUS: usize = 1;
const NODE_TAP: usize = 0;

/// A move under way, and then so many tries of the node's frames that come to nothing.
fn disturbed_in_motion(count: u32) -> Coordinator {
    let mut c = Coordinator::new(RobotKind::Irp6Postument, ServoLaw::DrivePosition);
    c.enable();
    let request = Request::Execute {
        epoch: c.epoch,
        id: 1,
        start_at: Micros(0),
        instruction: Instruction::MoveMotors {
            target: [60.0, 20.0, 20.0, 20.0, 20.0, 20.0].into_iter().collect(),
            relative: true,
            speeds: speeds(6, 0.5),
        },
    };
    assert_eq!(c.request(&request), Reply::Accepted);
    c.wait("moving", 2.0, |f| f.state == NodeState::Moving);
    for _ in 0..10 {
        c.macrostep(&mut ());
    }
    let from_ns = c.cell.now_ns();
    c.cell.wire_mut(DRIVE_BUS).unwrap().disturb(LineFault {
        from_ns,
        // SYNC, which only the node sends
        id: Some(Id::Standard(0x080)),
        sender: None,
        count,
        disturbance: Disturbance::Bit(10),
    });
    c
}

#[test]
fn frames_that_are_destroyed_and_sent_again_disturb_no_motion() {
    // each costs a SYNC 31 us; fifteen in a row still leave time for the cycle: 15 · 8 = 120 is active
    let mut c = disturbed_in_motion(15);
    c.wait("done", 20.0, |f| f.progress == Progress::Done);
    let feedback = c.feedback.as_ref().unwrap();
    assert_eq!((feedback.fault, feedback.limit_violations), (None, 0));
    let wire = c.cell.wire_mut(DRIVE_BUS).unwrap();
    assert_eq!(wire.statistics().errors, 15);
    assert_eq!(wire.state(NODE_TAP), State::Active);
}

#[test]
fn a_node_that_is_bus_off_stops_and_its_recovery_resumes_nothing() {
    let mut c = disturbed_in_motion(32);
    c.wait("faulted", 3.0, |f| f.state == NodeState::Faulted);
    let wire = c.cell.wire_mut(DRIVE_BUS).unwrap();
    assert_eq!(wire.state(NODE_TAP), State::BusOff);
    assert_eq!(wire.statistics().bus_off, 1);
    let fault = c.feedback.as_ref().and_then(|f| f.fault).unwrap();
    assert_eq!(
        (fault.cause, fault.during),
        (Cause::DriveSilent, NodeState::Moving)
    );
    // the drives have stopped by themselves: nobody could tell them
    for _ in 0..25 {
        c.macrostep(&mut ());
    }
    let rest = c.cell.robots().next().unwrap().1.motor_rad().to_vec();
    let wire = c.cell.wire_mut(DRIVE_BUS).unwrap();
    wire.clear(NODE_TAP);
    wire.recover(NODE_TAP);
    for _ in 0..50 {
        c.macrostep(&mut ());
    }
    let wire = c.cell.wire_mut(DRIVE_BUS).unwrap();
    assert_eq!(wire.state(NODE_TAP), State::Active);
    assert_eq!(c.state(), Some(NodeState::Faulted));
    let later = c.cell.robots().next().unwrap().1.motor_rad().to_vec();
    for (before, after) in rest.iter().zip(&later) {
        // a motor that is braked creeps by less than an encoder increment
        assert!((after - before).abs() < 1.6e-3, "{rest:?} {later:?}");
    }
}
