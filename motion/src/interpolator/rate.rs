//! The clock of the path: how fast path time runs against the caller's time.

use super::rate_ramp::RateRamp;
use super::span::{float, lower};
use super::stop::{MARGIN, StopLimits};
use crate::knot::AxisEnvelope;
use crate::ramp::Ramp;
use crate::scalar::{narrow, smaller};

/// Limits of the feed rate's derivatives: |dr/dt| ≤ `first` (1/s), |d²r/dt²| ≤ `second` (1/s²).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RateLimits {
    pub(crate) first: f64,
    pub(crate) second: f64,
}

/// Values tried for the trade between first and second derivative.
const TRIED: u32 = 32;

impl RateLimits {
    /// The same for the stop of a rate.
    pub(crate) fn narrow(self) -> StopLimits {
        StopLimits {
            a: narrow(self.first),
            j: narrow(self.second),
        }
    }

    /// The limits with the fastest stop such that no set-point leaves the hard limits, less [`MARGIN`].
    ///
    /// With position p(s(t)) and r = ds/dt in \[0, 1\]:
    /// velocity p'·r, acceleration p''·r² + p'·ṙ, jerk p'''·r³ + 3·p''·r·ṙ + p'·r̈.
    /// With |p'| ≤ v, |p''| ≤ a, |p'''| ≤ j (the path including its stop tail) it suffices that
    /// a + v·|ṙ| ≤ A and j + 3·a·|ṙ| + v·|r̈| ≤ J for every axis.
    pub(crate) fn new<const N: usize>(axes: &[AxisEnvelope; N]) -> Self {
        let mut most = f64::INFINITY;
        for axis in axes {
            let path = axis.tail();
            most = smaller(most, (axis.hard.a - path.a) / path.v);
            most = smaller(most, (axis.hard.j - path.j) / (3.0 * path.a));
        }
        let mut best = Self {
            first: 1.0,
            second: 1.0,
        };
        let mut shortest = f64::INFINITY;
        for k in 1..TRIED {
            let first = MARGIN * most * f64::from(k) / f64::from(TRIED);
            let second = MARGIN
                * axes.iter().fold(f64::INFINITY, |least, axis| {
                    let path = axis.tail();
                    let left = axis.hard.j - path.j - 3.0 * path.a * first;
                    smaller(least, left / path.v)
                });
            let limits = Self { first, second };
            let time = Ramp::new(1.0, 0.0, 0.0, first, second).duration();
            if time < shortest {
                (best, shortest) = (limits, time);
            }
        }
        best
    }
}

/// A feed rate in 2⁻³², at most [`FULL`](Self::FULL).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct FeedRate(u64);

impl FeedRate {
    /// The path stands.
    pub(crate) const ZERO: Self = Self(0);
    /// Path time is time.
    pub(crate) const FULL: Self = Self(1 << 32);

    /// The nearest below a number; of one that is not in \[0, 1\], the nearer end, and 0 of what is none.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a float to integer cast saturates, and is 0 of what is no number"
    )]
    pub(crate) fn of(share: f64) -> Self {
        Self((share * FRACTIONS) as u64).min(Self::FULL)
    }

    /// In 2⁻³².
    pub(crate) const fn parts(self) -> i64 {
        self.0.cast_signed()
    }

    /// In 24 bits.
    pub(crate) const fn share(self) -> f32 {
        // 31 bits of it: of more a microcontroller makes a float by thirty instructions
        2.0 * PER_FRACTION * float(lower(self.0 >> 1))
    }

    /// How much further a path is after so many µs.
    const fn after(self, us: u64) -> (u64, u32) {
        let (high, low) = (us >> 32, us & LOW);
        let low = low.wrapping_mul(self.0);
        let us = high.wrapping_mul(self.0).wrapping_add(low >> 32);
        (us, lower(low))
    }
}

/// Fractions of a microsecond in one.
const FRACTIONS: f64 = 4_294_967_296.0;
/// One of them.
const PER_FRACTION: f32 = 1.0 / 4_294_967_296.0;
/// The lower 32 bits.
const LOW: u64 = 0xFFFF_FFFF;

/// An instant of path time and how it passes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PathTime {
    /// Whole microseconds, and the rest in 2⁻³² µs.
    pub(crate) us: u64,
    pub(crate) fraction: u32,
    /// r, and ṙ in 1/s.
    pub(crate) rate: f32,
    pub(crate) change: f32,
}

impl PathTime {
    pub(crate) fn is_after(&self, us: u64) -> bool {
        self.us > us || (self.us == us && self.fraction > 0)
    }
}

/// Path time in closed form of the caller's time since the last change of mind, in integers: nothing is
/// accumulated from step to step, so nothing drifts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PathClock {
    limits: StopLimits,
    since_us: u64,
    /// Path time then, µs and 2⁻³² µs.
    from: (u64, u32),
    /// Constant since then, or what it will be in the end.
    rate: FeedRate,
    /// What is beyond that rate, and goes to 0.
    ramp: Option<RateRamp>,
    /// Path time at the last step.
    latest: (u64, u32),
}

impl PathClock {
    pub(crate) fn new(limits: StopLimits) -> Self {
        Self {
            limits,
            since_us: 0,
            from: (0, 0),
            rate: FeedRate::FULL,
            ramp: None,
            latest: (0, 0),
        }
    }

    /// As new, with the same limits.
    pub(crate) fn reset(&mut self) {
        *self = Self::new(self.limits);
    }

    /// Path time equals the caller's time at `at_us` and runs at a constant rate from then on.
    pub(crate) fn start(&mut self, at_us: u64, rate: FeedRate) {
        self.since_us = at_us;
        self.from = (at_us, 0);
        self.rate = rate;
        self.ramp = None;
        self.latest = self.from;
    }

    /// The next step, at a time that never goes back: what rounding would make path time go back is taken away.
    pub(crate) fn step(&mut self, now_us: u64) -> PathTime {
        self.settle(now_us);
        let path = self.at(now_us);
        self.latest = self.latest.max((path.us, path.fraction));
        let (us, fraction) = self.latest;
        PathTime {
            us,
            fraction,
            ..path
        }
    }

    pub(crate) fn at(&self, now_us: u64) -> PathTime {
        let passed_us = now_us.saturating_sub(self.since_us);
        // at rate 1 whole microseconds stay whole
        let mut time = later(self.from, self.rate.after(passed_us));
        let (mut rate, mut change) = (self.rate, 0.0);
        if let Some(ramp) = &self.ramp {
            let (more, beyond, changes) = ramp.at(passed_us);
            // what is negative has whole µs that are, rounded down, and they wrap
            time = later(
                time,
                ((more >> 32).cast_unsigned(), lower(more.cast_unsigned())),
            );
            rate = FeedRate(self.rate.0.saturating_add_signed(beyond)).min(FeedRate::FULL);
            change = changes;
        }
        let (us, fraction) = time;
        PathTime {
            us,
            fraction,
            rate: rate.share(),
            change,
        }
    }

    /// Begins to change the rate, smoothly from whatever it does now.
    pub(crate) fn change_to(&mut self, target: FeedRate, now_us: u64) {
        if self.ramp.is_none() && self.rate == target {
            return;
        }
        let PathTime {
            us,
            fraction,
            change,
            ..
        } = self.at(now_us);
        let beyond = self.ramp.as_ref().map_or(0, |ramp| {
            let (_, beyond, _) = ramp.at(now_us.saturating_sub(self.since_us));
            beyond
        });
        // both are at most 2³², and so is what they differ by
        let gap = self.rate.parts().wrapping_sub(target.parts());
        // axes that need a quarter of an hour to stop would be too much for integers: there it changes at once
        self.ramp = RateRamp::new(gap.wrapping_add(beyond), change, self.limits);
        self.from = (us, fraction);
        self.since_us = now_us;
        self.rate = target;
    }

    /// Ends a finished change, so that a rate of 1 counts in whole microseconds again.
    fn settle(&mut self, now_us: u64) {
        if let Some(ramp) = &self.ramp
            && now_us.saturating_sub(self.since_us) >= ramp.duration_us()
        {
            let PathTime { us, fraction, .. } = self.at(now_us);
            self.from = (us, fraction);
            self.since_us = now_us;
            self.ramp = None;
        }
    }

    /// The rate that is being changed to, if any.
    pub(crate) fn changing_to(&self) -> Option<f32> {
        self.ramp.as_ref().map(|_| self.rate.share())
    }

    pub(crate) fn stands(&self) -> bool {
        self.ramp.is_none() && self.rate == FeedRate::ZERO
    }
}

/// The sum of two times in µs and 2⁻³² µs.
const fn later((us, fraction): (u64, u32), (by_us, by_fraction): (u64, u32)) -> (u64, u32) {
    let (fraction, carry) = fraction.overflowing_add(by_fraction);
    let us = us.wrapping_add(by_us).wrapping_add(carry as u64);
    (us, fraction)
}

#[cfg(test)]
mod test {
    use super::*;
    use crate::profile::AxisLimits;
    use proptest::prelude::*;

    proptest! {
        /// The two inequalities from which every set-point's limits follow, and that little is wasted.
        #[test]
        fn rate_limits_leave_room_on_every_axis(
            v in prop::array::uniform3(0.01..100.0f64), a in prop::array::uniform3(0.1..1e3f64), j in prop::array::uniform3(1.0..1e5f64),
        ) {
            let axes: [AxisEnvelope; 3] = core::array::from_fn(|i| {
                AxisEnvelope::new(-1.0, 1.0, AxisLimits { v: v[i], a: a[i], j: j[i] })
            });
            let RateLimits { first, second } = RateLimits::new(&axes);
            prop_assert!(first > 0.0 && second > 0.0);
            let mut fullest = 0.0;
            for axis in &axes {
                let (path, hard) = (axis.tail(), axis.hard);
                let acceleration = (path.a + path.v * first) / hard.a;
                let jerk = (path.j + 3.0 * path.a * first + path.v * second) / hard.j;
                prop_assert!(path.v < hard.v && acceleration < 1.0 && jerk < 1.0);
                fullest = crate::scalar::larger(fullest, jerk);
            }
            prop_assert!(fullest > 1.0 - 1e-4);
        }
    }
}
