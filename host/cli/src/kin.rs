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

use std::fmt;
use std::io::{self, BufRead, Write};

use clap::{Args, Subcommand, ValueEnum};
use motion::Pose;
use robots::{Irp6Postument, Irp6Track, Joints, KinematicError, Motors, Robot, RobotKind};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

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
        case: ByJoints,
        /// Which frame's pose to give
        #[arg(long, value_enum, default_value_t = Frame::Flange)]
        frame: Frame,
    },
    /// Inverse: every configuration that reaches a pose, and the one nearest to `--near`
    Ik {
        #[command(flatten)]
        case: ByPose,
        /// Which frame the pose is of
        #[arg(long, value_enum, default_value_t = Frame::Flange)]
        frame: Frame,
    },
    /// Motor angles of joint positions
    Motors(ByJoints),
    /// Joint positions of motor angles
    Joints(ByMotors),
    /// Geometric Jacobian of the flange in the base frame: linear rows, then angular rows
    Jacobian(ByJoints),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Frame {
    /// Where the tool is bolted on
    Flange,
    /// The tip of the robot's default tool
    Tool,
}

#[derive(Debug, Args)]
struct Common {
    /// The robot's name, such as irp6-track
    robot: String,
    /// Read a JSON object a line from stdin, write one a line to stdout
    #[arg(long)]
    jsonl: bool,
}

#[derive(Debug, Args)]
struct ByJoints {
    #[command(flatten)]
    common: Common,
    /// Joint positions, rad or m, separated by commas
    #[arg(
        long,
        value_delimiter = ',',
        allow_hyphen_values = true,
        conflicts_with = "jsonl"
    )]
    joints: Vec<f64>,
}

#[derive(Debug, Args)]
struct ByMotors {
    #[command(flatten)]
    common: Common,
    /// Motor angles, rad, separated by commas
    #[arg(
        long,
        value_delimiter = ',',
        allow_hyphen_values = true,
        conflicts_with = "jsonl"
    )]
    motors: Vec<f64>,
}

#[derive(Debug, Args)]
struct ByPose {
    #[command(flatten)]
    common: Common,
    /// x,y,z of the frame's origin, m
    #[arg(
        long,
        value_delimiter = ',',
        allow_hyphen_values = true,
        conflicts_with = "jsonl"
    )]
    position: Vec<f64>,
    /// The nine entries of the rotation matrix, row by row
    #[arg(
        long,
        value_delimiter = ',',
        allow_hyphen_values = true,
        conflicts_with = "jsonl"
    )]
    rotation: Vec<f64>,
    /// Where the robot is, rad or m: picks the nearest branch and the track's position
    #[arg(
        long,
        value_delimiter = ',',
        allow_hyphen_values = true,
        conflicts_with = "jsonl"
    )]
    near: Vec<f64>,
}

/// A case of `fk`, `motors` and `jacobian`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct JointsCase {
    joints: Vec<f64>,
}

/// A case of `joints`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct MotorsCase {
    motors: Vec<f64>,
}

/// A case of `ik`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct PoseCase {
    position_m: [f64; 3],
    /// By rows.
    rotation: [[f64; 3]; 3],
    near: Vec<f64>,
}

#[derive(Debug, Serialize)]
#[serde(untagged)]
enum Answer {
    Pose {
        position_m: [f64; 3],
        rotation: [[f64; 3]; 3],
    },
    Inverse {
        branches: Vec<Vec<f64>>,
        nearest: Vec<f64>,
    },
    Motors {
        motors: Vec<f64>,
    },
    Joints {
        joints: Vec<f64>,
    },
    Jacobian {
        jacobian: Vec<Vec<f64>>,
    },
    Limit {
        error: &'static str,
        quantity: &'static str,
        axis: usize,
        name: &'static str,
        value: f64,
        lower: f64,
        upper: f64,
    },
    None {
        error: &'static str,
        message: String,
    },
}

impl From<&KinematicError> for Answer {
    fn from(error: &KinematicError) -> Self {
        match *error {
            KinematicError::Limit {
                axis,
                name,
                quantity,
                value,
                lower,
                upper,
            } => Self::Limit {
                error: error.code(),
                quantity: quantity.name(),
                axis,
                name,
                value,
                lower,
                upper,
            },
            KinematicError::NotFinite
            | KinematicError::NotARotation { .. }
            | KinematicError::Unreachable
            | KinematicError::Singular => Self::None {
                error: error.code(),
                message: error.to_string(),
            },
        }
    }
}

/// Why `mrroc kin` failed.
#[derive(Debug)]
pub(crate) enum KinError {
    /// Flags are missing or have the wrong number of values.
    Usage(String),
    /// There is no such robot; the text lists those there are.
    UnknownRobot(String),
    /// Lines of stdin could not be read as cases.
    Malformed {
        /// How many.
        lines: usize,
        /// The first of them, counted from 1.
        first: usize,
        /// What was expected there and what was found.
        what: String,
    },
    /// The one case given by flags has no answer.
    NoAnswer(KinematicError),
    /// stdin or stdout failed.
    Stream(io::Error),
}

impl KinError {
    /// The process' exit code, after `sysexits`.
    pub(crate) fn exit_code(&self) -> u8 {
        match self {
            Self::Usage(_) => 64,
            Self::UnknownRobot(_) | Self::Malformed { .. } | Self::NoAnswer(_) => 65,
            Self::Stream(_) => 74,
        }
    }
}

impl fmt::Display for KinError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Usage(text) | Self::UnknownRobot(text) => f.write_str(text),
            Self::Malformed {
                lines: 1,
                first,
                what,
            } => write!(f, "line {first} of stdin: {what}"),
            Self::Malformed { lines, first, what } => {
                write!(
                    f,
                    "{lines} lines of stdin are malformed, the first is line {first}: {what}"
                )
            }
            Self::NoAnswer(error) => error.fmt(f),
            Self::Stream(error) => write!(f, "stdin or stdout: {error}"),
        }
    }
}

impl std::error::Error for KinError {}

impl From<io::Error> for KinError {
    fn from(error: io::Error) -> Self {
        Self::Stream(error)
    }
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
            case: ByJoints { common, .. },
            ..
        }
        | Question::Ik {
            case: ByPose { common, .. },
            ..
        }
        | Question::Motors(ByJoints { common, .. })
        | Question::Joints(ByMotors { common, .. })
        | Question::Jacobian(ByJoints { common, .. })) = &self.question;
        let kind = RobotKind::from_name(&common.robot)
            .map_err(|error| KinError::UnknownRobot(error.to_string()))?;
        match kind {
            RobotKind::Irp6Track => self.question.answer(&Irp6Track, out, input),
            RobotKind::Irp6Postument => self.question.answer(&Irp6Postument, out, input),
        }
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
            Self::Fk { case, frame } => {
                by_joints(case, robot, out, input, |q| Ok(forward(robot, q, frame)))
            }
            Self::Motors(case) => by_joints(case, robot, out, input, |q| {
                Ok(Answer::Motors {
                    motors: robot.motors(q)?.0.to_vec(),
                })
            }),
            Self::Jacobian(case) => by_joints(case, robot, out, input, |q| {
                let jacobian = robot.jacobian(q);
                let rows = jacobian.row_iter().map(|row| row.iter().copied().collect());
                Ok(Answer::Jacobian {
                    jacobian: rows.collect(),
                })
            }),
            Self::Joints(ByMotors { common, motors }) => {
                let case = Some(MotorsCase { motors }).filter(|case| !case.motors.is_empty());
                serve(
                    &common,
                    case,
                    "--motors",
                    out,
                    input,
                    |case: &MotorsCase| {
                        let motors = Motors(counted("motors", robot, &case.motors)?);
                        Ok(Answer::Joints {
                            joints: robot.joints(&motors)?.0.to_vec(),
                        })
                    },
                )
            }
            Self::Ik { case, frame } => {
                let ByPose {
                    common,
                    position,
                    rotation,
                    near,
                } = case;
                let given = !(position.is_empty() && rotation.is_empty() && near.is_empty());
                let case = given
                    .then(|| pose_of_flags(&position, &rotation, near))
                    .transpose()?;
                let flags = "--position, --rotation and --near";
                serve(&common, case, flags, out, input, |case: &PoseCase| {
                    inverse(robot, case, frame)
                })
            }
        }
    }
}

fn by_joints<const N: usize>(
    case: ByJoints,
    robot: &impl Robot<N>,
    out: &mut dyn Write,
    input: &mut dyn BufRead,
    answer: impl Fn(&Joints<N>) -> Result<Answer, KinematicError>,
) -> Result<(), KinError> {
    let ByJoints { common, joints } = case;
    let case = Some(JointsCase { joints }).filter(|case| !case.joints.is_empty());
    serve(
        &common,
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

fn pose_of_flags(position: &[f64], rotation: &[f64], near: Vec<f64>) -> Result<PoseCase, KinError> {
    let wrong = |flag: &str, expected: usize, got: usize| {
        KinError::Usage(format!("{flag}: expected {expected} numbers, got {got}"))
    };
    let position_m = position
        .try_into()
        .map_err(|_| wrong("--position", 3, position.len()))?;
    let entries: [f64; 9] = rotation
        .try_into()
        .map_err(|_| wrong("--rotation", 9, rotation.len()))?;
    let [a, b, c, d, e, f, g, h, i] = entries;
    Ok(PoseCase {
        position_m,
        rotation: [[a, b, c], [d, e, f], [g, h, i]],
        near,
    })
}

/// Answers the case of the flags, or with `--jsonl` every line of `input`.
fn serve<C: DeserializeOwned>(
    common: &Common,
    case: Option<C>,
    flags: &str,
    out: &mut dyn Write,
    input: &mut dyn BufRead,
    answer: impl Fn(&C) -> Result<Answer, Refusal>,
) -> Result<(), KinError> {
    if common.jsonl {
        return lines(out, input, answer);
    }
    let case = case.ok_or_else(|| KinError::Usage(format!("expected {flags}, or --jsonl")))?;
    match answer(&case) {
        Ok(found) => write_line(out, &found),
        Err(Refusal::Shape(text)) => Err(KinError::Usage(text)),
        Err(Refusal::Kinematic(error)) => {
            write_line(out, &Answer::from(&error))?;
            Err(KinError::NoAnswer(error))
        }
    }
}

fn lines<C: DeserializeOwned>(
    out: &mut dyn Write,
    input: &mut dyn BufRead,
    answer: impl Fn(&C) -> Result<Answer, Refusal>,
) -> Result<(), KinError> {
    let mut malformed: Option<(usize, usize, String)> = None;
    let mut line = Vec::new();
    for number in 1.. {
        line.clear();
        if input.read_until(b'\n', &mut line)? == 0 {
            break;
        }
        let refusal = match serde_json::from_slice(&line) {
            Ok(case) => answer(&case),
            Err(error) => Err(Refusal::Shape(error.to_string())),
        };
        let found = match refusal {
            Ok(found) => found,
            Err(Refusal::Kinematic(error)) => Answer::from(&error),
            Err(Refusal::Shape(what)) => {
                let (count, first, text) = malformed.unwrap_or((0, number, what.clone()));
                malformed = Some((count + 1, first, text));
                let message = format!("line {number} of stdin: {what}");
                Answer::None {
                    error: "malformed",
                    message,
                }
            }
        };
        write_line(out, &found)?;
    }
    out.flush()?;
    match malformed {
        Some((lines, first, what)) => Err(KinError::Malformed { lines, first, what }),
        None => Ok(()),
    }
}

fn write_line(out: &mut dyn Write, answer: &Answer) -> Result<(), KinError> {
    serde_json::to_writer(&mut *out, answer).map_err(io::Error::from)?;
    out.write_all(b"\n")?;
    Ok(())
}

#[cfg(test)]
mod test {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Shell {
        #[command(flatten)]
        kin: Kin,
    }

    fn kin(arguments: &str, stdin: &str) -> (String, Result<(), KinError>) {
        let shell = Shell::try_parse_from(format!("kin {arguments}").split_whitespace()).unwrap();
        let mut out = Vec::new();
        let result = shell.kin.run(&mut out, &mut stdin.as_bytes());
        (String::from_utf8(out).unwrap(), result)
    }

    fn numbers(value: &serde_json::Value) -> Vec<f64> {
        value
            .as_array()
            .unwrap()
            .iter()
            .map(|v| v.as_f64().unwrap())
            .collect()
    }

    const FRONT: &str = "0,-1.57,0,1.56,1.57,-1.57";

    #[test]
    fn forward_by_flags() {
        let (out, result) = kin(&format!("fk irp6-postument --joints {FRONT}"), "");
        result.unwrap();
        let pose: serde_json::Value = serde_json::from_str(&out).unwrap();
        let p = numbers(&pose["position_m"]);
        assert!((p[0] - 0.6723).abs() < 6e-5 && p[1].abs() < 6e-5 && (p[2] - 0.2645).abs() < 6e-5);
        // rows: the first holds the x of N, O and A, and A points along x
        assert!(
            (numbers(&pose["rotation"][0])[2] - 1.0).abs() < 1e-3,
            "{out}"
        );
        let (tool, _) = kin(
            &format!("fk irp6-postument --joints {FRONT} --frame tool"),
            "",
        );
        let tool: serde_json::Value = serde_json::from_str(&tool).unwrap();
        assert!((numbers(&tool["position_m"])[0] - p[0] - 0.25).abs() < 1e-3);
    }

    #[test]
    fn a_line_a_case_and_back() {
        for frame in ["flange", "tool"] {
            let q = r#"{"joints":[0.25,0.1,-1.4,0.1,0.9,1.2,0.3]}"#;
            let (pose, result) = kin(&format!("fk irp6-track --jsonl --frame {frame}"), q);
            result.unwrap();
            let near = r#","near":[0.25,0,-1.5,0,1,1,0]}"#;
            let case = format!("{}{near}\n", pose.trim_end().trim_end_matches('}'));
            let (out, result) = kin(
                &format!("ik irp6-track --jsonl --frame {frame}"),
                &case.repeat(2),
            );
            result.unwrap();
            assert_eq!(out.lines().count(), 2);
            let found: serde_json::Value =
                serde_json::from_str(out.lines().next().unwrap()).unwrap();
            let nearest = numbers(&found["nearest"]);
            for (got, expected) in nearest.iter().zip([0.25, 0.1, -1.4, 0.1, 0.9, 1.2, 0.3]) {
                assert!((got - expected).abs() < 1e-9, "{out}");
            }
            assert!(found["branches"].as_array().unwrap().len() >= 3);
        }
    }

    #[test]
    fn motors_and_joints() {
        let (out, _) = kin(&format!("motors irp6-postument --joints {FRONT}"), "");
        assert!(out.starts_with("{\"motors\":[-15.9,-4.86"), "{out}");
        let (out, _) = kin("joints irp6-postument --motors 0,0,0,0,0,0", "");
        assert!(out.starts_with("{\"joints\":[-0.1006"), "{out}");
        let (out, _) = kin(&format!("jacobian irp6-postument --joints {FRONT}"), "");
        let jacobian: serde_json::Value = serde_json::from_str(&out).unwrap();
        assert_eq!(jacobian["jacobian"].as_array().unwrap().len(), 6);
        assert_eq!(
            numbers(&jacobian["jacobian"][5])[0].to_bits(),
            1.0_f64.to_bits()
        );
    }

    #[test]
    fn a_case_without_an_answer_is_an_answer_on_a_line_and_an_error_by_flags() {
        let out_of_triangle = r#"{"motors":[0,-300,0,0,0,0]}"#;
        let (out, result) = kin("joints irp6-postument --jsonl", out_of_triangle);
        result.unwrap();
        assert!(
            out.starts_with(
                r#"{"error":"limit","quantity":"screw-length","axis":1,"name":"lower arm""#
            ),
            "{out}"
        );
        let (out, result) = kin("joints irp6-postument --motors 0,-300,0,0,0,0", "");
        assert!(out.contains("\"limit\""));
        assert_eq!(result.unwrap_err().exit_code(), 65);
        let far = r#"{"position_m":[9,0,0],"rotation":[[1,0,0],[0,1,0],[0,0,1]],"near":[0,-1.5,0,0,1,0]}"#;
        let (out, result) = kin("ik irp6-postument --jsonl", far);
        result.unwrap();
        assert!(out.starts_with(r#"{"error":"unreachable""#), "{out}");
    }

    #[test]
    fn malformed_lines_are_answered_counted_and_passed() {
        let good = r#"{"joints":[0,-1.57,0,1.56,1.57,-1.57]}"#;
        let stdin = format!(
            "{good}\n{{\"joints\":[1,2]}}\nnonsense\n\n{{\"joint\":[]}}\n\u{fffd}\n{good}\n"
        );
        let (out, result) = kin("fk irp6-postument --jsonl", &stdin);
        let lines: Vec<_> = out.lines().collect();
        assert_eq!(lines.len(), 7);
        assert_eq!(lines[0], lines[6]);
        for line in &lines[1..6] {
            assert!(
                line.starts_with(r#"{"error":"malformed","message":"line "#),
                "{line}"
            );
        }
        let error = result.unwrap_err();
        assert_eq!(error.exit_code(), 65);
        assert_eq!(
            error.to_string(),
            "5 lines of stdin are malformed, the first is line 2: \
             joints of irp6-postument: expected 6 numbers, got 2"
        );
    }

    #[test]
    fn wrong_use_says_what_was_expected() {
        let (out, result) = kin("fk irp7 --joints 1", "");
        let error = result.unwrap_err();
        assert_eq!((out.as_str(), error.exit_code()), ("", 65));
        assert_eq!(
            error.to_string(),
            "unknown robot \"irp7\"; known: irp6-track, irp6-postument"
        );
        for (arguments, text) in [
            (
                "fk irp6-track --joints 1,2",
                "joints of irp6-track: expected 7 numbers, got 2",
            ),
            ("fk irp6-track", "expected --joints, or --jsonl"),
            (
                "ik irp6-track --position 1,2",
                "--position: expected 3 numbers, got 2",
            ),
        ] {
            let (out, result) = kin(arguments, "");
            let error = result.unwrap_err();
            assert_eq!((out.as_str(), error.exit_code()), ("", 64));
            assert_eq!(error.to_string(), text);
        }
        let (_, result) = kin("fk irp6-postument --joints nan,0,0,0,0,0", "");
        assert_eq!(
            result.unwrap_err().to_string(),
            "a coordinate is not a finite number"
        );
    }
}
