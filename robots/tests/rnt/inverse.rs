//! Inverse kinematics: every branch, the nearest one, and every way to have none.

use core::f64::consts::PI;

use motion::Pose;
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;
use robots::rnt::HOME;
use robots::{Joints, KinematicError, Quantity, Rnt, Robot, distance};

use super::{apart, within_limits};

fn same_pose(a: &Pose, b: &Pose) -> f64 {
    let (p, r) = (
        (a.position - b.position).amax(),
        (a.rotation - b.rotation).amax(),
    );
    if p > r { p } else { r }
}

proptest! {
    #[test]
    fn every_branch_is_found(
        truth in prop::array::uniform6(0.0..1.0f64), near in prop::array::uniform6(0.0..1.0f64),
    ) {
        let (truth, near) = (within_limits(&truth), within_limits(&near));
        let pose = Rnt.forward(&truth);
        let found = match Rnt.inverse(&pose, &near) {
            Ok(found) => found,
            Err(error) => return Err(TestCaseError::fail(format!("{truth:?}: {error}"))),
        };
        let branches = found.branches();
        // the angles of a singular wrist are known to rounding over sin w2
        let tolerance = 1e-9 + 1e-13 / libm::sin(truth.0[4]).abs();
        prop_assert!(
            branches.iter().any(|q| apart(&q.0, &truth.0) < tolerance), "{truth:?} not in {branches:?}"
        );
        for (i, q) in branches.iter().enumerate() {
            prop_assert!(same_pose(&Rnt.forward(q), &pose) < 1e-9, "{q:?}");
            prop_assert_eq!(Rnt.check_joints(q), Ok(()));
            for other in &branches[..i] {
                prop_assert!(apart(&q.0, &other.0) > 1e-6, "{q:?} twice");
            }
            prop_assert!(distance(q, &near) >= distance(&found.nearest(), &near), "{q:?} is nearer");
            let again = Rnt.inverse(&pose, q).unwrap();
            prop_assert_eq!(again.branches().len(), branches.len());
            prop_assert!(apart(&again.nearest().0, &q.0) < 1e-9);
        }
        // all that there are: two wrists where both w1 are in range, and the turns of w3 in ±350°
        let [.., w1, _, w3] = truth.0;
        let turns = |w3: f64| [-1.0, 0.0, 1.0].iter()
            .filter(|n| (w3 + *n * 2.0 * PI).abs() <= 350.0_f64.to_radians()).count();
        let flip_in_range = w1.abs() >= 10.0_f64.to_radians();
        let flipped = if w3 > 0.0 { w3 - PI } else { w3 + PI };
        let expected = turns(w3) + if flip_in_range { turns(flipped) } else { 0 };
        prop_assert_eq!(branches.len(), expected, "{:?}", truth);
    }

    #[test]
    fn small_steps_stay_on_the_branch(
        unit in prop::array::uniform6(0.0..1.0f64), off in prop::array::uniform6(-0.02..0.02f64),
    ) {
        let mut truth = within_limits(&unit);
        // nearer to the singularity than the step, the other wrist may be nearer
        if libm::sin(truth.0[4]).abs() <= 0.03 {
            truth.0[4] += 0.1;
        }
        let near = Joints(core::array::from_fn(|k| truth.0[k] + off[k]));
        let pose = Rnt.forward(&truth);
        let (Ok(all), Ok(one)) = (Rnt.inverse(&pose, &near), Rnt.inverse_near(&pose, &near)) else {
            return Err(TestCaseError::fail("a configuration inside the limits has solutions"));
        };
        prop_assert!(apart(&one.0, &all.nearest().0) < 1e-9, "{one:?} {:?}", all.nearest());
        prop_assert!(same_pose(&Rnt.forward(&one), &pose) < 1e-9);
        // and it is the one the pose was made of
        let conditioning = libm::sin(truth.0[4]).abs();
        prop_assert!(apart(&one.0, &truth.0) < 1e-12 / conditioning, "{one:?} {truth:?}");
    }

    #[test]
    fn arbitrary_input_never_yields_a_wrong_branch(
        p in prop::array::uniform3(-1.8..1.8f64), w in prop::array::uniform3(-2.0..2.0f64),
    ) {
        let pose = Pose::from_rotation_vector(Vector3::from(p), Vector3::from(w));
        match Rnt.inverse(&pose, &HOME) {
            Ok(found) => for q in found.branches() {
                prop_assert!(same_pose(&Rnt.forward(q), &pose) < 1e-9);
                prop_assert_eq!(Rnt.check_joints(q), Ok(()));
            },
            Err(KinematicError::Limit { axis, value, lower, upper, .. }) => {
                prop_assert!(axis < 6 && (value < lower || value > upper));
            }
            Err(error) => prop_assert!(false, "{error:?}"),
        }
    }

    #[test]
    fn a_singular_wrist_keeps_its_first_axis(
        unit in prop::array::uniform6(0.1..0.9f64), shift in -0.2..0.2f64, tiny in -1e-10..1e-10f64,
    ) {
        let mut q = within_limits(&unit);
        q.0[4] = tiny;
        let pose = Rnt.forward(&q);
        let mut near = q;
        near.0[3] += shift;
        for got in [
            Rnt.inverse(&pose, &near).unwrap().nearest(), Rnt.inverse_near(&pose, &near).unwrap(),
        ] {
            prop_assert!((got.0[3] - near.0[3]).abs() < 1e-12);
            // w3 takes back what w1 keeps
            prop_assert!((got.0[5] - (q.0[5] - shift)).abs() < 1e-9, "{got:?}");
            prop_assert!(same_pose(&Rnt.forward(&got), &pose) < 1e-9);
        }
    }
}

/// A sphere of poses a step apart: the wrist follows without a jump.
#[test]
fn following_a_path_is_smooth() {
    let mut near = HOME;
    let mut worst = 0.0;
    for step in 0..=20_000 {
        let t = f64::from(step) * 1e-3;
        let turn = Vector3::new(
            0.4 * libm::sin(t),
            0.4 * libm::cos(1.3 * t) - 0.4,
            0.8 * libm::sin(0.7 * t),
        );
        let home = Rnt.forward(&HOME);
        let pose = Pose {
            position: home.position
                + Vector3::new(
                    0.2 * libm::sin(t),
                    0.2 * libm::sin(0.7 * t),
                    0.1 * libm::sin(1.7 * t),
                ),
            rotation: motion::pose::exp(turn) * home.rotation,
        };
        let next = Rnt.inverse_near(&pose, &near).unwrap();
        let jump = apart(&next.0, &near.0);
        worst = if jump > worst { jump } else { worst };
        near = next;
    }
    // joints at some 2 rad/s, 1 ms a step; a jump of branch is half a turn
    assert!((5e-4..5e-3).contains(&worst), "{worst}");
}

#[test]
fn singular_where_the_kept_first_axis_does_not_reach() {
    // w1 + w3 is 4 rad; with w1 kept at −2.9 rad, w3 would have to be 6.9 or 0.6 rad …
    let q = Joints([0.1, 0.1, 1.1, 1.0, 0.0, 3.0]);
    let pose = Rnt.forward(&q);
    let mut near = q;
    near.0[3] = -2.9;
    // … so there is a turn that does
    let found = Rnt.inverse(&pose, &near).unwrap();
    assert!((found.nearest().0[5] - (6.9 - 2.0 * PI)).abs() < 1e-9);
    // kept outside its own limits, nothing is left, though another w1 would do
    near.0[3] = 3.0;
    assert_eq!(Rnt.inverse(&pose, &near), Err(KinematicError::Singular));
    // folded back by half a turn, no w1 helps: that is a limit of w2
    let mut folded = q;
    folded.0[4] = PI;
    let error = Rnt.inverse(&Rnt.forward(&folded), &q).unwrap_err();
    assert!(
        matches!(error, KinematicError::Limit { axis: 4, .. }),
        "{error:?}"
    );
}

#[test]
fn outside_a_limit_names_the_axis() {
    for (axis, value) in [(0, 0.62), (1, -0.62), (2, 0.79), (2, 1.41), (4, 1.95)] {
        let mut q = HOME;
        q.0[axis] = value;
        let pose = Rnt.forward(&q);
        for error in [
            Rnt.inverse(&pose, &q).unwrap_err(),
            Rnt.inverse_near(&pose, &q).unwrap_err(),
        ] {
            assert!(
                matches!(error, KinematicError::Limit { axis: k, quantity: Quantity::Joint, .. } if k == axis),
                "{axis}: {error:?}"
            );
        }
    }
    // in the base's origin there is no direction
    let nowhere = Pose {
        position: Vector3::zeros(),
        ..Rnt.forward(&HOME)
    };
    assert_eq!(
        Rnt.inverse(&nowhere, &HOME),
        Err(KinematicError::Unreachable)
    );
    // above the base, the leg would have to turn upside down
    let above = Pose {
        position: Vector3::new(0.0, 0.0, 1.2),
        ..nowhere
    };
    assert!(matches!(
        Rnt.inverse(&above, &HOME),
        Err(KinematicError::Limit { axis: 0, .. })
    ));
}

#[test]
fn malformed_poses_are_refused() {
    let good = Rnt.forward(&HOME);
    let with = |rotation| Rnt.inverse(&Pose { rotation, ..good }, &HOME);
    for bad in [
        good.rotation * 1.001,
        Matrix3::zeros(),
        Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, -1.0)),
    ] {
        assert!(
            matches!(with(bad), Err(KinematicError::NotARotation { .. })),
            "{bad}"
        );
    }
    assert_eq!(
        with(Matrix3::from_element(f64::NAN)),
        Err(KinematicError::NotFinite)
    );
}

#[test]
fn a_solution_on_its_limit_is_kept() {
    for (k, axis) in Rnt.description().axes.iter().enumerate() {
        for bound in [axis.joint_position.lower, axis.joint_position.upper] {
            let mut q = Joints([0.1, 0.1, 1.1, 0.3, 0.8, 0.2]);
            q.0[k] = bound;
            let found = Rnt.inverse(&Rnt.forward(&q), &q).unwrap();
            assert!(
                apart(&found.nearest().0, &q.0) < 1e-9,
                "{} at {bound}",
                axis.name
            );
            Rnt.check_joints(&found.nearest()).unwrap();
        }
    }
}
