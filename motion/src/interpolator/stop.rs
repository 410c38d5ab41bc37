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
const WHOLE: f32 = 4_294_967_296.0;
const FRACTION_BITS: u32 = 32;
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
    first: Phase,
    second: Phase,
    /// Backwards from rest.
    third: Phase,
}

/// Way (quanta), velocity and acceleration (units per s and per s²).
pub(crate) type StopState = (i64, f32, f32);

impl AxisStop {
    /// At rest already.
    pub(crate) const NONE: Self = {
        let rest = Phase {
            way: 0,
            v: 0,
            a: 0,
            sixth: 0,
        };
        Self {
            bits: 0,
            u: [0; 3],
            first: rest,
            second: rest,
            third: rest,
        }
    };

    /// The stop from a velocity and an acceleration, per s and per s², and the lowest and highest way on it, quanta; `None`
    /// if integers do not reach as far.
    pub(crate) fn new(v: f32, a: f32, limits: StopLimits) -> Option<(Self, (i64, i64))> {
        let (side, [t1, t2, t3]) = durations(v, a, limits);
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
        let unit = unit_s(bits);
        let v0 = quanta(v * unit)?;
        let a0 = quanta(a * unit * unit)?;
        let middle = u2.checked_add(u1.wrapping_add(u3) >> 1)?;
        let gained = times_fraction(a0, u1) >> 1;
        let a1 = quotient(v0.wrapping_add(gained), middle)?.wrapping_neg();
        let first = Phase {
            way: 0,
            v: v0,
            a: a0,
            sixth: quotient(a1.wrapping_sub(a0), u1)?.wrapping_div(6),
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
            sixth: quotient(a1, u3)?.wrapping_div(6),
        };
        third.way = second.way_after(u2).wrapping_sub(third.way_after(u3));
        let turning = turning(v, a, side * limits.j, t1);
        // what f32 is off by at most
        let turning = quanta(turning * (1.0 + 1.0 / 4096.0))?;
        let reach = (turning.min(third.way).min(0), turning.max(third.way).max(0));
        let stop = Self {
            bits,
            u: [u1, second_u, total_u],
            first,
            second,
            third,
        };
        Some((stop, reach))
    }

    /// How long it takes, µs.
    pub(crate) fn duration_us(&self) -> u64 {
        let [.., total] = self.u;
        let shift = FRACTION_BITS.wrapping_sub(self.bits);
        u64::from(total).wrapping_shr(shift).saturating_add(1)
    }

    /// The state so many µs after the beginning.
    pub(crate) fn at(&self, us: u64) -> StopState {
        let [second, third, total] = self.u;
        let now = us.wrapping_shl(FRACTION_BITS.wrapping_sub(self.bits));
        let now = if us >= self.duration_us() {
            total
        } else {
            u32::try_from(now).unwrap_or(total)
        };
        let (phase, u, back) = if now < second {
            (&self.first, now, false)
        } else if now < third {
            (&self.second, now.wrapping_sub(second), false)
        } else {
            (&self.third, total.saturating_sub(now), true)
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
        let per = 1.0 / unit_s(self.bits);
        let (v, a) = (float(v) / QUANTA * per, float(a) / QUANTA * per * per);
        (phase.way_after(u), v, a)
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
fn durations(v: f32, a: f32, limits: StopLimits) -> (f32, [f32; 3]) {
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
#[expect(clippy::cast_precision_loss, reason = "a power of two")]
fn unit_s(bits: u32) -> f32 {
    1_u64.wrapping_shl(bits) as f32 * S_PER_US
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
    clippy::cast_precision_loss,
    reason = "the conversion saturates, and sums are checked"
)]
fn parts(t: f32, shift: u32) -> u32 {
    (t * US_PER_S * 1_u64.wrapping_shl(shift) as f32) as u32
}

/// A way in quanta, if there are so many.
fn quanta(way: f32) -> Option<i64> {
    integer(way * QUANTA)
}

#[expect(clippy::cast_possible_truncation, reason = "compared before")]
fn integer(x: f32) -> Option<i64> {
    (libm::fabsf(x) < MOST).then_some(x as i64)
}

#[expect(clippy::cast_precision_loss, reason = "24 bits are enough")]
const fn float(x: i64) -> f32 {
    x as f32
}

/// n·2³²/d to 44 bits: a quotient of f32, and what it leaves once more.
#[expect(clippy::cast_precision_loss, reason = "24 bits are enough")]
fn quotient(n: i64, d: u32) -> Option<i64> {
    let per = WHOLE / d as f32;
    let near = integer(float(n) * per)?;
    let left = n.wrapping_sub(times_fraction(near, d));
    Some(near.wrapping_add(integer(float(left) * per)?))
}
