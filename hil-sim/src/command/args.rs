//! The command line.

use super::touch::{ForceBus, Surface};
use bus::spec::{Place, SpecError};
use clap::Parser;
use firmware::Station;
use firmware::config::ForceAddress;
use firmware::process::drive_buses;
use hil_sim::drive::quirk::{Quirk, Quirks};
use hil_sim::fault::{Breakable, FaultSpec, Schedule};
use hil_sim::plant::contact::Plate;
use process::End;
use protocol::message::ServoLaw;
use protocol::transfer::Mtu;
use robots::{RobotKind, TrackRule};
use std::ffi::OsString;

/// For `--help`.
const EXIT_CODES: &str = "\
Exit codes:
   0  done: ended by Ctrl-C or SIGTERM
  64  wrong use of the command line (unknown robot, bad bus, bad value)
  69  the bus cannot be opened: port taken, no interface, no CAN in this system
  70  an error of this program
  74  the bus failed on the way
  77  --priority: the system does not let this user";

/// Drives and mechanics of robots, in real time.
///
/// On a hub this process is the hub: a socketcand server on this machine with the channel `mp` for
/// MP and nodes, and `ROBOT.0`, `ROBOT.1` for the drive buses of each robot. On a CAN interface
/// everything is one wire. Late? Then it says so, on stderr and in the summary. Ctrl-C or SIGTERM
/// ends it.
#[derive(Debug, Parser)]
#[command(name = "mrroc-hil-sim", version, after_help = EXIT_CODES)]
struct Raw {
    /// The robots: irp6-track, irp6-postument, polycrank, irp6-arm, conveyor, irp6-track-gripper,
    /// irp6-postument-gripper
    #[arg(required = true, value_name = "ROBOT")]
    robots: Vec<String>,
    /// Where: hub, hub:PORT (port 0: any free one, told at the start), can:INTERFACE,
    /// slcan:DEVICE or slcan:HOST:PORT (one robot: it is one connection)
    #[arg(long, value_parser = place)]
    bus: Place,
    /// The effectors' numbers, in the order of the robots [default: by the robot, irp6-track 1,
    /// irp6-postument 2, …]
    #[arg(long, value_name = "J,…", value_delimiter = ',')]
    effector: Vec<u8>,
    /// Seed of everything random: where the motors stand at the start, switches that bounce
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// What the drives do otherwise than the book: slow-boot, slow-answers, homing-never-reached,
    /// no-interpolation-period, tight-sync, homes-itself, emergency-before-boot-up, short-pdo,
    /// flickering-fault, forgets-node, slow-layer, no-verify-configuration
    #[arg(long, value_name = "QUIRK,…", value_delimiter = ',', value_parser = quirk)]
    quirk: Vec<Quirk>,
    /// What breaks when: ROBOT/AXIS:FAULT@SECONDS with silent, trip, frozen, jumping, reversed, drifting, garbage (its
    /// encoder), switch-on, switch-off, no-index, blank (its node id is lost); ROBOT/force:FAULT@SECONDS with silent, saturated, over-force, failed,
    /// frozen, repeating, torn; ROBOT.BUS:FAULT@SECONDS with stuck-dominant, short, cut:TAP (behind
    /// the node, 0, or the TAP-th drive), wrecked:TAP. `none` mends. Axes from 1, buses from 0, seconds from the
    /// start; may be given several times
    #[arg(long, value_name = "SPEC")]
    fault: Vec<FaultSpec>,
    /// A force sensor in the wrist of a robot, on its drive bus BUS (0 or 1, on a CAN interface 0): irp6-track or
    /// irp6-postument; --force-bus of its mrroc-node says the same
    #[arg(long, value_name = "ROBOT.BUS")]
    force_bus: Vec<ForceBus>,
    /// A square plate that a tool can touch, ROBOT:X,Y,Z:NX,NY,NZ:EDGE:STIFFNESS: the middle of its face, m in the base
    /// frame, the normal out of it, the edge, m, and N/m. May be given several times
    #[arg(long, value_name = "SPEC")]
    surface: Vec<Surface>,
    /// Real-time scheduling (first in, first out) with this priority, 1 to 99, and memory that stays in RAM:
    /// on Linux, for those who may
    #[arg(long, value_name = "P", value_parser = clap::value_parser!(u8).range(1..=99))]
    priority: Option<u8>,
    /// JSON lines on stdout: `ready`, `late` as it happens, then the summary
    #[arg(long)]
    json: bool,
}

/// A robot that is to be simulated.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Simulated {
    /// What it is.
    pub(crate) kind: RobotKind,
    /// Its number as an effector.
    pub(crate) effector: u8,
    /// Its force sensor.
    pub(crate) force: Option<ForceAddress>,
    /// What its tool can touch.
    pub(crate) plates: Vec<Plate>,
}

impl Simulated {
    /// Its node, as far as drives and sensors are concerned.
    pub(crate) const fn station(&self, one_wire: bool) -> Station {
        Station {
            effector: self.effector,
            unique_id: 0,
            mtu: Mtu::Classic,
            law: ServoLaw::DrivePosition,
            velocity_factor: 1.0,
            one_wire,
            track: TrackRule::Keep,
        }
    }

    /// How many drive buses it has on a hub.
    pub(crate) fn buses(&self) -> u8 {
        let drives = drive_buses(self.kind);
        let sensor = self.force.map(|force| force.bus);
        let last = drives.iter().copied().chain(sensor).max();
        last.map_or(0, |last| last + 1)
    }
}

/// What is to be run.
#[derive(Debug)]
pub(crate) struct Args {
    /// The robots.
    pub(crate) robots: Vec<Simulated>,
    /// The bus; a hub is our own, and port 0 any free one.
    pub(crate) place: Place,
    /// Seed of everything random.
    pub(crate) seed: u64,
    /// What the drives do otherwise than the book.
    pub(crate) quirks: Quirks,
    /// What breaks when; robots are numbered as listed.
    pub(crate) faults: Schedule,
    /// Of real-time scheduling.
    pub(crate) priority: Option<u8>,
    /// JSON lines on stdout.
    pub(crate) json: bool,
}

/// What the command line asks for.
///
/// # Errors
/// `--help` and `--version` (code 0), or what is wrong, in one line.
pub(crate) fn parse(args: impl IntoIterator<Item = OsString>) -> Result<Args, End> {
    let raw = Raw::try_parse_from(args)?;
    let place = raw.bus;
    if !raw.effector.is_empty() && raw.effector.len() != raw.robots.len() {
        return Err(End::usage(format!(
            "--effector: expected one number for each of {} robots, got {}",
            raw.robots.len(),
            raw.effector.len()
        )));
    }
    let mut robots: Vec<Simulated> = Vec::new();
    let mut numbers = raw.effector.iter().copied();
    for name in &raw.robots {
        let kind = RobotKind::from_name(name).map_err(|error| End::usage(error.to_string()))?;
        let number = numbers.next().unwrap_or(kind.effector());
        if number == 0 {
            return Err(End::usage("--effector: expected numbers from 1 on, got 0"));
        }
        let hub = matches!(place, Place::Hub { .. });
        if hub && robots.iter().any(|other| other.kind == kind) {
            return Err(End::usage(format!(
                "{kind}: given twice (expected each robot once on a hub: its channels are named \
                 after it)"
            )));
        }
        if let Some(Simulated { kind: other, .. }) = robots.iter().find(|r| r.effector == number) {
            return Err(End::usage(format!(
                "--effector: {other} and {kind} are both effector {number} (expected different \
                 numbers)"
            )));
        }
        robots.push(Simulated {
            kind,
            effector: number,
            force: None,
            plates: Vec::new(),
        });
    }
    equip(&mut robots, &raw.force_bus, &raw.surface, &place)?;
    let breakable: Vec<Breakable<'_>> = robots
        .iter()
        .map(|robot| Breakable {
            name: robot.kind.name(),
            axes: robot.kind.axes(),
            buses: robot.buses(),
            force: robot.force.is_some(),
        })
        .collect();
    let faults = Schedule::new(&raw.fault, &breakable)
        .map_err(|misplaced| End::usage(format!("--fault {misplaced}")))?;
    Ok(Args {
        faults,
        robots,
        place,
        seed: raw.seed,
        quirks: raw.quirk.into_iter().fold(Quirks::default(), Quirks::with),
        priority: raw.priority,
        json: raw.json,
    })
}

/// Gives the robots their force sensors, and what their tools can touch.
fn equip(
    robots: &mut [Simulated],
    sensors: &[ForceBus],
    surfaces: &[Surface],
    place: &Place,
) -> Result<(), End> {
    let one_wire = !matches!(place, Place::Hub { .. });
    for sensor in sensors {
        let robot = named(robots, &sensor.robot, "--force-bus")?;
        let wrong = |what: String| {
            let given = format!("{}.{}", sensor.robot, sensor.bus);
            End::usage(format!("--force-bus {given}: {what}"))
        };
        if robot.force.is_some() {
            return Err(wrong("expected one sensor a robot, got another".into()));
        }
        let address = robot.station(one_wire).force(robot.kind, sensor.bus);
        robot.force = Some(address.map_err(|error| wrong(error.to_string()))?);
    }
    for surface in surfaces {
        let robot = named(robots, &surface.robot, "--surface")?;
        robot.plates.push(surface.plate);
    }
    Ok(())
}

/// The robot of a name that is there once.
fn named<'a>(
    robots: &'a mut [Simulated],
    name: &str,
    option: &str,
) -> Result<&'a mut Simulated, End> {
    let known: Vec<&str> = robots.iter().map(|robot| robot.kind.name()).collect();
    let expected = format!(
        "{option} {name}: expected {}, given once",
        known.join(" or ")
    );
    let mut of_name = robots.iter_mut().filter(|robot| robot.kind.name() == name);
    match (of_name.next(), of_name.next()) {
        (Some(robot), None) => Ok(robot),
        (None | Some(_), _) => Err(End::usage(expected)),
    }
}

/// A quirk by its name.
fn quirk(text: &str) -> Result<Quirk, String> {
    Quirk::from_name(text).ok_or_else(|| {
        let names = Quirk::ALL.map(Quirk::name);
        format!("expected {}", names.join(" or "))
    })
}

/// Where the hub is to be, or which interface: as everywhere, and the hub's port may be 0.
fn place(text: &str) -> Result<Place, SpecError> {
    match text {
        "hub:0" => Ok(Place::Hub {
            host: "127.0.0.1".into(),
            port: 0,
        }),
        _ => text.parse(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use process::exit;

    fn of(text: &str) -> Result<Args, End> {
        parse(text.split(' ').map(OsString::from))
    }

    #[test]
    fn effectors_are_the_nodes_defaults_or_as_listed() {
        let (track, postument) = (RobotKind::Irp6Track, RobotKind::Irp6Postument);
        let who = |args: &Args| -> Vec<(RobotKind, u8)> {
            let robots = args.robots.iter();
            robots.map(|robot| (robot.kind, robot.effector)).collect()
        };
        let args = of("mrroc-hil-sim irp6-postument irp6-track --bus hub:0").unwrap();
        assert_eq!(who(&args), [(postument, 2), (track, 1)]);
        assert_eq!(
            args.place,
            Place::Hub {
                host: "127.0.0.1".into(),
                port: 0
            }
        );
        let args = of("mrroc-hil-sim irp6-track irp6-track --bus can:can0 --effector 3,4").unwrap();
        assert_eq!(who(&args), [(track, 3), (track, 4)]);
    }

    #[test]
    fn robots_have_the_sensors_and_surfaces_that_are_theirs() {
        let text = "mrroc-hil-sim irp6-track irp6-postument --bus hub --force-bus irp6-postument.1 \
                    --surface irp6-postument:1,0,0.2:0,0,1:0.1:1e4 --surface irp6-postument:0,1,0:0,1,0:0.1:1e4";
        let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
        let args = of(&text).unwrap();
        let [track, postument] = args.robots.as_slice() else {
            panic!("{args:?}");
        };
        assert!(track.force.is_none() && track.plates.is_empty());
        assert_eq!(
            (track.buses(), postument.buses()),
            (2, 2),
            "a bus of its own"
        );
        let force = postument.force.unwrap();
        assert_eq!((force.bus, force.number.force_cob()), (1, 0x680));
        assert_eq!(postument.plates.len(), 2);
        // on one wire it is that of its effector
        let text = "mrroc-hil-sim irp6-postument --bus can:can0 --force-bus irp6-postument.0";
        let force = of(text).unwrap().robots[0].force.unwrap();
        assert_eq!((force.bus, force.number.force_cob()), (0, 0x682));
    }

    #[test]
    fn every_mistake_is_one_line_with_code_64() {
        for text in [
            "mrroc-hil-sim",
            "mrroc-hil-sim --bus hub",
            "mrroc-hil-sim irp6-track",
            "mrroc-hil-sim irp7 --bus hub",
            "mrroc-hil-sim irp6-track --bus hub:x",
            "mrroc-hil-sim irp6-track --bus hub:far.example:29536",
            "mrroc-hil-sim irp6-track --bus virtual",
            "mrroc-hil-sim irp6-track irp6-track --bus hub",
            "mrroc-hil-sim irp6-track irp6-track --bus can:can0",
            "mrroc-hil-sim irp6-track irp6-postument --bus hub --effector 1",
            "mrroc-hil-sim irp6-track irp6-postument --bus hub --effector 5,5",
            "mrroc-hil-sim irp6-track --bus hub --effector 0",
            "mrroc-hil-sim irp6-track --bus hub --seed x",
            "mrroc-hil-sim irp6-track --bus hub --quirk lazy",
            "mrroc-hil-sim irp6-track --bus hub --fault irp6-track/1:frozen",
            "mrroc-hil-sim irp6-track --bus hub --fault irp6-track/1:melted@2",
            "mrroc-hil-sim irp6-track --bus hub --fault irp6-track/1:frozen@soon",
            "mrroc-hil-sim irp6-track --bus hub --fault irp6-track/8:frozen@2",
            "mrroc-hil-sim irp6-track --bus hub --fault irp6-track.2:short@2",
            "mrroc-hil-sim irp6-track --bus hub --fault irp6-track/force:frozen@2",
            "mrroc-hil-sim irp6-track --bus hub --fault polycrank/1:frozen@2",
            "mrroc-hil-sim irp6-track irp6-track --bus can:c --effector 3,4 --fault irp6-track/1:frozen@2",
            "mrroc-hil-sim irp6-track --bus hub --force-bus irp6-track",
            "mrroc-hil-sim irp6-track --bus hub --force-bus irp6-track.2",
            "mrroc-hil-sim irp6-track --bus hub --force-bus irp6-postument.1",
            "mrroc-hil-sim irp6-track --bus hub --force-bus irp6-track.1 --force-bus irp6-track.0",
            "mrroc-hil-sim irp6-track --bus can:can0 --force-bus irp6-track.1",
            "mrroc-hil-sim irp6-postument --bus hub --force-bus irp6-postument.0",
            "mrroc-hil-sim conveyor --bus hub --force-bus conveyor.0",
            "mrroc-hil-sim irp6-track irp6-track --bus can:c --effector 3,4 --force-bus irp6-track.0",
            "mrroc-hil-sim irp6-track --bus hub --surface irp6-track:1,2,3",
            "mrroc-hil-sim irp6-track --bus hub --surface conveyor:1,0,0.2:0,0,1:0.1:1e4",
        ] {
            let end = of(text).unwrap_err();
            assert_eq!(end.code, exit::USAGE, "{text}");
            assert!(
                !end.text.contains('\n') && end.text.len() > 20,
                "{text}: {}",
                end.text
            );
        }
    }

    #[test]
    fn help_and_version_are_no_errors() {
        let help = of("mrroc-hil-sim --help").unwrap_err();
        assert_eq!(help.code, 0);
        for code in [exit::USAGE, exit::UNAVAILABLE, exit::INTERNAL, exit::IO] {
            assert!(
                help.text.contains(&format!("  {code}  ")),
                "{code} is not in --help"
            );
        }
        let listed = help.text.split_whitespace().collect::<Vec<_>>().join(" ");
        for (name, _) in hil_sim::drive::DriveFault::NAMED {
            assert!(listed.contains(name), "{name} is not in --help");
        }
        for fault in hil_sim::plant::force_sensor::ForceFault::ALL {
            assert!(listed.contains(fault.name()), "{fault:?} is not in --help");
        }
        for fault in ["stuck-dominant", "short", "cut:TAP", "wrecked:TAP"] {
            assert!(listed.contains(fault), "{fault} is not in --help");
        }
        assert_eq!(of("mrroc-hil-sim --version").unwrap_err().code, 0);
    }
}
