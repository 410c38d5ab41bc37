//! Polynomials of degree ≤ 5 on \[0, 1\], ascending coefficients, and where they lie there.

use crate::scalar::{larger, smaller};

pub(crate) type Coefficients = [f64; 6];

/// Value, first and second derivative at u.
pub(crate) fn evaluate(c: &Coefficients, u: f64) -> [f64; 3] {
    let [c0, c1, c2, c3, c4, c5] = *c;
    [
        c0 + u * (c1 + u * (c2 + u * (c3 + u * (c4 + u * c5)))),
        c1 + u * (2.0 * c2 + u * (3.0 * c3 + u * (4.0 * c4 + u * 5.0 * c5))),
        2.0 * c2 + u * (6.0 * c3 + u * (12.0 * c4 + u * 20.0 * c5)),
    ]
}

/// The third derivative at u.
pub(crate) fn third(c: &Coefficients, u: f64) -> f64 {
    let [_, _, _, c3, c4, c5] = *c;
    6.0 * c3 + u * (24.0 * c4 + u * 60.0 * c5)
}

/// The quintic through positions, velocities and accelerations at both ends (per unit of u).
pub(crate) fn quintic([p0, v0, a0]: [f64; 3], [p1, v1, a1]: [f64; 3]) -> Coefficients {
    let d = p1 - p0;
    [
        p0,
        v0,
        0.5 * a0,
        10.0 * d - 6.0 * v0 - 4.0 * v1 - 1.5 * a0 + 0.5 * a1,
        -15.0 * d + 8.0 * v0 + 7.0 * v1 + 1.5 * a0 - a1,
        6.0 * d - 3.0 * (v0 + v1) + 0.5 * (a1 - a0),
    ]
}

/// The cubic through positions and velocities at both ends (per unit of u).
pub(crate) fn cubic([p0, v0]: [f64; 2], [p1, v1]: [f64; 2]) -> Coefficients {
    let d = p1 - p0;
    [p0, v0, 3.0 * d - 2.0 * v0 - v1, v0 + v1 - 2.0 * d, 0.0, 0.0]
}

pub(crate) fn derivative(c: &Coefficients) -> Coefficients {
    let [_, c1, c2, c3, c4, c5] = *c;
    [c1, 2.0 * c2, 3.0 * c3, 4.0 * c4, 5.0 * c5, 0.0]
}

/// Intervals that surely hold all values on \[0, 1\] of the polynomial and of its first three derivatives: the hulls
/// of their Bernstein coefficients.
///
/// Those of degree 5 are `b_k = Σ C(k, i)/C(5, i)·c_i`, and those of a derivative are differences of those one
/// degree higher, times that degree. So one conversion serves all four: 32 operations of f64, where each by
/// itself takes 25, and a microcontroller makes 75 instructions of one. The constant is left out of the differences, so that they
/// do not lose to it what digits they have.
pub(crate) fn hulls(c: &Coefficients) -> [(f64, f64); 4] {
    let [c0, c1, c2, c3, c4, c5] = *c;
    let b = [
        0.0,
        0.2 * c1,
        0.4 * c1 + 0.1 * c2,
        0.6 * c1 + 0.3 * c2 + 0.1 * c3,
        0.8 * c1 + 0.6 * c2 + 0.4 * c3 + 0.2 * c4,
        c1 + c2 + c3 + c4 + c5,
    ];
    let (low, high) = hull(&b);
    let d1: [f64; 5] = differences(&b);
    let d2: [f64; 4] = differences(&d1);
    let d3: [f64; 3] = differences(&d2);
    let times = |factor: f64, (low, high): (f64, f64)| (factor * low, factor * high);
    [
        (c0 + low, c0 + high),
        times(5.0, hull(&d1)),
        times(20.0, hull(&d2)),
        times(60.0, hull(&d3)),
    ]
}

fn differences<const N: usize>(b: &[f64]) -> [f64; N] {
    let mut out = [0.0; N];
    for (out, (from, to)) in out.iter_mut().zip(b.iter().zip(b.iter().skip(1))) {
        *out = to - from;
    }
    out
}

fn hull(b: &[f64]) -> (f64, f64) {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for b in b {
        low = smaller(low, *b);
        high = larger(high, *b);
    }
    (low, high)
}

/// The interval of all values on \[0, 1\]: between values at the ends and at the extrema.
///
/// The extrema are isolated from the linear derivative upwards: between neighbouring roots of its
/// derivative a polynomial is monotone and has at most one root, found by bisection.
pub(crate) fn range(c: &Coefficients) -> (f64, f64) {
    let d1 = derivative(c);
    let d2 = derivative(&d1);
    let d3 = derivative(&d2);
    let d4 = derivative(&d3);
    let mut extrema = Points::default();
    for d in [&d4, &d3, &d2, &d1] {
        extrema = roots(d, &extrema);
    }
    let (first, last) = (value(c, 0.0), value(c, 1.0));
    let mut bounds = (smaller(first, last), larger(first, last));
    for u in extrema.iter() {
        let x = value(c, u);
        bounds = (smaller(bounds.0, x), larger(bounds.1, x));
    }
    bounds
}

fn value(c: &Coefficients, u: f64) -> f64 {
    c.iter().rev().fold(0.0, |sum, c| sum * u + c)
}

/// At most five points of (0, 1), ascending.
#[derive(Clone, Copy, Default)]
struct Points {
    at: [f64; 5],
    count: usize,
}

impl Points {
    fn push(&mut self, u: f64) {
        if let Some(place) = self.at.get_mut(self.count) {
            *place = u;
            self.count = self.count.saturating_add(1);
        }
    }

    fn iter(&self) -> impl Iterator<Item = f64> + '_ {
        self.at.iter().copied().take(self.count)
    }
}

/// Where the polynomial changes sign, given points between which it is monotone.
fn roots(c: &Coefficients, monotone_between: &Points) -> Points {
    let mut found = Points::default();
    let mut from = 0.0;
    for to in monotone_between.iter().chain(core::iter::once(1.0)) {
        if value(c, from) * value(c, to) < 0.0 {
            found.push(bisect(c, from, to));
        }
        from = to;
    }
    found
}

/// To 1e-9 of the interval; the error of an extremum is of second order in it.
fn bisect(c: &Coefficients, mut from: f64, mut to: f64) -> f64 {
    let rising = value(c, from) < 0.0;
    for _ in 0..30 {
        let middle = 0.5 * (from + to);
        if (value(c, middle) < 0.0) == rising {
            from = middle;
        } else {
            to = middle;
        }
    }
    0.5 * (from + to)
}

#[cfg(test)]
mod test {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// With rounding of 1e-15 of coefficients up to 600 and, for the third derivative, 60 times 8 of it.
        #[test]
        fn the_ranges_are_inside_the_hulls_which_are_not_much_larger(c in prop::array::uniform6(-10.0..10.0f64)) {
            let mut p = c;
            for (low, high) in hulls(&c) {
                let (inner_low, inner_high) = range(&p);
                prop_assert!(low <= inner_low + 1e-10 && high >= inner_high - 1e-10);
                // a control polygon is within n²/8 of its second differences of the polynomial (n = 5)
                let size = p.iter().fold(0.0, |sum, c| sum + c.abs());
                prop_assert!(high - low <= inner_high - inner_low + 8.0 * size);
                // both ends are control points
                let ends = [value(&p, 0.0), value(&p, 1.0)];
                prop_assert!(ends.iter().all(|x| *x >= low - 1e-10 && *x <= high + 1e-10));
                p = derivative(&p);
            }
        }

        #[test]
        fn hulls_of_straight_lines_are_exact(c0 in -1e3..1e3f64, c1 in -10.0..10.0f64) {
            let [(low, high), (slow, fast), none, nothing] = hulls(&[c0, c1, 0.0, 0.0, 0.0, 0.0]);
            // positions to rounding at 1000
            prop_assert!((low - smaller(c0, c0 + c1)).abs() < 1e-12 && (high - larger(c0, c0 + c1)).abs() < 1e-12);
            prop_assert!((slow - c1).abs() < 1e-13 && (fast - c1).abs() < 1e-13);
            for (low, high) in [none, nothing] {
                prop_assert!(low.abs() < 1e-12 && high.abs() < 1e-12);
            }
        }

        #[test]
        fn the_range_is_tight(c in prop::array::uniform6(-10.0..10.0f64)) {
            let (low, high) = range(&c);
            let (mut seen_low, mut seen_high) = (f64::INFINITY, f64::NEG_INFINITY);
            for i in 0..=2000u32 {
                let x = value(&c, f64::from(i) / 2000.0);
                seen_low = smaller(seen_low, x);
                seen_high = larger(seen_high, x);
            }
            prop_assert!(low <= seen_low + 1e-12 && high >= seen_high - 1e-12);
            // between samples an extremum rises at most max|p''|·h²/8 < 1000·(1/2000)²/8
            prop_assert!(low >= seen_low - 4e-5 && high <= seen_high + 4e-5);
        }

        #[test]
        fn a_quintic_meets_both_ends(start in prop::array::uniform3(-5.0..5.0f64), end in prop::array::uniform3(-5.0..5.0f64)) {
            let c = quintic(start, end);
            for (u, expected) in [(0.0, start), (1.0, end)] {
                for (x, e) in evaluate(&c, u).iter().zip(&expected) {
                    prop_assert!((x - e).abs() < 1e-11);
                }
            }
        }

        #[test]
        fn a_cubic_meets_both_ends(p in prop::array::uniform2(-5.0..5.0f64), v in prop::array::uniform2(-5.0..5.0f64)) {
            let c = cubic([p[0], v[0]], [p[1], v[1]]);
            for (u, i) in [(0.0, 0), (1.0, 1)] {
                let [x, dx, _] = evaluate(&c, u);
                prop_assert!((x - p[i]).abs() < 1e-12 && (dx - v[i]).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn five_extrema_are_all_found() {
        // the Chebyshev polynomial of degree 5 on [0, 1]: four inner extrema at ±1, ends at ±1
        let c = [-1.0, 50.0, -400.0, 1120.0, -1280.0, 512.0];
        let (low, high) = range(&c);
        assert!((low + 1.0).abs() < 1e-12 && (high - 1.0).abs() < 1e-12);
    }
}
