//! `mrroc dbc`: a database (DBC) of the frames that look the same in every cycle: process data of every
//! axis, SYNC, NMT, heartbeats, emergencies, force sensors; towards the MP the heartbeats of Cyphal.
//!
//! Identifiers are those of buses of their own ([`firmware::Station`]): drive k of a robot is axis k.

use std::fmt::Write as _;
use std::io::Write;
use std::path::PathBuf;

use clap::Args;
use host::input::Files;
use host::task::{Cell, RobotSpec};
use process::{End, exit};
use protocol::canopen::node::{Function, NodeId as DriveId};
use protocol::canopen::objects::{self, TABLE};
use protocol::canopen::pdo::Entry;
use protocol::canopen::{axis, nmt, sync};
use protocol::force_torque::{FORCE_UNIT_N, MOMENT_UNIT_NM};
use protocol::id::{CanId, NodeId, Port, Priority, Subject};

use crate::eds::written;
use crate::world::force_address;

/// The CANopen identifier of a robot's own node on its drive buses.
const MASTER: u8 = 127;

/// A database of the frames of one bus
#[derive(Debug, Args)]
pub(crate) struct Dbc {
    /// The cell, or a task and its cell (.toml)
    cell: PathBuf,
    /// The bus; none is needed where there is one for drives only
    #[arg(long, value_name = "NAME")]
    bus: Option<String>,
    /// Write a file instead
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
}

impl Dbc {
    /// Writes the database.
    ///
    /// # Errors
    /// The cell cannot be read, has no such bus, or the database cannot be written.
    pub(crate) fn run(self, out: &mut dyn Write) -> Result<(), End> {
        let cell =
            Cell::load_any(&self.cell, &Files::on_disk()).map_err(host::error::Error::from)?;
        let text = database(&cell, self.bus.as_deref())?;
        written(self.output, out, &text)
    }
}

fn database(cell: &Cell, name: Option<&str>) -> Result<String, End> {
    let carries_drives = |bus: usize| {
        cell.robots
            .iter()
            .any(|robot| robot.drives.iter().any(|group| group.bus == bus))
    };
    let names: Vec<&str> = cell.buses.iter().map(|bus| bus.name.as_str()).collect();
    let bus = if let Some(name) = name {
        names.iter().position(|other| *other == name)
    } else {
        let mut of_drives = (0..names.len()).filter(|bus| carries_drives(*bus));
        of_drives.next().filter(|_| of_drives.next().is_none())
    };
    let bus = bus.ok_or_else(|| {
        let got = name.unwrap_or("no --bus");
        End::usage(format!("expected --bus {}, got {got}", names.join(" or ")))
    })?;
    let mut dbc = Database::default();
    for (number, robot) in (1_u8..).zip(&cell.robots) {
        let axes = robot.drives.iter().filter(|group| group.bus == bus);
        let axes: Vec<usize> = axes.flat_map(|group| group.axes.iter().copied()).collect();
        if !axes.is_empty() {
            dbc.drives(robot, &axes)?;
        }
        if let Some(address) = force_address(robot)
            && robot.force_bus == Some(bus)
        {
            dbc.force_sensor(&robot.name, address.number.force_cob());
        }
        if robot.mp_bus == bus {
            let node = NodeId::effector(number);
            dbc.cyphal_heartbeat(&robot.name, node.ok_or_else(|| too_many(&robot.name))?);
        }
    }
    if cell.robots.iter().any(|robot| robot.mp_bus == bus) {
        dbc.cyphal_heartbeat("mp", NodeId::MP);
    }
    Ok(dbc.text())
}

fn too_many(robot: &str) -> End {
    End::new(exit::DATA, format!("{robot}: no number is left for it"))
}

/// A signal within a message.
struct Signal {
    name: String,
    start: usize,
    bits: usize,
    signed: bool,
    /// One of what is on the wire, in the unit.
    factor: f64,
    /// Decimals of a value.
    decimals: usize,
    unit: &'static str,
}

/// The parts of a database, as they grow.
#[derive(Default)]
struct Database {
    nodes: Vec<String>,
    messages: String,
    values: String,
}

impl Database {
    /// Everything of a robot's drives on one bus.
    fn drives(&mut self, robot: &RobotSpec, axes: &[usize]) -> Result<(), End> {
        let robot = word(&robot.name);
        let node = format!("node_{robot}");
        self.nodes.push(node.clone());
        let byte = |name: &str, at: usize| unsigned(name, 8 * at, 8);
        self.message(
            u32::from(nmt::COB),
            &format!("NMT_{robot}"),
            2,
            &node,
            &[byte("Command", 0), byte("Node", 1)],
        );
        let commands = "1 \"Start\" 2 \"Stop\" 128 \"EnterPreOperational\" 129 \"ResetNode\" \
                        130 \"ResetCommunication\"";
        self.value_table(u32::from(nmt::COB), "Command", commands);
        let cob = u32::from(sync::DEFAULT_COB);
        self.message(cob, &format!("SYNC_{robot}"), 0, &node, &[]);
        let master = DriveId::new(MASTER).ok_or_else(|| too_many(&robot))?;
        self.heartbeat(master, &format!("HB_{robot}"), &node);
        for axis in axes {
            let number = axis + 1;
            let id = u8::try_from(number).ok().and_then(DriveId::new);
            let id = id.ok_or_else(|| too_many(&robot))?;
            let drive = format!("{robot}_{number}");
            self.nodes.push(drive.clone());
            let cob = |function| u32::from(id.cob(function));
            for (name, function, entries) in [
                ("RPDO1", Function::Rpdo1, &axis::RPDO1_CSP[..]),
                ("RPDO2", Function::Rpdo2, &axis::RPDO2_CST),
            ] {
                let (len, signals) = signals(entries);
                self.message(
                    cob(function),
                    &format!("{name}_{drive}"),
                    len,
                    &node,
                    &signals,
                );
            }
            for (name, function, entries) in [
                ("TPDO1", Function::Tpdo1, &axis::TPDO1[..]),
                ("TPDO2", Function::Tpdo2, &axis::TPDO2),
            ] {
                let (len, signals) = signals(entries);
                self.message(
                    cob(function),
                    &format!("{name}_{drive}"),
                    len,
                    &drive,
                    &signals,
                );
            }
            let emergency = [
                unsigned("ErrorCode", 0, 16),
                unsigned("ErrorRegister", 16, 8),
                unsigned("Detail", 24, 40),
            ];
            let emcy = format!("EMCY_{drive}");
            self.message(cob(Function::Emergency), &emcy, 8, &drive, &emergency);
            self.heartbeat(id, &format!("HB_{drive}"), &drive);
        }
        Ok(())
    }

    /// The two frames of a force sensor; that with the moment is the one after that with the force.
    fn force_sensor(&mut self, robot: &str, cob: u16) {
        let robot = word(robot);
        let sender = format!("force_{robot}");
        self.nodes.push(sender.clone());
        for (cob, name, factor, decimals, unit) in [
            (cob, "Force", FORCE_UNIT_N, 2, "N"),
            (cob + 1, "Moment", MOMENT_UNIT_NM, 3, "Nm"),
        ] {
            let along = |axis: &str, start: usize| Signal {
                signed: true,
                factor,
                decimals,
                unit,
                ..unsigned(&format!("{name}{axis}"), start, 16)
            };
            let signals = [
                along("X", 0),
                along("Y", 16),
                along("Z", 32),
                unsigned("SampleNumber", 48, 8),
                unsigned("OverForce", 56, 1),
                unsigned("Saturated", 57, 1),
                unsigned("Failed", 58, 1),
            ];
            self.message(
                u32::from(cob),
                &format!("{name}_{robot}"),
                8,
                &sender,
                &signals,
            );
        }
    }

    fn heartbeat(&mut self, id: DriveId, name: &str, sender: &str) {
        let cob = u32::from(id.cob(Function::Heartbeat));
        self.message(cob, name, 1, sender, &[unsigned("State", 0, 8)]);
        let states = "0 \"BootUp\" 4 \"Stopped\" 5 \"Operational\" 127 \"PreOperational\"";
        self.value_table(cob, "State", states);
    }

    /// `uavcan.node.Heartbeat.1.0` and the tail byte.
    fn cyphal_heartbeat(&mut self, name: &str, node: NodeId) {
        let name = word(name);
        let id = CanId {
            priority: Priority::Low,
            port: Port::Message(Subject::HEARTBEAT),
            source: node,
        };
        let sender = format!("cyphal_{name}");
        self.nodes.push(sender.clone());
        let signals = [
            Signal {
                unit: "s",
                ..unsigned("Uptime", 0, 32)
            },
            unsigned("Health", 32, 8),
            unsigned("Mode", 40, 8),
            unsigned("VendorStatus", 48, 8),
            unsigned("Tail", 56, 8),
        ];
        // bit 31: 29-bit identifier
        let id = id.bits() | 1 << 31;
        self.message(id, &format!("Heartbeat_{name}"), 8, &sender, &signals);
    }

    fn message(&mut self, id: u32, name: &str, len: usize, sender: &str, signals: &[Signal]) {
        // a String takes everything
        let _ = writeln!(self.messages, "BO_ {id} {name}: {len} {sender}");
        for s in signals {
            let (sign, low, high) = if s.signed {
                let half = 1_i128 << (s.bits - 1);
                ('-', -half, half - 1)
            } else {
                ('+', 0, (1_i128 << s.bits) - 1)
            };
            #[expect(
                clippy::cast_precision_loss,
                reason = "only whole ones are longer than 16 bits"
            )]
            let scaled = |raw: i128| match s.decimals {
                0 => raw.to_string(),
                decimals => format!("{:.decimals$}", raw as f64 * s.factor),
            };
            let _ = writeln!(
                self.messages,
                " SG_ {} : {}|{}@1{sign} ({},0) [{}|{}] \"{}\" Vector__XXX",
                s.name,
                s.start,
                s.bits,
                s.factor,
                scaled(low),
                scaled(high),
                s.unit
            );
        }
        self.messages.push('\n');
    }

    fn value_table(&mut self, id: u32, signal: &str, values: &str) {
        let _ = writeln!(self.values, "VAL_ {id} {signal} {values} ;");
    }

    fn text(&self) -> String {
        format!(
            "VERSION \"\"\n\nNS_ :\n\nBS_:\n\nBU_: {}\n\n{}{}",
            self.nodes.join(" "),
            self.messages,
            self.values
        )
    }
}

fn unsigned(name: &str, start: usize, bits: usize) -> Signal {
    Signal {
        name: name.into(),
        start,
        bits,
        signed: false,
        factor: 1.0,
        decimals: 0,
        unit: "",
    }
}

/// Length in bytes and signals of a mapping, named after its objects.
fn signals(entries: &[Entry]) -> (usize, Vec<Signal>) {
    let mut start = 0;
    let signals = entries.iter().map(|entry| {
        let bits = usize::from(entry.bits());
        let object = objects::find(entry.address()).and_then(|place| TABLE.get(place));
        let signal = Signal {
            signed: object.is_some_and(|object| object.data_type.is_signed()),
            ..unsigned(object.map_or("Gap", |object| object.name), start, bits)
        };
        start += bits;
        Signal {
            name: camel(&signal.name),
            ..signal
        }
    });
    let signals: Vec<Signal> = signals.collect();
    (start.div_ceil(8), signals)
}

/// `Target position` as `TargetPosition`.
fn camel(name: &str) -> String {
    let words = name.split(|c: char| !c.is_ascii_alphanumeric());
    let capital = |word: &str| {
        let mut chars = word.chars();
        let first = chars.next().map(|c| c.to_ascii_uppercase());
        first.into_iter().chain(chars).collect::<String>()
    };
    words.map(capital).collect()
}

/// A name as a C identifier.
fn word(name: &str) -> String {
    let good = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    name.chars().map(good).collect()
}

#[cfg(test)]
mod test {
    use super::*;
    use robots::RobotKind;

    fn cell() -> Cell {
        Cell::of(&[RobotKind::Irp6Postument])
    }

    #[test]
    fn golden_messages() {
        let text = database(&cell(), None).unwrap();
        for part in [
            "BO_ 128 SYNC_irp6_postument: 0 node_irp6_postument\n",
            "BO_ 386 TPDO1_irp6_postument_2: 8 irp6_postument_2\n \
             SG_ Statusword : 0|16@1+ (1,0) [0|65535] \"\" Vector__XXX\n \
             SG_ PositionActualValue : 16|32@1- (1,0) [-2147483648|2147483647] \"\" Vector__XXX\n \
             SG_ TorqueActualValue : 48|16@1- (1,0) [-32768|32767] \"\" Vector__XXX\n",
            "BO_ 1798 HB_irp6_postument_6: 1 irp6_postument_6\n",
            // the node's own heartbeat: 700 + 7F
            "VAL_ 1919 State 0 \"BootUp\"",
        ] {
            assert!(text.contains(part), "{part}");
        }
        assert!(!text.contains("_7:"));
    }

    #[test]
    fn a_force_sensor_is_on_its_own_bus_alone() {
        let cell = Cell::parse(
            r#"
            bus = [{ name = "wrist", kind = "classic" }, { name = "drives", kind = "classic" }]
            [[robot]]
            kind = "irp6-postument"
            drives = [{ bus = "drives", axes = [1, 2, 3, 4, 5, 6] }]
            force_bus = "wrist"
        "#,
        )
        .unwrap();
        let text = database(&cell, Some("wrist")).unwrap();
        for part in [
            "BU_: force_irp6_postument\n",
            "BO_ 1664 Force_irp6_postument: 8 force_irp6_postument\n \
             SG_ ForceX : 0|16@1- (0.01,0) [-327.68|327.67] \"N\" Vector__XXX\n",
            "BO_ 1665 Moment_irp6_postument: 8 force_irp6_postument\n",
            " SG_ MomentZ : 32|16@1- (0.001,0) [-32.768|32.767] \"Nm\" Vector__XXX\n \
             SG_ SampleNumber : 48|8@1+ (1,0) [0|255] \"\" Vector__XXX\n \
             SG_ OverForce : 56|1@1+ (1,0) [0|1] \"\" Vector__XXX\n",
        ] {
            assert!(text.contains(part), "{part} in {text}");
        }
        assert_eq!(
            text.lines().filter(|line| line.starts_with("BO_")).count(),
            2
        );
        assert!(!database(&cell, Some("drives")).unwrap().contains("Force"));
    }

    #[test]
    fn names_are_no_longer_than_the_format_allows() {
        for kind in RobotKind::ALL {
            let cell = Cell::of(&[kind]);
            for bus in &cell.buses {
                let text = database(&cell, Some(&bus.name)).unwrap();
                for line in text.lines().filter(|line| line.starts_with("BO_")) {
                    let name = line.split([' ', ':']).nth(2).unwrap();
                    assert!(name.len() <= 32, "{name}");
                }
            }
        }
    }

    #[test]
    fn the_mp_bus_has_heartbeats_with_long_identifiers() {
        let text = database(&cell(), Some("mp")).unwrap();
        let lines: Vec<&str> = text
            .lines()
            .filter(|line| line.starts_with("BO_"))
            .collect();
        // priority 5, subject 7509, node 1, and bit 31
        let mp = (5_u32 << 26 | 0b11 << 21 | 7509 << 8 | 1) | 1 << 31;
        assert_eq!(lines[1], format!("BO_ {mp} Heartbeat_mp: 8 cyphal_mp"));
        assert_eq!(lines.len(), 2);
    }

    #[test]
    fn a_bus_must_be_named_where_there_are_several() {
        let two = Cell::of(&[RobotKind::Irp6Track]);
        for (cell, bus) in [(&two, None), (&cell(), Some("x"))] {
            let end = database(cell, bus).unwrap_err();
            assert!(
                end.code == exit::USAGE && end.text.contains("--bus mp or"),
                "{}",
                end.text
            );
        }
    }
}
