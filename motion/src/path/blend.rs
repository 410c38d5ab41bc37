//! Corners rounded within a tolerance.

use super::join::{SAME_PLACE_M, SAME_TURN, distance};
use super::rotation::{after as turn_after, halves};
use super::{Curve, PathPoint, PieceError, Quintic, SHORTEST_M};
use crate::pose::{is_zero, log};
use crate::scalar::{larger, smaller, within};
use core::f64::consts::PI;
use core::fmt;
use nalgebra::Matrix3;

/// How far a blend may be from the corner that it replaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Position, m, > 0.
    pub metres: f64,
    /// Orientation, rad, > 0.
    pub radians: f64,
}

/// Why a corner cannot be blended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlendError {
    /// A tolerance is not a positive finite number.
    Tolerance,
    /// The second piece does not begin where the first ends.
    Gap,
    /// Less than [`SHORTEST_M`] could be taken off each piece.
    TooShort,
    /// A pose or derivative of the pieces is infinite or not a number.
    NotFinite,
}

impl fmt::Display for BlendError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Tolerance => "a tolerance of the blend is not a positive number",
            Self::Gap => "the second piece does not begin where the first ends",
            Self::TooShort => "the pieces or the tolerance are too short for a blend",
            Self::NotFinite => "a number of the pieces is infinite or not a number",
        })
    }
}

impl core::error::Error for BlendError {}

impl From<PieceError> for BlendError {
    fn from(error: PieceError) -> Self {
        match error {
            PieceError::TooShort => Self::TooShort,
            PieceError::NotFinite
            | PieceError::Collinear
            | PieceError::NoRadius
            | PieceError::NoNormal
            | PieceError::NotEquidistant => Self::NotFinite,
        }
    }
}

/// A blend turns the tool by less than this, rad: far from where the shortest way changes sides.
const MOST_TURN: f64 = 1.5;
/// Ends are moved towards the corner at most so often: bounds the work.
const ATTEMPTS: u32 = 16;
/// A share of the tolerance that need not be improved upon.
const ENOUGH: f64 = 0.91;
/// Deviation is sampled at so many intervals, an even number: the greatest is often right in the middle.
const INTERVALS: u32 = 16;
/// Kept below the tolerance for what lies between samples: where only curvatures differ the deviation changes sides half
/// way, and with `e'' ≤ (2·π)²·e` over the range, `π²/2/16²` of it is 1.9 %. Of that the parabola through the greatest
/// leaves little: it is there for what bends more.
const BETWEEN_SAMPLES: f64 = 0.98;
/// Orientations are compared in f32: what the chord of the angle between them is off at most, rad. A tenth of what
/// counts as the same orientation.
const ROUNDING: f64 = 1e-6;
/// No more of a tolerance is kept free for it than this share: one below 2e-5 rad is kept to [`ROUNDING`].
const BETWEEN_TURNS: f64 = 0.05;
/// The least length of the parameter of a blend, relative to what it replaces.
const LEAST_RATIO: f64 = 0.5;

/// A [`Quintic`] in the place of a corner: leaves the first piece a distance d before its end and enters the
/// second d after its start, with their p, p', p'', R, ω, ω' there.
///
/// d (in the parameter) uses up 0.88 of the tolerance or more, or is half of the shorter piece, so that both
/// ends of a piece can be blended, or as much as turns the tool by 1.5 rad in all. The tolerance bounds the
/// distance between the blend at u and the corner at u, both over \[0, 1\]: that is more than the distance to
/// the nearest point.
///
/// The parameter of a blend has the length `2·d·k`. For unit speed half way through a corner of two lines
/// that turns by α, `k = 15/8·cos(α/2)/(1 + 7/8·cos(α/2))`; of that, from 1 (straight on) to 0 (back), no
/// less than ½ is taken. The same is used for all pieces, with `|p'|` at the corner for 1 (with ω for p'
/// where only the orientation changes). For two lines:
///
/// - `|p'|` is within 0.3 % of 1 for α up to 90°, between 0.96 and 1.003 up to 135°, and never more;
///   beyond, it falls half way to 0.74 at 150° and to 0 at 180°, where the tool turns back;
/// - `|p''| ≤ 3.11·sin(α/2)/(2·d·k)`, and up to 135° the curvature is at most 6 % more than that;
/// - the greatest deviation is `d·2·sin(α/2)·(1/2 − 5/16·k)`, half way.
///
/// Where a line goes over into an arc of radius R without a corner, the curvature stays below 1.12/R and
/// |p'| between 0.93 and 1.06.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blend {
    curve: Quintic,
    distance: f64,
}

impl Blend {
    /// The blend of the corner where the first piece ends and the second begins.
    ///
    /// Work: at most 16 attempts of 15 poses of the blend and of the pieces; one attempt, and no pose, for two lines
    /// that do not turn; of 2000 random corners of arcs nine in ten took one, and none more than four.
    ///
    /// # Errors
    /// [`BlendError`].
    // a frame of its own: a path without corners does not need this much of the stack
    #[inline(never)]
    pub fn between(
        first: &impl Curve,
        second: &impl Curve,
        tolerance: &Tolerance,
    ) -> Result<Self, BlendError> {
        for bound in [tolerance.metres, tolerance.radians] {
            if bound <= 0.0 || !bound.is_finite() {
                return Err(BlendError::Tolerance);
            }
        }
        let corner = Corner::new(first, second)?;
        let mut distance = corner.estimate(tolerance);
        let (mut best, mut too_far) = (None, None);
        for _ in 0..ATTEMPTS {
            if distance < SHORTEST_M {
                break;
            }
            let (from, to) = (corner.at(-distance), corner.at(distance));
            let length = 2.0 * distance * corner.ratio;
            let curve = Quintic::between(&from, &to, length)?;
            let used = corner.deviation(&curve, distance, tolerance) / BETWEEN_SAMPLES;
            if !used.is_finite() {
                return Err(BlendError::NotFinite);
            }
            if used <= 1.0 {
                best = Some(Self { curve, distance });
            } else {
                too_far = Some(distance);
            }
            distance = match (&best, too_far) {
                // between what is too far and what is not, until it is enough
                (Some(best), Some(far)) if !(ENOUGH..=1.0).contains(&used) => {
                    libm::sqrt(best.distance * far)
                }
                (Some(_), _) => break,
                // the deviation grows with d where directions differ, with d² where only curvatures
                // do: the root is the smaller step, and the 1 % ends a series of them
                (None, _) => distance * 0.99 / libm::sqrt(used),
            };
        }
        best.ok_or(BlendError::TooShort)
    }

    /// The blend as a curve.
    #[must_use]
    pub fn curve(&self) -> &Quintic {
        &self.curve
    }

    /// How much of the parameter is taken off the end of the first piece and the start of the second, m.
    #[must_use]
    pub fn distance(&self) -> f64 {
        self.distance
    }
}

/// Two pieces as one path with its corner at 0.
struct Corner<'a, A, B> {
    first: &'a A,
    second: &'a B,
    end: PathPoint,
    start: PathPoint,
    /// Length of the parameter of the blend relative to the corner's.
    ratio: f64,
}

impl<'a, A: Curve, B: Curve> Corner<'a, A, B> {
    fn new(first: &'a A, second: &'a B) -> Result<Self, BlendError> {
        let (end, start) = (first.at(first.length()), second.at(0.0));
        let (metres, radians) = distance(&end.pose, &start.pose);
        if !(metres.is_finite() && radians.is_finite()) {
            return Err(BlendError::NotFinite);
        }
        if metres > SAME_PLACE_M || radians > SAME_TURN {
            return Err(BlendError::Gap);
        }
        let linear = end.first.linear_norm() + start.first.linear_norm();
        let (speeds, sum) = if linear > 0.0 {
            (linear, end.first.linear + start.first.linear)
        } else {
            let angular = end.first.angular_norm() + start.first.angular_norm();
            (angular, end.first.angular + start.first.angular)
        };
        let together = libm::sqrt(sum.dot(&sum));
        // |p'| half way is 15/16·|sum|/k − 7/16·|sum|; wanted is half of both speeds
        let ratio = 0.9375 * together / (0.5 * speeds + 0.4375 * together);
        Ok(Self {
            first,
            second,
            end,
            start,
            ratio: within(ratio, LEAST_RATIO, 1.0),
        })
    }

    /// The path, so far before (negative) or after the corner.
    fn at(&self, s: f64) -> PathPoint {
        if s <= 0.0 {
            self.first.at(self.first.length() + s)
        } else {
            self.second.at(s)
        }
    }

    /// Two lines that do not turn.
    fn is_plain(&self) -> bool {
        let still = |point: &PathPoint| is_zero(point.first.angular.as_slice());
        let straight = self.first.is_straight() && self.second.is_straight();
        straight && still(&self.end) && still(&self.start)
    }

    /// The tolerances, and how far the blend of two lines is from them for each unit of its distance.
    fn jumps(&self, tolerance: &Tolerance) -> [(f64, f64); 2] {
        let per_jump = 0.5 - 0.3125 * self.ratio;
        let linear = self.start.first.linear - self.end.first.linear;
        let angular = self.start.first.angular - self.end.first.angular;
        [(tolerance.metres, linear), (tolerance.radians, angular)]
            .map(|(room, jump)| (room, libm::sqrt(jump.dot(&jump)) * per_jump))
    }

    /// The distance from the corner at which the blend of two lines would use up the tolerance.
    fn estimate(&self, tolerance: &Tolerance) -> f64 {
        let turning = self.start.first.angular_norm() + self.end.first.angular_norm();
        let mut distance = 0.5 * smaller(self.first.length(), self.second.length());
        let [metres, radians] = self.jumps(tolerance);
        for (room, rate) in [metres, radians, (MOST_TURN, turning)] {
            let room = 0.999 * BETWEEN_SAMPLES * room;
            if rate * distance > room {
                distance = room / rate;
            }
        }
        distance
    }

    /// The greatest share of the tolerance that the curve uses up, by samples and the parabola through the greatest.
    ///
    /// Of two lines that do not turn it is known: the [estimate](Self::estimate) is what it says.
    fn deviation(&self, curve: &Quintic, from_corner: f64, tolerance: &Tolerance) -> f64 {
        let mut most = 0.0;
        if self.is_plain() {
            for (room, jump) in self.jumps(tolerance) {
                most = larger(most, jump * from_corner / room);
            }
            return most;
        }
        // as the chord of the angle
        let radians = 2.0 * libm::sin(0.5 * smaller(tolerance.radians, PI));
        let off = smaller(ROUNDING, BETWEEN_TURNS * radians);
        let between = |from: Matrix3<f64>| halves(&log(&(from * curve.turns_from().transpose())));
        let sides = [self.first.turns_from(), self.second.turns_from()].map(between);
        // the last two; nothing at the ends
        let [mut earlier, mut last] = [0.0; 2];
        for i in 1..INTERVALS {
            let u = f64::from(i) / f64::from(INTERVALS);
            let (s, at) = (u * curve.length(), (2.0 * u - 1.0) * from_corner);
            let [before, after] = sides;
            let (position, turn, side) = if at <= 0.0 {
                let at = self.first.length() + at;
                (self.first.position_at(at), self.first.turn_at(at), before)
            } else {
                (self.second.position_at(at), self.second.turn_at(at), after)
            };
            let way = position - curve.position_at(s);
            let (chord, _) =
                turn_after(turn_after(halves(&turn), side), halves(&-curve.turn_at(s)));
            let metres = libm::sqrt(way.dot(&way));
            let chord = 2.0 * f64::from(libm::sqrtf(chord.dot(&chord)));
            if !(metres + chord).is_finite() {
                return f64::INFINITY;
            }
            let next = larger(metres / tolerance.metres, (chord + off) / radians);
            most = larger(most, peak(earlier, last, next));
            (earlier, last) = (last, next);
        }
        larger(most, peak(earlier, last, 0.0))
    }
}

/// The greatest of three values one interval apart, and of the parabola through them where the middle one is.
fn peak(a: f64, b: f64, c: f64) -> f64 {
    let bend = 2.0 * b - a - c;
    if b >= a && b >= c && bend > 0.0 {
        b + (c - a) * (c - a) / (8.0 * bend)
    } else {
        larger(larger(a, b), c)
    }
}
