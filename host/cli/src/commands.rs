//! The command line: subcommands in the field's words.

use crate::PROGRAM;
use crate::dbc::Dbc;
use crate::eds::Eds;
use crate::kin::Kin;
use crate::load::Bus;
use crate::monitor;
use crate::node::Node;
use crate::plan::Plan;
use crate::replay;
use crate::robot::Robot;
use crate::run::{Finished, Options, Record, catch_interrupt, run};
use agent::{Class, Inhabitant};
use bus::spec::{BusSpec, Place};
use clap::{Args, CommandFactory, Parser, Subcommand};
use hil_sim::fault::FaultSpec;
use host::error::Error;
use host::input::Files;
use host::path::Reference;
use host::task::{self, Task};
use process::{End, exit};
use protocol::message::StopKind;
use robots::RobotKind;
use std::io::{BufReader, Write};
use std::path::PathBuf;

/// Multi-robot controller: runs, watches, records and draws.
#[derive(Parser, Debug)]
#[command(version, propagate_version = true, max_term_width = 100, after_help = EXIT_CODES)]
pub(crate) struct Cli {
    #[command(subcommand)]
    command: Command,
}

/// Exit codes, as in [`exit`].
const EXIT_CODES: &str = "\
Exit codes: 0 done; 10 a fault ended the motion; 11 a target was refused or cannot be reached; \
12 stopped by the operator; 13 a replay differs from its record; 64 wrong use; 65 wrong contents of a file; 66 a file cannot be read; \
69 a node or a bus is not there; 70 internal error; 73 a file cannot be created; 74 I/O error; \
75 another MP holds the lease; 76 another protocol; 77 no permission; 78 other robots than the cell's.";

#[derive(Subcommand, Debug)]
enum Command {
    /// Run a task, or one taught trajectory (.trj) on a robot.
    Run(RunArgs),
    /// Home robots, axis by axis.
    Home(HomeArgs),
    /// Move one robot to joints, motors or a pose; homes it first if need be.
    Move(MoveArgs),
    /// Stop every robot on a bus; needs no lease.
    Stop(StopArgs),
    /// Feed a record (.mcap) back to the Master Process and the nodes, and compare what they send.
    Replay(replay::Replay),
    /// Watch the nodes on a bus: states, joints, faults.
    Monitor(monitor::Monitor),
    /// One node: who it is, why it started, its first fault, its next image.
    Node(Node),
    /// Kinematics: poses, joints, motors, Jacobians.
    Kin(Kin),
    /// What is known about a robot: axes, limits, masses; as text, JSON or URDF.
    Robot(Robot),
    /// The buses of a cell: what they carry at worst.
    Bus(Bus),
    /// Plans of motion without a robot: of axes, of a tool along a path.
    Plan(Plan),
    /// Print the data sheet (EDS, CiA 306) of the drive of one axis.
    Eds(Eds),
    /// Print a database (DBC) of the frames of one bus of a cell.
    Dbc(Dbc),
    /// The classes of generators and conditions, and who inhabits them.
    Classes(ClassesArgs),
    /// Print a completion script for a shell.
    Completions {
        /// The shell.
        shell: clap_complete::Shell,
    },
    /// Print the manual page.
    Man,
}

/// What all commands that command robots share.
#[derive(Args, Debug)]
struct Common {
    /// virtual (simulated in this process), hub, hub:PORT, hub:HOST:PORT, can:INTERFACE,
    /// slcan:DEVICE or slcan:HOST:PORT.
    #[arg(long, default_value = "virtual")]
    bus: BusSpec,
    /// Pace virtual time by the wall clock.
    #[arg(long)]
    realtime: bool,
    /// Write every frame of every bus: .mcap (can be replayed), or any other name for a candump log.
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// Draw what happened (.svg or .png); may be given several times.
    #[arg(long, value_name = "FILE")]
    plot: Vec<PathBuf>,
    /// Print the summary as one JSON value.
    #[arg(long)]
    json: bool,
    /// No progress on stderr.
    #[arg(long, short)]
    quiet: bool,
    /// Seed of the simulation.
    #[arg(long)]
    seed: Option<u64>,
    /// What breaks when in the simulation: ROBOT/AXIS:FAULT@SECONDS or ROBOT.BUS:FAULT@SECONDS, as for `mrroc-hil-sim
    /// --fault`, of which this has the list; may be given several times.
    #[arg(long, value_name = "SPEC")]
    fault: Vec<FaultSpec>,
    /// Real-time scheduling (first in, first out) with this priority, 1 to 99, and memory that stays in RAM:
    /// on Linux, for those who may.
    #[arg(long, value_name = "P", value_parser = clap::value_parser!(u8).range(1..=99))]
    priority: Option<u8>,
}

impl Common {
    fn options(&self, files: Files) -> Options {
        let record = self.record.clone().map(|path| Record {
            path,
            arguments: std::env::args_os()
                .skip(1)
                .map(|argument| argument.to_string_lossy().into_owned())
                .collect(),
            files: files.into_read(),
        });
        Options {
            bus: self.bus.clone(),
            realtime: self.realtime,
            record,
            plots: self.plot.clone(),
            json: self.json,
            quiet: self.quiet,
            faults: self.fault.clone(),
        }
    }

    fn run(&self, asked: impl FnOnce(&Files) -> Result<Asked, Error>) -> Result<u8, End> {
        // before there are threads
        self.priority.map_or(Ok(()), process::take_priority)?;
        Ok(self.carry_out(asked)?)
    }

    fn carry_out(&self, asked: impl FnOnce(&Files) -> Result<Asked, Error>) -> Result<u8, Error> {
        let files = Files::on_disk();
        let Asked { task, path } = asked(&files)?;
        for warning in task.warnings() {
            let _ = writeln!(std::io::stderr(), "mrroc: warning: {warning}");
        }
        catch_interrupt()?;
        let Finished { summary, exit_code } = run(task, path.as_deref(), &self.options(files))?;
        let mut out = std::io::stdout().lock();
        let text = if self.json {
            summary
                .to_json()
                .map_err(|e| Error::Internal(e.to_string()))?
                + "\n"
        } else {
            summary.to_string()
        };
        // a reader that has gone away does not change what the robots did
        let _ = out.write_all(text.as_bytes());
        if let Some(error) = &summary.error {
            let _ = writeln!(std::io::stderr(), "mrroc: {error}");
        }
        Ok(exit_code)
    }
}

/// A task that was asked for.
#[derive(Debug)]
pub(crate) struct Asked {
    pub(crate) task: Task,
    /// Its file, for messages.
    pub(crate) path: Option<PathBuf>,
}

impl Asked {
    fn new(task: Task, path: Option<PathBuf>, common: &Common) -> Self {
        let seed = common.seed.unwrap_or(task.seed);
        let task = Task { seed, ..task };
        Self { task, path }
    }
}

#[derive(Args, Debug)]
struct RunArgs {
    /// A task (.toml) or a taught trajectory (.trj).
    file: PathBuf,
    /// The robot that replays a .trj file.
    #[arg(long)]
    robot: Option<String>,
    #[command(flatten)]
    common: Common,
}

#[derive(Args, Debug)]
struct HomeArgs {
    /// The robots.
    #[arg(required = true)]
    robots: Vec<String>,
    #[command(flatten)]
    common: Common,
}

#[derive(Args, Debug)]
struct MoveArgs {
    /// The robot.
    robot: String,
    #[command(flatten)]
    target: MoveTarget,
    /// The target is an increment (a pose: in the tool frame; a path: from where the tool is, along
    /// the axes of the base frame).
    #[arg(long)]
    relative: bool,
    /// Fraction (0, 1] of the robot's speed ceilings.
    #[arg(long, allow_negative_numbers = true, value_parser = fraction, conflicts_with = "path")]
    speed: Option<f64>,
    /// Greatest speed of the tool on a path, m/s.
    #[arg(long, value_name = "M_S", allow_negative_numbers = true, value_parser = feed)]
    #[arg(conflicts_with_all = ["joints", "motors", "pose"])]
    feed: Option<f64>,
    #[command(flatten)]
    common: Common,
}

#[derive(Args, Debug)]
#[group(required = true, multiple = false)]
struct MoveTarget {
    /// Joint positions, rad or m, separated by commas.
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true, value_parser = finite)]
    joints: Option<Vec<f64>>,
    /// Motor angles, rad, separated by commas.
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true, value_parser = finite)]
    motors: Option<Vec<f64>>,
    /// Pose of the tool on a straight line: x,y,z in m and rotation vector rx,ry,rz in rad.
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true, value_parser = finite)]
    pose: Option<Vec<f64>>,
    /// Path of the tool: points x,y,z or x,y,z,rx,ry,rz (.csv), or lines, arcs and points (.toml).
    #[arg(long, value_name = "FILE")]
    path: Option<PathBuf>,
}

#[derive(Args, Debug)]
struct StopArgs {
    /// path (torque stays on), quick (then torque off) or torque-off.
    #[arg(long, default_value = "path", value_parser = stop_kind)]
    kind: StopKind,
    /// hub, hub:PORT, hub:HOST:PORT, can:INTERFACE,
    /// slcan:DEVICE or slcan:HOST:PORT.
    #[arg(long, default_value = "hub")]
    bus: Place,
}

#[derive(Args, Debug)]
struct ClassesArgs {
    /// Print a JSON array.
    #[arg(long)]
    json: bool,
}

/// A number that is neither infinite nor none.
pub(crate) fn finite(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err("expected a finite number".into()),
    }
}

fn fraction(text: &str) -> Result<f64, String> {
    match finite(text)? {
        value if value > 0.0 && value <= 1.0 => Ok(value),
        _ => Err("expected a number above 0 and at most 1".into()),
    }
}

/// A feed that can be asked for, m/s.
pub(crate) fn feed(text: &str) -> Result<f64, String> {
    match finite(text)? {
        value if value > 0.0 && value <= 5.0 => Ok(value),
        _ => Err("expected a number of m/s above 0 and at most 5".into()),
    }
}

fn stop_kind(text: &str) -> Result<StopKind, String> {
    match text {
        "path" => Ok(StopKind::Path),
        "quick" => Ok(StopKind::Quick),
        "torque-off" => Ok(StopKind::TorqueOff),
        _ => Err("expected path, quick or torque-off".into()),
    }
}

/// The robot of a name.
pub(crate) fn robot(name: &str) -> Result<RobotKind, Error> {
    RobotKind::from_name(name).map_err(|_| Error::Usage {
        what: format!("unknown robot {name:?}"),
        expected: RobotKind::ALL.map(RobotKind::name).join(" or "),
        got: name.chars().take(80).collect(),
    })
}

impl Cli {
    /// The task that a process with these arguments was asked for; `None` if it was something else.
    pub(crate) fn asked(
        arguments: impl IntoIterator<Item = String>,
        files: &Files,
    ) -> Result<Option<Asked>, End> {
        let name = std::iter::once(PROGRAM.to_owned());
        let cli = Self::try_parse_from(name.chain(arguments))?;
        Ok(match cli.command {
            Command::Run(args) => Some(args.asked(files)?),
            Command::Home(args) => Some(args.asked()?),
            Command::Move(args) => Some(args.asked(files)?),
            _ => None,
        })
    }

    /// Carry out the command; the exit code.
    pub(crate) fn run(self) -> Result<u8, End> {
        Ok(match self.command {
            Command::Run(args) => args.common.run(|files| args.asked(files))?,
            Command::Home(args) => args.common.run(|_| args.asked())?,
            Command::Move(args) => args.common.run(|files| args.asked(files))?,
            Command::Replay(replay) => replay.run(&mut std::io::stdout().lock())?,
            Command::Stop(args) => monitor::stop(&args.bus, args.kind)?,
            Command::Monitor(args) => args.run()?,
            Command::Node(node) => node.run(&mut std::io::stdout().lock())?,
            Command::Kin(kin) => {
                let mut input = BufReader::new(std::io::stdin());
                kin.run(&mut std::io::stdout().lock(), &mut input)?;
                exit::OK
            }
            Command::Robot(robot) => {
                robot.run(&mut std::io::stdout().lock())?;
                exit::OK
            }
            Command::Bus(bus) => bus.run(&mut std::io::stdout().lock())?,
            Command::Plan(plan) => {
                let mut input = BufReader::new(std::io::stdin());
                plan.run(&mut std::io::stdout().lock(), &mut input)?;
                exit::OK
            }
            Command::Eds(eds) => {
                eds.run(&mut std::io::stdout().lock())?;
                exit::OK
            }
            Command::Dbc(dbc) => {
                dbc.run(&mut std::io::stdout().lock())?;
                exit::OK
            }
            Command::Classes(args) => classes(args.json),
            Command::Completions { shell } => {
                let mut command = Self::command();
                clap_complete::generate(shell, &mut command, "mrroc", &mut std::io::stdout());
                exit::OK
            }
            Command::Man => {
                let rendered =
                    clap_mangen::Man::new(Self::command()).render(&mut std::io::stdout());
                rendered.map_err(|e| Error::Internal(e.to_string()))?;
                exit::OK
            }
        })
    }
}

impl HomeArgs {
    fn asked(&self) -> Result<Asked, Error> {
        let kinds = self.robots.iter().map(|name| robot(name));
        let kinds = kinds.collect::<Result<Vec<_>, _>>()?;
        Ok(Asked::new(Task::homing(&kinds), None, &self.common))
    }
}

impl RunArgs {
    fn asked(&self, files: &Files) -> Result<Asked, Error> {
        let extension = self
            .file
            .extension()
            .map(|e| e.to_string_lossy().to_lowercase());
        let task = match (extension.as_deref(), &self.robot) {
            (Some("trj"), Some(name)) => Task::replay(&self.file, files, robot(name)?)?,
            (Some("trj"), None) => {
                return Err(Error::Usage {
                    what: "a .trj file says nothing of its robot".into(),
                    expected: "--robot NAME".into(),
                    got: "no --robot".into(),
                });
            }
            (_, Some(_)) => {
                return Err(Error::Usage {
                    what: "--robot goes with .trj files only".into(),
                    expected: "FILE.trj".into(),
                    got: self.file.display().to_string(),
                });
            }
            (_, None) => Task::load(&self.file, files)?,
        };
        let path = Some(self.file.clone());
        Ok(Asked::new(task, path, &self.common))
    }
}

impl MoveArgs {
    fn asked(&self, files: &Files) -> Result<Asked, Error> {
        let kind = robot(&self.robot)?;
        if let Some(file) = &self.target.path {
            let reference = if self.relative {
                Reference::Start
            } else {
                Reference::Base
            };
            let task = Task::single_path(kind, file, files, reference, self.feed)?;
            return Ok(Asked::new(task, None, &self.common));
        }
        let target = match &self.target {
            MoveTarget {
                joints: Some(values),
                ..
            } => task::MoveTarget::Joints(values.clone()),
            MoveTarget {
                motors: Some(values),
                ..
            } => task::MoveTarget::Motors(values.clone()),
            MoveTarget { pose, .. } => task::MoveTarget::Pose(pose.clone().unwrap_or_default()),
        };
        let task = Task::single_move(kind, target, self.relative, self.speed)?;
        Ok(Asked::new(task, None, &self.common))
    }
}

/// The census of both levels.
fn inhabitants() -> Vec<(Class, &'static str)> {
    let nodes = firmware::ecp::census::ECP
        .iter()
        .map(|i: &Inhabitant| (i.class, i.name));
    nodes.chain(host::mp::census::census()).collect()
}

fn classes(json: bool) -> u8 {
    let inhabitants = inhabitants();
    let mut out = std::io::stdout().lock();
    let rows = Class::all().map(|class| {
        let names = inhabitants
            .iter()
            .filter(|(c, _)| *c == class)
            .map(|(_, name)| *name);
        (class, names.collect::<Vec<_>>())
    });
    let mut empty = 0;
    let mut values = Vec::new();
    for (class, names) in rows {
        empty += usize::from(names.is_empty());
        let (level, kind) = (format!("{:?}", class.role()), format!("{:?}", class.kind()));
        if json {
            values.push(serde_json::json!({
                "level": level.to_lowercase(),
                "kind": kind.to_lowercase(),
                "class": class.to_string(),
                "inhabitants": names,
            }));
        } else {
            let (level, class) = (level.to_uppercase(), class.to_string());
            let _ = writeln!(out, "{level:4} {kind:10} {class:26} {}", names.join(", "));
        }
    }
    if json {
        let _ = writeln!(out, "{}", serde_json::Value::Array(values));
    }
    if empty == 0 { exit::OK } else { exit::INTERNAL }
}

#[cfg(test)]
mod test {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn every_class_is_inhabited() {
        let inhabitants = inhabitants();
        for class in Class::all() {
            assert!(
                inhabitants.iter().any(|(c, _)| *c == class),
                "{class} has no inhabitant"
            );
        }
        assert_eq!(Class::all().count(), 5 + 8 + 4 + 8);
    }

    #[test]
    fn bad_arguments_are_told() {
        for (arguments, word) in [
            (
                &["mrroc", "run", "x.toml", "--bus", "wire"][..],
                "unknown bus",
            ),
            (
                &["mrroc", "move", "irp6-track", "--joints", "1,nan"],
                "finite",
            ),
            (
                &[
                    "mrroc",
                    "move",
                    "irp6-track",
                    "--joints",
                    "1",
                    "--speed",
                    "-1",
                ],
                "above 0",
            ),
            (&["mrroc", "move", "irp6-track"], "required"),
            (
                &[
                    "mrroc",
                    "move",
                    "irp6-track",
                    "--path",
                    "x.csv",
                    "--feed",
                    "0",
                ],
                "above 0",
            ),
            (
                &[
                    "mrroc",
                    "move",
                    "irp6-track",
                    "--path",
                    "x.csv",
                    "--pose",
                    "1,2,3,0,0,0",
                ],
                "cannot be used with",
            ),
            (
                &[
                    "mrroc",
                    "move",
                    "irp6-track",
                    "--joints",
                    "1",
                    "--feed",
                    "1",
                ],
                "cannot be used with",
            ),
            (&["mrroc", "stop", "--kind", "slow"], "torque-off"),
            (
                &["mrroc", "run", "x.toml", "--fault", "conveyor/1:melted@1"],
                "frozen",
            ),
        ] {
            let error = Cli::try_parse_from(arguments).unwrap_err().to_string();
            assert!(error.contains(word), "{arguments:?}: {error}");
        }
        assert_eq!(robot("irp7").unwrap_err().exit_code(), exit::USAGE);
    }
}
