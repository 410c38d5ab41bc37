//! Set-points obey position, velocity, acceleration and jerk limits at every servo step, as an
//! observer of the frames sees them: in both drive modes, in homing, in every kind of motion, in
//! every kind of stop, and in the main job.

use hil_sim::plant::random::SplitMix64;
use host::input::Files;
use host::task::Task;
use mrroc_tests::coordinator::{Coordinator, FACTOR, speeds};
use mrroc_tests::watch::{Watch, Watches};
use mrroc_tests::{job, workspace};
use protocol::fault::{Cause, Refusal};
use protocol::message::{
    Instruction, KnotMessage, NodeState, PoseMessage, PosePath, PoseReference, PoseSpeeds, Reply,
    Request, ServoLaw, Space, StopKind, WireCondition,
};
use protocol::time::Micros;
use protocol::units::PerAxis;
use robots::RobotKind;

const FRONT: [f64; 6] = [0.0, -1.57, 0.0, 1.56, 1.57, -1.57];

fn joints(target: &[f64], relative: bool, speed: f32) -> Instruction {
    Instruction::MoveJoints {
        target: target.iter().copied().collect(),
        relative,
        speeds: speeds(target.len(), speed, speed),
    }
}

fn motors(target: &[f64], speed: f32) -> Instruction {
    Instruction::MoveMotors {
        target: target.iter().copied().collect(),
        relative: true,
        speeds: speeds(target.len(), speed, speed),
    }
}

fn pose(position_m: [f64; 3], path: PosePath) -> Instruction {
    Instruction::MovePose {
        target: PoseMessage {
            position_m,
            rotation_rad: [0.0, 0.0, 0.1],
        },
        reference: PoseReference::Tool,
        path,
        speeds: PoseSpeeds {
            velocity_m_s: 0.1,
            angular_velocity_rad_s: 0.3,
            acceleration_m_s2: 0.3,
            angular_acceleration_rad_s2: 0.5,
        },
    }
}

/// Every instruction of the wire, one after the other, homed and in front.
fn every_instruction(c: &mut Coordinator) {
    c.execute(joints(&FRONT, false, 0.5));
    c.execute(joints(&[0.3, 0.1, -0.1, -0.3, 0.3, 0.4], true, 1.0));
    c.execute(motors(&[-30.0, 8.0, 5.0, -12.0, 9.0, 60.0], 1.0));
    c.execute(Instruction::MoveMotors {
        target: [5.0, 3.0, 2.0, 150.0, 140.0, 300.0].into_iter().collect(),
        relative: false,
        speeds: speeds(6, 0.7, 1.0),
    });
    c.execute(joints(&FRONT, false, 1.0));
    c.execute(joints(&[0.0, 0.0, 0.0, -0.3, 0.0, 0.0], true, 1.0));
    c.execute(pose([0.03, 0.02, -0.04], PosePath::Line));
    c.execute(pose([0.0, -0.03, 0.02], PosePath::Joint));
    c.execute(Instruction::Hold { duration_ms: 100 });
    let until = WireCondition::Settled { window_rad: 1.0 };
    c.execute(Instruction::Wait {
        until,
        timeout_ms: 5000,
    });
    let program = Instruction::Program {
        program: 9,
        argument: 0.0,
    };
    assert_eq!(
        c.begin(program),
        Reply::Refused(Refusal::UnknownProgram { program: 9 })
    );
}

/// Stops of a kind at random instants of a fast motion there and back.
fn stops(c: &mut Coordinator, kind: StopKind, random: &mut SplitMix64, times: u32) {
    for k in 0..times {
        let way = if k % 2 == 0 { 1.0 } else { -1.0 };
        let [column, lower, upper, v, n] = [0.9, 0.15, -0.12, 0.6, 0.7].map(|joint| way * joint);
        let target = [column, lower, upper, -0.5, v, n];
        assert_eq!(c.begin(joints(&target, true, 1.0)), Reply::Accepted);
        c.wait_for(NodeState::Moving);
        for _ in 0..random.next_u64() % 60 {
            c.macrostep();
        }
        c.stop(kind);
        c.recover();
        c.execute(joints(&FRONT, false, 1.0));
    }
}

/// The MP falls silent in the middle of a motion.
fn lease_loss(c: &mut Coordinator, steps: u64) {
    assert_eq!(
        c.begin(joints(&[0.9, 0.1, 0.0, -0.4, 0.5, 0.5], true, 1.0)),
        Reply::Accepted
    );
    c.wait_for(NodeState::Moving);
    for _ in 0..steps {
        c.macrostep();
    }
    c.talks = false;
    c.wait_for(NodeState::Faulted);
    assert_eq!(
        c.feedback().fault.map(|fault| fault.cause),
        Some(Cause::LeaseExpired)
    );
    c.recover();
    c.execute(joints(&FRONT, false, 1.0));
}

fn whole_life(law: ServoLaw, seed: u64, stop_count: u32) {
    let what = format!("{law:?}");
    let mut random = SplitMix64::new(seed);
    let mut c = Coordinator::new(RobotKind::Irp6Postument, law, seed);
    c.enable();
    c.execute(motors(&[8.0, -5.0, 4.0, 6.0, -3.0, 10.0], 0.5));
    assert_eq!(
        c.begin(motors(&[30.0, 0.0, 0.0, 0.0, 0.0, 0.0], 0.5)),
        Reply::Accepted
    );
    c.wait_for(NodeState::Moving);
    c.stop(StopKind::Path);
    c.recover();
    c.home();
    every_instruction(&mut c);
    stops(&mut c, StopKind::Path, &mut random, stop_count);
    stops(&mut c, StopKind::Quick, &mut random, stop_count);
    lease_loss(&mut c, random.next_u64() % 40);
    c.watch.assert_kept(&what);
    assert_eq!(c.feedback().limit_violations, 0, "{what}");
    assert_eq!(c.cell.refused(), [], "{what}");
    // it was really looked at, and really moved
    let fastest = c
        .watch
        .worst()
        .iter()
        .map(|w| w.velocity)
        .fold(0.0, |a, b| if b > a { b } else { a });
    assert!(fastest > 0.5, "{what}: {:?}", c.watch.worst());
}

#[test]
fn drives_that_close_the_position_loop() {
    whole_life(ServoLaw::DrivePosition, 11, 4);
}

#[test]
fn the_original_regulator() {
    whole_life(ServoLaw::Original, 12, 2);
}

#[test]
fn the_feed_forward_regulator() {
    whole_life(ServoLaw::FeedForward, 13, 2);
}

#[test]
fn a_stop_in_every_part_of_homing() {
    let mut random = SplitMix64::new(14);
    let mut c = Coordinator::new(RobotKind::Irp6Postument, ServoLaw::DrivePosition, 14);
    c.enable();
    for kind in [StopKind::Path, StopKind::Quick, StopKind::Path] {
        c.accepted(|epoch| Request::Synchronise { epoch });
        c.wait_for(NodeState::Synchronising);
        for _ in 0..20 + random.next_u64() % 150 {
            c.macrostep();
        }
        c.stop(kind);
        c.recover();
    }
    c.home();
    c.watch.assert_kept("homing with stops");
}

/// A rest-to-rest motion of least jerk as knots; the second axis goes the other way.
fn knots(from: &[f64], span: f64, count: u32, whole: bool) -> Vec<KnotMessage> {
    let period = f64::from(count) * 0.02;
    (1..=count)
        .map(|k| {
            let s = f64::from(k) / f64::from(count);
            let p = s * s * s * (10.0 + s * (-15.0 + s * 6.0));
            let v = s * s * (30.0 + s * (-60.0 + s * 30.0)) / period;
            let a = s * (60.0 + s * (-180.0 + s * 120.0)) / (period * period);
            let way = |axis: usize| if axis == 1 { -0.2 * span } else { span };
            let each = || (0..from.len()).map(way);
            KnotMessage {
                at: Micros(0),
                space: Space::Motors,
                position: from
                    .iter()
                    .zip(each())
                    .map(|(from, way)| from + way * p)
                    .collect(),
                velocity: each().map(|way| narrow(way * v)).collect(),
                acceleration: if whole {
                    each().map(|way| narrow(way * a)).collect()
                } else {
                    PerAxis::new()
                },
            }
        })
        .collect()
}

#[expect(clippy::cast_possible_truncation, reason = "what travels has 32 bits")]
fn narrow(value: f64) -> f32 {
    value as f32
}

/// Follows knots; the greatest jerk of the column, rad/s³.
fn follow(c: &mut Coordinator, span: f64, count: u32, whole: bool) -> f64 {
    let unit = |axis: usize| {
        let turn = if axis == 5 { 2000.0 } else { 4000.0 };
        core::f64::consts::TAU / (turn * 1000.0)
    };
    let demand = c.feedback().demand.clone();
    let from: Vec<f64> = demand
        .iter()
        .enumerate()
        .map(|(axis, units)| f64::from(i32::try_from(*units).unwrap()) * unit(axis))
        .collect();
    let knots = knots(&from, span, count, whole);
    c.watch.forget_worst();
    c.follow(|k| knots.get(usize::try_from(k).unwrap() - 1).cloned());
    c.watch.jerk_rad_s3(0)
}

#[test]
fn knots_are_joined_without_steps_of_velocity_or_acceleration() {
    let mut c = Coordinator::new(RobotKind::Irp6Postument, ServoLaw::DrivePosition, 15);
    c.enable();
    c.home();
    c.execute(joints(&FRONT, false, 1.0));
    let (span, count) = (10.0, 75);
    let period = f64::from(count) * 0.02;
    // least jerk: 60·D/T³ at both ends; third differences never exceed the greatest derivative
    let derivative = 60.0 * span / (period * period * period);
    // resolution of the column: 4q/Ts³, and q/Ts³ for what the knots lose as f32
    let resolution = 5.0 * core::f64::consts::TAU / 4.0e6 / (0.002 * 0.002 * 0.002);
    let seen = follow(&mut c, span, count, true);
    assert!(
        seen < derivative + resolution,
        "{seen} > {derivative} + {resolution}"
    );
    // without acceleration, segments are cubic: continuous in velocity, steps of acceleration. For
    // the same knots these are at most h²/6 times the fourth derivative, 360·D/T⁴, for each side.
    let seen = follow(&mut c, -span, count, false);
    let step = 2.0 * 0.02 * 0.02 / 6.0 * 360.0 * span / (period * period * period * period);
    assert!(
        seen < derivative + resolution + step / 0.002,
        "{seen}: {step}"
    );
    c.watch.assert_kept("knots");
    assert_eq!(c.feedback().fault, None);
    assert_eq!(c.feedback().limit_violations, 0);
}

#[test]
fn the_main_job() {
    let task = Task::load(&workspace().join("tasks/two-arms.toml"), &Files::on_disk()).unwrap();
    let mut first_bus = 1;
    let mut watches = Vec::new();
    for (spec, j) in task.cell.robots.iter().zip([1, 2]) {
        let mut buses = vec![0; spec.axes()];
        for (number, group) in (0_u8..).zip(&spec.drives) {
            group.axes.iter().for_each(|axis| buses[*axis] = number);
        }
        assert!((spec.velocity_factor - FACTOR).abs() < 1e-12);
        watches.push(Watch::new(
            spec.kind, j, spec.servo, FACTOR, first_bus, &buses,
        ));
        first_bus += spec.drives.len();
    }
    let mut watches = Watches(watches);
    let (error, cell) = job::run(task, &mut watches);
    assert_eq!(error, None);
    assert!(cell.now().as_secs_f64() > 60.0);
    for watch in &watches.0 {
        watch.assert_kept("the main job");
    }
}
