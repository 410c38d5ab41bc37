//! The elements of a path from the moves of a program, made one by one.

use super::Options;
use super::Steps;
use super::place::Place;
use super::smooth::{Given, Smoother, Vertex, pose};
use super::step::{Keeping, Move, Shape, Speed, What, distance};
use crate::path::{Goal, Mark, SHARP, Way};
use motion::path::{Arc, Blend, Curve, Join, Piece, Straight, Tolerance};
use nalgebra::Vector3;
use protocol::message::Corner;
use std::collections::VecDeque;

/// Lines no longer than this, m, may become points of a curve.
const SHORT_M: f64 = 5e-3;
/// Chords of curves are off by no more than this share of the tolerance of curves.
const CHORD: f64 = 0.05;
/// The most chords of a span of a curve.
const MOST_CHORDS: u32 = 4096;
/// An arc is given out in parts of at most this, rad.
const MOST_ANGLE: f64 = 2.0;
/// Arcs shorter than this, m, become points of a curve.
const SHORTEST_ARC_M: f64 = 1e-3;
/// The rounding of orientation beside that of position, rad: nothing turns.
const TURN_RAD: f32 = 0.1;

/// The elements of a path in the frame of the board: an iterator that makes them as they are asked for.
///
/// Memory is that of the program that runs, of 2048 vertices at most, and of what one move makes.
#[derive(Clone, Debug)]
pub struct Marks {
    steps: Steps,
    place: Place,
    options: Options,
    /// A move that is made vertices of, and where.
    bending: Option<Bending>,
    run: Option<Smoother>,
    made: VecDeque<Mark>,
    /// Where the last element ends, m, the piece it was, and its feed.
    at: Option<[f64; 3]>,
    last: Option<Piece>,
    feed: Option<f64>,
    /// Line and feed of the last element, if that is a point of a curve.
    through: Option<(u32, f64)>,
    /// Within what corners are rounded now, m.
    within_m: f64,
    over: bool,
}

/// A curve on its way to vertices.
#[derive(Clone, Debug)]
struct Bending {
    of: Move,
    line: u32,
    feed: f64,
    tolerance_m: f64,
    /// Shares of the curve where its spans begin and end, the last first.
    breaks: Vec<f64>,
    from: f64,
}

impl Marks {
    pub(super) const fn new(steps: Steps, place: Place, options: Options) -> Self {
        Self {
            steps,
            place,
            options,
            bending: None,
            run: None,
            made: VecDeque::new(),
            at: None,
            last: None,
            feed: None,
            through: None,
            within_m: 0.0,
            over: false,
        }
    }
}

impl Iterator for Marks {
    type Item = Mark;

    fn next(&mut self) -> Option<Mark> {
        // each round takes a step of the program, or a span of a curve
        loop {
            if let Some(mark) = self.made.pop_front() {
                return Some(mark);
            }
            if self.bending.is_some() {
                self.bend();
                continue;
            }
            if self.over {
                return None;
            }
            match self.steps.next() {
                Some(Ok(step)) => match step.what {
                    What::Move(made) => self.take(&made, step.line),
                    What::Action(_) => self.end(),
                },
                _ => self.end(),
            }
        }
    }
}

impl Marks {
    fn end(&mut self) {
        self.flush();
        self.over = true;
    }

    fn take(&mut self, of: &Move, line: u32) {
        let (from, to) = (self.place.map(&of.from_m), self.place.map(&of.to_m));
        let within_m = match of.keeping {
            Keeping::Task => self.options.tolerance_m,
            Keeping::Within(metres) => metres,
            Keeping::Exact => 0.0,
        };
        let feed = match of.speed {
            Speed::Rapid => self.options.rapid_m_s,
            Speed::Feed(feed) => self.options.cut_m_s.unwrap_or(feed),
        };
        if self.at.is_none() {
            // wherever the tool is, it is led to where the path begins
            self.line(from, line, self.options.rapid_m_s, true);
            self.last = None;
        }
        if within_m.to_bits() != self.within_m.to_bits() {
            self.flush();
            self.within_m = within_m;
        }
        let rapid = of.speed == Speed::Rapid;
        match &of.shape {
            Shape::Line if rapid || within_m <= 0.0 || distance(&from, &to) > SHORT_M => {
                self.flush();
                self.line(to, line, feed, rapid);
                if rapid {
                    // what comes after it begins at rest, too
                    self.last = None;
                }
            }
            Shape::Line => self.vertex(Vertex { at: to, line, feed }, within_m, false),
            Shape::Arc {
                plane: [.., across],
                angle_rad,
                ..
            } => {
                let circle = self.place.keeps_circles(*across) && flat(of, *across);
                // shorter ones are too close for a node: points of a curve are fewer
                let short = self.place.scale * of.length_m() < SHORTEST_ARC_M && within_m > 0.0;
                if circle && !short {
                    self.flush();
                    self.arcs(of, line, feed);
                } else {
                    let parts = super::step::steps(angle_rad.abs());
                    let breaks = (0..=parts).map(|k| f64::from(k) / f64::from(parts));
                    let tolerance_m = if circle {
                        within_m
                    } else {
                        self.options.curve_tolerance_m
                    };
                    self.bent(of, line, feed, breaks.collect(), tolerance_m);
                }
            }
            Shape::Nurbs(curve) => {
                let breaks = curve.breaks().collect();
                self.bent(of, line, feed, breaks, self.options.curve_tolerance_m);
            }
        }
    }

    fn bent(&mut self, of: &Move, line: u32, feed: f64, mut breaks: Vec<f64>, tolerance_m: f64) {
        breaks.reverse();
        let from = breaks.pop().unwrap_or_default();
        self.bending = Some(Bending {
            of: of.clone(),
            line,
            feed,
            tolerance_m,
            breaks,
            from,
        });
    }

    /// The next span of a curve.
    fn bend(&mut self) {
        let Some(mut bending) = self.bending.take() else {
            return;
        };
        let Some(to) = bending.breaks.pop() else {
            return;
        };
        let tolerance = bending.tolerance_m;
        let at = |share: f64| self.place.map(&bending.of.at(share));
        let (from, width) = (bending.from, to - bending.from);
        // chords of sixteen parts are off by so much; that falls with the square of their number
        let mut most = 0.0;
        for k in 0..16_u32 {
            let part = |half: u32| at(from + width * f64::from(2 * k + half) / 32.0);
            let (a, m, b) = (part(0), part(1), part(2));
            let off = distance(&m, &super::step::mix(&a, &b, 0.5));
            most = if off > most { off } else { most };
        }
        let count = super::step::steps(16.0 * libm::sqrt(most / (CHORD * tolerance)));
        let count = count.clamp(16, MOST_CHORDS);
        let (line, feed) = (bending.line, bending.feed);
        let vertices = (1..=count).map(|k| at(from + width * f64::from(k) / f64::from(count)));
        for at in vertices.collect::<Vec<_>>() {
            self.vertex(Vertex { at, line, feed }, tolerance, true);
        }
        bending.from = to;
        self.bending = Some(bending);
    }

    /// Another vertex of a run of short lines, or of a curve.
    fn vertex(&mut self, vertex: Vertex, tolerance_m: f64, dense: bool) {
        if self
            .run
            .as_ref()
            .is_some_and(|run| !run.fits(tolerance_m, dense))
        {
            self.flush();
        }
        let from = self.at.unwrap_or(vertex.at);
        let mut run = match self.run.take() {
            Some(run) => run,
            None => Smoother::new(from, tolerance_m, dense),
        };
        let mut given = VecDeque::new();
        run.push(vertex, &mut |point| given.push_back(point));
        self.run = Some(run);
        self.give(&given);
    }

    /// The run ends here.
    fn flush(&mut self) {
        if let Some(mut run) = self.run.take() {
            let mut given = VecDeque::new();
            run.finish(&mut |point| given.push_back(point));
            self.give(&given);
            if run.last.is_some() {
                self.last = run.last;
            }
        }
    }

    fn give(&mut self, given: &VecDeque<Given>) {
        for given in given {
            match given {
                Given::Line(to) => self.line(to.at, to.line, to.feed, false),
                Given::Begin => self.part(),
                Given::Point(to) => {
                    self.mark(Way::Through, to.at, to.line, to.feed);
                    self.last = None;
                }
            }
        }
    }

    /// Two curves one after the other would be one: a line that goes nowhere parts them.
    fn part(&mut self) {
        if let (Some(at), Some((line, feed))) = (self.at, self.through) {
            self.mark(Way::Line { corner: SHARP }, at, line, feed);
        }
    }

    /// A line; what goes nowhere is none.
    fn line(&mut self, to: [f64; 3], line: u32, feed: f64, sharp: bool) {
        let piece = self.at.map(|at| Straight::new(pose(&at), pose(&to)));
        let piece = match piece {
            Some(Ok(piece)) => Some(Piece::from(piece)),
            Some(Err(_)) => return,
            None => None,
        };
        let corner = if sharp {
            SHARP
        } else {
            self.corner(piece.as_ref())
        };
        self.mark(Way::Line { corner }, to, line, feed);
        self.last = piece;
    }

    /// The corner before a piece: rounded within the tolerance, if it can be.
    fn corner(&self, next: Option<&Piece>) -> Corner {
        let (Some(last), Some(next)) = (&self.last, next) else {
            return self.rounded();
        };
        if self.within_m <= 0.0 {
            return SHARP;
        }
        let (end, start) = (last.at(last.length()), next.at(0.0));
        if Join::between(&end, &start) == Some(Join::Smooth) {
            return self.rounded();
        }
        let tolerance = Tolerance {
            metres: self.within_m,
            radians: f64::from(TURN_RAD),
        };
        match Blend::between(last, next, &tolerance) {
            Ok(_) => self.rounded(),
            Err(_) => SHARP,
        }
    }

    fn rounded(&self) -> Corner {
        #[expect(
            clippy::cast_possible_truncation,
            reason = "travels as f32; 24 bits are enough"
        )]
        let metres = self.within_m as f32;
        if metres > 0.0 && self.last.is_some() {
            Corner {
                metres,
                radians: TURN_RAD,
            }
        } else {
            SHARP
        }
    }

    /// An arc in its plane, in parts that a robot's node can tell from a line.
    fn arcs(&mut self, of: &Move, line: u32, feed: f64) {
        let Shape::Arc { angle_rad, .. } = &of.shape else {
            return;
        };
        let parts = super::step::steps(angle_rad.abs() / MOST_ANGLE);
        for k in 0..parts {
            let share = |half: u32| f64::from(2 * k + half) / f64::from(2 * parts);
            let (via, to) = (of.at(share(1)), of.at(share(2)));
            let (via, to) = (self.place.map(&via), self.place.map(&to));
            let from = self.at.unwrap_or(to);
            match Arc::through(pose(&from), Vector3::from(via), pose(&to)) {
                Ok(arc) => {
                    let piece = Piece::from(arc);
                    let corner = self.corner(Some(&piece));
                    let way = Way::Arc { via_m: via, corner };
                    self.mark(way, to, line, feed);
                    self.last = Some(piece);
                }
                // it bends by less than anything can tell
                Err(_) => self.line(to, line, feed, false),
            }
        }
    }

    fn mark(&mut self, way: Way, to: [f64; 3], line: u32, feed: f64) {
        let changed = self.feed.map(f64::to_bits) != Some(feed.to_bits());
        self.feed = Some(feed);
        self.at = Some(to);
        self.through = (way == Way::Through).then_some((line, feed));
        self.made.push_back(Mark {
            line,
            way,
            to: Goal {
                position_m: to,
                rotation_rad: None,
            },
            feed_m_s: changed.then_some(feed),
        });
    }
}

/// Does it stay in its plane?
fn flat(of: &Move, across: usize) -> bool {
    let height = |point: &[f64; 3]| super::step::get(point, across);
    (height(&of.from_m) - height(&of.to_m)).abs() <= 1e-9
}
