//! The arm of five axes.

use nalgebra::{Rotation3, Vector3};
use proptest::prelude::*;
use robots::{Irp6Arm, Irp6Postument, Joints, KinematicError, Motors, Quantity, Robot};

use crate::{off, spread};

proptest! {
    #[test]
    fn the_turn_about_the_tool_axis_is_free(
        unit in prop::array::uniform7(0.02..0.98f64), turn in -3.0..3.0f64,
    ) {
        let q = spread(&Irp6Arm, &unit);
        let mut pose = Irp6Arm.forward(&q);
        pose.rotation *= Rotation3::from_axis_angle(&Vector3::z_axis(), turn).into_inner();
        let found = Irp6Arm.inverse(&pose, &q).unwrap();
        prop_assert!(off(&found.nearest(), &q) < 1e-6, "{found:?} {q:?}");
    }

    #[test]
    fn it_is_the_postument_with_its_n_at_rest(unit in prop::array::uniform7(0.0..1.0f64)) {
        let Joints([a, b, c, d, e]) = spread(&Irp6Arm, &unit);
        let six = Irp6Postument.forward(&Joints([a, b, c, d, e, 0.0]));
        let five = Irp6Arm.forward(&Joints([a, b, c, d, e]));
        prop_assert_eq!(five, six);
    }
}

#[test]
fn homing_ends_where_the_calibration_says() {
    // by hand from the gears: column 16/−158, T level at 170, V at (357 − 170)/76.8 from T's travel
    let q = Irp6Arm.joints(&Motors([0.0; 5])).unwrap();
    assert!((q.0[0] + 16.0 / 158.0).abs() < 1e-12, "{q:?}");
    let t4 = q.0[1] + q.0[2] + q.0[3] + core::f64::consts::FRAC_PI_2;
    assert!((t4 - 170.0 / 128.0).abs() < 1e-12, "{q:?}");
    assert!((q.0[4] - (357.0 - 170.0) / 76.8).abs() < 1e-12, "{q:?}");
    Irp6Arm.check_joints(&q).unwrap();
}

#[test]
fn its_t_ends_at_ninety_degrees() {
    let axis = Irp6Arm.description().axes[3];
    assert!((axis.joint_position.upper - 90.1_f64.to_radians()).abs() < 1e-12);
    let q = Joints([0.0, -1.57, 0.0, 1.58, 0.5]);
    let error = Irp6Arm.check_joints(&q).unwrap_err();
    assert!(matches!(
        error,
        KinematicError::Limit {
            axis: 3,
            quantity: Quantity::Joint,
            ..
        }
    ));
}
