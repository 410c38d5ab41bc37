//! The step `engrave`: a program or a drawing, on the board of the cell.
//!
//! ```toml
//! engrave = { robot = "rnt", file = "inscription.svg", depth_m = 6e-4, margin_m = 0.02 }
//! ```
//!
//! Files are `.ngc`, `.nc`, `.gcode`, `.tap`, `.dxf` and `.svg`. Without a `scale` the program is made as large as
//! the board admits within the margin, but not larger than it is unless `enlarge = true`. Drawings are engraved `depth_m` deep
//! at `cut_m_s`; a program has its own depths and feeds where the task says none. `surface_m` is the height of
//! the board's surface in the program.

use super::board::{Board, t_board_tool_rotation};
use super::cell::Cell;
use super::document::{Document, Fields, Value};
use super::path::{MOST_SPEED, speeds};
use super::step::robot;
use crate::cad::place::{Placement, ZRule};
use crate::cad::section::Work;
use crate::cad::step::Action;
use crate::cad::{Format, Options, Program, Summary};
use crate::input::{DataError, LoadError, Problem};
use crate::mp::arm::{Arm, arm};
use crate::path::{MOST_POINTS, Mark, Reference, ToolPath};
use crate::task::PathStep;
use std::path::Path;
use std::sync::Arc;

/// A program or drawing, placed on the board of the cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Engrave {
    /// Index in [`Cell::robots`].
    pub robot: usize,
    /// What is done, in order.
    pub sections: Vec<Section>,
    /// What the first pass found.
    pub summary: Arc<Summary>,
}

/// A part of it.
#[derive(Clone, Debug, PartialEq)]
pub enum Section {
    /// The tool moves.
    Path(PathStep),
    /// The spindle is switched on or off.
    Spindle(bool),
    /// Nothing, for so many seconds.
    Dwell(f64),
}

/// The spindle has reached its speed after so long, s.
const SPIN_UP_S: f64 = 1.0;
/// Accelerations along the path where the task says nothing: m/s², rad/s².
const ACCELERATIONS: [f64; 2] = [0.5, 2.0];
/// Greatest angular velocity of the tool, rad/s; it keeps its direction.
const ANGULAR: f64 = 0.5;

pub(super) fn read(
    document: &Document<'_>,
    cell: &Cell,
    value: &Value<'_, '_>,
) -> Result<Engrave, DataError> {
    let known = [
        "robot",
        "file",
        "depth_m",
        "margin_m",
        "scale",
        "enlarge",
        "surface_m",
        "cut_m_s",
        "plunge_m_s",
        "rapid_m_s",
        "clearance_m",
        "tolerance_m",
        "acceleration_m_s2",
    ];
    let fields = value.fields("an engraving", &known)?;
    let robot_value = fields.required("robot")?;
    let robot = robot(cell, &robot_value)?;
    let Some(board) = cell.board.filter(|board| board.robot == robot) else {
        return Err(robot_value.error(
            Problem::Conflict,
            "an engraving without a board",
            "a table `board` of the cell, for this robot",
            "none",
        ));
    };
    let (options, acceleration) = options(&fields, &board)?;
    let file_value = fields.required("file")?;
    let file = document.resolve(file_value.text()?);
    let program = Program::open(&file, document.files, &options).map_err(|error| match error {
        LoadError::Data(error) => error,
        LoadError::Input(error) => file_value.error(
            Problem::Unreadable,
            "cannot read the program",
            "a .ngc, .nc, .gcode, .tap, .dxf or .svg file",
            error.to_string(),
        ),
    })?;
    let [_, _, lowest] = program.summary().on_board.least_m;
    if -lowest > board.thickness_m {
        return Err(file_value.error(
            Problem::OutOfRange,
            "cuts deeper than the board is thick",
            format!("at most {} m, see depth_m and surface_m", board.thickness_m),
            format!("{:.4} m", -lowest),
        ));
    }
    let on_path = |marks| on_path(cell, robot, &options, acceleration, &file, marks);
    let mut sections = sections(&program, &board, &file)?
        .into_iter()
        .map(|part| match part {
            Part::Path(marks) => Section::Path(on_path(marks)),
            Part::Spindle(on) => Section::Spindle(on),
            Part::Dwell(seconds) => Section::Dwell(seconds),
        })
        .collect::<Vec<_>>();
    if Format::of(&file) != Some(Format::Gcode) {
        // a drawing says nothing of a spindle
        sections.insert(0, Section::Spindle(true));
    }
    if !matches!(sections.last(), Some(Section::Spindle(false))) {
        sections.push(Section::Spindle(false));
    }
    Ok(Engrave {
        robot,
        sections: spun_up(sections),
        summary: Arc::new(program.summary().clone()),
    })
}

/// How the program is read and placed, and the acceleration along its paths, m/s².
fn options(fields: &Fields<'_, '_>, board: &Board) -> Result<(Options, f64), DataError> {
    let number = |key, default: f64, least: f64, most: f64| match fields.optional(key) {
        Some(value) => value.number(&format!("{least} to {most}"), |x| {
            (least..=most).contains(&x)
        }),
        None => Ok(default),
    };
    let mut options = Options::default();
    let speed = |key, default| number(key, default, 1e-4, MOST_SPEED);
    options.rapid_m_s = speed("rapid_m_s", options.rapid_m_s)?;
    options.engrave.feed_m_s = speed("cut_m_s", options.engrave.feed_m_s)?;
    options.cut_m_s = fields.optional("cut_m_s").map(|_| options.engrave.feed_m_s);
    options.engrave.plunge_m_s = speed("plunge_m_s", options.engrave.plunge_m_s)?;
    options.engrave.clearance_m = number("clearance_m", options.engrave.clearance_m, 1e-4, 0.1)?;
    options.tolerance_m = number("tolerance_m", options.tolerance_m, 1e-6, 0.01)?;
    options.surface_m = number("surface_m", options.surface_m, -10.0, 10.0)?;
    if fields.optional("depth_m").is_some() {
        let deepest = board.thickness_m;
        options.z = ZRule::Depth(number("depth_m", 0.0, 1e-5, deepest)?);
    }
    options.placement = match fields.optional("scale") {
        Some(scale) => {
            Placement::Scale(scale.number("1e-6 to 1e6", |s| (1e-6..=1e6).contains(&s))?)
        }
        None => Placement::Fit {
            board_m: board.size_m,
            margin_m: number("margin_m", 0.0, 0.0, 1.0)?,
            enlarge: match fields.optional("enlarge") {
                Some(value) => value.boolean()?,
                None => false,
            },
        },
    };
    let acceleration = number("acceleration_m_s2", ACCELERATIONS[0], 1e-3, MOST_SPEED)?;
    Ok((options, acceleration))
}

/// A path as fast as asked, or as the robot's node takes it.
fn on_path(
    cell: &Cell,
    robot: usize,
    options: &Options,
    acceleration: f64,
    file: &Path,
    marks: Vec<Mark>,
) -> PathStep {
    let arm = cell.robots.get(robot).map(|spec| arm(spec.kind));
    let [v, a] = arm.map_or([MOST_SPEED; 2], Arm::tool_ceilings);
    let most = |asked: f64, limit: f64| if asked < limit { asked } else { limit };
    let path = ToolPath {
        file: Some(file.to_path_buf()),
        marks,
    };
    PathStep {
        speeds: speeds([
            most(options.rapid_m_s, v),
            most(ANGULAR, v),
            most(acceleration, a),
            most(ACCELERATIONS[1], a),
        ]),
        ..PathStep::new(robot, path, Reference::Base, None)
    }
}

enum Part {
    Path(Vec<Mark>),
    Spindle(bool),
    Dwell(f64),
}

/// The parts of a program in the robot's base frame. A stop for an operator is none here, and another tool
/// cannot be put in.
fn sections(program: &Program, board: &Board, file: &Path) -> Result<Vec<Part>, DataError> {
    let rotation = board.t_base_board * t_board_tool_rotation();
    let (mut parts, mut points) = (Vec::new(), 0);
    for section in program.sections() {
        let line = section.line;
        let refused = |what: &str, expected: String, got: &str| {
            DataError::at((line, 1), Problem::Conflict, what, expected, got).in_file(file)
        };
        match section.what {
            Work::Path(path) => {
                let marks: Vec<Mark> = path.on(board.t_base_board, rotation).marks().collect();
                points += marks.len();
                if points > MOST_POINTS {
                    let expected = format!("at most {MOST_POINTS}");
                    return Err(refused("too many elements for one step", expected, "more"));
                }
                parts.push(Part::Path(marks));
            }
            Work::Action(Action::Spindle { clockwise, .. }) => {
                parts.push(Part::Spindle(clockwise.is_some()));
            }
            Work::Action(Action::Dwell(seconds)) => parts.push(Part::Dwell(seconds)),
            Work::Action(Action::Stop { .. }) => {}
            Work::Action(Action::Tool(_)) => {
                if points > 0 {
                    let expected = "one tool for a program".to_owned();
                    return Err(refused("another tool in the middle", expected, "M6"));
                }
            }
        }
    }
    Ok(parts)
}

/// Wait for the spindle's speed where it is switched on; switch nothing that is switched already.
fn spun_up(sections: Vec<Section>) -> Vec<Section> {
    let (mut out, mut spins) = (Vec::new(), false);
    for section in sections {
        match section {
            Section::Spindle(on) if on == spins => {}
            Section::Spindle(on) => {
                spins = on;
                out.push(section);
                if on {
                    out.push(Section::Dwell(SPIN_UP_S));
                }
            }
            other => out.push(other),
        }
    }
    out
}
