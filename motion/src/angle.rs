//! A position in fixed point: exact differences, and no f64 where an integer will do.
//!
//! A microcontroller with floats of 32 bits makes about a hundred instructions of one operation of f64, and one or two of
//! a sum of 64-bit integers. So what a servo step computes with is an integer here: sums and differences of
//! positions are exact, and a difference of any order says exactly what was sent.

use crate::scalar::within;
use core::fmt;

/// Quanta in one unit of the axis.
const PER_UNIT: f64 = 1_099_511_627_776.0;
/// A quantum is so many parts while it is rounded, 2¹⁰: what is lost below them is a thousandth of a quantum.
const PARTS: f64 = 1024.0;
const PART_BITS: u32 = 10;
const HALF: i64 = 512;
/// So far 63 bits hold the parts.
const EXACT: f64 = 8192.0;
/// Where the range ends.
const RANGE: f64 = 8_388_608.0;

/// A position of one axis (rad of the motor shaft on a controller node) in quanta of 2⁻⁴⁰.
///
/// A quantum is 9.1e-13 rad: a drive unit, a thousandth of an encoder's increment, is some 10⁶ of them. The range is
/// ±2²³, 8.4e6 rad: 1.3 million turns. To f64 it is exact within ±8192, since 53 bits hold it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Angle(i64);

impl Angle {
    /// A quantum is 2 to the power of minus this.
    pub const FRACTION_BITS: u32 = 40;
    /// 0.
    pub const ZERO: Self = Self(0);
    /// The lowest, −2²³: as a limit, none.
    pub const MIN: Self = Self(i64::MIN);
    /// The highest, 2²³ less a quantum: as a limit, none.
    pub const MAX: Self = Self(i64::MAX);

    /// So many quanta.
    #[must_use]
    pub const fn of_quanta(quanta: i64) -> Self {
        Self(quanta)
    }

    /// How many quanta.
    #[must_use]
    pub const fn quanta(self) -> i64 {
        self.0
    }

    /// The nearest to a position; `None` if it is not a number, or beyond the range.
    #[must_use]
    pub fn nearest(position: f64) -> Option<Self> {
        (libm::fabs(position) < RANGE).then(|| Self::bound(position))
    }

    /// The nearest to a limit, to a thousandth of a quantum: beyond the range, its end, which no position passes. What is not a number is 0.
    #[must_use]
    #[expect(
        clippy::cast_possible_truncation,
        reason = "a float to integer cast saturates"
    )]
    // one function: it is soft floats on a microcontroller, and called in many places
    #[inline(never)]
    pub fn bound(limit: f64) -> Self {
        // in parts of a quantum, of which the floor of the sum with a half is the nearest: a third of what `round` costs
        if libm::fabs(limit) < EXACT {
            let parts = (limit * (PER_UNIT * PARTS)) as i64;
            return Self(parts.wrapping_add(HALF) >> PART_BITS);
        }
        Self(libm::round(limit * PER_UNIT) as i64)
    }

    /// In the axis' unit.
    #[must_use]
    #[expect(
        clippy::cast_precision_loss,
        reason = "exact within ±8192, and to 2⁻⁵³ of it beyond"
    )]
    pub fn to_f64(self) -> f64 {
        self.0 as f64 / PER_UNIT
    }

    /// So many quanta further; stays at the end of the range.
    #[must_use]
    pub const fn plus(self, quanta: i64) -> Self {
        Self(self.0.saturating_add(quanta))
    }

    /// Quanta from an earlier position to this one: exact, unless they are more than the range holds.
    #[must_use]
    pub const fn since(self, earlier: Self) -> i64 {
        self.0.saturating_sub(earlier.0)
    }

    /// Moved into `[lower, upper]`.
    #[must_use]
    pub fn within(self, lower: Self, upper: Self) -> Self {
        let low = if self.0 > upper.0 { upper } else { self };
        if low.0 < lower.0 { lower } else { low }
    }
}

impl fmt::Display for Angle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.to_f64())
    }
}

/// A small constant by which integers are multiplied: units of a drive in a quantum of an [`Angle`], say.
///
/// It is held with 62 bits, as `factor`/2^`64 + shift`: the product is true to 2⁻⁶¹ of it before it is rounded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ratio {
    factor: u64,
    shift: u32,
}

impl Ratio {
    /// The ratio nearest to a number; to 2⁻⁶⁰ or 1/8 if it does not lie between these.
    #[must_use]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "between 2^61 and 2^62"
    )]
    pub fn nearest(value: f64) -> Self {
        // 2⁻⁶⁰, and the last below 1/8
        let value = within(value, 8.673_617_379_884_035e-19, 0.125 - 2e-17);
        // value = mantissa·2^exponent, with the mantissa from 1/2 to 1 and the exponent from −59 to −3
        let (mantissa, exponent) = libm::frexp(value);
        Self {
            factor: libm::round(mantissa * 4_611_686_018_427_387_904.0) as u64,
            shift: exponent.unsigned_abs().wrapping_sub(2),
        }
    }

    /// `x` times the constant, rounded to the nearest; half a unit goes up.
    #[must_use]
    #[inline]
    pub const fn of(&self, x: i64) -> i64 {
        // half of what is shifted out, so that the floor of the sum is the nearest
        let half = 1_i64.wrapping_shl(self.shift.wrapping_sub(1));
        product_high(x, self.factor)
            .wrapping_add(half)
            .wrapping_shr(self.shift)
    }
}

/// x·y/2⁶⁴, rounded down, from four products of 32 bits; y is below 2⁶³.
#[inline]
const fn product_high(x: i64, y: u64) -> i64 {
    let (x1, x0) = (x >> 32, x.cast_unsigned() & LOW);
    let (y1, y0) = (y >> 32, y & LOW);
    let low = x0.wrapping_mul(y0);
    let middle = x0.wrapping_mul(y1).wrapping_add(low >> 32);
    let cross = x1
        .wrapping_mul(y0.cast_signed())
        .wrapping_add((middle & LOW).cast_signed());
    x1.wrapping_mul(y1.cast_signed())
        .wrapping_add((middle >> 32).cast_signed())
        .wrapping_add(cross >> 32)
}

/// The lower 32 bits.
const LOW: u64 = 0xFFFF_FFFF;

/// x·u/2³², rounded down.
#[inline]
pub(crate) fn times_fraction(x: i64, u: u32) -> i64 {
    let (high, low) = (x >> 32, x.cast_unsigned() & LOW);
    high.wrapping_mul(i64::from(u))
        .wrapping_add((low.wrapping_mul(u64::from(u)) >> 32).cast_signed())
}

#[cfg(test)]
mod test {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn what_no_angle_can_be_is_none_and_a_limit_beyond_the_range_is_none_at_all() {
        for position in [f64::NAN, f64::INFINITY, -f64::INFINITY, 8_388_608.0, -1e300] {
            assert_eq!(Angle::nearest(position), None);
        }
        assert_eq!(Angle::bound(f64::INFINITY), Angle::MAX);
        assert_eq!(Angle::bound(-f64::INFINITY), Angle::MIN);
        assert_eq!(Angle::nearest(1.0).map(Angle::quanta), Some(1 << 40));
        assert_eq!(Angle::MAX.plus(1), Angle::MAX);
        assert_eq!(Angle::MIN.since(Angle::of_quanta(1)), i64::MIN);
    }

    proptest! {
        #[test]
        fn an_angle_is_within_half_a_quantum_of_its_position(x in -8192.5..8192.5f64) {
            let angle = Angle::nearest(x).unwrap();
            prop_assert!((angle.to_f64() - x).abs() <= (0.5 + 1.0 / PARTS) / PER_UNIT);
            // 53 bits hold it within ±8192: there and back is the same
            prop_assert!(x.abs() > 8191.0 || Angle::nearest(angle.to_f64()) == Some(angle));
        }

        #[test]
        #[expect(clippy::cast_possible_truncation, clippy::cast_precision_loss, reason = "exact below 2^53")]
        fn a_product_is_the_integer_nearest_to_it(x in any::<i64>(), value in 1e-12..0.12f64) {
            // the same by 128 bits: the float is exact as a fraction of 2^120
            let exact = libm::scalbn(value, 60) as i128;
            let ratio = Ratio::nearest(libm::scalbn(exact as f64, -60)).of(x);
            let wanted = (i128::from(x) * exact + (1 << 59)) >> 60;
            prop_assert!((i128::from(ratio) - wanted).abs() <= 1, "{ratio} {wanted}");
            // and where nothing is rounded twice, the same
            if x.unsigned_abs() < 1 << 52 {
                prop_assert_eq!(i128::from(ratio), wanted);
            }
        }

        #[test]
        fn the_product_with_a_fraction_is_the_floor(x in any::<i64>(), u in any::<u32>()) {
            prop_assert_eq!(i128::from(times_fraction(x, u)), (i128::from(x) * i128::from(u)) >> 32);
        }

        #[test]
        fn the_upper_half_of_a_product_is_that_of_128_bits(x in any::<i64>(), y in 0..=u64::MAX / 2) {
            prop_assert_eq!(i128::from(product_high(x, y)), (i128::from(x) * i128::from(y)) >> 64);
        }
    }
}
