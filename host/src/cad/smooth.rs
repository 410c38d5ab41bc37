//! Polygons of short lines, and curves, as points of the papers' smooth curve.
//!
//! The curve through the points is made here by the very code of the node, and each of its spans is compared
//! with the polygon between its ends: points are given out only while it stays within the tolerance,
//! however the curve goes on and if it ends there. What does not fit is given out as lines.

use super::step::{distance, mix};
use motion::Pose;
use motion::path::{Curve, MovingSegment, Piece, Quintic};
use nalgebra::{Matrix3, Vector3};
use std::collections::VecDeque;

/// The most vertices that are looked at together: 100 kB with what belongs to them.
pub(super) const MOST_VERTICES: usize = 2048;
/// Points are no closer than this, m: a node sees 0.2 mm or more from sample to sample, and wants points no
/// closer than a quarter of that; it takes 200 of them per second.
const CLOSEST_M: f64 = 2.5e-4;
/// Points of a curve are no farther apart than this, m, and turn by no more than this, rad: a circle is
/// met to its radius times 3e-6.
const FARTHEST_M: f64 = 5e-3;
const MOST_TURN: f64 = 0.2;
/// A span is compared at so many points; between them it differs by some percent more.
const COMPARED: u32 = 8;
/// Points of a line before a curve are no farther apart, m.
const LONGEST_ENTRY_M: f64 = 1e-3;
/// Share of the tolerance that is used up at the points compared.
const USED: f64 = 0.9;
/// What turns by more than this at a vertex, rad, is a corner.
pub(super) const CORNER_RAD: f64 = 0.45;
/// Points that are held back, so that what is given out stays right however the curve goes on.
const HELD: usize = 12;
/// Points that are tried together.
const TRIED: usize = 64;
/// How many points before a bad span the curve may end.
const BACK: usize = 5;

/// A vertex of a polygon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Vertex {
    pub(super) at: [f64; 3],
    pub(super) line: u32,
    /// Of the way to it, m/s.
    pub(super) feed: f64,
}

/// What is given out, in order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Given {
    /// A line to a vertex.
    Line(Vertex),
    /// A curve begins where the tool is: another than the one that may have ended there.
    Begin,
    /// A point of the curve.
    Point(Vertex),
}

/// The pose of a point; how the tool is turned does not matter here.
pub(super) fn pose(at: &[f64; 3]) -> Pose {
    Pose {
        position: Vector3::from(*at),
        rotation: Matrix3::identity(),
    }
}

/// A polygon that is given out bit by bit.
#[derive(Clone, Debug)]
pub(super) struct Smoother {
    /// The first is where the way begins; what belongs to spans yet to come is kept.
    vertices: Vec<Vertex>,
    /// Index of the vertex that was given out last.
    given: usize,
    /// The curve that is open there.
    curve: Option<Trace>,
    tolerance_m: f64,
    /// The vertices are points of a curve, closer than points need be.
    dense: bool,
    /// Vertices up to this one are points, however close they are.
    forced: usize,
    /// The last span that was made.
    pub(super) last: Option<Piece>,
}

/// A curve through points, and the vertices of the spans that it has not made yet.
#[derive(Clone, Debug)]
struct Trace {
    segment: MovingSegment,
    ends: VecDeque<usize>,
    last: Option<Quintic>,
}

impl Smoother {
    pub(super) fn new(from: [f64; 3], tolerance_m: f64, dense: bool) -> Self {
        let begin = Vertex {
            at: from,
            line: 0,
            feed: 0.0,
        };
        Self {
            vertices: vec![begin],
            given: 0,
            curve: None,
            tolerance_m,
            dense,
            forced: 0,
            last: None,
        }
    }

    pub(super) fn fits(&self, tolerance_m: f64, dense: bool) -> bool {
        self.dense == dense && self.tolerance_m.to_bits() == tolerance_m.to_bits()
    }

    /// Another vertex; those that repeat the one before are left out.
    pub(super) fn push(&mut self, vertex: Vertex, out: &mut impl FnMut(Given)) {
        let last = self.vertices.last().map_or([0.0; 3], |last| last.at);
        if distance(&last, &vertex.at) < motion::path::SHORTEST_M {
            return;
        }
        self.vertices.push(vertex);
        if self.vertices.len() >= MOST_VERTICES {
            self.give(false, out);
        }
    }

    /// Everything that is left.
    pub(super) fn finish(&mut self, out: &mut impl FnMut(Given)) {
        self.give(true, out);
    }

    /// Gives out what is settled, or everything.
    fn give(&mut self, all: bool, out: &mut impl FnMut(Given)) {
        // each round gives out a vertex at least
        loop {
            let left = self.vertices.len() - 1 - self.given;
            if left == 0 || (!all && left < MOST_VERTICES / 2) {
                break;
            }
            self.round(all, out);
        }
        if all {
            self.curve = None;
        }
        self.forget();
    }

    /// Vertices before what is to come are of no use.
    fn forget(&mut self) {
        let first = self.curve.as_ref().and_then(|curve| curve.ends.front());
        let first = first.copied().unwrap_or(self.given).min(self.given);
        self.vertices.drain(..first);
        self.given -= first;
        if let Some(curve) = &mut self.curve {
            for end in &mut curve.ends {
                *end -= first;
            }
        }
    }

    /// As many points of one curve as fit, or one line.
    fn round(&mut self, all: bool, out: &mut impl FnMut(Given)) {
        if self.curve.is_none() && !self.dense && self.entry(all, out) {
            return;
        }
        let begin = self.curve.clone().or_else(|| self.begin());
        // a curve that is held to its tolerance by closer points: each time twice as close
        let mut spacing = if self.dense { FARTHEST_M } else { CLOSEST_M };
        while let Some(begin) = &begin {
            if self.try_curve(begin, spacing, all, out) {
                return;
            }
            spacing *= 0.5;
            if spacing < CLOSEST_M {
                break;
            }
        }
        // a curve that was open ends where it is: that was within the tolerance when it was given out
        self.curve = None;
        self.line(out);
    }

    /// A curve that begins in a line: with four points on it, so that it goes on from it without a stop.
    ///
    /// The derivatives at the first point come from it and the three after it: those of the line.
    fn entry(&mut self, all: bool, out: &mut impl FnMut(Given)) -> bool {
        let place = |k: usize| self.vertices.get(k).map(|vertex| vertex.at);
        let first = self.given + 1;
        let (Some(from), Some(to)) = (place(self.given), self.vertices.get(first).copied()) else {
            return false;
        };
        let smooth = place(first + 1).is_some_and(|next| turn(&from, &to.at, &next) < CORNER_RAD);
        let length = distance(&from, &to.at);
        if !smooth || length < 2.0 * CLOSEST_M {
            return false;
        }
        let step = 0.25 * length;
        let step = if step < LONGEST_ENTRY_M {
            step
        } else {
            LONGEST_ENTRY_M
        };
        let before = |steps: f64| Vertex {
            at: mix(&to.at, &from, steps * step / length),
            ..to
        };
        let added = [before(3.0), before(2.0), before(1.0)];
        self.vertices.splice(first..first, added);
        self.given = first;
        self.forced = first + added.len();
        let mut points = Vec::new();
        let begin = self.begin();
        let fits = begin.is_some_and(|begin| {
            self.try_curve(&begin, CLOSEST_M, all, &mut |given| points.push(given))
        });
        self.forced = 0;
        if fits {
            let [entry, ..] = added;
            out(Given::Line(entry));
            points.into_iter().for_each(out);
        } else {
            self.vertices.drain(first..first + added.len());
            self.given = first - 1;
        }
        fits
    }

    fn begin(&self) -> Option<Trace> {
        let mut segment = MovingSegment::new();
        segment
            .push(pose(&self.vertices.get(self.given)?.at))
            .ok()?;
        Some(Trace {
            segment,
            ends: VecDeque::from([self.given]),
            last: None,
        })
    }

    /// Gives out points of a curve that goes on from `begin`; false if none fits.
    fn try_curve(
        &mut self,
        begin: &Trace,
        spacing: f64,
        all: bool,
        out: &mut impl FnMut(Given),
    ) -> bool {
        let (points, ends) = self.choose(spacing, all);
        let mut curve = begin.clone();
        let good = points
            .iter()
            .take_while(|end| self.extend(&mut curve, **end))
            .count();
        // all that is known of it fits
        let known = good == points.len() && !ends;
        let (most, least) = if known {
            (good.saturating_sub(HELD), 1)
        } else {
            // span k is made when the fourth point after it has come
            (good, good.saturating_sub(BACK + 4).max(1))
        };
        let few = if self.curve.is_some() { 1 } else { 3 };
        for count in (least..=most).rev().take(BACK + 5) {
            if count < few {
                break;
            }
            let mut curve = begin.clone();
            let mut taken = points.iter().take(count);
            if !taken.all(|end| self.extend(&mut curve, *end)) {
                continue;
            }
            let mut end = curve.clone();
            if !self.end(&mut end) {
                continue;
            }
            if self.curve.is_none() {
                out(Given::Begin);
            }
            for place in points.iter().take(count) {
                if let Some(vertex) = self.vertices.get(*place) {
                    let feed = self.slowest(self.given, *place, vertex.feed);
                    out(Given::Point(Vertex { feed, ..*vertex }));
                    self.given = *place;
                }
            }
            self.last = end.last.map(Into::into);
            self.curve = known.then_some(curve);
            return true;
        }
        false
    }

    /// The slowest feed of vertices after one up to another.
    fn slowest(&self, from: usize, to: usize, feed: f64) -> f64 {
        let between = self.vertices.iter().take(to).skip(from + 1);
        between.fold(feed, |slow, vertex| {
            if vertex.feed < slow {
                vertex.feed
            } else {
                slow
            }
        })
    }

    /// Vertices that are to be points, and whether the last of them is the end or a corner.
    fn choose(&self, spacing: f64, all: bool) -> (heapless::Vec<usize, TRIED>, bool) {
        let mut points = heapless::Vec::new();
        let (mut last, mut turned) = (self.given, 0.0);
        let place = |k: usize| self.vertices.get(k).map(|vertex| vertex.at);
        for k in self.given + 1..self.vertices.len() {
            let (Some(before), Some(here), Some(from)) = (place(k - 1), place(k), place(last))
            else {
                break;
            };
            let ahead = place(k + 1);
            let turn = ahead.map_or(0.0, |ahead| turn(&before, &here, &ahead));
            let corner = turn
                > if self.dense {
                    0.5 * MOST_TURN
                } else {
                    CORNER_RAD
                };
            turned += turn;
            let gone = distance(&from, &here);
            let far = gone >= spacing || (self.dense && turned > MOST_TURN && gone >= CLOSEST_M);
            if corner || (ahead.is_none() && all) {
                // the end of it all is a point, whatever came just before
                if gone < 0.5 * CLOSEST_M && points.len() > 1 && last > self.forced {
                    points.pop();
                }
                let _ = points.push(k);
                return (points, true);
            }
            if far || k <= self.forced {
                let _ = points.push(k);
                (last, turned) = (k, 0.0);
            }
            if points.is_full() {
                break;
            }
        }
        (points, false)
    }

    /// Another point of a curve; false if a span that it completes is too far from the polygon.
    fn extend(&self, curve: &mut Trace, end: usize) -> bool {
        let Some(vertex) = self.vertices.get(end) else {
            return false;
        };
        let Ok(span) = curve.segment.push(pose(&vertex.at)) else {
            return false;
        };
        curve.ends.push_back(end);
        span.is_none_or(|span| self.made(curve, &span))
    }

    /// The curve ends.
    fn end(&self, curve: &mut Trace) -> bool {
        while let Some(span) = curve.segment.finish() {
            if !self.made(curve, &span) {
                return false;
            }
        }
        true
    }

    /// Compares a span with the vertices between its ends.
    fn made(&self, curve: &mut Trace, span: &Quintic) -> bool {
        let Some(from) = curve.ends.pop_front() else {
            return false;
        };
        let to = curve.ends.front().copied().unwrap_or(from);
        let Some(polygon) = self.vertices.get(from..=to) else {
            return false;
        };
        curve.last = Some(*span);
        let within = USED * self.tolerance_m;
        let mut points = [[0.0; 3]; COMPARED as usize + 1];
        for (k, point) in (0..=COMPARED).zip(&mut points) {
            *point = span
                .at(span.length() * f64::from(k) / f64::from(COMPARED))
                .pose
                .position
                .into();
        }
        let inner = points.iter().skip(1).take(COMPARED as usize - 1);
        let near = |point: &[f64; 3]| off(point, polygon.iter().map(|vertex| &vertex.at)) <= within;
        if !inner.into_iter().all(near) {
            return false;
        }
        // and what was left out of it must be near the span
        let inner = polygon.iter().skip(1).take(polygon.len().saturating_sub(2));
        self.dense
            || inner
                .into_iter()
                .all(|vertex| off(&vertex.at, points.iter()) <= within)
    }

    /// A line to the next vertex, or beyond vertices that are too close to it.
    fn line(&mut self, out: &mut impl FnMut(Given)) {
        let Some(from) = self.vertices.get(self.given).map(|vertex| vertex.at) else {
            return;
        };
        let mut to = self.given + 1;
        for k in to + 1..self.vertices.len().min(to + LOOKED_AT) {
            let reach = |k: usize| {
                self.vertices
                    .get(k)
                    .map_or(f64::INFINITY, |v| distance(&from, &v.at))
            };
            if reach(to) >= CLOSEST_M && !self.dense {
                break;
            }
            let Some(end) = self.vertices.get(k) else {
                break;
            };
            let ends = [from, end.at];
            let mut between = self.vertices.iter().take(k).skip(self.given + 1);
            if !between.all(|vertex| off(&vertex.at, ends.iter()) <= 0.5 * self.tolerance_m) {
                break;
            }
            to = k;
        }
        if let Some(vertex) = self.vertices.get(to) {
            let feed = self.slowest(self.given, to, vertex.feed);
            out(Given::Line(Vertex { feed, ..*vertex }));
        }
        self.given = to;
        self.last = None;
    }
}

/// Vertices that one line may leave out.
const LOOKED_AT: usize = 32;

/// The angle between two sides, rad.
pub(super) fn turn(a: &[f64; 3], b: &[f64; 3], c: &[f64; 3]) -> f64 {
    let (u, v) = (
        Vector3::from(*b) - Vector3::from(*a),
        Vector3::from(*c) - Vector3::from(*b),
    );
    let across = u.cross(&v);
    libm::atan2(libm::sqrt(across.dot(&across)), u.dot(&v))
}

/// The distance of a point from a polygon, m.
fn off<'a>(point: &[f64; 3], polygon: impl Iterator<Item = &'a [f64; 3]>) -> f64 {
    let mut least = f64::INFINITY;
    let mut before: Option<&[f64; 3]> = None;
    for here in polygon {
        let way = before.map_or(0.0, |before| {
            let side = Vector3::from(*here) - Vector3::from(*before);
            let to = Vector3::from(*point) - Vector3::from(*before);
            (side.dot(&to) / side.dot(&side)).clamp(0.0, 1.0)
        });
        let nearest = mix(before.unwrap_or(here), here, way);
        let off = distance(point, &nearest);
        if off < least {
            least = off;
        }
        before = Some(here);
    }
    least
}
