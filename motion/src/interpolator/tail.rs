//! The stop tail: how the path goes on behind its last knot, to rest.

use super::segment::End;
use crate::knot::AxisEnvelope;
use crate::profile::AxisLimits;
use crate::scalar::{larger, narrow, smaller, within};

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
/// there is a T, and the smallest one is taken.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tail<const N: usize> {
    t: f64,
    fade: [f64; N],
    duration: f64,
}

/// What of an envelope a tail is made with, found once and not at every knot.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TailLimits {
    a: f64,
    j: f64,
    fade: f64,
}

impl TailLimits {
    /// Nothing may move.
    pub(crate) const NOWHERE: Self = Self {
        a: 0.0,
        j: 0.0,
        fade: 0.0,
    };

    pub(crate) fn new(envelope: &AxisEnvelope) -> Self {
        let AxisLimits { a, j, .. } = envelope.tail();
        let fade = envelope.fade_s();
        Self { a, j, fade }
    }
}

impl<const N: usize> Tail<N> {
    /// At rest already.
    pub(crate) const NONE: Self = Self {
        t: 0.0,
        fade: [0.0; N],
        duration: 0.0,
    };

    pub(crate) fn new(end: &End<N>, axes: &[TailLimits; N]) -> Self {
        let (mut t, mut duration) = (0.0, 0.0);
        let mut fade = [0.0; N];
        let states = end.velocity.iter().zip(&end.acceleration);
        for ((own, axis), (v, a)) in fade.iter_mut().zip(axes).zip(states) {
            let (v, a, limits) = (v.abs(), a.abs(), axis);
            *own = axis.fade;
            if a > 0.0 {
                duration = larger(duration, *own);
            }
            t = larger(t, 1.5 * v / (limits.a - a));
            t = larger(t, libm::sqrt(6.0 * v / (limits.j - 4.0 * a / *own)));
        }
        Self {
            t,
            fade,
            duration: larger(duration, t),
        }
    }

    /// Path time until rest, s.
    pub(crate) fn duration(&self) -> f64 {
        self.duration
    }

    /// Position, and its first and second derivative with respect to path time, of each axis: positions in f64, the
    /// derivatives in f32.
    pub(crate) fn at<'a>(
        &'a self,
        end: &'a End<N>,
        after_s: f64,
    ) -> impl Iterator<Item = (f64, f32, f32)> + 'a {
        let u = if self.t > 0.0 {
            within(after_s / self.t, 0.0, 1.0)
        } else {
            1.0
        };
        let way = self.t * u * (1.0 + u * u * (0.5 * u - 1.0));
        let (u, t) = (narrow(u), narrow(self.t));
        let h0 = 1.0 + u * u * (2.0 * u - 3.0);
        let slope = if t > 0.0 {
            6.0 * u * (u - 1.0) / t
        } else {
            0.0
        };
        end.axes().zip(&self.fade).map(move |([p, v, a], fade)| {
            let x = within(after_s / fade, 0.0, 1.0);
            let faded = a * fade * fade * x * x * (0.5 + x * (0.25 * x - 2.0 / 3.0));
            let position = p + v * way + faded;
            let (v, a, x, fade) = (narrow(v), narrow(a), narrow(x), narrow(*fade));
            let left = 1.0 - x;
            (
                position,
                v * h0 + a * fade * x * left * left,
                v * slope + a * left * (1.0 - 3.0 * x),
            )
        })
    }

    /// Where the path comes to rest.
    pub(crate) fn rest_position(&self, end: &End<N>) -> [f64; N] {
        let mut position = end.position;
        for (to, (p, ..)) in position.iter_mut().zip(self.at(end, self.duration)) {
            *to = p;
        }
        position
    }

    /// An interval that holds all positions of each axis: both parts move one way only.
    pub(crate) fn reach<'a>(&'a self, end: &'a End<N>) -> impl Iterator<Item = (f64, f64)> + 'a {
        end.axes().zip(&self.fade).map(|([p, v, a], fade)| {
            let (along, fading) = (0.5 * v * self.t, a * fade * fade / 12.0);
            (
                p + smaller(along, 0.0) + smaller(fading, 0.0),
                p + larger(along, 0.0) + larger(fading, 0.0),
            )
        })
    }
}
