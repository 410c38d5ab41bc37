//! The gate before the drives: every set-point is checked, whoever made it.
//!
//! The gate knows only the set-points themselves: velocity, acceleration and jerk are the
//! differences of what is really sent, so a mistake anywhere above cannot pass it.

use motion::Angle;
use motion::interpolator::Range;
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
            Quantity::MotorPosition | Quantity::JointPosition => Cause::PositionLimit,
            Quantity::Velocity => Cause::VelocityLimit,
            Quantity::Acceleration => Cause::AccelerationLimit,
            Quantity::Jerk => Cause::JerkLimit,
        }
    }
}

/// Set-points of a path are so far from it at most, in quanta of an [`Angle`]; a difference of order n is then off by up
/// to 2ⁿ times that. Over (2 ms)³ the third is 9e-3 rad/s³, of 15 000. Nothing else is rounded here.
const QUANTA: i64 = motion::interpolator::EVALUATION_QUANTA;

/// The bounds of one axis in quanta: of the position, and of the differences of first to third order over one servo step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Limits {
    lower: Angle,
    upper: Angle,
    differences: [i64; 3],
}

impl Limits {
    fn new(bounds: &Bounds, ts: f64) -> Self {
        let quanta = |limit: f64, order: u32| {
            Angle::bound(limit)
                .quanta()
                .saturating_add(QUANTA.wrapping_shl(order))
        };
        Self {
            lower: Angle::bound(bounds.lower),
            upper: Angle::bound(bounds.upper),
            differences: [
                quanta(bounds.velocity * ts, 1),
                quanta(bounds.acceleration * ts * ts, 2),
                quanta(bounds.jerk * ts * ts * ts, 3),
            ],
        }
    }
}

/// The last set-point, and how it differed from those before it, quanta.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Past {
    position: Angle,
    first: i64,
    second: i64,
}

/// Remembers the last set-point of every axis and refuses what breaks a limit.
///
/// It computes in integers: differences over servo steps are exact, and the limits become differences once, here.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gate<const N: usize> {
    past: [Past; N],
    limits: [Limits; N],
    /// Servo step, s.
    ts: f64,
}

impl<const N: usize> Gate<N> {
    /// At rest at these positions; `ts` is the servo step in s.
    #[must_use]
    pub fn at_rest(positions: &[Angle; N], bounds: &[Bounds; N], ts: f64) -> Self {
        Self {
            past: positions.map(|position| Past {
                position,
                first: 0,
                second: 0,
            }),
            limits: bounds.each_ref().map(|bounds| Limits::new(bounds, ts)),
            ts,
        }
    }

    /// At rest at these positions from now on, within the same limits.
    pub fn hold(&mut self, positions: &[Angle; N]) {
        for (past, position) in self.past.iter_mut().zip(positions) {
            *past = Past {
                position: *position,
                first: 0,
                second: 0,
            };
        }
    }

    /// Within these ranges of position from now on.
    pub fn set_ranges(&mut self, ranges: &[Range; N]) {
        for (limits, (lower, upper)) in self.limits.iter_mut().zip(ranges) {
            (limits.lower, limits.upper) = (*lower, *upper);
        }
    }

    /// The last set-points that passed.
    #[must_use]
    pub fn positions(&self) -> [Angle; N] {
        self.past.map(|past| past.position)
    }

    /// The origin of one axis has moved: its positions shift by so many quanta, nothing else changes.
    pub fn shift(&mut self, axis: usize, by: i64) {
        if let Some(past) = self.past.get_mut(axis) {
            past.position = past.position.plus(by);
        }
    }

    /// Check the set-points of one servo step; they become the past only if all are kept.
    ///
    /// # Errors
    /// The first violation, in the order of the axes; nothing is remembered then.
    // a function of its own, so that what it costs can be counted
    #[inline(never)]
    pub fn pass(&mut self, positions: &[Angle; N]) -> Result<(), Violation> {
        let mut next = self.past;
        for (axis, ((p, limits), past)) in
            (0..N).zip(positions.iter().zip(&self.limits).zip(&mut next))
        {
            let Limits {
                lower,
                upper,
                differences: [velocity, acceleration, jerk],
            } = *limits;
            // Outside its range an axis may only come back.
            let outside = (*p < lower && *p < past.position) || (*p > upper && *p > past.position);
            let first = p.since(past.position);
            let second = first.saturating_sub(past.first);
            let third = second.saturating_sub(past.second);
            if outside
                || first.saturating_abs() > velocity
                || second.saturating_abs() > acceleration
                || third.saturating_abs() > jerk
            {
                return Err(self.violation(axis, *p, [first, second, third], limits));
            }
            *past = Past {
                position: *p,
                first,
                second,
            };
        }
        self.past = next;
        Ok(())
    }

    /// What is wrong with a set-point that breaks a limit, in rad and s.
    #[cold]
    fn violation(
        &self,
        axis: usize,
        position: Angle,
        differences: [i64; 3],
        limits: &Limits,
    ) -> Violation {
        let rates = [Quantity::Velocity, Quantity::Acceleration, Quantity::Jerk];
        let mut per = 1.0;
        let all = rates.into_iter().zip(differences).zip(limits.differences);
        let past = self.past.get(axis).map_or(position, |past| past.position);
        let outside = (position < limits.lower && position < past)
            || (position > limits.upper && position > past);
        if !outside {
            for (order, ((quantity, difference), limit)) in (1..).zip(all) {
                per /= self.ts;
                if difference.saturating_abs() > limit {
                    let limit = limit.saturating_sub(QUANTA.wrapping_shl(order));
                    return Violation {
                        axis,
                        quantity,
                        value: Angle::of_quanta(difference).to_f64() * per,
                        limit: Angle::of_quanta(limit).to_f64() * per,
                    };
                }
            }
        }
        let limit = if position < limits.lower {
            limits.lower
        } else {
            limits.upper
        };
        Violation {
            axis,
            quantity: Quantity::MotorPosition,
            value: position.to_f64(),
            limit: limit.to_f64(),
        }
    }
}

#[cfg(test)]
mod test {
    use super::*;
    use proptest::prelude::*;

    const B: Bounds = Bounds {
        lower: -10.0,
        upper: 10.0,
        velocity: 50.0,
        acceleration: 450.0,
        jerk: 15_000.0,
    };
    /// Nothing but the range is limited.
    const FREE: Bounds = Bounds {
        jerk: 1e12,
        acceleration: 1e12,
        velocity: 1e9,
        ..B
    };
    const TS: f64 = 0.002;

    fn gate(at: f64, bounds: Bounds) -> Gate<1> {
        Gate::at_rest(&[Angle::bound(at)], &[bounds], TS)
    }

    #[test]
    fn each_quantity_has_its_limit_on_both_sides() {
        for (unit, most, quantity) in [
            (TS, B.velocity, Quantity::Velocity),
            (TS * TS, B.acceleration, Quantity::Acceleration),
            (TS * TS * TS, B.jerk, Quantity::Jerk),
        ] {
            for sign in [1.0, -1.0] {
                // the others are unlimited, so that exactly one thing can break
                let mut b = FREE;
                match quantity {
                    Quantity::Velocity => b.velocity = most,
                    Quantity::Acceleration => b.acceleration = most,
                    _ => b.jerk = most,
                }
                let mut gate = gate(0.0, b);
                let at = |value: f64| [Angle::bound(sign * unit * value)];
                let before = gate;
                let error = gate.pass(&at(1.01 * most)).unwrap_err();
                assert_eq!((error.axis, error.quantity), (0, quantity));
                assert!(
                    (error.value - sign * 1.01 * most).abs() < 1e-3 * most,
                    "{error:?}"
                );
                // half a quantum over the third power of the step
                assert!((error.limit - most).abs() < 1e-4, "{error:?}");
                assert_eq!(gate, before, "nothing is remembered");
                assert_eq!(gate.pass(&at(most)), Ok(()));
            }
        }
    }

    #[test]
    fn what_is_kept_is_the_limit_and_what_a_path_may_be_off() {
        for (order, unit, most) in [(1, TS, B.velocity), (3, TS * TS * TS, B.jerk)] {
            let b = if order == 1 {
                Bounds {
                    velocity: most,
                    ..FREE
                }
            } else {
                Bounds { jerk: most, ..FREE }
            };
            let last = Angle::bound(unit * most).plus(QUANTA << order);
            assert_eq!(gate(0.0, b).pass(&[last]), Ok(()));
            assert!(gate(0.0, b).pass(&[last.plus(1)]).is_err());
        }
    }

    #[test]
    fn outside_the_range_only_inward() {
        let mut gate = gate(10.5, FREE);
        let mut pass = |at| gate.pass(&[Angle::bound(at)]);
        let error = pass(10.6).unwrap_err();
        assert_eq!(error.cause(), Cause::PositionLimit);
        assert!((error.value - 10.6).abs() < 1e-12 && (error.limit - 10.0).abs() < 1e-12);
        assert!(pass(10.4).is_ok());
        assert!(pass(9.0).is_ok());
        assert!(pass(10.1).is_err());
        assert!(pass(-10.1).is_err());
    }

    #[test]
    fn the_ends_of_the_numbers_do_not_pass() {
        for end in [Angle::MIN, Angle::MAX] {
            assert!(gate(0.0, B).pass(&[end]).is_err());
            let unbounded = Bounds {
                lower: -f64::INFINITY,
                upper: f64::INFINITY,
                ..B
            };
            assert!(gate(0.0, unbounded).pass(&[end]).is_err());
        }
    }

    #[test]
    fn held_anew_it_knows_no_motion_but_its_limits() {
        let mut gate = gate(0.0, B);
        let step = Angle::bound(TS * TS * TS * B.jerk);
        for k in [1, 4, 10] {
            assert_eq!(gate.pass(&[Angle::of_quanta(k * step.quanta())]), Ok(()));
        }
        gate.hold(&[Angle::bound(2.0)]);
        assert!(
            gate.pass(&[Angle::bound(2.0).plus(2 * step.quanta())])
                .is_err()
        );
        assert_eq!(gate.pass(&[Angle::bound(2.0).plus(step.quanta())]), Ok(()));
    }

    #[test]
    fn an_origin_that_moves_is_no_motion() {
        let mut gate = gate(3.0, B);
        gate.shift(0, -Angle::bound(3.0).quanta());
        assert_eq!(gate.pass(&[Angle::ZERO]), Ok(()));
    }

    proptest! {
        /// The same by floats: what is clearly inside passes, what is clearly outside does not.
        #[test]
        fn integers_decide_as_floats_do(ways in prop::collection::vec(-0.11..0.11f64, 1..20)) {
            let b = Bounds { acceleration: 40_000.0, jerk: 3e7, ..B };
            let (mut gate, mut p, mut past) = (gate(0.0, b), 0.0, [0.0; 3]);
            for way in ways {
                let next = p + way;
                let v = way / TS;
                let a = (v - past[0]) / TS;
                let j = (a - past[1]) / TS;
                let share = [v / b.velocity, a / b.acceleration, j / b.jerk, next / 10.0];
                let most = share.iter().fold(0.0, |most: f64, x| if x.abs() > most { x.abs() } else { most });
                let passed = gate.pass(&[Angle::bound(next)]).is_ok();
                // quanta: 1e-11 rad of 0.1
                prop_assume!((most - 1.0).abs() > 1e-9);
                prop_assert_eq!(passed, most < 1.0, "{:?}", share);
                if passed {
                    (p, past) = (next, [v, a, j]);
                }
            }
        }
    }
}
