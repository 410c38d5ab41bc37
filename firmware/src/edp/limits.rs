//! The gate before the drives: every set-point is checked, whoever made it.
//!
//! The gate knows only the set-points themselves: velocity, acceleration and jerk are the
//! differences of what is really sent, so a mistake anywhere above cannot pass it.

use protocol::fault::{Cause, Quantity};

/// Bounds of one axis; motor shaft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// rad; −∞ before homing.
    pub lower: f64,
    /// rad; +∞ before homing.
    pub upper: f64,
    /// rad/s
    pub velocity: f64,
    /// rad/s²
    pub acceleration: f64,
    /// rad/s³
    pub jerk: f64,
}

/// A set-point that must not be sent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Violation {
    /// The axis, from 0.
    pub axis: usize,
    /// What would be broken.
    pub quantity: Quantity,
    /// What it would be.
    pub value: f64,
    /// What it may be.
    pub limit: f64,
}

impl Violation {
    /// The fault it means.
    #[must_use]
    pub const fn cause(&self) -> Cause {
        match self.quantity {
            Quantity::MotorPosition | Quantity::JointPosition => {
                if self.value.is_finite() {
                    Cause::PositionLimit
                } else {
                    Cause::NotFinite
                }
            }
            Quantity::Velocity => Cause::VelocityLimit,
            Quantity::Acceleration => Cause::AccelerationLimit,
            Quantity::Jerk => Cause::JerkLimit,
        }
    }
}

/// A limit counts as kept up to this relative excess, for the rounding of the third difference:
/// 8 half-ulps at 4096 rad are 3.6e-12 rad, over (2 ms)³ 4.6e-4 rad/s³, of 15000 rad/s³ 3e-8.
const ROUNDING: f64 = 1e-7;

#[derive(Clone, Copy, Debug, PartialEq)]
struct Past {
    position: f64,
    velocity: f64,
    acceleration: f64,
}

/// Remembers the last set-point of every axis and refuses what breaks a limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gate<const N: usize> {
    past: [Past; N],
    /// Servo steps a second, 1/s: differences are multiplied by it, which is a fifth of the work of a division.
    rate: f64,
}

impl<const N: usize> Gate<N> {
    /// At rest at these positions, rad; `ts` is the servo step in s.
    #[must_use]
    pub fn at_rest(positions: &[f64; N], ts: f64) -> Self {
        Self {
            past: positions.map(|position| Past {
                position,
                velocity: 0.0,
                acceleration: 0.0,
            }),
            rate: 1.0 / ts,
        }
    }

    /// The last set-points that passed, rad.
    #[must_use]
    pub fn positions(&self) -> [f64; N] {
        self.past.map(|past| past.position)
    }

    /// The origin of one axis has moved: its positions shift by `by`, nothing else changes.
    pub fn shift(&mut self, axis: usize, by: f64) {
        if let Some(past) = self.past.get_mut(axis) {
            past.position += by;
        }
    }

    /// Check the set-points of one servo step; they become the past only if all are kept.
    ///
    /// # Errors
    /// The first violation, in the order of the axes; nothing is remembered then.
    pub fn pass(&mut self, positions: &[f64; N], bounds: &[Bounds; N]) -> Result<(), Violation> {
        let mut next = self.past;
        for (axis, ((p, b), past)) in (0..N).zip(positions.iter().zip(bounds).zip(&mut next)) {
            let fail = |quantity, value, limit| {
                Err(Violation {
                    axis,
                    quantity,
                    value,
                    limit,
                })
            };
            if !p.is_finite() {
                return fail(Quantity::MotorPosition, *p, b.upper);
            }
            // Outside its range an axis may only come back.
            let inward =
                (*p < b.lower && *p >= past.position) || (*p > b.upper && *p <= past.position);
            if (*p < b.lower || *p > b.upper) && !inward {
                let limit = if *p < b.lower { b.lower } else { b.upper };
                return fail(Quantity::MotorPosition, *p, limit);
            }
            let velocity = (p - past.position) * self.rate;
            let acceleration = (velocity - past.velocity) * self.rate;
            let jerk = (acceleration - past.acceleration) * self.rate;
            for (quantity, value, limit) in [
                (Quantity::Velocity, velocity, b.velocity),
                (Quantity::Acceleration, acceleration, b.acceleration),
                (Quantity::Jerk, jerk, b.jerk),
            ] {
                let size = libm::fabs(value);
                // without the product as long as it does not matter
                if size > limit && size > limit * (1.0 + ROUNDING) {
                    return fail(quantity, value, limit);
                }
            }
            *past = Past {
                position: *p,
                velocity,
                acceleration,
            };
        }
        self.past = next;
        Ok(())
    }
}

#[cfg(test)]
mod test {
    use super::*;

    const B: Bounds = Bounds {
        lower: -10.0,
        upper: 10.0,
        velocity: 50.0,
        acceleration: 450.0,
        jerk: 15_000.0,
    };
    const TS: f64 = 0.002;

    #[test]
    fn each_quantity_has_its_limit_on_both_sides() {
        for (position, quantity) in [
            (TS * 51.0, Quantity::Velocity),
            (TS * TS * 460.0, Quantity::Acceleration),
            (TS * TS * TS * 15_100.0, Quantity::Jerk),
        ] {
            for sign in [1.0, -1.0] {
                let mut gate = Gate::<1>::at_rest(&[0.0], TS);
                // the lower derivatives are unlimited, so that exactly one thing can break
                let mut b = Bounds {
                    jerk: 1e12,
                    acceleration: 1e12,
                    velocity: 1e12,
                    ..B
                };
                match quantity {
                    Quantity::Velocity => b.velocity = B.velocity,
                    Quantity::Acceleration => b.acceleration = B.acceleration,
                    _ => b.jerk = B.jerk,
                }
                let error = gate.pass(&[sign * position], &[b]).unwrap_err();
                assert_eq!((error.axis, error.quantity), (0, quantity));
                assert_eq!(gate, Gate::at_rest(&[0.0], TS), "nothing is remembered");
                assert_eq!(gate.pass(&[sign * position * 0.97], &[b]), Ok(()));
            }
        }
    }

    #[test]
    fn nan_does_not_pass() {
        let mut gate = Gate::<2>::at_rest(&[0.0; 2], TS);
        let error = gate.pass(&[0.0, f64::NAN], &[B; 2]).unwrap_err();
        assert_eq!((error.axis, error.cause()), (1, Cause::NotFinite));
    }

    #[test]
    fn outside_the_range_only_inward() {
        let free = Bounds {
            velocity: 1e9,
            acceleration: 1e12,
            jerk: 1e15,
            ..B
        };
        let mut gate = Gate::<1>::at_rest(&[10.5], TS);
        assert!(gate.pass(&[10.6], &[free]).is_err());
        assert!(gate.pass(&[10.4], &[free]).is_ok());
        assert!(gate.pass(&[9.0], &[free]).is_ok());
        assert!(gate.pass(&[10.1], &[free]).is_err());
    }
}
