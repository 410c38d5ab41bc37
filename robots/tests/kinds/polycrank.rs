//! Polycrank against its published table, and its redundancy.

use core::f64::consts::{FRAC_PI_2, PI, TAU};

use motion::Pose;
use nalgebra::{Matrix3, Matrix4, Vector3};
use proptest::prelude::*;
use robots::{Joints, KinematicError, Polycrank, Robot};

use crate::{apart, off};

/// The published table, row by row: an oracle that shares nothing with the closed form.
fn by_table(q: &[f64; 7]) -> Pose {
    const TABLE: [(f64, f64, f64); 7] = [
        (0.220, -0.299, 0.0),
        (0.152, 0.180, 0.0),
        (0.335, 0.0, FRAC_PI_2),
        (0.120, 0.151, 0.0),
        (0.116, 0.151, 0.0),
        (0.060, 0.0, FRAC_PI_2),
        (0.043, 0.0, 0.0),
    ];
    let mut t = Matrix4::new_translation(&Vector3::new(0.0, 0.0, 0.925));
    for (q, (d, a, alpha)) in q.iter().zip(TABLE) {
        t *= Matrix4::from_axis_angle(&Vector3::z_axis(), *q)
            * Matrix4::new_translation(&Vector3::new(a, 0.0, d))
            * Matrix4::from_axis_angle(&Vector3::x_axis(), alpha);
    }
    Pose {
        position: t.fixed_view::<3, 1>(0, 3).into_owned(),
        rotation: t.fixed_view::<3, 3>(0, 0).into_owned(),
    }
}

#[test]
fn published_poses_are_reached() {
    let zero = Polycrank.forward(&Joints([0.0; 7]));
    let expected = Pose {
        position: Vector3::new(0.183, -0.296, 1.589),
        rotation: Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0)),
    };
    assert!(apart(&zero, &expected) < 1e-12, "{zero:?}");
    let other = Polycrank.forward(&Joints([0.5, -0.4, 0.3, -0.2, 0.6, 0.7, -0.8]));
    let expected = Pose {
        position: Vector3::new(0.331_677, -0.271_299, 1.641_298),
        rotation: Matrix3::new(
            0.011_725, 0.571_014, 0.820_856, 0.783_794, -0.514_997, 0.347_052, 0.620_91, 0.639_313,
            -0.453_596,
        ),
    };
    // the digits printed
    assert!(apart(&other, &expected) < 1e-6, "{other:?}");
}

fn joints() -> impl Strategy<Value = [f64; 7]> {
    prop::array::uniform7(-20.0..20.0f64)
}

/// An angle in three turns that is 0.2 and more from every multiple of π.
fn bent() -> impl Strategy<Value = f64> {
    (-3..3_i32, 0.2..PI - 0.2).prop_map(|(halves, angle)| f64::from(halves) * PI + angle)
}

proptest! {
    #[test]
    fn forward_is_the_product_of_the_table(q in joints()) {
        prop_assert!(apart(&Polycrank.forward(&Joints(q)), &by_table(&q)) < 1e-12);
    }

    #[test]
    fn every_branch_reaches_in_the_turn_nearest_to_near(q in joints(), near in joints()) {
        let pose = Polycrank.forward(&Joints(q));
        let found = Polycrank.inverse_at(&pose, &Joints(near), Polycrank.reach(&Joints(q))).unwrap();
        let mut original = false;
        for branch in found.branches() {
            prop_assert!(apart(&by_table(&branch.0), &pose) < 1e-7);
            prop_assert!(off(branch, &Joints(near)) <= PI + 1e-9);
            let turns = branch.0.iter().zip(q).map(|(b, q)| (b - q) / TAU);
            original |= turns.map(|t| (t - t.round()).abs()).all(|t| t < 1e-6);
        }
        prop_assert!(original, "{:?}", found.branches());
        // two bends of each pair, in the plane and perhaps in its opposite
        prop_assert!([4, 8].contains(&found.branches().len()), "{}", found.branches().len());
        for (i, a) in found.branches().iter().enumerate() {
            for b in &found.branches()[..i] {
                prop_assert!(off(a, b) > 1e-9, "twice {a:?}");
            }
        }
    }

    #[test]
    fn a_reach_that_is_not_possible_is_replaced_by_one_that_is(q in joints(), near in joints()) {
        let pose = Polycrank.forward(&Joints(q));
        // whatever the cranks of `near` do, a pose that can be reached is reached
        let found = Polycrank.inverse(&pose, &Joints(near)).unwrap();
        for branch in found.branches() {
            prop_assert!(apart(&by_table(&branch.0), &pose) < 1e-7);
        }
    }

    #[test]
    fn a_small_step_of_the_flange_is_a_small_step_of_the_joints(
        mut q in joints(), [q2, q5, psi] in [bent(), bent(), bent()],
        step in prop::array::uniform3(-1e-5..1e-5f64),
    ) {
        // both pairs of cranks bent, and the roll's axis off the vertical: ψ = q4 + q5 + q6
        (q[1], q[4], q[5]) = (q2, q5, psi - q[3] - q5);
        let (q, mut pose) = (Joints(q), Polycrank.forward(&Joints(q)));
        pose.position += Vector3::from(step);
        let near = Polycrank.inverse_near(&pose, &q).unwrap();
        // 1.8e-5 m over cranks of 0.15 m at an angle of 0.2, a few of them in a row
        prop_assert!(off(&near, &q) < 4e-3, "{near:?} {q:?}");
        // u stays to the rounding: it does not creep along a path
        prop_assert!((Polycrank.reach(&near) - Polycrank.reach(&q)).abs() < 1e-14);
        prop_assert!(apart(&by_table(&near.0), &pose) < 1e-9);
    }
}

#[test]
fn a_vertical_roll_axis_keeps_the_plane() {
    let q = Joints([0.3, 0.8, -0.4, 0.5, -1.1, 0.6, 2.0]);
    let pose = Polycrank.forward(&q);
    let found = Polycrank.inverse(&pose, &q).unwrap();
    assert!(off(&found.nearest(), &q) < 1e-9);
    // another plane, as far as it goes: only the sum of φ and q7 is kept
    let mut near = q;
    near.0[2] += 0.1;
    let moved = Polycrank.inverse(&pose, &near).unwrap().nearest();
    let phi = |q: &Joints<7>| q.0[0] + q.0[1] + q.0[2];
    assert!((phi(&moved) - phi(&near)).abs() < 1e-12);
    assert!(apart(&by_table(&moved.0), &pose) < 1e-9);
    // a plane that passes the pose too far away
    let far = Pose {
        position: Vector3::new(0.75, -0.296, 1.5),
        rotation: Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0)),
    };
    assert!(Polycrank.inverse(&far, &Joints([0.0; 7])).is_ok());
    assert_eq!(
        Polycrank.inverse(&far, &Joints([-FRAC_PI_2, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])),
        Err(KinematicError::Singular)
    );
}

#[test]
fn folded_and_stretched_cranks_have_their_answer() {
    // the second pair folded: u = w = 0 and q4 free
    let folded = Joints([0.3, 0.8, -0.4, 0.5, PI, 0.6, 2.0]);
    let pose = Polycrank.forward(&folded);
    let found = Polycrank.inverse_at(&pose, &folded, 0.0).unwrap();
    assert!(off(&found.nearest(), &folded) < 1e-6, "{found:?}");
    // the first pair stretched: both bends are one
    let stretched = Joints([0.3, PI, -0.4, 0.5, 1.0, 0.6, 2.0]);
    let pose = Polycrank.forward(&stretched);
    let found = Polycrank.inverse(&pose, &stretched).unwrap();
    // the root of the rounding
    assert!(off(&found.nearest(), &stretched) < 1e-6, "{found:?}");
    // beyond
    let mut pose = pose;
    pose.position += Vector3::new(pose.position.x, pose.position.y, 0.0).normalize() * 0.5;
    assert_eq!(
        Polycrank.inverse_near(&pose, &stretched),
        Err(KinematicError::Unreachable)
    );
}
