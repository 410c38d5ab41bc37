//! Forward kinematics against the published entries of the matrix, Jacobian against differences.

use core::f64::consts::FRAC_PI_2;

use motion::pose::log;
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;
use robots::{Irp6Postument, Irp6Track, Joints, Robot};

use super::within_limits;

/// The flange from the entry-by-entry formulas of the six-axis model; another path than the product
/// of turns the crate uses.
fn published(q: &[f64]) -> (Vector3<f64>, Matrix3<f64>) {
    let t3 = q[2] + q[1] + FRAC_PI_2;
    let t = [q[0], q[1], t3, q[3] + t3, q[4], q[5]];
    let [s1, s2, s3, s4, s5, s6] = t.map(libm::sin);
    let [c1, c2, c3, c4, c5, c6] = t.map(libm::cos);
    let r = 0.455 * c2 + 0.67 * c3 + 0.19 * c4;
    let p = Vector3::new(c1 * r, s1 * r, -0.455 * s2 - 0.67 * s3 - 0.19 * s4);
    let column = |a: f64, b: f64| {
        Vector3::new(
            (c1 * s4 * c5 + s1 * s5) * a + c1 * c4 * b,
            (s1 * s4 * c5 - c1 * s5) * a + s1 * c4 * b,
            c4 * c5 * a - s4 * b,
        )
    };
    let approach = Vector3::new(c1 * s4 * s5 - s1 * c5, s1 * s4 * s5 + c1 * c5, c4 * s5);
    (
        p,
        Matrix3::from_columns(&[column(c6, s6), column(-s6, c6), approach]),
    )
}

fn jacobian_agrees<const N: usize>(
    robot: &impl Robot<N>,
    q: &Joints<N>,
) -> Result<(), TestCaseError> {
    let h = 1e-6;
    let here = robot.forward(q);
    let jacobian = robot.jacobian(q);
    for k in 0..N {
        let moved = |by: f64| {
            let mut q = *q;
            q.0[k] += by;
            robot.forward(&q)
        };
        let (minus, plus) = (moved(-h), moved(h));
        let linear = (plus.position - minus.position) / (2.0 * h);
        let angular = log(&(plus.rotation * minus.rotation.transpose())) / (2.0 * h);
        let column = jacobian.column(k);
        // rounding 1e-16/h and h² of differences
        for i in 0..3 {
            prop_assert!((column[i] - linear[i]).abs() < 1e-9, "{k} {i} at {here:?}");
            prop_assert!(
                (column[i + 3] - angular[i]).abs() < 1e-9,
                "{k} {i} at {here:?}"
            );
        }
    }
    Ok(())
}

proptest! {
    #[test]
    fn flange_is_the_published_one(q in prop::array::uniform6(-10.0..10.0f64), along in -1.0..2.0f64) {
        let (p, r) = published(&q);
        let got = Irp6Postument.forward(&Joints(q));
        prop_assert!((got.position - p).norm() < 1e-14);
        prop_assert!((got.rotation - r).norm() < 1e-14);
        let [a, b, c, d, e, f] = q;
        let got = Irp6Track::KEEP.forward(&Joints([along, a, b, c, d, e, f]));
        prop_assert!((got.position - p - Vector3::new(0.0, along, 0.0)).norm() < 1e-14);
        prop_assert!((got.rotation - r).norm() < 1e-14);
    }

    #[test]
    fn jacobian_is_the_derivative(unit in prop::array::uniform7(0.0..1.0f64)) {
        jacobian_agrees(&Irp6Postument, &within_limits(&Irp6Postument, &unit))?;
        jacobian_agrees(&Irp6Track::KEEP, &within_limits(&Irp6Track::KEEP, &unit))?;
    }
}

proptest! {
    #[test]
    fn sine_and_cosine_together_are_to_the_bit_what_they_are_alone(
        angle in prop_oneof![-12.0..12.0f64, -1e-7..1e-7f64, -1e6..1e6f64],
    ) {
        let (s, c) = libm::sincos(angle);
        prop_assert_eq!(s.to_bits(), libm::sin(angle).to_bits());
        prop_assert_eq!(c.to_bits(), libm::cos(angle).to_bits());
    }
}
