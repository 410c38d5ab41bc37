//! Numbers along a path with their first three derivatives, in f32: the product rule and what follows from it.
//!
//! A processor with f32 makes a product of two in some thirty instructions, where one of f64 alone takes a hundred. Each
//! operation is off by some units of 6e-8 of the largest term. Differences lose digits where they come close to 0, so
//! whoever knows such a value better [says it](Jet::with_value).

use crate::narrow::narrow;
use core::ops::{Add, Mul, Sub};

/// A value and its first three derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Jet(pub(crate) [f32; 4]);

/// Sine and cosine of an angle along a path, and the angle's derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Turn {
    pub(crate) sine: Jet,
    pub(crate) cosine: Jet,
    pub(crate) rates: [f32; 3],
}

impl Jet {
    /// The same with the value known.
    pub(crate) fn with_value(self, value: f64) -> Self {
        let Self([_, a, b, c]) = self;
        Self([narrow(value), a, b, c])
    }

    /// The same derivatives of a value that is so much more.
    pub(crate) fn plus(self, by: f32) -> Self {
        let Self([v, a, b, c]) = self;
        Self([v + by, a, b, c])
    }
}

impl Add for Jet {
    type Output = Self;
    #[inline(never)]
    fn add(self, Self([b0, b1, b2, b3]): Self) -> Self {
        let Self([a0, a1, a2, a3]) = self;
        Self([a0 + b0, a1 + b1, a2 + b2, a3 + b3])
    }
}

impl Sub for Jet {
    type Output = Self;
    #[inline(never)]
    fn sub(self, Self([b0, b1, b2, b3]): Self) -> Self {
        let Self([a0, a1, a2, a3]) = self;
        Self([a0 - b0, a1 - b1, a2 - b2, a3 - b3])
    }
}

impl Mul<f32> for Jet {
    type Output = Self;
    fn mul(self, by: f32) -> Self {
        Self(self.0.map(|a| a * by))
    }
}

impl Mul for Jet {
    type Output = Self;
    // one copy: an inverse kinematics has dozens of them
    #[inline(never)]
    fn mul(self, Self([b0, b1, b2, b3]): Self) -> Self {
        let Self([a0, a1, a2, a3]) = self;
        Self([
            a0 * b0,
            a1 * b0 + a0 * b1,
            a2 * b0 + 2.0 * (a1 * b1) + a0 * b2,
            a3 * b0 + 3.0 * (a2 * b1 + a1 * b2) + a0 * b3,
        ])
    }
}

/// The derivatives of the angle of the point (x, y): θ' = (x·y' − y·x')/(x² + y²), and twice the product rule.
#[inline(never)]
pub(crate) fn angle_rates(y: Jet, x: Jet) -> [f32; 3] {
    let (Jet([y0, y1, y2, y3]), Jet([x0, x1, x2, x3])) = (y, x);
    let n0 = x0 * y1 - y0 * x1;
    let n1 = x0 * y2 - y0 * x2;
    let n2 = x1 * y2 + x0 * y3 - y1 * x2 - y0 * x3;
    let d1 = 2.0 * (x0 * x1 + y0 * y1);
    let d2 = 2.0 * (x1 * x1 + x0 * x2 + y1 * y1 + y0 * y2);
    let per_d = 1.0 / (x0 * x0 + y0 * y0);
    let first = n0 * per_d;
    let second = (n1 - first * d1) * per_d;
    let third = (n2 - 2.0 * second * d1 - first * d2) * per_d;
    [first, second, third]
}

impl Turn {
    /// Of an angle with these derivatives, with its sine and cosine.
    #[inline(never)]
    pub(crate) fn new(rates: [f32; 3], sine: f64, cosine: f64) -> Self {
        let (s, c) = (narrow(sine), narrow(cosine));
        let [a, b, d] = rates;
        let (square, cube) = (a * a, a * a * a);
        Self {
            sine: Jet([
                s,
                c * a,
                c * b - s * square,
                c * (d - cube) - 3.0 * s * a * b,
            ]),
            cosine: Jet([
                c,
                -s * a,
                -s * b - c * square,
                -s * (d - cube) - 3.0 * c * a * b,
            ]),
            rates,
        }
    }
}

#[cfg(test)]
mod test {
    use super::*;
    use proptest::prelude::*;

    /// A quintic and its derivatives in f64.
    fn quintic(c: &[f64; 6], s: f64) -> [f64; 4] {
        let [a, b, d, e, f, g] = *c;
        [
            a + s * (b + s * (d + s * (e + s * (f + s * g)))),
            b + s * (2.0 * d + s * (3.0 * e + s * (4.0 * f + s * 5.0 * g))),
            2.0 * d + s * (6.0 * e + s * (12.0 * f + s * 20.0 * g)),
            6.0 * e + s * (24.0 * f + s * 60.0 * g),
        ]
    }

    fn near(is: &[f32], wanted: &[f64], most: f64) -> Result<(), TestCaseError> {
        for (is, wanted) in is.iter().zip(wanted) {
            prop_assert!((f64::from(*is) - wanted).abs() < most, "{is} {wanted}");
        }
        Ok(())
    }

    /// First and second derivative of f by central differences, to a part in 1e7 here.
    fn rates(f: impl Fn(f64) -> f64) -> [f64; 2] {
        let h = 1e-3;
        let (b2, b1, q, a1, a2) = (f(-2.0 * h), f(-h), f(0.0), f(h), f(2.0 * h));
        [
            (8.0 * (a1 - b1) - (a2 - b2)) / (12.0 * h),
            (16.0 * (a1 + b1) - (a2 + b2) - 30.0 * q) / (12.0 * h * h),
        ]
    }

    proptest! {
        #[test]
        fn products_and_angles_have_the_derivatives_of_their_differences(a in prop::array::uniform6(-1.0..1.0f64), b in prop::array::uniform6(-1.0..1.0f64)) {
            let jet = |c: &[f64; 6]| Jet(quintic(c, 0.0).map(narrow));
            let Jet(product) = jet(&a) * jet(&b);
            let value = |s: f64| quintic(&a, s)[0] * quintic(&b, s)[0];
            // f32 of terms up to 60
            near(&product[..1], &[value(0.0)], 1e-6)?;
            near(&product[1..3], &rates(value), 1e-5)?;
            let first = |s: f64| {
                let ([a0, a1, ..], [b0, b1, ..]) = (quintic(&a, s), quintic(&b, s));
                a1 * b0 + a0 * b1
            };
            near(&product[1..], &[first(0.0), rates(first)[0], rates(first)[1]], 1e-4)?;
            // the angle of (a, b), away from the origin
            let square = a[0] * a[0] + b[0] * b[0];
            prop_assume!(square > 0.25);
            let turning = |s: f64| {
                let ([a0, a1, ..], [b0, b1, ..]) = (quintic(&a, s), quintic(&b, s));
                (b0 * a1 - a0 * b1) / (a0 * a0 + b0 * b0)
            };
            let [first, second] = rates(turning);
            let seen = angle_rates(jet(&a), jet(&b));
            near(&seen, &[turning(0.0), first, second], 1e-3)?;
            // sine and cosine of it
            let r = libm::sqrt(square);
            let turn = Turn::new(seen, a[0] / r, b[0] / r);
            let angle = |s: f64| libm::atan2(quintic(&a, s)[0], quintic(&b, s)[0]);
            for (jet, f) in [(turn.sine, libm::sin as fn(f64) -> f64), (turn.cosine, libm::cos)] {
                let [first, second] = rates(|s| f(angle(s)));
                near(&jet.0, &[f(angle(0.0)), first, second], 1e-3)?;
                // the third as the first derivative of the second
                let [third, _] = rates(|t| rates(|s| f(angle(s + t)))[1]);
                near(&jet.0[3..], &[third], 0.02)?;
            }
        }
    }
}
