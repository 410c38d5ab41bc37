//! Figures computed from MRROC++'s published constants, by hand and by another program.

use robots::{ASSUMED, Irp6Postument, Irp6Track, JointKind, Joints, Motors, Robot, RobotKind};

use super::apart;

/// MRROC++ configuration `common.ini`: the "front" position of the operator's panel.
const FRONT_POSTUMENT: Joints<6> = Joints([0.0, -1.57, 0.0, 1.56, 1.57, -1.57]);
const FRONT_TRACK: Joints<7> = Joints([0.0, 0.0, -1.57, 0.0, 1.56, 1.57, -1.57]);

#[test]
fn homed_pose() {
    let p = Irp6Postument.joints(&Motors([0.0; 6])).unwrap();
    // four printed digits
    assert!(
        apart(&p.0, &[-0.1006, -1.5419, 0.0197, 1.1335, 3.6971, -2.7381]) < 6e-5,
        "{p:?}"
    );
    Irp6Postument.check_joints(&p).unwrap();
    let ot = Irp6Track::KEEP.joints(&Motors([0.0; 7])).unwrap();
    assert!(
        apart(
            &ot.0,
            &[0.0, -0.0685, -1.5477, 0.0123, 1.2067, 4.1732, -2.6644]
        ) < 6e-5,
        "{ot:?}"
    );
    Irp6Track::KEEP.check_joints(&ot).unwrap();
}

#[test]
fn front_pose_motors() {
    let p = Irp6Postument.motors(&FRONT_POSTUMENT).unwrap();
    // three printed digits
    assert!(
        apart(&p.0, &[-15.9, -4.862, -8.387, -48.472, 114.892, 337.451]) < 6e-4,
        "{p:?}"
    );
    Irp6Postument.check_motors(&p).unwrap();
    let ot = Irp6Track::KEEP.motors(&FRONT_TRACK).unwrap();
    assert!(
        apart(
            &ot.0,
            &[0.0, -10.819, -3.874, -6.079, -40.785, 159.142, 316.151]
        ) < 6e-4,
        "{ot:?}"
    );
    Irp6Track::KEEP.check_motors(&ot).unwrap();
}

#[test]
fn front_pose_flange() {
    for flange in [
        Irp6Postument.forward(&FRONT_POSTUMENT),
        Irp6Track::KEEP.forward(&FRONT_TRACK),
    ] {
        let position: [f64; 3] = flange.position.into();
        assert!(
            apart(&position, &[0.6723, 0.0, 0.2645]) < 6e-5,
            "{position:?}"
        );
    }
}

#[test]
fn tool_and_base() {
    let d = Irp6Postument.description();
    let tip = Irp6Postument.forward(&FRONT_POSTUMENT) * d.default_tool();
    let world = d.base() * tip;
    // the front pose points the tool along +x: 0.6723 + 0.25 less what 0.01 rad of T take
    let expected = [0.6723 + 0.25 - 0.0728, 2.1063, 0.2645 - 0.0302];
    let position: [f64; 3] = world.position.into();
    assert!(apart(&position, &expected) < 3e-3, "{position:?}");
}

#[test]
fn descriptions_are_complete() {
    fn complete<const N: usize>(robot: &impl Robot<N>, kind: RobotKind) {
        let d = robot.description();
        assert_eq!(d.name, kind.name());
        assert_eq!(N, kind.axes());
        assert_eq!((d.servo_step_us, d.macrostep), (2000, 10));
        let mut order = d.homing.order;
        order.sort_unstable();
        assert_eq!(order, core::array::from_fn(|k| k));
        for axis in &d.axes {
            assert!(
                axis.joint_position.lower < axis.joint_position.upper,
                "{}",
                axis.name
            );
            assert!(
                axis.motor_position.lower < axis.motor_position.upper,
                "{}",
                axis.name
            );
            // homing ends inside the range
            assert!(axis.motor_position.contains(0.0), "{}", axis.name);
            let r = axis.pwm_regulator;
            assert!(r.epsilon > 0.0 && r.a > 0.0 && r.a < 1.0 && r.b0 > r.b1 && r.b1 > 0.0);
            let c = axis.current_regulator;
            assert!(c.gain_ma > 0.0 && c.limit_ma >= 1000.0);
            assert_eq!(
                axis.increments_per_turn,
                if axis.name == "N" { 2000 } else { 4000 }
            );
            assert_eq!(axis.kind == JointKind::Prismatic, axis.name == "track");
            assert!(axis.planning_limits.velocity < axis.hard_limits.velocity);
            assert!(axis.planning_limits.acceleration < axis.hard_limits.acceleration);
            assert!(axis.planning_limits.jerk < axis.hard_limits.jerk);
        }
    }
    complete(&Irp6Postument, RobotKind::Irp6Postument);
    complete(&Irp6Track::KEEP, RobotKind::Irp6Track);
    assert_eq!(Irp6Track::KEEP.description().homing.order[0], 2);
    assert_eq!(Irp6Postument.description().homing.order[0], 1);
}

#[test]
fn names_are_found_and_unknown_ones_explained() {
    for kind in RobotKind::ALL {
        assert_eq!(RobotKind::from_name(kind.name()), Ok(kind));
    }
    let text = RobotKind::from_name("irp7").unwrap_err().to_string();
    assert_eq!(
        text,
        "unknown robot \"irp7\"; known: irp6-track, irp6-postument, polycrank, irp6-arm, \
         conveyor, irp6-track-gripper, irp6-postument-gripper, rnt"
    );
}

#[test]
fn every_assumed_number_is_listed_with_a_reason() {
    let axis = Irp6Track::KEEP.description().axes[0];
    for value in [
        axis.hard_limits.acceleration,
        axis.hard_limits.jerk,
        axis.planning_limits.jerk,
        robots::VELOCITY_SHARE,
        robots::CURVATURE_SHARE,
    ] {
        assert!(
            ASSUMED.iter().any(|a| a.value.to_bits() == value.to_bits()),
            "{value}"
        );
    }
    assert!(
        ASSUMED
            .iter()
            .all(|a| !a.item.is_empty() && !a.unit.is_empty() && a.why.len() > 10)
    );
}
