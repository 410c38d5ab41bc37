//! `mrroc plan profile`: the shortest jerk-limited motion of axes between two states.

use std::io::{BufRead, Write};
use std::path::PathBuf;

use clap::Args;
use host::plot::{self, AxisMotion, MotionPlot, Picture};

use super::answer::Answer;
use super::case::{Case, Names};
use super::error::PlanError;
use super::motion::{Asked, Motion, NoMotion};
use super::{line, table};
use crate::jsonl::{each_line, write_line};

const EXAMPLES: &str = "\
Examples:
  mrroc plan profile --from 0 --to 1 --v-max 0.5 --a-max 1 --j-max 10
  mrroc plan profile --from 0,0.2 --from-velocity 0.4,-0.1 --to 1,-0.3 --v-max 1,1 --a-max 2,2 \\
      --j-max 10,10 --plot motion.svg
  mrroc plan profile --jsonl < cases.jsonl > motions.jsonl

A line of cases.jsonl: {\"p0\":[0],\"p1\":[1],\"v_max\":[0.5],\"a_max\":[1],\"j_max\":[10]}; keys that may be
left out: v0 a0 v1 a1 v_min a_min p_min p_max sync minimum_duration. Its answer: {\"duration_s\":2.6,
\"axes\":[[{\"t\":…,\"j\":…,\"a0\":…,\"v0\":…,\"p0\":…},…]]}, phases of constant jerk with the state where each
begins; or {\"error\":…,\"message\":…}.";

/// The shortest motion of 1 to 16 axes between two states, limited in velocity, acceleration and jerk
///
/// Positions are in any unit, velocities, accelerations and jerks in it per s, s² and s³. Every motion is
/// proved from its phases before it is told.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(super) struct Profile {
    #[command(flatten)]
    case: Case,
    /// Unit of positions in the table and in pictures
    #[arg(long, default_value = "rad")]
    unit: String,
    /// Draw the motion (.svg or .png); may be given several times
    #[arg(long, value_name = "FILE")]
    plot: Vec<PathBuf>,
    /// Print the motion as one JSON value
    #[arg(long)]
    json: bool,
    /// Read a JSON object a line from stdin, write one a line to stdout
    #[arg(long, conflicts_with_all = ["unit", "plot", "json"])]
    jsonl: bool,
}

impl Profile {
    /// Plans the case of the flags, or with `--jsonl` every line of `input`.
    pub(super) fn run(self, out: &mut dyn Write, input: &mut dyn BufRead) -> Result<(), PlanError> {
        if self.jsonl {
            return lines(out, input);
        }
        if self.case.is_empty() {
            let flags = "--from, --to, --v-max, --a-max and --j-max";
            return Err(PlanError::Usage(format!("expected {flags}, or --jsonl")));
        }
        let asked = self.case.asked(Names::Flags).map_err(PlanError::Usage)?;
        match plan(&asked, Names::Flags).map_err(PlanError::Usage)? {
            Ok(motion) => self.tell(out, &asked, &motion),
            Err(error) => {
                if self.json {
                    write_line(out, &Answer::from(&error))?;
                }
                Err(error.into())
            }
        }
    }

    fn tell(&self, out: &mut dyn Write, asked: &Asked, motion: &Motion) -> Result<(), PlanError> {
        if !self.plot.is_empty() {
            let picture = Picture::from(&self.drawn(asked, motion));
            for path in &self.plot {
                plot::save(&picture, path)?;
            }
        }
        if self.json {
            write_line(out, &Answer::from(motion))?;
        } else {
            table::write(out, asked, motion, &self.unit)?;
        }
        Ok(())
    }

    fn drawn(&self, asked: &Asked, motion: &Motion) -> MotionPlot {
        let each = (1..).zip(&motion.axes).zip(&asked.bounds);
        let axes = each.map(|((number, phases), bounds)| AxisMotion {
            name: format!("axis {number}"),
            phases: phases.clone(),
            bounds: *bounds,
        });
        MotionPlot {
            title: table::title(asked, motion),
            unit: self.unit.clone(),
            axes: axes.collect(),
        }
    }
}

/// The motion, or why there is none; the outer error is a number of axes that cannot be planned.
fn plan(asked: &Asked, names: Names) -> Result<Result<Motion, NoMotion>, String> {
    let planned = asked.plan();
    planned.ok_or_else(|| names.wrong_axes(asked.start.len()))
}

fn lines(out: &mut dyn Write, input: &mut dyn BufRead) -> Result<(), PlanError> {
    let mut unproved: Option<(usize, String)> = None;
    let answered = each_line(out, input, |line| {
        let asked = line::case(line)?.asked(Names::Keys)?;
        Ok(match plan(&asked, Names::Keys)? {
            Ok(motion) => Answer::from(&motion),
            Err(error) => {
                if let NoMotion::Unproved { .. } = error {
                    let (motions, what) = unproved.take().unwrap_or((0, error.to_string()));
                    unproved = Some((motions + 1, what));
                }
                Answer::from(&error)
            }
        })
    });
    match unproved {
        // an error of this program, beside which others count little
        Some((motions, what)) => Err(PlanError::Unproved { motions, what }),
        None => Ok(answered?),
    }
}
