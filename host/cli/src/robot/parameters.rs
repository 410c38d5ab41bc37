//! The numbers of a description as rows, each with the source its robot's table says.

use robots::{
    AxisDescription, AxisHoming, Gearing, Range, Reference, RobotDescription, Source, Sources,
};
use serde::{Serialize, Serializer};

/// One row: a quantity of one value or several.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Parameter {
    pub(super) item: &'static str,
    pub(super) values: Vec<f64>,
    pub(super) unit: &'static str,
    #[serde(serialize_with = "by_name")]
    pub(super) source: Source,
}

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "the signature that serde calls"
)]
fn by_name<S: Serializer>(source: &Source, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(source.name())
}

fn row(
    item: &'static str,
    values: impl Into<Vec<f64>>,
    unit: &'static str,
    source: Source,
) -> Parameter {
    Parameter {
        item,
        values: values.into(),
        unit,
        source,
    }
}

fn range(item: &'static str, range: Range, unit: &'static str, source: Source) -> Parameter {
    row(item, [range.lower, range.upper], unit, source)
}

/// What concerns the robot as a whole.
pub(super) fn of_robot<const N: usize>(robot: &RobotDescription<N>) -> Vec<Parameter> {
    let from = robot.sources;
    let step = f64::from(robot.servo_step_us);
    let macrostep = f64::from(robot.macrostep);
    let (tool, base) = (robot.tool_offset_m, robot.base_position_m);
    let (v, a) = (robot.cartesian_velocity, robot.cartesian_acceleration);
    vec![
        row("servo step", [step], "µs", from.cycle),
        row("macrostep", [macrostep], "servo steps", from.cycle),
        row("default tool, in the flange", tool, "m", from.tool),
        row("base, in the world", base, "m", from.base),
        row("flange velocity, planning", [v], "m/s", from.flange),
        row("flange acceleration, planning", [a], "m/s²", from.flange),
    ]
}

/// What concerns one axis of a robot with these sources.
pub(super) fn of_axis(axis: &AxisDescription, from: &Sources) -> Vec<Parameter> {
    let mut rows = limits(axis, from);
    rows.extend(transmission(axis, from.gearing));
    rows.extend(drive(axis, from));
    rows.extend(regulators(axis, from));
    rows
}

fn limits(axis: &AxisDescription, from: &Sources) -> Vec<Parameter> {
    // the joint's unit and its rates'
    let [q, dq, ddq] = match axis.kind {
        robots::JointKind::Revolute => ["rad", "rad/s", "rad/s²"],
        robots::JointKind::Prismatic => ["m", "m/s", "m/s²"],
    };
    let (v, a) = (axis.joint_velocity, axis.joint_acceleration);
    let (hard, plan) = (axis.hard_limits, axis.planning_limits);
    let [m1, m2, m3] = ["rad/s", "rad/s²", "rad/s³"];
    let (joint, motor) = (axis.joint_position, axis.motor_position);
    vec![
        range("joint position", joint, q, from.joint_range),
        row("joint velocity, planning", [v], dq, from.joint_rates),
        row("joint acceleration, planning", [a], ddq, from.joint_rates),
        range("motor position", motor, "rad", from.motor_range),
        row(
            "motor velocity, hard",
            [hard.velocity],
            m1,
            from.hard_velocity,
        ),
        row(
            "motor acceleration, hard",
            [hard.acceleration],
            m2,
            from.hard_rates,
        ),
        row("motor jerk, hard", [hard.jerk], m3, from.hard_rates),
        row(
            "motor velocity, planning",
            [plan.velocity],
            m1,
            from.plan_rates,
        ),
        row(
            "motor acceleration, planning",
            [plan.acceleration],
            m2,
            from.plan_rates,
        ),
        row("motor jerk, planning", [plan.jerk], m3, from.plan_jerk),
    ]
}

/// Motor, encoder, what trips, homing.
fn drive(axis: &AxisDescription, from: &Sources) -> Vec<Parameter> {
    let motor = axis.motor;
    let at = axis.synchro_motor_position;
    let increments = f64::from(axis.increments_per_turn);
    let (over, error) = (axis.overcurrent_ma, axis.following_error_increments);
    let load = "load inertia, mean, at the motor";
    let mut rows = vec![
        row("motor at the reference", [at], "rad", from.motor_range),
        row("encoder", [increments], "increments/turn", from.encoder),
        row(
            "torque constant",
            [motor.torque_constant_nm_a],
            "N·m/A",
            from.motor,
        ),
        row("rotor inertia", [motor.rotor_kg_m2], "kg·m²", from.motor),
        row(load, [motor.load_kg_m2], "kg·m²", from.load),
        row(
            "viscous friction",
            [motor.viscous_nms_rad],
            "N·m·s/rad",
            from.motor,
        ),
        row("Coulomb friction", [motor.coulomb_nm], "N·m", from.load),
        row("overcurrent", [f64::from(over)], "mA", from.overcurrent),
        row(
            "following error",
            [f64::from(error)],
            "increments",
            from.following_error,
        ),
    ];
    if let AxisHoming::Switch {
        coarse_velocity,
        fine_velocity,
    } = axis.homing
    {
        let [coarse, fine] = ["homing velocity, coarse", "homing velocity, fine"];
        rows.push(row(coarse, [coarse_velocity], "rad/s", from.homing_coarse));
        rows.push(row(fine, [fine_velocity], "rad/s", from.homing_fine));
    }
    rows
}

fn regulators(axis: &AxisDescription, from: &Sources) -> Vec<Parameter> {
    let (pwm, current) = (axis.pwm_regulator, axis.current_regulator);
    let constants = [pwm.epsilon, pwm.a, pwm.b0, pwm.b1, pwm.limit];
    let item = "PWM regulator ε, a, b0, b1, limit";
    vec![
        row(item, constants, "PWM units", from.pwm_regulator),
        row(
            "current regulator gain",
            [current.gain_ma],
            "mA",
            from.current_gain,
        ),
        row(
            "current regulator limit",
            [current.limit_ma],
            "mA",
            from.current_limit,
        ),
    ]
}

/// How the motor drives the joint.
fn transmission(axis: &AxisDescription, from: Source) -> Vec<Parameter> {
    let mut rows = vec![];
    match axis.reference {
        Reference::Joint => {}
        Reference::ArmPlane { offset } => {
            let item = "drives the link's angle in the plane";
            rows.push(row(item, [offset], "rad + joint + link before", from));
        }
        Reference::Leg { reference_length_m } => {
            let item = "drives a leg; its length at the reference";
            rows.push(row(item, [reference_length_m], "m", from));
        }
    }
    let unit = match (axis.kind, axis.reference) {
        (_, Reference::Leg { .. }) | (robots::JointKind::Prismatic, _) => "rad/m",
        (robots::JointKind::Revolute, _) => "rad/rad",
    };
    match axis.gearing {
        Gearing::Linear { ratio } => rows.push(row("gear", [ratio], unit, from)),
        Gearing::OnPrevious { ratio } => {
            rows.push(row("gear, on the motor before", [ratio], unit, from));
        }
        Gearing::Quadratic(law) => {
            let item = "jaw by the motor's angle: c0, c1, c2";
            let constants = [law.constant, law.linear, law.square];
            rows.push(row(item, constants, "m, m/rad, m/rad²", from));
        }
        Gearing::Screw(screw) => {
            let sides = [screw.cosine_mm2, screw.sine_mm2];
            let length = screw.reference_length_mm;
            rows.extend([
                row(
                    "screw triangle, sum of squares",
                    [screw.sum_of_squares_mm2],
                    "mm²",
                    from,
                ),
                row("screw triangle, cosine and sine", sides, "mm²", from),
                row("screw length at the reference", [length], "mm", from),
                row("screw", [screw.rad_per_mm], "rad/mm", from),
            ]);
        }
    }
    rows
}
