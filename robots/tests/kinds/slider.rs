//! Conveyor and grippers.

use motion::Pose;
use nalgebra::{Matrix3, Rotation3, Vector3};
use proptest::prelude::*;
use robots::{
    AxisHoming, Conveyor, Gearing, Irp6Gripper, Joints, KinematicError, Motors, Quantity, Robot,
};

const GRIPPERS: [Irp6Gripper; 2] = [Irp6Gripper::Track, Irp6Gripper::Postument];

#[test]
fn the_jaws_stand_where_the_original_has_them() {
    for gripper in GRIPPERS {
        for (opening, motor) in [(0.053, 1176.0), (0.074, 0.0), (0.091, -1809.0)] {
            let got = gripper.motors(&Joints([opening])).unwrap().0[0];
            // the figures are rounded to a radian
            assert!((got - motor).abs() < 1.0, "{got}");
        }
        // the original's own inverse, with its printed digits
        for opening in [0.053, 0.06, 0.07, 0.08, 0.09] {
            let got = gripper.motors(&Joints([opening])).unwrap().0[0];
            // m = 0.3531946456e-5·√(0.2622172716e19 − 0.28313e20·j) − 2564.03432, squared
            let root = (got + 2_564.034_32) / 0.353_194_645_6e-5;
            let square = 0.262_217_271_6e19_f64 - 0.283_13e20 * opening;
            assert!((root * root / square - 1.0).abs() < 1e-6, "{got}");
        }
    }
}

#[test]
fn the_jaws_do_not_pass_their_dead_centre() {
    let gripper = Irp6Gripper::Track;
    let Gearing::Quadratic(law) = gripper.description().axes[0].gearing else {
        panic!("a quadratic")
    };
    assert!((law.vertex() + 2564.03).abs() < 0.01, "{}", law.vertex());
    let error = gripper.motors(&Joints([law.extreme() + 1e-6])).unwrap_err();
    assert!(matches!(
        error,
        KinematicError::Limit {
            axis: 0,
            quantity: Quantity::Joint,
            ..
        }
    ));
    let error = gripper.joints(&Motors([law.vertex() - 1.0])).unwrap_err();
    assert!(matches!(
        error,
        KinematicError::Limit {
            axis: 0,
            quantity: Quantity::Motor,
            ..
        }
    ));
    // and the limits keep off it
    let axis = gripper.description().axes[0];
    assert!(law.extreme() > axis.joint_position.upper);
    assert!(law.vertex() < axis.motor_position.lower);
}

#[test]
fn outside_its_limits_a_gripper_says_so() {
    for (opening, limit) in [(0.052, 0.053), (0.092, 0.091)] {
        let pose = Pose {
            position: Vector3::new(0.0, opening, 0.0),
            rotation: Matrix3::identity(),
        };
        match Irp6Gripper::Postument.inverse(&pose, &Joints([0.07])) {
            Err(KinematicError::Limit { lower, upper, .. }) => {
                assert!(
                    lower.to_bits() == f64::to_bits(limit)
                        || upper.to_bits() == f64::to_bits(limit)
                );
            }
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn the_belt_is_where_its_motor_is() {
    let at = |m: f64| Conveyor.joints(&Motors([m])).unwrap().0[0];
    assert!((at(2250.0) - 1.0).abs() < 1e-15);
    assert!((at(-225.0) + 0.1).abs() < 1e-15);
    let axis = Conveyor.description().axes[0];
    assert_eq!(axis.homing, AxisHoming::InPlace);
    // a belt that has run for a kilometre is still within its limits
    Conveyor.check_joints(&Joints([1e3])).unwrap();
    Conveyor.check_motors(&Motors([2.25e6])).unwrap();
    assert_eq!(axis.joint_position.centre().to_bits(), 0);
}

proptest! {
    #[test]
    fn off_the_line_or_turned_there_is_no_answer(
        q in -2.0..2.0f64, by in 1e-6..1.0f64, turn in 1e-6..3.0f64,
    ) {
        let near = Joints([q]);
        let on = Conveyor.forward(&near);
        let mut aside = on;
        aside.position.z += by;
        prop_assert_eq!(Conveyor.inverse(&aside, &near), Err(KinematicError::Unreachable));
        let turned = Pose {
            rotation: Rotation3::from_axis_angle(&Vector3::x_axis(), turn).into_inner(),
            ..on
        };
        prop_assert_eq!(Conveyor.inverse(&turned, &near), Err(KinematicError::Unreachable));
    }
}
