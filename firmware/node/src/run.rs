//! The loop: wait for the node's next instant, hand it what has arrived, send what it says.

use crate::args::Args;
use crate::beat::Beat;
use crate::panel::{Ended, Panel};
use crate::ports::{self, Ports};
use crate::printer::Printer;
use crate::report::Report;
use crate::state::State;
use bus::now;
use bus::spec::Place;
use firmware::config::ForceAddress;
use firmware::maintenance::Kept;
use firmware::{ConfigError, KnownDrives, Node, NodeProcess, Port, Station};
use process::{End, Lateness, exit};
use protocol::canopen::lss;
use protocol::id::NodeId;
use protocol::time::Micros;
use protocol::transfer::Mtu;
use robots::{Robot, RobotKind, RobotVisitor};
use serde_json::json;
use std::fmt::Debug;
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};
use std::time::{SystemTime, UNIX_EPOCH};

/// After a restart was asked for: for its answer to leave this process.
const FAREWELL: Micros = Micros::from_millis(20);

/// How a node's life has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Over {
    /// Somebody ended it.
    Ended,
    /// Somebody wants it to begin anew.
    Restarts,
}

/// Runs the node until somebody ends it; as often as it is restarted.
///
/// # Errors
/// When the buses cannot be opened, or fail.
pub(crate) fn run(args: &Args) -> Result<(), End> {
    let asked = Arc::new(AtomicU8::new(0));
    let asking = Arc::clone(&asked);
    ctrlc::set_handler(move || {
        asking.fetch_add(1, Ordering::Relaxed);
    })
    .map_err(|error| End::new(exit::INTERNAL, format!("cannot listen to Ctrl-C: {error}")))?;
    while live(args, &asked)? == Over::Restarts {}
    Ok(())
}

/// One life, from the start as of a processor.
fn live(args: &Args, asked: &Arc<AtomicU8>) -> Result<Over, End> {
    let printer = Printer::new(args.json);
    let mut station = Station {
        effector: args.effector,
        unique_id: unique_id(),
        mtu: Mtu::Classic,
        law: args.law,
        velocity_factor: args.velocity_factor,
        one_wire: !matches!(args.place, Place::Hub { .. }),
        track: args.track,
    };
    let wrong = |error: ConfigError| {
        End::new(
            exit::USAGE,
            format!("{} as effector {}: {error}", args.robot, args.effector),
        )
    };
    let force = args.force_bus.map(|bus| {
        let address = station.force(args.robot, bus);
        address.map_err(|error| End::usage(format!("--force-bus {bus}: {}: {error}", args.robot)))
    });
    let force = force.transpose()?;
    let known = KnownDrives {
        identities: &args.drives.drive,
        find: args.drives.find_drives,
        stored: args.drives.stored_setup,
    };
    let drives = args.robot.visit(args.track, Drives(&station, &known));
    let drives = drives.map_err(wrong)?;
    let opened = ports::open(&args.place, args.robot, &drives, force, &mut |line| {
        printer.tell(line);
    })?;
    station.mtu = opened.mtu;
    if args.drives.fast_drives && opened.mtu != Mtu::Fd {
        return Err(End::new(
            exit::UNAVAILABLE,
            format!(
                "{}: --fast-drives: this interface carries classical frames only (CAN FD has an mtu of 72: \
                 `ip link set … mtu 72`, a controller also `type can … dbitrate … fd on`)",
                args.place
            ),
        ));
    }
    let state = State::open(args.state.as_deref(), args.robot)?;
    let build = Build {
        station: &station,
        fast_drives: args.drives.fast_drives,
        force,
        known: &known,
        state: &state,
        wrong: &wrong,
    };
    let node = args.robot.visit(args.track, build)?;
    let identity = node.identity();
    let half = Micros(u64::from(identity.servo_step_us) / 2);
    let mut work = Work {
        robot: args.robot,
        node,
        ports: opened.ports,
        report: Report::new(args.robot),
        lateness: Lateness::new(half.into()),
        beat: Beat::new(half),
        printer,
        asked: Arc::clone(asked),
        id: NodeId::effector(args.effector).unwrap_or(NodeId::MP),
    };
    work.begin(args, &state);
    let over = work.turn();
    work.summary();
    state.end().and(over)
}

/// Random enough to tell this process from the one before.
fn unique_id() -> u64 {
    let since = SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .unwrap_or_default();
    u64::from(std::process::id()) << 32 ^ u64::try_from(since.as_micros()).unwrap_or(0)
}

/// The ids of a robot's drives, and that which the answers of layer setting look like where nodes are told apart by it.
struct Drives<'a>(&'a Station, &'a KnownDrives<'a>);

impl RobotVisitor for Drives<'_> {
    type Output = Result<Vec<u8>, ConfigError>;

    fn visit<R: Robot<N>, const N: usize>(self, robot: R) -> Self::Output {
        let config = self.0.config(robot.description().drive_buses())?;
        let config = config.with_drives(self.1)?;
        let drives = config.drives.iter().map(|drive| drive.id.get());
        let layer = self.1.find || !self.1.identities.is_empty();
        let [answers, _] = lss::SLAVE_COB.to_le_bytes();
        Ok(drives.chain(layer.then_some(answers & 0x7F)).collect())
    }
}

/// Makes the node of a robot.
struct Build<'a, W> {
    station: &'a Station,
    fast_drives: bool,
    force: Option<ForceAddress>,
    known: &'a KnownDrives<'a>,
    state: &'a State,
    wrong: &'a W,
}

impl<W: Fn(ConfigError) -> End> RobotVisitor for Build<'_, W> {
    type Output = Result<Box<dyn NodeProcess>, End>;

    fn visit<R, const N: usize>(self, robot: R) -> Self::Output
    where
        R: Robot<N> + Copy + Debug + Send + Sync + 'static,
    {
        let config = self.station.config(robot.description().drive_buses());
        let config = config.and_then(|config| config.with_drives(self.known));
        let node = config.and_then(|mut config| {
            config.fast_drives = self.fast_drives;
            config.force = self.force;
            Node::new(now(), robot, config)
        });
        let keeper = self.state.keeper(N)?;
        Ok(Box::new(Kept::new(node.map_err(self.wrong)?, keeper)))
    }
}

struct Work {
    robot: RobotKind,
    node: Box<dyn NodeProcess>,
    ports: Ports,
    report: Report,
    lateness: Lateness,
    beat: Beat,
    printer: Printer,
    asked: Arc<AtomicU8>,
    id: NodeId,
}

impl Work {
    fn begin(&self, args: &Args, state: &State) {
        let identity = self.node.identity();
        self.printer.tell(format!(
            "{}: effector {} is node {}, {} axes, servo step {} us, schema {:016x}; Ctrl-C ends it",
            self.robot,
            args.effector,
            self.id,
            identity.axes,
            identity.servo_step_us,
            identity.schema_hash
        ));
        self.printer.json(&json!({
            "event": "ready", "robot": self.robot.name(), "effector": args.effector,
            "node": self.id.get(), "axes": identity.axes, "servo_step_us": identity.servo_step_us,
            "boots": state.boots, "reset_cause": format!("{:?}", state.cause),
        }));
    }

    fn turn(&mut self) -> Result<Over, End> {
        let mut rx = Vec::new();
        let mut panel: Option<Panel> = None;
        let mut failure: Option<End> = None;
        loop {
            let due = self.node.next_wake();
            let at = self.beat.wall(due);
            self.ports.wait_until(at, &mut rx);
            self.lateness.record(now().since(at).into());
            self.ports.await_answers(&mut rx);
            for received in &mut rx {
                received.at = self.beat.node(received.at);
            }
            let now = now();
            self.beat.called(due, now);
            while let Some(change) = self.ports.take_change() {
                self.report.bus(now, &change, &self.printer);
            }
            if let Some(error) = self.ports.take_failure() {
                self.printer
                    .tell(format!("{}: {error}: stopping", self.robot));
                failure.get_or_insert(End::new(exit::IO, error.to_string()));
                panel.get_or_insert_with(|| Panel::new(self.id, due));
            }
            let asked = self.asked.load(Ordering::Relaxed);
            if asked > 0 && panel.is_none() {
                self.printer.tell(format!(
                    "{}: asked to end: path stop, torque off",
                    self.robot
                ));
                panel = Some(Panel::new(self.id, due));
            }
            if let Some(panel) = &mut panel {
                if asked > 1 {
                    panel.cut(due);
                }
                let mut ended = panel.step(due, self.node.state(), &mut rx);
                if self.ports.all_failed() {
                    // nothing can be told to the drives any more: they stop by themselves
                    ended = Some(Ended::Cut);
                }
                if let Some(ended) = ended {
                    self.printer.tell(match ended {
                        Ended::InOrder => format!("{}: torque off", self.robot),
                        Ended::Cut => format!("{}: torque cut", self.robot),
                    });
                    return failure.map_or(Ok(Over::Ended), Err);
                }
            }
            let Self {
                node,
                ports,
                report,
                printer,
                ..
            } = self;
            node.step(due, &rx, &mut |port, frame| {
                if port == Port::Mp {
                    if panel.as_mut().is_some_and(|panel| panel.takes(&frame, due)) {
                        return;
                    }
                    report.frame(now, &frame, printer);
                }
                ports.send(port, &frame);
            });
            rx.clear();
            report.state(now, node.state(), printer);
            if node.restarts() {
                // torque is off: this was granted for no other state
                printer.tell(format!("{}: asked to restart", self.robot));
                ports.wait_until(bus::now() + FAREWELL, &mut rx);
                return Ok(Over::Restarts);
            }
        }
    }

    fn summary(&self) {
        let traffic = self.ports.traffic();
        let late = &self.lateness;
        let last = self.report.last();
        let (steps, violations, lost) =
            last.map_or((0, 0, 0), |f| (f.step, f.limit_violations, f.lost));
        let us = |permille| late.percentile(permille).as_micros();
        self.printer.result(format!(
            "{robot}: {steps} servo steps, {faults} faults, {violations} limit violations, {lost} \
             commands lost\n\
             {robot}: called {late}; behind by {behind} us at worst\n\
             {robot}: {sent} frames sent, {received} received, {dropped} dropped; late answers \
             awaited {awaited} times, worst {awaited_us} us",
            robot = self.robot,
            faults = self.report.faults(),
            behind = self.beat.worst().0,
            sent = traffic.sent,
            received = traffic.received,
            dropped = traffic.dropped,
            awaited = traffic.awaited,
            awaited_us = traffic.awaited_worst.0,
        ));
        self.printer.json(&json!({
            "event": "summary", "robot": self.robot.name(), "servo_steps": steps,
            "faults": self.report.faults(), "limit_violations": violations, "commands_lost": lost,
            "lateness_us": {"p50": us(500), "p99": us(990), "p99_9": us(999), "max": us(1000)},
            "lateness_histogram_us": late.histogram(),
            "overruns": late.overruns(), "calls": late.calls(),
            "behind_max_us": self.beat.worst().0, "frames_sent": traffic.sent,
            "frames_received": traffic.received, "frames_dropped": traffic.dropped,
            "answers_awaited": traffic.awaited, "answers_awaited_max_us": traffic.awaited_worst.0,
        }));
    }
}
