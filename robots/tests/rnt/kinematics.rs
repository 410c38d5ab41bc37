//! Forward kinematics, Jacobian and the description.

use motion::pose::{exp, log};
use nalgebra::Vector3;
use proptest::prelude::*;
use robots::rnt::HOME;
use robots::{ASSUMED, AxisDescription, AxisHoming, JointKind, Joints, Motors, Rnt, Robot};

use super::{apart, platform, within_limits};

proptest! {
    #[test]
    fn forward_is_the_chain_of_turns(unit in prop::array::uniform6(0.0..1.0f64)) {
        let q = within_limits(&unit);
        let [ty, tx, reach, w1, w2, w3] = q.0;
        let base = platform(ty, tx);
        let mount = exp(Vector3::y() * 120.0_f64.to_radians());
        let wrist = exp(Vector3::z() * w1) * exp(Vector3::y() * w2) * exp(Vector3::z() * w3);
        let pose = Rnt.forward(&q);
        prop_assert!((pose.position - base * Vector3::new(0.0, 0.0, -reach - 0.12)).norm() < 1e-14);
        prop_assert!((pose.rotation - base * mount * wrist).norm() < 1e-14);
    }

    #[test]
    fn the_jacobian_is_the_derivative_of_forward(unit in prop::array::uniform6(0.0..1.0f64)) {
        let q = within_limits(&unit);
        let jacobian = Rnt.jacobian(&q);
        let h = 1e-6;
        for k in 0..6 {
            let moved = |by: f64| {
                let mut q = q;
                q.0[k] += by;
                Rnt.forward(&q)
            };
            let (minus, plus) = (moved(-h), moved(h));
            let linear = (plus.position - minus.position) / (2.0 * h);
            let angular = log(&(plus.rotation * minus.rotation.transpose())) / (2.0 * h);
            let column = jacobian.column(k);
            // rounding, 1e-16 over h, and h²
            prop_assert!((linear - column.fixed_rows::<3>(0)).norm() < 1e-9, "{k}");
            prop_assert!((angular - column.fixed_rows::<3>(3)).norm() < 1e-9, "{k}");
        }
    }
}

#[test]
fn the_central_leg_is_where_the_published_check_has_it() {
    let q = Joints([
        (-10.0_f64).to_radians(),
        20.0_f64.to_radians(),
        1.0,
        0.3,
        0.2,
        0.1,
    ]);
    let wrist: [f64; 3] = Rnt.forward(&q).position.into();
    let expected = [0.163_176, 0.342_020, -0.925_417].map(|c: f64| c * 1.12);
    // six printed digits
    assert!(apart(&wrist, &expected) < 6e-7, "{wrist:?}");
}

#[test]
fn at_home_the_spindle_points_down() {
    let d = Rnt.description();
    let tip = Rnt.forward(&HOME) * d.default_tool();
    let position: [f64; 3] = tip.position.into();
    assert!(apart(&position, &[0.0, 0.0, -1.1 - 0.12 - 0.15]) < 1e-15);
    assert!((tip.rotation.column(2) + Vector3::z()).norm() < 1e-15);
    let motors = Rnt.motors(&HOME).unwrap();
    Rnt.check_motors(&motors).unwrap();
    Rnt.check_joints(&HOME).unwrap();
    // (1.12805 − 0.86) m of 10 mm a turn; six printed digits
    for m in &motors.0[..3] {
        assert!(
            (m - 0.268_051_4 / 0.010 * core::f64::consts::TAU).abs() < 5e-5,
            "{m}"
        );
    }
    // as many motor turns as the gear from 5° above the lower limits
    for (m, degrees) in motors.0[3..].iter().zip([165.0_f64, 105.0 + 60.0, 345.0]) {
        assert!((m - 100.0 * degrees.to_radians()).abs() < 1e-10, "{m}");
    }
}

#[test]
fn homing_ends_with_the_legs_retracted_and_the_wrist_near_its_lower_limits() {
    let zero = Motors([0.0; 6]);
    Rnt.check_motors(&zero).unwrap();
    let q = Rnt.joints(&zero).unwrap();
    Rnt.check_joints(&q).unwrap();
    let reach = libm::sqrt(0.86 * 0.86 - 0.25 * 0.25);
    let expected = [0.0, 0.0, reach, -165.0, -105.0, -345.0];
    for (k, (q, expected)) in q.0.iter().zip(expected).enumerate() {
        let expected: f64 = expected;
        let expected = if k < 3 {
            expected
        } else {
            expected.to_radians()
        };
        assert!((q - expected).abs() < 1e-12, "{k}: {q}");
    }
    // from there to the limits: legs from 0.60 m to 1.60 m, the wrist from 5° below
    for (k, axis) in Rnt.description().axes.iter().enumerate() {
        let range = axis.motor_position;
        let (lower, upper) = match k {
            0..3 => (-0.26, 0.74),
            3 => (-5.0, 335.0),
            4 => (-5.0, 215.0),
            _ => (-5.0, 695.0_f64),
        };
        let scale = if k < 3 {
            core::f64::consts::TAU / 0.010
        } else {
            1.0_f64.to_radians() * 100.0
        };
        assert!((range.lower - lower * scale).abs() < 1e-9, "{k} {range:?}");
        assert!((range.upper - upper * scale).abs() < 1e-9, "{k} {range:?}");
    }
}

#[test]
fn the_straight_way_of_the_motors_from_homing_to_home_is_free() {
    let home = Rnt.motors(&HOME).unwrap();
    for step in 0..=100 {
        let on_way = Motors(home.0.map(|m| m * f64::from(step) / 100.0));
        let joints = Rnt.joints(&on_way).unwrap();
        Rnt.check_joints(&joints).unwrap();
        Rnt.check_motors(&on_way).unwrap();
    }
}

#[test]
fn the_description_is_complete() {
    let d = Rnt.description();
    assert_eq!((d.name, d.servo_step_us, d.macrostep), ("rnt", 1000, 20));
    assert!(d.long_name.contains("assumed"));
    let mut order = d.homing.order;
    order.sort_unstable();
    assert_eq!(order, core::array::from_fn(|k| k));
    for (k, axis) in d.axes.iter().enumerate() {
        assert!(axis.motor_position.contains(0.0));
        assert!(axis.joint_position.lower < axis.joint_position.upper);
        assert_eq!(axis.kind == JointKind::Prismatic, k == 2);
        assert_eq!(axis.increments_per_turn, 8000);
        for (plan, hard) in [
            (
                axis.planning_limits.acceleration,
                axis.hard_limits.acceleration,
            ),
            (axis.planning_limits.jerk, axis.hard_limits.jerk),
        ] {
            assert!(0.0 < plan && plan <= 0.4 * hard + 1e-9);
        }
        // what is counted in a step at full speed stays well below what is believed
        let per_step = axis.hard_limits.velocity * 1e-3 * 8000.0 / core::f64::consts::TAU;
        assert!(per_step < 0.5 * f64::from(axis.max_increments_per_step));
        // homing towards the switch, then off it; a step of the fine speed is less than 4 increments
        let (coarse, fine) = homing(axis);
        assert!(coarse < 0.0 && fine > 0.0);
        // the motor can do the hard limits at once: inertia, friction and the weight of 30 kg on a screw
        let m = axis.motor;
        let torque = (m.rotor_kg_m2 + m.load_kg_m2) * axis.hard_limits.acceleration
            + m.viscous_nms_rad * axis.hard_limits.velocity
            + m.coulomb_nm
            + 30.0 * 9.81 * 0.010 / core::f64::consts::TAU;
        let most = axis.current_regulator.limit_ma * 1e-3 * m.torque_constant_nm_a;
        assert!(torque < 0.9 * most, "{torque} of {most}");
    }
}

/// Velocities of homing, coarse and fine.
fn homing(axis: &AxisDescription) -> (f64, f64) {
    match axis.homing {
        AxisHoming::Switch {
            coarse_velocity,
            fine_velocity,
        } => (coarse_velocity, fine_velocity),
        other => panic!("{other:?}"),
    }
}

#[test]
fn every_number_is_listed_as_assumed() {
    let listed = |value: f64| {
        ASSUMED
            .iter()
            .any(|a| a.item.starts_with("rnt: ") && (a.value - value).abs() <= 1e-12 * value.abs())
    };
    let d = Rnt.description();
    for axis in &d.axes {
        let m = axis.motor;
        let mut numbers = vec![
            axis.hard_limits.velocity,
            axis.joint_velocity,
            axis.joint_acceleration,
            m.torque_constant_nm_a,
            m.rotor_kg_m2,
            m.load_kg_m2,
            m.viscous_nms_rad,
            m.coulomb_nm,
            axis.current_regulator.limit_ma,
            axis.pwm_regulator.a,
            f64::from(axis.increments_per_turn),
        ];
        let (coarse, fine) = homing(axis);
        numbers.extend([-coarse, fine]);
        if axis.kind == JointKind::Prismatic {
            numbers.extend([axis.joint_position.lower, axis.joint_position.upper]);
        } else {
            numbers.push(axis.joint_position.upper.to_degrees());
        }
        for number in numbers {
            assert!(listed(number), "{}: {number}", axis.name);
        }
    }
    for number in d.base_position_m.into_iter().chain([
        d.tool_offset_m[2],
        d.cartesian_velocity,
        d.cartesian_acceleration,
        -robots::rnt::WORK_AREA_CENTRE_M[2],
        robots::rnt::WORK_AREA_SIZE_M[0],
        robots::rnt::WORK_AREA_SIZE_M[1],
        robots::rnt::WORK_AREA_CLEARANCE_M,
    ]) {
        assert!(listed(number), "{number}");
    }
}
