//! `mrroc plan cad`: what is in a program of a machine tool, or in a drawing.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use host::cad::place::{Placement, ZRule};
use host::cad::{Format, Options, Program, Summary};
use host::error::Error;
use host::input::Files;
use serde::Serialize;

use super::error::PlanError;
use crate::jsonl::write_line;

const EXAMPLE: &str = "\
Example:
  mrroc plan cad flowsnake.ngc --unit in --fit 0.2,0.2 --margin 0.01 --depth 0.0002

Lengths of the program are those before it is scaled; its time is that of programmed feeds alone.";

/// What is in a program (.ngc, .nc, .gcode, .tap) or a drawing (.dxf, .svg)
///
/// Goes through all of it, as before anything moves: what is not understood is an error with its line and
/// column.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLE)]
pub(super) struct Cad {
    /// The file.
    file: PathBuf,
    #[command(flatten)]
    on_board: OnBoard,
    /// Print the summary as one JSON value.
    #[arg(long)]
    json: bool,
}

/// Where a program or drawing is, and how large
#[derive(Args, Debug)]
pub(super) struct OnBoard {
    /// Fit the cuts into a board of width, height (m), and centre them; never enlarge them.
    #[arg(long, value_name = "W,H", value_delimiter = ',', value_parser = length)]
    fit: Vec<f64>,
    /// What stays free along the edges of the board, m.
    #[arg(long, value_name = "M", default_value = "0", value_parser = length, requires = "fit")]
    margin: f64,
    /// Enlarge what is smaller than the board.
    #[arg(long, requires = "fit")]
    enlarge: bool,
    /// Times as large, about the program's origin.
    #[arg(long, value_name = "FACTOR", value_parser = positive, conflicts_with = "fit")]
    scale: Option<f64>,
    /// Depth of the deepest cut, m; without it z is scaled as x and y.
    #[arg(long, value_name = "M", value_parser = positive)]
    depth: Option<f64>,
    /// z of the surface in the program, m.
    #[arg(long, value_name = "M", default_value = "0", allow_negative_numbers = true, value_parser = crate::commands::finite)]
    surface: f64,
    /// How far the tool may pass by corners where the program does not say, m.
    #[arg(long, value_name = "M", default_value = "0.00002", value_parser = length)]
    tolerance: f64,
    /// Speed of every cut, m/s, instead of what the file says.
    #[arg(long, value_name = "M_S", value_parser = crate::commands::feed)]
    cut_feed: Option<f64>,
    /// The unit until the file says its own.
    #[arg(long, value_name = "UNIT", default_value = "mm")]
    unit: Unit,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Unit {
    Mm,
    In,
}

fn positive(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok();
    let good = number.filter(|number| *number > 0.0 && *number <= 1e6);
    good.ok_or_else(|| "a number greater than 0, at most 1e6".to_owned())
}

fn length(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok();
    let good = number.filter(|number| (0.0..=100.0).contains(number));
    good.ok_or_else(|| "a number of metres from 0 to 100".to_owned())
}

impl OnBoard {
    /// The program of a file of these formats; none if it is of another.
    pub(super) fn program(&self, file: &Path) -> Result<Option<Program>, PlanError> {
        if Format::of(file).is_none() {
            return Ok(None);
        }
        let program =
            Program::open(file, &Files::on_disk(), &self.options()?).map_err(Error::from)?;
        Ok(Some(program))
    }

    fn options(&self) -> Result<Options, PlanError> {
        let placement = match self.fit.as_slice() {
            [] => Placement::Scale(self.scale.unwrap_or(1.0)),
            [width, height] => {
                let free = |edge: &f64| *edge > 2.0 * self.margin;
                if !(free(width) && free(height)) {
                    let why = "--fit: the margins leave nothing of the board";
                    return Err(PlanError::Usage(why.to_owned()));
                }
                Placement::Fit {
                    board_m: [*width, *height],
                    margin_m: self.margin,
                    enlarge: self.enlarge,
                }
            }
            other => {
                let why = format!("--fit: width and height (got {} numbers)", other.len());
                return Err(PlanError::Usage(why));
            }
        };
        Ok(Options {
            unit_m: match self.unit {
                Unit::Mm => 1e-3,
                Unit::In => 0.0254,
            },
            placement,
            z: self.depth.map_or(ZRule::AsPlane, ZRule::Depth),
            surface_m: self.surface,
            tolerance_m: self.tolerance,
            cut_m_s: self.cut_feed,
            ..Options::default()
        })
    }
}

/// The JSON of a program.
#[derive(Debug, Serialize)]
struct CadAnswer<'a> {
    file: String,
    sections: usize,
    #[serde(flatten)]
    summary: &'a Summary,
}

impl Cad {
    pub(super) fn run(self, out: &mut dyn Write) -> Result<(), PlanError> {
        let program = Program::open(&self.file, &Files::on_disk(), &self.on_board.options()?)
            .map_err(Error::from)?;
        let answer = CadAnswer {
            file: self.file.display().to_string(),
            sections: program.sections().count(),
            summary: program.summary(),
        };
        if self.json {
            write_line(out, &answer)?;
        } else {
            table(out, &answer)?;
        }
        Ok(())
    }
}

fn table(out: &mut dyn Write, answer: &CadAnswer<'_>) -> io::Result<()> {
    let s = answer.summary;
    writeln!(out, "{}", answer.file)?;
    if let Some(unit) = s.unit {
        let name = if unit.metres > 1e-3 { "inch" } else { "mm" };
        let said = if unit.said {
            "the program's"
        } else {
            "assumed"
        };
        writeln!(out, "{} lines executed, unit {name} ({said})", s.blocks)?;
    }
    writeln!(
        out,
        "cuts: {} lines, {} arcs, {} splines, {:.4} m; {} other moves, {:.4} m",
        s.lines, s.arcs, s.splines, s.cut_m, s.rapids, s.rapid_m
    )?;
    writeln!(
        out,
        "{} sections; {} actions, {} of them stops, {:.2} s of dwell, spindle up to {:.0} rev/min",
        answer.sections,
        s.actions,
        s.stops,
        s.dwell_s,
        60.0 * s.spindle_rev_s
    )?;
    let [slow, fast] = s.feed_m_s;
    writeln!(
        out,
        "feeds {slow:.5} to {fast:.5} m/s, {:.1} s at them",
        s.estimate_s
    )?;
    for (name, extent) in [("program", &s.cuts), ("board", &s.on_board)] {
        let pair = |k: usize| {
            let end = |ends: &[f64; 3]| ends.get(k).copied().unwrap_or_default();
            format!(
                "{:.5} to {:.5}",
                end(&extent.least_m),
                end(&extent.greatest_m)
            )
        };
        writeln!(
            out,
            "{name:<8} x {}, y {}, z {} m",
            pair(0),
            pair(1),
            pair(2)
        )?;
    }
    let [x, y, z] = s.place.offset_m;
    writeln!(
        out,
        "scale {:.6}, of z {:.6}; then {x:.5}, {y:.5}, {z:.5} m are added",
        s.place.scale, s.place.z_scale
    )?;
    for ignored in &s.ignored {
        writeln!(out, "without effect: {}", ignored.what)?;
    }
    Ok(())
}
