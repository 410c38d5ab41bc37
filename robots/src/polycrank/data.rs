//! The numbers of Polycrank. Geometry: mzbikows/graspit, `Polycrank.xml` and `PolycrankGripper.xml`;
//! everything else is ASSUMED, see [`crate::ASSUMED`]: the MRROC++ code of this robot is a stub.

use crate::assumed::{
    POLYCRANK_ACCELERATION_HARD, POLYCRANK_ACCELERATION_PLANNING, POLYCRANK_BASE_Y_M,
    POLYCRANK_INCREMENTS, POLYCRANK_JERK_HARD, POLYCRANK_JERK_PLANNING,
    POLYCRANK_REGULATOR_BANDWIDTH,
};
use crate::description::{
    AxisDescription, AxisHoming, CurrentRegulator, Gearing, HomingSequence, JointKind, Motor,
    MotorLimits, PwmRegulator, Range, Reference, RobotDescription,
};
use crate::sources::{Source, Sources};

/// a1, a2, a4, a5 of the module's page, m.
pub(super) const CRANKS_M: [f64; 4] = [-0.299, 0.180, 0.151, 0.151];
/// H: height of axis 4 above the floor, m: the column and d1, d2, d3.
pub(super) const AXIS4_HEIGHT_M: f64 = 0.925 + 0.220 + 0.152 + 0.335;
/// D: d4 + d5 + d6, m.
pub(super) const SIDE_M: f64 = 0.120 + 0.116 + 0.060;
/// d7, m.
pub(super) const FLANGE_M: f64 = 0.043;

/// Units of u at which the regulator saturates, as in MRROC++.
const SATURATION: f64 = 190.0;

/// What differs between the axes; all of it ASSUMED. Loads are between the inertia an axis has
/// with the others held and the much smaller one it has with them free, so that loops of single axes are
/// stable; peak torques do the planning accelerations with the arm stretched.
struct Axis {
    name: &'static str,
    /// rad/s.
    velocity: f64,
    /// N·m.
    peak_torque: f64,
    /// kg·m².
    rotor: f64,
    /// kg·m².
    load: f64,
    /// N·m·s/rad.
    viscous: f64,
    /// N·m.
    coulomb: f64,
}

/// The current of every drive at its peak torque, A. ASSUMED: torque motors are wound for their drive.
const PEAK_A: f64 = 20.0;
/// Servo step, s.
const STEP_S: f64 = 0.002;

/// The MRROC++ difference equation as a proportional-derivative law with a double pole at the
/// bandwidth w on the inertia J: torque = J·(w²·e + 2w·ė), with a slow integral and a filter.
///
/// e[k] − e[k−1]·b1/b0 with (b0 − b1)/b1 = w·T/2; the filter's gain 1/(1 − a) is taken back in b0.
const fn regulator(inertia: f64, torque_constant: f64, gain_ma: f64) -> PwmRegulator {
    let (w, a) = (POLYCRANK_REGULATOR_BANDWIDTH, 0.4);
    let rad_per_increment = core::f64::consts::TAU / (POLYCRANK_INCREMENTS as f64);
    let ma_per_increment = 1000.0 * inertia / torque_constant * rad_per_increment;
    let scale = (1.0 - a) * ma_per_increment / gain_ma;
    PwmRegulator {
        epsilon: 0.005,
        a,
        b0: scale * (w * w + 2.0 * w / STEP_S),
        b1: scale * 2.0 * w / STEP_S,
        limit: SATURATION,
    }
}

const fn axis(data: &Axis) -> AxisDescription {
    let peak_ma = 1000.0 * PEAK_A;
    let torque_constant = data.peak_torque / PEAK_A;
    let gain_ma = peak_ma / SATURATION;
    AxisDescription {
        name: data.name,
        kind: JointKind::Revolute,
        reference: Reference::Joint,
        gearing: Gearing::Linear { ratio: 1.0 },
        synchro_motor_position: 0.0,
        increments_per_turn: POLYCRANK_INCREMENTS,
        motor_position: Range::UNLIMITED,
        joint_position: Range::UNLIMITED,
        hard_limits: MotorLimits {
            velocity: data.velocity,
            acceleration: POLYCRANK_ACCELERATION_HARD,
            jerk: POLYCRANK_JERK_HARD,
        },
        planning_limits: MotorLimits {
            velocity: 0.8 * data.velocity,
            acceleration: POLYCRANK_ACCELERATION_PLANNING,
            jerk: POLYCRANK_JERK_PLANNING,
        },
        joint_velocity: 0.8 * data.velocity,
        joint_acceleration: POLYCRANK_ACCELERATION_PLANNING,
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a whole positive number of mA"
        )]
        overcurrent_ma: peak_ma as u32,
        max_increments_per_step: 1000,
        // 0.15 rad at rest, 0.38 at full speed: single axes under cst lag behind without gears
        following_error_increments: 4000,
        motor: Motor {
            torque_constant_nm_a: torque_constant,
            rotor_kg_m2: data.rotor,
            gear_kg_m2: 0.0,
            load_kg_m2: data.load,
            viscous_nms_rad: data.viscous,
            coulomb_nm: data.coulomb,
        },
        homing: AxisHoming::Absolute,
        pwm_regulator: regulator(data.rotor + data.load, torque_constant, gain_ma),
        current_regulator: CurrentRegulator {
            gain_ma,
            limit_ma: peak_ma,
        },
    }
}

/// A vertical axis: name, peak torque, load.
const fn vertical(name: &'static str, peak_torque: f64, load: f64) -> AxisDescription {
    axis(&Axis {
        name,
        velocity: 6.3,
        peak_torque,
        rotor: 0.02,
        load,
        viscous: 0.05,
        coulomb: 0.1,
    })
}

/// A level axis: name, peak torque, load.
const fn level(name: &'static str, peak_torque: f64, load: f64) -> AxisDescription {
    axis(&Axis {
        name,
        velocity: 9.0,
        peak_torque,
        rotor: 0.003,
        load,
        viscous: 0.02,
        coulomb: 0.03,
    })
}

pub(super) static DESCRIPTION: RobotDescription<7> = RobotDescription {
    name: "polycrank",
    long_name: "Polycrank",
    sources: Sources {
        geometry: Source::Graspit,
        tool: Source::Graspit,
        ..Sources::ASSUMED
    },
    servo_step_us: 2000,
    macrostep: 10,
    axes: [
        vertical("crank 1", 200.0, 0.6),
        vertical("crank 2", 120.0, 0.2),
        vertical("crank 3", 50.0, 0.08),
        level("crank 4", 40.0, 0.08),
        level("crank 5", 20.0, 0.025),
        level("crank 6", 5.0, 0.0008),
        axis(&Axis {
            name: "roll",
            velocity: 12.0,
            peak_torque: 2.0,
            rotor: 0.001,
            load: 0.0002,
            viscous: 0.005,
            coulomb: 0.01,
        }),
    ],
    homing: HomingSequence {
        order: [0, 1, 2, 3, 4, 5, 6],
        ramp_steps: 10,
        stop_steps: 250,
        settle_steps: 25,
        debounce_steps: 3,
    },
    tool_offset_m: [0.0, 0.0, 0.048],
    base_position_m: [0.0, POLYCRANK_BASE_Y_M, 0.0],
    cartesian_velocity: 5.0,
    cartesian_acceleration: 5.0,
};
