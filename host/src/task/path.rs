//! The step `path`, and paths written in TOML.
//!
//! ```toml
//! path = { robot = "irp6-track", file = "rose.csv", feed_m_s = 0.05, relative_to = "start" }
//! ```
//!
//! Instead of a `file` (points in `.csv`, see [`crate::path::csv`], or the list below in `.toml`)
//! there may be `elements`, each from where the one before ends:
//!
//! ```toml
//! elements = [
//!     { line = { position_m = [0.1, 0, 0] } },
//!     { line = { position_m = [0.1, 0.1, 0] }, corner_m = 0.005, corner_rad = 0.1 },
//!     { arc = { via_m = [0.05, 0.15, 0], to = { position_m = [0, 0.1, 0] } } },
//!     { through = { position_m = [0, 0.05, 0.02] } },
//! ]
//! ```
//!
//! A corner is rounded within `corner_m` and `corner_rad`; without them the tool rests in it. `overrides`
//! change the feed at times counted from the beginning of the path: `[[2.0, 0.0], [3.0, 1.0]]`.

use super::cell::Cell;
use super::document::{Document, Fields, Value};
use super::step::{robot, together};
use crate::cad;
use crate::input::{DataError, Files, LoadError, Problem, position, shown};
use crate::path::{Goal, MOST_POINTS, Mark, Reference, SHARP, ToolPath, Way, csv};
use protocol::message::{Corner, PoseSpeeds};
use std::path::Path;
use std::sync::Arc;

/// A path of one robot.
#[derive(Clone, Debug, PartialEq)]
pub struct PathStep {
    /// Index in [`Cell::robots`].
    pub robot: usize,
    /// The path, as written.
    pub path: Arc<ToolPath>,
    /// What its coordinates are relative to.
    pub reference: Reference,
    /// How fast at most.
    pub speeds: PoseSpeeds,
    /// When (s after the path began) the feed becomes which share (-1 to 1) of the programmed one; in
    /// the order of time, and at last going on.
    pub overrides: Vec<(f64, f64)>,
}

/// Speeds of a path whose task says nothing: m/s, rad/s, m/s², rad/s².
const SPEEDS: [f64; 4] = [0.05, 0.5, 0.5, 2.0];
/// The greatest that can be asked for, of any of them: the ceilings of `.trj` files.
pub(super) const MOST_SPEED: f64 = 5.0;
/// The rounding of orientation where only that of position is given, rad.
const CORNER_RAD: f64 = 0.1;
/// The latest override of a path, s.
const LATEST_S: f64 = 3600.0;

impl PathStep {
    /// A path at a feed, m/s, or as a task that says nothing of it.
    #[must_use]
    pub fn new(robot: usize, path: ToolPath, reference: Reference, feed_m_s: Option<f64>) -> Self {
        let [feed, angular, acceleration, angular_acceleration] = SPEEDS;
        Self {
            robot,
            path: Arc::new(path),
            reference,
            speeds: speeds([
                feed_m_s.unwrap_or(feed),
                angular,
                acceleration,
                angular_acceleration,
            ]),
            overrides: Vec::new(),
        }
    }
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "speeds and tolerances travel as f32; 24 bits are enough"
)]
const fn narrow(value: f64) -> f32 {
    value as f32
}

pub(super) const fn speeds([v, w, a, b]: [f64; 4]) -> PoseSpeeds {
    PoseSpeeds {
        velocity_m_s: narrow(v),
        angular_velocity_rad_s: narrow(w),
        acceleration_m_s2: narrow(a),
        angular_acceleration_rad_s2: narrow(b),
    }
}

/// Reads a path file: `.csv`, `.toml`, or a program or drawing of [`cad`], as large as it says and within 20 µm.
///
/// # Errors
/// The file cannot be read, or the first mistake in it.
pub fn load(path: &Path, files: &Files) -> Result<ToolPath, LoadError> {
    let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    if cad::Format::of(path).is_some() {
        let program = cad::Program::open(path, files, &cad::Options::default())?;
        return Ok(program.tool_path(path)?);
    }
    if ending.as_deref() == Some("csv") {
        return csv::load(path, files);
    }
    let read = Document::load(path, files, |document| {
        let table = document.parse()?;
        let noun = "a path";
        let fields = Fields::new(document, 0..0, table.get_ref(), noun, &["elements"])?;
        elements(document, &fields.required("elements")?)
    })?;
    Ok(ToolPath {
        file: Some(path.to_path_buf()),
        ..read
    })
}

pub(super) fn read(
    document: &Document<'_>,
    cell: &Cell,
    value: &Value<'_, '_>,
) -> Result<PathStep, DataError> {
    let fields = value.fields(
        "a path",
        &[
            "robot",
            "file",
            "elements",
            "relative_to",
            "feed_m_s",
            "angular_rad_s",
            "acceleration_m_s2",
            "angular_acceleration_rad_s2",
            "overrides",
        ],
    )?;
    let robot = robot(cell, &fields.required("robot")?)?;
    let (key, source) = fields.exactly_one(&["file", "elements"])?;
    let path = if key == "file" {
        from_file(document, &source)?
    } else {
        elements(document, &source)?
    };
    let reference = match fields.optional("relative_to") {
        Some(value) => value.choice(
            "reference",
            &[("base", Reference::Base), ("start", Reference::Start)],
        )?,
        None => Reference::Base,
    };
    let mut fast = SPEEDS;
    let keys = [
        "feed_m_s",
        "angular_rad_s",
        "acceleration_m_s2",
        "angular_acceleration_rad_s2",
    ];
    for (speed, key) in fast.iter_mut().zip(keys) {
        if let Some(value) = fields.optional(key) {
            *speed = value.number("greater than 0, at most 5", |v| v > 0.0 && v <= MOST_SPEED)?;
        }
    }
    Ok(PathStep {
        speeds: speeds(fast),
        overrides: match fields.optional("overrides") {
            Some(value) => overrides(&value)?,
            None => Vec::new(),
        },
        ..PathStep::new(robot, path, reference, None)
    })
}

fn from_file(document: &Document<'_>, value: &Value<'_, '_>) -> Result<ToolPath, DataError> {
    load(&document.resolve(value.text()?), document.files).map_err(|error| match error {
        LoadError::Data(error) => error,
        LoadError::Input(error) => value.error(
            Problem::Unreadable,
            "cannot read the path",
            "a .csv, .toml, .ngc, .dxf or .svg file",
            error.to_string(),
        ),
    })
}

fn elements(document: &Document<'_>, value: &Value<'_, '_>) -> Result<ToolPath, DataError> {
    let list = value.list()?;
    if list.is_empty() || list.len() > MOST_POINTS {
        return Err(value.error(
            Problem::WrongCount,
            "wrong number of elements of a path",
            format!("1 to {MOST_POINTS}"),
            list.len().to_string(),
        ));
    }
    let marks = list.iter().map(|value| element(document, value));
    Ok(ToolPath {
        file: None,
        marks: marks.collect::<Result<_, _>>()?,
    })
}

fn element(document: &Document<'_>, value: &Value<'_, '_>) -> Result<Mark, DataError> {
    let known = ["through", "line", "arc", "corner_m", "corner_rad"];
    let fields = value.fields("an element of a path", &known)?;
    let (key, what) = fields.exactly_one(&["through", "line", "arc"])?;
    let corner = corner(&fields)?;
    let (way, to) = match key {
        "through" => {
            for key in ["corner_m", "corner_rad"] {
                if let Some(stray) = fields.optional(key) {
                    return Err(stray.error(
                        Problem::Conflict,
                        "a corner of a smooth curve",
                        "an element `line` or `arc`",
                        "`through`",
                    ));
                }
            }
            (Way::Through, goal(&what)?)
        }
        "line" => (Way::Line { corner }, goal(&what)?),
        _ => {
            let arc = what.fields("an arc", &["via_m", "to"])?;
            let via_m = arc.required("via_m")?.triple()?;
            (Way::Arc { via_m, corner }, goal(&arc.required("to")?)?)
        }
    };
    Ok(Mark {
        line: position(document.text, fields.span.start).0,
        way,
        to,
        feed_m_s: None,
    })
}

fn corner(fields: &Fields<'_, '_>) -> Result<Corner, DataError> {
    let Some(metres) = fields.optional("corner_m") else {
        together(fields, "corner_rad", "corner_m")?;
        return Ok(SHARP);
    };
    let metres = metres.number("0 to 1", |m| (0.0..=1.0).contains(&m))?;
    let radians = match fields.optional("corner_rad") {
        Some(value) => value.number("0 to 1", |r| (0.0..=1.0).contains(&r))?,
        None => CORNER_RAD,
    };
    Ok(Corner {
        metres: narrow(metres),
        radians: narrow(radians),
    })
}

fn goal(value: &Value<'_, '_>) -> Result<Goal, DataError> {
    let fields = value.fields("a goal", &["position_m", "rotation_rad"])?;
    let rotation = fields.optional("rotation_rad");
    Ok(Goal {
        position_m: fields.required("position_m")?.triple()?,
        rotation_rad: rotation.map(|value| value.triple()).transpose()?,
    })
}

fn overrides(value: &Value<'_, '_>) -> Result<Vec<(f64, f64)>, DataError> {
    let mut overrides: Vec<(f64, f64)> = Vec::new();
    for entry in value.list()? {
        let pair = entry.list()?;
        let [time, share] = pair.as_slice() else {
            return Err(entry.error(
                Problem::WrongCount,
                "an override",
                "[time in s, share]",
                format!("{} values", pair.len()),
            ));
        };
        let earlier = overrides.last().map_or(-1.0, |(time, _)| *time);
        let time = time.number("0 to 3600, later than the one before", |t| {
            (0.0..=LATEST_S).contains(&t) && t > earlier
        })?;
        let share = share.number("-1 to 1", |share| (-1.0..=1.0).contains(&share))?;
        overrides.push((time, share));
    }
    match overrides.last() {
        Some((_, share)) if *share <= 0.0 => Err(value.error(
            Problem::OutOfRange,
            "overrides after which the path never ends",
            "a last share above 0",
            shown(&share.to_string()),
        )),
        _ => Ok(overrides),
    }
}

#[cfg(test)]
mod test;
