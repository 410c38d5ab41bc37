//! The surface of a tool whose axis is tilted, seen from below, in closed form at one pose.
//!
//! A point p above the tip has the height ζ = n·p along the axis n and the squared distance
//! |p|² − ζ² from it. On a vertical line ζ is linear in the height z, so to be inside a cylinder, cone or
//! sphere is a quadratic inequality in z, and to be between two heights along the axis a linear one.
//! The parts are convex: each meets the line in an interval, and the least of their lower ends is the surface.

use super::sweep::{Row, Sweep};
use super::tool::{HOLDER_M, Profile, Tool};

/// A tool at one pose.
#[derive(Clone, Copy, Debug)]
pub(super) struct TiltedTool<'a> {
    tool: &'a Tool,
    tip: [f64; 3],
    /// Unit vector from the tip towards the shank; its z is positive.
    up: [f64; 3],
    /// What of the axis can be below the top of the board: ends over the board, and the radius there.
    ends: [[f64; 2]; 2],
    radius: f64,
    guards: bool,
}

/// Heights above the tip, m, in order.
type Interval = [f64; 2];

impl<'a> TiltedTool<'a> {
    /// The tool with its tip at a point of the board frame (m) and the shank in a direction (unit
    /// vector, z > 0); none if it is above the board.
    pub(super) fn new(tool: &'a Tool, tip: [f64; 3], up: [f64; 3]) -> Option<Self> {
        let shank = &tool.shank;
        let tilt = libm::sqrt(up[0] * up[0] + up[1] * up[1]);
        // a disc of radius r around the axis at ζ reaches down to tip + ζ·cos − r·sin
        let submerged = |radius: f64| (radius * tilt - tip[2]) / up[2];
        let widest = [
            tool.radius_m,
            0.5 * shank.diameter_m,
            0.5 * shank.holder_diameter_m,
        ]
        .into_iter()
        .fold(0.0, |a, b| if b > a { b } else { a });
        let guards = submerged(widest) > shank.cutting_length_m;
        let mut radius = if guards { widest } else { tool.radius_m };
        let mut height = submerged(radius);
        if height <= 0.0 {
            return None;
        }
        if !guards {
            radius = tool.radius_at_m(height);
            height = submerged(radius);
            if height <= 0.0 {
                return None;
            }
        }
        let most = shank.stick_out_m + HOLDER_M;
        let height = if height < most { height } else { most };
        Some(Self {
            tool,
            tip,
            up,
            ends: [
                [tip[0], tip[1]],
                [tip[0] + height * up[0], tip[1] + height * up[1]],
            ],
            radius,
            guards,
        })
    }

    /// The vertical line above a point of the board.
    fn line(&self, x: f64, y: f64) -> Line {
        let (dx, dy) = (x - self.tip[0], y - self.tip[1]);
        Line {
            distance2: dx * dx + dy * dy,
            offset: self.up[0] * dx + self.up[1] * dy,
            cosine: self.up[2],
        }
    }

    fn above_tip(&self, parts: &[Option<Interval>]) -> f64 {
        let lowest = parts
            .iter()
            .flatten()
            .fold(f64::INFINITY, |a, [b, _]| if *b < a { *b } else { a });
        self.tip[2] + lowest
    }
}

impl Sweep for TiltedTool<'_> {
    fn rows(&self) -> Row {
        let [[_, a], [_, b]] = self.ends;
        Row::around(a, b, self.radius)
    }

    fn columns(&self, _: f64) -> Row {
        let [[a, _], [b, _]] = self.ends;
        Row::around(a, b, self.radius)
    }

    fn cutter(&self, x: f64, y: f64) -> f64 {
        let line = self.line(x, y);
        let (radius, length) = (self.tool.radius_m, self.tool.shank.cutting_length_m);
        match self.tool.profile {
            Profile::Flat => self.above_tip(&[line.cone(radius, 0.0, [0.0, length])]),
            Profile::Ball => {
                self.above_tip(&[line.ball(radius), line.cone(radius, 0.0, [radius, length])])
            }
            Profile::V {
                tip_radius_m,
                slope,
            } => self.above_tip(&[line.cone(tip_radius_m, 1.0 / slope, [0.0, length])]),
        }
    }

    fn guard(&self, x: f64, y: f64) -> f64 {
        if !self.guards {
            return f64::INFINITY;
        }
        let (line, shank) = (self.line(x, y), &self.tool.shank);
        let top = shank.stick_out_m + HOLDER_M;
        let heights = [shank.cutting_length_m, shank.stick_out_m];
        let holder = [shank.stick_out_m, top];
        self.above_tip(&[
            line.cone(0.5 * shank.diameter_m, 0.0, heights),
            line.cone(0.5 * shank.holder_diameter_m, 0.0, holder),
        ])
    }
}

/// A vertical line, seen from the tip: z counts from the tip, ζ = offset + cosine·z.
#[derive(Clone, Copy, Debug)]
struct Line {
    /// Squared distance over the board from the tip, m².
    distance2: f64,
    /// m
    offset: f64,
    cosine: f64,
}

impl Line {
    /// The part between two heights along the axis.
    fn slab(self, [from, to]: Interval) -> Interval {
        [
            (from - self.offset) / self.cosine,
            (to - self.offset) / self.cosine,
        ]
    }

    /// The part inside the cone of radius `radius + widening·ζ`, between two heights along the axis.
    ///
    /// d² + z² − ζ² ≤ (r + m·ζ)² is A·z² + 2B·z + C ≤ 0; where A < 0 the line is steeper than the
    /// cone, and its part in the upper half of the double cone is what is above the greater root.
    fn cone(self, radius: f64, widening: f64, heights: Interval) -> Option<Interval> {
        let (e, c) = (self.offset, self.cosine);
        let m = 1.0 + widening * widening;
        let qa = 1.0 - m * c * c;
        let qb = -c * (m * e + radius * widening);
        let qc = self.distance2 - m * e * e - 2.0 * radius * widening * e - radius * radius;
        let inside = match roots(qa, qb, qc) {
            Some([_, upper]) if qa < 0.0 => [upper, f64::INFINITY],
            Some(both) => both,
            None if qc <= 0.0 => [f64::NEG_INFINITY, f64::INFINITY],
            None => return None,
        };
        overlap(inside, self.slab(heights))
    }

    /// The part inside the lower half of the ball that touches the tip: |p − R·n| ≤ R, ζ ≤ R.
    fn ball(self, radius: f64) -> Option<Interval> {
        let middle = radius * self.cosine;
        let square = middle * middle - self.distance2 + 2.0 * radius * self.offset;
        if square < 0.0 {
            return None;
        }
        let half = libm::sqrt(square);
        overlap(
            [middle - half, middle + half],
            self.slab([f64::NEG_INFINITY, radius]),
        )
    }
}

fn overlap([a, b]: Interval, [c, d]: Interval) -> Option<Interval> {
    let lower = if c > a { c } else { a };
    let upper = if d < b { d } else { b };
    (lower <= upper).then_some([lower, upper])
}

/// The roots of a·z² + 2b·z + c in order, without the loss of digits where a is small; none if there are none.
fn roots(a: f64, b: f64, c: f64) -> Option<Interval> {
    let square = b * b - a * c;
    if square < 0.0 {
        return None;
    }
    let q = -(b + libm::copysign(libm::sqrt(square), b));
    if q == 0.0 {
        return (a != 0.0).then_some([0.0, 0.0]);
    }
    let (one, two) = (q / a, c / q);
    Some(if one < two { [one, two] } else { [two, one] })
}
