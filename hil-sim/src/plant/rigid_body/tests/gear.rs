//! Gears that give.

use super::*;
use crate::plant::gear::{Gear, GearError};

/// Without friction and stops; brakes hold.
fn smooth_axes(p: &mut PlantParameters) {
    (p.viscous_nms_rad, p.coulomb_nm) = (0.0, 0.0);
    p.stop_rad = [f64::NEG_INFINITY, f64::INFINITY];
}

/// The last axis of a Polycrank, its rotor free and all others braked, on a spring without damping.
fn rolling(stiffness_nm_rad: f64) -> (Arm<Polycrank, 7>, [Drive; 7]) {
    let mut arm = Arm::new(Polycrank, RobotKind::Polycrank, &SWING, DT, smooth_axes);
    let gear = Gear {
        stiffness_nm_rad,
        damping_nms_rad: 0.0,
        backlash_rad: 0.0,
    };
    arm.body.set_gear(6, Some(gear)).unwrap();
    let mut commands = [Drive::default(); 7];
    commands[6] = OPEN;
    arm.run(0.1, &commands);
    (arm, commands)
}

#[test]
fn rotor_and_links_swing_against_each_other_as_two_masses_do() {
    let stiffness = 2.0;
    let (mut arm, commands) = rolling(stiffness);
    let rotor = Polycrank.description().axes[6].motor.rotor_kg_m2;
    let transmission = Polycrank.transmission(&SWING).unwrap();
    let all = transmission.mass_matrix(&arm.body.loaded.at(&SWING).mass_matrix());
    let links = all[(6, 6)] - rotor;
    let omega = libm::sqrt(stiffness * (1.0 / rotor + 1.0 / links));
    let twist =
        |arm: &Arm<Polycrank, 7>| arm.plants[6].angle_rad() - arm.body.links_rad(6).unwrap();
    let angle = arm.plants[6].angle_rad();
    arm.plants[6].moved(angle + 0.1, 0.0);
    let begin = twist(&arm);
    let (mut crossings, mut first, mut last, mut most) = (0_u32, 0.0, 0.0, 0.0_f64);
    let mut before = begin;
    for step in 0..4000_u32 {
        arm.run(DT, &commands);
        let now = twist(&arm);
        if before > 0.0 && now <= 0.0 {
            last = f64::from(step) + before / (before - now);
            first = if crossings == 0 { last } else { first };
            crossings += 1;
        }
        if step > 3000 && now > most {
            most = now;
        }
        before = now;
    }
    let measured = core::f64::consts::TAU * f64::from(crossings - 1) / ((last - first) * DT);
    // drift-kick-drift swings faster by (ω·dt)²/24: 1.4e-3 here
    let wx = omega * DT;
    let expected = omega * (1.0 + wx * wx / 24.0);
    println!("{omega} {measured} rad/s after {crossings} periods");
    assert!(crossings >= 20 && (measured / expected - 1.0).abs() < 1e-3);
    // neither grows nor fades, but for where in a period it is sampled: 1 − cos(ω·dt/2)
    assert!((most / begin - 1.0).abs() < wx * wx, "{most} {begin}");
}

#[test]
fn links_hang_on_the_loaded_flank() {
    let mut arm = postument(|p| p.coulomb_nm = 0.0);
    let gear = Gear {
        stiffness_nm_rad: 5.0,
        damping_nms_rad: 0.05,
        backlash_rad: 0.02,
    };
    arm.body.set_gear(1, Some(gear)).unwrap();
    let start = arm.motion().position.0;
    arm.run(3.0, &[Drive::default(); 6]);
    let links = arm.body.links_rad(1).unwrap();
    let mut sagged = start;
    sagged[1] = links;
    let joints = Irp6Postument.joints(&Motors(sagged)).unwrap();
    let transmission = Irp6Postument.transmission(&joints).unwrap();
    let posture = arm.body.loaded.at(&joints);
    let weight = transmission.motor_torques(&posture.gravity_torques(&STANDARD_GRAVITY))[1];
    // the brake holds the rotor, and the weight what it must be overcome with
    assert_eq!(arm.plants[1].angle_rad().to_bits(), start[1].to_bits());
    let sag = weight / 5.0 + weight.signum() * 0.01;
    assert!(weight.abs() > 0.05, "{weight}");
    assert!(
        (start[1] - links - sag).abs() < 1e-8,
        "{} {sag}",
        start[1] - links
    );
    assert!(arm.body.links_rad(0).is_none());
}

#[test]
fn without_its_gear_an_axis_is_rigid_again() {
    let (mut arm, commands) = rolling(2.0);
    arm.body.set_gear(6, None).unwrap();
    arm.run(0.01, &commands);
    assert!(arm.body.links_rad(6).is_none());
    let bad = Gear {
        stiffness_nm_rad: f64::INFINITY,
        damping_nms_rad: 0.0,
        backlash_rad: 0.0,
    };
    assert_eq!(arm.body.set_gear(7, None), Err(GearError::Axis));
    assert_eq!(arm.body.set_gear(0, Some(bad)), Err(GearError::Number));
    let stiff = Gear {
        stiffness_nm_rad: 1e9,
        ..bad
    };
    assert_eq!(arm.body.set_gear(0, Some(stiff)), Err(GearError::Stiff));
}

#[test]
fn a_stop_ends_the_links_and_the_rotor_winds_up_the_spring() {
    let mut arm = postument(|p| p.coulomb_nm = 0.0);
    let gear = Gear {
        stiffness_nm_rad: 5.0,
        damping_nms_rad: 0.05,
        backlash_rad: 0.0,
    };
    arm.body.set_gear(1, Some(gear)).unwrap();
    let mut commands = [OPEN; 6];
    commands[1].torque_nm = -2.0;
    arm.run(4.0, &commands);
    let stop = arm.plants[1].parameters().stop_rad[0];
    let links = arm.body.links_rad(1).unwrap();
    let wound = links - arm.plants[1].angle_rad();
    assert!((links - stop).abs() < 1e-12, "{links} {stop}");
    // the torque of the greatest current, which is less than the 2 N·m demanded, on 5 N·m/rad
    let p = arm.plants[1].parameters();
    let expected = p.current_limit_a * p.torque_constant_nm_a / 5.0;
    assert!((wound - expected).abs() < 1e-6, "{wound} {expected}");
}
