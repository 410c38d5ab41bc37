//! Comparisons and conversions of numbers that behave alike on every target.

/// Microseconds in one second.
pub(crate) const US_PER_S: f64 = 1e6;

/// The larger of two numbers; the first when they compare equal or not at all.
pub(crate) fn larger<T: PartialOrd>(a: T, b: T) -> T {
    if b > a { b } else { a }
}

/// The smaller of two numbers; the first when they compare equal or not at all.
pub(crate) fn smaller<T: PartialOrd>(a: T, b: T) -> T {
    if b < a { b } else { a }
}

/// `x` moved into `[lower, upper]`.
pub(crate) fn within(x: f64, lower: f64, upper: f64) -> f64 {
    larger(smaller(x, upper), lower)
}

/// The cube root, off by some units in the last place: Newton's method from a third of the exponent, which is within 5 %.
///
/// That of libm takes products and sums with one rounding, which a processor without them makes of many instructions.
pub(crate) fn cube_root(x: f64) -> f64 {
    /// ⅔ of the exponent of 1, with what makes the error the same on both sides, in the upper half (W. Kahan).
    const THIRD: u32 = 715_094_163;
    let size = libm::fabs(x);
    if size <= 0.0 || !size.is_finite() {
        return x;
    }
    let [.., a, b, c, d] = size.to_bits().to_le_bytes();
    let upper = (u32::from_le_bytes([a, b, c, d]) / 3).saturating_add(THIRD);
    let mut root = f64::from_bits(u64::from(upper) << 32);
    // errors 5 %, 0.25 %, 6e-6, 4e-11, and rounding
    for _ in 0..4 {
        root = (2.0 * root + size / (root * root)) * (1.0 / 3.0);
    }
    if x < 0.0 { -root } else { root }
}

/// -1, 0 or 1.
pub(crate) fn sign(x: f64) -> f64 {
    if x > 0.0 {
        1.0
    } else if x < 0.0 {
        -1.0
    } else {
        0.0
    }
}

/// An integer number of microseconds as a float: exact below 2^53 µs (285 years).
#[expect(
    clippy::cast_precision_loss,
    reason = "differences of times: far below 2^53 µs"
)]
pub(crate) fn float_us(us: u64) -> f64 {
    us as f64
}

/// The whole microseconds of a time ≥ 0 and the remaining fraction, in \[0, 1).
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a float to integer cast saturates, and the argument is not negative"
)]
pub(crate) fn split_us(us: f64) -> (u64, f64) {
    let whole = libm::floor(us);
    (whole as u64, us - whole)
}

/// 1/6: multiplied, where a division would cost ten times as much.
pub(crate) const SIXTH: f64 = 1.0 / 6.0;

/// The nearest float of 32 bits.
#[expect(clippy::cast_possible_truncation, reason = "24 bits are enough")]
pub(crate) const fn narrow(x: f64) -> f32 {
    x as f32
}

#[cfg(test)]
mod test {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_cube_root_is_one(exponent in -300.0..300.0f64) {
            let x = libm::pow(10.0, exponent);
            for x in [x, -x] {
                // rounding of the last step
                prop_assert!((cube_root(x) / libm::cbrt(x) - 1.0).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn what_has_no_cube_root_of_its_own_is_left_alone() {
        assert_eq!(cube_root(0.0).to_bits(), 0);
        assert!(cube_root(f64::INFINITY).is_infinite());
        assert!(cube_root(f64::NAN).is_nan());
    }
}
