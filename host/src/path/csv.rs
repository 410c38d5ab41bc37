//! Points of a path as text, a line each.
//!
//! ```text
//! x,y,z,rx,ry,rz              may be left out; the names of the columns in this order
//! # anything after a # is no number
//! 0.90, 0.10, 0.30, 0, 3.14159, 0     position of the tool, m; its rotation vector, rad
//! 0.91, 0.10, 0.30, 0, 3.14159, 0     …
//!
//! 0.91, 0.20, 0.30, 0, 3.14159, 0     a blank line: the next run of points begins
//! ```
//!
//! Within a run the tool goes through the points on a smooth curve. It gets to the first point of every
//! run on a straight line, and rests at both its ends; a run that begins where the one before ended makes
//! a corner. Without the last three columns the
//! orientation stays as it is where the path begins. A line that holds only a comment is not blank.

use super::{Goal, MAX_BYTES, MOST_POINTS, Mark, SHARP, ToolPath, Way};
use crate::input::{DataError, Files, LoadError, MAX_LINE_BYTES, Problem, shown};
use std::path::Path;

/// The columns.
const NAMES: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];
/// The least a path has.
const LEAST_POINTS: usize = 2;

/// Reads a path file.
///
/// # Errors
/// As [`parse`], and a file that cannot be read.
pub fn load(path: &Path, files: &Files) -> Result<ToolPath, LoadError> {
    let text = files.read_up_to(path, MAX_BYTES)?;
    let read = parse(&text).map_err(|error| error.in_file(path))?;
    Ok(ToolPath {
        file: Some(path.to_path_buf()),
        ..read
    })
}

/// Reads the points of a path.
///
/// # Errors
/// Where the text is not as the module describes: the first mistake, with line and column.
pub fn parse(text: &str) -> Result<ToolPath, DataError> {
    let mut marks: Vec<Mark> = Vec::new();
    let mut width = None;
    let mut begins = true;
    let mut end = 1;
    for (line, content) in (1_u32..).zip(text.lines()) {
        end = line;
        if content.len() > MAX_LINE_BYTES {
            return Err(DataError::at(
                (line, 1),
                Problem::TooLong,
                "line too long",
                format!("at most {MAX_LINE_BYTES} bytes"),
                format!("{} bytes", content.len()),
            ));
        }
        if content.trim().is_empty() {
            begins = true;
            continue;
        }
        let said = content.split('#').next().unwrap_or_default();
        if said.trim().is_empty() {
            continue;
        }
        let cells = cells(said);
        if let Some(header) = header(line, &cells)? {
            if width.is_some() {
                return Err(DataError::at(
                    (line, 1),
                    Problem::Conflict,
                    "names of columns below the first line",
                    "numbers",
                    shown(said.trim()),
                ));
            }
            width = Some(header);
            continue;
        }
        let to = goal(line, &cells, &mut width)?;
        if marks.len() == MOST_POINTS {
            return Err(DataError::at(
                (line, 1),
                Problem::WrongCount,
                "too many points",
                format!("at most {MOST_POINTS}"),
                "more",
            ));
        }
        let way = if core::mem::take(&mut begins) {
            Way::Line { corner: SHARP }
        } else {
            Way::Through
        };
        marks.push(Mark {
            line,
            way,
            to,
            feed_m_s: None,
        });
    }
    if marks.len() < LEAST_POINTS {
        return Err(DataError::at(
            (end, 1),
            Problem::WrongCount,
            "too few points for a path",
            format!("at least {LEAST_POINTS}"),
            marks.len().to_string(),
        ));
    }
    Ok(ToolPath { file: None, marks })
}

/// What stands between commas, with its column.
fn cells(said: &str) -> Vec<(u32, &str)> {
    let mut column = 1;
    let mut cells = Vec::new();
    for piece in said.split(',') {
        let blank = piece.chars().take_while(|c| c.is_whitespace()).count();
        let before = u32::try_from(blank).unwrap_or(u32::MAX);
        cells.push((column + before, piece.trim()));
        column += u32::try_from(piece.chars().count() + 1).unwrap_or(u32::MAX);
    }
    cells
}

/// The number of columns that a header names; none if this is no header.
fn header(line: u32, cells: &[(u32, &str)]) -> Result<Option<usize>, DataError> {
    let named = |(_, text): &(u32, &str)| text.parse::<f64>().is_err() && is_name(text);
    if !cells.first().is_some_and(named) {
        return Ok(None);
    }
    for ((column, text), name) in cells.iter().zip(NAMES) {
        if *text != name {
            return Err(DataError::at(
                (line, *column),
                Problem::UnknownName,
                "wrong name of a column",
                format!("`{name}`"),
                shown(text),
            ));
        }
    }
    count(line, cells, None)?;
    Ok(Some(cells.len()))
}

fn is_name(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|b| b.is_ascii_alphabetic())
}

/// Are there as many cells as there must be?
fn count(line: u32, cells: &[(u32, &str)], width: Option<usize>) -> Result<(), DataError> {
    let (good, expected) = match width {
        Some(width) => (cells.len() == width, format!("{width}, as above")),
        None => (
            matches!(cells.len(), 3 | 6),
            "3 (x,y,z) or 6 (x,y,z,rx,ry,rz)".to_owned(),
        ),
    };
    if good {
        return Ok(());
    }
    let most = width.unwrap_or(if cells.len() < 3 { 3 } else { 6 });
    let place = cells.get(most).or_else(|| cells.last());
    Err(DataError::at(
        (line, place.map_or(1, |(column, _)| *column)),
        Problem::WrongCount,
        "wrong number of columns",
        expected,
        cells.len().to_string(),
    ))
}

fn goal(line: u32, cells: &[(u32, &str)], width: &mut Option<usize>) -> Result<Goal, DataError> {
    let mut values = [0.0; NAMES.len()];
    count(line, cells, *width)?;
    for ((value, (column, text)), name) in values.iter_mut().zip(cells).zip(NAMES) {
        let wrong = |problem, what: &str| {
            let unit = if name.len() == 1 { "m" } else { "rad" };
            DataError::at(
                (line, *column),
                problem,
                format!("`{name}` {what}"),
                format!("a finite number of {unit}"),
                shown(text),
            )
        };
        *value = match text.parse::<f64>() {
            Ok(number) if number.is_finite() => number,
            Ok(_) => return Err(wrong(Problem::NotFinite, "is not finite")),
            Err(_) => return Err(wrong(Problem::WrongType, "is no number")),
        };
    }
    *width = Some(cells.len());
    let [x, y, z, rx, ry, rz] = values;
    Ok(Goal {
        position_m: [x, y, z],
        rotation_rad: (cells.len() == NAMES.len()).then_some([rx, ry, rz]),
    })
}
