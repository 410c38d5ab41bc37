//! The command line.

use bus::spec::Place;
use clap::{Parser, ValueEnum};
use process::End;
use protocol::canopen::lss::Identity;
use protocol::id::NodeId;
use protocol::message::ServoLaw;
use robots::{RobotKind, TrackRule};
use std::ffi::OsString;
use std::path::PathBuf;

/// For `--help`.
const EXIT_CODES: &str = "\
Exit codes:
   0  done: ended by Ctrl-C or SIGTERM, at rest, torque off
  64  wrong use of the command line (unknown robot, bad bus, bad value)
  65  a file of the state is damaged
  66  a file of the state cannot be read
  69  the bus cannot be opened: no hub, no interface, no CAN in this system
  70  an error of this program
  73  a file of the state cannot be written
  74  the bus failed on the way
  77  the system refuses access to the state, or real-time priority";

/// The controller node of one robot, in real time.
///
/// Runs the node (ECP and EDP) as a process: MP on one side, CANopen drives on the other. On a hub
/// the MP's bus is the channel `mp`, the drive buses are `ROBOT.0`, `ROBOT.1`; on a CAN interface
/// everything is one wire. State changes and faults are told on stderr as they happen, how late
/// the node was called at the end. Ctrl-C or SIGTERM: path stop, torque off, end; a second one
/// cuts the torque at once. Axes are counted from 1.
#[derive(Debug, Parser)]
#[command(name = "mrroc-node", version, after_help = EXIT_CODES)]
struct Raw {
    /// The robot: irp6-track, irp6-postument, polycrank, irp6-arm, conveyor, irp6-track-gripper or
    /// irp6-postument-gripper
    robot: String,
    /// Where MP and drives are: hub, hub:PORT, hub:HOST:PORT (this machine), can:INTERFACE,
    /// slcan:DEVICE or slcan:HOST:PORT
    #[arg(long)]
    bus: Place,
    /// The effector's number j, from 1 [default: by the robot, irp6-track 1, irp6-postument 2, …]
    #[arg(long, value_name = "J")]
    effector: Option<u8>,
    /// How the loops are closed at start
    #[arg(long, value_enum, default_value = "drive-position")]
    law: Law,
    /// Fraction of the motors' hard velocity limit that may be used, 0 < F <= 1
    #[arg(long, value_name = "F", default_value_t = 0.2)]
    velocity_factor: f64,
    /// Where poses put the track of irp6-track; the cell file of the MP must say the same
    #[arg(long, value_enum, default_value = "keep")]
    track: Track,
    #[command(flatten)]
    drives: DriveOptions,
    /// The force sensor in the wrist is on this drive bus, 0 or 1, as sensor 0; on a CAN interface on 0, as sensor J − 1
    #[arg(long, value_name = "BUS")]
    force_bus: Option<u8>,
    /// Real-time scheduling (first in, first out) with this priority, 1 to 99, and memory that stays in RAM:
    /// on Linux, for those who may
    #[arg(long, value_name = "P", value_parser = clap::value_parser!(u8).range(1..=99))]
    priority: Option<u8>,
    /// Keep starts, black box and images in this folder, so that they survive this process; without it they do not,
    /// and the node has no slots for images
    #[arg(long, value_name = "DIR")]
    state: Option<PathBuf>,
    /// JSON lines on stdout: every event as it happens, then the summary
    #[arg(long)]
    json: bool,
}

/// What is asked of the drives.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct DriveOptions {
    /// Node and drives speak the fast profile of CAN FD, which is experimental: on an interface that carries CAN FD,
    /// with drives that can (those of mrroc-hil-sim)
    #[arg(long)]
    pub(crate) fast_drives: bool,
    /// The device that the drive of an axis must be; if it has no node id, the node gives it one. May be given several
    /// times
    #[arg(long, value_name = "AXIS=VENDOR:PRODUCT:REVISION:SERIAL", value_parser = named)]
    pub(crate) drive: Vec<(u8, Identity)>,
    /// Look for a drive without node id when an axis' drive does not boot, and tell its identity
    #[arg(long)]
    pub(crate) find_drives: bool,
    /// The drives store their set-up, and are not given it again while it is the same
    #[arg(long)]
    pub(crate) stored_setup: bool,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Law {
    /// csp: the drive closes the position loop
    DrivePosition,
    /// cst: MRROC++'s second-order difference equation
    Original,
    /// cst: PID with velocity and acceleration feed-forward
    FeedForward,
    /// cst: the torques of the arm's equation of motion
    ComputedTorque,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum Track {
    /// It stays where it stands
    Keep,
    /// In front of the tool, so that the column looks straight ahead
    InFront,
}

/// What is to be run.
#[derive(Debug)]
pub(crate) struct Args {
    /// The robot.
    pub(crate) robot: RobotKind,
    /// The bus.
    pub(crate) place: Place,
    /// The effector's number.
    pub(crate) effector: u8,
    /// The servo law.
    pub(crate) law: ServoLaw,
    /// Fraction of the velocity limit.
    pub(crate) velocity_factor: f64,
    /// Where the track goes.
    pub(crate) track: TrackRule,
    /// What is asked of the drives.
    pub(crate) drives: DriveOptions,
    /// The drive bus of its force sensor, if it has one.
    pub(crate) force_bus: Option<u8>,
    /// Of real-time scheduling.
    pub(crate) priority: Option<u8>,
    /// Where its state is kept.
    pub(crate) state: Option<PathBuf>,
    /// JSON lines on stdout.
    pub(crate) json: bool,
}

/// What the command line asks for.
///
/// # Errors
/// `--help` and `--version` (code 0), or what is wrong, in one line.
pub(crate) fn parse(args: impl IntoIterator<Item = OsString>) -> Result<Args, End> {
    let raw = Raw::try_parse_from(args)?;
    let robot = RobotKind::from_name(&raw.robot).map_err(|error| End::usage(error.to_string()))?;
    let effector = raw.effector.unwrap_or(robot.effector());
    if effector == 0 || NodeId::effector(effector).is_none() {
        return Err(End::usage(format!(
            "--effector: not an effector's number (expected 1 to {}, got {effector})",
            NodeId::MAX - NodeId::EFFECTOR_BASE
        )));
    }
    if !(raw.velocity_factor > 0.0 && raw.velocity_factor <= 1.0) {
        return Err(End::usage(format!(
            "--velocity-factor: out of range (expected 0 < F <= 1, got {})",
            raw.velocity_factor
        )));
    }
    if raw.track != Track::Keep && robot != RobotKind::Irp6Track {
        return Err(End::usage(format!("--track: {robot} has no track")));
    }
    if raw.drives.fast_drives && !matches!(raw.bus, Place::Can { .. }) {
        return Err(End::usage(format!(
            "--fast-drives: {} carries classical frames only (expected can:INTERFACE, with CAN FD)",
            raw.bus
        )));
    }
    Ok(Args {
        robot,
        place: raw.bus,
        effector,
        law: match raw.law {
            Law::DrivePosition => ServoLaw::DrivePosition,
            Law::Original => ServoLaw::Original,
            Law::FeedForward => ServoLaw::FeedForward,
            Law::ComputedTorque => ServoLaw::ComputedTorque,
        },
        velocity_factor: raw.velocity_factor,
        track: match raw.track {
            Track::Keep => TrackRule::Keep,
            Track::InFront => TrackRule::InFront,
        },
        drives: raw.drives,
        force_bus: raw.force_bus,
        priority: raw.priority,
        state: raw.state,
        json: raw.json,
    })
}

/// `AXIS=VENDOR:PRODUCT:REVISION:SERIAL`, the axis from 1, each number decimal or hexadecimal (0x).
fn named(text: &str) -> Result<(u8, Identity), String> {
    let number = |text: &str| match text.strip_prefix("0x") {
        Some(digits) => u32::from_str_radix(digits, 16),
        None => text.parse(),
    };
    let read = || {
        let (axis, identity) = text.split_once('=')?;
        let axis = axis.parse::<u8>().ok()?.checked_sub(1)?;
        let parts: Vec<u32> = identity
            .split(':')
            .map_while(|part| number(part).ok())
            .collect();
        let count = identity.split(':').count();
        let parts: [u32; 4] = parts.try_into().ok().filter(|_| count == 4)?;
        Some((axis, Identity::from_parts(parts)))
    };
    read().ok_or_else(|| "expected like 3=0:402:0x10000:17, axes from 1".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use process::exit;

    fn of(text: &str) -> Result<Args, End> {
        parse(text.split(' ').map(OsString::from))
    }

    #[test]
    fn only_a_robot_on_a_track_has_a_rule_for_it() {
        let args = of("mrroc-node irp6-track --bus hub --track in-front").unwrap();
        assert_eq!(args.track, TrackRule::InFront);
        let args = of("mrroc-node conveyor --bus hub").unwrap();
        assert_eq!((args.effector, args.track), (5, TrackRule::Keep));
        let error = of("mrroc-node polycrank --bus hub --track in-front").unwrap_err();
        assert_eq!(error.code, exit::USAGE);
        assert!(of("mrroc-node irp6-track --bus hub --track behind").is_err());
    }

    #[test]
    fn drives_are_named_by_axis_and_four_numbers() {
        let args = "mrroc-node irp6-postument --bus hub --drive 3=0:402:0x10000:17 --drive 1=1:2:3:0xFFFFFFFF";
        let args = of(args).unwrap();
        let parts: Vec<_> = args
            .drives
            .drive
            .iter()
            .map(|(axis, who)| (*axis, who.parts()))
            .collect();
        assert_eq!(parts, [(2, [0, 402, 65_536, 17]), (0, [1, 2, 3, u32::MAX])]);
        assert!(!args.drives.find_drives && !args.drives.stored_setup);
        for wrong in [
            "3",
            "0=1:2:3:4",
            "3=1:2:3",
            "3=1:2:3:4:5",
            "3=1:2:3:x",
            "x=1:2:3:4",
            "3=1:2:3:4294967296",
        ] {
            let end = of(&format!(
                "mrroc-node irp6-postument --bus hub --drive {wrong}"
            ))
            .unwrap_err();
            assert_eq!(end.code, exit::USAGE, "{wrong}");
        }
    }

    #[test]
    fn defaults() {
        let args = of("mrroc-node irp6-postument --bus hub:3000").unwrap();
        assert_eq!((args.effector, args.drives.fast_drives), (2, false));
        assert_eq!(args.law, ServoLaw::DrivePosition);
        assert_eq!(
            args.place,
            Place::Hub {
                host: "127.0.0.1".into(),
                port: 3000
            }
        );
        let args = of("mrroc-node irp6-track --bus can:can0 --fast-drives").unwrap();
        assert_eq!((args.effector, args.drives.fast_drives), (1, true));
    }

    #[test]
    fn every_mistake_is_one_line_with_code_64() {
        for text in [
            "mrroc-node",
            "mrroc-node irp6-track",
            "mrroc-node irp7 --bus hub",
            "mrroc-node irp6-track --bus hub:x",
            "mrroc-node irp6-track --bus virtual",
            "mrroc-node irp6-track --bus hub --effector 0",
            "mrroc-node irp6-track --bus hub --effector 118",
            "mrroc-node irp6-track --bus hub --effector 1000",
            "mrroc-node irp6-track --bus hub --law pid",
            "mrroc-node irp6-track --bus hub --velocity-factor 0",
            "mrroc-node irp6-track --bus hub --velocity-factor NaN",
            "mrroc-node irp6-track --bus hub --velocity-factor 1.1",
            "mrroc-node irp6-track --bus hub --fast-drives",
            "mrroc-node irp6-track --bus slcan:/dev/ttyACM0 --fast-drives",
            "mrroc-node irp6-track --bus hub --bogus",
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
        let help = of("mrroc-node --help").unwrap_err();
        assert_eq!(help.code, 0);
        for code in [
            exit::USAGE,
            exit::DATA,
            exit::NO_INPUT,
            exit::UNAVAILABLE,
            exit::INTERNAL,
            exit::CANNOT_CREATE,
            exit::IO,
            exit::PERMISSION,
        ] {
            assert!(
                help.text.contains(&format!("  {code}  ")),
                "{code} is not in --help"
            );
        }
        assert_eq!(of("mrroc-node --version").unwrap_err().code, 0);
    }
}
