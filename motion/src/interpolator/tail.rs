//! The stop tail: how the path goes on behind its last knot, to rest.

use super::fixed::Unfixable;
use super::segment::End;
use super::span::{Span, whole};
use crate::angle::{Angle, times_fraction};
use crate::knot::{AxisEnvelope, Setpoint};
use crate::profile::AxisLimits;
use crate::scalar::{US_PER_S, float_us, larger, narrow, smaller};

/// Ways of a tail are in 16ths of a quantum of an [`Angle`]: so what their sums leave out is below one.
const SIXTEENTHS: f64 = 17_592_186_044_416.0;
const SIXTEENTH_BITS: u32 = 4;
/// The farthest either part of a tail may go, in the axis' unit: eight times as much has 63 bits.
const MOST_WAY: f64 = 32_768.0;
const S_PER_US: f32 = 1e-6;

/// From the end of the path to rest, in path time.
///
/// Velocity is `v·h0(t/T) + a·Tᵢ·h1(t/Tᵢ)` with `h0(u) = 1 − 3u² + 2u³`, `h1(u) = u(1 − u)²`: the
/// velocity at the end of the path keeps its direction while it dies out over a time T common to all
/// axes, and the acceleration fades over a time Tᵢ of each axis' own. C2 at the joint, and a ends at 0.
///
/// Bounds (max|h0'| = 3/2, max|h0''| = 6, max h1 = 4/27, max|h1'| = 1, max|h1''| = 4):
/// velocity ≤ |v| + 4/27·|a|·Tᵢ, acceleration ≤ 3/2·|v|/T + |a|, jerk ≤ 6·|v|/T² + 4·|a|/Tᵢ.
/// With Tᵢ = 8·aₚ/jₜ (plan acceleration, tail jerk) fading takes at most half of jₜ, and at most
/// 32/27·aₚ²/jₜ of velocity, which [`AxisEnvelope`] keeps free. So for every end within the plan limits
/// there is a T, and the smallest one is taken. Both are whole microseconds: T is rounded up, Tᵢ down.
///
/// The ways are `w₀·(2u − 2u³ + u⁴)`, w₀ = v·T/2, and `w₁·(6x² − 8x³ + 3x⁴)`, w₁ = a·Tᵢ²/12. The last knot's
/// position, w₀ and w₁ are rounded, to half a quantum and 1/32; each of the eight products down, by less than 1/16; the
/// sum to the nearest; and what u and x leave of the time counts with a velocity of 24 bits: 3 quanta at most.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tail<const N: usize> {
    /// The state that it begins with, where the path ends.
    from: Setpoint<N>,
    /// T; of no duration where nothing goes on.
    span: Span,
    duration_us: u64,
    /// w₀ of each axis, 16ths of a quantum.
    along: [i64; N],
    /// w₁ of each axis, 16ths of a quantum.
    fading: [i64; N],
}

/// What of an envelope a tail is made with, found once and not at every knot.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TailLimits {
    a: f64,
    j: f64,
    fade_us: u64,
}

impl TailLimits {
    pub(crate) fn new(envelope: &AxisEnvelope) -> Self {
        let AxisLimits { a, j, .. } = envelope.tail();
        Self {
            a,
            j,
            fade_us: fade_us(envelope),
        }
    }
}

/// Tᵢ of an axis: whole microseconds, at least one.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a float to integer cast saturates"
)]
fn fade_us(envelope: &AxisEnvelope) -> u64 {
    ((envelope.fade_s() * US_PER_S) as u64).max(1)
}

/// The same as a span; none where it is longer than 71 minutes, which no tail is.
pub(crate) fn fade_span(envelope: &AxisEnvelope) -> Span {
    Span::new(fade_us(envelope)).unwrap_or(Span::NONE)
}

impl<const N: usize> Tail<N> {
    /// At rest already.
    pub(crate) const fn at_rest(position: [Angle; N]) -> Self {
        Self {
            from: Setpoint::at_rest(position),
            span: Span::NONE,
            duration_us: 0,
            along: [0; N],
            fading: [0; N],
        }
    }

    /// The state that it begins with, where the path ends.
    pub(crate) const fn from(&self) -> &Setpoint<N> {
        &self.from
    }

    /// The tail behind a state, and an interval that holds all positions of each axis on it: both parts move one way
    /// only.
    ///
    /// # Errors
    /// [`Unfixable`]: it is too long, or goes too far.
    pub(crate) fn new(
        end: &End<N>,
        axes: &[TailLimits; N],
    ) -> Result<(Self, [(f64, f64); N]), Unfixable> {
        let (mut t, mut duration_us) = (0.0, 0);
        let states = end.velocity.iter().zip(&end.acceleration);
        for (axis, (v, a)) in axes.iter().zip(states) {
            let (v, a) = (v.abs(), a.abs());
            let fade = float_us(axis.fade_us) / US_PER_S;
            if a > 0.0 {
                duration_us = duration_us.max(axis.fade_us);
            }
            t = larger(t, 1.5 * v / (axis.a - a));
            t = larger(t, libm::sqrt(6.0 * v / (axis.j - 4.0 * a / fade)));
        }
        let span = Span::new(whole_us(t)).ok_or(Unfixable::Long)?;
        let t = float_us(span.us()) / US_PER_S;
        let mut tail = Self {
            from: Setpoint {
                position: end.position.map(Angle::bound),
                velocity: end.velocity.map(narrow),
                acceleration: end.acceleration.map(narrow),
            },
            span,
            duration_us: duration_us.max(span.us()),
            along: [0; N],
            fading: [0; N],
        };
        let mut reach = [(0.0, 0.0); N];
        let ways = tail.along.iter_mut().zip(&mut tail.fading).zip(&mut reach);
        for (axis, (((w0, w1), reach), ([p, v, a], limits))) in
            (0..N).zip(ways.zip(end.axes().zip(axes)))
        {
            let fade = float_us(limits.fade_us) / US_PER_S;
            let (along, faded) = (0.5 * v * t, a * fade * fade / 12.0);
            for way in [along, faded] {
                let value = libm::fabs(way);
                if value >= MOST_WAY {
                    let limit = MOST_WAY;
                    return Err(Unfixable::Far { axis, value, limit });
                }
            }
            (*w0, *w1) = (sixteenths(along), sixteenths(faded));
            *reach = (
                p + smaller(along, 0.0) + smaller(faded, 0.0),
                p + larger(along, 0.0) + larger(faded, 0.0),
            );
        }
        Ok((tail, reach))
    }

    /// Path time until rest, µs.
    pub(crate) const fn duration_us(&self) -> u64 {
        self.duration_us
    }

    /// Position, and its first and second derivative with respect to path time, of each axis, so many µs (and 2⁻³² µs)
    /// behind the end; `fades` are the axes' Tᵢ.
    pub(crate) fn at<'a>(
        &'a self,
        fades: impl Iterator<Item = &'a Span> + 'a,
        (since_us, fraction): (u64, u32),
    ) -> impl Iterator<Item = (Angle, f32, f32)> + 'a {
        let along = self.span.part(since_us, fraction).map(|part| {
            let u = part.share();
            let per_s = 1.0 / seconds(&self.span);
            let h0 = 1.0 + u * u * (2.0 * u - 3.0);
            (part, h0, 6.0 * u * (u - 1.0) * per_s)
        });
        let ways = self.along.iter().zip(&self.fading).zip(fades);
        states(&self.from)
            .zip(ways)
            .map(move |((p, v, a), ((w0, w1), fade))| {
                let (way, left, velocity, acceleration) = match along {
                    Some((part, h0, slope)) => {
                        (going(*w0, part.u), part.left * (v * h0), v * h0, v * slope)
                    }
                    None => (*w0, 0.0, 0.0, 0.0),
                };
                let (faded, more, dv, da) = match fade.part(since_us, fraction) {
                    Some(part) => {
                        let x = part.share();
                        let rest = 1.0 - x;
                        let dv = a * seconds(fade) * x * rest * rest;
                        (
                            fading(*w1, part.u),
                            part.left * dv,
                            dv,
                            a * rest * (1.0 - 3.0 * x),
                        )
                    }
                    None => (*w1, 0.0, 0.0, 0.0),
                };
                let way = whole_quanta(way.wrapping_add(faded));
                (
                    p.plus(way.wrapping_add(whole(left + more))),
                    velocity + dv,
                    acceleration + da,
                )
            })
    }

    /// Where the path comes to rest.
    pub(crate) fn rest_position(&self) -> [Angle; N] {
        let mut position = self.from.position;
        let ways = self.along.iter().zip(&self.fading);
        for (position, (w0, w1)) in position.iter_mut().zip(ways) {
            *position = position.plus(whole_quanta(w0.wrapping_add(*w1)));
        }
        position
    }
}

/// Position, velocity and acceleration of each axis.
pub(crate) fn states<const N: usize>(
    of: &Setpoint<N>,
) -> impl Iterator<Item = (Angle, f32, f32)> + '_ {
    let derivatives = of.velocity.iter().zip(&of.acceleration);
    let axes = of.position.iter().zip(derivatives);
    axes.map(|(p, (v, a))| (*p, *v, *a))
}

/// `w·(2u − 2u³ + u⁴)`
fn going(w: i64, u: u32) -> i64 {
    let two = w.wrapping_mul(2);
    let sum = times_fraction(w, u).wrapping_sub(two);
    let sum = times_fraction(times_fraction(sum, u), u).wrapping_add(two);
    times_fraction(sum, u)
}

/// `w·(6x² − 8x³ + 3x⁴)`
fn fading(w: i64, x: u32) -> i64 {
    let sum = times_fraction(w.wrapping_mul(3), x).wrapping_sub(w.wrapping_mul(8));
    let sum = times_fraction(sum, x).wrapping_add(w.wrapping_mul(6));
    times_fraction(times_fraction(sum, x), x)
}

/// Of a way in 16ths of a quantum the nearest quantum.
const fn whole_quanta(way: i64) -> i64 {
    way.wrapping_add(8) >> SIXTEENTH_BITS
}

/// Its duration in s, in 24 bits.
#[expect(clippy::cast_precision_loss, reason = "24 bits are enough")]
fn seconds(span: &Span) -> f32 {
    span.us() as f32 * S_PER_US
}

/// Whole microseconds, rounded up.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a float to integer cast saturates, and what is too long is refused"
)]
fn whole_us(s: f64) -> u64 {
    libm::ceil(s * US_PER_S) as u64
}

/// A way in 16ths of a quantum, to the nearest.
#[expect(
    clippy::cast_possible_truncation,
    reason = "below 2^60: it was compared"
)]
fn sixteenths(way: f64) -> i64 {
    libm::round(way * SIXTEENTHS) as i64
}

#[cfg(test)]
mod test {
    use super::*;
    use proptest::prelude::*;

    const LIMITS: AxisLimits = AxisLimits {
        v: 250.0,
        a: 900.0,
        j: 60_000.0,
    };

    proptest! {
        /// The polynomials of the description in f64, wherever on the tail and behind it.
        #[test]
        fn it_is_the_tail_in_f64_within_three_quanta(
            p in -4000.0..4000.0f64, v in -0.9..0.9f64, a in -1.0..1.0f64, at in prop::collection::vec((0.0..1.2f64, any::<u32>()), 16),
        ) {
            let axis = AxisEnvelope::new(-1e5, 1e5, LIMITS);
            let (v, a) = (v * axis.plan.v, a * axis.plan.a);
            let end = End { at_us: 7, position: [p], velocity: [v], acceleration: [a] };
            let (tail, [(low, high)]) = Tail::new(&end, &[TailLimits::new(&axis)]).unwrap();
            let fade = fade_span(&axis);
            let (t, f) = (1e-6 * float_us(tail.span.us()), 1e-6 * float_us(fade.us()));
            // T is the shortest that the limits of the tail allow, in whole microseconds
            let most = axis.tail();
            let needed = |t: f64| larger(1.5 * v.abs() / t + a.abs() - most.a, (6.0 * v.abs() / (t * t) + 4.0 * a.abs() / f - most.j) / 1e3);
            prop_assert!(v == 0.0 || (needed(t) <= 1e-6 && needed(t - 1.01e-6) > -1e-6), "{}", needed(t));
            for (share, fraction) in at {
                #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a test")]
                let us = (share * float_us(tail.duration_us())) as u64;
                let s = 1e-6 * (float_us(us) + f64::from(fraction) / 4_294_967_296.0);
                let (u, x) = (smaller(s / t, 1.0), smaller(s / f, 1.0));
                let position = p + v * t * (u - u * u * u + 0.5 * u * u * u * u) + a * f * f * x * x * (0.5 - 2.0 / 3.0 * x + 0.25 * x * x);
                let velocity = v * (1.0 - 3.0 * u * u + 2.0 * u * u * u) + a * f * x * (1.0 - x) * (1.0 - x);
                let acceleration = v * 6.0 * u * (u - 1.0) / t + a * (1.0 - x) * (1.0 - 3.0 * x);
                let found = tail.at([fade].iter(), (us, fraction)).next();
                let (angle, dv, da) = found.unwrap();
                let off = (angle.to_f64() - position) * 1_099_511_627_776.0;
                // and f64 in this test: ten roundings of up to 4000 and 60
                prop_assert!(off.abs() < 3.0 + 1e-15 * 5000.0 * 1_099_511_627_776.0, "{off} quanta");
                prop_assert!((f64::from(dv) - velocity).abs() < 1e-6 * (v.abs() + a.abs() * f), "{dv} {velocity}");
                prop_assert!((f64::from(da) - acceleration).abs() < 2e-6 * (6.0 * v.abs() / t + 2.0 * a.abs()), "{da} {acceleration}");
                prop_assert!(position >= low - 1e-9 && position <= high + 1e-9);
            }
            let rest = tail.at([fade].iter(), (tail.duration_us(), 0)).next();
            let [stands] = tail.rest_position();
            prop_assert_eq!(rest, Some((stands, 0.0, 0.0)));
        }
    }
}
