//! The cubic spline through a few points: its first two derivatives at one of them.

use nalgebra::Vector6;

/// A position (m) and a rotation vector (rad).
pub(super) type Value = Vector6<f64>;

/// Points of a window.
pub(super) const MOST: usize = 7;

/// A point of the spline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Knot {
    /// Distance in the parameter to the knot before, > 0; of no meaning for the first.
    pub(super) step: f64,
    pub(super) value: Value,
}

/// First and second derivative at one of the knots, of which there may be [`MOST`]; 0 if there is none.
///
/// The cubic B-spline with as many coefficients as points: its third derivative does not jump at the
/// second and the last but one ("not a knot"). Through four points it is one cubic, through three a
/// parabola, through two a line.
pub(super) fn derivatives(knots: &[Knot], at: usize) -> [Value; 2] {
    let seconds = seconds(knots);
    let second = |i: usize| seconds.get(i).copied().unwrap_or_default();
    let here = second(at);
    let value = |i: usize| knots.get(i).map(|knot| knot.value);
    let after = at.saturating_add(1);
    let first = match (value(at), knots.get(after)) {
        (Some(value), Some(next)) => {
            let slope = (next.value - value) / next.step;
            slope - (here * 2.0 + second(after)) * (next.step / 6.0)
        }
        // the last knot: from its left
        (Some(value), None) => match (at.checked_sub(1), knots.get(at)) {
            (Some(before), Some(knot)) => {
                let from = knots.get(before).map_or(value, |before| before.value);
                (value - from) / knot.step + (second(before) + here * 2.0) * (knot.step / 6.0)
            }
            _ => Value::zeros(),
        },
        (None, _) => Value::zeros(),
    };
    [first, here]
}

/// The second derivatives M at all knots.
///
/// Continuity of the first derivative at each inner knot, between steps h and k:
/// `h·M₋ + 2·(h + k)·M + k·M₊ = 6·(slope after − slope before)`. Where the first of them is the second
/// knot, `M₋ = ((h + k)·M − h·M₊)/k` is put in, and likewise at the end. What is left is tridiagonal and
/// diagonally dominant for all positive steps.
fn seconds(knots: &[Knot]) -> [Value; MOST] {
    let mut m = [Value::zeros(); MOST];
    if let [a, b, c] = knots {
        let bend = (c.value - b.value) / c.step - (b.value - a.value) / b.step;
        return [bend * (2.0 / (b.step + c.step)); MOST];
    }
    let Some(rows) = knots.len().checked_sub(2).filter(|rows| *rows >= 2) else {
        return m;
    };
    // elimination: M = right − upper·M₊
    let mut eliminated = [(0.0, Value::zeros()); MOST];
    let (mut upper, mut right) = (0.0, Value::zeros());
    for ((i, three), row) in (0..MOST).zip(knots.windows(3)).zip(&mut eliminated) {
        let [before, here, after] = three else {
            continue;
        };
        let (h, k) = (here.step, after.step);
        let bend = (after.value - here.value) / k - (here.value - before.value) / h;
        let (mut low, mut diagonal, mut high) = (h, 2.0 * (h + k), k);
        if i == 0 {
            diagonal += h * (h + k) / k;
            high -= h * h / k;
            low = 0.0;
        }
        if i.saturating_add(1) == rows {
            diagonal += k * (h + k) / h;
            low -= k * k / h;
            high = 0.0;
        }
        let pivot = diagonal - low * upper;
        right = (bend * 6.0 - right * low) / pivot;
        upper = high / pivot;
        *row = (upper, right);
    }
    let mut after = Value::zeros();
    let inner = m.iter_mut().skip(1).zip(&eliminated).take(rows);
    for (m, (upper, right)) in inner.rev() {
        *m = right - after * *upper;
        after = *m;
    }
    if let (Some([_, second, third, ..]), [first, one, two, ..]) = (knots.get(..3), &mut m) {
        let (h, k) = (second.step, third.step);
        *first = (*one * (h + k) - *two * h) / k;
    }
    let of_knots = m.get_mut(..knots.len()).unwrap_or_default();
    if let ([.., inner, outer], [.., two, one, end]) = (knots, of_knots) {
        let (h, k) = (inner.step, outer.step);
        *end = (*one * (h + k) - *two * k) / h;
    }
    m
}

#[cfg(test)]
mod test {
    extern crate std;
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    fn knots(steps: &[f64], f: impl Fn(f64) -> f64) -> Vec<Knot> {
        let mut t = 0.0;
        let knot = |step: &f64| {
            t += step;
            Knot {
                step: *step,
                value: Value::repeat(f(t)),
            }
        };
        steps.iter().map(knot).collect()
    }

    proptest! {
        #[test]
        fn cubics_are_reproduced_through_four_points_or_more(steps in prop::collection::vec(0.1..2.0f64, 4..=MOST), c in prop::array::uniform4(-2.0..2.0f64), which in 0..MOST) {
            let at = which % steps.len();
            let t: f64 = steps[..=at].iter().sum();
            let knots = knots(&steps, |t| c[0] + t * (c[1] + t * (c[2] + t * c[3])));
            let [first, second] = derivatives(&knots, at);
            let expected = [c[1] + t * (2.0 * c[2] + 3.0 * t * c[3]), 2.0 * c[2] + 6.0 * t * c[3]];
            // values up to 1e4 at t ≤ 14, steps down to 0.1: 1e4·1e-16/0.1² and the sum of steps
            prop_assert!((first[0] - expected[0]).abs() < 1e-8 && (second[0] - expected[1]).abs() < 1e-7, "{first} {second} {expected:?}");
        }

        #[test]
        fn parabolas_are_reproduced_through_three_points(steps in prop::array::uniform3(0.1..2.0f64), c in prop::array::uniform3(-2.0..2.0f64), at in 0..3usize) {
            let t: f64 = steps[..=at].iter().sum();
            let [first, second] = derivatives(&knots(&steps, |t| c[0] + t * (c[1] + t * c[2])), at);
            prop_assert!((first[0] - c[1] - 2.0 * t * c[2]).abs() < 1e-11 && (second[0] - 2.0 * c[2]).abs() < 1e-10);
        }
    }

    #[test]
    fn two_points_make_a_line_and_one_a_rest() {
        let line = knots(&[0.3, 0.5], |t| 4.0 * t);
        for at in [0, 1] {
            let [first, second] = derivatives(&line, at);
            assert!((first[0] - 4.0).abs() < 1e-15 && second[0] == 0.0);
        }
        assert_eq!(derivatives(&line[..1], 0), [Value::zeros(); 2]);
        assert_eq!(derivatives(&line, 2), [Value::zeros(); 2]);
    }
}
