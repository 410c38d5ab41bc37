//! The force sensor in the wrist: motions that end at a force, and what happens without it.

use super::*;
use hil_sim::plant::contact::{Obstacle, Shape, Surface, Tip};
use hil_sim::plant::force_sensor::ForceFault;
use hil_sim::plant::robot::SimRobot;
use protocol::force_torque::SensorNumber;
use protocol::message::{PoseMessage, PosePath, PoseReference, PoseSpeeds};

const STIFFNESS_N_M: f64 = 1.0e4;
const SPEED_M_S: f32 = 0.01;
const NEWTONS: f32 = 10.0;
/// How far the surface is from the tip at the start, m.
const GAP_M: f64 = 0.005;

/// The postument with a sensor on a bus of its own, homed and away from its limits.
fn ready() -> Coordinator {
    let force = ForceAddress {
        bus: 1,
        number: SensorNumber::new(0).unwrap(),
    };
    let (kind, law) = (RobotKind::Irp6Postument, ServoLaw::DrivePosition);
    let mut c = Coordinator::wired(kind, law, Quirks::default(), Some(force));
    c.enable();
    c.home();
    let done = c.execute(Instruction::MoveJoints {
        target: [0.0, -1.57, 0.0, 1.56, 1.57, -1.57].into_iter().collect(),
        relative: false,
        speeds: speeds(6, 0.2),
    });
    assert_eq!(done.progress, Progress::Done, "{done:?}");
    c
}

fn robot(c: &mut Coordinator) -> &mut SimRobot {
    c.cell.robot_mut(0).unwrap()
}

/// Puts a surface before the tip, across the tool's z.
fn before_the_tip(c: &mut Coordinator) {
    let centre_m = robots::Robot::<6>::description(&robots::Irp6Postument)
        .default_tool()
        .position;
    let flange = robot(c).wrist().unwrap().flange;
    let along = flange.rotation.column(2).into_owned();
    let tip = flange.position + flange.rotation * centre_m;
    let wall = Obstacle {
        shape: Shape::HalfSpace {
            point: tip + along * GAP_M,
            normal: -along,
        },
        surface: Surface {
            stiffness_n_m: STIFFNESS_N_M,
            ..Surface::METAL
        },
    };
    let tip = Tip {
        centre_m,
        radius_m: 0.0,
    };
    assert!(robot(c).surround(vec![wall], tip));
}

/// Along the tool's z.
fn ahead(metres: f64) -> PoseMessage {
    PoseMessage {
        position_m: [0.0, 0.0, metres],
        rotation_rad: [0.0; 3],
    }
}

fn slowly() -> PoseSpeeds {
    PoseSpeeds {
        velocity_m_s: SPEED_M_S,
        angular_velocity_rad_s: 0.1,
        acceleration_m_s2: 0.1,
        angular_acceleration_rad_s2: 0.1,
    }
}

fn until_force() -> Instruction {
    Instruction::MoveUntilForce {
        target: ahead(0.03),
        reference: PoseReference::Tool,
        speeds: slowly(),
        newtons: NEWTONS,
    }
}

fn line() -> Instruction {
    Instruction::MovePose {
        target: ahead(0.03),
        reference: PoseReference::Tool,
        path: PosePath::Line,
        speeds: slowly(),
    }
}

/// The force the surface exerts, N.
fn push_n(c: &mut Coordinator) -> f64 {
    robot(c)
        .wrist()
        .unwrap()
        .touch
        .map_or(0.0, |(f, _)| libm::sqrt(f.dot(&f)))
}

#[test]
fn a_motion_ends_where_the_force_says_and_no_farther_than_its_reaction() {
    let mut c = ready();
    before_the_tip(&mut c);
    let before = robot(&mut c).wrist().unwrap().flange;
    let done = c.execute(until_force());
    assert_eq!(
        (done.progress, done.state),
        (Progress::Done, NodeState::Holding),
        "{done:?}"
    );
    for _ in 0..25 {
        c.macrostep(&mut ());
    }
    let pushed = push_n(&mut c);
    let way = robot(&mut c).wrist().unwrap().flange.position - before.position;
    let along = before.rotation.column(2).into_owned();
    let aside = way - along * way.dot(&along);
    let aside_m = libm::sqrt(aside.dot(&aside));
    println!("{pushed:.2} N, {:.0} um beside its line", aside_m * 1e6);
    // the surface gives k·v = 0.1 N a millisecond. Until it is seen: half a sample of the mean of two, up to a sample, and
    // frames and servo step, 0.5 to 2.5 ms; the set-points are 4.4 ms ahead of the arm (44 µm); of the stop half: with motors
    // at up to 10 rad/s and 60 000 rad/s³ 2·√(v/j), 5 to 26 ms. Drives and friction give or take half a newton
    let per_ms = STIFFNESS_N_M * f64::from(SPEED_M_S) * 1e-3;
    let least = f64::from(NEWTONS) + per_ms * (1.0 + 0.0 + 0.5 + 4.4 + 2.5) - 0.5;
    let most = f64::from(NEWTONS) + per_ms * (1.0 + 2.0 + 2.5 + 4.4 + 13.0) + 0.5;
    assert!(
        (least..most).contains(&pushed),
        "{pushed} of {least} to {most}"
    );
    // each axis stops by itself, and none goes on for longer than 26 ms: half of that at 0.01 m/s, and 44 um of csp
    assert!(aside_m < 0.175e-3, "{aside_m} m");
    // what is told is near to it, weight and bias apart
    let told = c.feedback.as_ref().unwrap().force_n;
    assert!(told.is_some());
}

#[test]
fn a_motion_that_meets_nothing_ends_where_it_should() {
    let mut c = ready();
    let before = robot(&mut c).wrist().unwrap().flange.position;
    let done = c.execute(until_force());
    assert_eq!(done.progress, Progress::Done, "{done:?}");
    let way = robot(&mut c).wrist().unwrap().flange.position - before;
    // 44 µm is what csp is off its way at speed
    assert!((libm::sqrt(way.dot(&way)) - 0.03).abs() < 1e-4, "{way:?}");
}

/// What comes of a motion when the sensor is broken in its middle.
fn broken(instruction: Instruction, fault: ForceFault) -> Feedback {
    let mut c = ready();
    let request = Request::Execute {
        epoch: c.epoch,
        id: 77,
        start_at: Micros(0),
        instruction,
    };
    assert_eq!(c.request(&request), Reply::Accepted);
    c.wait("moving", 2.0, |f| f.state == NodeState::Moving);
    for _ in 0..25 {
        c.macrostep(&mut ());
    }
    let onset = c.cell.now();
    assert!(robot(&mut c).break_force_sensor(Some(fault)));
    c.wait("stopping", 1.0, |f| f.fault.is_some());
    let seen = c.feedback.clone().unwrap();
    let found = seen.fault.unwrap();
    assert_eq!(
        (found.cause, found.during),
        (Cause::ForceSensor, NodeState::Moving),
        "{fault:?}"
    );
    // a sample that is none: three periods of the sensor until the last one is too old, a servo step, and this test's own
    // macrostep; one that is frozen: fifty more samples
    let (least, most) = match fault {
        ForceFault::Frozen => (100_000, 130_000),
        _ => (0, 30_000),
    };
    let took = seen.sampled_at.since(onset).0;
    assert!((least..=most).contains(&took), "{fault:?}: {took} us");
    c.wait("faulted", 2.0, |f| f.state == NodeState::Faulted);
    for _ in 0..10 {
        c.macrostep(&mut ());
    }
    c.feedback.clone().unwrap()
}

#[test]
fn without_its_sensor_a_robot_stops_on_its_path() {
    for fault in [ForceFault::Silent, ForceFault::Frozen] {
        let holding = broken(line(), fault);
        // torque on: the motors carry the arm
        assert!(
            holding.current_ma.iter().any(|ma| ma.abs() > 100),
            "{fault:?}: {holding:?}"
        );
    }
}

#[test]
fn whatever_is_wrong_with_its_sensor_a_robot_that_feels_its_way_stops_quickly() {
    for fault in ForceFault::ALL {
        let off = broken(until_force(), fault);
        assert!(
            off.current_ma.iter().all(|ma| ma.abs() <= 100),
            "{fault:?}: {off:?}"
        );
        assert_eq!(off.force_n, None);
    }
}

#[test]
fn a_motion_until_a_force_needs_a_sensor() {
    let mut c = ready();
    robot(&mut c).set_force_node(None);
    c.macrostep(&mut ());
    let request = Request::Execute {
        epoch: c.epoch,
        id: 77,
        start_at: Micros(0),
        instruction: until_force(),
    };
    assert_eq!(c.request(&request), Reply::Refused(Refusal::NoForce));
    assert_eq!(c.state(), Some(NodeState::Holding));
}
