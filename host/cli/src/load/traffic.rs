//! What the buses of a cell carry at worst: every cyclic frame at its greatest length.
//!
//! A frame's length is that of `protocol::budget`, with the most stuff bits it can have; the frames
//! themselves are made by the code that makes the real ones, from messages whose numbers are as long as
//! they get. What is sent only when something happens (requests, replies, events, digital inputs) has the
//! share that [`LIMIT`] leaves.

use firmware::edp::drives::{DRIVE_HEARTBEAT_MS, MASTER_HEARTBEAT};
use firmware::node::FEEDBACK_STEPS;
use host::mp::arm::arm;
use host::mp::config::Config;
use host::task::{BusKind, BusSpec, Cell, RobotSpec};
use protocol::budget::{self, Bits, IdFormat, Rates};
use protocol::canopen::fast::{Feedback as DriveFeedback, Layout, Slot};
use protocol::cyphal::{Health, Heartbeat, Mode};
use protocol::frame::Frame;
use protocol::id::NodeId;
use protocol::link::{Endpoint, Role};
use protocol::message::{
    Command, Coordination, DemandTrace, Feedback, KnotMessage, NodeState, Progress, Space, TimeSync,
};
use protocol::time::Micros;
use protocol::transfer::Mtu;
use protocol::units::PerAxis;
use robots::{AxisDescription, Robot, RobotVisitor, TrackRule};

/// The greatest share of a bus that its cyclic traffic may take at worst.
/// Three drives at 1 kHz, as those of the RNT, take 80.8 %: hence not 80.
pub(crate) const LIMIT: f64 = 0.82;

/// Positions are within 2³¹ units of zero, but for axes that turn without end, and those need 64 turns an
/// hour for a year to get beyond what is as long.
const POSITION: i64 = -(1 << 31);
/// A year of bus time.
const TIME: Micros = Micros(1 << 45);

/// Frames that a bus carries again and again.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Entry {
    /// What they are.
    pub(crate) what: String,
    /// How many at once.
    pub(crate) frames: usize,
    /// How long all of them occupy the bus at worst, ns.
    pub(crate) worst_ns: u64,
    /// How often, ns.
    pub(crate) period_ns: u64,
    /// It has the least priority and nobody waits for it: it takes what is left.
    pub(crate) gives_way: bool,
}

impl Entry {
    fn new(what: impl Into<String>, lengths: &[Bits], rates: Rates, period: Micros) -> Self {
        Self {
            what: what.into(),
            frames: lengths.len(),
            worst_ns: lengths.iter().map(|bits| rates.duration_ns(*bits)).sum(),
            period_ns: period.0 * 1000,
            gives_way: false,
        }
    }

    /// Its share of the bus.
    #[expect(clippy::cast_precision_loss, reason = "nanoseconds of a cycle")]
    pub(crate) fn share(&self) -> f64 {
        self.worst_ns as f64 / self.period_ns as f64
    }
}

/// A bus and what it carries.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Traffic {
    /// The bus.
    pub(crate) bus: BusSpec,
    /// What it carries.
    pub(crate) entries: Vec<Entry>,
}

impl Traffic {
    /// The share of the bus at worst, without what gives way.
    pub(crate) fn worst(&self) -> f64 {
        let stays = |entry: &&Entry| !entry.gives_way;
        self.entries.iter().filter(stays).map(Entry::share).sum()
    }

    /// The share of the bus that everything would take at worst.
    pub(crate) fn whole(&self) -> f64 {
        self.entries.iter().map(Entry::share).sum()
    }

    /// Has the bus room for it?
    pub(crate) fn fits(&self) -> bool {
        self.worst() <= LIMIT
    }
}

/// A force sensor sends a sample, two frames, this often.
const FORCE_PERIOD: Micros = Micros(2000);

/// What every bus of a cell carries, in the order of the cell; `config` is what its MP is told.
pub(crate) fn of(cell: &Cell, config: &Config) -> Vec<Traffic> {
    let each = cell.buses.iter().enumerate();
    each.map(|(number, bus)| {
        let mut entries = Vec::new();
        if cell.robots.iter().any(|robot| robot.mp_bus == number) {
            entries.extend(mp(bus, config));
        }
        for robot in &cell.robots {
            if robot.mp_bus == number {
                entries.extend(node(robot, bus, config));
            }
            if robot.force_bus == Some(number) {
                let sample = [budget::worst_classic(IdFormat::Standard, 8); 2];
                let what = format!("{}: force sensor", robot.name);
                entries.push(Entry::new(what, &sample, bus.rates(), FORCE_PERIOD));
            }
            for group in robot.drives.iter().filter(|group| group.bus == number) {
                entries.extend(if robot.fast_drives {
                    fast_drives(robot, bus, &group.axes)
                } else {
                    drives(robot, bus, &group.axes)
                });
            }
        }
        let bus = bus.clone();
        Traffic { bus, entries }
    })
    .collect()
}

/// What drives and their node say to each other, in csp: the frames of cst are no longer. Drives without a gear
/// are sent a torque offset too.
fn drives(robot: &RobotSpec, bus: &BusSpec, axes: &[usize]) -> Vec<Entry> {
    let (rates, cycle) = (bus.rates(), Micros(u64::from(servo_step_us(robot))));
    let standard = |len| budget::worst_classic(IdFormat::Standard, len);
    let name = &robot.name;
    let all = arm(robot.kind).axes();
    let set_point = |axis: &usize| match all.get(*axis) {
        Some(axis) if axis.is_direct() => standard(8),
        _ => standard(6),
    };
    let set_points: Vec<_> = axes.iter().map(set_point).collect();
    let axes = axes.len();
    let mut entries = vec![
        Entry::new(format!("{name}: SYNC"), &[standard(0)], rates, cycle),
        Entry::new(
            format!("{name}: set-points (RPDO1)"),
            &set_points,
            rates,
            cycle,
        ),
        Entry::new(
            format!("{name}: actual values (TPDO1)"),
            &vec![standard(8); axes],
            rates,
            cycle,
        ),
    ];
    entries.extend(heartbeats(name, rates, axes));
    entries
}

/// The same in the fast profile: one group, as when all drives have the same controlword, and a feedback each. Drives
/// without a gear have a group of their own, with offsets.
fn fast_drives(robot: &RobotSpec, bus: &BusSpec, axes: &[usize]) -> Vec<Entry> {
    let (rates, cycle) = (bus.rates(), Micros(u64::from(servo_step_us(robot))));
    let name = &robot.name;
    let all = arm(robot.kind).axes();
    let direct = |axis: usize| all.get(axis).is_some_and(AxisDescription::is_direct);
    let last = |layout: Layout| {
        let mine = |axis: usize| direct(axis) == (layout == Layout::Offsets);
        let mine = (1..).zip(axes).filter(|(_, axis)| mine(**axis));
        mine.last().and_then(|(number, _)| Slot::new(number))
    };
    let fd = |len: usize| budget::worst_fd(IdFormat::Standard, u8::try_from(len).unwrap_or(64));
    let layouts = [Layout::Targets, Layout::Offsets].into_iter();
    let groups: Vec<_> = layouts
        .filter_map(|layout| Some(fd(layout.length(last(layout)?))))
        .collect();
    let sync = budget::worst_classic(IdFormat::Standard, 0);
    let mut entries = vec![
        Entry::new(format!("{name}: SYNC"), &[sync], rates, cycle),
        Entry::new(format!("{name}: set-points (group)"), &groups, rates, cycle),
        Entry::new(
            format!("{name}: feedback (FD)"),
            &vec![fd(DriveFeedback::LENGTH); axes.len()],
            rates,
            cycle,
        ),
    ];
    entries.extend(heartbeats(name, rates, axes.len()));
    entries
}

/// Heartbeats of so many drives and of their node.
fn heartbeats(name: &str, rates: Rates, drives: usize) -> [Entry; 2] {
    let standard = |len| budget::worst_classic(IdFormat::Standard, len);
    [
        Entry::new(
            format!("{name}: heartbeats of the drives"),
            &vec![standard(1); drives],
            rates,
            Micros::from_millis(u64::from(DRIVE_HEARTBEAT_MS)),
        ),
        Entry::new(
            format!("{name}: heartbeat of the node"),
            &[standard(1)],
            rates,
            MASTER_HEARTBEAT,
        ),
    ]
}

/// What the MP says to all.
fn mp(bus: &BusSpec, config: &Config) -> Vec<Entry> {
    let mut link = endpoint(bus, Role::Coordinator);
    let sync = TimeSync {
        sequence: u8::MAX,
        previous_sent_at: TIME,
    };
    let sync = lengths(|out| link.send_time_sync(&sync, &mut into(out)).is_ok());
    vec![
        Entry::new("MP: time", &sync, bus.rates(), config.timing.macrostep()),
        heartbeat("MP", bus, link),
    ]
}

/// What the MP and the node of a robot say to each other.
fn node(robot: &RobotSpec, bus: &BusSpec, config: &Config) -> Vec<Entry> {
    let (rates, axes) = (bus.rates(), robot.axes());
    let step = Micros(u64::from(servo_step_us(robot)));
    let knot = Command {
        epoch: u32::MAX,
        sequence: u16::MAX,
        valid_until: TIME,
        coordination: Coordination::Tight(KnotMessage {
            at: TIME,
            space: Space::Joints,
            position: all(0.0, axes),
            velocity: all(0.0, axes),
            acceleration: all(0.0, axes),
        }),
    };
    let feedback = Feedback {
        step: u32::MAX,
        sampled_at: TIME,
        state: NodeState::Moving,
        fault: None,
        synchronised: u8::MAX,
        epoch: u32::MAX,
        instruction: u32::MAX,
        progress: Progress::Running,
        horizon_us: u32::MAX,
        actual: all(POSITION, axes),
        demand: all(POSITION, axes),
        current_ma: all(i16::MIN, axes),
        following_error: all(u32::MAX, axes),
        limit_violations: u32::MAX,
        acceleration_step: 0.0,
        lost: u32::MAX,
        force_n: Some([0.0; 3]),
    };
    let trace = DemandTrace {
        step: u32::MAX,
        demand: all(POSITION, axes),
    };
    let mut link = endpoint(bus, Role::Coordinator);
    let said = lengths(|out| {
        let times = 0..=config.timing.knot_repeats;
        times.fold(true, |good, _| {
            good && link.send_command(NodeId::MP, &knot, &mut into(out)).is_ok()
        })
    });
    let mut link = endpoint(bus, Role::Coordinator);
    let heard = lengths(|out| link.send_feedback(&feedback, &mut into(out)).is_ok());
    let name = &robot.name;
    let macrostep = config.timing.macrostep();
    let mut entries = vec![
        Entry::new(format!("{name}: knots, repeated"), &said, rates, macrostep),
        Entry::new(
            format!("{name}: feedback"),
            &heard,
            rates,
            Micros(step.0 * u64::from(FEEDBACK_STEPS)),
        ),
    ];
    if bus.kind != BusKind::Classic {
        let traced = lengths(|out| link.send_demand_trace(&trace, &mut into(out)).is_ok());
        entries.push(Entry {
            gives_way: true,
            ..Entry::new(format!("{name}: demands, give way"), &traced, rates, step)
        });
    }
    entries.push(heartbeat(name, bus, link));
    entries
}

fn heartbeat(name: &str, bus: &BusSpec, mut link: Endpoint<1>) -> Entry {
    let heartbeat = |uptime_s| Heartbeat {
        uptime_s,
        health: Health::Nominal,
        mode: Mode::Operational,
        status: u8::MAX,
    };
    let frames = lengths(|out| {
        link.poll_heartbeat(TIME, heartbeat, &mut into(out));
        true
    });
    Entry::new(
        format!("{name}: heartbeat"),
        &frames,
        bus.rates(),
        Micros::from_millis(1000),
    )
}

fn endpoint(bus: &BusSpec, role: Role) -> Endpoint<1> {
    let mtu = match bus.kind {
        BusKind::Classic => Mtu::Classic,
        BusKind::Fd { .. } => Mtu::Fd,
    };
    Endpoint::new(NodeId::MP, role, mtu)
}

/// The worst lengths of the frames that something sends. No message of these types is longer than a
/// transfer, so that sending does not fail.
fn lengths(send: impl FnOnce(&mut Vec<Bits>) -> bool) -> Vec<Bits> {
    let mut lengths = Vec::new();
    let _sent = send(&mut lengths);
    lengths
}

/// Keeps the worst lengths of frames.
fn into(lengths: &mut Vec<Bits>) -> impl FnMut(Frame) {
    |frame| lengths.push(budget::worst(&frame))
}

fn all<T: Clone>(value: T, axes: usize) -> PerAxis<T> {
    core::iter::repeat_n(value, axes).collect()
}

fn servo_step_us(robot: &RobotSpec) -> u32 {
    struct Step;
    impl RobotVisitor for Step {
        type Output = u32;
        fn visit<R: Robot<N>, const N: usize>(self, robot: R) -> u32 {
            robot.description().servo_step_us
        }
    }
    robot.kind.visit(TrackRule::Keep, Step)
}

#[cfg(test)]
mod test {
    use super::*;
    use host::program::config_of;
    use robots::RobotKind;

    fn loads(cell: &Cell) -> Vec<Traffic> {
        of(cell, &config_of(cell).unwrap())
    }

    /// 55 + 6·(115 + 135) = 1555 µs of 2000 (Davis et al. 2007), and seven heartbeats of 65 µs in 100 ms.
    #[test]
    fn six_axes_take_78_per_cent_of_their_bus() {
        let cell = Cell::of(&[RobotKind::Irp6Postument]);
        let traffic = loads(&cell);
        let drives = traffic.iter().find(|t| t.bus.name != "mp").unwrap();
        let expected = 1555.0 / 2000.0 + 7.0 * 65.0 / 100_000.0;
        assert!(
            (drives.worst() - expected).abs() < 1e-12,
            "{}",
            drives.worst()
        );
        assert!(drives.fits());
    }

    /// The same on CAN FD at 1 and 5 Mbit/s, wire.md's frame lengths worst: a SYNC of 55 µs, a group of 32 bytes and six
    /// feedbacks of 16 bytes of 72.6 µs.
    #[test]
    fn six_axes_in_the_fast_profile_take_a_third_of_an_fd_bus() {
        let mut cell = Cell::of(&[RobotKind::Irp6Postument]);
        let classical = loads(&cell);
        for bus in cell.buses.iter_mut().filter(|bus| bus.name != "mp") {
            *bus = BusSpec::fd(bus.name.clone());
        }
        cell.robots[0].fast_drives = true;
        let fast = loads(&cell);
        let of = |all: &[Traffic]| all.iter().find(|t| t.bus.name != "mp").unwrap().clone();
        let (classical, fast) = (of(&classical), of(&fast));
        let group = Rates::FD_1M_5M.duration_ns(budget::worst_fd(IdFormat::Standard, 32));
        #[expect(clippy::cast_precision_loss, reason = "nanoseconds of a frame")]
        let group = group as f64 * 1e-3;
        let expected = (55.0 + group + 6.0 * 72.6) / 2000.0 + 7.0 * 65.0 / 100_000.0;
        // the lengths above are rounded to 0.1 µs
        assert!(
            (fast.worst() - expected).abs() < 6.0 * 0.05 / 2000.0 + 1e-9,
            "{}",
            fast.worst()
        );
        assert!(fast.worst() < 0.4 * classical.worst() && fast.fits());
    }

    /// Drives without a gear have a group with offsets: four take 4 + 4 · 6 bytes of it, sent in 32, where targets alone
    /// take 20.
    #[test]
    fn a_group_with_offsets_is_as_long_as_its_slots() {
        let mut cell = Cell::of(&[RobotKind::Polycrank]);
        for bus in cell.buses.iter_mut().filter(|bus| bus.name != "mp") {
            *bus = BusSpec::fd(bus.name.clone());
        }
        cell.robots[0].fast_drives = true;
        let loads = loads(&cell);
        let first = loads.iter().find(|t| t.bus.name != "mp").unwrap();
        let groups = first.entries.iter().filter(|e| e.what.contains("group"));
        let groups: Vec<(usize, u64)> = groups.map(|e| (e.frames, e.worst_ns)).collect();
        let worst = budget::worst_fd(IdFormat::Standard, 32);
        assert_eq!(groups, [(1, Rates::FD_1M_5M.duration_ns(worst))]);
        assert_eq!(cell.robots[0].drives[0].axes.len(), 4);
    }

    #[test]
    fn seven_axes_do_not_fit_one_bus_and_half_the_rate_is_twice_the_load() {
        let mut cell = Cell::of(&[RobotKind::Irp6Track]);
        let one = cell.robots[0].drives[0].bus;
        cell.robots[0].drives.truncate(1);
        cell.robots[0].drives[0].axes = (0..7).collect();
        let traffic = loads(&cell).remove(one);
        // 55 + 7·250 = 1805 µs of 2000
        assert!(traffic.worst() > 1805.0 / 2000.0 && !traffic.fits());
        cell.buses[one].bit_rate /= 2;
        let slow = loads(&cell).remove(one);
        assert!((slow.worst() - 2.0 * traffic.worst()).abs() < 1e-12);
    }

    #[test]
    fn the_drive_buses_of_every_kind_have_room() {
        for traffic in loads(&Cell::of(&RobotKind::ALL)) {
            assert!(traffic.fits(), "{}: {}", traffic.bus.name, traffic.worst());
        }
    }

    #[test]
    fn every_kind_of_robot_fits_one_fast_bus_towards_the_mp() {
        let cell = Cell::of(&RobotKind::ALL);
        let mp = loads(&cell).remove(cell.robots[0].mp_bus);
        assert!(mp.fits() && mp.whole() > mp.worst() + 0.3, "{}", mp.worst());
    }

    #[test]
    fn two_arms_fit_a_fast_bus_with_their_master() {
        let mut cell = Cell::of(&[RobotKind::Irp6Track, RobotKind::Irp6Postument]);
        let mp = cell.robots[0].mp_bus;
        let fast = loads(&cell).remove(mp);
        assert!(fast.fits(), "{}", fast.worst());
        cell.buses[mp] = BusSpec::classic("mp");
        let classic = loads(&cell).remove(mp);
        assert!(classic.worst() > fast.worst() + 0.2, "{}", classic.worst());
        assert!(!classic.entries.iter().any(|e| e.what.contains("demands")));
    }
}
