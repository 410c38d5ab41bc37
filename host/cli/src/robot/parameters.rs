//! The numbers of a description as rows. Which source a number has is said in `robots::description`,
//! field by field; this repeats it.

use robots::{AxisDescription, AxisHoming, Gearing, Range, Reference, RobotDescription};
use serde::Serialize;

/// Chosen by this project, because nobody published it.
pub(super) const ASSUMED: &str = "ASSUMED";

const MRROC: &str = "MRROC++";
const IRP6_ROBOT: &str = "irp6_robot";

/// One row: a quantity of one value or several.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Parameter {
    pub(super) item: &'static str,
    pub(super) values: Vec<f64>,
    pub(super) unit: &'static str,
    pub(super) source: &'static str,
}

fn row(
    item: &'static str,
    values: impl Into<Vec<f64>>,
    unit: &'static str,
    source: &'static str,
) -> Parameter {
    Parameter {
        item,
        values: values.into(),
        unit,
        source,
    }
}

fn range(item: &'static str, range: Range, unit: &'static str) -> Parameter {
    row(item, [range.lower, range.upper], unit, MRROC)
}

/// What concerns the robot as a whole.
pub(super) fn of_robot<const N: usize>(robot: &RobotDescription<N>) -> Vec<Parameter> {
    vec![
        row("servo step", [f64::from(robot.servo_step_us)], "µs", MRROC),
        row(
            "macrostep",
            [f64::from(robot.macrostep)],
            "servo steps",
            MRROC,
        ),
        row(
            "default tool, in the flange",
            robot.tool_offset_m,
            "m",
            MRROC,
        ),
        row("base, in the world", robot.base_position_m, "m", MRROC),
        row(
            "flange velocity, planning",
            [robot.cartesian_velocity],
            "m/s",
            MRROC,
        ),
        row(
            "flange acceleration, planning",
            [robot.cartesian_acceleration],
            "m/s²",
            MRROC,
        ),
    ]
}

/// What concerns one axis.
pub(super) fn of_axis(axis: &AxisDescription) -> Vec<Parameter> {
    let mut rows = limits(axis);
    rows.extend(transmission(axis));
    rows.extend(drive(axis));
    rows.extend(regulators(axis));
    rows
}

fn limits(axis: &AxisDescription) -> Vec<Parameter> {
    // the joint's unit and its rates'
    let [q, dq, ddq] = match axis.kind {
        robots::JointKind::Revolute => ["rad", "rad/s", "rad/s²"],
        robots::JointKind::Prismatic => ["m", "m/s", "m/s²"],
    };
    let (hard, plan) = (axis.hard_limits, axis.planning_limits);
    vec![
        range("joint position", axis.joint_position, q),
        row("joint velocity, planning", [axis.joint_velocity], dq, MRROC),
        row(
            "joint acceleration, planning",
            [axis.joint_acceleration],
            ddq,
            MRROC,
        ),
        range("motor position", axis.motor_position, "rad"),
        row("motor velocity, hard", [hard.velocity], "rad/s", MRROC),
        row(
            "motor acceleration, hard",
            [hard.acceleration],
            "rad/s²",
            ASSUMED,
        ),
        row("motor jerk, hard", [hard.jerk], "rad/s³", ASSUMED),
        row("motor velocity, planning", [plan.velocity], "rad/s", MRROC),
        row(
            "motor acceleration, planning",
            [plan.acceleration],
            "rad/s²",
            MRROC,
        ),
        row("motor jerk, planning", [plan.jerk], "rad/s³", ASSUMED),
    ]
}

/// Motor, encoder, what trips, homing.
fn drive(axis: &AxisDescription) -> Vec<Parameter> {
    let motor = axis.motor;
    let mut rows = vec![
        row(
            "motor at the reference",
            [axis.synchro_motor_position],
            "rad",
            MRROC,
        ),
        row(
            "encoder",
            [f64::from(axis.increments_per_turn)],
            "increments/turn",
            MRROC,
        ),
        row(
            "torque constant",
            [motor.torque_constant_nm_a],
            "N·m/A",
            IRP6_ROBOT,
        ),
        row("rotor inertia", [motor.rotor_kg_m2], "kg·m²", IRP6_ROBOT),
        row(
            "load inertia, mean, at the motor",
            [motor.load_kg_m2],
            "kg·m²",
            ASSUMED,
        ),
        row(
            "viscous friction",
            [motor.viscous_nms_rad],
            "N·m·s/rad",
            IRP6_ROBOT,
        ),
        row("Coulomb friction", [motor.coulomb_nm], "N·m", ASSUMED),
        row("overcurrent", [f64::from(axis.overcurrent_ma)], "mA", MRROC),
        row(
            "following error",
            [f64::from(axis.following_error_increments)],
            "increments",
            IRP6_ROBOT,
        ),
    ];
    if let AxisHoming::Switch {
        coarse_velocity,
        fine_velocity,
    } = axis.homing
    {
        let item = "homing velocity, coarse and fine";
        rows.push(row(item, [coarse_velocity, fine_velocity], "rad/s", MRROC));
    }
    rows
}

fn regulators(axis: &AxisDescription) -> Vec<Parameter> {
    let (pwm, current) = (axis.pwm_regulator, axis.current_regulator);
    vec![
        row(
            "PWM regulator ε, a, b0, b1, limit",
            [pwm.epsilon, pwm.a, pwm.b0, pwm.b1, pwm.limit],
            "PWM units",
            MRROC,
        ),
        row(
            "current regulator gain, limit",
            [current.gain_ma, current.limit_ma],
            "mA",
            IRP6_ROBOT,
        ),
    ]
}

/// How the motor drives the joint.
fn transmission(axis: &AxisDescription) -> Vec<Parameter> {
    let mut rows = vec![];
    if let Reference::ArmPlane { offset } = axis.reference {
        let item = "drives the link's angle in the plane";
        rows.push(row(item, [offset], "rad + joint + link before", MRROC));
    }
    let unit = match axis.kind {
        robots::JointKind::Revolute => "rad/rad",
        robots::JointKind::Prismatic => "rad/m",
    };
    match axis.gearing {
        Gearing::Linear { ratio } => rows.push(row("gear", [ratio], unit, MRROC)),
        Gearing::OnPrevious { ratio } => {
            rows.push(row("gear, on the motor before", [ratio], unit, MRROC));
        }
        Gearing::Quadratic(law) => rows.push(row(
            "jaw by the motor's angle: c0, c1, c2",
            [law.constant, law.linear, law.square],
            "m, m/rad, m/rad²",
            MRROC,
        )),
        Gearing::Screw(screw) => rows.extend([
            row(
                "screw triangle, sum of squares",
                [screw.sum_of_squares_mm2],
                "mm²",
                MRROC,
            ),
            row(
                "screw triangle, cosine and sine",
                [screw.cosine_mm2, screw.sine_mm2],
                "mm²",
                MRROC,
            ),
            row(
                "screw length at the reference",
                [screw.reference_length_mm],
                "mm",
                MRROC,
            ),
            row("screw", [screw.rad_per_mm], "rad/mm", MRROC),
        ]),
    }
    rows
}
