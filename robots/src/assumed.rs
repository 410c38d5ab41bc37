//! The numbers nobody has published: chosen by us, and shown as such.

use crate::planning::{CURVATURE_SHARE, VELOCITY_SHARE};
use crate::rnt::assumed as rnt;

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
pub const POLYCRANK_REGULATOR_BANDWIDTH: f64 = 40.0;
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
        item: "rnt: radius of the circle of the legs' feet in the base, at 90°, 210° and 330°",
        value: rnt::BASE_RADIUS_M,
        unit: "m",
        why: "a tripod for a workspace of about a metre",
    },
    Assumed {
        item: "rnt: radius of the circle of the legs' ends in the platform, at the same angles",
        value: rnt::PLATFORM_RADIUS_M,
        unit: "m",
        why: "smaller than the base's: no other assembly within the tilts",
    },
    Assumed {
        item: "rnt: lead of the ball screws of the legs",
        value: rnt::LEAD_M,
        unit: "m/turn",
        why: "a common lead; 0.48 m/s at the motors' greatest velocity",
    },
    Assumed {
        item: "rnt: shortest leg, a motor limit",
        value: rnt::LEG_SHORTEST_M,
        unit: "m",
        why: "most of the wanted reaches and tilts are inside",
    },
    Assumed {
        item: "rnt: longest leg, a motor limit",
        value: rnt::LEG_LONGEST_M,
        unit: "m",
        why: "a stroke of one metre",
    },
    Assumed {
        item: "rnt: length of a leg where homing ends, its motor at 0",
        value: rnt::LEG_AT_INDEX_M,
        unit: "m",
        why: "legs retract to a switch as a real one would: 22 mm before the central leg is pushed together",
    },
    Assumed {
        item: "rnt: greatest tilt of the central leg about y and about x, either way",
        value: rnt::TILT_DEGREES,
        unit: "°",
        why: "a universal joint",
    },
    Assumed {
        item: "rnt: least reach of the central leg",
        value: rnt::REACH_LEAST_M,
        unit: "m",
        why: "its sliding guide, pushed together, with the legs short of their limit",
    },
    Assumed {
        item: "rnt: greatest reach of the central leg",
        value: rnt::REACH_MOST_M,
        unit: "m",
        why: "its sliding guide, pulled out",
    },
    Assumed {
        item: "rnt: the wrist's centre below the platform",
        value: rnt::WRIST_CENTRE_M,
        unit: "m",
        why: "room for the drives of the wrist",
    },
    Assumed {
        item: "rnt: turn of the wrist's base about the platform's y",
        value: rnt::WRIST_MOUNT_RAD,
        unit: "rad",
        why: "a vertical spindle stands 60° from the wrist's first axis at no tilt: in the middle between the singularity at 0° and the limit at 110°",
    },
    Assumed {
        item: "rnt: harmonic drives of the wrist",
        value: rnt::WRIST_RATIO,
        unit: "1",
        why: "a common ratio",
    },
    Assumed {
        item: "rnt: greatest angle of wrist 1, either way",
        value: rnt::WRIST_1_DEGREES,
        unit: "°",
        why: "less than a turn",
    },
    Assumed {
        item: "rnt: greatest angle of wrist 2, either way",
        value: rnt::WRIST_2_DEGREES,
        unit: "°",
        why: "past the horizontal, short of the links' meeting",
    },
    Assumed {
        item: "rnt: greatest angle of wrist 3, either way",
        value: rnt::WRIST_3_DEGREES,
        unit: "°",
        why: "nearly two turns of cable",
    },
    Assumed {
        item: "rnt: where homing of a wrist's axis ends, from its lower limit",
        value: rnt::WRIST_INDEX_DEGREES,
        unit: "°",
        why: "room for the switch",
    },
    Assumed {
        item: "rnt: tip of the spindle from the flange, along its approach",
        value: rnt::SPINDLE_M,
        unit: "m",
        why: "a milling spindle",
    },
    Assumed {
        item: "rnt: encoder increments of a motor",
        value: 8000.0,
        unit: "1/turn",
        why: "1.25 µm of a leg",
    },
    Assumed {
        item: "rnt: greatest velocity of a motor",
        value: rnt::MOTOR_VELOCITY,
        unit: "rad/s",
        why: "2865 turns a minute: a common servo motor",
    },
    Assumed {
        item: "rnt: acceleration of a leg, planning; the wrist's motors have the same in rad/s²",
        value: rnt::ACCELERATION_PLANNING_M_S2,
        unit: "m/s²",
        why: "twice what the flange is asked for",
    },
    Assumed {
        item: "rnt: acceleration of a leg, hard limit; the wrist's motors have the same in rad/s²",
        value: rnt::ACCELERATION_HARD_M_S2,
        unit: "m/s²",
        why: "2.5 times the plan, as much as the node keeps for a stop on the path; takes a third of the motors' current",
    },
    Assumed {
        item: "rnt: jerk of a leg, planning; the wrist's motors have the same in rad/s³",
        value: rnt::JERK_PLANNING_M_S3,
        unit: "m/s³",
        why: "full planning acceleration in 50 ms",
    },
    Assumed {
        item: "rnt: jerk of a leg, hard limit; the wrist's motors have the same in rad/s³",
        value: rnt::JERK_HARD_M_S3,
        unit: "m/s³",
        why: "full acceleration in 5 ms, ten times a current loop; less would leave no room to stop within the velocity limit in force",
    },
    Assumed {
        item: "rnt: velocity of the tilts, planning",
        value: rnt::TILT_VELOCITY,
        unit: "rad/s",
        why: "0.4 m/s of a leg",
    },
    Assumed {
        item: "rnt: acceleration of the tilts, planning",
        value: rnt::TILT_ACCELERATION,
        unit: "rad/s²",
        why: "2 m/s² of a leg",
    },
    Assumed {
        item: "rnt: velocity of the reach, planning",
        value: rnt::REACH_VELOCITY,
        unit: "m/s",
        why: "that of the legs",
    },
    Assumed {
        item: "rnt: acceleration of the reach, planning",
        value: rnt::REACH_ACCELERATION,
        unit: "m/s²",
        why: "that of the legs",
    },
    Assumed {
        item: "rnt: velocity of the wrist's joints, planning",
        value: rnt::WRIST_VELOCITY,
        unit: "rad/s",
        why: "short of the motors' 3 rad/s",
    },
    Assumed {
        item: "rnt: acceleration of the wrist's joints, planning",
        value: rnt::WRIST_ACCELERATION,
        unit: "rad/s²",
        why: "short of the motors' 12.6 rad/s²",
    },
    Assumed {
        item: "rnt: torque constant of the motors",
        value: rnt::TORQUE_CONSTANT,
        unit: "N·m/A",
        why: "a servo motor of some 500 W",
    },
    Assumed {
        item: "rnt: inertia of a rotor",
        value: rnt::ROTOR_KG_M2,
        unit: "kg·m²",
        why: "the same motor",
    },
    Assumed {
        item: "rnt: load of a leg's motor, at its shaft",
        value: rnt::LEG_LOAD_KG_M2,
        unit: "kg·m²",
        why: "47 kg of platform, tube, half the legs, wrist and spindle: 4e-5 where all legs lift, 2.7e-4 and more where one turns the platform",
    },
    Assumed {
        item: "rnt: load of the motors of wrist 1 and 2, at their shafts",
        value: rnt::WRIST_LOAD_KG_M2,
        unit: "kg·m²",
        why: "a spindle of 12 kg at 0.15 m, by the square of the ratio",
    },
    Assumed {
        item: "rnt: load of the motor of wrist 3, at its shaft",
        value: rnt::SPINDLE_LOAD_KG_M2,
        unit: "kg·m²",
        why: "the spindle about its own axis",
    },
    Assumed {
        item: "rnt: viscous friction of a motor",
        value: rnt::VISCOUS,
        unit: "N·m·s/rad",
        why: "a fifth of the current at full speed",
    },
    Assumed {
        item: "rnt: Coulomb friction of a motor",
        value: rnt::COULOMB_NM,
        unit: "N·m",
        why: "a preloaded screw or gear",
    },
    Assumed {
        item: "rnt: greatest current of a motor",
        value: rnt::CURRENT_MA,
        unit: "mA",
        why: "3 N·m: a third more than the hard limits, friction and 30 kg on one screw take together",
    },
    Assumed {
        item: "rnt: velocity off the switch and on to the index",
        value: rnt::HOMING_FINE,
        unit: "rad/s",
        why: "2 increments a step",
    },
    Assumed {
        item: "rnt: ω of the regulators' two fast poles",
        value: rnt::REGULATOR_RAD_S,
        unit: "rad/s",
        why: "the delay of 1.5 steps of 1 ms costs 13° of phase",
    },
    Assumed {
        item: "rnt: pole of the regulators' filter",
        value: rnt::REGULATOR_FILTER,
        unit: "1",
        why: "0.8 ms, far beyond ω",
    },
    Assumed {
        item: "rnt: x of the base in the world",
        value: 0.0,
        unit: "m",
        why: "the middle of the work area lies in the world's plane z = 0, away from the other robots",
    },
    Assumed {
        item: "rnt: y of the base in the world",
        value: -3.0,
        unit: "m",
        why: "the middle of the work area lies in the world's plane z = 0, away from the other robots",
    },
    Assumed {
        item: "rnt: z of the base in the world",
        value: 1.30,
        unit: "m",
        why: "the middle of the work area lies in the world's plane z = 0, away from the other robots",
    },
    Assumed {
        item: "rnt: coarse velocity of homing, towards the switch",
        value: 5.0,
        unit: "rad/s",
        why: "8 mm/s of a leg",
    },
    Assumed {
        item: "rnt: greatest velocity of the flange, planning",
        value: 0.2,
        unit: "m/s",
        why: "engraving; far below what the legs can",
    },
    Assumed {
        item: "rnt: greatest acceleration of the flange, planning",
        value: 1.0,
        unit: "m/s²",
        why: "half of what the legs are planned with",
    },
    Assumed {
        item: "rnt: the work area's surface below the base",
        value: 1.30,
        unit: "m",
        why: "the reaches over it are in the middle of their range",
    },
    Assumed {
        item: "rnt: size of the work area along x",
        value: 0.8,
        unit: "m",
        why: "what a vertical spindle reaches far from limits and singularities",
    },
    Assumed {
        item: "rnt: size of the work area along y",
        value: 0.6,
        unit: "m",
        why: "what a vertical spindle reaches far from limits and singularities",
    },
    Assumed {
        item: "rnt: clearance above the work area",
        value: 0.10,
        unit: "m",
        why: "room for moves between cuts",
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
        item: "conveyor: gain of the regulator for a current",
        value: 120.0,
        unit: "mA",
        why: "of the order of the arms' 100 to 200",
    },
    Assumed {
        item: "conveyor and grippers: following error that trips",
        value: 1000.0,
        unit: "increments",
        why: "as on the arms",
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
        item: "polycrank: current at the peak torques 200, 120, 50, 40, 20, 5, 2 N·m; velocities 6.3, 9, 12 rad/s, inertias and friction",
        value: 20.0,
        unit: "A",
        why: "each torque holds 2 kg in the worst posture and gives its axis the planning acceleration besides",
    },
    Assumed {
        item: "IRp-6 track: inertia of reducer and pinion, at the motor's shaft",
        value: 5.6e-5,
        unit: "kg·m²",
        why: "with the links' masses it makes up the load the original gains are stable with",
    },
    Assumed {
        item: "IRp-6 V: inertia of bevels and shaft, at the motor's shaft",
        value: 2.4e-5,
        unit: "kg·m²",
        why: "with the links' masses it makes up the load the original gains are stable with",
    },
    Assumed {
        item: "irp6-arm: motors, currents, gains and homing of the postument",
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
