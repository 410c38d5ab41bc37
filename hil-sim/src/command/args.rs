//! The command line.

use bus::spec::{Place, SpecError};
use clap::Parser;
use firmware::process::drive_buses;
use hil_sim::drive::quirk::{Quirk, Quirks};
use hil_sim::fault::{Breakable, FaultSpec, Schedule};
use process::End;
use robots::RobotKind;
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
    /// encoder), switch-on, switch-off, no-index, blank (its node id is lost); ROBOT.BUS:FAULT@SECONDS with stuck-dominant, short, cut:TAP (behind
    /// the node, 0, or the TAP-th drive), wrecked:TAP. `none` mends. Axes from 1, buses from 0, seconds from the
    /// start; may be given several times
    #[arg(long, value_name = "SPEC")]
    fault: Vec<FaultSpec>,
    /// Real-time scheduling (first in, first out) with this priority, 1 to 99, and memory that stays in RAM:
    /// on Linux, for those who may
    #[arg(long, value_name = "P", value_parser = clap::value_parser!(u8).range(1..=99))]
    priority: Option<u8>,
    /// JSON lines on stdout: `ready`, `late` as it happens, then the summary
    #[arg(long)]
    json: bool,
}

/// What is to be run.
#[derive(Debug)]
pub(crate) struct Args {
    /// The robots and their effector numbers.
    pub(crate) robots: Vec<(RobotKind, u8)>,
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
    let mut robots: Vec<(RobotKind, u8)> = Vec::new();
    let mut numbers = raw.effector.iter().copied();
    for name in &raw.robots {
        let kind = RobotKind::from_name(name).map_err(|error| End::usage(error.to_string()))?;
        let number = numbers.next().unwrap_or(kind.effector());
        if number == 0 {
            return Err(End::usage("--effector: expected numbers from 1 on, got 0"));
        }
        let hub = matches!(place, Place::Hub { .. });
        if hub && robots.iter().any(|(other, _)| *other == kind) {
            return Err(End::usage(format!(
                "{kind}: given twice (expected each robot once on a hub: its channels are named \
                 after it)"
            )));
        }
        if let Some((other, _)) = robots.iter().find(|(_, taken)| *taken == number) {
            return Err(End::usage(format!(
                "--effector: {other} and {kind} are both effector {number} (expected different \
                 numbers)"
            )));
        }
        robots.push((kind, number));
    }
    let breakable: Vec<Breakable<'_>> = robots
        .iter()
        .map(|(kind, _)| Breakable {
            name: kind.name(),
            axes: kind.axes(),
            buses: buses(*kind),
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

/// How many drive buses a robot has on a hub.
pub(crate) fn buses(kind: RobotKind) -> u8 {
    drive_buses(kind).iter().max().map_or(0, |last| last + 1)
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
        let args = of("mrroc-hil-sim irp6-postument irp6-track --bus hub:0").unwrap();
        assert_eq!(args.robots, [(postument, 2), (track, 1)]);
        assert_eq!(
            args.place,
            Place::Hub {
                host: "127.0.0.1".into(),
                port: 0
            }
        );
        let args = of("mrroc-hil-sim irp6-track irp6-track --bus can:can0 --effector 3,4").unwrap();
        assert_eq!(args.robots, [(track, 3), (track, 4)]);
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
            "mrroc-hil-sim irp6-track --bus hub --fault polycrank/1:frozen@2",
            "mrroc-hil-sim irp6-track irp6-track --bus can:c --effector 3,4 --fault irp6-track/1:frozen@2",
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
        for fault in ["stuck-dominant", "short", "cut:TAP", "wrecked:TAP"] {
            assert!(listed.contains(fault), "{fault} is not in --help");
        }
        assert_eq!(of("mrroc-hil-sim --version").unwrap_err().code, 0);
    }
}
