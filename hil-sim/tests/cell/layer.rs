//! The node as master of layer setting: blank drives, wrong ones, none, late ones, two of one identity.
//!
//! A bench without wires, so that each drive can be made otherwise: what one sends the other hears at once.

use super::*;
use firmware::{KnownDrives, NodeProcess, Port, Received};
use hil_sim::drive::quirk::Quirk;
use hil_sim::plant::parameters::RobotSetup;
use hil_sim::plant::robot::{SUBSTEP_NS, SimRobot};
use protocol::canopen::lss::{Identity, MASTER_COB};
use protocol::canopen::nmt;
use protocol::message::{DriveFinding, DriveIdentity, Event};

/// One with a single bus of six drives.
const KIND: RobotKind = RobotKind::Irp6Postument;

/// The drives' identities are those of their dictionary; the serial number is the axis, from 1.
const fn identity(serial: u32) -> Identity {
    Identity {
        vendor: 0,
        product: 402,
        revision: 0x0001_0000,
        serial,
    }
}

fn wire(serial: u32) -> DriveIdentity {
    identity(serial).into()
}

/// What a node told: bus, axis, finding, expected, got.
pub(super) type Found = (
    u8,
    Option<u8>,
    DriveFinding,
    Option<DriveIdentity>,
    Option<DriveIdentity>,
);

pub(super) struct Bench {
    pub(super) node: Box<dyn NodeProcess + Send>,
    pub(super) robot: SimRobot,
    link: Endpoint<16>,
    pub(super) now_ns: u64,
    pub(super) found: Vec<Found>,
    /// Requests of layer setting: when, and the first bytes.
    asked: Vec<(u64, [u8; 2])>,
    pub(super) fault: Option<(Cause, Option<u8>)>,
    /// SDO requests of the node: to whom, and the bytes.
    pub(super) requests: Vec<(u16, [u8; 8])>,
    epoch: u32,
    sequence: u16,
    to_node: Vec<Frame>,
    reply: Option<Reply>,
}

impl Bench {
    pub(super) fn new(known: &KnownDrives<'_>, change: impl FnOnce(&mut RobotSetup)) -> Self {
        let (node, drives) = Self::start(known, 0);
        let mut setup = hil_sim::cell::setup(KIND, &drives, 1, Quirks::default());
        change(&mut setup);
        Self {
            node,
            robot: SimRobot::new(setup, 1).unwrap(),
            link: Endpoint::new(NodeId::MP, Role::Coordinator, Mtu::Fd),
            now_ns: 0,
            found: Vec::new(),
            asked: Vec::new(),
            fault: None,
            requests: Vec::new(),
            epoch: 0,
            sequence: 0,
            to_node: Vec::new(),
            reply: None,
        }
    }

    /// A node that begins at this time, and where it expects its drives.
    fn start(
        known: &KnownDrives<'_>,
        now_ns: u64,
    ) -> (Box<dyn NodeProcess + Send>, Vec<firmware::DriveAddress>) {
        let station = Station {
            effector: 1,
            unique_id: 7,
            mtu: Mtu::Fd,
            law: ServoLaw::DrivePosition,
            velocity_factor: 0.2,
            one_wire: false,
            track: TrackRule::Keep,
        };
        let buses = drive_buses(KIND);
        let wiring = Wiring {
            drives: *known,
            ..Wiring::classic(&buses)
        };
        hil_sim::cell::node(KIND, &station, &wiring, Micros(now_ns / 1000)).unwrap()
    }

    /// Another node in the place of this one: its drives stay as they are.
    pub(super) fn restart(&mut self, known: &KnownDrives<'_>) {
        (self.node, _) = Self::start(known, self.now_ns);
        self.link = Endpoint::new(NodeId::MP, Role::Coordinator, Mtu::Fd);
        self.epoch = 0;
        self.requests.clear();
    }

    /// Axes, from 0, lose their node ids.
    fn blank(mut self, axes: &[usize]) -> Self {
        for axis in axes {
            self.lose(*axis);
        }
        self
    }

    fn lose(&mut self, axis: usize) {
        assert!(self.robot.inject(axis, Some(DriveFault::Blank)));
    }

    fn step(&mut self) {
        self.now_ns += SUBSTEP_NS;
        let (now, now_ns) = (Micros(self.now_ns / 1000), self.now_ns);
        let mut rx: Vec<Received> = Vec::new();
        let drives = |frame| Received {
            port: Port::Drives(0),
            at: now,
            frame,
        };
        self.robot
            .advance(now_ns, &mut |sent| rx.push(drives(sent.frame)));
        rx.extend(self.to_node.drain(..).map(|frame| Received {
            port: Port::Mp,
            at: now,
            frame,
        }));
        let mut out = Vec::new();
        if self.node.next_wake() > now && rx.is_empty() {
            return;
        }
        self.node
            .step(now, &rx, &mut |port, frame| out.push((port, frame)));
        let mut back: Vec<Received> = Vec::new();
        for (port, frame) in out {
            match port {
                Port::Mp => self.hear(now, &frame),
                Port::Drives(bus) => {
                    if frame.id() == Id::Standard(MASTER_COB) {
                        let [a, b, ..] = *frame.data() else { panic!() };
                        self.asked.push((now_ns, [a, b]));
                    }
                    if let Id::Standard(cob @ 0x601..=0x67F) = frame.id() {
                        let bytes = frame.data().try_into().unwrap();
                        self.requests.push((cob, bytes));
                    }
                    self.robot.on_frame(bus, now_ns, &frame, &mut |sent| {
                        back.push(drives(sent.frame));
                    });
                }
            }
        }
        self.node
            .step(now, &back, &mut |_, _| panic!("nothing is due"));
    }

    fn hear(&mut self, now: Micros, frame: &Frame) {
        match self
            .link
            .receive(frame, now)
            .map(|incoming| incoming.message)
        {
            Some(Message::Event(Event::DriveFound {
                bus,
                axis,
                finding,
                expected,
                got,
            })) => self.found.push((bus, axis, finding, expected, got)),
            Some(Message::Event(Event::Fault(fault))) => {
                self.fault = Some((fault.cause, fault.axis));
            }
            Some(Message::Reply { reply, .. }) => self.reply = Some(reply),
            _ => {}
        }
    }

    pub(super) fn ask(&mut self, request: &Request) -> Reply {
        let to_node = &mut self.to_node;
        self.link
            .send_request(NODE, request, &mut |frame| to_node.push(frame))
            .unwrap();
        self.reply = None;
        for _ in 0..100 {
            self.step();
            if let Some(reply) = self.reply.take() {
                return reply;
            }
        }
        panic!("no reply to {request:?}");
    }

    pub(super) fn run_ms(&mut self, ms: u64) {
        for _ in 0..ms * 1_000_000 / SUBSTEP_NS {
            if self.epoch != 0 && self.now_ns.is_multiple_of(20_000_000) {
                self.sequence = self.sequence.wrapping_add(1);
                let command = Command {
                    epoch: self.epoch,
                    sequence: self.sequence,
                    valid_until: Micros(self.now_ns / 1000 + 50_000),
                    coordination: Coordination::None,
                };
                let to_node = &mut self.to_node;
                self.link
                    .send_command(NODE, &command, &mut |frame| to_node.push(frame))
                    .unwrap();
            }
            self.step();
        }
    }

    /// Takes the lease and switches torque on.
    pub(super) fn enable(&mut self) -> u32 {
        let acquire = Request::Acquire {
            nonce: 1,
            lease_ms: 100,
            takeover: false,
        };
        let Reply::Lease { epoch } = self.ask(&acquire) else {
            panic!("no lease")
        };
        self.epoch = epoch;
        assert_eq!(self.ask(&Request::Enable { epoch }), Reply::Accepted);
        self.run_ms(300);
        epoch
    }

    /// Until the drives are configured, or one is not; how long it took, ms.
    pub(super) fn bring_up(&mut self) -> u64 {
        let began = self.now_ns;
        for _ in 0..20_000 {
            self.run_ms(1);
            let state = self.node.state();
            if state == NodeState::Disabled || state == NodeState::Faulted {
                let took = (self.now_ns - began) / 1_000_000;
                // what is to be told has been told after another macrostep
                self.run_ms(20);
                return took;
            }
        }
        panic!("neither configured nor a fault: {:?}", self.node.state());
    }

    /// Node ids that LSS has given.
    fn given(&self) -> Vec<u8> {
        let given = self
            .asked
            .iter()
            .filter(|(_, [specifier, _])| *specifier == 0x11);
        given.map(|(_, [_, node])| *node).collect()
    }
}

fn all() -> Vec<(u8, Identity)> {
    (0..6)
        .map(|axis| (axis, identity(u32::from(axis) + 1)))
        .collect()
}

fn known(identities: &[(u8, Identity)]) -> KnownDrives<'_> {
    KnownDrives {
        identities,
        find: false,
        stored: false,
    }
}

#[test]
fn one_and_two_blank_drives_get_their_ids_and_the_others_keep_theirs() {
    let all = all();
    let undisturbed = Bench::new(&known(&[]), |_| {}).bring_up();
    for blank in [&[2][..], &[1, 4], &[0, 1, 2, 3, 4, 5]] {
        let mut b = Bench::new(&known(&all), |_| {}).blank(blank);
        let took = b.bring_up();
        assert_eq!(
            (b.node.state(), b.fault),
            (NodeState::Disabled, None),
            "{blank:?}"
        );
        let ids: Vec<u8> = blank
            .iter()
            .map(|axis| u8::try_from(*axis).unwrap() + 1)
            .collect();
        assert_eq!(b.given(), ids, "each once");
        let expected: Vec<Found> = blank
            .iter()
            .map(|axis| {
                let axis = u8::try_from(*axis).unwrap();
                let expected = wire(u32::from(axis) + 1);
                (0, Some(axis), DriveFinding::Given, Some(expected), None)
            })
            .collect();
        assert_eq!(b.found, expected);
        // The blank ones boot once more, 150 ms. A question takes 22 ms: the first, then at most five of each drive that
        // has not booted (storing is answered at once), with nine frames, one in 2 ms.
        let greatest = undisturbed + 150 + 22 + 6 * (5 * 22 + 9 * 2);
        assert!(
            (undisturbed + 150..=greatest).contains(&took),
            "{blank:?}: {took} ms, {undisturbed} ms without"
        );
    }
}

#[test]
fn when_all_drives_have_their_ids_it_only_asks_until_they_have_booted() {
    let all = all();
    let mut b = Bench::new(&known(&all), |_| {});
    b.bring_up();
    b.run_ms(1000);
    assert_eq!((b.node.state(), b.found.len()), (NodeState::Disabled, 0));
    // at 0 and 100 ms: the drives boot in 150
    let asked: Vec<[u8; 2]> = b.asked.iter().map(|(_, bytes)| *bytes).collect();
    assert_eq!(asked, [[0x4C, 0], [0x4C, 0]]);
}

#[test]
fn what_is_not_named_is_not_searched() {
    let mut b = Bench::new(&known(&[]), |_| {}).blank(&[2]);
    let took = b.bring_up();
    assert_eq!(b.fault, Some((Cause::DriveHeartbeat, Some(2))));
    assert_eq!((b.asked.len(), b.found.len()), (0, 0));
    // the time to boot, and half a servo step
    assert!((3000..3010).contains(&took), "{took} ms");
}

#[test]
fn a_blank_drive_of_another_serial_number_is_refused_and_told() {
    let named = [(2, identity(17))];
    let mut b = Bench::new(&known(&named), |_| {}).blank(&[2]);
    let took = b.bring_up();
    assert_eq!(b.fault, Some((Cause::DriveHeartbeat, Some(2))));
    b.run_ms(100);
    let mut found = b.found.clone();
    found.sort_by_key(|(_, axis, ..)| *axis);
    let expected = [
        (0, None, DriveFinding::Unnamed, None, Some(wire(3))),
        (0, Some(2), DriveFinding::Missing, Some(wire(17)), None),
    ];
    assert_eq!(found, expected);
    assert_eq!(b.given(), [] as [u8; 0]);
    // 3 s to boot, a fastscan of 133 questions of 20 to 22 ms
    assert!((5660..6100).contains(&took), "{took} ms");
}

#[test]
fn a_stranger_is_looked_for_where_that_is_asked_for() {
    let find = KnownDrives {
        identities: &[],
        find: true,
        stored: false,
    };
    let mut b = Bench::new(&find, |_| {}).blank(&[5]);
    b.bring_up();
    b.run_ms(100);
    let stranger = (0, None, DriveFinding::Unnamed, None, Some(wire(6)));
    assert_eq!(b.found, [stranger]);
    assert_eq!(b.fault, Some((Cause::DriveHeartbeat, Some(5))));
    assert_eq!(b.given(), [] as [u8; 0]);
}

#[test]
fn another_drive_with_the_axis_node_id_is_refused_and_told() {
    let named = [(3, identity(17))];
    let mut b = Bench::new(&known(&named), |_| {});
    b.bring_up();
    assert_eq!(b.fault, Some((Cause::DriveConfiguration, Some(3))));
    let other = (
        0,
        Some(3),
        DriveFinding::Other,
        Some(wire(17)),
        Some(wire(4)),
    );
    assert_eq!(b.found, [other]);
}

#[test]
fn a_drive_that_is_not_there_is_missing() {
    let all = all();
    let mut b = Bench::new(&known(&all), |_| {});
    assert!(b.robot.inject(1, Some(DriveFault::Silent)));
    let took = b.bring_up();
    b.run_ms(100);
    assert_eq!(b.fault, Some((Cause::DriveHeartbeat, Some(1))));
    let missing = (0, Some(1), DriveFinding::Missing, Some(wire(2)), None);
    assert_eq!(b.found, [missing]);
    // 3 s to boot, one last search of a window and its frames
    assert!((3020..3070).contains(&took), "{took} ms");
    // nobody is without id: no scan
    assert!(b.asked.iter().all(|(_, [specifier, _])| *specifier != 0x51));
}

#[test]
fn a_drive_that_answers_too_late_is_missing_and_nobody_gets_its_id() {
    let all = all();
    let mut b = Bench::new(&known(&all), |setup| {
        setup.axes[1].drive.quirks = Quirks::default().with(Quirk::SlowLayer);
    })
    .blank(&[1]);
    b.bring_up();
    b.run_ms(100);
    assert_eq!(b.fault, Some((Cause::DriveHeartbeat, Some(1))));
    let missing = (0, Some(1), DriveFinding::Missing, Some(wire(2)), None);
    assert_eq!(b.found, [missing]);
    assert_eq!(b.given(), [] as [u8; 0]);
}

#[test]
fn two_drives_of_one_identity_get_no_id() {
    let named = [(1, identity(2))];
    let mut b = Bench::new(&known(&named), |setup| setup.axes[4].drive.serial = 2).blank(&[1, 4]);
    b.bring_up();
    b.run_ms(3500);
    // the first that is given up is the one that nobody looks for
    assert_eq!(b.fault, Some((Cause::DriveHeartbeat, Some(4))));
    let collision = (0, Some(1), DriveFinding::Collision, Some(wire(2)), None);
    assert_eq!(b.found, [collision]);
    assert_eq!(b.given(), [] as [u8; 0]);
}

#[test]
fn a_drive_that_is_elsewhere_is_left_there() {
    let named = [(1, identity(2))];
    let mut b = Bench::new(&known(&named), |setup| setup.axes[1].node = 30);
    b.bring_up();
    b.run_ms(100);
    assert_eq!(b.fault, Some((Cause::DriveHeartbeat, Some(1))));
    let elsewhere = DriveFinding::Elsewhere { node: 30 };
    assert_eq!(b.found, [(0, Some(1), elsewhere, Some(wire(2)), None)]);
    assert_eq!(b.given(), [] as [u8; 0]);
}

#[test]
fn a_drive_that_does_not_store_is_told_of_and_given_its_id_again_after_its_next_power_up() {
    let all = all();
    let mut b = Bench::new(&known(&all), |setup| {
        setup.axes[2].drive.quirks = Quirks::default().with(Quirk::ForgetsNode);
    })
    .blank(&[2]);
    b.bring_up();
    let told = (0, Some(2), DriveFinding::NotStored, Some(wire(3)), None);
    assert_eq!(
        (b.node.state(), b.found.clone()),
        (NodeState::Disabled, vec![told])
    );
    let epoch = b.enable();
    assert_eq!(b.node.state(), NodeState::Unsynchronised);
    let asked = b.asked.len();
    // its supply fails for a moment
    let reset = nmt::command_frame(
        nmt::Command::ResetNode,
        nmt::Target::Node(protocol::canopen::node::NodeId::new(3).unwrap()),
    );
    let now_ns = b.now_ns;
    b.robot.on_frame(0, now_ns, &reset, &mut |_| {});
    b.run_ms(1000);
    assert_eq!(b.node.state(), NodeState::Faulted);
    assert_eq!(b.fault, Some((Cause::DriveSilent, Some(2))));
    assert_eq!(b.asked.len(), asked, "no layer setting in operation");
    assert_eq!(b.ask(&Request::Acknowledge { epoch }), Reply::Accepted);
    b.run_ms(1500);
    assert_eq!(b.node.state(), NodeState::Disabled);
    assert_eq!((b.given(), b.found.clone()), (vec![3, 3], vec![told, told]));
}

#[test]
fn an_identity_is_for_one_axis_of_the_robot() {
    let station = |effector, one_wire| Station {
        effector,
        unique_id: 7,
        mtu: Mtu::Fd,
        law: ServoLaw::DrivePosition,
        velocity_factor: 0.2,
        one_wire,
        track: TrackRule::Keep,
    };
    let config = station(1, false).config([0_u8; 6]).unwrap();
    for wrong in [
        &[(6, identity(1))][..],
        &[(0, identity(1)), (0, identity(2))],
        &[(0, identity(1)), (1, identity(1))],
    ] {
        assert!(config.with_drives(&known(wrong)).is_err(), "{wrong:?}");
    }
    let all = all();
    let named = config.with_drives(&known(&all)).unwrap();
    assert_ne!(named.crc("a"), config.crc("a"));
    // another node is the master of that wire
    let shared = station(2, true).config([0_u8; 6]).unwrap();
    assert!(shared.with_drives(&known(&all)).is_err());
    assert!(shared.with_drives(&known(&[])).is_ok());
}
