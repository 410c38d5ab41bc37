//! Outlines of drawings as moves: above the beginning, down, along, and up again.

use super::nurbs::Nurbs;
use super::step::{Keeping, Move, Shape, Speed, Step, What, distance, mix};
use std::collections::VecDeque;
use std::sync::Arc;

/// How outlines are engraved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Engrave {
    /// How deep below z = 0, m; a depth of the task goes before it, and neither is scaled.
    pub depth_m: f64,
    /// How high the tool is above it between outlines, m.
    pub clearance_m: f64,
    /// Speed of going down, m/s.
    pub plunge_m_s: f64,
    /// Speed of engraving, m/s.
    pub feed_m_s: f64,
}

impl Default for Engrave {
    fn default() -> Self {
        Self {
            depth_m: 2e-4,
            clearance_m: 2e-3,
            plunge_m_s: 5e-3,
            feed_m_s: 2e-2,
        }
    }
}

/// A line of a drawing that the tool follows without leaving it, in the plane z = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    /// Its line in the file, from 1.
    pub line: u32,
    /// Where it begins, m.
    pub from_m: [f64; 3],
    /// Where each of its parts ends, m, and their shapes.
    pub parts: Vec<([f64; 3], Shape)>,
}

impl Outline {
    /// An outline that begins at a point.
    #[must_use]
    pub const fn new(line: u32, from_m: [f64; 3]) -> Self {
        Self {
            line,
            from_m,
            parts: Vec::new(),
        }
    }

    /// Where it ends, m.
    #[must_use]
    pub fn end(&self) -> [f64; 3] {
        self.parts.last().map_or(self.from_m, |(to, _)| *to)
    }

    /// A line to a point, unless it is there.
    pub(super) fn line_to(&mut self, to: [f64; 3]) {
        if distance(&self.end(), &to) > 0.0 {
            self.parts.push((to, Shape::Line));
        }
    }

    /// A spline from where it ends.
    pub(super) fn curve(&mut self, curve: Nurbs) {
        self.parts
            .push((curve.at(1.0), Shape::Nurbs(Arc::new(curve))));
    }
}

/// The moves of outlines: an iterator.
#[derive(Clone, Debug)]
pub(crate) struct Outlines {
    all: Arc<[Outline]>,
    engrave: Engrave,
    next: usize,
    /// The part of the outline that is next.
    part: usize,
    made: VecDeque<Step>,
    at: Option<[f64; 3]>,
}

impl Outlines {
    pub(crate) const fn new(all: Arc<[Outline]>, engrave: Engrave) -> Self {
        Self {
            all,
            engrave,
            next: 0,
            part: 0,
            made: VecDeque::new(),
            at: None,
        }
    }

    fn go(&mut self, line: u32, to: [f64; 3], shape: Shape, speed: Speed) {
        let from_m = self.at.unwrap_or(to);
        self.at = Some(to);
        self.made.push_back(Step {
            line,
            what: What::Move(Move {
                from_m,
                to_m: to,
                shape,
                speed,
                keeping: Keeping::Task,
            }),
        });
    }
}

impl Iterator for Outlines {
    type Item = Step;

    fn next(&mut self) -> Option<Step> {
        // each round begins an outline, makes a part of it, or ends it
        loop {
            if let Some(step) = self.made.pop_front() {
                return Some(step);
            }
            let all = self.all.clone();
            let outline = all.get(self.next)?;
            let line = outline.line;
            let Engrave {
                depth_m,
                clearance_m,
                plunge_m_s,
                feed_m_s,
            } = self.engrave;
            let at = |[x, y, _]: [f64; 3], z: f64| [x, y, z];
            if self.part == 0 {
                let (above, below) = (
                    at(outline.from_m, clearance_m),
                    at(outline.from_m, -depth_m),
                );
                self.go(line, above, Shape::Line, Speed::Rapid);
                self.go(line, below, Shape::Line, Speed::Feed(plunge_m_s));
            }
            if let Some((to, shape)) = outline.parts.get(self.part) {
                let lowered = lowered(shape, depth_m);
                self.go(line, at(*to, -depth_m), lowered, Speed::Feed(feed_m_s));
                self.part += 1;
            } else {
                self.go(
                    line,
                    at(outline.end(), clearance_m),
                    Shape::Line,
                    Speed::Rapid,
                );
                self.part = 0;
                self.next += 1;
            }
        }
    }
}

/// A shape at the depth of the cut.
fn lowered(shape: &Shape, depth_m: f64) -> Shape {
    match shape {
        Shape::Nurbs(curve) => Shape::Nurbs(Arc::new(curve.moved(&[0.0, 0.0, -depth_m]))),
        other => other.clone(),
    }
}

/// An arc from a polyline: its bulge is the tangent of a quarter of its angle, counterclockwise.
pub(super) fn bulged(from: &[f64; 3], to: &[f64; 3], bulge: f64) -> Shape {
    let chord = distance(from, to);
    if bulge.abs() < 1e-9 || chord <= 0.0 {
        return Shape::Line;
    }
    let ([x0, y0, z], [x1, y1, _]) = (*from, *to);
    let [xm, ym, _] = mix(from, to, 0.5);
    // the centre is (1 − b²)/(4b) chords to the left of the middle
    let off = (1.0 - bulge * bulge) / (4.0 * bulge);
    Shape::Arc {
        centre_m: [xm - off * (y1 - y0), ym + off * (x1 - x0), z],
        plane: [0, 1, 2],
        angle_rad: 4.0 * libm::atan(bulge),
    }
}
