//! The HIL suite over SocketCAN: simulator, nodes and `mrroc` on `vcan0` (CAN FD) and `vcan1` (classical),
//! `candump` as the witness.
//!
//! `cargo xtask vcan` runs it, on this kernel or on one of its own. Elsewhere a test says that it is
//! skipped. What is asserted is the protocol and that nothing is lost; how long things take is told.

// of this module, so that its tests are in the suite
#[path = "can_utils.rs"]
mod can_utils;

use super::child::{PATIENCE, Process};
use super::coordinator::Coordinator;
use super::force;
use super::witness::Witness;
use super::{LONG_RAD, SHORT_RAD, demands, on_the_path, since, under_way};
use bus::candump::Entry;
use bus::socketcan::{KERNEL_QUEUE, QUEUE, SocketCan};
use bus::{Bus, BusError, Hears, open_can};
use protocol::fault::Cause;
use protocol::frame::{Frame, Id};
use protocol::message::{NodeState, Request};
use protocol::transfer::Mtu;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;
use std::thread;
use std::time::{Duration, Instant};

const FD: &str = "vcan0";
const CLASSIC: &str = "vcan1";

/// The two-arm task takes 108 s, and homing before it.
const TASK: Duration = Duration::from_secs(400);

/// Is this interface here? If not, the test is skipped, unless it must run.
fn is_here(interface: &str) -> bool {
    let here = Path::new("/sys/class/net").join(interface).exists();
    if !here {
        assert!(
            std::env::var_os("MRROC_ON_VCAN").is_none(),
            "there is no {interface}"
        );
        println!("skipped: no {interface}");
    }
    here
}

/// Runs a tool of the system.
fn system(program: &str, arguments: &[&str]) {
    let done = Command::new(program).args(arguments).status();
    assert!(
        done.is_ok_and(|status| status.success()),
        "{program} {arguments:?}"
    );
}

/// Simulator and nodes on an interface, until the end of the test.
struct Cell {
    simulator: Process,
    nodes: Vec<Process>,
    /// The interface was down for a while.
    unplugged: bool,
}

impl Cell {
    fn start(interface: &str, robots: &[&str]) -> Self {
        Self::with(interface, robots, &[])
    }

    /// The same, with options of the nodes.
    fn with(interface: &str, robots: &[&str], options: &[&str]) -> Self {
        let place = format!("can:{interface}");
        let arguments = [robots, &["--bus", &place, "--json"]].concat();
        let mut simulator = Process::start("mrroc-hil-sim", &arguments);
        simulator.event("ready", |_| true);
        let nodes = robots.iter().map(|robot| {
            let arguments = [&[*robot, "--bus", &place, "--json"], options].concat();
            let mut node = Process::start("mrroc-node", &arguments);
            node.event("ready", |_| true);
            node
        });
        Self {
            nodes: nodes.collect(),
            simulator,
            unplugged: false,
        }
    }

    /// Ends a node in order.
    fn interrupted(mut node: Process, faults: u64) {
        node.interrupt();
        let (status, said) = node.end();
        assert_eq!(status.code(), Some(0), "{said:#?}");
        let summary = node.events.last().unwrap();
        println!("{summary}");
        assert_eq!(summary["faults"], faults, "{said:#?}");
        assert_eq!(summary["limit_violations"], 0, "{said:#?}");
    }

    /// Ends everything in order and tells how it went; `faults` is what the nodes have seen.
    fn end(mut self, faults: u64) {
        for node in self.nodes {
            Self::interrupted(node, faults);
        }
        self.simulator.interrupt();
        let (status, said) = self.simulator.end();
        assert_eq!(status.code(), Some(0), "{said:#?}");
        let summaries = self.simulator.events.iter();
        for summary in summaries.filter(|event| event["event"] == "summary") {
            println!("{summary}");
            // only while there was no bus
            let dropped = summary["frames_dropped"].as_u64();
            assert_eq!(dropped > Some(0), self.unplugged, "{said:#?}");
        }
    }
}

/// The set-points (in the drives' units) on the wire: of each drive, in their order.
fn setpoints(seen: &[Entry], drives: std::ops::RangeInclusive<u16>) -> BTreeMap<u16, Vec<i64>> {
    let mut positions: BTreeMap<u16, Vec<i64>> = BTreeMap::new();
    for entry in seen {
        // RPDO1: controlword, target position (docs/wire.md)
        let (Id::Standard(id), [_, _, a, b, c, d, ..]) = (entry.frame.id(), entry.frame.data())
        else {
            continue;
        };
        if let Some(drive) = id.checked_sub(0x200).filter(|drive| drives.contains(drive)) {
            let position = i32::from_le_bytes([*a, *b, *c, *d]);
            positions.entry(drive).or_default().push(position.into());
        }
    }
    positions
}

/// Tells how regular a periodic frame was, by the witness's clock.
fn tell_jitter(seen: &[Entry], id: Id, name: &str) {
    let at: Vec<u64> = seen
        .iter()
        .filter(|entry| entry.frame.id() == id)
        .map(|entry| entry.at.0)
        .collect();
    let mut gaps: Vec<u64> = at.windows(2).map(|two| two[1] - two[0]).collect();
    gaps.sort_unstable();
    let percentile = |share: usize| gaps.get(gaps.len().saturating_sub(1) * share / 1000);
    println!(
        "{name}: {} frames; from one to the next, us: p1 {:?}, p50 {:?}, p99 {:?}, worst {:?}",
        at.len(),
        percentile(10),
        percentile(500),
        percentile(990),
        gaps.last()
    );
}

#[test]
fn two_arms_boot_home_and_do_their_task() {
    two_arms("data/two-arms-short.toml");
}

/// All 108 s of it: `cargo xtask vcan two_arms --include-ignored`.
#[test]
#[ignore = "takes ten minutes on a kernel as a process"]
fn two_arms_boot_home_and_do_the_whole_task() {
    two_arms("../tasks/two-arms.toml");
}

fn two_arms(task: &str) {
    if !is_here(FD) {
        return;
    }
    // of the drives' frames SYNC and what tells of their boot: all would be some 600 000
    let mut witness = Witness::of_some(FD, &["080:7FF", "0E2:7FF", "700:780", "80000000:80000000"]);
    let cell = Cell::start(FD, &["irp6-track", "irp6-postument"]);
    do_their_task(task);
    witnessed_task(&witness.seen());
    cell.end(0);
}

/// The same set-points in groups: both nodes have one of their own on the same wire.
#[test]
fn two_arms_in_the_fast_profile_home_and_do_their_task() {
    if !is_here(FD) {
        return;
    }
    // both groups, RPDO1 and RPDO2 of all drives (200 to 21F, 300 to 31F), one feedback of either
    let mut witness =
        Witness::of_some(FD, &["262:7FF", "200:6E0", "300:6E0", "181:7FF", "18B:7FF"]);
    let robots = ["irp6-track", "irp6-postument"];
    let cell = Cell::with(FD, &robots, &["--fast-drives"]);
    do_their_task("data/two-arms-short.toml");
    let seen = witness.seen();
    let of = |id: u16| {
        let all = seen
            .iter()
            .filter(|entry| entry.frame.id() == Id::Standard(id));
        all.map(|entry| entry.frame).collect::<Vec<Frame>>()
    };
    // seven axes and six: 4 + 28 and 4 + 24 bytes are both sent in 32
    for (group, feedback) in [(0x200, 0x181), (0x262, 0x18B)] {
        let (groups, answers) = (of(group), of(feedback));
        let long = |frame: &Frame, length| frame.is_fd() && frame.data().len() == length;
        assert!(groups.len() > 1000, "{}", groups.len());
        assert!(
            groups
                .iter()
                .all(|frame| frame.data().len() <= 32 && frame.is_fd())
        );
        assert!(groups.iter().filter(|frame| long(frame, 32)).count() > 1000);
        assert!(answers.iter().filter(|frame| long(frame, 16)).count() > 1000);
    }
    let classical = |frame: &Frame| {
        // a filter without the flag of the format lets the MP's frames pass, too
        let Id::Standard(id) = frame.id() else {
            return false;
        };
        (0x201..0x260).contains(&id) || (0x300..0x320).contains(&id)
    };
    assert!(!seen.iter().any(|entry| classical(&entry.frame)));
    cell.end(0);
}

#[test]
fn a_classical_interface_refuses_the_fast_profile_in_one_line() {
    if !is_here(CLASSIC) {
        return;
    }
    let arguments = ["irp6-postument", "--bus", "can:vcan1", "--fast-drives"];
    super::refused("mrroc-node", &arguments, 69, &["can:vcan1", "mtu of 72"]);
}

fn do_their_task(task: &str) {
    let begun = Instant::now();
    let task = ["run", task, "--bus", "can:vcan0", "--json"];
    let mut master = Process::start("mrroc", &task);
    let (status, said) = master.end_within(TASK);
    println!("two arms: {:.1} s", begun.elapsed().as_secs_f64());
    let summary = master
        .events
        .last()
        .unwrap_or_else(|| panic!("no summary: {said:#?}"));
    assert_eq!(status.code(), Some(0), "{said:#?} {summary:#}");
    assert_eq!(summary["ok"], true);
    for robot in summary["robots"].as_array().unwrap() {
        assert_eq!(
            (&robot["faults"], &robot["limit_violations"]),
            (&0.into(), &0.into())
        );
    }
}

#[test]
fn an_arm_on_socketcan_stops_at_a_force() {
    if is_here(FD) {
        force::a_task_ends_at_the_surface("can:vcan0", "0", |_| {
            open_can(FD, Hears::Extended)
                .map(|(bus, mtu)| (bus as Box<dyn Bus>, mtu))
                .unwrap()
        });
    }
}

#[test]
fn a_node_whose_master_is_killed_in_motion_stops_on_its_path_and_stays() {
    if !is_here(FD) {
        return;
    }
    let mut cell = Cell::start(FD, &["irp6-postument"]);
    killed_in_motion(&mut cell.nodes[0]);
    cell.end(1);
}

/// The arm is homed, and the motion after that is cut off by `kill -9` of its master: the node stops on
/// the path, says why, and nothing resumes.
fn killed_in_motion(node: &mut Process) {
    const DRIVES: std::ops::RangeInclusive<u16> = 11..=16;
    let mut master = Process::start(
        "mrroc",
        &[
            "move",
            "irp6-postument",
            "--motors",
            "-60,30,20,10,15,25",
            "--relative",
            "--bus",
            "can:vcan0",
        ],
    );
    node.event("state", |event| event["state"] == "Holding");
    let mut witness = Witness::of(FD);
    node.event("state", |event| event["state"] == "Moving");
    travelled(FD, 11, 100_000);
    master.kill();
    let fault = node.event("fault", |_| true);
    assert_eq!(
        (&fault["name"], &fault["during"]),
        (&"LeaseExpired".into(), &"Moving".into())
    );
    node.event("state", |event| event["state"] == "Faulted");
    assert!(
        node.states().ends_with(&["Moving", "Stopping", "Faulted"]),
        "{:?}",
        node.states()
    );
    let stopped = witness.seen();
    thread::sleep(Duration::from_millis(500));
    let later = witness.seen();
    let (positions, after) = (setpoints(&stopped, DRIVES), setpoints(&later, DRIVES));
    let start: Vec<i64> = positions.values().map(|all| all[0]).collect();
    let end: Vec<i64> = positions.values().map(|all| *all.last().unwrap()).collect();
    let rest: Vec<i64> = after.values().map(|all| *all.last().unwrap()).collect();
    assert_eq!(end, rest, "nothing resumes by itself");
    let whole = since(std::slice::from_ref(&start), &[end]);
    // every drive got a set-point in every servo step of its node: none is missing on the wire
    let counts: BTreeSet<usize> = positions.values().map(Vec::len).collect();
    let steps = *counts.first().unwrap();
    assert!(counts.last().unwrap() - steps <= 1, "{counts:?}");
    for step in 0..steps {
        let here: Vec<i64> = positions.values().map(|all| all[step]).collect();
        let way = since(std::slice::from_ref(&start), &[here]);
        if way[0].iter().any(|units| units.abs() > 1000) {
            on_the_path(&way[0], &whole[0], &start);
        }
    }
    println!(
        "killed after {:?} units of the first axis",
        whole[0].first()
    );
}

/// Waits until the set-points of a drive have gone so many units since this is called.
fn travelled(interface: &str, drive: u16, units: i64) {
    let (mut bus, _) = open_can(interface, Hears::All).unwrap();
    let until = Instant::now() + PATIENCE;
    let mut first = None;
    loop {
        assert!(Instant::now() < until, "drive {drive} does not move");
        bus.wait(bus::now() + protocol::time::Micros::from_millis(10))
            .unwrap();
        while let Some(received) = bus.receive().unwrap() {
            let (Id::Standard(id), [_, _, position @ ..]) =
                (received.frame.id(), received.frame.data())
            else {
                continue;
            };
            let Ok(position) = <[u8; 4]>::try_from(position) else {
                continue;
            };
            if id == 0x200 + drive {
                let position = i64::from(i32::from_le_bytes(position));
                if (position - *first.get_or_insert(position)).abs() >= units {
                    return;
                }
            }
        }
    }
}

/// What the witness must have seen of a whole task.
fn witnessed_task(seen: &[Entry]) {
    tell_jitter(seen, Id::Standard(0x080), "SYNC of irp6-track");
    tell_jitter(seen, Id::Standard(0x0E2), "SYNC of irp6-postument");
    // a boot-up of every drive, the only heartbeat that says 0 (CiA 301)
    let booted: BTreeSet<u16> = seen
        .iter()
        .filter_map(|entry| match (entry.frame.id(), entry.frame.data()) {
            (Id::Standard(id), [0]) => id.checked_sub(0x700),
            _ => None,
        })
        .collect();
    let expected: BTreeSet<u16> = (1..=7).chain(11..=16).collect();
    assert_eq!(booted, expected);
    // MP and nodes speak FD, the drives never
    let long = |entry: &&Entry| entry.frame.is_fd() && entry.frame.data().len() > 8;
    let speakers: BTreeSet<u32> = seen
        .iter()
        .filter(long)
        .filter_map(|entry| match entry.frame.id() {
            Id::Extended(id) => Some(id & 0x7F),
            Id::Standard(_) => None,
        })
        .collect();
    assert_eq!(speakers, BTreeSet::from([1, 11, 12]));
    let drives = |entry: &&Entry| matches!(entry.frame.id(), Id::Standard(_));
    let mut drives = seen.iter().filter(drives);
    assert!(drives.all(|entry| !entry.frame.is_fd()));
}

/// A virtual interface has no errors of its own, but hands on the error frames that another program sends: those of
/// drivers of real controllers look the same.
#[test]
fn a_controller_that_goes_bus_off_is_told_by_everyone_who_is_on_it() {
    if !is_here(FD) {
        return;
    }
    let mut cell = Cell::start(FD, &["irp6-postument"]);
    let mut told = |class: &str, controller: &str, state: &str| {
        // cansend: 8 digits with the kernel's flag of error frames
        let frame = format!("{class}#00{controller}000000000000");
        system("cansend", &[FD, &frame]);
        let event = cell.nodes[0].event("bus", |_| true);
        assert_eq!(
            (&event["bus"], &event["state"]),
            (&"can:vcan0".into(), &state.into())
        );
    };
    told("20000204", "20", "Passive");
    told("20000040", "00", "BusOff");
    told("20000100", "00", "Active");
    for node in cell.nodes {
        Cell::interrupted(node, 0);
    }
    cell.simulator.interrupt();
    let (status, said) = cell.simulator.end();
    assert_eq!(status.code(), Some(0), "{said:#?}");
    let lines = |state: &str| {
        let what = format!("irp6-postument: can:vcan0: {state}");
        said.iter().filter(|line| line.starts_with(&what)).count()
    };
    assert_eq!(
        ["error-passive: ", "bus-off: ", "error-active again"].map(lines),
        [1, 1, 1],
        "{said:#?}"
    );
}

/// A coordinator on an interface, torque on in all its robots.
fn enabled(interface: &str, robots: &[(u8, usize)]) -> Coordinator {
    let (bus, mtu) = open_can(interface, Hears::All).unwrap();
    let mut coordinator = Coordinator::on(bus, mtu, robots);
    coordinator.wait("configured", |robot| {
        robot.state() == Some(NodeState::Disabled)
    });
    coordinator.acquire();
    coordinator.demand(|_, epoch| Request::Enable { epoch });
    coordinator.wait("enabled", |robot| {
        robot.state() == Some(NodeState::Unsynchronised)
    });
    coordinator
}

#[test]
fn an_interface_that_goes_down_and_comes_back_leaves_a_robot_that_stands() {
    if !is_here(FD) {
        return;
    }
    let mut cell = Cell::start(FD, &["irp6-postument"]);
    let mut coordinator = enabled(FD, &[(2, 6)]);
    let start = demands(&coordinator);
    coordinator.start(SHORT_RAD);
    coordinator.done();
    let short = since(&start, &demands(&coordinator));
    let start = demands(&coordinator);
    coordinator.start(LONG_RAD);
    under_way(&mut coordinator, &start, &short);
    system("ip", &["link", "set", FD, "down"]);
    for _ in 0..25 {
        coordinator.cycle();
    }
    system("ip", &["link", "set", FD, "up"]);
    cell.unplugged = true;

    // the drives went silent for the node long before its lease ended; who is first is kept
    let fault = cell.nodes[0].event("fault", |_| true);
    println!("{fault}");
    assert_eq!(fault["during"], "Moving");
    coordinator.wait("faulted", |robot| robot.state() == Some(NodeState::Faulted));
    let image = coordinator.robots[0].feedback.clone().unwrap();
    let cause = image.fault.unwrap().cause;
    assert_eq!(fault["code"], cause.code());
    assert_ne!(cause, Cause::LeaseExpired);
    let stopped = demands(&coordinator);
    for _ in 0..50 {
        coordinator.cycle();
    }
    assert_eq!(demands(&coordinator), stopped, "nothing resumes by itself");
    let image = coordinator.robots[0].feedback.clone().unwrap();
    assert_eq!(
        (image.state, image.limit_violations),
        (NodeState::Faulted, 0)
    );
    drop(coordinator);
    cell.end(1);
}

#[test]
fn a_classical_interface_carries_a_cell_without_one_fd_frame() {
    if !is_here(CLASSIC) {
        return;
    }
    let mut witness = Witness::of(CLASSIC);
    let mut cell = Cell::start(CLASSIC, &["irp6-postument"]);
    let mut coordinator = enabled(CLASSIC, &[(2, 6)]);
    let start = demands(&coordinator);
    coordinator.start(SHORT_RAD);
    coordinator.done();
    let short = since(&start, &demands(&coordinator));
    let start = demands(&coordinator);
    coordinator.start(LONG_RAD);
    under_way(&mut coordinator, &start, &short);
    drop(coordinator);
    let fault = cell.nodes[0].event("fault", |_| true);
    assert_eq!(fault["code"], Cause::LeaseExpired.code());
    cell.nodes[0].event("state", |event| event["state"] == "Faulted");
    let seen = witness.seen();
    assert!(seen.len() > 1000, "{} frames", seen.len());
    assert_eq!(seen.iter().filter(|entry| entry.frame.is_fd()).count(), 0);
    cell.end(1);

    let (mut bus, mtu) = open_can(CLASSIC, Hears::All).unwrap();
    assert_eq!(mtu, Mtu::Classic);
    let frame = Frame::fd(Id::Extended(1), &[0; 12]).unwrap();
    assert!(matches!(
        bus.send(&frame),
        Err(BusError::FdUnsupported { .. })
    ));
}

#[test]
fn the_kernel_holds_no_more_frames_than_it_may_and_an_urgent_one_overtakes_the_rest() {
    if !is_here(CLASSIC) {
        return;
    }
    let (witness, mut socket) = (
        Witness::of(CLASSIC),
        SocketCan::open(CLASSIC, Hears::Extended).unwrap(),
    );
    // 16 bytes a frame: 2 at once, then 62 a second
    let slow = "root tbf rate 8kbit burst 32 limit 100000";
    let words = ["qdisc", "add", "dev", CLASSIC];
    system(
        "tc",
        &[&words[..], &slow.split(' ').collect::<Vec<_>>()].concat(),
    );
    let mut refused = 0;
    for number in 0..2 * (KERNEL_QUEUE + QUEUE) {
        let data = u16::try_from(number).unwrap().to_le_bytes();
        let sent = socket.send(&Frame::classic(Id::Standard(0x400), &data).unwrap());
        if let Err(error) = sent {
            assert!(matches!(error, BusError::Full { .. }), "{error}");
            refused = number;
            break;
        }
        if number == QUEUE / 2 {
            let urgent = Frame::classic(Id::Standard(0x001), &[]).unwrap();
            socket.send(&urgent).unwrap();
        }
    }
    let until = Instant::now() + PATIENCE;
    let place = loop {
        // whoever waits flushes
        socket
            .wait(bus::now() + protocol::time::Micros::from_millis(20))
            .unwrap();
        let seen = witness.read();
        let sent: Vec<Id> = seen.iter().map(|entry| entry.frame.id()).collect();
        if let Some(place) = sent
            .iter()
            .filter(|id| **id != super::witness::MARK)
            .position(|id| *id == Id::Standard(1))
        {
            break place;
        }
        assert!(Instant::now() < until, "{sent:?}");
    };
    system("tc", &["qdisc", "del", "dev", CLASSIC, "root"]);
    println!("{place} frames went before the urgent one; {refused} were taken");
    // what the kernel held, what it had sent at once, and what it sent meanwhile
    assert!((KERNEL_QUEUE / 2..=KERNEL_QUEUE + 8).contains(&place));
    assert!((QUEUE + KERNEL_QUEUE / 2..=QUEUE + KERNEL_QUEUE + 8).contains(&refused));
    // in order, none is lost
    let seen = loop {
        socket
            .wait(bus::now() + protocol::time::Micros::from_millis(20))
            .unwrap();
        let seen = witness.read();
        let numbers: Vec<u16> = seen
            .iter()
            .filter(|entry| entry.frame.id() == Id::Standard(0x400))
            .map(|entry| u16::from_le_bytes([entry.frame.data()[0], entry.frame.data()[1]]))
            .collect();
        if numbers.len() >= refused {
            break numbers;
        }
        assert!(Instant::now() < until, "{numbers:?}");
    };
    assert!(
        seen.iter().zip(0..).all(|(number, k)| *number == k),
        "{seen:?}"
    );
}
