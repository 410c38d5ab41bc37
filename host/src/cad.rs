//! Programs of machine tools and drawings, as paths of a robot.
//!
//! | module | one line |
//! |---|---|
//! | [`gcode`] | RS-274 with its parameters, subroutines and loops |
//! | [`dxf`], [`svg`] | drawings: their outlines, each to be engraved |
//! | [`outline`] | an outline as moves: above it, down, along it, up |
//! | [`step`], [`nurbs`] | what every reader makes of a file: moves and actions |
//! | [`place`] | where that is on the board, and how large |
//! | [`section`] | a program in paths and what is done between them |
//! | [`marks`] | a path as elements of a node |
//!
//! A [`Program`] is gone through twice: [`Program::open`] finds every mistake, the box that its cuts are
//! in, and what it takes; [`Program::sections`] makes elements of it as they are wanted. Of neither pass
//! anything is kept but the file's text (or a drawing's outlines), so that a short program may make
//! millions of moves.

pub mod dxf;
pub mod gcode;
pub mod marks;
pub mod nurbs;
pub mod outline;
pub mod place;
pub mod section;
mod smooth;
pub mod step;
mod summary;
pub mod svg;
#[cfg(test)]
mod test;

use crate::input::{DataError, Files, LoadError, Problem, shown};
use crate::path::{MOST_POINTS, Mark, ToolPath};
use gcode::Gcode;
use outline::{Engrave, Outline, Outlines};
use place::{Place, Placement, ZRule};
use section::{Sections, Work};
use std::path::Path;
use std::sync::Arc;
use step::Step;

pub use summary::{Summary, Unit};

/// The largest file, bytes.
pub const MAX_BYTES: u64 = 16_000_000;

/// The formats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// `.ngc`, `.nc`, `.gcode`, `.tap`
    Gcode,
    /// `.dxf`
    Dxf,
    /// `.svg`
    Svg,
}

impl Format {
    /// By the end of a name.
    #[must_use]
    pub fn of(path: &Path) -> Option<Self> {
        let ending = path.extension()?.to_string_lossy().to_lowercase();
        match &*ending {
            "ngc" | "nc" | "gcode" | "tap" => Some(Self::Gcode),
            "dxf" => Some(Self::Dxf),
            "svg" => Some(Self::Svg),
            _ => None,
        }
    }
}

/// What a task says of a program.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Metres in a unit, until the file says what its unit is.
    pub unit_m: f64,
    /// How large, and where.
    pub placement: Placement,
    /// How deep.
    pub z: ZRule,
    /// z of the surface of the board in the program, m.
    pub surface_m: f64,
    /// How near to the program the tool stays where that does not say, m.
    pub tolerance_m: f64,
    /// How near to arcs out of the plane and to splines it stays, m.
    pub curve_tolerance_m: f64,
    /// Speed of what does not cut, m/s.
    pub rapid_m_s: f64,
    /// Speed of every cut, m/s; absent: as the file says.
    pub cut_m_s: Option<f64>,
    /// How outlines are engraved.
    pub engrave: Engrave,
    /// Leave out lines that begin with `/`.
    pub block_delete: bool,
    /// The most lines that a program may execute.
    pub most_blocks: u64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            unit_m: 1e-3,
            placement: Placement::Scale(1.0),
            z: ZRule::AsPlane,
            surface_m: 0.0,
            tolerance_m: 2e-5,
            curve_tolerance_m: 1e-6,
            rapid_m_s: 0.1,
            cut_m_s: None,
            engrave: Engrave::default(),
            block_delete: true,
            most_blocks: 20_000_000,
        }
    }
}

/// A file that was gone through once, without an error.
#[derive(Clone, Debug)]
pub struct Program {
    source: Source,
    place: Place,
    options: Options,
    summary: Summary,
}

#[derive(Clone, Debug)]
enum Source {
    Gcode(Arc<Gcode>),
    Outlines(Arc<[Outline]>),
}

/// The steps of a program that runs, up to the first error.
#[derive(Clone, Debug)]
pub(crate) enum Steps {
    Gcode(Box<gcode::Run>),
    Outlines(Outlines),
}

impl Iterator for Steps {
    type Item = Result<Step, DataError>;

    fn next(&mut self) -> Option<Self::Item> {
        match self {
            Self::Gcode(run) => run.next(),
            Self::Outlines(outlines) => outlines.next().map(Ok),
        }
    }
}

impl Program {
    /// Reads a file of one of the formats, and goes through all of it.
    ///
    /// # Errors
    /// It cannot be read, or the first mistake in it.
    pub fn open(path: &Path, files: &Files, options: &Options) -> Result<Self, LoadError> {
        let Some(format) = Format::of(path) else {
            let ending = path.extension().unwrap_or_default().to_string_lossy();
            let what = "a file of another kind";
            let expected = ".ngc, .nc, .gcode, .tap, .dxf or .svg";
            let error = DataError::at((1, 1), Problem::UnknownName, what, expected, shown(&ending));
            return Err(error.in_file(path).into());
        };
        let text = files.read_up_to(path, MAX_BYTES)?;
        let program = Self::read(text, format, options);
        Ok(program.map_err(|error| error.in_file(path))?)
    }

    /// Goes through a program.
    ///
    /// # Errors
    /// The first mistake in it, a program that cuts nothing included.
    pub fn read(text: String, format: Format, options: &Options) -> Result<Self, DataError> {
        let mut options = *options;
        if format != Format::Gcode {
            // a drawing has no z: depth and clearance are the task's, as they are
            if let ZRule::Depth(depth) = options.z {
                options.engrave.depth_m = depth;
            }
            options.z = ZRule::Scale(1.0);
        }
        let options = &options;
        let source = match format {
            Format::Gcode => Source::Gcode(Arc::new(Gcode::new(
                text,
                options.unit_m,
                options.most_blocks,
                options.block_delete,
            )?)),
            Format::Dxf => Source::Outlines(dxf::read(&text, options.unit_m)?.into()),
            Format::Svg => Source::Outlines(svg::read(&text)?.into()),
        };
        let (mut summary, cuts) = Summary::of(source.steps(options), options)?;
        let place = Place::of(&cuts, options);
        summary.put(place, &cuts);
        Ok(Self {
            source,
            place,
            options: *options,
            summary,
        })
    }

    /// What was found.
    #[must_use]
    pub const fn summary(&self) -> &Summary {
        &self.summary
    }

    /// All of its paths as one, in the frame of the board, for a plan that needs it whole.
    ///
    /// # Errors
    /// More than [`MOST_POINTS`] elements.
    pub fn tool_path(&self, file: &Path) -> Result<ToolPath, DataError> {
        let paths = self.sections().filter_map(|section| match section.what {
            Work::Path(path) => Some(path.marks()),
            Work::Action(_) => None,
        });
        let mut marks: Vec<Mark> = Vec::new();
        for mark in paths.flatten() {
            if marks.len() == MOST_POINTS {
                let (what, expected) = (
                    "too many elements for a plan",
                    format!("at most {MOST_POINTS}"),
                );
                let problem = Problem::WrongCount;
                let error = DataError::at((mark.line, 1), problem, what, expected, "more");
                return Err(error.in_file(file));
            }
            marks.push(mark);
        }
        Ok(ToolPath {
            file: Some(file.to_path_buf()),
            marks,
        })
    }

    /// Its sections, in order.
    #[must_use]
    pub fn sections(&self) -> Sections {
        let steps = self.source.steps(&self.options);
        Sections::new(steps, self.place, self.options)
    }
}

impl Source {
    fn steps(&self, options: &Options) -> Steps {
        match self {
            Self::Gcode(program) => Steps::Gcode(Box::new(program.run())),
            Self::Outlines(outlines) => {
                Steps::Outlines(Outlines::new(outlines.clone(), options.engrave))
            }
        }
    }
}
