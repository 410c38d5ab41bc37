//! A checked piece of the path, in the numbers a servo step computes with.
//!
//! Positions are integers, in quanta of an [`Angle`]; velocity and acceleration are f32. With u, the time in the
//! piece over its duration, as a fraction of 32 bits, a position is `c₀ + u(c₁ + u(c₂ + u(c₃ + u(c₄ + u·c₅))))` by
//! five products that are rounded down, and what u leaves of the time, below 2⁻³⁰ of the duration, times the velocity.
//!
//! How far that is from the polynomial, in quanta: at most half for `c₀`, 9/16 for each other coefficient, one for
//! each product, which is rounded down, and one for the last, which is rounded towards 0: 9.4, [`EVALUATION_QUANTA`].
//! The error of the velocity (a few 2⁻²⁴) counts only in that last product. Where a piece begins there is half a
//! quantum alone, so pieces meet within that bound.

use super::rate::PathTime;
use super::segment::Segment;
use super::span::{Part, Span, whole};
use crate::angle::{Angle, times_fraction};
use crate::scalar::narrow;

/// A set-point on a path is at most so many quanta of an [`Angle`] from the polynomial through its knots.
pub const EVALUATION_QUANTA: i64 = 10;

/// A piece begins no farther from 0 than this, in the axis' unit: half of what an [`Angle`] holds.
const MOST_FROM: f64 = 4_194_304.0;
/// The largest sum of a piece's other coefficients by magnitude: 2¹⁸, 2⁵⁸ quanta. So neither a sum of quanta leaves 64
/// bits, nor what u leaves of a way 32.
const MOST_WAY: f64 = 262_144.0;
/// Quanta of an [`Angle`], times 16.
const SIXTEENTHS: f64 = 17_592_186_044_416.0;
/// Why a piece cannot be had in fixed point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Unfixable {
    /// It lasts longer than a [`Span`] can.
    Long,
    /// An axis would go farther than the integers reach: the value and its limit, in the axis' unit.
    Far { axis: usize, value: f64, limit: f64 },
}

/// One polynomial per axis, in u.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FixedSegment<const N: usize> {
    start_us: u64,
    span: Span,
    per_s: f32,
    from: [Angle; N],
    /// Quanta: the coefficients of u to u⁵.
    way: [[i64; 5]; N],
    /// Of the axis' unit per s: the coefficients of 1 to u⁴.
    velocity: [[f32; 5]; N],
}

impl<const N: usize> FixedSegment<N> {
    /// The same piece.
    ///
    /// # Errors
    /// [`Unfixable`].
    pub(crate) fn new(segment: &Segment<N>) -> Result<Self, Unfixable> {
        let start_us = segment.start_us();
        let duration_us = segment.end.at_us.saturating_sub(start_us);
        let per_s = narrow(segment.per_s());
        let mut fixed = Self {
            start_us,
            span: Span::new(duration_us).ok_or(Unfixable::Long)?,
            per_s,
            from: [Angle::ZERO; N],
            way: [[0; 5]; N],
            velocity: [[0.0; 5]; N],
        };
        let into = fixed.way.iter_mut().zip(&mut fixed.velocity);
        let axes = fixed.from.iter_mut().zip(into);
        for (axis, ((from, (way, velocity)), coefficients)) in
            (0..N).zip(axes.zip(segment.coefficients()))
        {
            let [begin, rest @ ..] = coefficients;
            let sum = rest.iter().fold(0.0, |sum, c| sum + libm::fabs(*c));
            for (value, limit) in [(libm::fabs(*begin), MOST_FROM), (sum, MOST_WAY)] {
                if value >= limit {
                    return Err(Unfixable::Far { axis, value, limit });
                }
            }
            *from = Angle::bound(*begin);
            let mut factor = 0.0;
            for ((way, velocity), c) in way.iter_mut().zip(velocity).zip(rest) {
                factor += per_s;
                *way = quanta(*c);
                *velocity = factor * narrow(*c);
            }
        }
        Ok(fixed)
    }

    /// When it begins, path time in µs.
    pub(crate) const fn start_us(&self) -> u64 {
        self.start_us
    }

    /// When it ends, path time in µs.
    pub(crate) const fn end_us(&self) -> u64 {
        self.start_us.saturating_add(self.span.us())
    }

    /// The same piece, begun at another time.
    pub(crate) const fn begun_at(&self, start_us: u64) -> Self {
        Self { start_us, ..*self }
    }

    /// Position, and its first and second derivative with respect to path time, of each axis; `None` at the end and
    /// later.
    #[inline]
    pub(crate) fn at(
        &self,
        path: PathTime,
    ) -> Option<impl Iterator<Item = (Angle, f32, f32)> + '_> {
        let since_us = path.us.saturating_sub(self.start_us);
        let Part { u, left } = self.span.part(since_us, path.fraction)?;
        let share = Part { u, left }.share();
        let derivatives = self.way.iter().zip(&self.velocity);
        let axes = self.from.iter().zip(derivatives);
        Some(axes.map(move |(from, (way, velocity))| {
            let [c1, c2, c3, c4, c5] = *way;
            let [v1, v2, v3, v4, v5] = *velocity;
            let quanta = times_fraction(c5, u).wrapping_add(c4);
            let quanta = times_fraction(quanta, u).wrapping_add(c3);
            let quanta = times_fraction(quanta, u).wrapping_add(c2);
            let quanta = times_fraction(quanta, u).wrapping_add(c1);
            let quanta = times_fraction(quanta, u);
            let v = v1 + share * (v2 + share * (v3 + share * (v4 + share * v5)));
            let a = v2 + share * (2.0 * v3 + share * (3.0 * v4 + share * (4.0 * v5)));
            let further = quanta.wrapping_add(whole(left * v));
            (from.plus(further), v, a * self.per_s)
        }))
    }
}

/// The quanta nearest to a coefficient, to a sixteenth.
#[expect(
    clippy::cast_possible_truncation,
    reason = "below 2^62: their sum was compared"
)]
fn quanta(coefficient: f64) -> i64 {
    ((coefficient * SIXTEENTHS) as i64).wrapping_add(8) >> 4
}
