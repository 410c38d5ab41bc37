//! The first pass: what a program is, and what it takes.

use super::place::{Extent, Place};
use super::step::{Action, Move, Shape, Speed, What};
use super::{Options, Steps};
use crate::input::{DataError, Problem};
use serde::Serialize;

/// Kinds of words without effect that are told.
const MOST_IGNORED: usize = 20;

/// The unit of length of a file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Unit {
    /// Metres in it.
    pub metres: f64,
    /// Does the file say so?
    pub said: bool,
}

/// What is in a program. Lengths are those of the program, before it is scaled.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Lines executed, repetitions counted; 0 of drawings.
    pub blocks: u64,
    /// Moves that do not cut.
    pub rapids: u64,
    /// Cuts along lines.
    pub lines: u64,
    /// Along arcs and helices.
    pub arcs: u64,
    /// Along splines.
    pub splines: u64,
    /// Starts and stops of the spindle, dwells, stops and tools.
    pub actions: u64,
    /// Length of all cuts, m.
    pub cut_m: f64,
    /// Of what does not cut, m.
    pub rapid_m: f64,
    /// The box that the cuts are in.
    pub cuts: Extent,
    /// The same box on the board.
    pub on_board: Extent,
    /// The last unit of length.
    pub unit: Option<Unit>,
    /// The least and the greatest feed, m/s.
    pub feed_m_s: [f64; 2],
    /// The greatest speed of the spindle, 1/s.
    pub spindle_rev_s: f64,
    /// Dwells, s.
    pub dwell_s: f64,
    /// Where the tool stands still for an operator, or to be changed.
    pub stops: u64,
    /// Cuts and the rest at programmed speeds, s: without acceleration, and z as scaled as x and y.
    pub estimate_s: f64,
    /// How the program is put on the board.
    pub place: Place,
    /// What has no effect here, with the line of its first time.
    pub ignored: Vec<Ignored>,
}

/// Words that have no effect here.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Ignored {
    /// The first time, in steps made before it.
    pub after_steps: u64,
    /// What.
    pub what: &'static str,
}

impl Summary {
    const fn new() -> Self {
        Self {
            blocks: 0,
            rapids: 0,
            lines: 0,
            arcs: 0,
            splines: 0,
            actions: 0,
            cut_m: 0.0,
            rapid_m: 0.0,
            cuts: Extent::EMPTY,
            on_board: Extent::EMPTY,
            unit: None,
            feed_m_s: [0.0; 2],
            spindle_rev_s: 0.0,
            dwell_s: 0.0,
            stops: 0,
            estimate_s: 0.0,
            place: Place {
                scale: 1.0,
                z_scale: 1.0,
                offset_m: [0.0; 3],
            },
            ignored: Vec::new(),
        }
    }

    /// Goes through a program.
    pub(super) fn of(mut steps: Steps, options: &Options) -> Result<(Self, Extent), DataError> {
        let mut this = Self::new();
        let mut cuts = Extent::EMPTY;
        let mut cutting_s = 0.0;
        // a program executes a bounded number of lines
        while let Some(step) = steps.next() {
            match step?.what {
                What::Move(made) => cutting_s += this.moved(&made, &mut cuts, options.cut_m_s),
                What::Action(action) => this.acted(action),
            }
            this.look(&mut steps);
        }
        this.look(&mut steps);
        if cuts.is_empty() {
            return Err(DataError::at(
                (1, 1),
                Problem::Missing,
                "a program that cuts nothing",
                "at least one cut",
                format!("{} moves without one", this.rapids),
            ));
        }
        this.estimate_s = cutting_s + this.rapid_m / options.rapid_m_s;
        Ok((this, cuts))
    }

    fn look(&mut self, steps: &mut Steps) {
        if let Steps::Gcode(run) = steps {
            self.blocks = run.executed();
            let (metres, said) = run.unit_m();
            self.unit = Some(Unit { metres, said });
            if let Some(what) = run.ignored()
                && self.ignored.len() < MOST_IGNORED
                && !self.ignored.iter().any(|known| known.what == what)
            {
                let after_steps =
                    self.rapids + self.lines + self.arcs + self.splines + self.actions;
                self.ignored.push(Ignored { after_steps, what });
            }
        }
    }

    /// A move, and the time that it takes if it cuts, s.
    fn moved(&mut self, made: &Move, cuts: &mut Extent, cut: Option<f64>) -> f64 {
        let length = made.length_m();
        let Speed::Feed(feed) = made.speed else {
            self.rapids += 1;
            self.rapid_m += length;
            return 0.0;
        };
        match made.shape {
            Shape::Line => self.lines += 1,
            Shape::Arc { .. } => self.arcs += 1,
            Shape::Nurbs(_) => self.splines += 1,
        }
        made.outline().for_each(|point| cuts.add(&point));
        self.cut_m += length;
        let [least, greatest] = &mut self.feed_m_s;
        if *least <= 0.0 || feed < *least {
            *least = feed;
        }
        if feed > *greatest {
            *greatest = feed;
        }
        let feed = cut.unwrap_or(feed);
        if feed > 0.0 { length / feed } else { 0.0 }
    }

    fn acted(&mut self, action: Action) {
        self.actions += 1;
        match action {
            Action::Spindle { speed_rev_s, .. } => {
                if speed_rev_s > self.spindle_rev_s {
                    self.spindle_rev_s = speed_rev_s;
                }
            }
            Action::Dwell(seconds) => self.dwell_s += seconds,
            Action::Stop { .. } | Action::Tool(_) => self.stops += 1,
        }
    }

    /// The program is put on its board.
    pub(super) fn put(&mut self, place: Place, cuts: &Extent) {
        self.place = place;
        self.cuts = *cuts;
        self.on_board = place.extent(cuts);
        self.estimate_s = self.estimate_s * place.scale + self.dwell_s;
    }
}
