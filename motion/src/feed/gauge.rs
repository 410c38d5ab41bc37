//! The part of a line in the plane of (u, x) = (s̈, ṡ²) that a sample allows.

use super::sample::Allowed;
use crate::scalar::{larger, smaller};

/// u and x as affine functions of one variable t: value at 0 and slope.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chord {
    pub(super) u: [f64; 2],
    pub(super) x: [f64; 2],
}

/// The values of t that are still allowed; empty when low > high.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Span {
    pub(super) low: f64,
    pub(super) high: f64,
}

impl Span {
    const EMPTY: Self = Self {
        low: f64::INFINITY,
        high: f64::NEG_INFINITY,
    };

    pub(super) fn is_empty(&self) -> bool {
        self.low > self.high
    }

    /// |c + d·t| ≤ limit
    fn strip(&mut self, c: f64, d: f64, limit: f64) {
        if d.abs() > 0.0 {
            let inverse = 1.0 / d;
            let (middle, half) = (-c * inverse, limit * inverse.abs());
            self.low = larger(self.low, middle - half);
            self.high = smaller(self.high, middle + half);
        } else if c.abs() > limit {
            *self = Self::EMPTY;
        }
    }

    /// c + d·t ≤ limit
    fn half_plane(&mut self, c: f64, d: f64, limit: f64) {
        if d > 0.0 {
            self.high = smaller(self.high, (limit - c) / d);
        } else if d < 0.0 {
            self.low = larger(self.low, (limit - c) / d);
        } else if c > limit {
            *self = Self::EMPTY;
        }
    }

    /// a·t² + 2·b·t + c ≤ 0 with a ≥ 0
    fn parabola(&mut self, a: f64, b: f64, c: f64) {
        if a > 0.0 {
            let square = b * b - a * c;
            if square < 0.0 {
                *self = Self::EMPTY;
                return;
            }
            let root = libm::sqrt(square);
            self.low = larger(self.low, (-b - root) / a);
            self.high = smaller(self.high, (-b + root) / a);
        } else if c > 0.0 {
            *self = Self::EMPTY;
        }
    }
}

impl<const N: usize> Allowed<N> {
    /// Cuts off what this sample does not allow, all its limits of acceleration multiplied by `limit`.
    pub(super) fn clip(&self, chord: &Chord, limit: f64, span: &mut Span) {
        let ([u0, u1], [x0, x1]) = (chord.u, chord.x);
        for (first, second) in self.first.iter().zip(&self.second) {
            span.strip(first * u0 + second * x0, first * u1 + second * x1, limit);
        }
        for [bb, bc, cc] in &self.tool {
            if *bb > 0.0 || *cc > 0.0 {
                span.parabola(
                    bb * u1 * u1 + 2.0 * bc * u1 * x1 + cc * x1 * x1,
                    bb * u0 * u1 + bc * (u0 * x1 + u1 * x0) + cc * x0 * x1,
                    bb * u0 * u0 + 2.0 * bc * u0 * x0 + cc * x0 * x0 - limit * limit,
                );
            }
        }
        let [by_u, by_x] = self.mixed;
        if by_x > 0.0 {
            for side in [by_u, -by_u] {
                span.half_plane(side * u0 + by_x * x0, side * u1 + by_x * x1, limit);
            }
        }
    }
}
