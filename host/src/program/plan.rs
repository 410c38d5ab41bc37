//! A task walked through by kinematics, from where the robots are: whatever cannot be is told with
//! its place in the file before anything moves.

mod walk;

use super::progress::Segment;
use crate::mp::arm::Arm;
use crate::mp::config::{Config, Grid};
use crate::mp::failure::Failure;
use crate::mp::generator::{Carried, Course};
use crate::path::{PathFault, Streamed};
use crate::task::engrave::{Engrave, Section};
use crate::task::{Action, Coordination, PathStep, Step, Task, Tight};
use core::fmt;
use protocol::message::{Instruction, ServoLaw};
use protocol::units::PerAxis;
use robots::{AxisHoming, KinematicError};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Where a robot is.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// Motor angles, rad; before homing they count from anywhere, but for absolute encoders.
    pub motors: PerAxis<f64>,
    /// Is it homed?
    pub homed: bool,
    /// It is where a motion until a force would have ended without one: nobody knows how far that went.
    pub guessed: bool,
}

impl Place {
    /// Not homed, as a robot that was just switched on.
    #[must_use]
    pub fn unknown(arm: &dyn Arm) -> Self {
        Self {
            motors: arm.axes().iter().map(|_| 0.0).collect(),
            homed: false,
            guessed: false,
        }
    }

    /// Homed from here: an axis ends at 0, or rests where its absolute encoder has it.
    fn home(&mut self, arm: &dyn Arm) {
        for (motor, axis) in self.motors.iter_mut().zip(arm.axes()) {
            if axis.homing != AxisHoming::Absolute {
                *motor = 0.0;
            }
        }
        self.homed = true;
    }

    /// The same place, to the last unit of a motor, as far as its angles mean anything.
    pub(super) fn is_near(&self, other: &Self, arm: &dyn Arm) -> bool {
        self.homed == other.homed
            && self
                .motors
                .iter()
                .zip(&other.motors)
                .zip(arm.axes())
                .filter(|(_, axis)| self.homed || axis.homing == AxisHoming::Absolute)
                .all(|((a, b), _)| (a - b).abs() < SAME_RAD)
    }
}

/// Motor angles, or joints, that are the same but for the last unit of a motor.
pub(super) const SAME_RAD: f64 = 1e-5;

/// A motion of one robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// Which robot.
    pub robot: usize,
    /// What its node is asked for.
    pub instruction: Instruction,
    /// The way it takes.
    pub segment: Segment,
}

/// What a step does.
#[derive(Clone, Debug, PartialEq)]
pub enum Work {
    /// Home these robots.
    Home(Vec<usize>),
    /// Groups of motions; the motions of a group begin together, and a group begins when the one
    /// before has ended for all.
    Groups(Vec<Vec<Motion>>),
    /// A list of motions for each robot; they begin together and then go on, each for itself.
    Streams(Vec<Vec<Motion>>),
    /// Let time pass, s.
    Wait(f64),
    /// Carry an object.
    Carry {
        /// Its way.
        tight: Tight,
        /// The joints of its robots at the beginning, in the order of the way's list.
        start: Vec<PerAxis<f64>>,
    },
    /// Stream a path.
    Path {
        /// Who, how fast, and when how much of that.
        step: PathStep,
        /// The path from where the tool will be.
        streamed: Arc<Streamed>,
    },
    /// Choose a servo law.
    Servo(usize, ServoLaw),
    /// Switch the spindle of a robot.
    Spindle(usize, bool),
}

/// A step with its work.
#[derive(Clone, Debug, PartialEq)]
pub struct Planned {
    /// Its name.
    pub name: String,
    /// What is done.
    pub work: Work,
}

/// A task, planned.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The steps in their order.
    pub steps: Vec<Planned>,
    /// Where the robots will be at the end.
    pub end: Vec<Place>,
}

/// Why a task cannot be run from where the robots are.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanError {
    /// The file, if there is one.
    pub path: Option<PathBuf>,
    /// The line, from 1; 0 if unknown.
    pub line: u32,
    /// The name of the step.
    pub step: Box<str>,
    /// The robot.
    pub robot: Box<str>,
    /// Why.
    pub why: Box<Why>,
}

/// What is wrong.
#[derive(Clone, Debug, PartialEq)]
pub enum Why {
    /// The robot must be homed for this.
    NotHomed,
    /// Outside its limits or its reach, at the goal or at a share of the way.
    Kinematics {
        /// The share of the way, 1 = the goal.
        share: f64,
        /// Why.
        error: KinematicError,
    },
    /// The tool is asked for more than the robot's node takes.
    Speed {
        /// Of what, with its unit.
        what: &'static str,
        /// How much was asked for.
        asked: f64,
        /// How much there is.
        most: f64,
    },
    /// The carry cannot be.
    Carry(Box<Failure>),
    /// An element of a path cannot be.
    Element {
        /// Its number, from 1.
        number: usize,
        /// Why.
        fault: PathFault,
    },
    /// On the way to a point of a path the robot is outside its limits or its reach.
    Point {
        /// Its number, from 1.
        number: usize,
        /// Why.
        error: KinematicError,
    },
}

impl PlanError {
    /// The exit code of a program that ends with this: nothing moved.
    #[must_use]
    pub const fn exit_code(&self) -> u8 {
        11
    }
}

impl fmt::Display for PlanError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.path {
            Some(path) => write!(f, "{}:{}: error: ", path.display(), self.line)?,
            None if self.line > 0 => write!(f, "line {}: error: ", self.line)?,
            None => write!(f, "step \"{}\": error: ", self.step)?,
        }
        match &*self.why {
            Why::NotHomed => write!(
                f,
                "{} is not homed (expected a step `home` before, or a relative motion of motors)",
                self.robot
            ),
            Why::Kinematics { share, error } if *share >= 1.0 => {
                write!(f, "{}: the goal: {error}", self.robot)
            }
            Why::Kinematics { share, error } => {
                write!(
                    f,
                    "{}: at {:.0} % of the way: {error}",
                    self.robot,
                    100.0 * share
                )
            }
            Why::Speed { what, asked, most } => write!(
                f,
                "{}: {what} of the tool out of range (expected at most {most}, got {asked})",
                self.robot
            ),
            Why::Carry(failure) => failure.fmt(f),
            Why::Element { number, fault } => {
                write!(f, "{}: point {number} of the path: {fault}", self.robot)
            }
            Why::Point { number, error } => {
                write!(f, "{}: to point {number} of the path: {error}", self.robot)
            }
        }
    }
}

impl std::error::Error for PlanError {}

impl Plan {
    /// Walks through a task from where the robots are. `path` is the task's file, for messages.
    ///
    /// # Errors
    /// The first motion that cannot be.
    pub fn new(
        task: &Task,
        path: Option<&Path>,
        config: &Config,
        places: Vec<Place>,
    ) -> Result<Self, PlanError> {
        let mut walk = Walk {
            config,
            path,
            places,
        };
        let mut steps = Vec::new();
        for step in &task.steps {
            steps.extend(walk.step(step)?);
        }
        Ok(Self {
            steps,
            end: walk.places,
        })
    }
}

struct Walk<'a> {
    config: &'a Config,
    path: Option<&'a Path>,
    places: Vec<Place>,
}

/// Where in a file something stands.
struct Source<'a> {
    path: Option<&'a Path>,
    line: u32,
    step: &'a Step,
}

impl Walk<'_> {
    /// An engraving: its paths, and what is done between them.
    fn engrave(
        &mut self,
        engrave: &Engrave,
        source: &Source<'_>,
    ) -> Result<Vec<Planned>, PlanError> {
        let mut planned = Vec::new();
        for section in &engrave.sections {
            let (what, work) = match section {
                Section::Path(path) => {
                    let streamed = Arc::new(self.path(path, source)?);
                    let step = path.clone();
                    ("path", Work::Path { step, streamed })
                }
                Section::Spindle(true) => ("spindle on", Work::Spindle(engrave.robot, true)),
                Section::Spindle(false) => ("spindle off", Work::Spindle(engrave.robot, false)),
                Section::Dwell(seconds) => ("dwell", Work::Wait(*seconds)),
            };
            let name = format!("{}: {what}", source.step.name);
            planned.push(Planned { name, work });
        }
        Ok(planned)
    }

    /// A step as it is planned: itself, or the parts of an engraving.
    fn step(&mut self, step: &Step) -> Result<Vec<Planned>, PlanError> {
        let source = Source {
            path: self.path,
            line: step.line,
            step,
        };
        let work = match &step.action {
            Action::Home { robots } => {
                for robot in robots {
                    if let Some(place) = self.places.get_mut(*robot)
                        && let Some(config) = self.config.robots.get(*robot)
                        && !place.homed
                    {
                        place.home(config.arm);
                    }
                }
                Work::Home(robots.clone())
            }
            Action::Replay {
                replays,
                coordination,
            } => {
                let mut lists = Vec::new();
                for replay in replays {
                    let mut motions = Vec::new();
                    for node in &replay.trajectory.nodes {
                        let instruction = replay.trajectory.instruction(node);
                        let path = Some(replay.path.as_path());
                        let at = Source {
                            path,
                            line: node.line,
                            step,
                        };
                        motions.push(self.motion(replay.robot, instruction, &at)?);
                    }
                    lists.push(motions);
                }
                match coordination {
                    Coordination::None => Work::Streams(lists),
                    Coordination::Loose => Work::Groups(transposed(lists)),
                }
            }
            Action::Move { moves } => {
                let mut group = Vec::new();
                for one in moves {
                    group.push(self.motion(one.robot, one.instruction(), &source)?);
                }
                Work::Groups(vec![group])
            }
            Action::Wait { seconds } => Work::Wait(*seconds),
            Action::Tight(tight) => {
                let start = self.carry(tight, &source)?;
                Work::Carry {
                    tight: tight.clone(),
                    start,
                }
            }
            Action::Path(path) => Work::Path {
                streamed: Arc::new(self.path(path, &source)?),
                step: path.clone(),
            },
            Action::Regulator { robot, law } => Work::Servo(*robot, *law),
            Action::Engrave(engrave) => return self.engrave(engrave, &source),
        };
        let name = step.name.clone();
        Ok(vec![Planned { name, work }])
    }

    fn path(&mut self, step: &PathStep, source: &Source<'_>) -> Result<Streamed, PlanError> {
        let robot = step.robot;
        let pair = self
            .config
            .robots
            .get(robot)
            .zip(self.places.get_mut(robot));
        let Some((config, place)) = pair else {
            return Err(error(source, "", Why::NotHomed));
        };
        walk::follow(config, place, step).map_err(|why| {
            let number = match &why {
                Why::Element { number, .. } | Why::Point { number, .. } => *number,
                Why::NotHomed | Why::Kinematics { .. } | Why::Speed { .. } | Why::Carry(_) => 0,
            };
            // a point stands in the file of the path, or in the task
            let mark = number.checked_sub(1).and_then(|k| step.path.marks.get(k));
            let at = Source {
                path: match mark {
                    Some(_) => step.path.file.as_deref().or(source.path),
                    None => source.path,
                },
                line: mark.map_or(source.line, |mark| mark.line),
                step: source.step,
            };
            error(&at, &config.name, why)
        })
    }

    fn motion(
        &mut self,
        robot: usize,
        instruction: Instruction,
        source: &Source<'_>,
    ) -> Result<Motion, PlanError> {
        let pair = self
            .config
            .robots
            .get(robot)
            .zip(self.places.get_mut(robot));
        let Some((config, place)) = pair else {
            return Err(error(source, "", Why::NotHomed));
        };
        let whole = walk::whole(&instruction);
        let segment = walk::walk(config, place, whole.as_ref().unwrap_or(&instruction))
            .map_err(|why| error(source, &config.name, why))?;
        place.guessed |= matches!(instruction, Instruction::MoveUntilForce { .. });
        Ok(Motion {
            robot,
            instruction,
            // what begins nobody knows where is not to be compared with anything
            segment: if place.guessed {
                Segment::None
            } else {
                segment
            },
        })
    }

    fn carry(
        &mut self,
        tight: &Tight,
        source: &Source<'_>,
    ) -> Result<Vec<PerAxis<f64>>, PlanError> {
        let mut carried = Vec::new();
        for robot in &tight.robots {
            let pair = self.config.robots.get(*robot).zip(self.places.get(*robot));
            let Some((config, place)) = pair else {
                continue;
            };
            let failed = |why| error(source, &config.name, why);
            if !place.homed {
                return Err(failed(Why::NotHomed));
            }
            let one = config
                .arm
                .joints(&place.motors)
                .and_then(|joints| Carried::new(*robot, config, joints))
                .map_err(|error| failed(Why::Kinematics { share: 0.0, error }))?;
            carried.push(one);
        }
        let names = source.step.name.as_str();
        let course = Course::new(tight.clone(), carried).map_err(|e| {
            error(
                source,
                names,
                Why::Kinematics {
                    share: 0.0,
                    error: e,
                },
            )
        })?;
        let grid = Grid::new(&self.config.timing);
        let ends = course
            .check(grid, 0.0)
            .map_err(|failure| error(source, names, Why::Carry(Box::new(failure))))?;
        for (carried, joints) in course.robots().iter().zip(ends) {
            let pair = self
                .config
                .robots
                .get(carried.robot)
                .zip(self.places.get_mut(carried.robot));
            if let Some((config, place)) = pair {
                place.motors = config.arm.motors(&joints).map_err(|e| {
                    error(
                        source,
                        &config.name,
                        Why::Kinematics {
                            share: 1.0,
                            error: e,
                        },
                    )
                })?;
            }
        }
        Ok(course
            .robots()
            .iter()
            .map(|c| c.joints().iter().copied().collect())
            .collect())
    }
}

fn error(source: &Source<'_>, robot: &str, why: Why) -> PlanError {
    PlanError {
        path: source.path.map(Path::to_path_buf),
        line: source.line,
        step: source.step.name.as_str().into(),
        robot: robot.into(),
        why: Box::new(why),
    }
}

fn transposed(lists: Vec<Vec<Motion>>) -> Vec<Vec<Motion>> {
    let nodes = lists.iter().map(Vec::len).max().unwrap_or(0);
    let mut groups: Vec<Vec<Motion>> = (0..nodes).map(|_| Vec::new()).collect();
    for list in lists {
        for (group, motion) in groups.iter_mut().zip(list) {
            group.push(motion);
        }
    }
    groups
}
