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

/// The cube root, to 3 units in the last place. Much smaller than libm's, which rounds correctly by a fused product.
///
/// |x| = z·8ᵏ with z from 1/2 to 4, of whose root 3/4 + z/4 is at most 11 % off; three steps of Halley's method, each of which
/// leaves less than the cube of the error before it: 1.3e-3, 2.3e-9, nothing.
pub(crate) fn cube_root(x: f64) -> f64 {
    if libm::fabs(x) <= 0.0 || !x.is_finite() {
        return x;
    }
    let (mantissa, exponent) = libm::frexp(libm::fabs(x));
    let third = exponent.div_euclid(3);
    let z = libm::scalbn(mantissa, exponent.rem_euclid(3));
    let mut root = 0.75 + 0.25 * z;
    for _ in 0..3 {
        let cube = root * root * root;
        root *= (cube + 2.0 * z) / (2.0 * cube + z);
    }
    sign(x) * libm::scalbn(root, third)
}

/// An integer number of microseconds as a float: exact below 2^53 µs (285 years).
#[expect(
    clippy::cast_precision_loss,
    reason = "differences of times: far below 2^53 µs"
)]
pub(crate) fn float_us(us: u64) -> f64 {
    us as f64
}

/// 1/6: multiplied, where a division would cost ten times as much.
pub(crate) const SIXTH: f64 = 1.0 / 6.0;

/// 2ᵉ for an e below 128, made of its bits: from an integer it takes a microcontroller thirty instructions.
pub(crate) const fn power_of_two(e: u32) -> f32 {
    f32::from_bits(e.wrapping_add(127).wrapping_shl(23))
}

/// The nearest float of 32 bits.
#[expect(clippy::cast_possible_truncation, reason = "24 bits are enough")]
pub(crate) const fn narrow(x: f64) -> f32 {
    x as f32
}

#[cfg(test)]
mod test {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_cube_root_of_what_has_none_is_itself() {
        for x in [0.0, -0.0, f64::INFINITY, -f64::INFINITY] {
            assert_eq!(cube_root(x).to_bits(), x.to_bits());
        }
        assert!(cube_root(f64::NAN).is_nan());
        let least = f64::from_bits(1);
        assert!((cube_root(least) / libm::cbrt(least) - 1.0).abs() < 1e-15);
    }

    proptest! {
        #[test]
        fn a_cube_root_is_within_three_units_in_the_last_place(mantissa in 1.0..8.0f64, exponent in -300..300i32, negative in any::<bool>()) {
            let x = libm::scalbn(if negative { -mantissa } else { mantissa }, 3 * exponent);
            let (root, exact) = (cube_root(x), libm::cbrt(x));
            prop_assert!((root - exact).abs() <= 3.0 * 2.3e-16 * exact.abs(), "{root} {exact}");
        }
    }
}
