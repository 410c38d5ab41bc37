//! The numbers of the RNT: all ASSUMED. [`crate::ASSUMED`] says why each is what it is.

/// Radius of the circle of the legs' feet in the base, at 90°, 210° and 330°, m.
pub(crate) const BASE_RADIUS_M: f64 = 0.40;
/// Radius of the circle of the legs' ends in the platform, at the same angles, m.
pub(crate) const PLATFORM_RADIUS_M: f64 = 0.15;
/// Lead of the ball screws of the legs, m/turn.
pub(crate) const LEAD_M: f64 = 0.010;
/// Shortest leg, a motor limit, m.
pub(crate) const LEG_SHORTEST_M: f64 = 0.60;
/// Longest leg, a motor limit, m.
pub(crate) const LEG_LONGEST_M: f64 = 1.60;
/// Length of a leg where homing ends, its motor at 0, m.
pub(crate) const LEG_AT_INDEX_M: f64 = 0.86;
/// Greatest tilt of the central leg about y and about x, either way, °.
pub(crate) const TILT_DEGREES: f64 = 35.0;
/// Least reach of the central leg, m.
pub(crate) const REACH_LEAST_M: f64 = 0.80;
/// Greatest reach of the central leg, m.
pub(crate) const REACH_MOST_M: f64 = 1.40;
/// The wrist's centre below the platform, m.
pub(crate) const WRIST_CENTRE_M: f64 = 0.12;
/// Turn of the wrist's base about the platform's y, rad.
pub(crate) const WRIST_MOUNT_RAD: f64 = 2.0 / 3.0 * core::f64::consts::PI;
/// Harmonic drives of the wrist, 1.
pub(crate) const WRIST_RATIO: f64 = 100.0;
/// Greatest angle of wrist 1, either way, °.
pub(crate) const WRIST_1_DEGREES: f64 = 170.0;
/// Greatest angle of wrist 2, either way, °.
pub(crate) const WRIST_2_DEGREES: f64 = 110.0;
/// Greatest angle of wrist 3, either way, °.
pub(crate) const WRIST_3_DEGREES: f64 = 350.0;
/// Where homing of a wrist's axis ends, from its lower limit, °.
pub(crate) const WRIST_INDEX_DEGREES: f64 = 5.0;
/// Tip of the spindle from the flange, along its approach, m.
pub(crate) const SPINDLE_M: f64 = 0.15;
/// Encoder increments of a motor, 1/turn.
pub(crate) const INCREMENTS_PER_TURN: u32 = 8000;
/// Greatest velocity of a motor, rad/s.
pub(crate) const MOTOR_VELOCITY: f64 = 300.0;
/// Acceleration of a leg, planning; the wrist's motors have the same in rad/s², m/s².
pub(crate) const ACCELERATION_PLANNING_M_S2: f64 = 2.0;
/// Acceleration of a leg, hard limit; the wrist's motors have the same in rad/s², m/s².
pub(crate) const ACCELERATION_HARD_M_S2: f64 = 5.0;
/// Jerk of a leg, planning; the wrist's motors have the same in rad/s³, m/s³.
pub(crate) const JERK_PLANNING_M_S3: f64 = 40.0;
/// Jerk of a leg, hard limit; the wrist's motors have the same in rad/s³, m/s³.
pub(crate) const JERK_HARD_M_S3: f64 = 1000.0;
/// Velocity of the tilts, planning, rad/s.
pub(crate) const TILT_VELOCITY: f64 = 1.0;
/// Acceleration of the tilts, planning, rad/s².
pub(crate) const TILT_ACCELERATION: f64 = 5.0;
/// Velocity of the reach, planning, m/s.
pub(crate) const REACH_VELOCITY: f64 = 0.45;
/// Acceleration of the reach, planning, m/s².
pub(crate) const REACH_ACCELERATION: f64 = 2.0;
/// Velocity of the wrist's joints, planning, rad/s.
pub(crate) const WRIST_VELOCITY: f64 = 2.5;
/// Acceleration of the wrist's joints, planning, rad/s².
pub(crate) const WRIST_ACCELERATION: f64 = 10.0;
/// Torque constant of the motors, N·m/A.
pub(crate) const TORQUE_CONSTANT: f64 = 0.2;
/// Inertia of a rotor, kg·m².
pub(crate) const ROTOR_KG_M2: f64 = 3.0e-4;
/// Load of a leg's motor, at its shaft, kg·m².
pub(crate) const LEG_LOAD_KG_M2: f64 = 2.0e-4;
/// Load of the motors of wrist 1 and 2, at their shafts, kg·m².
pub(crate) const WRIST_LOAD_KG_M2: f64 = 2.7e-5;
/// Load of the motor of wrist 3, at its shaft, kg·m².
pub(crate) const SPINDLE_LOAD_KG_M2: f64 = 5.0e-6;
/// Viscous friction of a motor, N·m·s/rad.
pub(crate) const VISCOUS: f64 = 2.0e-3;
/// Coulomb friction of a motor, N·m.
pub(crate) const COULOMB_NM: f64 = 0.05;
/// Greatest current of a motor, mA.
pub(crate) const CURRENT_MA: f64 = 25_000.0;
/// Velocity off the switch and on to the index, rad/s.
pub(crate) const HOMING_FINE: f64 = 1.5;
/// Ω of the regulators' two fast poles, rad/s.
pub(crate) const REGULATOR_RAD_S: f64 = 150.0;
/// Pole of the regulators' filter, 1.
pub(crate) const REGULATOR_FILTER: f64 = 0.3;
/// The base's frame in the world, m: the middle of the work area lies in the world's plane z = 0, away from
/// the other robots.
pub(crate) const BASE_POSITION_M: [f64; 3] = [0.0, -3.0, 1.30];
