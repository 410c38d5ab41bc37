//! Tasks: what a user asks the cell to do, as strict TOML.
//!
//! ```toml
//! title = "Both arms to their first poses"
//! seed = 7
//! cell = "cell.toml"                 # or the same tables here: [[cell.robot]], [[cell.bus]]
//!
//! [[step]]
//! home = ["irp6-track", "irp6-postument"]
//!
//! [[step]]
//! trj = { irp6-track = "a.trj", irp6-postument = "b.trj" }
//! coordination = "loose"             # both begin every node together; "none": each for itself
//!
//! [[step]]
//! move = { robot = "irp6-track", pose = { position_m = [0, 0, 0.05] }, relative = true }
//!
//! [[step]]                           # down, until the force at the wrist has changed by 10 N
//! move = { robot = "irp6-track", pose = { position_m = [0, 0, 0.05] }, relative = true, until_force_n = 10 }
//!
//! [[step]]
//! wait = { seconds = 0.5 }
//!
//! [[step]]
//! tight = { robots = ["irp6-track", "irp6-postument"], displacement_m = [0, 0, 0.1], duration_s = 4 }
//!
//! [[step]]
//! path = { robot = "irp6-track", file = "rose.csv", feed_m_s = 0.05, relative_to = "start" }
//!
//! [[step]]
//! engrave = { robot = "rnt", file = "drawing.svg", depth_m = 6e-4 }   # on `cell.board`
//!
//! [[step]]
//! regulator = { robot = "irp6-track", law = "feed-forward" }
//! ```
//!
//! An unknown or doubled key, a number outside its range and a file that is not there are errors
//! with file, line and column, and a task with an error does not begin. Paths are relative to the
//! file that names them. What needs kinematics or the state of a robot (reach, limits, homing) is
//! judged when the step begins.

use crate::error::Error;
use crate::input::{DataError, Files, LoadError, Problem};
use crate::path::Reference;
use crate::trj::Trajectory;
use document::{Document, Fields};
use motion::pose::Pose;
use nalgebra::Vector3;
use protocol::message::{PosePath, PoseReference, ServoLaw};
use robots::RobotKind;
use std::path::{Path, PathBuf};

pub mod board;
pub mod cell;
mod document;
pub mod engrave;
mod kind;
pub mod path;
#[cfg(test)]
mod shipped;
mod step;
mod surface;
#[cfg(test)]
mod test;

use step::{AXIS_SPEED, POSE_SPEED};

pub use board::{Board, Cutter};
pub use cell::{BusKind, BusSpec, Cell, DriveGroup, RobotSpec};
pub use engrave::Engrave;
pub use path::PathStep;
pub use surface::SurfaceSpec;

/// A task, checked as far as that is possible without its robots.
#[derive(Clone, Debug, PartialEq)]
pub struct Task {
    /// What people call it.
    pub title: String,
    /// Seed of everything random in the run; 0 if the task says nothing.
    pub seed: u64,
    /// The robots and buses.
    pub cell: Cell,
    /// What to do, in this order.
    pub steps: Vec<Step>,
}

/// One step of a task; it ends when all its robots have ended.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Its name, for progress and plots: the task's, or one made of the action.
    pub name: String,
    /// Its line in the task file, from 1; 0 if there is no file.
    pub line: u32,
    /// What is done.
    pub action: Action,
}

/// What a step does. Robots are indices in [`Cell::robots`], each at most once.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// Home the robots.
    Home {
        /// Which.
        robots: Vec<usize>,
    },
    /// Replay taught trajectories.
    Replay {
        /// One per robot; of equal node counts if loosely coordinated.
        replays: Vec<Replay>,
        /// How the robots wait for each other.
        coordination: Coordination,
    },
    /// One motion each; the robots begin in the same step.
    Move {
        /// One per robot.
        moves: Vec<Move>,
    },
    /// Let time pass.
    Wait {
        /// How long, s; greater than 0, at most 3600.
        seconds: f64,
    },
    /// Move an object held by several robots: tight coordination.
    Tight(Tight),
    /// Follow a path.
    Path(PathStep),
    /// Engrave the board of the cell.
    Engrave(Engrave),
    /// Choose how a robot's loops are closed.
    Regulator {
        /// Which robot.
        robot: usize,
        /// The law for all its axes.
        law: ServoLaw,
    },
}

/// How robots that replay trajectories wait for each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coordination {
    /// They begin together and then go on, each for itself.
    None,
    /// They begin every node together.
    Loose,
}

/// A taught trajectory for a robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Replay {
    /// Index in [`Cell::robots`].
    pub robot: usize,
    /// The file.
    pub path: PathBuf,
    /// What it says.
    pub trajectory: Trajectory,
}

/// A motion of one robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Move {
    /// Index in [`Cell::robots`].
    pub robot: usize,
    /// Where to.
    pub target: Target,
    /// Velocity as a fraction (0, 1] of the ceiling of the target's space, as in `.trj` files
    /// ([`crate::trj::Space::velocity_ceiling`]).
    pub velocity: f64,
    /// Acceleration, likewise.
    pub acceleration: f64,
    /// It ends where the force at the wrist has changed by so much since it began, N.
    pub until_force_n: Option<f64>,
}

/// Where a motion goes.
#[derive(Clone, Debug, PartialEq)]
pub enum Target {
    /// Joint positions or increments, rad or m, one per axis.
    Joints {
        /// The values.
        values: Vec<f64>,
        /// Are they increments?
        relative: bool,
    },
    /// Motor-shaft angles or increments, rad, one per axis.
    Motors {
        /// The values.
        values: Vec<f64>,
        /// Are they increments?
        relative: bool,
    },
    /// A pose of the tool.
    Pose {
        /// `t_base_tool`, or the increment `t_tool_goal`.
        pose: Pose,
        /// Absolute, or relative to the tool.
        reference: PoseReference,
        /// Straight for the tool or straight for the joints.
        path: PosePath,
    },
}

/// A motion of an object that several robots hold: every tool makes the same displacement of the
/// world, so that their relative poses stay.
#[derive(Clone, Debug, PartialEq)]
pub struct Tight {
    /// At least two, as indices in [`Cell::robots`].
    pub robots: Vec<usize>,
    /// Translation, m, in the world.
    pub displacement_m: [f64; 3],
    /// Rotation vector (axis · angle), rad, in the world; at most half a turn.
    pub rotation_rad: [f64; 3],
    /// The point of the world about which the object turns, m.
    pub centre_m: [f64; 3],
    /// How long it takes, s.
    pub duration_s: f64,
}

impl Tight {
    /// The displacement D(s) of the world after the share s ∈ \[0, 1\] of the way: a tool that
    /// began at `t_world_tool` is then at `D(s) * t_world_tool`.
    #[must_use]
    pub fn displacement(&self, s: f64) -> Pose {
        let centre = Vector3::from(self.centre_m);
        let turn =
            Pose::from_rotation_vector(Vector3::zeros(), Vector3::from(self.rotation_rad) * s);
        Pose {
            position: centre - turn.rotation * centre + Vector3::from(self.displacement_m) * s,
            rotation: turn.rotation,
        }
    }
}

impl Task {
    /// Reads a task file and every file it names.
    ///
    /// # Errors
    /// A file cannot be read, or the first mistake in one, with line and column.
    pub fn load(path: &Path, files: &Files) -> Result<Self, LoadError> {
        Document::load(path, files, read)
    }

    /// Reads a task from text; paths in it are relative to the working directory.
    ///
    /// # Errors
    /// As [`Task::load`].
    pub fn parse(text: &str) -> Result<Self, DataError> {
        read(&Document {
            path: None,
            text,
            files: &Files::on_disk(),
        })
    }

    /// The task of replaying one taught file after homing.
    ///
    /// # Errors
    /// The file cannot be read or is not a trajectory for this robot.
    pub fn replay(path: &Path, files: &Files, kind: RobotKind) -> Result<Self, LoadError> {
        let trajectory = crate::trj::load(path, files, kind.axes())?;
        let mut task = Self::homing(&[kind]);
        task.title = path.file_name().map_or_else(
            || kind.name().to_owned(),
            |name| name.to_string_lossy().into_owned(),
        );
        task.steps.push(Step {
            name: task.title.clone(),
            line: 0,
            action: Action::Replay {
                replays: vec![Replay {
                    robot: 0,
                    path: path.to_path_buf(),
                    trajectory,
                }],
                coordination: Coordination::None,
            },
        });
        Ok(task)
    }

    /// The task of homing robots.
    #[must_use]
    pub fn homing(kinds: &[RobotKind]) -> Self {
        let cell = Cell::of(kinds);
        let action = Action::Home {
            robots: (0..cell.robots.len()).collect(),
        };
        let name = action.describe(&cell);
        Self {
            title: name.clone(),
            seed: 0,
            cell,
            steps: vec![Step {
                name,
                line: 0,
                action,
            }],
        }
    }

    /// The task of one move, homing the robot first. `speed` is a fraction of its speed ceilings,
    /// the original's default if absent; a pose is x, y, z (m) and a rotation vector (rad), reached
    /// on a straight line.
    ///
    /// # Errors
    /// [`Error::Usage`] for a wrong number of values.
    pub fn single_move(
        kind: RobotKind,
        target: MoveTarget,
        relative: bool,
        speed: Option<f64>,
    ) -> Result<Self, Error> {
        let (what, expected, values) = match &target {
            MoveTarget::Joints(values) => ("--joints", kind.axes(), values),
            MoveTarget::Motors(values) => ("--motors", kind.axes(), values),
            MoveTarget::Pose(values) => ("--pose", 6, values),
        };
        if values.len() != expected {
            return Err(Error::Usage {
                what: format!("{what} of {kind}"),
                expected: format!("{expected} values"),
                got: values.len().to_string(),
            });
        }
        let (target, default) = match target {
            MoveTarget::Joints(values) => (Target::Joints { values, relative }, AXIS_SPEED),
            MoveTarget::Motors(values) => (Target::Motors { values, relative }, AXIS_SPEED),
            MoveTarget::Pose(values) => {
                let three = |from: usize| {
                    Vector3::from_fn(|k, _| values.get(from + k).copied().unwrap_or(0.0))
                };
                let pose = Pose::from_rotation_vector(three(0), three(3));
                let reference = if relative {
                    PoseReference::Tool
                } else {
                    PoseReference::Base
                };
                let target = Target::Pose {
                    pose,
                    reference,
                    path: PosePath::Line,
                };
                (target, POSE_SPEED)
            }
        };
        let (velocity, acceleration) = speed.map_or(default, |speed| (speed, speed));
        let mut task = Self::homing(&[kind]);
        task.title = format!("move {kind}");
        let moves = vec![Move {
            robot: 0,
            target,
            velocity,
            acceleration,
            until_force_n: None,
        }];
        task.steps.push(Step {
            name: task.title.clone(),
            line: 0,
            action: Action::Move { moves },
        });
        Ok(task)
    }

    /// The task of one path (`.csv` or `.toml`), homing the robot first.
    ///
    /// # Errors
    /// The file cannot be read or is no path.
    pub fn single_path(
        kind: RobotKind,
        file: &Path,
        files: &Files,
        reference: Reference,
        feed_m_s: Option<f64>,
    ) -> Result<Self, LoadError> {
        let mut task = Self::homing(&[kind]);
        task.title = format!("path {kind}");
        let path = path::load(file, files)?;
        task.steps.push(Step {
            name: task.title.clone(),
            line: 0,
            action: Action::Path(PathStep::new(0, path, reference, feed_m_s)),
        });
        Ok(task)
    }

    /// What was skipped in the task's trajectories, a line each.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        self.steps
            .iter()
            .filter_map(|step| match &step.action {
                Action::Replay { replays, .. } => Some(replays),
                _ => None,
            })
            .flatten()
            .flat_map(|replay| {
                let path = replay.path.display().to_string();
                replay
                    .trajectory
                    .warnings
                    .iter()
                    .map(move |warning| format!("{path}: {warning}"))
            })
            .collect()
    }
}

/// The target of [`Task::single_move`].
#[derive(Clone, Debug, PartialEq)]
pub enum MoveTarget {
    /// rad or m.
    Joints(Vec<f64>),
    /// rad.
    Motors(Vec<f64>),
    /// x, y, z in m, rotation vector in rad.
    Pose(Vec<f64>),
}

impl Action {
    /// The action in a few words: `home irp6-track, irp6-postument`.
    #[must_use]
    pub fn describe(&self, cell: &Cell) -> String {
        let names = |indices: &mut dyn Iterator<Item = usize>| {
            indices
                .filter_map(|index| Some(cell.robots.get(index)?.name.as_str()))
                .collect::<Vec<_>>()
                .join(", ")
        };
        match self {
            Self::Home { robots } => format!("home {}", names(&mut robots.iter().copied())),
            Self::Replay { replays, .. } => {
                format!("replay {}", names(&mut replays.iter().map(|r| r.robot)))
            }
            Self::Move { moves } => format!("move {}", names(&mut moves.iter().map(|m| m.robot))),
            Self::Wait { seconds } => format!("wait {seconds} s"),
            Self::Tight(tight) => format!("carry {}", names(&mut tight.robots.iter().copied())),
            Self::Path(path) => format!("path {}", names(&mut std::iter::once(path.robot))),
            Self::Engrave(engrave) => {
                format!("engrave {}", names(&mut std::iter::once(engrave.robot)))
            }
            Self::Regulator { robot, law } => {
                let law = cell::SERVO_LAWS
                    .iter()
                    .find(|(_, known)| known == law)
                    .map_or("", |(name, _)| *name);
                format!("{law} {}", names(&mut std::iter::once(*robot)))
            }
        }
    }
}

fn read(document: &Document<'_>) -> Result<Task, DataError> {
    let table = document.parse()?;
    let fields = Fields::new(
        document,
        0..0,
        table.get_ref(),
        "a task",
        &["title", "seed", "cell", "step"],
    )?;
    let title = fields.required("title")?.text()?.to_owned();
    let seed = match fields.optional("seed") {
        Some(value) => value.integer("a whole number from 0", |_| true)?,
        None => 0,
    };
    let cell = cell::of_task(document, &fields.required("cell")?)?;
    let mut steps = Vec::new();
    let list = fields.required("step")?;
    for value in list.list()? {
        steps.push(step::read(document, &cell, &value)?);
    }
    if steps.is_empty() {
        return Err(list.error(
            Problem::WrongCount,
            "a task without steps",
            "at least one",
            "none",
        ));
    }
    Ok(Task {
        title,
        seed,
        cell,
        steps,
    })
}
