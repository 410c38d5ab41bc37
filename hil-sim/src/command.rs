//! What the process does: robots in threads of their own, and the hub between the processes.

pub(crate) mod args;
mod touch;

use args::{Args, Simulated};
use bus::hub::{HubServer, Reachable};
use bus::spec::Place;
use bus::{Bus, BusError, Hears, open_can};
use firmware::{DriveAddress, Station};
use hil_sim::cell::setup;
use hil_sim::plant::contact::{Plate, Tip};
use hil_sim::plant::force_sensor::ForceNode;
use hil_sim::plant::robot::SimRobot;
use hil_sim::realtime::clock::Clock;
use hil_sim::realtime::{LiveRobot, Statistics, Waiting};
use process::{End, Lateness, exit};
use protocol::time::Micros;
use protocol::transfer::Mtu;
use robots::{Robot, RobotKind, RobotVisitor};
use serde_json::{Value, json};
use std::io::Write as _;
use std::net::ToSocketAddrs as _;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// Between two looks at what the robots report.
const LOOK: Duration = Duration::from_millis(50);
/// Lateness is told once in so many looks: every 5 s.
const LOOKS_PER_REPORT: u32 = 100;

/// Runs the robots until somebody ends it.
///
/// # Errors
/// When the bus cannot be opened, or fails.
pub(crate) fn run(args: &Args) -> Result<(), End> {
    let ending = Arc::new(AtomicBool::new(false));
    let (bus, hub) = open_hub(args)?;
    let mut live = Vec::new();
    for (number, robot) in args.robots.iter().enumerate() {
        let built = build(args, hub.as_ref(), robot)?;
        live.push((robot.kind, built.with_faults(args.faults.of(number))));
    }
    let asked = Arc::clone(&ending);
    ctrlc::set_handler(move || asked.store(true, Ordering::Relaxed))
        .map_err(|error| End::new(exit::INTERNAL, format!("cannot listen to Ctrl-C: {error}")))?;
    let running: Vec<Running> = live
        .into_iter()
        .map(|(kind, robot)| Running::start(kind, robot, &ending))
        .collect::<Result<_, _>>()?;
    begin(args, &bus, hub.as_ref());
    let mut looks = 0;
    let mut told: Vec<u64> = vec![0; running.len()];
    while !ending.load(Ordering::Relaxed) {
        thread::sleep(LOOK);
        looks += 1;
        if looks % LOOKS_PER_REPORT == 0 {
            for (robot, told) in running.iter().zip(&mut told) {
                robot.tell_if_late(args.json, told);
            }
        }
    }
    let mut result = Ok(());
    for robot in running {
        let ended = robot.end(args.json);
        result = result.and(ended);
    }
    if let Some(hub) = hub {
        let (frames, dropped) = (hub.frames(), hub.dropped());
        say(
            args.json,
            &format!(
                "hub: {frames} frames, {dropped} not taken by a participant that did not read"
            ),
            &json!({"event": "summary", "hub": {"frames": frames, "dropped": dropped}}),
        );
    }
    result
}

/// The hub, if the bus is one, and what to call the bus.
fn open_hub(args: &Args) -> Result<(String, Option<HubServer>), End> {
    let (host, port) = match &args.place {
        place @ (Place::Can { .. } | Place::Slcan(_)) => return Ok((place.to_string(), None)),
        Place::Hub { host, port } => (host.as_str(), *port),
    };
    let unavailable = |text: String| End::new(exit::UNAVAILABLE, text);
    let address = (host, port)
        .to_socket_addrs()
        .map_err(|error| unavailable(format!("hub {host}:{port}: no such host: {error}")))?
        .next()
        .ok_or_else(|| unavailable(format!("hub {host}:{port}: no address")))?;
    let mut channels = vec!["mp".to_owned()];
    for robot in &args.robots {
        channels.extend((0..robot.buses()).map(|bus| format!("{}.{bus}", robot.kind)));
    }
    let names: Vec<&str> = channels.iter().map(String::as_str).collect();
    let hub = HubServer::bind_to(address, &names, Reachable::Loopback)
        .map_err(|error| unavailable(error.to_string()))?;
    Ok((format!("hub:{}", hub.address()), Some(hub)))
}

/// Where the drives of a robot are, and its servo step, µs.
struct Wiring<'a>(&'a Station);

impl RobotVisitor for Wiring<'_> {
    type Output = Result<(Vec<DriveAddress>, u32), firmware::ConfigError>;

    fn visit<R: Robot<N>, const N: usize>(self, robot: R) -> Self::Output {
        let config = self.0.config(robot.description().drive_buses())?;
        let step_us = robot.description().servo_step_us;
        Ok((config.drives.to_vec(), step_us))
    }
}

fn build(args: &Args, hub: Option<&HubServer>, simulated: &Simulated) -> Result<LiveRobot, End> {
    let (kind, effector) = (simulated.kind, simulated.effector);
    let station = simulated.station(hub.is_none());
    let wrong = |error: &dyn std::fmt::Display| {
        End::new(
            exit::USAGE,
            format!("{kind} as effector {effector}: {error}"),
        )
    };
    let config = |error: firmware::ConfigError| wrong(&error);
    let (drives, step_us) = kind
        .visit(station.track, Wiring(&station))
        .map_err(config)?;
    let period = Micros(u64::from(step_us));
    let robot = |mtu: Mtu| {
        let mut setup = setup(kind, &drives, args.seed, args.quirks);
        for axis in &mut setup.axes {
            axis.drive.fd = mtu == Mtu::Fd;
        }
        let mut robot = SimRobot::new(setup, args.seed).map_err(|error| wrong(&error))?;
        let sensor = simulated.force;
        robot.set_force_node(sensor.map(|address| ForceNode::of(kind, address, args.seed)));
        if !simulated.plates.is_empty() {
            let obstacles = simulated.plates.iter().map(Plate::obstacle).collect();
            if !robot.surround(obstacles, Tip::of(kind)) {
                return Err(wrong(
                    &"--surface: expected a robot that can touch something",
                ));
            }
        }
        Ok(robot)
    };
    let unavailable = |error: BusError| End::new(exit::UNAVAILABLE, error.to_string());
    Ok(match (&args.place, hub) {
        (Place::Hub { .. }, Some(hub)) => {
            let names = (0..simulated.buses()).map(|bus| format!("{kind}.{bus}"));
            let taps = names.filter_map(|name| hub.tap(&name));
            let taps = taps
                .map(|tap| Box::new(tap) as Box<dyn Bus + Send>)
                .collect();
            LiveRobot::new(
                robot(Mtu::Classic)?,
                taps,
                Waiting::Wake,
                Clock::waiting(period.0 * 1000),
                period,
            )
        }
        (Place::Can { interface }, _) => {
            let (can, mtu) = open_can(interface, Hears::Standard).map_err(unavailable)?;
            let robot = robot(mtu)?;
            LiveRobot::new(robot, vec![can], Waiting::Look, Clock::strict(), period)
        }
        (Place::Slcan(adapter), _) => {
            let line = Box::new(adapter.open().map_err(unavailable)?);
            let robot = robot(Mtu::Classic)?;
            LiveRobot::new(robot, vec![line], Waiting::Look, Clock::strict(), period)
        }
        (Place::Hub { .. }, None) => {
            return Err(End::new(exit::INTERNAL, "the hub was not started"));
        }
    })
}

fn begin(args: &Args, bus: &str, hub: Option<&HubServer>) {
    let names: Vec<String> = args
        .robots
        .iter()
        .map(|robot| {
            let force = if robot.force.is_some() {
                " with a force sensor"
            } else {
                ""
            };
            format!("{} as effector {}{force}", robot.kind, robot.effector)
        })
        .collect();
    let robots: Vec<Value> = args
        .robots
        .iter()
        .map(|robot| {
            let kind = robot.kind;
            json!({
                "name": kind.name(), "effector": robot.effector, "axes": kind.axes(),
                "force_bus": robot.force.map(|force| force.bus),
            })
        })
        .collect();
    let port = hub.map(|hub| hub.address().port());
    warn(&format!(
        "{bus}: simulating {}; seed {}; Ctrl-C ends it",
        names.join(", "),
        args.seed
    ));
    let ready = json!({
        "event": "ready", "bus": bus, "port": port, "robots": robots, "seed": args.seed,
    });
    say(args.json, "", &ready);
}

/// A robot in its thread.
struct Running {
    kind: RobotKind,
    statistics: Arc<Mutex<Statistics>>,
    thread: JoinHandle<(Result<(), BusError>, Lateness)>,
}

impl Running {
    fn start(kind: RobotKind, mut robot: LiveRobot, ending: &Arc<AtomicBool>) -> Result<Self, End> {
        let statistics = Arc::new(Mutex::new(Statistics::default()));
        let (shared, ending) = (Arc::clone(&statistics), Arc::clone(ending));
        let thread = thread::Builder::new()
            .name(kind.name().to_owned())
            .spawn(move || {
                let mut result = Ok(());
                while result.is_ok() && !ending.load(Ordering::Relaxed) {
                    result = robot.turn();
                    while let Some(change) = robot.take_change() {
                        warn(&format!("{kind}: {change}"));
                    }
                    *shared.lock().unwrap_or_else(PoisonError::into_inner) = robot.statistics();
                }
                ending.store(true, Ordering::Relaxed);
                (result, robot.lateness().clone())
            })
            .map_err(|error| End::new(exit::INTERNAL, format!("{kind}: no thread: {error}")))?;
        Ok(Self {
            kind,
            statistics,
            thread,
        })
    }

    fn statistics(&self) -> Statistics {
        *self
            .statistics
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }

    /// Says so if it was late since it was last asked.
    fn tell_if_late(&self, json: bool, told: &mut u64) {
        let s = self.statistics();
        let events = s.late + s.held.count;
        if std::mem::replace(told, events) == events {
            return;
        }
        warn(&format!("{}: {}", self.kind, lateness(&s)));
        say(
            json,
            "",
            &json!({"event": "late", "robot": self.kind.name(), "lateness": late(&s)}),
        );
    }

    fn end(self, json: bool) -> Result<(), End> {
        let (s, kind) = (self.statistics(), self.kind);
        let (result, called) = self.thread.join().map_err(|_| {
            let what = "its simulation panicked";
            End::new(exit::INTERNAL, format!("{kind}: {what}"))
        })?;
        let seconds = Micros(s.simulated_ns / 1000).as_secs_f64();
        say(
            json,
            &format!(
                "{kind}: {seconds:.3} s simulated; {} frames received, {} sent, {} dropped; {}\n{kind}: called {called}",
                s.received,
                s.sent,
                s.dropped,
                lateness(&s)
            ),
            &json!({
                "event": "summary", "robot": kind.name(), "simulated_s": seconds,
                "frames_received": s.received, "frames_sent": s.sent, "frames_dropped": s.dropped,
                "lateness": late(&s), "lateness_histogram_us": called.histogram(),
            }),
        );
        result.map_err(|error| End::new(exit::IO, format!("{kind}: {error}")))
    }
}

fn lateness(s: &Statistics) -> String {
    let ms = |ns: u64| Micros(ns / 1000).as_secs_f64() * 1e3;
    format!(
        "late {} times, worst {:.1} ms; simulated time waited for SYNC {} times, worst {:.1} ms, \
         {:.1} ms in all",
        s.late,
        s.late_worst.as_secs_f64() * 1e3,
        s.held.count,
        ms(s.held.worst_ns),
        ms(s.held.total_ns)
    )
}

fn late(s: &Statistics) -> Value {
    json!({
        "late": s.late, "late_max_us": s.late_worst.as_micros(), "held": s.held.count,
        "held_max_us": s.held.worst_ns / 1000, "held_total_us": s.held.total_ns / 1000,
    })
}

/// A result, for people or for machines. Nobody may be reading: no reason to stop.
fn say(json: bool, text: &str, value: &Value) {
    let mut out = std::io::stdout();
    let _ = if json {
        writeln!(out, "{value}")
    } else if text.is_empty() {
        Ok(())
    } else {
        writeln!(out, "{text}")
    };
}

/// Something to know while it runs.
fn warn(text: &str) {
    let _ = writeln!(std::io::stderr(), "{text}");
}
