//! Pictures as SVG and as PNG: of a run (joints, following errors and tool paths), of a planned motion, of
//! curves over one quantity, of a board that was cut.
//!
//! [`PlotData`], [`MotionPlot`], [`CurvesPlot`] and [`BoardPicture`] say what to draw and know nothing of where it came from. They are
//! laid out once as a list of shapes, a [`Picture`]; SVG and PNG are two ways to write that list, so
//! they show the same. The PNG is drawn with a font that is part of this program: nothing need be
//! installed.

use crate::error::Error;
use std::path::Path;

mod board;
mod curves;
mod decimate;
mod drawing;
mod font;
mod layout;
mod motion;
mod panel;
mod png;
mod scale;
mod svg;
#[cfg(test)]
mod test;

pub use self::board::{BoardPicture, PathError, ProgrammedLine};
pub use self::curves::{CurveDiagram, CurvesPlot};
pub use self::motion::{AxisMotion, MotionPlot};

/// What to draw: one row of panels per robot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlotData {
    /// Above everything.
    pub title: String,
    /// One per robot.
    pub robots: Vec<RobotPlot>,
    /// Where the steps of the task begin.
    pub steps: Vec<StepMark>,
}

/// The beginning of a step.
#[derive(Clone, Debug, PartialEq)]
pub struct StepMark {
    /// When, s.
    pub time_s: f64,
    /// The step's name.
    pub name: String,
}

/// The series of one robot. Series may differ in length; what has no partner is left out, and so
/// are numbers that are not finite.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RobotPlot {
    /// Its name.
    pub name: String,
    /// When the samples were taken, s, not decreasing.
    pub time_s: Vec<f64>,
    /// One per axis.
    pub axes: Vec<AxisPlot>,
    /// Where the tool was to be, in the robot's base frame, m.
    pub tool_setpoint_m: Vec<[f64; 3]>,
    /// Where it was, m.
    pub tool_actual_m: Vec<[f64; 3]>,
}

/// The series of one axis, a value per sample.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AxisPlot {
    /// Its name, with its unit if that is not rad: `track [m]`.
    pub name: String,
    /// Set-points of the joint, rad or m.
    pub setpoint: Vec<f64>,
    /// Actual positions of the joint, rad or m.
    pub actual: Vec<f64>,
    /// Following error, rad of the motor shaft.
    pub following_error_rad: Vec<f64>,
}

/// A picture, laid out.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture(drawing::Drawing);

impl From<&PlotData> for Picture {
    fn from(data: &PlotData) -> Self {
        Self(layout::lay_out(data))
    }
}

impl From<&MotionPlot> for Picture {
    fn from(data: &MotionPlot) -> Self {
        Self(motion::lay_out(data))
    }
}

impl From<&CurvesPlot> for Picture {
    fn from(data: &CurvesPlot) -> Self {
        Self(curves::lay_out(data))
    }
}

impl From<&BoardPicture<'_>> for Picture {
    fn from(data: &BoardPicture<'_>) -> Self {
        Self(board::lay_out(data))
    }
}

/// The picture as SVG.
#[must_use]
pub fn svg(picture: &Picture) -> String {
    svg::write(&picture.0)
}

/// The picture as PNG.
///
/// # Errors
/// Memory for the picture cannot be had, or the font that is part of this program is damaged.
pub fn png(picture: &Picture) -> Result<Vec<u8>, Error> {
    png::write(&picture.0)
}

/// Writes the picture to a file that ends in `.svg` or `.png`; a picture that is there already is
/// replaced only by a complete one.
///
/// # Errors
/// Another ending, or the file cannot be written.
pub fn save(picture: &Picture, path: &Path) -> Result<(), Error> {
    let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    let bytes = match ending.as_deref() {
        Some("svg") => svg(picture).into_bytes(),
        Some("png") => png(picture)?,
        _ => return Err(unknown_ending(path)),
    };
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(".part");
    let part = path.with_file_name(name);
    std::fs::write(&part, bytes).map_err(|error| Error::create(path, error))?;
    std::fs::rename(&part, path).map_err(|error| {
        // the incomplete picture is of no use to anyone; that it stays is no second error
        drop(std::fs::remove_file(&part));
        Error::create(path, error)
    })
}

/// Is this a name [`save`] will take? For refusing a wrong one before anything moves.
///
/// # Errors
/// Another ending than `.svg` or `.png`.
pub fn check_name(path: &Path) -> Result<(), Error> {
    let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    match ending.as_deref() {
        Some("svg" | "png") => Ok(()),
        _ => Err(unknown_ending(path)),
    }
}

fn unknown_ending(path: &Path) -> Error {
    Error::Usage {
        what: "unknown kind of picture".into(),
        expected: "a name that ends in .svg or .png".into(),
        got: crate::input::shown(&path.to_string_lossy()),
    }
}
