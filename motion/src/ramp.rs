//! The fastest change of a quantity to a new value, with limited first and second derivative.
//!
//! The velocity of an axis changes so while it looks for its zero; by how fast a feed rate does, its limits are found.

use crate::scalar::{SIXTH, larger, sign, smaller};

/// The quantity x, its derivative, and its integral since the ramp began.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RampState {
    /// ∫x dt since the beginning.
    pub integral: f64,
    /// x
    pub x: f64,
    /// dx/dt
    pub dx: f64,
}

/// From (x, dx) to (target, 0): at most three phases with ddx = s, 0, −s.
///
/// Because every ramp with the same limits can come to dx = 0 no later than at its own target, a
/// chain of interrupted ramps never leaves the interval spanned by its targets and its start at dx = 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ramp {
    x0: f64,
    dx0: f64,
    target: f64,
    /// ddx in the first phase.
    s: f64,
    t1: f64,
    t2: f64,
    t3: f64,
    /// State where the second phase begins.
    second: RampState,
    total: f64,
}

impl Ramp {
    /// The time-optimal ramp with |dx| ≤ `rate`, |ddx| ≤ `bend`, both positive; |`dx0`| ≤ `rate`.
    #[must_use]
    pub fn new(x0: f64, dx0: f64, target: f64, rate: f64, bend: f64) -> Self {
        let stopping = x0 + 0.5 * dx0 * dx0.abs() / bend;
        let towards = sign(target - stopping);
        let side = if towards == 0.0 { sign(dx0) } else { towards };
        let (s, along) = (side * bend, side * dx0);
        let distance = side * (target - x0);
        let square = larger(bend * distance + 0.5 * along * along, 0.0);
        let peak = smaller(libm::sqrt(square), rate);
        let t1 = larger((peak - along) / bend, 0.0);
        let t3 = peak / bend;
        let ramps = (2.0 * peak * peak - along * along) / (2.0 * bend);
        let t2 = if peak >= rate {
            larger((distance - ramps) / peak, 0.0)
        } else {
            0.0
        };
        let mut ramp = Self {
            x0,
            dx0,
            target,
            s,
            t1,
            t2,
            t3,
            second: RampState {
                integral: 0.0,
                x: x0,
                dx: dx0,
            },
            total: 0.0,
        };
        ramp.second = ramp.first(t1);
        ramp.second.dx = s * t3;
        let third = ramp.during_second(t2);
        ramp.total = third.integral + t3 * (target - s * t3 * t3 / 6.0);
        ramp
    }

    /// How long the change takes, s.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.t1 + self.t2 + self.t3
    }

    /// The state t seconds after the beginning; constant from the end on.
    #[must_use]
    pub fn at(&self, t: f64) -> RampState {
        if t < self.t1 {
            return self.first(larger(t, 0.0));
        }
        if t < self.t1 + self.t2 {
            return self.during_second(t - self.t1);
        }
        // backwards from the end, so that it is reached exactly
        let left = self.duration() - t;
        if left > 0.0 {
            return RampState {
                integral: self.total - left * (self.target - self.s * left * left * SIXTH),
                x: self.target - 0.5 * self.s * left * left,
                dx: self.s * left,
            };
        }
        RampState {
            integral: self.total - left * self.target,
            x: self.target,
            dx: 0.0,
        }
    }

    fn first(&self, t: f64) -> RampState {
        RampState {
            integral: t * (self.x0 + t * (0.5 * self.dx0 + t * self.s * SIXTH)),
            x: self.x0 + t * (self.dx0 + t * 0.5 * self.s),
            dx: self.dx0 + t * self.s,
        }
    }

    fn during_second(&self, t: f64) -> RampState {
        let from = self.second;
        RampState {
            integral: from.integral + t * (from.x + 0.5 * t * from.dx),
            x: from.x + t * from.dx,
            dx: from.dx,
        }
    }
}

#[cfg(test)]
mod test {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn limits_hold_and_the_target_is_met(
            x0 in -2.0..2.0f64, share in -1.0..1.0f64, target in -2.0..2.0f64,
            rate in 0.01..10.0f64, bend in 0.01..100.0f64,
        ) {
            let ramp = Ramp::new(x0, share * rate, target, rate, bend);
            let (n, mut before) = (400u32, ramp.at(0.0));
            prop_assert_eq!(before.x.to_bits(), x0.to_bits());
            let h = ramp.duration() / f64::from(n);
            for i in 1..=n {
                let now = ramp.at(h * f64::from(i));
                prop_assert!(now.dx.abs() <= rate * (1.0 + 1e-12));
                prop_assert!((now.dx - before.dx).abs() <= bend * h * (1.0 + 1e-9) + 1e-12);
                // trapezoid rules: errors h³/12·bend for x, h²/8·(rate + bend·h)·h for its integral
                prop_assert!((now.x - before.x - 0.5 * h * (now.dx + before.dx)).abs() <= bend * h * h * 0.26 + 1e-11);
                let area = 0.5 * h * (now.x + before.x);
                prop_assert!((now.integral - before.integral - area).abs() <= bend * h * h * h + 1e-10);
                before = now;
            }
            let end = ramp.at(ramp.duration());
            prop_assert!((end.x - target).abs() < 1e-12 && end.dx.abs() < 1e-9);
            prop_assert!((ramp.total - end.integral).abs() < 1e-9 * (1.0 + ramp.duration()));
        }

        #[test]
        fn interrupted_ramps_stay_between_their_targets(
            targets in prop::collection::vec((0.0..=1.0f64, 0.0..1.2f64), 1..12), rate in 0.1..5.0f64, bend in 0.1..50.0f64,
        ) {
            let (mut x, mut dx) = (1.0, 0.0);
            for (target, share) in targets {
                let ramp = Ramp::new(x, dx, target, rate, bend);
                for i in 0..50u32 {
                    let s = ramp.at(ramp.duration() * f64::from(i) / 50.0);
                    prop_assert!(s.x > -1e-12 && s.x < 1.0 + 1e-12, "{s:?}");
                }
                let s = ramp.at(ramp.duration() * share);
                (x, dx) = (s.x, s.dx);
            }
        }
    }
}
