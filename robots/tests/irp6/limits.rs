//! Position limits.

use robots::{Irp6Track, KinematicError, Motors, Quantity, Robot};

#[test]
fn bounds_are_inclusive_and_named() {
    let home = Irp6Track::KEEP.joints(&Motors([0.0; 7])).unwrap();
    for (k, axis) in Irp6Track::KEEP.description().axes.iter().enumerate() {
        for (bound, outwards) in [
            (axis.joint_position.lower, -1e-9),
            (axis.joint_position.upper, 1e-9),
        ] {
            let mut q = home;
            q.0[k] = bound;
            assert_eq!(Irp6Track::KEEP.check_joints(&q), Ok(()));
            q.0[k] = bound + outwards;
            let expected = KinematicError::Limit {
                axis: k,
                name: axis.name,
                quantity: Quantity::Joint,
                value: bound + outwards,
                lower: axis.joint_position.lower,
                upper: axis.joint_position.upper,
            };
            assert_eq!(Irp6Track::KEEP.check_joints(&q), Err(expected));
        }
        for (bound, outwards) in [
            (axis.motor_position.lower, -1e-9),
            (axis.motor_position.upper, 1e-9),
        ] {
            let mut m = Motors([0.0; 7]);
            m.0[k] = bound;
            assert_eq!(Irp6Track::KEEP.check_motors(&m), Ok(()));
            m.0[k] = bound + outwards;
            let error = Irp6Track::KEEP.check_motors(&m).unwrap_err();
            assert!(
                matches!(error, KinematicError::Limit { axis, quantity: Quantity::Motor, .. } if axis == k),
                "{error:?}"
            );
        }
    }
}

#[test]
fn an_error_says_everything() {
    let mut m = Motors([0.0; 7]);
    m.0[4] = 400.0;
    let error = Irp6Track::KEEP.check_motors(&m).unwrap_err();
    assert_eq!(error.code(), "limit");
    assert_eq!(
        error.to_string(),
        "motor of axis 5 (T) would be 400.0, allowed -70 to 380"
    );
}
