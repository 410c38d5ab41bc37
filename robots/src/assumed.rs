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
/// ASSUMED: irp6-arm: y of the base in the world, m.
pub const ARM_BASE_Y_M: f64 = -2.0;
/// ASSUMED: conveyor: y of the base in the world, m.
pub const CONVEYOR_BASE_Y_M: f64 = 1.0;
/// ASSUMED: conveyor: greatest current, and where the drive trips, mA.
pub const CONVEYOR_CURRENT_MA: f64 = 10_000.0;
/// ASSUMED: gripper motor velocity, planning, rad/s.
pub const GRIPPER_VELOCITY_PLANNING: f64 = 1_000.0;
/// ASSUMED: gripper motor acceleration, hard limit, rad/s².
pub const GRIPPER_ACCELERATION_HARD: f64 = 9_000.0;
/// ASSUMED: gripper motor acceleration, planning, rad/s².
pub const GRIPPER_ACCELERATION_PLANNING: f64 = 1_500.0;
/// ASSUMED: gripper motor jerk, hard limit, rad/s³.
pub const GRIPPER_JERK_HARD: f64 = 600_000.0;
/// ASSUMED: gripper motor jerk, planning, rad/s³.
pub const GRIPPER_JERK_PLANNING: f64 = 15_000.0;
/// ASSUMED: gripper: homing velocity off the switch, rad/s.
pub const GRIPPER_FINE_VELOCITY: f64 = 25.0;
/// ASSUMED: polycrank: y of the base in the world, m.
pub const POLYCRANK_BASE_Y_M: f64 = 4.5;
/// ASSUMED: polycrank motor acceleration, hard limit, rad/s².
pub const POLYCRANK_ACCELERATION_HARD: f64 = 60.0;
/// ASSUMED: polycrank motor acceleration, planning, rad/s².
pub const POLYCRANK_ACCELERATION_PLANNING: f64 = 20.0;
/// ASSUMED: polycrank motor jerk, hard limit, rad/s³.
pub const POLYCRANK_JERK_HARD: f64 = 20_000.0;
/// ASSUMED: polycrank motor jerk, planning, rad/s³.
pub const POLYCRANK_JERK_PLANNING: f64 = 400.0;
/// ASSUMED: polycrank: double pole of the regulator, rad/s.
pub const POLYCRANK_REGULATOR_BANDWIDTH: f64 = 70.0;
/// ASSUMED: polycrank, encoder increments a turn (4000 would be 1.4 mm at full reach).
pub const POLYCRANK_INCREMENTS: u32 = 65_536;

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
    Assumed {
        item: "irp6-arm: y of the base in the world",
        value: ARM_BASE_Y_M,
        unit: "m",
        why: "as far to one side of the track as the postument is to the other",
    },
    Assumed {
        item: "conveyor: y of the base in the world",
        value: CONVEYOR_BASE_Y_M,
        unit: "m",
        why: "between the track's arm and the postument",
    },
    Assumed {
        item: "conveyor: greatest current, and where the drive trips",
        value: CONVEYOR_CURRENT_MA,
        unit: "mA",
        why: "MRROC++ has 200 mA there and does not use it; its motor is that of the arms",
    },
    Assumed {
        item: "gripper motor velocity, planning",
        value: GRIPPER_VELOCITY_PLANNING,
        unit: "rad/s",
        why: "a tenth of the hard limit; the jaws open in 3 s, MRROC++ takes 2 s",
    },
    Assumed {
        item: "gripper motor acceleration, hard limit",
        value: GRIPPER_ACCELERATION_HARD,
        unit: "rad/s²",
        why: "six sevenths of what the clamped current gives the motor",
    },
    Assumed {
        item: "gripper motor acceleration, planning",
        value: GRIPPER_ACCELERATION_PLANNING,
        unit: "rad/s²",
        why: "a sixth of the hard limit, as on the arms",
    },
    Assumed {
        item: "gripper motor jerk, hard limit",
        value: GRIPPER_JERK_HARD,
        unit: "rad/s³",
        why: "40 times the planning jerk, as on the arms",
    },
    Assumed {
        item: "gripper motor jerk, planning",
        value: GRIPPER_JERK_PLANNING,
        unit: "rad/s³",
        why: "full planning acceleration in 0.1 s, as on the arms",
    },
    Assumed {
        item: "gripper: homing velocity off the switch",
        value: GRIPPER_FINE_VELOCITY,
        unit: "rad/s",
        why: "MRROC++ has 100 rad/s; the drive is told to latch the index by two requests, which must be done within a turn",
    },
    Assumed {
        item: "polycrank: y of the base in the world",
        value: POLYCRANK_BASE_Y_M,
        unit: "m",
        why: "beyond the postument, out of reach of the others",
    },
    Assumed {
        item: "polycrank motor acceleration, hard limit",
        value: POLYCRANK_ACCELERATION_HARD,
        unit: "rad/s²",
        why: "what the peak torques give the mean inertias",
    },
    Assumed {
        item: "polycrank motor acceleration, planning",
        value: POLYCRANK_ACCELERATION_PLANNING,
        unit: "rad/s²",
        why: "a third of the hard limit",
    },
    Assumed {
        item: "polycrank motor jerk, hard limit",
        value: POLYCRANK_JERK_HARD,
        unit: "rad/s³",
        why: "full acceleration in 3 ms: without gears torque comes as fast as current",
    },
    Assumed {
        item: "polycrank motor jerk, planning",
        value: POLYCRANK_JERK_PLANNING,
        unit: "rad/s³",
        why: "full planning acceleration in 50 ms",
    },
    Assumed {
        item: "polycrank: double pole of the regulator",
        value: POLYCRANK_REGULATOR_BANDWIDTH,
        unit: "rad/s",
        why: "step, filter and current loop leave the double pole some 40° of phase",
    },
    Assumed {
        item: "polycrank: encoder increments a turn",
        value: POLYCRANK_INCREMENTS as f64,
        unit: "1",
        why: "0.1 mm at full reach",
    },
    Assumed {
        item: "polycrank: torque constant; with it peak torques 80, 50, 30, 20, 10, 5, 2 N·m, velocities 6.3, 9, 12 rad/s, inertias and friction",
        value: 2.0,
        unit: "N·m/A",
        why: "plausible direct drives; nothing about them is published",
    },
    Assumed {
        item: "irp6-arm: currents, gains and homing of the postument",
        value: 1.0,
        unit: "1",
        why: "the same drives; only its calibration is published",
    },
    Assumed {
        item: "conveyor and grippers: inertia of the load and dry friction",
        value: 1.0,
        unit: "1",
        why: "of the order of the rotor's and of a small part of the greatest torque",
    },
];
