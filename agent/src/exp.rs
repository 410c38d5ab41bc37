//! The exponential of negative numbers, without a mathematics library.

use core::f64::consts::LOG2_E;

/// `ln 2` in two parts: the first has 32 significant bits, so that `k · LN_2_HIGH` is exact for
/// `k < 2²¹`; the sum is `ln 2` to 2⁻⁸⁶. The split of Cody and Waite, as in fdlibm's `e_exp.c`.
const LN_2_HIGH: f64 = 6.931_471_803_691_238e-1;
const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;

/// Beyond this, `e^{−u}` is below 2⁻¹⁰²¹ and is given as 0: such a probability is never drawn.
const VANISHES: f64 = 707.0;

/// `1/n!` for `n = 13, 12, …, 0`: the remainder of the series is below 2⁻⁵⁷ for `|r| ≤ ln 2 / 2`.
const INVERSE_FACTORIALS: [f64; 14] = [
    1.0 / 6_227_020_800.0,
    1.0 / 479_001_600.0,
    1.0 / 39_916_800.0,
    1.0 / 3_628_800.0,
    1.0 / 362_880.0,
    1.0 / 40_320.0,
    1.0 / 5_040.0,
    1.0 / 720.0,
    1.0 / 120.0,
    1.0 / 24.0,
    1.0 / 6.0,
    1.0 / 2.0,
    1.0,
    1.0,
];

/// `e^{−u}` for `u ≥ 0`, in `[0, 1]`; 1 for `u < 0`, 0 for NaN.
///
/// `e^{−u} = 2^{−k} · e^{−r}` with `k = round(u / ln 2)` and `r = u − k ln 2`; `e^{−r}` by its
/// Taylor series. The relative error is below 4·2⁻⁵² for results above 2⁻¹⁰²⁰; smaller results
/// are 0.
pub(crate) fn exp_of_minus(u: f64) -> f64 {
    if u.is_nan() || u >= VANISHES {
        return 0.0;
    }
    if u <= 0.0 {
        return 1.0;
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "0.5 ≤ value ≤ 1021, and cutting off the fraction is what rounds"
    )]
    let k = (u * LOG2_E + 0.5) as u16;
    let k_f = f64::from(k);
    let r = (u - k_f * LN_2_HIGH) - k_f * LN_2_LOW;
    let series = INVERSE_FACTORIALS.iter().fold(0.0, |sum, c| sum * -r + c);
    let exponent = u64::from(1023_u16.saturating_sub(k));
    let y = series * f64::from_bits(exponent << 52);
    if y > 1.0 { 1.0 } else { y }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::exp_of_minus;
    use proptest::prelude::*;

    #[expect(
        clippy::disallowed_methods,
        reason = "the oracle: std's exp, within 1 ulp"
    )]
    fn oracle(u: f64) -> f64 {
        (-u).exp()
    }

    /// 4 ulp of ours and 1 ulp of the oracle.
    const BOUND: f64 = 5.0 * f64::EPSILON;

    #[test]
    fn parts_of_ln_2_sum_up() {
        let sum = super::LN_2_HIGH + super::LN_2_LOW;
        assert_eq!(sum.to_bits(), core::f64::consts::LN_2.to_bits());
        assert_eq!(super::LN_2_HIGH.to_bits() & 0x001F_FFFF, 0);
    }

    #[test]
    fn ends() {
        assert_eq!(exp_of_minus(0.0).to_bits(), 1.0_f64.to_bits());
        assert_eq!(exp_of_minus(-3.0).to_bits(), 1.0_f64.to_bits());
        assert_eq!(exp_of_minus(707.0).to_bits(), 0.0_f64.to_bits());
        assert_eq!(exp_of_minus(f64::INFINITY).to_bits(), 0.0_f64.to_bits());
        assert_eq!(exp_of_minus(f64::NAN).to_bits(), 0.0_f64.to_bits());
        assert!(exp_of_minus(706.999) > 0.0);
    }

    #[test]
    fn agrees_on_a_grid() {
        for n in 0..70_700 {
            let u = f64::from(n) * 0.01;
            let error = (exp_of_minus(u) - oracle(u)).abs();
            assert!(u >= 707.0 || error <= BOUND * oracle(u), "{u}: {error:e}");
        }
    }

    proptest! {
        #[test]
        fn agrees(u in 0.0..707.0_f64) {
            prop_assert!((exp_of_minus(u) - oracle(u)).abs() <= BOUND * oracle(u));
        }

        #[test]
        fn agrees_near_zero(exponent in 963..1023_u64, m in 1.0..2.0_f64) {
            let u = m * f64::from_bits(exponent << 52); // 2⁻⁶⁰ to 1
            prop_assert!((exp_of_minus(u) - oracle(u)).abs() <= BOUND);
        }

        #[test]
        fn stays_within_bounds(u in proptest::num::f64::ANY) {
            prop_assert!((0.0..=1.0).contains(&exp_of_minus(u)));
        }
    }
}
