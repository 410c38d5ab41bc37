//! What both IRp-6 share: lengths, gears, limits, regulators. Sources in [`crate::description`].

use core::f64::consts::{FRAC_PI_2, PI};

use crate::assumed::{MOTOR_ACCELERATION_HARD, MOTOR_JERK_HARD, MOTOR_JERK_PLANNING};
use crate::description::{
    AxisDescription, AxisHoming, CurrentRegulator, Gearing, JointKind, Motor, MotorLimits,
    PwmRegulator, Range, Reference,
};
use crate::screw::ScrewTriangle;

/// a2: shoulder to elbow, m. MRROC++ `kinematic_model_irp6ot_with_wrist`.
pub(crate) const LOWER_ARM_M: f64 = 0.455;
/// a3: elbow to wrist, m. Same source.
pub(crate) const UPPER_ARM_M: f64 = 0.67;
/// d5: wrist to flange, m. Same source.
pub(crate) const WRIST_M: f64 = 0.19;

/// 2π over the lead of 5 mm, rad/mm. Same source.
const SCREW_RAD_PER_MM: f64 = 2.0 * PI / 5.0;

/// Lower arm: crank 140 mm mounted 75° off the arm, motor pivot 157.5 mm behind and 183 mm below the
/// shoulder. Same source.
pub(crate) const LOWER_ARM_SCREW: ScrewTriangle = ScrewTriangle {
    sum_of_squares_mm2: 77_895.25,
    cosine_mm2: 60_902.55,
    sine_mm2: -29_346.68,
    reference_length_mm: 220.3374,
    rad_per_mm: SCREW_RAD_PER_MM,
};

/// Upper arm: the same triangle with the crank opposite to the arm. Same source.
pub(crate) const UPPER_ARM_SCREW: ScrewTriangle = ScrewTriangle {
    sum_of_squares_mm2: 77_895.25,
    cosine_mm2: -44_100.0,
    sine_mm2: -51_240.0,
    reference_length_mm: 183.8348,
    rad_per_mm: SCREW_RAD_PER_MM,
};

/// Track: ball screw of 8 mm lead, belt 2:1, doubled; 1570.796 rad/m. Same source.
const TRACK_RATIO: f64 = 1000.0 * 2.0 * 2.0 * PI / 8.0;
/// Column: harmonic drive.
const COLUMN_RATIO: f64 = -158.0;
/// T: harmonic drive; carries V's bevel with it.
const T_RATIO: f64 = -128.0;
/// V: harmonic drive and bevel 0.6.
const V_RATIO: f64 = -128.0 * 0.6;
/// N.
const N_RATIO: f64 = 288.8845;

const HARD: MotorLimits = MotorLimits {
    velocity: 250.0,
    acceleration: MOTOR_ACCELERATION_HARD,
    jerk: MOTOR_JERK_HARD,
};

const PLANNING: MotorLimits = MotorLimits {
    velocity: 200.0,
    acceleration: 150.0,
    jerk: MOTOR_JERK_PLANNING,
};

/// Towards the switch at −0.03 rad, off it at 0.007 rad a 2 ms step.
const HOMING: AxisHoming = AxisHoming::Switch {
    coarse_velocity: -15.0,
    fine_velocity: 3.5,
};
/// N: −0.05 and 0.05 rad a 2 ms step.
const HOMING_N: AxisHoming = AxisHoming::Switch {
    coarse_velocity: -25.0,
    fine_velocity: 25.0,
};

const fn regulator(epsilon: f64, a: f64, b0: f64, b1: f64) -> PwmRegulator {
    PwmRegulator {
        epsilon,
        a,
        b0,
        b1,
        limit: 190.0,
    }
}

const fn degrees(lower: f64, upper: f64) -> Range {
    Range {
        lower: lower.to_radians(),
        upper: upper.to_radians(),
    }
}

/// What differs between the two machines in one axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Machine {
    /// rad.
    pub(super) synchro_motor_position: f64,
    /// mA.
    pub(super) overcurrent_ma: u32,
    /// mA for a unit of u.
    pub(super) gain_ma: f64,
}

/// An axis with what all have in common filled in; the constructors below set the rest.
const fn axis(name: &'static str, machine: Machine, gearing: Gearing) -> AxisDescription {
    AxisDescription {
        name,
        kind: JointKind::Revolute,
        reference: Reference::Joint,
        gearing,
        synchro_motor_position: machine.synchro_motor_position,
        increments_per_turn: 4000,
        motor_position: Range {
            lower: 0.0,
            upper: 0.0,
        },
        joint_position: Range {
            lower: 0.0,
            upper: 0.0,
        },
        hard_limits: HARD,
        planning_limits: PLANNING,
        joint_velocity: 1.5,
        joint_acceleration: 7.0,
        overcurrent_ma: machine.overcurrent_ma,
        max_increments_per_step: 1000,
        following_error_increments: 1000,
        motor: ARM_MOTOR,
        homing: HOMING,
        pwm_regulator: regulator(0.0, 0.0, 0.0, 0.0),
        current_regulator: CurrentRegulator {
            gain_ma: machine.gain_ma,
            limit_ma: 0.0,
        },
    }
}

const fn current(machine: Machine, limit_ma: f64) -> CurrentRegulator {
    CurrentRegulator {
        gain_ma: machine.gain_ma,
        limit_ma,
    }
}

pub(super) const fn track(machine: Machine) -> AxisDescription {
    AxisDescription {
        kind: JointKind::Prismatic,
        // reducer and pinion
        motor: Motor {
            gear_kg_m2: 5.6e-5,
            ..ARM_MOTOR
        },
        motor_position: Range {
            lower: -200.0,
            upper: 1900.0,
        },
        joint_position: Range {
            lower: -0.125,
            upper: 1.21,
        },
        pwm_regulator: regulator(0.010, 0.412_429_378_531, 1.556_959_2, 1.502_861_4),
        // irp6_robot, irp6-ot-inside.launch at 126c5c7
        current_regulator: current(machine, 22_000.0),
        ..axis("track", machine, Gearing::Linear { ratio: TRACK_RATIO })
    }
}

/// The motor of the big axes; the load is the track's.
const ARM_MOTOR: Motor = Motor {
    torque_constant_nm_a: 0.105,
    rotor_kg_m2: 1.5e-4,
    gear_kg_m2: 0.0,
    load_kg_m2: 1.0e-4,
    viscous_nms_rad: 0.02,
    coulomb_nm: 0.02,
};

/// The motor of the wrist's rolls; the load is that of V.
const WRIST_MOTOR: Motor = Motor {
    torque_constant_nm_a: 0.105,
    rotor_kg_m2: 1.5e-5,
    gear_kg_m2: 0.0,
    load_kg_m2: 3.0e-5,
    viscous_nms_rad: 2.0e-4,
    coulomb_nm: 0.01,
};

pub(super) const fn column(machine: Machine) -> AxisDescription {
    AxisDescription {
        motor: Motor {
            load_kg_m2: 2.0e-4,
            ..ARM_MOTOR
        },
        motor_position: Range {
            lower: -470.0,
            upper: 450.0,
        },
        joint_position: degrees(-170.0, 170.0),
        pwm_regulator: regulator(0.010, 0.412_429_378_531, 1.556_959_2, 1.502_861_4),
        current_regulator: current(machine, 20_000.0),
        ..axis(
            "column",
            machine,
            Gearing::Linear {
                ratio: COLUMN_RATIO,
            },
        )
    }
}

pub(super) const fn lower_arm(machine: Machine) -> AxisDescription {
    AxisDescription {
        motor: Motor {
            load_kg_m2: 1.4e-4,
            ..ARM_MOTOR
        },
        motor_position: Range {
            lower: -110.0,
            upper: 100.0,
        },
        joint_position: degrees(-130.0, -50.0),
        pwm_regulator: regulator(0.008, 0.655_629_139_073, 0.618_106_8, 0.591_685_2),
        current_regulator: current(machine, 15_000.0),
        ..axis("lower arm", machine, Gearing::Screw(LOWER_ARM_SCREW))
    }
}

pub(super) const fn upper_arm(machine: Machine) -> AxisDescription {
    AxisDescription {
        reference: Reference::ArmPlane { offset: FRAC_PI_2 },
        motor_position: Range {
            lower: -80.0,
            upper: 100.0,
        },
        joint_position: degrees(-25.0, 40.0),
        pwm_regulator: regulator(0.008, 0.315_789_473_684, 1.198_478_4, 1.142_482_8),
        current_regulator: current(machine, 15_000.0),
        ..axis("upper arm", machine, Gearing::Screw(UPPER_ARM_SCREW))
    }
}

pub(super) const fn wrist_t(machine: Machine) -> AxisDescription {
    wrist_t_of(machine, 92.0)
}

/// T up to so many degrees.
pub(super) const fn wrist_t_of(machine: Machine, upper_degrees: f64) -> AxisDescription {
    AxisDescription {
        motor: Motor {
            load_kg_m2: 1.0e-5,
            ..ARM_MOTOR
        },
        reference: Reference::ArmPlane { offset: 0.0 },
        motor_position: Range {
            lower: -70.0,
            upper: 380.0,
        },
        joint_position: degrees(-90.0, upper_degrees),
        pwm_regulator: regulator(0.010, 0.548_946_716_233, 0.630_506_4, 0.587_439_6),
        current_regulator: current(machine, 15_000.0),
        ..axis("T", machine, Gearing::Linear { ratio: T_RATIO })
    }
}

pub(super) const fn wrist_v(machine: Machine) -> AxisDescription {
    AxisDescription {
        // bevels and the long shaft through the upper arm
        motor: Motor {
            gear_kg_m2: 2.4e-5,
            ..WRIST_MOTOR
        },
        motor_position: Range {
            lower: -80.0,
            upper: 490.0,
        },
        joint_position: Range {
            lower: -10.0,
            upper: 10.0,
        },
        pwm_regulator: regulator(0.020, 0.391_982_182_628, 0.445_859_2, 0.408_539_2),
        current_regulator: current(machine, 8_000.0),
        ..axis("V", machine, Gearing::OnPrevious { ratio: V_RATIO })
    }
}

pub(super) const fn wrist_n(machine: Machine) -> AxisDescription {
    AxisDescription {
        motor: Motor {
            load_kg_m2: 2.0e-7,
            coulomb_nm: 0.005,
            ..WRIST_MOTOR
        },
        increments_per_turn: 2000,
        motor_position: Range {
            lower: -1000.0,
            upper: 3000.0,
        },
        joint_position: Range {
            lower: -2.88,
            upper: 2.93,
        },
        homing: HOMING_N,
        pwm_regulator: regulator(0.005, 0.3, 0.5456, 0.5056),
        current_regulator: current(machine, 1_000.0),
        ..axis("N", machine, Gearing::Linear { ratio: N_RATIO })
    }
}

/// An N that reaches every angle: for the inverse of an arm that has none.
pub(super) const fn free_wrist_n() -> AxisDescription {
    AxisDescription {
        joint_position: Range {
            lower: -4.0,
            upper: 4.0,
        },
        ..wrist_n(machine(0.0, 0, 0.0))
    }
}

pub(super) const fn machine(
    synchro_motor_position: f64,
    overcurrent_ma: u32,
    gain_ma: f64,
) -> Machine {
    Machine {
        synchro_motor_position,
        overcurrent_ma,
        gain_ma,
    }
}
