//! A node in miniature: one axis, a frame log, SYNC every 2 ms.

use std::collections::VecDeque;

use protocol::canopen::axis::{self, Actual, Inputs, Target};
use protocol::canopen::cia402::{Goal, Master, Mode, PowerState, Statusword};
use protocol::canopen::emcy::{Emergency, ErrorCode};
use protocol::canopen::nmt::{self, Command};
use protocol::canopen::node::{Function, NodeId, frame, standard};
use protocol::canopen::sdo::{Address, BlockClient, Client, ClientError, Outcome, Progress};
use protocol::canopen::sync::SyncProducer;
use protocol::frame::Frame;
use protocol::time::Micros;

use crate::drive::parameters::MS;
use crate::plant::axis::{AxisPlant, Drive};
use crate::plant::mechanics::{Apart, Mechanics};
use crate::plant::parameters::{AxisSetup, RobotSetup, irp6_postument};
use crate::plant::robot::{Sent, SimRobot};

pub(crate) const CYCLE_NS: u64 = 2 * MS;

/// An SDO client of either kind, at time 0: nothing is ever late here.
pub(crate) trait Converse {
    fn download(&mut self, at: Address, value: &[u8]) -> Result<[u8; 8], ClientError>;
    fn upload(&mut self, at: Address) -> Result<[u8; 8], ClientError>;
    fn on_answer(&mut self, data: &[u8]) -> Progress;
    /// What it sends without being asked again.
    fn next_segment(&mut self) -> Option<[u8; 8]>;
    fn data(&self) -> &[u8];
}

impl<const N: usize> Converse for Client<N> {
    fn download(&mut self, at: Address, value: &[u8]) -> Result<[u8; 8], ClientError> {
        self.download(Micros(0), at, value)
    }
    fn upload(&mut self, at: Address) -> Result<[u8; 8], ClientError> {
        self.upload(Micros(0), at)
    }
    fn on_answer(&mut self, data: &[u8]) -> Progress {
        self.on_answer(Micros(0), data)
    }
    fn next_segment(&mut self) -> Option<[u8; 8]> {
        None
    }
    fn data(&self) -> &[u8] {
        self.data()
    }
}

impl<const N: usize> Converse for BlockClient<N> {
    fn download(&mut self, at: Address, value: &[u8]) -> Result<[u8; 8], ClientError> {
        self.download(Micros(0), at, value)
    }
    fn upload(&mut self, at: Address) -> Result<[u8; 8], ClientError> {
        self.upload(Micros(0), at)
    }
    fn on_answer(&mut self, data: &[u8]) -> Progress {
        self.on_answer(Micros(0), data)
    }
    fn next_segment(&mut self) -> Option<[u8; 8]> {
        self.next_segment()
    }
    fn data(&self) -> &[u8] {
        self.data()
    }
}

/// A constant weight.
pub(crate) struct Weight(pub(crate) f64);

impl Mechanics for Weight {
    fn axes(&self) -> Option<usize> {
        None
    }

    fn step(&mut self, plants: &mut [AxisPlant], commands: &[Drive], _dt_s: f64) {
        for (plant, command) in plants.iter_mut().zip(commands) {
            plant.step(*command, self.0);
        }
    }
}

pub(crate) struct Bench {
    pub(crate) robot: SimRobot,
    pub(crate) node: NodeId,
    pub(crate) master: Master,
    pub(crate) target: Target,
    pub(crate) status: Statusword,
    pub(crate) actual: Actual,
    pub(crate) inputs: Option<Inputs>,
    pub(crate) log: Vec<Sent>,
    pub(crate) now_ns: u64,
    /// Does the node send its RPDO, its SYNC?
    pub(crate) talks: bool,
    pub(crate) syncs: bool,
    sync: SyncProducer,
}

/// Axis `index` of the postument robot alone, starting at `start_rad`.
pub(crate) fn axis_setup(index: usize, start_rad: f64) -> AxisSetup {
    AxisSetup {
        start_rad,
        ..irp6_postument(1).axes[index]
    }
}

impl Bench {
    pub(crate) fn new(axis: &AxisSetup) -> Self {
        Self::loaded(axis, Box::new(Apart))
    }

    pub(crate) fn loaded(axis: &AxisSetup, mechanics: Box<dyn Mechanics>) -> Self {
        let node = NodeId::new(axis.node).unwrap();
        let robot = SimRobot::new(
            RobotSetup {
                axes: vec![*axis],
                mechanics,
            },
            1,
        )
        .unwrap();
        Self {
            robot,
            node,
            master: Master::default(),
            target: Target::Position(0),
            status: Statusword(0),
            actual: Actual {
                statusword: 0,
                position: 0,
                torque: 0,
            },
            inputs: None,
            log: Vec::new(),
            now_ns: 0,
            talks: true,
            syncs: true,
            sync: SyncProducer::new(protocol::canopen::sync::DEFAULT_COB, 0),
        }
    }

    fn keep(&mut self, sent: &[Sent]) {
        for item in sent {
            self.log.push(*item);
            let cob = standard(&item.frame).unwrap();
            if cob == self.node.cob(Function::Tpdo1) {
                if let Some(actual) = Actual::decode(item.frame.data()) {
                    self.actual = actual;
                    self.status = Statusword(actual.statusword);
                }
            } else if cob == self.node.cob(Function::Tpdo2) {
                self.inputs = Inputs::decode(item.frame.data());
            }
        }
    }

    pub(crate) fn send(&mut self, frame: &Frame) -> Vec<Sent> {
        let mut sent = Vec::new();
        self.robot
            .on_frame(0, self.now_ns, frame, &mut |item| sent.push(item));
        self.keep(&sent);
        sent
    }

    /// Lets time pass without SYNC.
    pub(crate) fn wait(&mut self, ms: u64) {
        self.pass_ns(ms * MS);
    }

    /// The same, in nanoseconds.
    pub(crate) fn pass_ns(&mut self, ns: u64) {
        self.now_ns += ns;
        let mut sent = Vec::new();
        self.robot.advance(self.now_ns, &mut |item| sent.push(item));
        self.keep(&sent);
    }

    /// One cycle: SYNC, then the RPDO for the next one.
    pub(crate) fn cycle(&mut self) {
        if self.syncs {
            let sync = self.sync.produce();
            self.send(&sync);
        }
        if self.talks {
            let word = self.master.next(self.status);
            let frame = axis::command(self.node, word.0, self.target, None);
            self.send(&frame);
        }
        self.wait(CYCLE_NS / MS);
    }

    pub(crate) fn cycles(&mut self, count: u64) {
        (0..count).for_each(|_| self.cycle());
    }

    pub(crate) fn write(&mut self, index: u16, value: &[u8]) -> Outcome {
        self.write_sub(index, 0, value)
    }

    pub(crate) fn write_sub(&mut self, index: u16, sub: u8, value: &[u8]) -> Outcome {
        let mut client = Client::<64>::default();
        let request = client
            .download(Micros(0), Address::new(index, sub), value)
            .unwrap();
        self.converse(&mut client, request)
    }

    pub(crate) fn read(&mut self, index: u16, sub: u8) -> u32 {
        let mut client = Client::<64>::default();
        let request = client.upload(Micros(0), Address::new(index, sub)).unwrap();
        let outcome = self.converse(&mut client, request);
        assert_eq!(outcome, Outcome::Uploaded(Address::new(index, sub)));
        client.number().unwrap()
    }

    pub(crate) fn text(&mut self, index: u16) -> Vec<u8> {
        let mut client = Client::<64>::default();
        let request = client.upload(Micros(0), Address::new(index, 0)).unwrap();
        self.converse(&mut client, request);
        client.data().to_vec()
    }

    /// Runs a transfer that begins with this request to its end.
    pub(crate) fn converse(&mut self, client: &mut dyn Converse, first: [u8; 8]) -> Outcome {
        let request = self.node.cob(Function::SdoRequest);
        let answer = Some(self.node.cob(Function::SdoAnswer));
        let mut waiting = VecDeque::from([first]);
        // 64 KiB are 9363 segments, each with an answer or a millisecond
        for _ in 0..40_000 {
            let sent = if let Some(next) = waiting.pop_front() {
                self.send(&frame(request, next))
            } else {
                let before = self.log.len();
                self.wait(1);
                self.log.split_off(before)
            };
            for item in sent {
                if standard(&item.frame) != answer {
                    continue;
                }
                match client.on_answer(item.frame.data()) {
                    Progress::Send(next) => waiting.push_back(next),
                    Progress::Done(outcome) => return outcome,
                    Progress::End(last, outcome) => {
                        self.send(&frame(request, last));
                        return outcome;
                    }
                    Progress::Ignored => {}
                }
                while let Some(segment) = client.next_segment() {
                    waiting.push_back(segment);
                }
            }
        }
        panic!("the transfer never ended");
    }

    pub(crate) fn nmt(&mut self, command: Command) {
        let frame = nmt::command_frame(command, nmt::Target::Node(self.node));
        self.send(&frame);
    }

    /// Boots, starts the network and chooses a mode; still without torque.
    pub(crate) fn start(&mut self, mode: Mode) {
        self.wait(200);
        self.write(0x6060, &mode.code().to_le_bytes());
        self.target = match mode {
            Mode::Cst => Target::Torque(0),
            Mode::None | Mode::Pp | Mode::Pv | Mode::Homing | Mode::Csp | Mode::Csv => {
                Target::Position(0)
            }
        };
        self.nmt(Command::Start);
        self.cycles(2);
    }

    /// Boots and enables in a mode.
    pub(crate) fn enable(&mut self, mode: Mode) {
        self.start(mode);
        self.master.set_goal(Goal::Enabled);
        self.cycles(40);
        assert_eq!(self.status.state(), Some(PowerState::OperationEnabled));
    }

    pub(crate) fn state(&self) -> PowerState {
        self.robot.drive(0).unwrap().power_state()
    }

    pub(crate) fn motor_rad(&self) -> f64 {
        self.robot.motor_rad()[0]
    }

    pub(crate) fn velocity(&self) -> f64 {
        self.robot.plant(0).unwrap().velocity_rad_s()
    }

    pub(crate) fn emergencies(&self) -> Vec<ErrorCode> {
        let emergencies = self
            .log
            .iter()
            .filter_map(|item| Emergency::decode(&item.frame));
        emergencies.map(|(_, emergency)| emergency.code).collect()
    }
}

/// Drive units per motor radian at 4000 increments a turn.
pub(crate) const UNITS_PER_RAD: f64 = 4_000_000.0 / core::f64::consts::TAU;

/// A position in drive units.
#[expect(
    clippy::cast_possible_truncation,
    reason = "a test's positions are small"
)]
pub(crate) fn units(rad: f64) -> i32 {
    (rad * UNITS_PER_RAD) as i32
}
