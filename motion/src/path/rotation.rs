//! Orientation along a curve of rotation vectors: `R(s) = exp(φ(s))·R₀`.
//!
//! With `A = φ×φ'`, `B = φ×A` and x = |φ|², the angular velocity in the base frame is
//! `ω = φ' + b(x)·A + c(x)·B`, `b = (1 − cos θ)/θ²`, `c = (θ − sin θ)/θ³` (the left Jacobian of the
//! rotation group); ω' and ω'' follow by the product rule. b and c are entire functions of x, and no
//! closed form is needed: their series serve every angle up to half a turn.

use crate::pose::{SINE_DEFECT as C, VERSINE as B, rodrigues, terms};
use crate::scalar::narrow;
use nalgebra::{Matrix3, RealField, Vector3};

/// A rotation vector (rad) and its first three derivatives.
pub(super) type Jet<T> = [Vector3<T>; 4];

/// Value, first and second derivative by x of a power series in x = θ².
fn series(of: &[f64; 14], x: f64) -> [f64; 3] {
    let (mut value, mut first, mut half_second) = (0.0, 0.0, 0.0);
    for term in terms(of, x) {
        half_second = half_second * x + first;
        first = first * x + value;
        value = value * x + term;
    }
    [value, first, 2.0 * half_second]
}

/// `exp(φ)`, and ω, ω', ω'' of it, in the frame in which φ is given; |φ| at most π.
pub(super) fn along(jet: Jet<f64>) -> (Matrix3<f64>, [Vector3<f64>; 3]) {
    let [w, ..] = jet;
    let x = w.dot(&w);
    let (b, c) = (series(&B, x), series(&C, x));
    let ([b0, ..], [c0, ..]) = (b, c);
    // sin θ/θ = 1 − x·c
    (rodrigues(&w, 1.0 - x * c0, b0), angular(jet, b, c))
}

/// ω, ω', ω'' in f32.
pub(super) fn velocity(jet: Jet<f32>) -> [Vector3<f32>; 3] {
    let [w, ..] = jet;
    let x = w.dot(&w);
    // half the terms: the next is 1e-9 at θ = π
    let few = |of: &[f64; 14]| {
        let (mut value, mut first, mut half_second) = (0.0, 0.0, 0.0);
        for term in of.iter().take(9).rev() {
            half_second = half_second * x + first;
            first = first * x + value;
            value = value * x + narrow(*term);
        }
        [value, first, 2.0 * half_second]
    };
    angular(jet, few(&B), few(&C))
}

/// ω, ω', ω'' with b and c and their derivatives by x.
fn angular<T: RealField + Copy>(
    [w, w1, w2, w3]: Jet<T>,
    [b, bx, bxx]: [T; 3],
    [c, cx, cxx]: [T; 3],
) -> [Vector3<T>; 3] {
    let twice = |x: T| x + x;
    let x1 = twice(w.dot(&w1));
    let x2 = twice(w1.dot(&w1) + w.dot(&w2));
    let (b1, c1) = (bx * x1, cx * x1);
    let (b2, c2) = (bxx * x1 * x1 + bx * x2, cxx * x1 * x1 + cx * x2);
    // A, A', A'' and B, B', B''
    let (once, once1) = (cross(&w, &w1), cross(&w, &w2));
    let once2 = cross(&w1, &w2) + cross(&w, &w3);
    let (both, both1) = (cross(&w, &once), cross(&w1, &once) + cross(&w, &once1));
    let middle = cross(&w1, &once1);
    let both2 = cross(&w2, &once) + middle + middle + cross(&w, &once2);
    [
        sum(w1, [(once, b), (both, c)]),
        sum(w2, [(once, b1), (once1, b), (both, c1), (both1, c)]),
        sum(
            w3,
            [
                (once, b2),
                (once1, twice(b1)),
                (once2, b),
                (both, c2),
                (both1, twice(c1)),
                (both2, c),
            ],
        ),
    ]
}

/// One copy of what would be dozens.
#[inline(never)]
fn cross<T: RealField + Copy>(a: &Vector3<T>, b: &Vector3<T>) -> Vector3<T> {
    a.cross(b)
}

#[inline(never)]
fn scaled<T: RealField + Copy>(a: &Vector3<T>, by: T) -> Vector3<T> {
    Vector3::new(a.x * by, a.y * by, a.z * by)
}

fn sum<T: RealField + Copy, const K: usize>(
    first: Vector3<T>,
    rest: [(Vector3<T>, T); K],
) -> Vector3<T> {
    rest.iter()
        .fold(first, |sum, (term, by)| sum + scaled(term, *by))
}

/// Sine of half the angle times the axis, and its cosine, by series in f32: the next term is 1e-9 at π.
pub(super) fn halves(turn: &Vector3<f64>) -> (Vector3<f32>, f32) {
    let half = turn.map(narrow) * 0.5;
    let x = half.dot(&half);
    let sum = |of: &[f64; 14]| {
        let terms = of.iter().take(7).rev();
        terms.fold(0.0, |sum, term| sum * x + narrow(*term))
    };
    (half * (1.0 - x * sum(&C)), 1.0 - x * sum(&B))
}

/// Two rotations, each [given](halves) by its half angle, one after the other: the first argument is the last.
pub(super) fn after(
    (v, c): (Vector3<f32>, f32),
    (w, d): (Vector3<f32>, f32),
) -> (Vector3<f32>, f32) {
    (v * d + w * c + v.cross(&w), c * d - v.dot(&w))
}

/// φ' and φ'' that make ω and ω' at φ: the inverse of [`along`], for |φ| at most π/2.
///
/// The inverse of the left Jacobian is `I − ½[φ]ₓ + e·[φ]ₓ²` with `e = (b − 2c)/(2·sin θ/θ)`.
pub(super) fn rates(
    w: Vector3<f64>,
    angular: Vector3<f64>,
    angular1: Vector3<f64>,
) -> [Vector3<f64>; 2] {
    let x = w.dot(&w);
    let ([b, bx, _], [c, cx, _]) = (series(&B, x), series(&C, x));
    let e = (b - 2.0 * c) / (2.0 * (1.0 - x * c));
    let solve = |v: Vector3<f64>| {
        let once = cross(&w, &v);
        v - once * 0.5 + scaled(&cross(&w, &once), e)
    };
    let w1 = solve(angular);
    let x1 = 2.0 * w.dot(&w1);
    let once = cross(&w, &w1);
    // what ω' holds beside the Jacobian times φ''
    let rest =
        scaled(&once, bx * x1) + scaled(&cross(&w, &once), cx * x1) + scaled(&cross(&w1, &once), c);
    [w1, solve(angular1 - rest)]
}

#[cfg(test)]
mod test {
    use super::*;
    use crate::pose::{exp, log};
    use core::f64::consts::PI;
    use proptest::prelude::*;

    fn vector(most: f64) -> impl Strategy<Value = Vector3<f64>> {
        prop::array::uniform3(-most..most).prop_map(Vector3::from)
    }

    /// φ(s) as a cubic, so that differences of ω are checked against ω' and ω''.
    fn cubic([w, w1, w2, w3]: Jet<f64>, s: f64) -> Jet<f64> {
        [
            w + w1 * s + w2 * (s * s / 2.0) + w3 * (s * s * s / 6.0),
            w1 + w2 * s + w3 * (s * s / 2.0),
            w2 + w3 * s,
            w3,
        ]
    }

    proptest! {
        #[test]
        fn the_series_are_the_closed_forms(angle in 0.05..PI) {
            let x = angle * angle;
            let (b, c) = (series(&B, x)[0], series(&C, x)[0]);
            // cancellation in the closed forms: 1e-16/θ², 1e-16/θ³
            prop_assert!((b - (1.0 - libm::cos(angle)) / x).abs() < 4e-16 / x + 2e-16);
            prop_assert!((c - (angle - libm::sin(angle)) / (x * angle)).abs() < 4e-16 / (x * angle) + 2e-16);
        }

        #[test]
        fn derivatives_of_the_orientation_are_its_differences(w in vector(1.7), w1 in vector(2.0), w2 in vector(2.0), w3 in vector(2.0)) {
            let (jet, h) = ([w, w1, w2, w3], 1e-3);
            prop_assume!(w.norm() < 3.0);
            let (r, [o, o1, o2]) = along(jet);
            prop_assert!((r - exp(w)).norm() < 1e-14);
            let (before, after) = (along(cubic(jet, -h)), along(cubic(jet, h)));
            // of fourth order in rates up to 4 per unit: h²/6·4³·few; measured 4e-5
            let spin = log(&(after.0 * before.0.transpose())) / (2.0 * h);
            prop_assert!((spin - o).norm() < 1e-4, "{}", (spin - o).norm());
            let o1_seen = (after.1[0] - before.1[0]) / (2.0 * h);
            prop_assert!((o1_seen - o1).norm() < 1e-3, "{}", (o1_seen - o1).norm());
            let o2_seen = (after.1[1] - before.1[1]) / (2.0 * h);
            prop_assert!((o2_seen - o2).norm() < 1e-2, "{}", (o2_seen - o2).norm());
        }

        #[test]
        fn the_velocity_in_short_is_that_of_f64(w in vector(1.7), w1 in vector(2.0), w2 in vector(2.0), w3 in vector(2.0)) {
            prop_assume!(w.norm() < 3.0);
            let (_, long) = along([w, w1, w2, w3]);
            let short = velocity([w, w1, w2, w3].map(|v| v.map(narrow)));
            // 6e-8 of the largest of some tens of terms, up to 4, 10 and 40
            for (order, most) in [2e-6, 1e-5, 5e-5].into_iter().enumerate() {
                let off = (short[order].map(f64::from) - long[order]).norm();
                prop_assert!(off < most, "{order}: {off:e}");
            }
        }

        #[test]
        fn half_angles_compose_as_rotations_do(v in vector(1.7), w in vector(1.7)) {
            prop_assume!(v.norm() < 3.0 && w.norm() < 3.0);
            let (both, _) = after(halves(&v), halves(&w));
            let angle = log(&(exp(v) * exp(w))).norm();
            // some units of 6e-8
            prop_assert!((f64::from(both.norm()) - libm::sin(0.5 * angle)).abs() < 4e-7);
        }

        #[test]
        fn rates_invert_the_derivatives(w in vector(0.9), w1 in vector(2.0), w2 in vector(2.0)) {
            let (_, [o, o1, _]) = along([w, w1, w2, Vector3::zeros()]);
            let [got1, got2] = rates(w, o, o1);
            prop_assert!((got1 - w1).norm() < 1e-14 && (got2 - w2).norm() < 1e-13);
        }
    }
}
