//! A quick stop of one axis: its velocity goes to zero as fast as acceleration and jerk allow, in fixed point.
//!
//! At most three phases with jerk s₁, 0, s₃, as in [`Ramp`](crate::ramp::Ramp). How long they take is found in f32. What
//! is left is closed in integers: with T₁, T₂, T₃ as they are, the velocity ends at zero, and the acceleration with it, if
//! the middle phase has a₁ = −(v + a·T₁/2)/(T₁/2 + T₂ + T₃/2), s₁ = (a₁ − a)/T₁ and s₃ = −a₁/T₃. So the errors of f32
//! are in a₁, s₁ and s₃, where [`MARGIN`] covers them, and none is in what is sent: positions are a polynomial in integers,
//! five quanta off at most.
//!
//! Time is in parts of 2ⁿ µs, which is up to twice the duration: u = t/2ⁿ in 2⁻³², exact for whole microseconds.
//! Velocity times 2ⁿ µs, acceleration times (2ⁿ µs)² and so on are integers of quanta then.

use crate::angle::times_fraction;
use crate::scalar::power_of_two;

/// Kept below the hard limits, for what f32 finds: durations to some 3e-7 of a/j, of which a step of acceleration
/// that is spread over three servo steps of 2 ms makes 2e-6 of j where a/j is 40 ms.
pub(super) const MARGIN: f64 = 1.0 - 16e-6;
/// Quanta of an [`Angle`](crate::Angle) in one unit.
const QUANTA: f32 = 1_099_511_627_776.0;
/// Nothing may be larger, in quanta: sums of two have 63 bits then.
const MOST: f32 = 2_305_843_009_213_693_952.0;
const US_PER_S: f32 = 1e6;
const S_PER_US: f32 = 1e-6;
/// 2³².
pub(super) const WHOLE: f32 = 4_294_967_296.0;
const FRACTION_BITS: u32 = 32;
/// No quotient has more.
const QUOTIENT_BITS: u32 = 61;
/// 2³²/6.
const SIXTH: u32 = 715_827_882;
/// The duration has so many µs more than f32 found, for two phases that last at least one.
const MORE_US: u32 = 8;

/// What an axis may do in a quick stop, per s² and s³.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct StopLimits {
    pub(crate) a: f32,
    pub(crate) j: f32,
}

/// A phase: way, velocity, acceleration where it begins, and a sixth of the jerk.
#[derive(Clone, Copy, Debug)]
struct Phase {
    way: i64,
    v: i64,
    a: i64,
    sixth: i64,
}

/// The stop of an axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AxisStop {
    /// n.
    bits: u32,
    /// When the second phase begins, the third, and rest.
    u: [u32; 3],
    /// Velocity, acceleration and a sixth of the jerk where the first phase begins.
    first: [i64; 3],
    /// Way, velocity and acceleration where the second begins.
    second: [i64; 3],
    /// Way and a sixth of the jerk at rest, from which the third goes backwards.
    third: [i64; 2],
}

/// Way (quanta), velocity and acceleration (units per s and per s²).
pub(crate) type StopState = (i64, f32, f32);

impl AxisStop {
    /// At rest already.
    pub(crate) const NONE: Self = Self {
        bits: 0,
        u: [0; 3],
        first: [0; 3],
        second: [0; 3],
        third: [0; 2],
    };

    /// The stop from a velocity and an acceleration, per s and per s², and the lowest and highest way on it, quanta; `None`
    /// if integers do not reach as far.
    pub(crate) fn new(v: f32, a: f32, limits: StopLimits) -> Option<(Self, (i64, i64))> {
        let (side, times) = durations(v, a, limits);
        let [t1, ..] = times;
        let scaled = |bits| {
            let unit = unit_s(bits);
            Some((quanta(v * unit)?, quanta(a * unit * unit)?))
        };
        let (stop, end) = Self::closed(times, scaled)?;
        let turning = turning(v, a, side * limits.j, t1);
        // what f32 is off by at most
        let turning = quanta(turning * (1.0 + 1.0 / 4096.0))?;
        let reach = (turning.min(end).min(0), turning.max(end).max(0));
        Some((stop, reach))
    }

    /// Closed in integers: phases that last so long, from a velocity and an acceleration that are scaled by 2ⁿ µs; and the
    /// whole way.
    #[inline]
    pub(super) fn closed(
        [t1, t2, t3]: [f32; 3],
        scaled: impl FnOnce(u32) -> Option<(i64, i64)>,
    ) -> Option<(Self, i64)> {
        let total = micros(t1 + t2 + t3)?.checked_add(MORE_US)?;
        let bits = FRACTION_BITS.wrapping_sub(total.leading_zeros());
        let shift = FRACTION_BITS.checked_sub(bits)?;
        // seconds in parts of 2ⁿ µs
        let micro = 1_u32.checked_shl(shift)?;
        let part = |t: f32| parts(t, shift);
        let (u1, u2) = (part(t1).max(micro), part(t2));
        let u3 = part(t3).max(micro);
        // so that their sum has a half
        let u3 = u3.checked_add(u1.wrapping_add(u3) & 1)?;
        let second_u = u1.checked_add(u2)?;
        let total_u = second_u.checked_add(u3)?;
        let (v0, a0) = scaled(bits)?;
        let middle = u2.checked_add(u1.wrapping_add(u3) >> 1)?;
        let gained = times_fraction(a0, u1) >> 1;
        let a1 = quotient(v0.wrapping_add(gained), middle)?.wrapping_neg();
        let first = Phase {
            way: 0,
            v: v0,
            a: a0,
            sixth: quotient(sixth(a1.wrapping_sub(a0)), u1)?,
        };
        let second = Phase {
            way: first.way_after(u1),
            v: v0.wrapping_add(times_fraction(a0.wrapping_add(a1), u1) >> 1),
            a: a1,
            sixth: 0,
        };
        let mut third = Phase {
            way: 0,
            v: 0,
            a: 0,
            sixth: quotient(sixth(a1), u3)?,
        };
        third.way = second.way_after(u2).wrapping_sub(third.way_after(u3));
        let stop = Self {
            bits,
            u: [u1, second_u, total_u],
            first: [first.v, first.a, first.sixth],
            second: [second.way, second.v, second.a],
            third: [third.way, third.sixth],
        };
        Some((stop, third.way))
    }

    /// n.
    pub(super) const fn bits(&self) -> u32 {
        self.bits
    }

    /// How long it takes, µs.
    pub(crate) fn duration_us(&self) -> u64 {
        let [.., total] = self.u;
        let shift = FRACTION_BITS.wrapping_sub(self.bits);
        u64::from(total).wrapping_shr(shift).saturating_add(1)
    }

    /// The state so many µs after the beginning.
    pub(crate) fn at(&self, us: u64) -> StopState {
        let [way, v, a] = self.state(us);
        let per = 1.0 / unit_s(self.bits);
        (way, float(v) / QUANTA * per, float(a) / QUANTA * per * per)
    }

    /// Way, velocity and acceleration so many µs after the beginning, as they were given: per 2ⁿ µs.
    #[inline]
    pub(super) fn state(&self, us: u64) -> [i64; 3] {
        let [second, third, total] = self.u;
        let now = us.wrapping_shl(FRACTION_BITS.wrapping_sub(self.bits));
        let now = if us >= self.duration_us() {
            total
        } else {
            u32::try_from(now).unwrap_or(total)
        };
        let (phase, u, back) = if now < second {
            let [v, a, sixth] = self.first;
            let way = 0;
            (Phase { way, v, a, sixth }, now, false)
        } else if now < third {
            let [way, v, a] = self.second;
            let sixth = 0;
            (Phase { way, v, a, sixth }, now.wrapping_sub(second), false)
        } else {
            let [way, sixth] = self.third;
            let (v, a) = (0, 0);
            let u = total.saturating_sub(now);
            (Phase { way, v, a, sixth }, u, true)
        };
        let half = times_fraction(phase.sixth, u).wrapping_mul(3);
        let jerked = times_fraction(half, u);
        let v = phase
            .v
            .wrapping_add(times_fraction(phase.a, u))
            .wrapping_add(jerked);
        let a = phase.a.wrapping_add(half.wrapping_mul(2));
        // backwards, the velocity changes its sign
        let v = if back { v.wrapping_neg() } else { v };
        [phase.way_after(u), v, a]
    }
}

impl Phase {
    /// way + u(v + u(a/2 + u·sixth))
    fn way_after(&self, u: u32) -> i64 {
        let sum = times_fraction(self.sixth, u).wrapping_add(self.a >> 1);
        let sum = times_fraction(sum, u).wrapping_add(self.v);
        times_fraction(sum, u).wrapping_add(self.way)
    }
}

/// The sign of the jerk of the first phase, and how long each phase takes, s.
pub(super) fn durations(v: f32, a: f32, limits: StopLimits) -> (f32, [f32; 3]) {
    let StopLimits { a: most, j } = limits;
    let stopping = v + 0.5 * a * libm::fabsf(a) / j;
    let side = if stopping > 0.0 || (stopping >= 0.0 && a < 0.0) {
        -1.0
    } else {
        1.0
    };
    let (along, distance) = (side * a, -side * v);
    let square = j * distance + 0.5 * along * along;
    let root = libm::sqrtf(if square > 0.0 { square } else { 0.0 });
    let peak = if root < most { root } else { most };
    let t2 = if root < most {
        0.0
    } else {
        let ramps = (2.0 * peak * peak - along * along) / (2.0 * j);
        (distance - ramps) / peak
    };
    let t1 = (peak - along) / j;
    let least = |t: f32| if t > 0.0 { t } else { 0.0 };
    (side, [least(t1), least(t2), peak / j])
}

/// The way at which the velocity changes its sign, if it does before the acceleration does; else 0.
fn turning(v: f32, a: f32, s: f32, t1: f32) -> f32 {
    let extreme = -a / s;
    let extreme = if extreme < t1 { extreme } else { t1 };
    if extreme <= 0.0 || v * (v + extreme * (a + 0.5 * s * extreme)) >= 0.0 {
        return 0.0;
    }
    // of v + a·t + s·t²/2 the first root; a has the other sign than v and s
    let root = libm::sqrtf(a * a - 2.0 * s * v);
    let t = 2.0 * libm::fabsf(v) / (libm::fabsf(a) + root);
    t * (v + t * (0.5 * a + t * s * (1.0 / 6.0)))
}

/// 2ⁿ µs in s.
pub(super) fn unit_s(n: u32) -> f32 {
    power_of_two(n) * S_PER_US
}

/// Whole microseconds of a duration.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "compared before"
)]
fn micros(t: f32) -> Option<u32> {
    let us = t * US_PER_S;
    (0.0..WHOLE / 4.0).contains(&us).then_some(us as u32)
}

/// A duration in 2⁻³² of 2ⁿ µs; `shift` is 32 − n.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the conversion saturates, and sums are checked"
)]
fn parts(t: f32, shift: u32) -> u32 {
    (t * (US_PER_S * power_of_two(shift))) as u32
}

/// A way in quanta, if there are so many.
fn quanta(way: f32) -> Option<i64> {
    integer(way * QUANTA)
}

#[expect(clippy::cast_possible_truncation, reason = "compared before")]
pub(super) fn integer(x: f32) -> Option<i64> {
    (libm::fabsf(x) < MOST).then_some(x as i64)
}

/// A float of an integer, to 23 bits or 2⁸: of its halves, for a microcontroller has no other instruction for it.
#[expect(
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "halves, of which 24 bits are enough"
)]
pub(super) fn float(x: i64) -> f32 {
    let (high, low) = ((x >> 32) as i32, x as u32);
    high as f32 * WHOLE + low as f32
}

/// x/6 to a unit, by products: a division of 64 bits takes hundreds of instructions.
fn sixth(x: i64) -> i64 {
    let near = times_fraction(x, SIXTH);
    let left = x.wrapping_sub(near.wrapping_mul(6));
    near.wrapping_add(times_fraction(left, SIXTH))
}

/// n·2³²/d, from the reciprocal of d to 29 bits, and what that leaves once more: two units of n are left then, or as many
/// as d takes bits away from 2³², whichever is more.
fn quotient(n: i64, d: u32) -> Option<i64> {
    let left_bits = d.leading_zeros();
    // d from 1/2 to 1
    let whole = d.checked_shl(left_bits)?;
    // 2⁶³ over it: to 15 bits, and by a step of Newton's to 29, from below
    let near = u32::MAX.checked_div(whole >> 16)?.wrapping_shl(15);
    let short = u64::from(near)
        .wrapping_mul(u64::from(whole))
        .wrapping_neg()
        >> 32;
    let reciprocal = u64::from(near).wrapping_mul(short) >> 31;
    let reciprocal = u32::try_from(reciprocal).unwrap_or(u32::MAX);
    let more = left_bits.wrapping_add(1);
    let over = |n: i64| times_fraction(n, reciprocal);
    let most = QUOTIENT_BITS.checked_sub(more)?;
    let near = over(n);
    if near.unsigned_abs() >= 1_u64.wrapping_shl(most) {
        return None;
    }
    let near = near.wrapping_shl(more);
    let left = n.wrapping_sub(times_fraction(near, d));
    Some(near.wrapping_add(over(left).wrapping_shl(more)))
}

#[cfg(test)]
mod test {
    use super::*;
    use crate::ramp::Ramp;
    use proptest::prelude::*;

    const PER_UNIT: f64 = 1_099_511_627_776.0;

    #[expect(
        clippy::cast_precision_loss,
        reason = "some 10^14 quanta, far below 2^53"
    )]
    fn exact(quanta: i64) -> f64 {
        quanta as f64 / PER_UNIT
    }

    proptest! {
        /// From any state within the limits: the stop in f64, whose durations f32 finds to 3e-7 of the longest time there is.
        #[test]
        fn it_is_the_fastest_stop_and_ends_at_rest(
            seconds in -1.0..1.0f32, share in -1.0..1.0f32, a in 1.0..1000.0f32, bend in 2.0..500.0f32,
        ) {
            let limits = StopLimits { a, j: a * bend };
            let (v, start) = (seconds * a, share * a);
            let ((stop, (low, high)), ramp) = (
                AxisStop::new(v, start, limits).unwrap(),
                Ramp::new(f64::from(v), f64::from(start), 0.0, f64::from(a), f64::from(limits.j)),
            );
            let [v, a, j] = [v, a, limits.j].map(|x| f64::from(libm::fabsf(x)));
            let t = ramp.duration();
            // two microseconds of the shortest phases, one of rounding up, and a few roundings of 24 bits
            let late = 1e-6 * crate::scalar::float_us(stop.duration_us()) - t;
            prop_assert!(late > -2e-6 * t && late < 4e-6 + 2e-6 * t, "{late}");
            let speed = v + a * a / j;
            for i in 0..=200u32 {
                let us = stop.duration_us() * u64::from(i) / 200;
                let (way, x, dx) = stop.at(us);
                let wanted = ramp.at(1e-6 * crate::scalar::float_us(us));
                // what a shift in time by as much makes
                let shift = 4e-6 + 2e-6 * t;
                prop_assert!((exact(way) - wanted.integral).abs() < 2.0 * shift * speed, "{way} {wanted:?}");
                prop_assert!((f64::from(x) - wanted.x).abs() < 2.0 * shift * a + 1e-6 * speed, "{x} {wanted:?}");
                prop_assert!((f64::from(dx) - wanted.dx).abs() < 2.0 * shift * j + 2e-6 * a, "{dx} {wanted:?}");
                prop_assert!(way >= low - 8 && way <= high + 8, "{low} {way} {high}");
            }
            let (end, x, dx) = stop.at(stop.duration_us());
            prop_assert!(x.to_bits() == 0 && dx.to_bits() == 0);
            prop_assert_eq!(stop.at(stop.duration_us() + 1_000_000).0, end);
        }

        /// What the gate sees: differences over servo steps of 2 ms keep the hard limits, of which the stop leaves out 16e-6.
        #[test]
        fn its_differences_keep_the_hard_limits(
            seconds in -1.0..1.0f32, share in -1.0..1.0f32, a in 50.0..1000.0f32, bend in 10.0..500.0f32,
        ) {
            let (v, hard) = (seconds * a, [a, a * bend].map(f64::from));
            #[expect(clippy::cast_possible_truncation, reason = "24 bits")]
            let [kept, jerk] = hard.map(|x| (x * MARGIN) as f32);
            let (stop, _) = AxisStop::new(v, share * kept, StopLimits { a: kept, j: jerk }).unwrap();
            let h = 2e-3;
            let way = |k: u64| exact(stop.at(2000 * k).0);
            // each position is five quanta off at most
            let quantum = 5.0 / PER_UNIT;
            for k in 0..stop.duration_us() / 2000 + 3 {
                let w = [way(k), way(k + 1), way(k + 2), way(k + 3)];
                let second = w[2] - 2.0 * w[1] + w[0];
                let third = w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0];
                prop_assert!(second.abs() <= hard[0] * h * h + 4.0 * quantum, "{}", second / h / h);
                prop_assert!(third.abs() <= hard[1] * h * h * h + 8.0 * quantum, "{}", third / h / h / h);
            }
        }
    }

    proptest! {
        /// To what the description says.
        #[test]
        fn a_quotient_leaves_little(n in -(1_i64 << 40)..1_i64 << 40, d in 1_u32..) {
            let Some(q) = quotient(n, d) else {
                // more than 61 bits
                prop_assert!(n.unsigned_abs() > u64::from(d) << 27);
                return Ok(());
            };
            let left = i128::from(n) * (1 << 32) - i128::from(q) * i128::from(d);
            prop_assert!(left.abs() <= 4 << 32, "{left}");
        }
    }

    #[test]
    fn what_integers_do_not_reach_is_no_stop() {
        let limits = StopLimits { a: 1.0, j: 10.0 };
        assert!(AxisStop::new(1.0, 0.0, limits).is_some());
        assert!(AxisStop::new(0.0, 0.0, limits).is_some());
        for v in [1e6, f32::INFINITY, f32::NAN] {
            assert!(AxisStop::new(v, 0.0, limits).is_none(), "{v}");
        }
        let none = StopLimits { a: 0.0, j: 0.0 };
        assert!(AxisStop::new(1.0, 0.0, none).is_none());
    }
}
