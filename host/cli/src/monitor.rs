//! Watching a bus without taking part, and stopping everyone on it.

mod force;

use crate::run::{catch_interrupt, interrupted};
use crate::world::open_bus;
use bus::Bus;
use bus::spec::Place;
use clap::Args;
use force::Sensors;
use host::error::{Error, exit, fault_text};
use host::mp::arm::{Arm, arm, motor_angles};
use protocol::id::NodeId;
use protocol::link::{Endpoint, Message, Role};
use protocol::message::{Feedback, StopAll, StopKind};
use protocol::time::Micros;
use protocol::transfer::Mtu;
use robots::RobotKind;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::{IsTerminal, Write};

/// A node that has been silent for this long is shown as silent.
const SILENT: Micros = Micros::from_millis(1000);
/// How often the table is drawn anew.
const REFRESH: Micros = Micros::from_millis(250);
/// Stop messages of `mrroc stop`, and their distance: a lost frame must not matter.
const STOPS: u32 = 3;
const STOP_GAP: Micros = Micros::from_millis(5);
/// How long `mrroc stop` waits for nodes to be heard standing.
const STOP_PATIENCE: Micros = Micros::from_millis(5000);

/// Watch the nodes on a bus.
#[derive(Args, Debug)]
pub(crate) struct Monitor {
    /// hub, hub:PORT, hub:HOST:PORT, can:INTERFACE,
    /// slcan:DEVICE or slcan:HOST:PORT.
    #[arg(long, default_value = "hub")]
    bus: Place,
    /// A drive bus whose force sensors are shown too, with their moments: the hub's channel (irp6-postument.1), or the
    /// CAN interface. May be given several times.
    #[arg(long, value_name = "NAME")]
    force_bus: Vec<String>,
    /// Print one JSON value per node (and sensor) and refresh instead of a table.
    #[arg(long)]
    json: bool,
    /// Look for this long, then end; without it, until Ctrl-C.
    #[arg(long, value_name = "SECONDS")]
    seconds: Option<u32>,
}

/// What was heard of a node.
#[derive(Default)]
struct Heard {
    arm: Option<&'static dyn Arm>,
    name: String,
    feedback: Option<Feedback>,
    at: Micros,
}

impl Monitor {
    pub(crate) fn run(self) -> Result<u8, Error> {
        let (mut bus, _) = open_bus(&self.bus)?;
        let opened = self
            .force_bus
            .iter()
            .map(|name| Sensors::open(&self.bus, name));
        let mut sensors: Vec<Sensors> = opened.collect::<Result<_, _>>()?;
        catch_interrupt()?;
        let mut link = Endpoint::<64>::new(NodeId::MP, Role::Observer, Mtu::Classic);
        let mut nodes = BTreeMap::<u8, Heard>::new();
        let terminal = std::io::stdout().is_terminal() && !self.json;
        let begun = bus::now();
        let end = self
            .seconds
            .map(|s| begun + Micros::from_millis(u64::from(s) * 1000));
        let mut next = begun + REFRESH;
        let mut drawn = 0;
        while !interrupted() && end.is_none_or(|end| bus::now() < end) {
            listen(&mut *bus, &mut link, &mut nodes, next)?;
            for sensors in &mut sensors {
                sensors.listen()?;
            }
            if bus::now() < next {
                continue;
            }
            next = next + REFRESH;
            let (text, sensors): (_, String) = if self.json {
                (json(&nodes), sensors.iter().map(Sensors::json).collect())
            } else {
                (table(&nodes), sensors.iter().map(Sensors::table).collect())
            };
            let text = text + &sensors;
            let mut out = std::io::stdout().lock();
            let up = if terminal && drawn > 0 {
                format!("\x1b[{drawn}A\x1b[J")
            } else {
                String::new()
            };
            drawn = text.lines().count();
            // a reader that has gone away ends the watch
            if write!(out, "{up}{text}")
                .and_then(|()| out.flush())
                .is_err()
            {
                break;
            }
        }
        Ok(exit::OK)
    }
}

fn listen(
    bus: &mut dyn Bus,
    link: &mut Endpoint<64>,
    nodes: &mut BTreeMap<u8, Heard>,
    until: Micros,
) -> Result<(), Error> {
    while let Some(received) = bus.receive().map_err(|e| crate::world::bus_error(&e))? {
        let Some(incoming) = link.receive(&received.frame, received.at) else {
            continue;
        };
        let heard = nodes.entry(incoming.from.get()).or_default();
        heard.at = received.at;
        match incoming.message {
            Message::Feedback(feedback) => heard.feedback = Some(feedback),
            Message::Reply {
                reply: protocol::message::Reply::Identity(identity),
                ..
            }
            | Message::Event(protocol::message::Event::Announce(identity)) => {
                heard.name = identity.robot.as_str().into();
                heard.arm = RobotKind::from_name(&identity.robot).ok().map(arm);
            }
            _ => {}
        }
    }
    bus.wait(until).map_err(|e| crate::world::bus_error(&e))
}

/// The robot of a feedback whose node has not said its name: known by its number of axes.
fn kind_of(heard: &Heard) -> Option<&'static dyn Arm> {
    let axes = heard.feedback.as_ref()?.actual.len();
    heard.arm.or_else(|| {
        RobotKind::ALL
            .into_iter()
            .find(|k| k.axes() == axes)
            .map(arm)
    })
}

fn joints(heard: &Heard) -> Option<Vec<f64>> {
    let (arm, feedback) = (kind_of(heard)?, heard.feedback.as_ref()?);
    let all = (1_u16 << arm.axes().len()) - 1;
    if u16::from(feedback.synchronised) != all {
        return None;
    }
    let motors = motor_angles(arm.axes(), &feedback.actual)?;
    arm.joints(&motors).ok().map(|q| q.to_vec())
}

fn table(nodes: &BTreeMap<u8, Heard>) -> String {
    let mut text = format!(
        "{:>4}  {:<16} {:<15} joints / fault\n",
        "node", "robot", "state"
    );
    for (id, heard) in nodes {
        let Some(feedback) = &heard.feedback else {
            continue;
        };
        let name = kind_of(heard).map_or(heard.name.as_str(), |arm| arm.kind().name());
        let silent = bus::now().since(heard.at) > SILENT;
        let state = if silent {
            "(silent)".to_owned()
        } else {
            format!("{:?}", feedback.state)
        };
        let joints = joints(heard).map_or_else(
            || "not homed".to_owned(),
            |q| {
                q.iter()
                    .map(|q| format!("{q:8.4}"))
                    .collect::<Vec<_>>()
                    .join(" ")
            },
        );
        let fault = feedback
            .fault
            .map_or_else(String::new, |f| format!("  {}", fault_text(&f)));
        let force = feedback.force_n.map_or_else(String::new, |[x, y, z]| {
            format!("  force {x:.1} {y:.1} {z:.1} N")
        });
        // writing to a String cannot fail
        let _ = writeln!(
            text,
            "{id:>4}  {name:<16} {state:<15} {joints}{force}{fault}"
        );
    }
    text
}

fn json(nodes: &BTreeMap<u8, Heard>) -> String {
    let mut text = String::new();
    for (id, heard) in nodes {
        let Some(feedback) = &heard.feedback else {
            continue;
        };
        let value = serde_json::json!({
            "node": id,
            "robot": kind_of(heard).map(|arm| arm.kind().name()),
            "state": format!("{:?}", feedback.state),
            "joints": joints(heard),
            "force_n": feedback.force_n,
            "fault": feedback.fault.map(|f| f.cause.code()),
            "age_ms": bus::now().since(heard.at).0 / 1000,
        });
        let _ = writeln!(text, "{value}");
    }
    text
}

/// Stop everyone on a bus; anyone may.
pub(crate) fn stop(place: &Place, kind: StopKind) -> Result<u8, Error> {
    let (mut bus, _) = open_bus(place)?;
    // A number of its own: another MP may be talking as number 1.
    let me = NodeId::new(2).unwrap_or(NodeId::MP);
    let mut link = Endpoint::<64>::new(me, Role::Observer, Mtu::Classic);
    let mut nodes = BTreeMap::<u8, Heard>::new();
    for _ in 0..STOPS {
        let mut frames = Vec::new();
        link.send_stop_all(&StopAll { kind }, &mut |frame| frames.push(frame))
            .map_err(|e| Error::Internal(format!("{e:?}")))?;
        for frame in frames {
            bus.send(&frame).map_err(|e| crate::world::bus_error(&e))?;
        }
        listen(&mut *bus, &mut link, &mut nodes, bus::now() + STOP_GAP)?;
    }
    nodes.clear();
    let deadline = bus::now() + STOP_PATIENCE;
    let moving = |heard: &Heard| {
        use protocol::message::NodeState::{Moving, Stopping, Synchronising};
        heard
            .feedback
            .as_ref()
            .is_none_or(|f| matches!(f.state, Moving | Stopping | Synchronising))
    };
    loop {
        listen(&mut *bus, &mut link, &mut nodes, bus::now() + REFRESH)?;
        let heard = nodes.values().filter(|h| h.feedback.is_some()).count();
        if heard > 0 && !nodes.values().filter(|h| h.feedback.is_some()).any(moving) {
            let _ = writeln!(std::io::stdout(), "{heard} nodes stand still");
            return Ok(exit::OK);
        }
        if bus::now() > deadline {
            return Err(Error::Bus {
                bus: place.to_string(),
                reason: format!(
                    "stop was sent, but {} (expected nodes at rest)",
                    if heard == 0 {
                        "no node is heard".to_owned()
                    } else {
                        format!("{heard} nodes are heard and some still move")
                    }
                ),
            });
        }
    }
}
