//! Simulator, nodes and coordinator as processes of their own, in real time, over a hub; [`vcan`]: over
//! SocketCAN.
//!
//! Nothing here asserts how long something takes; time-outs only end what hangs.
#![cfg(unix)]
#![forbid(unsafe_code)]

#[path = "processes/child.rs"]
mod child;
#[path = "processes/coordinator.rs"]
mod coordinator;
#[path = "processes/force.rs"]
mod force;
#[path = "processes/keeping.rs"]
mod keeping;
#[cfg(target_os = "linux")]
#[path = "processes/vcan.rs"]
mod vcan;
#[cfg(target_os = "linux")]
#[path = "processes/witness.rs"]
mod witness;

use child::Process;
use coordinator::Coordinator;
use mrroc_tests::stalls::in_real_time;
use protocol::fault::{Cause, Refusal};
use protocol::message::{NodeState, Progress, Reply, Request};
use std::net::TcpListener;

const ROBOTS: [(&str, u8, usize); 2] = [("irp6-track", 1, 7), ("irp6-postument", 2, 6)];

/// The short move, rad of the fastest motor, and one that lasts long enough to be cut off.
const SHORT_RAD: f64 = 1.0;
const LONG_RAD: f64 = 40.0;

#[test]
fn a_node_whose_coordinator_disappears_stops_on_its_path_and_says_why() {
    in_real_time(a_coordinator_disappears);
}

#[expect(
    clippy::too_many_lines,
    reason = "one story: starting the processes is dear"
)]
fn a_coordinator_disappears() {
    let mut args: Vec<&str> = ROBOTS.iter().map(|(name, ..)| *name).collect();
    args.extend(["--bus", "hub:0", "--json"]);
    let mut simulator = Process::start("mrroc-hil-sim", &args);
    let port = simulator.event("ready", |_| true)["port"].as_u64().unwrap();
    let port = u16::try_from(port).unwrap();
    let hub = format!("hub:{port}");
    let mut nodes = ROBOTS.map(|(name, effector, axes)| {
        let mut node = Process::start("mrroc-node", &[name, "--bus", &hub, "--json"]);
        let ready = node.event("ready", |_| true);
        assert_eq!(
            (&ready["effector"], &ready["axes"]),
            (&effector.into(), &axes.into())
        );
        node
    });
    let robots = ROBOTS.map(|(_, effector, axes)| (effector, axes));

    // A first coordinator: torque on, a whole move, and away in the middle of another.
    let mut first = Coordinator::join(port, &robots);
    first.wait("configured", |robot| {
        robot.state() == Some(NodeState::Disabled)
    });
    first.acquire();
    first.demand(|_, epoch| Request::Enable { epoch });
    first.wait("enabled", |robot| {
        robot.state() == Some(NodeState::Unsynchronised)
    });
    let start = demands(&first);
    first.start(SHORT_RAD);
    first.done();
    let short = since(&start, &demands(&first));
    let start = demands(&first);
    first.start(LONG_RAD);
    under_way(&mut first, &start, &short);
    drop(first);

    for node in &mut nodes {
        let fault = node.event("fault", |_| true);
        assert_eq!(
            fault["name"],
            "LeaseExpired",
            "{:#?} {:#?}",
            node.said(),
            simulator.said()
        );
        assert_eq!(fault["code"], Cause::LeaseExpired.code());
        assert_eq!(fault["during"], "Moving");
        assert_eq!(fault["page"], "docs/faults/10.md");
        node.event("state", |event| event["state"] == "Faulted");
        assert!(
            node.states().ends_with(&["Moving", "Stopping", "Faulted"]),
            "{:?}",
            node.states()
        );
        let said = node.said();
        let told = |line: &&String| line.contains("lease expired") && line.contains("path stop");
        assert_eq!(said.iter().filter(told).count(), 1, "{said:#?}");
    }

    // A second one, whose time starts at 0 again, sees what happened and can go on.
    let mut second = Coordinator::join(port, &robots);
    second.wait("faulted", |robot| robot.state() == Some(NodeState::Faulted));
    for robot in &second.robots {
        let feedback = robot.feedback.as_ref().unwrap();
        let fault = feedback.fault.unwrap();
        assert_eq!((fault.cause, fault.axis), (Cause::LeaseExpired, None));
        assert_eq!(fault.during, NodeState::Moving);
        assert_eq!((feedback.epoch, feedback.limit_violations), (0, 0));
        assert_eq!(feedback.progress, Progress::Failed(Refusal::Aborted));
    }
    let stopped = demands(&second);
    for ((way, whole), start) in since(&start, &stopped).iter().zip(&short).zip(&start) {
        on_the_path(way, whole, start);
    }
    second.acquire();
    let refused = second.ask(|robot| Request::Synchronise {
        epoch: robot.feedback.as_ref().map_or(0, |f| f.epoch),
    });
    assert!(
        refused
            .iter()
            .all(|reply| matches!(reply, Reply::Refused(_))),
        "{refused:?}"
    );
    second.demand(|_, epoch| Request::Acknowledge { epoch });
    second.wait("acknowledged", |robot| {
        robot.state() == Some(NodeState::Unsynchronised)
    });
    assert_eq!(demands(&second), stopped, "nothing resumes by itself");
    second.start(-SHORT_RAD);
    second.done();

    // Ctrl-C while moving: path stop, torque off, no fault.
    let start = demands(&second);
    second.start(-LONG_RAD);
    under_way(&mut second, &start, &short);
    for node in &nodes {
        node.interrupt();
    }
    while !nodes.iter_mut().all(Process::has_ended) {
        second.cycle();
    }
    for (node, robot) in nodes.iter_mut().zip(&second.robots) {
        let faults = robot.fault_events;
        let (status, said) = node.end();
        assert_eq!(status.code(), Some(0), "{said:#?}");
        assert!(
            said.iter().any(|line| line.ends_with("torque off")),
            "{said:#?}"
        );
        let states = node.states();
        let end = ["Moving", "Stopping", "Unsynchronised", "Disabled"];
        assert!(states.ends_with(&end), "{states:?}");
        assert_eq!(faults, 0, "the second coordinator heard of a new fault");
        let summary = node.events.last().unwrap();
        assert_eq!(
            (&summary["event"], &summary["faults"]),
            (&"summary".into(), &1.into())
        );
        assert_eq!(summary["limit_violations"], 0);
        assert!(summary["lateness_us"]["max"].as_u64() >= summary["lateness_us"]["p50"].as_u64());
    }
    simulator.interrupt();
    let (status, said) = simulator.end();
    assert_eq!(status.code(), Some(0), "{said:#?}");
    let summaries = simulator
        .events
        .iter()
        .filter(|event| event["event"] == "summary");
    assert_eq!(summaries.count(), ROBOTS.len() + 1);
}

/// Every robot has gone at least as far as in the short move.
fn under_way(coordinator: &mut Coordinator, start: &[Vec<i64>], short: &[Vec<i64>]) {
    let known: Vec<_> = coordinator.robots.iter().map(|robot| robot.node).collect();
    coordinator.wait("under way", |robot| {
        assert_eq!(
            robot.feedback.as_ref().and_then(|feedback| feedback.fault),
            None
        );
        let k = known.iter().position(|node| *node == robot.node).unwrap();
        (robot.demand()[0] - start[k][0]).abs() >= short[k][0].abs()
    });
}

fn demands(coordinator: &Coordinator) -> Vec<Vec<i64>> {
    coordinator
        .robots
        .iter()
        .map(coordinator::Robot::demand)
        .collect()
}

fn since(before: &[Vec<i64>], after: &[Vec<i64>]) -> Vec<Vec<i64>> {
    let way = |(a, b): (&Vec<i64>, &Vec<i64>)| b.iter().zip(a).map(|(b, a)| b - a).collect();
    before.iter().zip(after).map(way).collect()
}

/// Both moves are straight in the space of the motors and have the same direction, so at any
/// instant all axes have gone the same multiple of the short move.
fn on_the_path(way: &[i64], short: &[i64], start: &[i64]) {
    let longest = (0..short.len()).max_by_key(|&k| short[k].abs()).unwrap();
    let (way_0, short_0) = (way[longest], short[longest]);
    assert!(
        way_0.abs() > 0 && way_0.signum() == short_0.signum(),
        "{way:?} {short:?} {start:?}"
    );
    for (w, s) in way.iter().zip(short) {
        // |w − s·way_0/short_0|: three rounded differences, each off by at most one unit, the
        // latter two magnified by the ratio of the moves
        let off = (w * short_0 - s * way_0).abs();
        let allowed = 2 * (short_0.abs() + way_0.abs());
        assert!(off <= allowed, "off the path: {way:?}, {short:?}");
    }
}

/// One line on stderr, this code, no panic.
fn refused(name: &str, args: &[&str], code: i32, says: &[&str]) {
    let mut process = Process::start(name, args);
    let (status, said) = process.end();
    assert_eq!(status.code(), Some(code), "{name} {args:?}: {said:#?}");
    let errors: Vec<_> = said
        .iter()
        .filter(|line| line.starts_with(&format!("{name}: ")))
        .collect();
    assert_eq!(errors.len(), 1, "{name} {args:?}: {said:#?}");
    assert_eq!(said.last(), Some(errors[0]));
    assert!(
        !said.iter().any(|line| line.contains("panicked")),
        "{said:#?}"
    );
    for word in says {
        assert!(
            errors[0].contains(word),
            "{name} {args:?} does not say {word:?}: {}",
            errors[0]
        );
    }
}

#[test]
fn mistakes_are_one_line_with_a_code_of_their_own() {
    for name in ["mrroc-node", "mrroc-hil-sim"] {
        refused(
            name,
            &["irp7", "--bus", "hub"],
            64,
            &["irp7", "irp6-track, irp6-postument"],
        );
        refused(
            name,
            &["irp6-track", "--bus", "tcp:1"],
            64,
            &["tcp:1", "hub", "can:"],
        );
        refused(
            name,
            &["irp6-track", "--bus", "virtual"],
            64,
            &["virtual", "expected"],
        );
        refused(name, &["irp6-track"], 64, &["--bus"]);
        let above_all = ["irp6-track", "--bus", "hub", "--priority", "100"];
        refused(name, &above_all, 64, &["100", "1..=99"]);
        let no_interface = ["irp6-track", "--bus", "can:mrroc-none0"];
        refused(name, &no_interface, 69, &["can:mrroc-none0"]);
    }
    let fast = ["irp6-track", "--bus", "hub", "--fast-drives"];
    refused("mrroc-node", &fast, 64, &["--fast-drives", "hub", "can:"]);
    let taken = TcpListener::bind(("127.0.0.1", 0)).unwrap();
    let place = format!("hub:{}", taken.local_addr().unwrap().port());
    let address = taken.local_addr().unwrap().to_string();
    refused(
        "mrroc-hil-sim",
        &["irp6-track", "--bus", &place],
        69,
        &[&address, "cannot listen"],
    );
}

#[test]
fn a_bus_that_is_cut_by_the_simulator_stops_the_node_with_its_cause() {
    in_real_time(|| {
        let fault = "conveyor.0:cut:0@3";
        let args = ["conveyor", "--bus", "hub:0", "--json", "--fault", fault];
        let mut simulator = Process::start("mrroc-hil-sim", &args);
        let port = simulator.event("ready", |_| true)["port"].as_u64().unwrap();
        let hub = format!("hub:{port}");
        let mut node = Process::start("mrroc-node", &["conveyor", "--bus", &hub, "--json"]);
        let fault = node.event("fault", |_| true);
        assert_eq!(
            (&fault["name"], &fault["axis"]),
            (&"DriveSilent".into(), &1.into())
        );
    });
}

#[test]
fn an_encoder_that_freezes_in_the_simulator_stops_the_arm_with_its_cause() {
    in_real_time(|| {
        let (robot, fault) = ("irp6-postument", "irp6-postument/2:frozen@0");
        let args = [robot, "--bus", "hub:0", "--json", "--fault", fault];
        let mut simulator = Process::start("mrroc-hil-sim", &args);
        let port = simulator.event("ready", |_| true)["port"].as_u64().unwrap();
        let hub = format!("hub:{port}");
        let _node = Process::start("mrroc-node", &[robot, "--bus", &hub]);
        // the lower arm is homed first
        let mut master = Process::start("mrroc", &["home", robot, "--bus", &hub, "-q"]);
        let (status, said) = master.end();
        assert_eq!(status.code(), Some(10), "{said:#?}");
        let told = said.last().unwrap();
        assert!(
            told.contains("fault 30:") && told.contains("axis 2 (lower arm)"),
            "{told}"
        );
    });
}

#[test]
fn a_node_without_a_hub_gives_up() {
    // free a moment ago; if somebody takes it meanwhile, he is no hub
    let free = TcpListener::bind(("127.0.0.1", 0))
        .unwrap()
        .local_addr()
        .unwrap()
        .port();
    let place = format!("hub:{free}");
    refused(
        "mrroc-node",
        &["irp6-track", "--bus", &place],
        69,
        &["mrroc-hil-sim running?"],
    );
}
