//! Where the numbers of a description come from, group by group: each robot's description carries its table.

/// Who says a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// The public mirror of MRROC++ (ptroja/mrrocpp).
    Mrroc,
    /// The laboratory's later controller of the IRp-6 (RCPRG-ros-pkg/irp6_robot, October 2017).
    Irp6Robot,
    /// A model of Polycrank for `GraspIt!` (mzbikows/graspit).
    Graspit,
    /// No measured quantity: what a frame or a unit is chosen to be.
    Definition,
    /// Nobody has published it: chosen by this project.
    Assumed,
}

impl Source {
    /// The source's name in what is shown.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Mrroc => "MRROC++",
            Self::Irp6Robot => "irp6_robot",
            Self::Graspit => "GraspIt! model",
            Self::Definition => "by definition",
            Self::Assumed => "ASSUMED",
        }
    }
}

/// The source of every number of a [`RobotDescription`](crate::RobotDescription). Masses and shapes of links
/// are ASSUMED for every robot, and so have no field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sources {
    /// Lengths and directions of the links.
    pub geometry: Source,
    /// Servo step, macrostep.
    pub cycle: Source,
    /// Default tool.
    pub tool: Source,
    /// Base in the world.
    pub base: Source,
    /// What a plan may ask of the flange.
    pub flange: Source,
    /// Range of the joint.
    pub joint_range: Source,
    /// What a plan may ask of the joint: velocity, acceleration.
    pub joint_rates: Source,
    /// Range of the motor, and its angle at the reference.
    pub motor_range: Source,
    /// What the gear is, and drives.
    pub gearing: Source,
    /// Hard limit of the motor's velocity.
    pub hard_velocity: Source,
    /// Hard limits of its acceleration and jerk.
    pub hard_rates: Source,
    /// Planning limits of the motor's velocity and acceleration.
    pub plan_rates: Source,
    /// Planning limit of its jerk.
    pub plan_jerk: Source,
    /// Increments of the encoder.
    pub encoder: Source,
    /// Torque constant, rotor, viscous friction.
    pub motor: Source,
    /// Inertia of the load, Coulomb friction.
    pub load: Source,
    /// Where the drive trips by current.
    pub overcurrent: Source,
    /// Where it trips by following error.
    pub following_error: Source,
    /// Homing: velocity towards the switch.
    pub homing_coarse: Source,
    /// Homing: velocity off it and to the index.
    pub homing_fine: Source,
    /// Regulator for a voltage.
    pub pwm_regulator: Source,
    /// Regulator for a current: gain.
    pub current_gain: Source,
    /// Regulator for a current: greatest current.
    pub current_limit: Source,
}

impl Sources {
    /// Of a robot of which nothing is published.
    pub const ASSUMED: Self = {
        let assumed = Source::Assumed;
        Self {
            geometry: assumed,
            cycle: assumed,
            tool: assumed,
            base: assumed,
            flange: assumed,
            joint_range: assumed,
            joint_rates: assumed,
            motor_range: assumed,
            gearing: assumed,
            hard_velocity: assumed,
            hard_rates: assumed,
            plan_rates: assumed,
            plan_jerk: assumed,
            encoder: assumed,
            motor: assumed,
            load: assumed,
            overcurrent: assumed,
            following_error: assumed,
            homing_coarse: assumed,
            homing_fine: assumed,
            pwm_regulator: assumed,
            current_gain: assumed,
            current_limit: assumed,
        }
    };

    /// Of an IRp-6 with its own controllers.
    pub(crate) const IRP6: Self = Self {
        geometry: Source::Mrroc,
        cycle: Source::Mrroc,
        tool: Source::Mrroc,
        base: Source::Mrroc,
        flange: Source::Mrroc,
        joint_range: Source::Mrroc,
        joint_rates: Source::Mrroc,
        motor_range: Source::Mrroc,
        gearing: Source::Mrroc,
        hard_velocity: Source::Mrroc,
        plan_rates: Source::Mrroc,
        encoder: Source::Mrroc,
        motor: Source::Irp6Robot,
        overcurrent: Source::Mrroc,
        following_error: Source::Irp6Robot,
        homing_coarse: Source::Mrroc,
        homing_fine: Source::Mrroc,
        pwm_regulator: Source::Mrroc,
        current_gain: Source::Irp6Robot,
        current_limit: Source::Irp6Robot,
        ..Self::ASSUMED
    };
}
