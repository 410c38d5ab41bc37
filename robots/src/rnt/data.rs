//! The RNT's numbers. Nobody published any: every one is ASSUMED, and listed in [`crate::ASSUMED`].

use core::f64::consts::TAU;

use super::assumed;
use crate::description::{
    AxisDescription, AxisHoming, CurrentRegulator, Gearing, HomingSequence, JointKind, Motor,
    MotorLimits, PwmRegulator, Range, Reference, RobotDescription,
};
use crate::planning::VELOCITY_SHARE;
use crate::sources::Sources;

/// Names of the axes. The first three motors drive legs, the first three joints are what the platform
/// does: motor k does not belong to joint k, so the names have both.
pub(super) const NAMES: [&str; 6] = [
    "tilt y/leg 1",
    "tilt x/leg 2",
    "reach/leg 3",
    "wrist 1",
    "wrist 2",
    "wrist 3",
];

/// Motor angle for a lengthening of a leg, rad/m.
pub(super) const LEG_RAD_PER_M: f64 = TAU / assumed::LEAD_M;
/// Length of every leg at no tilt and a reach of 1.1 m: √(1.1² + (0.40 − 0.15)²).
const HOME_LEG_M: f64 = 1.128_051_417_267_847_7;

const LEG_LIMITS: MotorLimits = MotorLimits {
    velocity: assumed::MOTOR_VELOCITY,
    acceleration: assumed::ACCELERATION_HARD_M_S2 * LEG_RAD_PER_M,
    jerk: assumed::JERK_HARD_M_S3 * LEG_RAD_PER_M,
};

const LEG_PLANNING: MotorLimits = MotorLimits {
    velocity: VELOCITY_SHARE * assumed::MOTOR_VELOCITY,
    acceleration: assumed::ACCELERATION_PLANNING_M_S2 * LEG_RAD_PER_M,
    jerk: assumed::JERK_PLANNING_M_S3 * LEG_RAD_PER_M,
};

const fn symmetric(degrees: f64) -> Range {
    Range {
        lower: -degrees.to_radians(),
        upper: degrees.to_radians(),
    }
}

const fn motor(load_kg_m2: f64) -> Motor {
    Motor {
        torque_constant_nm_a: assumed::TORQUE_CONSTANT,
        rotor_kg_m2: assumed::ROTOR_KG_M2,
        gear_kg_m2: 0.0,
        load_kg_m2,
        viscous_nms_rad: assumed::VISCOUS,
        coulomb_nm: assumed::COULOMB_NM,
    }
}

/// The regulator of the original's form whose closed loop has the poles −ω/8, −ω, −ω for the rigid motor.
///
/// With i = K·(s + z1)(s + z2)/s·E and J·s²·E' = Kt·i, the characteristic polynomial
/// s³ + k·s² + k·(z1 + z2)·s + k·z1·z2, k = K·Kt/J, is (s + ω/8)(s + ω)² for
///
/// ```text
///   k = 17/8·ω      z1 + z2 = 10/17·ω      z1·z2 = 1/17·ω²
/// ```
///
/// so z1, z2 = (5 ∓ √8)/17·ω. Each zero becomes e^(−zT) in z, a filter 1/(1 + sτ) the pole a, and the
/// gain is that of the differences: b0·(1 + ε)·g = K·(1 − a)/T, with g the current of a unit of u, A, times
/// the increments of a rad.
///
/// ε = tanh(z1·T/2), from (1 − ε)/(1 + ε) = e^(−z1·T), is z1·T/2 less 3e-7 here, and b1/b0 = e^(−z2·T)
/// is given by its value, since constants have no functions: tests recompute both.
const fn pwm(inertia_kg_m2: f64) -> PwmRegulator {
    const STEP_S: f64 = 1e-3;
    const OMEGA: f64 = assumed::REGULATOR_RAD_S;
    /// (5 − √8)/17.
    const SLOW: f64 = 0.127_739_580_897_282_93;
    let epsilon = 0.5 * SLOW * OMEGA * STEP_S;
    let a = assumed::REGULATOR_FILTER;
    let gain = 2.125 * OMEGA * inertia_kg_m2 / assumed::TORQUE_CONSTANT;
    let per_unit = 1e-3 * GAIN_MA * INCREMENTS / TAU;
    let b0 = gain * (1.0 - a) / (STEP_S * (1.0 + epsilon) * per_unit);
    PwmRegulator {
        epsilon,
        a,
        b0,
        b1: b0 * FAST_POLE,
        limit: 190.0,
    }
}

/// e^(−(5 + √8)/17·ω·T) for ω = 150 rad/s and T = 1 ms.
const FAST_POLE: f64 = 0.933_257_283_302_166_4;
/// As in the description, which counts them.
const INCREMENTS: f64 = 8000.0;
/// The greatest u is the greatest current.
const GAIN_MA: f64 = assumed::CURRENT_MA / 190.0;

/// What all axes have in common; the constructors below set the rest.
const fn axis(name: &'static str, load_kg_m2: f64) -> AxisDescription {
    AxisDescription {
        name,
        kind: JointKind::Revolute,
        reference: Reference::Joint,
        gearing: Gearing::Linear {
            ratio: assumed::WRIST_RATIO,
        },
        synchro_motor_position: 0.0,
        increments_per_turn: assumed::INCREMENTS_PER_TURN,
        motor_position: Range {
            lower: 0.0,
            upper: 0.0,
        },
        joint_position: Range {
            lower: 0.0,
            upper: 0.0,
        },
        hard_limits: LEG_LIMITS,
        planning_limits: LEG_PLANNING,
        joint_velocity: assumed::WRIST_VELOCITY,
        joint_acceleration: assumed::WRIST_ACCELERATION,
        // a fifth above what the regulator may ask for
        overcurrent_ma: 30_000,
        // 382 a step at the greatest velocity
        max_increments_per_step: 1000,
        // 1.25 mm of a leg, 0.45° of the wrist
        following_error_increments: 1000,
        motor: motor(load_kg_m2),
        homing: AxisHoming::Switch {
            coarse_velocity: -5.0,
            fine_velocity: assumed::HOMING_FINE,
        },
        pwm_regulator: pwm(assumed::ROTOR_KG_M2 + load_kg_m2),
        current_regulator: CurrentRegulator {
            gain_ma: GAIN_MA,
            limit_ma: assumed::CURRENT_MA,
        },
    }
}

const fn leg(
    name: &'static str,
    kind: JointKind,
    joint_position: Range,
    joint_velocity: f64,
    joint_acceleration: f64,
) -> AxisDescription {
    AxisDescription {
        kind,
        reference: Reference::Leg {
            reference_length_m: HOME_LEG_M,
        },
        gearing: Gearing::Linear {
            ratio: LEG_RAD_PER_M,
        },
        synchro_motor_position: (HOME_LEG_M - assumed::LEG_AT_INDEX_M) * LEG_RAD_PER_M,
        motor_position: Range {
            lower: (assumed::LEG_SHORTEST_M - assumed::LEG_AT_INDEX_M) * LEG_RAD_PER_M,
            upper: (assumed::LEG_LONGEST_M - assumed::LEG_AT_INDEX_M) * LEG_RAD_PER_M,
        },
        joint_position,
        joint_velocity,
        joint_acceleration,
        ..axis(name, assumed::LEG_LOAD_KG_M2)
    }
}

const fn tilt(name: &'static str) -> AxisDescription {
    leg(
        name,
        JointKind::Revolute,
        symmetric(assumed::TILT_DEGREES),
        assumed::TILT_VELOCITY,
        assumed::TILT_ACCELERATION,
    )
}

const fn wrist(name: &'static str, most_degrees: f64, load_kg_m2: f64) -> AxisDescription {
    let joint_position = symmetric(most_degrees);
    let at_index = joint_position.lower + assumed::WRIST_INDEX_DEGREES.to_radians();
    AxisDescription {
        synchro_motor_position: -at_index * assumed::WRIST_RATIO,
        motor_position: Range {
            lower: (joint_position.lower - at_index) * assumed::WRIST_RATIO,
            upper: (joint_position.upper - at_index) * assumed::WRIST_RATIO,
        },
        joint_position,
        ..axis(name, load_kg_m2)
    }
}

pub(super) static DESCRIPTION: RobotDescription<6> = {
    let [tilt_y, tilt_x, reach, first, second, third] = NAMES;
    RobotDescription {
        name: "rnt",
        long_name: "RNT serial-parallel robot (dimensions assumed)",
        sources: Sources::ASSUMED,
        servo_step_us: 1000,
        // 20 ms, as for the other robots: what the buses and the ECP do in a macrostep costs the same, and
        // at 0.2 m/s knots are 4 mm apart
        macrostep: 20,
        axes: [
            tilt(tilt_y),
            tilt(tilt_x),
            leg(
                reach,
                JointKind::Prismatic,
                Range {
                    lower: assumed::REACH_LEAST_M,
                    upper: assumed::REACH_MOST_M,
                },
                assumed::REACH_VELOCITY,
                assumed::REACH_ACCELERATION,
            ),
            wrist(first, assumed::WRIST_1_DEGREES, assumed::WRIST_LOAD_KG_M2),
            wrist(second, assumed::WRIST_2_DEGREES, assumed::WRIST_LOAD_KG_M2),
            wrist(third, assumed::WRIST_3_DEGREES, assumed::SPINDLE_LOAD_KG_M2),
        ],
        homing: HomingSequence {
            order: [0, 1, 2, 3, 4, 5],
            ramp_steps: 20,
            stop_steps: 500,
            settle_steps: 50,
            debounce_steps: 6,
        },
        tool_offset_m: [0.0, 0.0, assumed::SPINDLE_M],
        base_position_m: assumed::BASE_POSITION_M,
        cartesian_velocity: 0.2,
        cartesian_acceleration: 1.0,
    }
};
