//! The quintic between two points of a path: equal to both in pose, first and second derivative.

use super::{Curve, PathPoint, PieceError, SHORTEST_M, is_finite, reach, rotation};
use crate::polynomial::{Coefficients, evaluate, quintic, third};
use crate::pose::{Pose, exp, is_zero, log};
use crate::scalar::narrow;
use crate::twist::Twist;
use nalgebra::{Matrix3, Vector3};

/// A curve whose position and rotation vector are polynomials of degree 5 in s.
///
/// The rotation vector is relative to the orientation half way between both ends, so that the curve is the
/// same in both directions; `p, p', p''` and `R, ω, ω'` at the ends are those given. The orientations of the
/// ends differ by at most half a turn: the shortest way is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quintic {
    origin: Vector3<f64>,
    middle: Matrix3<f64>,
    /// Position relative to the origin (m), rotation vector relative to the middle (rad); over \[0, 1\].
    axes: [Coefficients; 6],
    length: f64,
}

impl Quintic {
    /// From one point to another, over a range `length` (m) of the parameter in which both points'
    /// derivatives are given. The third derivatives are not looked at.
    ///
    /// # Errors
    /// [`PieceError::NotFinite`]; [`PieceError::TooShort`] if the range is less than [`SHORTEST_M`].
    pub fn between(from: &PathPoint, to: &PathPoint, length: f64) -> Result<Self, PieceError> {
        if !(is_finite(&from.pose) && is_finite(&to.pose) && length.is_finite()) {
            return Err(PieceError::NotFinite);
        }
        if length < SHORTEST_M {
            return Err(PieceError::TooShort);
        }
        let half = log(&(to.pose.rotation * from.pose.rotation.transpose())) * 0.5;
        let origin = from.pose.position;
        let start = jets(from, Vector3::zeros(), -half, length);
        let end = jets(to, to.pose.position - origin, half, length);
        let mut axes = [[0.0; 6]; 6];
        for ((axis, start), end) in axes.iter_mut().zip(start).zip(end) {
            *axis = quintic(start, end);
        }
        if !axes.as_flattened().iter().all(|c| c.is_finite()) {
            return Err(PieceError::NotFinite);
        }
        Ok(Self {
            origin,
            middle: exp(half) * from.pose.rotation,
            axes,
            length,
        })
    }

    /// Whether the orientation changes at all.
    fn turns(&self) -> bool {
        let [_, _, _, turning @ ..] = &self.axes;
        !is_zero(turning.as_flattened())
    }

    /// Position from the origin and rotation vector from the middle.
    fn values(&self, s: f64) -> [Vector3<f64>; 2] {
        let u = reach(s, self.length) / self.length;
        let at = |axis: &Coefficients| axis.iter().rev().fold(0.0, |sum, c| sum * u + c);
        let [x, y, z, turning @ ..] = &self.axes;
        let mut turn = Vector3::zeros();
        if self.turns() {
            let [a, b, c] = turning;
            turn = Vector3::new(at(a), at(b), at(c));
        }
        [Vector3::new(at(x), at(y), at(z)), turn]
    }
}

/// Value, first and second derivative over \[0, 1\] of the six axes.
fn jets(point: &PathPoint, at: Vector3<f64>, turn: Vector3<f64>, length: f64) -> [[f64; 3]; 6] {
    let [turn1, turn2] = rotation::rates(turn, point.first.angular, point.second.angular);
    let (p1, p2) = (point.first.linear, point.second.linear);
    let (h, hh) = (length, length * length);
    let [[x, y, z]] = at.data.0;
    let [[x1, y1, z1]] = (p1 * h).data.0;
    let [[x2, y2, z2]] = (p2 * hh).data.0;
    let [[a, b, c]] = turn.data.0;
    let [[a1, b1, c1]] = (turn1 * h).data.0;
    let [[a2, b2, c2]] = (turn2 * hh).data.0;
    [
        [x, x1, x2],
        [y, y1, y2],
        [z, z1, z2],
        [a, a1, a2],
        [b, b1, b2],
        [c, c1, c2],
    ]
}

impl Curve for Quintic {
    fn length(&self) -> f64 {
        self.length
    }

    fn at(&self, s: f64) -> PathPoint {
        let h = self.length;
        let (u, per_h) = (reach(s, h) / h, 1.0 / h);
        let powers = [per_h, per_h * per_h, per_h * per_h * per_h];
        let jet = |axis: &Coefficients| {
            let [value, first, second] = evaluate(axis, u);
            let [by1, by2, by3] = powers;
            [value, first * by1, second * by2, third(axis, u) * by3]
        };
        let [x, y, z, turning @ ..] = &self.axes;
        let [p, p1, p2, p3] = transpose(jet(x), jet(y), jet(z));
        let (rotation, [w, w1, w2]) = if self.turns() {
            let [a, b, c] = turning.each_ref().map(jet);
            let (turned, rates) = rotation::along(transpose(a, b, c));
            (turned * self.middle, rates)
        } else {
            (self.middle, [Vector3::zeros(); 3])
        };
        PathPoint {
            pose: Pose {
                position: self.origin + p,
                rotation,
            },
            first: Twist {
                linear: p1,
                angular: w,
            },
            second: Twist {
                linear: p2,
                angular: w1,
            },
            third: Twist {
                linear: p3,
                angular: w2,
            },
        }
    }

    fn followed_at(&self, s: f64) -> PathPoint {
        let u = narrow(reach(s, self.length) / self.length);
        let per_h = 1.0 / narrow(self.length);
        let [x, y, z, a, b, c] = self.axes.each_ref().map(|axis| rates(axis, u, per_h));
        let [p1, p2, p3] = columns(x, y, z);
        let [position, turn] = self.values(s);
        let (mut rotation, mut angular) = (self.middle, [Vector3::zeros(); 3]);
        if self.turns() {
            let [w1, w2, w3] = columns(a, b, c);
            rotation = exp(turn) * self.middle;
            angular = rotation::velocity([turn.map(narrow), w1, w2, w3]);
        }
        let [w, w1, w2] = angular;
        let twist = |linear: Vector3<f32>, angular: Vector3<f32>| Twist {
            linear: linear.map(f64::from),
            angular: angular.map(f64::from),
        };
        PathPoint {
            pose: Pose {
                position: self.origin + position,
                rotation,
            },
            first: twist(p1, w),
            second: twist(p2, w1),
            third: twist(p3, w2),
        }
    }

    fn position_at(&self, s: f64) -> Vector3<f64> {
        let [position, _] = self.values(s);
        self.origin + position
    }

    fn turns_from(&self) -> Matrix3<f64> {
        self.middle
    }

    fn turn_at(&self, s: f64) -> Vector3<f64> {
        let [_, turn] = self.values(s);
        turn
    }
}

/// The first three derivatives by s of an axis, in f32.
#[inline(never)]
fn rates(axis: &Coefficients, u: f32, per_h: f32) -> [f32; 3] {
    let [_, c1, c2, c3, c4, c5] = axis.map(narrow);
    [
        (c1 + u * (2.0 * c2 + u * (3.0 * c3 + u * (4.0 * c4 + u * 5.0 * c5)))) * per_h,
        (2.0 * c2 + u * (6.0 * c3 + u * (12.0 * c4 + u * 20.0 * c5))) * per_h * per_h,
        (6.0 * c3 + u * (24.0 * c4 + u * 60.0 * c5)) * per_h * per_h * per_h,
    ]
}

/// Three axes' rates as vectors, one for each order.
fn columns(x: [f32; 3], y: [f32; 3], z: [f32; 3]) -> [Vector3<f32>; 3] {
    let ([x1, x2, x3], [y1, y2, y3], [z1, z2, z3]) = (x, y, z);
    [
        Vector3::new(x1, y1, z1),
        Vector3::new(x2, y2, z2),
        Vector3::new(x3, y3, z3),
    ]
}

/// Three axes' derivatives as derivatives of a vector.
fn transpose(x: [f64; 4], y: [f64; 4], z: [f64; 4]) -> [Vector3<f64>; 4] {
    let [x0, x1, x2, x3] = x;
    let [y0, y1, y2, y3] = y;
    let [z0, z1, z2, z3] = z;
    [
        Vector3::new(x0, y0, z0),
        Vector3::new(x1, y1, z1),
        Vector3::new(x2, y2, z2),
        Vector3::new(x3, y3, z3),
    ]
}
