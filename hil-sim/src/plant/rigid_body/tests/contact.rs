//! An arm that touches something.

use super::*;
use crate::plant::contact::{Obstacle, Shape as Body3, Surface, Tip};

const TIP: Tip = Tip {
    centre_m: Vector3::new(0.0, 0.0, 0.1),
    radius_m: 0.005,
};

/// Where the tip's centre is, and how it moves, in the base frame.
fn tip(arm: &Arm<Polycrank, 7>) -> (Vector3<f64>, Vector3<f64>) {
    let motion = arm.motion();
    let joints = arm.body.robot.joint_motion(&motion).unwrap();
    let flange = Polycrank.forward(&joints.position);
    let lever = flange.rotation * TIP.centre_m;
    let twist = Polycrank.jacobian(&joints.position) * nalgebra::SVector::from(joints.velocity);
    let turn = Vector3::new(twist[3], twist[4], twist[5]);
    let velocity = Vector3::new(twist[0], twist[1], twist[2]) + turn.cross(&lever);
    (flange.position + lever, velocity)
}

/// A Polycrank above a table it is going to fall on.
fn above_a_table(change: impl Fn(&mut PlantParameters), surface: Surface) -> Arm<Polycrank, 7> {
    let mut arm = Arm::new(Polycrank, RobotKind::Polycrank, &SWING, DT, change);
    let (centre, _) = tip(&arm);
    let table = Obstacle {
        shape: Body3::HalfSpace {
            point: centre - Vector3::new(0.0, 0.0, 0.03),
            normal: Vector3::z(),
        },
        surface,
    };
    assert!(arm.body.surround(vec![table], TIP));
    arm
}

#[test]
fn an_arm_that_falls_on_a_table_rests_on_it_with_its_weight() {
    let mut arm = above_a_table(
        |p| {
            (p.viscous_nms_rad, p.coulomb_nm) = (0.5, 0.0);
        },
        Surface {
            friction: 0.0,
            ..Surface::METAL
        },
    );
    // only the fourth crank is free
    let mut commands = [Drive::default(); 7];
    commands[3] = OPEN;
    arm.run(4.0, &commands);
    let (force, at) = arm.body.surroundings.as_ref().unwrap().felt.unwrap();
    let joints = Polycrank.joints(&arm.motion().position).unwrap();
    let weight = arm
        .body
        .loaded
        .at(&joints)
        .gravity_torques(&STANDARD_GRAVITY)[3];
    let jacobian = Polycrank.jacobian(&joints);
    let turn = Vector3::new(jacobian[(3, 3)], jacobian[(4, 3)], jacobian[(5, 3)]);
    let flange = Polycrank.forward(&joints).position;
    let linear = Vector3::new(jacobian[(0, 3)], jacobian[(1, 3)], jacobian[(2, 3)]);
    let lever = linear + turn.cross(&(at - flange));
    // J'·f holds the weight; what is left of the motion after 4 s is less than a part in a million
    let held = lever.dot(&force);
    println!("{} N hold {weight} N·m", force.z);
    assert!(
        weight.abs() > 1.0 && (held - weight).abs() < 1e-5 * weight.abs(),
        "{held} {weight}"
    );
    assert!(force.z > 5.0 && force.x.abs() < 1e-9 && force.y.abs() < 1e-9);
}

#[test]
fn contact_takes_energy_only_and_friction_opposes_the_motion() {
    let mut arm = above_a_table(frictionless, Surface::METAL);
    let begin: f64 = arm.energy().iter().sum();
    let (mut touched, mut slid) = (0, 0);
    let mut deepest = 0.0;
    for _ in 0..8000 {
        arm.run(DT, &[OPEN; 7]);
        let energy: f64 = arm.energy().iter().sum();
        // the spring holds the rest; what the explicit spring is off by is a part in a thousand of an impact's energy
        assert!(energy < begin + 1e-3, "{energy} {begin}");
        if let Some((force, _)) = arm.body.surroundings.as_ref().unwrap().felt {
            let (_, velocity) = tip(&arm);
            let along = force.x * velocity.x + force.y * velocity.y;
            let speed = libm::hypot(velocity.x, velocity.y);
            // force and velocity are half a substep apart, which is seen where the tip is about to turn back
            assert!(along < 1e-6 || speed < 1e-2, "{along} {velocity}");
            assert!(force.z >= 0.0);
            slid += usize::from(along < -1e-3);
            touched += 1;
            deepest = if force.z > deepest { force.z } else { deepest };
        }
    }
    println!("{touched} substeps of touch, {slid} sliding, {deepest} N at most");
    assert!(touched > 100 && slid > 10 && deepest > 20.0);
    let end: f64 = arm.energy().iter().sum();
    assert!(
        end < begin - 0.5,
        "impacts and friction took some: {begin} {end}"
    );
}

#[test]
fn a_tip_that_touches_nothing_changes_nothing() {
    let mut alone = hanging(DT, 2);
    let mut beside = hanging(DT, 2);
    let far = Obstacle {
        shape: Body3::HalfSpace {
            point: Vector3::new(0.0, 0.0, -10.0),
            normal: Vector3::z(),
        },
        surface: Surface::METAL,
    };
    assert!(beside.body.surround(vec![far], TIP));
    alone.run(0.5, &[OPEN; 7]);
    beside.run(0.5, &[OPEN; 7]);
    assert_eq!(
        alone.motion().position.0.map(f64::to_bits),
        beside.motion().position.0.map(f64::to_bits)
    );
    let wrist = beside.body.wrist(&beside.plants).unwrap();
    assert_eq!(wrist.touch, None);
    assert_eq!(wrist.gravity, STANDARD_GRAVITY);
}
