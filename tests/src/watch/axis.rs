//! One axis as its set-points show it.

use super::{OPERATE, OPERATION_ENABLED};
use robots::description::AxisDescription;

/// What was broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// rad of the motor shaft.
    Position,
    /// rad/s
    Velocity,
    /// rad/s²
    Acceleration,
    /// rad/s³
    Jerk,
    /// No set-point in time for the SYNC.
    Missing,
}

/// A limit that was not kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Breach {
    /// When, ns.
    pub at_ns: u64,
    /// From 0.
    pub axis: usize,
    /// What.
    pub quantity: Quantity,
    /// What it was.
    pub value: f64,
    /// What it may be, the resolution of the set-points included.
    pub limit: f64,
}

/// The greatest absolute values, in multiples of the limits.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Worst {
    /// 1 is the limit.
    pub velocity: f64,
    /// 1 is the limit.
    pub acceleration: f64,
    /// 1 is the limit.
    pub jerk: f64,
}

/// The last set-points, newest last.
#[derive(Clone, Debug, Default)]
pub(super) struct History(Vec<i64>);

impl History {
    fn push(&mut self, units: i64) {
        if self.0.len() == 4 {
            self.0.remove(0);
        }
        self.0.push(units);
    }

    pub(super) fn last(&self) -> Option<i64> {
        self.0.last().copied()
    }

    /// The differences of first, second and third order, as far as they are known.
    fn differences(&self) -> [Option<i64>; 3] {
        match self.0[..] {
            [a, b, c, d] => [
                Some(d - c),
                Some(d - 2 * c + b),
                Some(d - 3 * c + 3 * b - a),
            ],
            [b, c, d] => [Some(d - c), Some(d - 2 * c + b), None],
            [c, d] => [Some(d - c), None, None],
            _ => [None; 3],
        }
    }
}

#[derive(Clone, Debug)]
pub(super) struct Axis {
    unit_rad: f64,
    ts: f64,
    lower: f64,
    upper: f64,
    limits: [f64; 3],
    pub(super) controlword: u16,
    pub(super) statusword: u16,
    pub(super) target: Option<i32>,
    pub(super) history: History,
    /// Position of motor angle 0, once homed.
    pub(super) zero: Option<i64>,
    counted_anew: bool,
    pub(super) worst: Worst,
}

impl Axis {
    pub(super) fn new(axis: &AxisDescription, factor: f64, ts: f64) -> Self {
        let hard = axis.hard_limits;
        Self {
            // a thousandth of an encoder increment (object 608F and 6091 of the drives)
            unit_rad: core::f64::consts::TAU / (f64::from(axis.increments_per_turn) * 1000.0),
            ts,
            lower: axis.motor_position.lower,
            upper: axis.motor_position.upper,
            limits: [hard.velocity * factor, hard.acceleration, hard.jerk],
            controlword: 0,
            statusword: 0,
            target: None,
            history: History::default(),
            zero: None,
            counted_anew: false,
            worst: Worst::default(),
        }
    }

    pub(super) const fn has_torque(&self) -> bool {
        self.controlword & OPERATE.0 == OPERATE.1
            && self.statusword & OPERATION_ENABLED.0 == OPERATION_ENABLED.1
    }

    pub(super) fn jerk_rad_s3(&self) -> f64 {
        self.worst.jerk * self.limits[2]
    }

    /// When an axis has found its index, at rest, it counts from there: once.
    pub(super) fn counts_anew(&mut self, units: i64) -> bool {
        let Some(last) = self.history.last() else {
            return false;
        };
        let [velocity, acceleration, _] = self.limits;
        let step_rad = rad(units - last, self.unit_rad).abs();
        let at_rest = self.history.differences()[0]
            .is_none_or(|d| rad(d, self.unit_rad).abs() / self.ts < acceleration * self.ts);
        if self.counted_anew || !at_rest || step_rad <= velocity * self.ts + self.unit_rad {
            return false;
        }
        self.counted_anew = true;
        self.history = History(vec![units; 4]);
        true
    }

    /// The next set-point; what it breaks.
    pub(super) fn push(&mut self, units: i64) -> Vec<(Quantity, f64, f64)> {
        self.history.push(units);
        let mut breaches = Vec::new();
        if let Some(zero) = self.zero {
            let position = rad(units - zero, self.unit_rad);
            let half = 0.5 * self.unit_rad;
            for (beyond, limit) in [
                (position < self.lower - half, self.lower),
                (position > self.upper + half, self.upper),
            ] {
                if beyond {
                    breaches.push((Quantity::Position, position, limit));
                }
            }
        }
        let (q, ts) = (self.unit_rad, self.ts);
        let [velocity, acceleration, jerk] = self.history.differences();
        let [v, a, j] = self.limits;
        let Worst {
            velocity: wv,
            acceleration: wa,
            jerk: wj,
        } = &mut self.worst;
        for (difference, quantity, per, limit, resolution, worst) in [
            (velocity, Quantity::Velocity, ts, v, 1.0, wv),
            (acceleration, Quantity::Acceleration, ts * ts, a, 2.0, wa),
            (jerk, Quantity::Jerk, ts * ts * ts, j, 4.0, wj),
        ] {
            let Some(difference) = difference else {
                continue;
            };
            let value = rad(difference, q).abs() / per;
            let may = limit + resolution * q / per;
            // the arithmetic here rounds too, by some 1e-16 of the value
            if value > may * (1.0 + 1e-12) {
                breaches.push((quantity, value, may));
            }
            if value / limit > *worst {
                *worst = value / limit;
            }
        }
        breaches
    }
}

#[expect(clippy::cast_precision_loss, reason = "positions fit 32 bits")]
fn rad(units: i64, unit_rad: f64) -> f64 {
    units as f64 * unit_rad
}
