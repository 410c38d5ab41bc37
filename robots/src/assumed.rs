//! The numbers nobody has published: chosen by us, and shown as such.

use crate::planning::{CURVATURE_SHARE, VELOCITY_SHARE};

/// One ASSUMED number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Assumed {
    /// What it is.
    pub item: &'static str,
    /// Its value.
    pub value: f64,
    /// The value's unit.
    pub unit: &'static str,
    /// Why this value.
    pub why: &'static str,
}

/// ASSUMED: greatest acceleration of a motor in any set-point, rad/s².
pub const MOTOR_ACCELERATION_HARD: f64 = 900.0;
/// ASSUMED: greatest jerk of a motor in any set-point, rad/s³.
pub const MOTOR_JERK_HARD: f64 = 60_000.0;
/// ASSUMED: greatest jerk of a motor in a plan, rad/s³.
pub const MOTOR_JERK_PLANNING: f64 = 1_500.0;

/// Every ASSUMED number of this crate, for the products that show them.
pub const ASSUMED: &[Assumed] = &[
    Assumed {
        item: "IRp-6 motor acceleration, hard limit",
        value: MOTOR_ACCELERATION_HARD,
        unit: "rad/s²",
        why: "six times the planning ceiling of MRROC++: a plan, the curvature of the screws and a stop on the path fit in",
    },
    Assumed {
        item: "IRp-6 motor jerk, hard limit",
        value: MOTOR_JERK_HARD,
        unit: "rad/s³",
        why: "40 times the planning jerk: full acceleration in 15 ms; a stop on the path may use it",
    },
    Assumed {
        item: "IRp-6 motor jerk, planning",
        value: MOTOR_JERK_PLANNING,
        unit: "rad/s³",
        why: "full planning acceleration in 0.1 s; MRROC++ limits no jerk",
    },
    Assumed {
        item: "share of the hard velocity limit a plan may use",
        value: VELOCITY_SHARE,
        unit: "1",
        why: "interpolation between knots must not touch the hard limit",
    },
    Assumed {
        item: "share of the hard acceleration limit left to the curvature of the screw triangles",
        value: CURVATURE_SHARE,
        unit: "1",
        why: "as much as for the plan; the rest is left to stopping on the path",
    },
    Assumed {
        item: "irp6-postument: tilt of the base",
        value: 0.0,
        unit: "rad",
        why: "MRROC++ has a calibrated tilt below 1.9°; the world here is upright",
    },
];
