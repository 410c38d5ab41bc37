//! Every kind of robot that is not an IRp-6 of six axes or more: homed and moved by its node over the
//! buses, in lock step, with every law, and every limit kept. Axes without end go beyond what 32 bits
//! count.

use host::input::Files;
use host::mp::arm::{arm, motor_angles, unit_rad};
use host::task::Task;
use mrroc_tests::coordinator::{Coordinator, speeds};
use mrroc_tests::{job, workspace};
use protocol::fault::Cause;
use protocol::message::{
    Instruction, NodeState, PoseMessage, PosePath, PoseReference, PoseSpeeds, Reply, ServoLaw,
};
use robots::{AxisHoming, RobotKind};

const LAWS: [ServoLaw; 3] = [
    ServoLaw::DrivePosition,
    ServoLaw::Original,
    ServoLaw::FeedForward,
];

/// Homed, and what homing must leave: the index at 0, the belt where it stood, the encoder's angle.
/// A second at rest: integrals take what friction and gravity leave.
fn settle(c: &mut Coordinator) {
    for _ in 0..50 {
        c.macrostep();
    }
}

fn homed(kind: RobotKind, law: ServoLaw, seed: u64) -> Coordinator {
    let mut c = Coordinator::new(kind, law, seed);
    c.enable();
    let before: Vec<f64> = c.cell.robots().next().unwrap().1.motor_rad().to_vec();
    c.home();
    settle(&mut c);
    let what = format!("{kind} {law:?}");
    assert_eq!(
        c.feedback().synchronised.count_ones() as usize,
        kind.axes(),
        "{what}"
    );
    let after: Vec<f64> = c.cell.robots().next().unwrap().1.motor_rad().to_vec();
    let counted = motor_angles(arm(kind).axes(), &c.feedback().actual).unwrap();
    for (k, axis) in arm(kind).axes().iter().enumerate() {
        // a few increments of gravity and friction
        let few = 20.0 * 1000.0 * unit_rad(axis);
        let what = format!(
            "{what} {}: {} to {}, {}",
            axis.name, before[k], after[k], counted[k]
        );
        match axis.homing {
            AxisHoming::Switch { .. } => {
                assert!(after[k].abs() < few && counted[k].abs() < few, "{what}");
            }
            AxisHoming::InPlace => {
                assert!(
                    (after[k] - before[k]).abs() < few && counted[k].abs() < few,
                    "{what}"
                );
            }
            AxisHoming::Absolute => {
                // gravity, until the integral holds it
                assert!((after[k] - before[k]).abs() < 0.05, "{what}");
                assert!(
                    (counted[k] - after[k]).abs() < 2.0 * 1000.0 * unit_rad(axis),
                    "{what}"
                );
            }
        }
    }
    c
}

fn joints(c: &Coordinator, kind: RobotKind) -> Vec<f64> {
    let motors = motor_angles(arm(kind).axes(), &c.feedback().actual).unwrap();
    arm(kind).joints(&motors).unwrap().to_vec()
}

/// At the target, to the following error at rest, a second later.
fn arrived(c: &mut Coordinator, kind: RobotKind, law: ServoLaw, target: &[f64]) {
    let what = format!("{kind} {law:?}");
    settle(c);
    let motors = arm(kind).motors(target).unwrap();
    let actual = motor_angles(arm(kind).axes(), &c.feedback().actual).unwrap();
    for ((axis, wanted), actual) in arm(kind).axes().iter().zip(&motors).zip(&actual) {
        let increments = (wanted - actual).abs() / (1000.0 * unit_rad(axis));
        // single axes of direct drives are held weakly against friction in cst: integrals take seconds there, and a
        // hundred increments are 10 mrad; in csp the model holds them
        let bound = match (axis.is_direct(), law) {
            (true, ServoLaw::DrivePosition) => 30.0,
            (true, _) => 1000.0,
            (false, _) => 120.0,
        };
        assert!(
            increments < bound,
            "{what} {}: {increments} increments off",
            axis.name
        );
    }
}

fn homes_and_moves(kind: RobotKind, targets: &[&[f64]]) {
    for law in LAWS {
        let what = format!("{kind} {law:?}");
        let mut c = homed(kind, law, 3);
        for target in targets {
            c.execute(Instruction::MoveJoints {
                target: target.iter().copied().collect(),
                relative: false,
                speeds: speeds(kind.axes(), 0.5, 0.5),
            });
            arrived(&mut c, kind, law, target);
        }
        assert_eq!(c.feedback().fault, None, "{what}");
        assert_eq!(c.feedback().limit_violations, 0, "{what}");
        assert_eq!(c.cell.refused(), [], "{what}");
        c.watch.assert_kept(&what);
    }
}

#[test]
fn the_conveyor_homes_in_place_and_moves() {
    homes_and_moves(RobotKind::Conveyor, &[&[0.15], &[-0.1]]);
}

#[test]
fn both_grippers_home_open_and_close() {
    for kind in [RobotKind::Irp6TrackGripper, RobotKind::Irp6PostumentGripper] {
        homes_and_moves(kind, &[&[0.0905], &[0.0535], &[0.074]]);
    }
}

#[test]
fn the_arm_of_five_axes_homes_and_moves() {
    homes_and_moves(RobotKind::Irp6Arm, &[&[0.2, -1.5, 0.1, 1.4, 0.5]]);
}

#[test]
fn polycrank_needs_no_motion_to_be_homed_and_moves() {
    let kind = RobotKind::Polycrank;
    let near =
        |c: &Coordinator, by: f64| -> Vec<f64> { joints(c, kind).iter().map(|q| q + by).collect() };
    for law in LAWS {
        let mut c = homed(kind, law, 3);
        for by in [0.4, -0.9] {
            let target = near(&c, by);
            c.execute(Instruction::MoveJoints {
                target: target.iter().copied().collect(),
                relative: false,
                speeds: speeds(7, 0.5, 0.5),
            });
            arrived(&mut c, kind, law, &target);
        }
        assert_eq!(c.feedback().limit_violations, 0, "{law:?}");
        c.watch.assert_kept(&format!("polycrank {law:?}"));
    }
}

/// Position units of a turn and more than 2³² of them.
fn beyond_32_bits(kind: RobotKind, axis: usize) -> f64 {
    let unit = unit_rad(&arm(kind).axes()[axis]);
    1.05 * unit * f64::from(u32::MAX)
}

#[test]
fn an_axis_without_end_goes_on_where_32_bits_end() {
    for (kind, law, axis, legs) in [
        (RobotKind::Conveyor, ServoLaw::DrivePosition, 0, 3),
        (RobotKind::Conveyor, ServoLaw::Original, 0, 3),
        (RobotKind::Polycrank, ServoLaw::DrivePosition, 6, 4),
    ] {
        let mut c = homed(kind, law, 3);
        let from = motor_angles(arm(kind).axes(), &c.feedback().actual).unwrap();
        // in legs, each of less than two minutes
        for leg in 1..=legs {
            let mut target = from.clone();
            target[axis] -= beyond_32_bits(kind, axis) * f64::from(leg) / f64::from(legs);
            c.execute(Instruction::MoveMotors {
                target: target.clone(),
                relative: false,
                speeds: speeds(kind.axes(), 1.0, 1.0),
            });
            let joints = arm(kind).joints(&target).unwrap();
            arrived(&mut c, kind, law, &joints);
        }
        // the drive itself counted as far, and what it says is that modulo 2³²
        let units = c.feedback().actual[axis];
        assert!(units < -i64::from(u32::MAX), "{units}");
        let truth = c.cell.robots().next().unwrap().1.motor_rad()[axis];
        let gone = truth - from[axis];
        assert!(
            (-gone / beyond_32_bits(kind, axis) - 1.0).abs() < 0.05,
            "{gone}"
        );
        c.watch.assert_kept(&format!("{kind} {law:?}"));
    }
}

fn pose(position_m: [f64; 3], rotation_rad: [f64; 3]) -> PoseMessage {
    PoseMessage {
        position_m,
        rotation_rad,
    }
}

const SLOWLY: PoseSpeeds = PoseSpeeds {
    velocity_m_s: 0.05,
    angular_velocity_rad_s: 0.3,
    acceleration_m_s2: 0.2,
    angular_acceleration_rad_s2: 1.0,
};

#[test]
fn tools_go_straight() {
    let start: [(RobotKind, &[f64]); 3] = [
        (RobotKind::Irp6Arm, &[0.2, -1.5, 0.1, 1.4, 0.5]),
        (RobotKind::Conveyor, &[0.02]),
        (RobotKind::Polycrank, &[0.3, 1.2, -0.4, 0.5, -1.1, 1.6, 2.0]),
    ];
    for (kind, from) in start {
        let mut c = homed(kind, ServoLaw::DrivePosition, 3);
        let mut from = from.to_vec();
        if kind == RobotKind::Polycrank {
            // in the turns where it stands
            for (q, now) in from.iter_mut().zip(joints(&c, kind)) {
                *q += core::f64::consts::TAU * ((now - *q) / core::f64::consts::TAU).round();
            }
        }
        c.execute(Instruction::MoveJoints {
            target: from.iter().copied().collect(),
            relative: false,
            speeds: speeds(kind.axes(), 1.0, 1.0),
        });
        let tool = |q: &[f64]| arm(kind).forward(q).unwrap() * arm(kind).default_tool();
        let begin = tool(&from);
        let by = match kind {
            RobotKind::Conveyor => [0.05, 0.0, 0.0],
            _ => [0.02, -0.04, 0.03],
        };
        let mut target = begin;
        for (p, by) in target.position.iter_mut().zip(by) {
            *p += by;
        }
        let turn = target.rotation_vector();
        c.execute(Instruction::MovePose {
            target: pose(target.position.into(), turn.into()),
            reference: PoseReference::Base,
            path: PosePath::Line,
            speeds: SLOWLY,
        });
        let end = tool(&joints(&c, kind));
        let off = (end.position - target.position).norm();
        // what the following error at rest makes at the tool
        assert!(off < 2e-4, "{kind}: {off} m");
        let axis = (end.rotation.column(2) - target.rotation.column(2)).norm();
        assert!(axis < 1e-3, "{kind}: {axis}");
        c.watch.assert_kept(kind.name());
    }
}

#[test]
fn a_turn_about_its_tool_axis_is_nothing_to_five_axes() {
    let kind = RobotKind::Irp6Arm;
    let from = [0.2, -1.5, 0.1, 1.4, 0.5];
    let mut c = homed(kind, ServoLaw::DrivePosition, 3);
    c.execute(Instruction::MoveJoints {
        target: from.into_iter().collect(),
        relative: false,
        speeds: speeds(5, 1.0, 1.0),
    });
    let before = joints(&c, kind);
    c.execute(Instruction::MovePose {
        target: pose([0.0; 3], [0.0, 0.0, 0.6]),
        reference: PoseReference::Tool,
        path: PosePath::Line,
        speeds: SLOWLY,
    });
    for (before, after) in before.iter().zip(joints(&c, kind)) {
        // an increment of T's motor is 1.2e-5 rad
        assert!((before - after).abs() < 1e-3, "{before} {after}");
    }
    // a turn that tilts the axis beyond what V and T reach is refused, and says so
    let reply = c.begin(Instruction::MovePose {
        target: pose([0.0; 3], [2.5, 0.0, 0.0]),
        reference: PoseReference::Tool,
        path: PosePath::Line,
        speeds: SLOWLY,
    });
    assert_eq!(reply, Reply::Accepted);
    c.wait("refused", 60.0, |f| {
        matches!(f.progress, protocol::message::Progress::Failed(_))
    });
    let rest = [NodeState::Holding, NodeState::Faulted];
    c.wait("at rest", 5.0, |f| rest.contains(&f.state));
    // a motor's limit shows only as its knot comes: that is a stop on the path, and no limit broken
    let cause = c.feedback().fault.map(|fault| fault.cause);
    assert!(
        matches!(cause, None | Some(Cause::PositionLimit)),
        "{cause:?}"
    );
    assert_eq!(c.feedback().limit_violations, 0);
}

/// A cell of the track's robot by a rule, and a line 0.3 m along the track from the front pose, which has
/// the track 0.2 m out and, turned, `column` rad off.
fn along_the_track(rule: &str, column: f64) -> Task {
    let arm = arm(RobotKind::Irp6Track);
    let front = [0.2, column, -1.57, 0.0, 1.56, 1.57, -1.57];
    let mut tool = arm.forward(&front).unwrap() * arm.default_tool();
    tool.position.y += 0.3;
    let (p, r) = (tool.position, tool.rotation_vector());
    let text = format!(
        r#"title = "along the track"
cell = {{ robot = [{{ kind = "irp6-track", track = "{rule}" }}] }}
[[step]]
home = ["irp6-track"]
[[step]]
move = {{ robot = "irp6-track", joints = {front:?} }}
[[step]]
move = {{ robot = "irp6-track", pose = {{ position_m = [{}, {}, {}], rotation_rad = [{}, {}, {}] }}, path = "line", speed = 0.02 }}
"#,
        p.x, p.y, p.z, r.x, r.y, r.z
    );
    Task::parse(&text).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn the_rule_of_a_cell_is_that_of_its_node() {
    for (rule, along) in [("keep", 0.2), ("in-front", 0.5)] {
        let (error, cell) = job::run(along_the_track(rule, 0.0), &mut ());
        assert_eq!(error, None, "{rule}");
        let (_, robot) = cell.robots().next().unwrap();
        let arm = arm(RobotKind::Irp6Track);
        let joints = arm.joints(robot.motor_rad()).unwrap();
        // a few increments of the track's motor
        assert!((joints[0] - along).abs() < 1e-3, "{rule}: {joints:?}");
        let tool = arm.forward(&joints).unwrap() * arm.default_tool();
        assert!((tool.position.y - 0.5).abs() < 1e-3, "{rule}: {tool:?}");
    }
}

#[test]
fn a_line_that_would_begin_with_a_jump_of_the_track_is_refused_at_rest() {
    let (error, cell) = job::run(along_the_track("in-front", 0.3), &mut ());
    let error = error.expect("a refusal").to_string();
    assert!(error.contains("irp6-track"), "{error}");
    let (_, robot) = cell.robots().next().unwrap();
    let joints = arm(RobotKind::Irp6Track).joints(robot.motor_rad()).unwrap();
    assert!(
        (joints[0] - 0.2).abs() < 1e-3 && (joints[1] - 0.3).abs() < 1e-3,
        "{joints:?}"
    );
}

#[test]
fn every_kind_works_in_one_cell() {
    let task = Task::load(
        &workspace().join("tasks/laboratory.toml"),
        &Files::on_disk(),
    )
    .unwrap();
    let mut kinds: Vec<_> = task.cell.robots.iter().map(|robot| robot.kind).collect();
    kinds.sort_by_key(|kind| kind.effector());
    assert_eq!(kinds, RobotKind::ALL, "a kind is missing in the task");
    let (error, cell) = job::run(task, &mut ());
    assert_eq!(error, None);
    assert_eq!(cell.refused(), []);
}
