//! Taught trajectories in the `.trj` format of MRROC++.
//!
//! ```text
//! JOINT                  MOTOR | JOINT | XYZ_ANGLE_AXIS | XYZ_EULER_ZYZ
//! 2                      nodes
//! ABSOLUTE               ABSOLUTE | RELATIVE; may be left out: ABSOLUTE
//!
//! 0.1 0.1 0.1 0.1 0.1 0.1        velocity      fractions (0, 1] of the ceilings below
//! 0.05 0.05 0.05 0.05 0.05 0.05  acceleration  likewise
//! 0 -1.57 0 1.56 1.57 -1.57      coordinates   rad, m; x y z and orientation for XYZ_…
//! …                              two more lines … per node; blank lines anywhere
//! ```
//!
//! Older files give five lines a node: the velocities at its start and at its end come first. They
//! are recognised by a first line of zeros (the robot starts from rest) and enough lines for it.
//!
//! The format and its reading are those of MRROC++ (`generator_tester`, `rcsc`, `draughts`): only
//! the declared number of nodes is run, and columns beyond the robot's axes, which moved the
//! gripper when it still was an axis of the arm, are skipped. Both are said in a [`Warning`].

use crate::input::{DataError, Files, LoadError, MAX_LINE_BYTES, Problem, shown};
use motion::pose::{Pose, exp};
use nalgebra::Vector3;
use std::fmt;
use std::path::Path;

#[cfg(test)]
mod test;

/// The most columns any file has: MRROC++'s `MAX_SERVOS`.
pub const MAX_COLUMNS: usize = 8;

/// What is wrong with a trajectory file, and where.
pub type TrjError = DataError;

/// The space in which nodes are given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Space {
    /// Motor-shaft angles, rad.
    Motor,
    /// Joint positions, rad or m.
    Joint,
    /// Position of the tool in m and rotation vector (axis · angle) in rad.
    XyzAngleAxis,
    /// Position of the tool in m and Euler angles Z, Y', Z'' in rad.
    XyzEulerZyz,
}

impl Space {
    /// Every space.
    pub const ALL: [Self; 4] = [
        Self::Motor,
        Self::Joint,
        Self::XyzAngleAxis,
        Self::XyzEulerZyz,
    ];

    /// The keyword.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Motor => "MOTOR",
            Self::Joint => "JOINT",
            Self::XyzAngleAxis => "XYZ_ANGLE_AXIS",
            Self::XyzEulerZyz => "XYZ_EULER_ZYZ",
        }
    }

    /// Values per line for a robot of so many axes.
    #[must_use]
    pub const fn width(self, axes: usize) -> usize {
        match self {
            Self::Motor | Self::Joint => axes,
            Self::XyzAngleAxis | Self::XyzEulerZyz => 6,
        }
    }

    /// What the fraction 1 of a velocity line means: rad/s of the motor shaft, rad/s or m/s of a
    /// joint, m/s and rad/s of the tool (MRROC++ `ecp_g_newsmooth`).
    #[must_use]
    pub const fn velocity_ceiling(self) -> f64 {
        match self {
            Self::Motor => 200.0,
            Self::Joint => 1.5,
            Self::XyzAngleAxis | Self::XyzEulerZyz => 5.0,
        }
    }

    /// What the fraction 1 of an acceleration line means, per second² (MRROC++ `ecp_g_newsmooth`).
    #[must_use]
    pub const fn acceleration_ceiling(self) -> f64 {
        match self {
            Self::Motor => 150.0,
            Self::Joint => 7.0,
            Self::XyzAngleAxis | Self::XyzEulerZyz => 5.0,
        }
    }
}

/// What the coordinates are measured from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reference {
    /// The zero of the axes, or the base frame.
    Absolute,
    /// Where the robot is when the node begins; for poses, the tool frame at that moment.
    Relative,
}

/// One taught location and the way to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Fractions (0, 1] of [`Space::velocity_ceiling`], one per coordinate.
    pub velocity: Vec<f64>,
    /// Fractions (0, 1] of [`Space::acceleration_ceiling`], one per coordinate.
    pub acceleration: Vec<f64>,
    /// The location: rad and m, as [`Space`] says.
    pub coordinates: Vec<f64>,
    /// The line of the coordinates, from 1.
    pub line: u32,
}

/// Something skipped that the writer of the file should know of.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Warning {
    /// Columns beyond the robot's axes were skipped.
    ExtraColumns {
        /// The first such line, from 1.
        line: u32,
        /// How many columns the robot has.
        used: usize,
        /// How many columns the widest line has.
        found: usize,
    },
    /// Nodes beyond the declared count were skipped.
    ExtraNodes {
        /// The first such line, from 1.
        line: u32,
        /// Nodes declared and run.
        declared: usize,
        /// Nodes in the file.
        found: usize,
    },
    /// An old five-line node passes its ends at a velocity; here the robot rests there.
    PassingVelocity {
        /// The line, from 1.
        line: u32,
    },
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ExtraColumns { line, used, found } if *found == used + 1 => write!(
                f,
                "line {line}: column {found} skipped, the robot has {used} (a gripper is a robot of its own)"
            ),
            Self::ExtraColumns { line, used, found } => write!(
                f,
                "line {line}: columns {} to {found} skipped, the robot has {used} (a gripper is a robot of its own)",
                used + 1
            ),
            Self::ExtraNodes {
                line,
                declared,
                found,
            } => write!(
                f,
                "line {line}: {} of {found} nodes skipped, {declared} declared",
                found - declared
            ),
            Self::PassingVelocity { line } => write!(
                f,
                "line {line}: velocity at the ends of a node ignored, the robot rests at every node"
            ),
        }
    }
}

/// A taught trajectory: what a `.trj` file says for a robot of known axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory {
    /// The space of every node.
    pub space: Space,
    /// What the nodes are relative to.
    pub reference: Reference,
    /// The declared nodes, at least one.
    pub nodes: Vec<Node>,
    /// What was skipped.
    pub warnings: Vec<Warning>,
}

impl Trajectory {
    /// The pose a node of an `XYZ_…` trajectory names: `t_base_tool`, or the increment
    /// `t_tool_goal` if relative; nothing for axes.
    #[must_use]
    pub fn pose(&self, node: &Node) -> Option<Pose> {
        let [x, y, z, a, b, c] = <[f64; 6]>::try_from(node.coordinates.as_slice()).ok()?;
        let position = Vector3::new(x, y, z);
        match self.space {
            Space::Motor | Space::Joint => None,
            Space::XyzAngleAxis => {
                Some(Pose::from_rotation_vector(position, Vector3::new(a, b, c)))
            }
            Space::XyzEulerZyz => Some(Pose {
                position,
                rotation: exp(Vector3::z() * a) * exp(Vector3::y() * b) * exp(Vector3::z() * c),
            }),
        }
    }
}

/// Reads a trajectory file for a robot of so many axes.
///
/// # Errors
/// As [`parse`], and a file that cannot be read.
pub fn load(path: &Path, files: &Files, axes: usize) -> Result<Trajectory, LoadError> {
    let text = files.read(path)?;
    Ok(parse(&text, axes).map_err(|error| error.in_file(path))?)
}

/// Reads a trajectory for a robot of so many axes.
///
/// # Errors
/// Where the text is not as the module describes: the first mistake, with line and column.
pub fn parse(text: &str, axes: usize) -> Result<Trajectory, TrjError> {
    let rows = rows(text)?;
    let end = u32::try_from(text.lines().count())
        .unwrap_or(u32::MAX)
        .max(1);
    let mut header = Header::new(&rows, end);
    let space = header.space()?;
    let declared = header.count()?;
    let reference = header.reference()?;
    let rows = header.body()?;
    Body {
        rows,
        width: space.width(axes),
        end,
        declared,
        warnings: Vec::new(),
    }
    .read(space, reference)
}

/// A line that says something.
struct Row<'a> {
    line: u32,
    tokens: Vec<Token<'a>>,
}

#[derive(Clone, Copy)]
struct Token<'a> {
    line: u32,
    column: u32,
    text: &'a str,
}

impl Token<'_> {
    fn error(&self, problem: Problem, what: String, expected: impl Into<String>) -> TrjError {
        error_at(
            self.line,
            self.column,
            problem,
            what,
            expected,
            shown(self.text),
        )
    }
}

fn error_at(
    line: u32,
    column: u32,
    problem: Problem,
    what: impl Into<String>,
    expected: impl Into<String>,
    got: impl Into<String>,
) -> TrjError {
    DataError::at((line, column), problem, what, expected, got)
}

fn rows(text: &str) -> Result<Vec<Row<'_>>, TrjError> {
    let mut rows = Vec::new();
    for (line, content) in (1u32..).zip(text.lines()) {
        if content.len() > MAX_LINE_BYTES {
            return Err(error_at(
                line,
                1,
                Problem::TooLong,
                "line too long",
                format!("at most {MAX_LINE_BYTES} bytes"),
                format!("{} bytes", content.len()),
            ));
        }
        let mut column = 1u32;
        let mut tokens = Vec::new();
        for piece in content.split_inclusive(char::is_whitespace) {
            let text = piece.trim_end();
            if !text.is_empty() {
                tokens.push(Token { line, column, text });
            }
            column += u32::try_from(piece.chars().count()).unwrap_or(u32::MAX);
        }
        if !tokens.is_empty() {
            rows.push(Row { line, tokens });
        }
    }
    Ok(rows)
}

mod body;
mod header;
use body::Body;
use header::Header;
