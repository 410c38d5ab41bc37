//! The clock of the path: how fast path time runs against the caller's time.

use crate::knot::AxisEnvelope;
use crate::ramp::Ramp;
use crate::scalar::{US_PER_S, float_us, smaller, split_us, within};

/// Limits of the feed rate's derivatives: |dr/dt| ≤ `first` (1/s), |d²r/dt²| ≤ `second` (1/s²).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RateLimits {
    pub(crate) first: f64,
    pub(crate) second: f64,
}

/// Kept below what the limits allow, for the tolerance of the check at push and for rounding.
const MARGIN: f64 = 1.0 - 1e-6;
/// Values tried for the trade between first and second derivative.
const TRIED: u32 = 32;

impl RateLimits {
    /// The limits with the fastest stop such that no set-point leaves the hard limits.
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

/// An instant of path time and how it passes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PathTime {
    /// Whole microseconds, and the rest in 2⁻³² µs.
    pub(crate) us: u64,
    pub(crate) fraction: u32,
    /// r, and ṙ in 1/s.
    pub(crate) rate: f64,
    pub(crate) change: f64,
}

impl PathTime {
    pub(crate) fn is_after(&self, us: u64) -> bool {
        self.us > us || (self.us == us && self.fraction > 0)
    }
}

/// Fractions of a microsecond in one.
const FRACTIONS: f64 = 4_294_967_296.0;

/// A part in \[0, 1) of a microsecond, rounded down to 2⁻³².
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a float to integer cast saturates, and the argument is not negative"
)]
fn fraction(part: f64) -> u32 {
    (part * FRACTIONS) as u32
}

/// Path time as a closed form of the caller's time since the last change of mind: nothing is
/// accumulated from step to step, so nothing drifts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PathClock {
    limits: RateLimits,
    since_us: u64,
    from: PathTime,
    ramp: Option<Ramp>,
}

impl PathClock {
    pub(crate) fn new(limits: RateLimits) -> Self {
        Self {
            limits,
            since_us: 0,
            from: PathTime {
                us: 0,
                fraction: 0,
                rate: 1.0,
                change: 0.0,
            },
            ramp: None,
        }
    }

    /// As new, with the same limits.
    pub(crate) fn reset(&mut self) {
        *self = Self::new(self.limits);
    }

    /// Path time equals the caller's time at `at_us` and runs at a constant rate from then on.
    pub(crate) fn start(&mut self, at_us: u64, rate: f64) {
        self.since_us = at_us;
        self.from = PathTime {
            us: at_us,
            fraction: 0,
            rate,
            change: 0.0,
        };
        self.ramp = None;
    }

    pub(crate) fn at(&self, now_us: u64) -> PathTime {
        let passed_us = now_us.saturating_sub(self.since_us);
        let Some(ramp) = &self.ramp else {
            if self.from.rate >= 1.0 {
                // whole microseconds stay whole
                return PathTime {
                    us: self.from.us.saturating_add(passed_us),
                    ..self.from
                };
            }
            return self.advanced(
                self.from.rate * float_us(passed_us),
                self.from.rate,
                self.from.change,
            );
        };
        let state = ramp.at(float_us(passed_us) / US_PER_S);
        let rate = within(state.x, 0.0, 1.0);
        self.advanced(state.integral * US_PER_S, rate, state.dx)
    }

    fn advanced(&self, by_us: f64, rate: f64, change: f64) -> PathTime {
        let (whole, part) = split_us(by_us);
        // rounded down, below 2³²: of a later time it is never less
        let (fraction, carry) = self.from.fraction.overflowing_add(fraction(part));
        let us = self.from.us.saturating_add(whole);
        PathTime {
            us: us.saturating_add(u64::from(carry)),
            fraction,
            rate,
            change,
        }
    }

    /// Begins to change the rate, smoothly from whatever it does now.
    pub(crate) fn change_to(&mut self, target: f64, now_us: u64) {
        if self.ramp.is_none() && (self.from.rate - target).abs() <= 0.0 {
            return;
        }
        let from = self.at(now_us);
        let RateLimits { first, second } = self.limits;
        self.ramp = Some(Ramp::new(from.rate, from.change, target, first, second));
        self.from = from;
        self.since_us = now_us;
    }

    /// Ends a finished change, so that a rate of 1 counts in whole microseconds again.
    pub(crate) fn settle(&mut self, now_us: u64) {
        if let Some(ramp) = &self.ramp {
            let passed = float_us(now_us.saturating_sub(self.since_us)) / US_PER_S;
            if passed >= ramp.duration() {
                let target = ramp.target();
                self.from = PathTime {
                    rate: target,
                    change: 0.0,
                    ..self.at(now_us)
                };
                self.since_us = now_us;
                self.ramp = None;
            }
        }
    }

    /// The rate that is being changed to, if any.
    pub(crate) fn changing_to(&self) -> Option<f64> {
        self.ramp.as_ref().map(Ramp::target)
    }

    pub(crate) fn stands(&self) -> bool {
        self.ramp.is_none() && self.from.rate <= 0.0
    }
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
            prop_assert!(fullest > 1.0 - 1e-5);
        }
    }
}
