//! The fast profile on CAN FD beside the classical framing: the same set-points, the same positions, a shorter bus.

use super::*;
use protocol::canopen::axis::Target;
use protocol::canopen::fast::{Group, Layout, Slot};
use std::collections::BTreeMap;

/// The groups of drives that obey SYNC 080, without offsets and with.
const GROUP: u16 = 0x200;
const GROUP_WITH_OFFSETS: u16 = 0x300;

/// The targets of every servo step, and how long a cycle occupies the bus.
#[derive(Default)]
struct Targets {
    latest: [i32; 6],
    steps: Vec<[i32; 6]>,
    groups: u32,
    classical: u32,
}

impl Observer for Targets {
    fn frame(&mut self, bus: usize, _: u64, frame: &Frame) {
        let (DRIVE_BUS, Id::Standard(cob)) = (bus, frame.id()) else {
            return;
        };
        if frame.is_fd() && cob == GROUP {
            self.groups += 1;
            let group = Group::decode(Layout::Targets, frame.data()).unwrap();
            for (slot, latest) in (1..).zip(&mut self.latest) {
                if let Some((Target::Position(units), None)) =
                    group.target(Slot::new(slot).unwrap())
                {
                    *latest = units;
                }
            }
        } else if (0x201..=0x206).contains(&cob) {
            self.classical += 1;
            let [_, _, a, b, c, d] = <[u8; 6]>::try_from(frame.data()).unwrap();
            self.latest[usize::from(cob - 0x201)] = i32::from_le_bytes([a, b, c, d]);
        } else if cob == 0x080 {
            self.steps.push(self.latest);
        }
    }
}

fn station() -> Station {
    Station {
        effector: 1,
        unique_id: 7,
        mtu: Mtu::Fd,
        law: ServoLaw::DrivePosition,
        velocity_factor: 0.2,
        one_wire: false,
        track: TrackRule::Keep,
    }
}

/// A move of every motor; what was demanded from its begin to its end, where the motors are, and the bus' busy time.
fn moved(fast: bool) -> (Targets, Vec<f64>, u64) {
    let kind = RobotKind::Irp6Postument;
    let mut c = Coordinator::new(kind, ServoLaw::DrivePosition);
    if fast {
        c.cell = Cell::new(Kind::Fd);
        c.cell
            .add(kind, &station(), &Wiring::fast(&drive_buses(kind)), 1)
            .unwrap();
    }
    c.enable();
    let request = Request::Execute {
        epoch: c.epoch,
        id: 1,
        start_at: Micros(0),
        instruction: Instruction::MoveMotors {
            target: [6.0, 4.0, -3.0, 5.0, 2.0, 4.0].into_iter().collect(),
            relative: true,
            speeds: speeds(6, 1.0),
        },
    };
    assert_eq!(c.request(&request), Reply::Accepted);
    let mut targets = Targets::default();
    let before = c.cell.statistics()[DRIVE_BUS].busy_ns;
    // 10 s
    for _ in 0..500 {
        c.macrostep(&mut targets);
    }
    let busy = c.cell.statistics()[DRIVE_BUS].busy_ns - before;
    let feedback = c.feedback.as_ref().unwrap();
    assert_eq!((feedback.progress, feedback.fault), (Progress::Done, None));
    assert_eq!(c.cell.refused(), []);
    // no two nodes have an identifier in common
    assert!(c.cell.statistics().iter().all(|bus| bus.collisions == 0));
    let motors = c.cell.robots().next().unwrap().1.motor_rad().to_vec();
    (targets, motors, busy)
}

/// Of the demands only where they change: when the request came lies within a few steps of each other.
fn changes(targets: &Targets) -> Vec<[i32; 6]> {
    let mut steps = targets.steps.clone();
    steps.dedup();
    steps
}

#[test]
fn the_same_motion_over_both_framings_has_the_same_set_points_and_ends_in_the_same_place() {
    let (classical, at, busy) = moved(false);
    let (fast, fast_at, fast_busy) = moved(true);
    assert_eq!((classical.groups, fast.classical), (0, 0));
    // one group a step: all drives have the same controlword
    let steps = u32::try_from(fast.steps.len()).unwrap();
    assert!(
        (steps - 1..=steps + 1).contains(&fast.groups),
        "{} {steps}",
        fast.groups
    );
    let (one, other) = (changes(&classical), changes(&fast));
    assert!(one.len() > 500, "{}", one.len());
    // both begin where the axes had settled when torque came: the way is compared
    let from = |all: &[[i32; 6]]| -> Vec<[i32; 6]> {
        let first = all.iter().find(|step| **step != [0; 6]).copied().unwrap();
        let offset = |step: &[i32; 6]| core::array::from_fn(|k| step[k] - first[k]);
        all.iter()
            .filter(|step| **step != [0; 6])
            .map(offset)
            .collect()
    };
    assert_eq!(from(&one), from(&other));
    for (one, other) in at.iter().zip(&fast_at) {
        // an increment and what friction leaves
        assert!((one - other).abs() < 3.2e-3, "{at:?} {fast_at:?}");
    }
    // wire.md: 6 axes take 648 us instead of 1565 at worst
    let share = f64::from(u32::try_from(fast_busy / 1000).unwrap())
        / f64::from(u32::try_from(busy / 1000).unwrap());
    println!("busy: {share:.3} of the classical framing");
    assert!((0.3..0.6).contains(&share), "{share}");
}

/// Targets and torque offsets of the drives of one bus, as they were at every SYNC.
#[derive(Default)]
struct Offsets {
    latest: BTreeMap<u8, (i32, i16)>,
    steps: Vec<BTreeMap<u8, (i32, i16)>>,
    lengths: Vec<usize>,
}

impl Observer for Offsets {
    fn frame(&mut self, bus: usize, _: u64, frame: &Frame) {
        let (DRIVE_BUS, Id::Standard(cob)) = (bus, frame.id()) else {
            return;
        };
        if cob == GROUP_WITH_OFFSETS {
            let group = Group::decode(Layout::Offsets, frame.data()).unwrap();
            self.lengths.push(frame.data().len());
            for number in 1..=10 {
                if let Some((Target::Position(units), Some(offset))) =
                    group.target(Slot::new(number).unwrap())
                {
                    self.latest.insert(number, (units, offset));
                }
            }
        } else if (0x201..0x280).contains(&cob) {
            let [_, _, a, b, c, d, e, f] = <[u8; 8]>::try_from(frame.data()).unwrap();
            let both = (i32::from_le_bytes([a, b, c, d]), i16::from_le_bytes([e, f]));
            self.latest.insert(u8::try_from(cob - 0x200).unwrap(), both);
        } else if cob == 0x080 {
            self.steps.push(self.latest.clone());
        }
    }
}

/// A move of Polycrank's joints; what its drives were told on the way, and where its motors are.
fn offsets(fast: bool) -> (Offsets, Vec<f64>) {
    let kind = RobotKind::Polycrank;
    let mut c = Coordinator::new(kind, ServoLaw::DrivePosition);
    let buses = drive_buses(kind);
    let wiring = if fast {
        Wiring::fast(&buses)
    } else {
        Wiring::classic(&buses)
    };
    // as fast as the motors can: else hardly a torque is needed
    let station = Station {
        velocity_factor: 1.0,
        ..station()
    };
    c.cell = Cell::new(Kind::Fd);
    c.cell.add(kind, &station, &wiring, 1).unwrap();
    c.enable();
    c.home();
    let request = Request::Execute {
        epoch: c.epoch,
        id: 1000,
        start_at: Micros(0),
        instruction: Instruction::MoveMotors {
            target: [3.0, -4.0, 2.0, 5.0, -3.0, 4.0, 2.0].into_iter().collect(),
            relative: true,
            speeds: speeds(7, 1.0),
        },
    };
    assert_eq!(c.request(&request), Reply::Accepted);
    let mut seen = Offsets::default();
    for _ in 0..150 {
        c.macrostep(&mut seen);
    }
    let feedback = c.feedback.as_ref().unwrap();
    assert_eq!((feedback.progress, feedback.fault), (Progress::Done, None));
    assert_eq!(c.cell.refused(), []);
    assert!(c.cell.statistics().iter().all(|bus| bus.collisions == 0));
    let motors = c.cell.robots().next().unwrap().1.motor_rad().to_vec();
    (seen, motors)
}

#[test]
fn drives_without_a_gear_get_the_same_targets_and_offsets_over_both_framings() {
    let (classical, at) = offsets(false);
    let (fast, fast_at) = offsets(true);
    assert!(classical.lengths.is_empty());
    // the drives of the first bus and no more: 4 + 6 bytes each, in a length that FD has
    let drives = drive_buses(RobotKind::Polycrank);
    let first = drives.iter().take_while(|bus| **bus == 0);
    let drives = u8::try_from(first.count()).unwrap();
    let length = Layout::Offsets.length(Slot::new(drives).unwrap());
    assert!(fast.lengths.iter().all(|got| *got == length), "{length}");
    let numbers: Vec<u8> = fast.latest.keys().copied().collect();
    assert_eq!(numbers, (1..=drives).collect::<Vec<u8>>());
    let way = |seen: &Offsets| {
        let mut steps = seen.steps.clone();
        steps.retain(|step| step.len() == usize::from(drives));
        steps.dedup_by(|a, b| a.values().zip(b.values()).all(|(a, b)| a.0 == b.0));
        steps
    };
    let (one, other) = (way(&classical), way(&fast));
    assert!(one.len() > 300, "{}", one.len());
    assert_eq!(one.len(), other.len());
    let greatest = |steps: &[BTreeMap<u8, (i32, i16)>]| {
        let all = steps.iter().flat_map(BTreeMap::values);
        all.map(|(_, offset)| offset.unsigned_abs()).max().unwrap()
    };
    assert!(greatest(&one) > 20, "{}", greatest(&one));
    for (a, b) in one.iter().zip(&other) {
        for (number, (units, offset)) in a {
            let (fast_units, fast_offset) = b[number];
            // absolute encoders: both know where they are from the start
            assert_eq!(*units, fast_units);
            assert_eq!(*offset, fast_offset);
        }
    }
    for (one, other) in at.iter().zip(&fast_at) {
        assert!((one - other).abs() < 1e-3, "{at:?} {fast_at:?}");
    }
}

#[test]
fn every_law_homes_and_moves_over_the_fast_profile() {
    for law in [ServoLaw::DrivePosition, ServoLaw::FeedForward] {
        let kind = RobotKind::Irp6Postument;
        let mut c = Coordinator::new(kind, law);
        c.cell = Cell::new(Kind::Fd);
        let station = Station { law, ..station() };
        c.cell
            .add(kind, &station, &Wiring::fast(&drive_buses(kind)), 1)
            .unwrap();
        c.enable();
        c.home();
        let done = c.execute(Instruction::MoveJoints {
            target: FRONT.iter().copied().collect(),
            relative: false,
            speeds: speeds(6, 0.2),
        });
        assert_eq!(
            (done.progress, done.fault),
            (Progress::Done, None),
            "{law:?}"
        );
        assert_eq!(c.cell.refused(), []);
    }
}
