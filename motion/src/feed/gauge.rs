//! The part of a line in the plane of (u, x) = (s̈, ṡ²) that a sample allows.

use super::polygon::{Polygon, dot};
use super::sample::Allowed;
use crate::scalar::{larger, smaller};

/// ṡ² that no step comes to, in units of the largest one allowed: a step whose end is within limits may
/// be bounded by a chord that rises more.
const HEADROOM: f32 = 16.0;
/// Where a polygon must be cut, it is cut this much deeper, so that limits that differ less from sample
/// to sample cut once.
const DEEPER: f32 = 1e-3;
/// The same where an ellipse cuts: a tangent at 1 − ε cuts off an arc of 2·acos(1 − ε), 10°.
const DEEPER_THAN_ROUND: f32 = 4e-3;
/// Most cuts for one ellipse: half of it is 180°, and no corner within 5° of a tangent remains outside.
const ROUND_CUTS: usize = 36;

/// u and x as affine functions of one variable t: value at 0 and slope.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chord {
    pub(super) u: [f32; 2],
    pub(super) x: [f32; 2],
}

/// The values of t that are still allowed; empty when low > high.
///
/// What holds at both ends of it holds between: then no limit below divides, or takes a root.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Span {
    pub(super) low: f32,
    pub(super) high: f32,
}

impl Span {
    const EMPTY: Self = Self {
        low: f32::INFINITY,
        high: f32::NEG_INFINITY,
    };

    pub(super) fn is_empty(self) -> bool {
        self.low > self.high
    }

    /// |c + d·t| ≤ 1
    fn strip(&mut self, c: f32, d: f32) {
        let reaches = larger((c + d * self.low).abs(), (c + d * self.high).abs());
        if reaches <= 1.0 {
            return;
        }
        if d.abs() > 0.0 {
            let inverse = 1.0 / d;
            let (middle, half) = (-c * inverse, inverse.abs());
            self.low = larger(self.low, middle - half);
            self.high = smaller(self.high, middle + half);
        } else if c.abs() > 1.0 {
            *self = Self::EMPTY;
        }
    }

    /// c + d·t ≤ limit
    pub(super) fn half_plane(&mut self, c: f32, d: f32, limit: f32) {
        if larger(c + d * self.low, c + d * self.high) <= limit {
            return;
        }
        if d > 0.0 {
            self.high = smaller(self.high, (limit - c) / d);
        } else if d < 0.0 {
            self.low = larger(self.low, (limit - c) / d);
        } else if c > limit {
            *self = Self::EMPTY;
        }
    }

    /// a·t² + 2·b·t + c ≤ 0 with a ≥ 0
    fn parabola(&mut self, a: f32, b: f32, c: f32) {
        let at = |t: f32| t * (a * t + 2.0 * b) + c;
        if larger(at(self.low), at(self.high)) <= 0.0 {
            return;
        }
        if a > 0.0 {
            let square = b * b - a * c;
            if square < 0.0 {
                *self = Self::EMPTY;
                return;
            }
            let root = libm::sqrtf(square);
            self.low = larger(self.low, (-b - root) / a);
            self.high = smaller(self.high, (-b + root) / a);
        } else if c > 0.0 {
            *self = Self::EMPTY;
        }
    }
}

impl<const N: usize> Allowed<N> {
    /// Without the limits that others imply where |u| and x are at most `most_u` and `most_x` with
    /// its headroom: they become 0.
    ///
    /// What the joints allow is a polygon. A line that touches it nowhere implies nothing; nor does an ellipse
    /// with all corners inside. Lines for which there is no place remain: the polygon is too large then.
    pub(super) fn reduced(mut self) -> Self {
        let mut polygon = Polygon::rectangle(self.most_u, HEADROOM * self.most_x);
        for line in self.joint_lines() {
            if polygon.has_room_for_two() {
                polygon.cut_strip(line, 1.0);
            }
        }
        let touches = |line| polygon.corners().any(|c| dot(line, *c).abs() >= TOUCHES);
        for (first, second) in self.first.iter_mut().zip(&mut self.second) {
            if !touches([*first, *second]) {
                (*first, *second) = (0.0, 0.0);
            }
        }
        for ellipse in &mut self.tool {
            if !polygon.corners().any(|c| square(ellipse, *c) >= TOUCHES) {
                *ellipse = [0.0; 3];
            }
        }
        self
    }

    fn joint_lines(&self) -> impl Iterator<Item = [f32; 2]> {
        let lines = self.first.iter().zip(&self.second);
        lines
            .map(|(first, second)| [*first, *second])
            .filter(|[first, second]| first.abs() + second.abs() > 0.0)
    }

    /// Cuts off what this sample does not allow, and a little more.
    pub(super) fn cut(&self, polygon: &mut Polygon) {
        for line in self.joint_lines() {
            polygon.cut_strip(line, 1.0 - DEEPER);
        }
        if self.mixed[1] > 0.0 {
            polygon.cut_roof(self.mixed, 1.0 - DEEPER);
        }
        for ellipse in &self.tool {
            let [bb, bc, cc] = ellipse;
            if bb + cc <= 0.0 {
                continue;
            }
            for _ in 0..ROUND_CUTS {
                let mut farthest = ([0.0; 2], 1.0);
                for corner in polygon.corners() {
                    let is = square(ellipse, *corner);
                    if is > farthest.1 {
                        farthest = (*corner, is);
                    }
                }
                let ([u, x], is) = farthest;
                if is <= 1.0 {
                    break;
                }
                // of p with p·M·p = r² the tangent at p/r is p·M·(u, x) ≤ r
                let line = [bb * u + bc * x, bc * u + cc * x];
                polygon.cut(line, libm::sqrtf(is) * (1.0 - DEEPER_THAN_ROUND));
            }
        }
    }

    /// Cuts off what this sample does not allow.
    pub(super) fn clip(&self, chord: &Chord, span: &mut Span) {
        let ([u0, u1], [x0, x1]) = (chord.u, chord.x);
        let top = HEADROOM * self.most_x;
        span.half_plane(x0, x1, top);
        for [first, second] in self.joint_lines() {
            span.strip(first * u0 + second * x0, first * u1 + second * x1);
        }
        for [bb, bc, cc] in &self.tool {
            if *bb > 0.0 || *cc > 0.0 {
                span.parabola(
                    bb * u1 * u1 + 2.0 * bc * u1 * x1 + cc * x1 * x1,
                    bb * u0 * u1 + bc * (u0 * x1 + u1 * x0) + cc * x0 * x1,
                    bb * u0 * u0 + 2.0 * bc * u0 * x0 + cc * x0 * x0 - 1.0,
                );
            }
        }
        let [by_u, by_x] = self.mixed;
        if by_x > 0.0 {
            for side in [by_u, -by_u] {
                span.half_plane(side * u0 + by_x * x0, side * u1 + by_x * x1, 1.0);
            }
        }
    }
}

/// From where a line or an ellipse at 1 counts as touched: rounding is below 1e-6.
const TOUCHES: f32 = 1.0 - 1e-5;

/// |b·u + c·x|²
fn square([bb, bc, cc]: &[f32; 3], [u, x]: [f32; 2]) -> f32 {
    u * (bb * u + 2.0 * bc * x) + cc * x * x
}
