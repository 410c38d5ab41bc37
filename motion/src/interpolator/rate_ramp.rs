//! A change of the feed rate: what is beyond the rate that it will have goes to zero, in fixed point.
//!
//! It is an [`AxisStop`] whose velocity is a rate and whose way is a time. A rate is given in 2⁻³², and stays exact.

use super::stop::{AxisStop, StopLimits, WHOLE, durations, float, integer, unit_s};
use crate::scalar::power_of_two;

/// In which a rate is given.
const RATE_BITS: u32 = 32;
/// Values are in 2⁻ᵉ with at most so many bits,
const MOST_BITS: u32 = 56;
/// and with the greatest of them, the second derivative, a sixth of which is looked for, they have so many.
const ALL_BITS: u32 = 60;
/// Of a float of 32 bits: where its exponent is, and what that is for 1.
const EXPONENT_AT: u32 = 23;
const EXPONENT_OF_1: u32 = 127;

/// The change of a rate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RateRamp {
    stop: AxisStop,
    /// e.
    bits: u32,
    /// What is left of 2ᵉ and 2ⁿ µs in a derivative, 1/s.
    per_s: f32,
}

impl RateRamp {
    /// From what is beyond the rate to come, in 2⁻³² and at most 1, and its derivative, per s; the limits are per s and per
    /// s². `None` if it takes longer than a quarter of an hour.
    pub(crate) fn new(beyond: i64, change: f32, limits: StopLimits) -> Option<Self> {
        let (_, times) = durations(share(beyond), change, limits);
        let mut e = 0;
        let (stop, _) = AxisStop::closed(times, |bits| {
            let unit = unit_s(bits);
            e = ALL_BITS
                .checked_sub(magnitude(limits.j * unit * unit))?
                .min(MOST_BITS);
            let beyond = beyond.checked_shl(e.checked_sub(RATE_BITS)?)?;
            Some((beyond, integer(change * unit * power_of_two(e))?))
        })?;
        let per_s = 1.0 / (power_of_two(e) * unit_s(stop.bits()));
        Some(Self {
            stop,
            bits: e,
            per_s,
        })
    }

    /// How long it takes, µs.
    pub(crate) fn duration_us(&self) -> u64 {
        self.stop.duration_us()
    }

    /// So many µs after it began: the time that has passed by what is beyond the rate to come, 2⁻³² µs; that rate, 2⁻³²; and
    /// its derivative, per s.
    pub(crate) fn at(&self, us: u64) -> (i64, i64, f32) {
        let [way, v, a] = self.stop.state(us);
        let n = self.stop.bits();
        let behind = self.bits.wrapping_sub(RATE_BITS);
        let time = match behind.checked_sub(n) {
            Some(less) => way.wrapping_shr(less),
            None => way.wrapping_shl(n.wrapping_sub(behind)),
        };
        (time, v.wrapping_shr(behind), float(a) * self.per_s)
    }
}

/// A rate in 24 bits, however small.
#[expect(clippy::cast_precision_loss, reason = "24 bits are enough")]
fn share(parts: i64) -> f32 {
    parts as f32 / WHOLE
}

/// So many bits has the whole part of a number from 1 on; 1 of what is less.
fn magnitude(x: f32) -> u32 {
    let exponent = (x.to_bits() >> EXPONENT_AT).max(EXPONENT_OF_1);
    exponent.wrapping_sub(EXPONENT_OF_1).wrapping_add(1)
}

#[cfg(test)]
mod test {
    use super::*;
    use crate::ramp::Ramp;
    use proptest::prelude::*;

    #[expect(clippy::cast_precision_loss, reason = "some 2^50, below 2^53")]
    fn exact(parts: i64) -> f64 {
        parts as f64 / 4_294_967_296.0
    }

    #[test]
    fn what_integers_do_not_reach_is_no_change() {
        let whole = 1 << 32;
        let slow = StopLimits { a: 1e-3, j: 1.0 };
        assert!(RateRamp::new(whole, 0.0, slow).is_some());
        for (a, j) in [
            (5e-4, 1.0),
            (0.0, 0.0),
            (f32::NAN, 1.0),
            (1.0, f32::INFINITY),
        ] {
            assert!(
                RateRamp::new(whole, 0.0, StopLimits { a, j }).is_none(),
                "{a} {j}"
            );
        }
    }

    proptest! {
        /// A change of the feed rate from any state that such a change may have: the ramp in f64.
        #[test]
        fn a_rate_goes_as_in_f64(
            from in 0..=1_i64 << 32, to in 0..=1_i64 << 32, share in -1.0..1.0f32, a in 0.05..50.0f32, bend in 1.0..5000.0f32,
        ) {
            let limits = StopLimits { a, j: a * bend };
            // no change goes beyond 0 and 1: before that it would come to rest
            let room = exact(if share > 0.0 { (1 << 32) - from } else { from });
            prop_assume!(f64::from(share * share * a) < 2.0 * room * f64::from(bend));
            let stop = RateRamp::new(from - to, share * a, limits);
            prop_assert!(stop.is_some(), "{from} {to} {limits:?}");
            let stop = stop.unwrap();
            let [x0, target] = [from, to].map(exact);
            let [a, j, start] = [a, limits.j, share * a].map(f64::from);
            let ramp = Ramp::new(x0, start, target, a, j);
            let t = ramp.duration();
            let shift = 10e-6 + 2e-6 * t;
            prop_assert!((1e-6 * crate::scalar::float_us(stop.duration_us()) - t).abs() < shift);
            for i in 0..=200u32 {
                let us = stop.duration_us() * u64::from(i) / 200;
                let seconds = 1e-6 * crate::scalar::float_us(us);
                let (time, rate, change) = stop.at(us);
                let wanted = ramp.at(seconds);
                let time = target * seconds + 1e-6 * exact(time);
                // what a shift in time by as much makes
                prop_assert!((time - wanted.integral).abs() < 2.0 * shift, "{time} {wanted:?}");
                prop_assert!((target + exact(rate) - wanted.x).abs() < 2.0 * shift * a + 1e-9, "{rate} {wanted:?}");
                prop_assert!((f64::from(change) - wanted.dx).abs() < 2.0 * shift * j + 2e-6 * a, "{change} {wanted:?}");
            }
            let (_, rate, change) = stop.at(stop.duration_us());
            prop_assert!(rate == 0 && change.to_bits() == 0);
        }
    }
}
