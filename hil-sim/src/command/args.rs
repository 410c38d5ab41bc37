//! The command line.

use super::exit::{self, End};
use bus::spec::BusSpec;
use clap::Parser;
use robots::RobotKind;
use std::ffi::OsString;

/// Drives and mechanics of robots, in real time.
///
/// On a hub this process is the hub: a socketcand server on this machine with the channel `mp` for
/// MP and nodes, and `ROBOT.0`, `ROBOT.1` for the drive buses of each robot. On a CAN interface
/// everything is one wire. Late? Then it says so, on stderr and in the summary. Ctrl-C or SIGTERM
/// ends it.
#[derive(Debug, Parser)]
#[command(name = "mrroc-hil-sim", version, after_help = exit::HELP)]
struct Raw {
    /// The robots: irp6-track, irp6-postument
    #[arg(required = true, value_name = "ROBOT")]
    robots: Vec<String>,
    /// Where: hub, hub:PORT (port 0: any free one, told at the start) or can:INTERFACE
    #[arg(long)]
    bus: String,
    /// The effectors' numbers, in the order of the robots [default: irp6-track 1, irp6-postument 2]
    #[arg(long, value_name = "J,…", value_delimiter = ',')]
    effector: Vec<u8>,
    /// Seed of everything random: where the motors stand at the start, switches that bounce
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// JSON lines on stdout: `ready`, `late` as it happens, then the summary
    #[arg(long)]
    json: bool,
}

/// A real bus.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    /// A hub of our own.
    Hub {
        /// Name or address of this machine.
        host: String,
        /// TCP port; 0 = any free one.
        port: u16,
    },
    /// A CAN interface.
    Can {
        /// Its name.
        interface: String,
    },
}

/// What is to be run.
#[derive(Debug)]
pub(crate) struct Args {
    /// The robots and their effector numbers.
    pub(crate) robots: Vec<(RobotKind, u8)>,
    /// The bus.
    pub(crate) place: Place,
    /// Seed of everything random.
    pub(crate) seed: u64,
    /// JSON lines on stdout.
    pub(crate) json: bool,
}

/// What the command line asks for.
///
/// # Errors
/// `--help` and `--version` (code 0), or what is wrong, in one line.
pub(crate) fn parse(args: impl IntoIterator<Item = OsString>) -> Result<Args, End> {
    let raw = Raw::try_parse_from(args).map_err(|error| {
        if error.use_stderr() {
            End::new(exit::USAGE, one_line(&error.to_string()))
        } else {
            End::new(0, error.to_string())
        }
    })?;
    let usage = |text: String| End::new(exit::USAGE, text);
    let place = place(&raw.bus)?;
    if !raw.effector.is_empty() && raw.effector.len() != raw.robots.len() {
        return Err(usage(format!(
            "--effector: expected one number for each of {} robots, got {}",
            raw.robots.len(),
            raw.effector.len()
        )));
    }
    let mut robots: Vec<(RobotKind, u8)> = Vec::new();
    let mut numbers = raw.effector.iter().copied();
    for name in &raw.robots {
        let kind = RobotKind::from_name(name).map_err(|error| usage(error.to_string()))?;
        let number = numbers.next().unwrap_or(kind.effector());
        if number == 0 {
            return Err(usage(
                "--effector: expected numbers from 1 on, got 0".into(),
            ));
        }
        let hub = matches!(place, Place::Hub { .. });
        if hub && robots.iter().any(|(other, _)| *other == kind) {
            return Err(usage(format!(
                "{kind}: given twice (expected each robot once on a hub: its channels are named \
                 after it)"
            )));
        }
        if let Some((other, _)) = robots.iter().find(|(_, taken)| *taken == number) {
            return Err(usage(format!(
                "--effector: {other} and {kind} are both effector {number} (expected different \
                 numbers)"
            )));
        }
        robots.push((kind, number));
    }
    Ok(Args {
        robots,
        place,
        seed: raw.seed,
        json: raw.json,
    })
}

fn place(text: &str) -> Result<Place, End> {
    if text == "hub:0" {
        return Ok(Place::Hub {
            host: "127.0.0.1".into(),
            port: 0,
        });
    }
    match text.parse() {
        Ok(BusSpec::Hub { host, port }) => Ok(Place::Hub { host, port }),
        Ok(BusSpec::Can { interface }) => Ok(Place::Can { interface }),
        Ok(BusSpec::Virtual) => Err(End::new(
            exit::USAGE,
            "--bus: a simulator process needs a bus between processes (expected hub, hub:PORT or \
             can:INTERFACE, got virtual)",
        )),
        Err(error) => Err(End::new(exit::USAGE, format!("--bus: {error}"))),
    }
}

/// The first paragraph of clap's text as one line.
fn one_line(text: &str) -> String {
    let paragraph = text.split("\n\n").next().unwrap_or(text);
    let words: Vec<&str> = paragraph.split_whitespace().collect();
    let line = words.join(" ");
    let line = line.strip_prefix("error: ").unwrap_or(&line);
    format!("{line} (see mrroc-hil-sim --help)")
}

#[cfg(test)]
mod tests {
    use super::*;

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
        assert_eq!(of("mrroc-hil-sim --version").unwrap_err().code, 0);
    }
}
