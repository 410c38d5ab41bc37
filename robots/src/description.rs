//! What is known about a robot, as constants.
//!
//! Sources, by short name: *MRROC++* is the public mirror of MRROC++ (ptroja/mrrocpp), the robots
//! there called `irp6ot_m` (track) and `irp6p_m` (postument); `irp6_robot` is the same laboratory's
//! later controller of the same machines (RCPRG-ros-pkg/irp6_robot, parameters of October 2017).
//! Everything else is labelled ASSUMED and listed in [`crate::ASSUMED`]. What the fields below name is the source for
//! the IRp-6; for the others [`RobotDescription::sources`] says it.

use motion::Pose;
use nalgebra::{Matrix3, Vector3};

use crate::quadratic::Quadratic;
use crate::screw::ScrewTriangle;
use crate::sources::Sources;

/// An inclusive range; infinite ends where there is no bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Least allowed value.
    pub lower: f64,
    /// Greatest allowed value.
    pub upper: f64,
}

impl Range {
    /// No bounds: an axis that turns without end.
    pub const UNLIMITED: Self = Self {
        lower: f64::NEG_INFINITY,
        upper: f64::INFINITY,
    };

    /// Whether both ends are bounds.
    #[must_use]
    pub const fn is_bounded(&self) -> bool {
        self.lower.is_finite() && self.upper.is_finite()
    }

    /// Whether the value is inside; a NaN is not.
    #[must_use]
    pub fn contains(&self, value: f64) -> bool {
        self.lower <= value && value <= self.upper
    }

    /// The middle; 0 of a range without both bounds.
    #[must_use]
    pub fn centre(&self) -> f64 {
        if self.is_bounded() {
            0.5 * (self.lower + self.upper)
        } else {
            0.0
        }
    }
}

/// How a joint moves, which gives its unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// Turns; rad.
    Revolute,
    /// Slides; m.
    Prismatic,
}

/// What the gear of an axis drives: its *gear coordinate* x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reference {
    /// The joint itself: x = q.
    Joint,
    /// The link's angle in the arm's plane, held by parallelograms whatever the links before it do:
    /// `x = q + x_previous + offset`.
    ArmPlane {
        /// rad.
        offset: f64,
    },
    /// A leg between the base and a moving platform: x is its length less `reference_length_m`. Several
    /// joints change it, by a function that the robot's own code knows; the description alone does not
    /// lead from joints to motors here.
    Leg {
        /// Length of the leg where the motor stands at its synchronisation offset, m.
        reference_length_m: f64,
    },
}

/// How the motor of an axis drives its gear coordinate x. Travel is the motor angle from
/// [`AxisDescription::synchro_motor_position`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Gearing {
    /// travel = ratio · x.
    Linear {
        /// rad of the motor for a rad (or m) of x; negative where the senses differ.
        ratio: f64,
    },
    /// travel = `travel_of_previous_axis` + ratio · x: a bevel wrist, where turning the axis before
    /// turns this one too.
    OnPrevious {
        /// rad of the motor for a rad of x.
        ratio: f64,
    },
    /// A ball screw across a triangle.
    Screw(ScrewTriangle),
    /// x = a quadratic of the travel: the jaws of a gripper.
    Quadratic(Quadratic),
}

/// Greatest absolute values of a motor's motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorLimits {
    /// rad/s.
    pub velocity: f64,
    /// rad/s².
    pub acceleration: f64,
    /// rad/s³.
    pub jerk: f64,
}

/// How one axis finds its reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AxisHoming {
    /// Towards the switch, stop, back off it, on to the index. MRROC++ `servo_gr`.
    Switch {
        /// Motor velocity towards the switch, rad/s. MRROC++ `regulator_*.h`.
        coarse_velocity: f64,
        /// Motor velocity off the switch and on to the index pulse, rad/s. Same source.
        fine_velocity: f64,
    },
    /// Motor angle 0 is where the axis stands: nothing moves. MRROC++ `sg_conv`.
    InPlace,
    /// The drive's encoder is absolute: its position 0 is motor angle 0; nothing moves.
    Absolute,
}

/// What is common to the homing of all axes of a robot. MRROC++ `servo_gr`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HomingSequence<const N: usize> {
    /// Axes in the order in which they are homed, one after another.
    pub order: [usize; N],
    /// Servo steps of the ramp to the coarse velocity.
    pub ramp_steps: u32,
    /// Servo steps of standstill on the switch.
    pub stop_steps: u32,
    /// Servo steps of standstill after the last axis.
    pub settle_steps: u32,
    /// Servo steps the switch must be seen before it counts. MRROC++ `hi_moxa`.
    pub debounce_steps: u32,
}

/// The second-order regulator of MRROC++, one call a servo step; position error e in encoder
/// increments a step, output u in its PWM units of 0 to 255.
///
/// δ\[k\] = δ\[k−1\] + (1+ε)·e\[k\] − (1−ε)·e\[k−1\];
/// u\[k\] = (1+a)·u\[k−1\] − a·u\[k−2\] + b0·δ\[k\] − b1·δ\[k−1\], |u| ≤ limit.
///
/// These are the constants in effect at every step of the original; its constructors and selectable
/// sets hold others that were overwritten before use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PwmRegulator {
    /// ε: share of integration, 1.
    pub epsilon: f64,
    /// a: pole of the filter, 1.
    pub a: f64,
    /// b0, PWM units an increment.
    pub b0: f64,
    /// b1, PWM units an increment.
    pub b1: f64,
    /// Saturation, PWM units. MRROC++ `regulator.cc`.
    pub limit: f64,
}

/// The same regulator with a current as its output: current = gain · u, clamped. `irp6_robot`,
/// launch parameters of October 2017.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurrentRegulator {
    /// mA for a unit of u.
    pub gain_ma: f64,
    /// Greatest demanded current, mA.
    pub limit_ma: f64,
}

/// A motor with what it drives, as seen at its shaft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motor {
    /// Torque per current, N·m/A. `irp6_robot`.
    pub torque_constant_nm_a: f64,
    /// Inertia of the rotor, kg·m². `irp6_robot` `hw_model`.
    pub rotor_kg_m2: f64,
    /// Inertia of couplings, shafts and gears that turn with the rotor, at its shaft, kg·m²: ASSUMED.
    pub gear_kg_m2: f64,
    /// Mean inertia of all that is behind the rotor, gear and links, kg·m², which the gains are for: ASSUMED.
    pub load_kg_m2: f64,
    /// Viscous friction, N·m·s/rad. `irp6_robot` `hw_model`.
    pub viscous_nms_rad: f64,
    /// Coulomb friction, N·m: ASSUMED.
    pub coulomb_nm: f64,
}

impl AxisDescription {
    /// Does the motor turn the joint without a gear? Then links move motors as much as motors links, and
    /// loops of single axes have to be slow.
    #[must_use]
    pub fn is_direct(&self) -> bool {
        matches!(self.gearing, Gearing::Linear { ratio } if libm::fabs(ratio - 1.0) < 1e-12)
    }
}

/// One axis: motor, gear, joint, limits, regulators.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisDescription {
    /// The axis' name in messages.
    pub name: &'static str,
    /// Revolute (rad) or prismatic (m).
    pub kind: JointKind,
    /// What the gear drives. MRROC++ `kinematic_model_*_with_wrist`.
    pub reference: Reference,
    /// How. Same source.
    pub gearing: Gearing,
    /// Motor angle at which the gear is at its reference, rad, counted from where homing ends: the
    /// calibration of this very machine. Same source.
    pub synchro_motor_position: f64,
    /// Encoder increments a turn of the motor. MRROC++ `edp_irp6*_m_effector.h`.
    pub increments_per_turn: u32,
    /// Motor angle, rad. MRROC++ `kinematic_model_*_with_wrist`.
    pub motor_position: Range,
    /// Joint position, rad or m. Same source.
    pub joint_position: Range,
    /// What no set-point may exceed. The velocity (MRROC++: 0.5 rad in a 2 ms step) is scaled by a
    /// [`crate::VelocityFactor`]; acceleration and jerk are ASSUMED.
    pub hard_limits: MotorLimits,
    /// What a plan may use. Velocity and acceleration: MRROC++ `ecp_g_newsmooth`; jerk is ASSUMED.
    pub planning_limits: MotorLimits,
    /// What a plan may ask of the joint, rad/s or m/s. MRROC++ `ecp_g_newsmooth`.
    pub joint_velocity: f64,
    /// What a plan may ask of the joint, rad/s² or m/s². Same source.
    pub joint_acceleration: f64,
    /// Current at which the drive trips, mA. MRROC++ `const_irp6*_m.h`.
    pub overcurrent_ma: u32,
    /// Encoder increments in one servo step beyond which the reading is not believed. MRROC++
    /// `const_irp6*_m.h`.
    pub max_increments_per_step: u32,
    /// Following error at which the axis trips, encoder increments. `irp6_robot`.
    pub following_error_increments: u32,
    /// Its motor and load.
    pub motor: Motor,
    /// How it is homed.
    pub homing: AxisHoming,
    /// Regulator for a drive that takes a voltage.
    pub pwm_regulator: PwmRegulator,
    /// Regulator for a drive that takes a current.
    pub current_regulator: CurrentRegulator,
}

/// A robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobotDescription<const N: usize> {
    /// The name commands and files use.
    pub name: &'static str,
    /// What it is, for people.
    pub long_name: &'static str,
    /// Who says the numbers of this very robot.
    pub sources: Sources,
    /// Servo step, µs. MRROC++ `EDP_STEP`.
    pub servo_step_us: u32,
    /// Servo steps in a macrostep. MRROC++ `ecp_g_multiple_position.h`.
    pub macrostep: u32,
    /// The axes, base first.
    pub axes: [AxisDescription; N],
    /// Order and pauses of homing.
    pub homing: HomingSequence<N>,
    /// Default tool: its tip from the flange, m, along the flange's axes. MRROC++: middle of the jaws.
    pub tool_offset_m: [f64; 3],
    /// The robot's base frame in the world, m; the axes are parallel. MRROC++ gives the postument a
    /// tilt of up to 1.9°, which is left out here.
    pub base_position_m: [f64; 3],
    /// What a plan may ask of the flange, m/s. MRROC++ `ecp_g_newsmooth`.
    pub cartesian_velocity: f64,
    /// What a plan may ask of the flange, m/s². Same source.
    pub cartesian_acceleration: f64,
}

impl<const N: usize> RobotDescription<N> {
    /// `t_flange_tool` of the default tool.
    #[must_use]
    pub fn default_tool(&self) -> Pose {
        translation(self.tool_offset_m)
    }

    /// Which drive bus each axis hangs on, when a robot has buses of its own: as few as will do, filled evenly.
    #[must_use]
    pub fn drive_buses(&self) -> [u8; N] {
        let step = usize::try_from(self.servo_step_us).unwrap_or(usize::MAX);
        let most = (AXES_OF_A_BUS.saturating_mul(step) / 2000).max(1);
        let on_each = N.div_ceil(N.div_ceil(most).max(1)).max(1);
        core::array::from_fn(|axis| u8::try_from(axis / on_each).unwrap_or(u8::MAX))
    }

    /// `t_world_base`.
    #[must_use]
    pub fn base(&self) -> Pose {
        translation(self.base_position_m)
    }
}

/// The most axes of one drive bus for a servo step of 2 ms: six at 500 Hz fill a classical 1 Mbit/s bus to 78 %.
const AXES_OF_A_BUS: usize = 6;

fn translation([x, y, z]: [f64; 3]) -> Pose {
    Pose {
        position: Vector3::new(x, y, z),
        rotation: Matrix3::identity(),
    }
}
