//! `mrroc kin`: the robots' kinematics, one case by flags or, with `--jsonl`, a line a case.
//!
//! Every answer is one JSON object on one line. Joints are in the robot's axis order, rad or m;
//! motors rad of the shaft, 0 where homing ends; poses are those of the flange (of the default tool
//! with `--frame tool`) in the robot's base frame, rotations by rows.
//!
//! ```text
//!   fk        {"joints":[…]}                              → {"position_m":[…],"rotation":[[…],[…],[…]]}
//!   ik        {"position_m":[…],"rotation":[…],"near":[…]} → {"branches":[[…],…],"nearest":[…]}
//!   motors    {"joints":[…]}                              → {"motors":[…]}
//!   joints    {"motors":[…]}                              → {"joints":[…]}
//!   jacobian  {"joints":[…]}                              → {"jacobian":[six rows]}
//!   without an answer                                     → {"error":"limit"|"unreachable"|…,…}
//! ```
//!
//! A line that cannot be read is answered with `{"error":"malformed",…}` and the rest is still done.

mod case;
mod error;
#[cfg(test)]
mod test;

use std::io::{BufRead, Write};

use clap::{Args, Subcommand, ValueEnum};
use motion::Pose;
use robots::{Joints, KinematicError, Motors, Robot, RobotKind, RobotVisitor, TrackRule};
use serde::de::DeserializeOwned;

use crate::jsonl::{each_line, write_line};
use case::{Answer, JointsCase, MotorsCase, PoseCase};
pub(crate) use error::KinError;

/// Kinematics of a robot: poses, joints, motors
#[derive(Debug, Args)]
pub(crate) struct Kin {
    #[command(subcommand)]
    question: Question,
}

#[derive(Debug, Subcommand)]
enum Question {
    /// Forward: the pose of joint positions
    Fk {
        #[command(flatten)]
        asked: Asked<JointsCase>,
        /// Which frame's pose to give
        #[arg(long, value_enum, default_value_t = Frame::Flange)]
        frame: Frame,
    },
    /// Inverse: every configuration that reaches a pose, and the one nearest to `--near`
    Ik {
        #[command(flatten)]
        asked: Asked<PoseFlags>,
        /// Which frame the pose is of
        #[arg(long, value_enum, default_value_t = Frame::Flange)]
        frame: Frame,
    },
    /// Motor angles of joint positions
    Motors(Asked<JointsCase>),
    /// Joint positions of motor angles
    Joints(Asked<MotorsCase>),
    /// Geometric Jacobian of the flange in the base frame: linear rows, then angular rows
    Jacobian(Asked<JointsCase>),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Frame {
    /// Where the tool is bolted on
    Flange,
    /// The tip of the robot's default tool
    Tool,
}

/// A robot, and one case of it by flags or a line a case.
#[derive(Debug, Args)]
struct Asked<C: Args> {
    /// The robot's name, such as irp6-track
    robot: String,
    /// Read a JSON object a line from stdin, write one a line to stdout
    #[arg(long)]
    jsonl: bool,
    #[command(flatten)]
    case: C,
}

#[derive(Debug, Args)]
#[group(conflicts_with = "jsonl")]
struct PoseFlags {
    /// x,y,z of the frame's origin, m
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true)]
    position: Vec<f64>,
    /// The nine entries of the rotation matrix, row by row
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true)]
    rotation: Vec<f64>,
    /// Where the robot is, rad or m: picks the nearest branch and the track's position
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true)]
    near: Vec<f64>,
}

/// A case without an answer.
#[derive(Debug)]
enum Refusal {
    /// It does not fit the robot: what was expected and what was given.
    Shape(String),
    Kinematic(KinematicError),
}

impl From<KinematicError> for Refusal {
    fn from(error: KinematicError) -> Self {
        Self::Kinematic(error)
    }
}

impl Kin {
    /// Answers the case of the flags, or every line of `input`.
    ///
    /// # Errors
    /// [`KinError`]; lines without an answer are answers, lines that cannot be read are reported
    /// after the last one.
    pub(crate) fn run(self, out: &mut dyn Write, input: &mut dyn BufRead) -> Result<(), KinError> {
        let (Question::Fk {
            asked: Asked { robot, .. },
            ..
        }
        | Question::Ik {
            asked: Asked { robot, .. },
            ..
        }
        | Question::Motors(Asked { robot, .. })
        | Question::Joints(Asked { robot, .. })
        | Question::Jacobian(Asked { robot, .. })) = &self.question;
        let kind =
            RobotKind::from_name(robot).map_err(|error| KinError::Usage(error.to_string()))?;
        let question = self.question;
        kind.visit(
            TrackRule::Keep,
            Answering {
                question,
                out,
                input,
            },
        )
    }
}

/// Answers a question about a robot.
struct Answering<'a> {
    question: Question,
    out: &'a mut dyn Write,
    input: &'a mut dyn BufRead,
}

impl RobotVisitor for Answering<'_> {
    type Output = Result<(), KinError>;

    fn visit<R: Robot<N>, const N: usize>(self, robot: R) -> Self::Output {
        self.question.answer(&robot, self.out, self.input)
    }
}

impl Question {
    fn answer<const N: usize>(
        self,
        robot: &impl Robot<N>,
        out: &mut dyn Write,
        input: &mut dyn BufRead,
    ) -> Result<(), KinError> {
        match self {
            Self::Fk { asked, frame } => {
                by_joints(asked, robot, out, input, |q| Ok(forward(robot, q, frame)))
            }
            Self::Motors(asked) => by_joints(asked, robot, out, input, |q| {
                Ok(Answer::Motors {
                    motors: robot.motors(q)?.0.to_vec(),
                })
            }),
            Self::Jacobian(asked) => by_joints(asked, robot, out, input, |q| {
                let jacobian = robot.jacobian(q);
                let rows = jacobian.row_iter().map(|row| row.iter().copied().collect());
                Ok(Answer::Jacobian {
                    jacobian: rows.collect(),
                })
            }),
            Self::Joints(Asked { jsonl, case, .. }) => {
                let case = Some(case).filter(|case| !case.motors.is_empty());
                serve(jsonl, case, "--motors", out, input, |case: &MotorsCase| {
                    let motors = Motors(counted("motors", robot, &case.motors)?);
                    Ok(Answer::Joints {
                        joints: robot.joints(&motors)?.0.to_vec(),
                    })
                })
            }
            Self::Ik { asked, frame } => {
                let case = asked.case.case()?;
                let flags = "--position, --rotation and --near";
                serve(asked.jsonl, case, flags, out, input, |case: &PoseCase| {
                    inverse(robot, case, frame)
                })
            }
        }
    }
}

fn by_joints<const N: usize>(
    asked: Asked<JointsCase>,
    robot: &impl Robot<N>,
    out: &mut dyn Write,
    input: &mut dyn BufRead,
    answer: impl Fn(&Joints<N>) -> Result<Answer, KinematicError>,
) -> Result<(), KinError> {
    let case = Some(asked.case).filter(|case| !case.joints.is_empty());
    serve(
        asked.jsonl,
        case,
        "--joints",
        out,
        input,
        |case: &JointsCase| {
            let joints = counted("joints", robot, &case.joints)?;
            if joints.iter().all(|q| q.is_finite()) {
                Ok(answer(&Joints(joints))?)
            } else {
                Err(Refusal::Kinematic(KinematicError::NotFinite))
            }
        },
    )
}

fn forward<const N: usize>(robot: &impl Robot<N>, joints: &Joints<N>, frame: Frame) -> Answer {
    let flange = robot.forward(joints);
    let pose = match frame {
        Frame::Flange => flange,
        Frame::Tool => flange * robot.description().default_tool(),
    };
    Answer::Pose {
        position_m: pose.position.into(),
        // columns of the transpose are rows
        rotation: pose.rotation.transpose().into(),
    }
}

fn inverse<const N: usize>(
    robot: &impl Robot<N>,
    case: &PoseCase,
    frame: Frame,
) -> Result<Answer, Refusal> {
    let near = Joints(counted("near", robot, &case.near)?);
    let by_columns: [[f64; 3]; 3] = case.rotation;
    let mut pose = Pose {
        position: case.position_m.into(),
        rotation: by_columns.into(),
    };
    pose.rotation.transpose_mut();
    let flange = match frame {
        Frame::Flange => pose,
        Frame::Tool => pose * robot.description().default_tool().inverse(),
    };
    let found = robot.inverse(&flange, &near)?;
    Ok(Answer::Inverse {
        branches: found.branches().iter().map(|q| q.0.to_vec()).collect(),
        nearest: found.nearest().0.to_vec(),
    })
}

/// The numbers of `key`, when there is one for every axis.
fn counted<const N: usize>(
    key: &str,
    robot: &impl Robot<N>,
    numbers: &[f64],
) -> Result<[f64; N], Refusal> {
    numbers.try_into().map_err(|_| {
        let name = robot.description().name;
        Refusal::Shape(format!(
            "{key} of {name}: expected {N} numbers, got {}",
            numbers.len()
        ))
    })
}

impl PoseFlags {
    /// The case they say, if any of them was given.
    fn case(self) -> Result<Option<PoseCase>, KinError> {
        let Self {
            position,
            rotation,
            near,
        } = self;
        if position.is_empty() && rotation.is_empty() && near.is_empty() {
            return Ok(None);
        }
        let wrong = |flag: &str, expected: usize, got: usize| {
            KinError::Usage(format!("{flag}: expected {expected} numbers, got {got}"))
        };
        let position_m = position
            .as_slice()
            .try_into()
            .map_err(|_| wrong("--position", 3, position.len()))?;
        let entries: [f64; 9] = rotation
            .as_slice()
            .try_into()
            .map_err(|_| wrong("--rotation", 9, rotation.len()))?;
        let [a, b, c, d, e, f, g, h, i] = entries;
        Ok(Some(PoseCase {
            position_m,
            rotation: [[a, b, c], [d, e, f], [g, h, i]],
            near,
        }))
    }
}

/// Answers the case of the flags, or with `--jsonl` every line of `input`.
fn serve<C: DeserializeOwned>(
    jsonl: bool,
    case: Option<C>,
    flags: &str,
    out: &mut dyn Write,
    input: &mut dyn BufRead,
    answer: impl Fn(&C) -> Result<Answer, Refusal>,
) -> Result<(), KinError> {
    if jsonl {
        each_line(out, input, |line| {
            let case = serde_json::from_slice(line).map_err(|error| error.to_string())?;
            answer(&case).or_else(|refusal| match refusal {
                Refusal::Shape(what) => Err(what),
                Refusal::Kinematic(error) => Ok(Answer::from(&error)),
            })
        })?;
        return Ok(());
    }
    let case = case.ok_or_else(|| KinError::Usage(format!("expected {flags}, or --jsonl")))?;
    match answer(&case) {
        Ok(found) => Ok(write_line(out, &found)?),
        Err(Refusal::Shape(text)) => Err(KinError::Usage(text)),
        Err(Refusal::Kinematic(error)) => {
            write_line(out, &Answer::from(&error))?;
            Err(KinError::NoAnswer(error))
        }
    }
}
