//! Inverse kinematics: every branch, the nearest one, and every way to have none.

use core::f64::consts::{FRAC_PI_2, PI};

use motion::Pose;
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;
use robots::{Irp6Postument, Irp6Track, Joints, KinematicError, Quantity, Robot, distance};

use super::{apart, patient, pitch, within_limits};

fn same_pose(a: &Pose, b: &Pose) -> f64 {
    (a.position - b.position)
        .amax()
        .max_of((a.rotation - b.rotation).amax())
}

trait MaxOf {
    fn max_of(self, other: Self) -> Self;
}

impl MaxOf for f64 {
    fn max_of(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
}

/// Any configuration is among the branches of its own pose, whatever the robot was near; and all
/// branches are of that pose, inside the limits and different.
fn complete<const N: usize>(
    robot: &impl Robot<N>,
    truth: &Joints<N>,
    mut near: Joints<N>,
) -> Result<(), TestCaseError> {
    if N == 7 {
        near.0[0] = truth.0[0];
    }
    let pose = robot.forward(truth);
    let found = match robot.inverse(&pose, &near) {
        Ok(found) => found,
        Err(error) => return Err(TestCaseError::fail(format!("{truth:?}: {error}"))),
    };
    let branches = found.branches();
    // the angle of a singular wrist is known to rounding over sin t5, that of a straight elbow never
    // arises inside the limits
    let conditioning = libm::sin(truth.0[N - 2]).abs();
    let tolerance = 1e-9_f64.max_of(1e-13 / conditioning);
    prop_assert!(
        branches.iter().any(|q| apart(&q.0, &truth.0) < tolerance),
        "{truth:?} not in {branches:?}"
    );
    for (i, q) in branches.iter().enumerate() {
        prop_assert!(same_pose(&robot.forward(q), &pose) < 1e-9, "{q:?}");
        prop_assert_eq!(robot.check_joints(q), Ok(()));
        for other in &branches[..i] {
            prop_assert!(apart(&q.0, &other.0) > 1e-6, "{q:?} twice");
        }
        let d = distance(q, &near);
        prop_assert!(d >= distance(&found.nearest(), &near), "{q:?} is nearer");
        // the set does not depend on where the robot was
        let again = robot.inverse(&pose, q).unwrap();
        prop_assert_eq!(again.branches().len(), branches.len());
        prop_assert!(apart(&again.nearest().0, &q.0) < 1e-9);
    }
    // turns of V come in full turns of all others
    let turns = branches
        .iter()
        .filter(|q| apart_but_v(q, &branches[0]) < 1e-6)
        .count();
    prop_assert!((3..=4).contains(&turns), "{turns} turns of V in ±10 rad");
    Ok(())
}

fn apart_but_v<const N: usize>(a: &Joints<N>, b: &Joints<N>) -> f64 {
    let mut a = *a;
    let half_turns = (a.0[N - 2] - b.0[N - 2]) / PI;
    if (half_turns - libm::round(half_turns)).abs() > 1e-6 || libm::round(half_turns) % 2.0 != 0.0 {
        return 1.0;
    }
    a.0[N - 2] = b.0[N - 2];
    apart(&a.0, &b.0)
}

/// Near a configuration, its own pose leads back to it: the branch is kept, and what is found is
/// what the search over all branches finds nearest.
fn stays_on_the_branch<const N: usize>(
    robot: &impl Robot<N>,
    truth: &Joints<N>,
    off: &[f64; 7],
) -> Result<(), TestCaseError> {
    let mut near = *truth;
    for (q, off) in near.0.iter_mut().zip(off) {
        *q += off;
    }
    if N == 7 {
        near.0[0] = truth.0[0];
    }
    let pose = robot.forward(truth);
    let (Ok(all), Ok(one)) = (
        robot.inverse(&pose, &near),
        robot.inverse_near(&pose, &near),
    ) else {
        return Err(TestCaseError::reject("no solution inside the limits"));
    };
    let off_path = apart(&one.0, &all.nearest().0);
    prop_assert!(off_path < 1e-9, "{one:?} {:?}", all.nearest());
    prop_assert!(same_pose(&robot.forward(&one), &pose) < 1e-9);
    Ok(())
}

proptest! {
    #![proptest_config(patient())]

    #[test]
    fn small_steps_stay_on_the_branch(
        unit in prop::array::uniform7(0.0..1.0f64), off in prop::array::uniform7(-0.02..0.02f64),
    ) {
        stays_on_the_branch(&Irp6Postument, &within_limits(&Irp6Postument, &unit), &off)?;
        stays_on_the_branch(&Irp6Track::KEEP, &within_limits(&Irp6Track::KEEP, &unit), &off)?;
    }

    #[test]
    fn every_branch_is_found(
        truth in prop::array::uniform7(0.0..1.0f64),
        near in prop::array::uniform7(0.0..1.0f64),
    ) {
        complete(&Irp6Postument, &within_limits(&Irp6Postument, &truth), within_limits(&Irp6Postument, &near))?;
        complete(&Irp6Track::KEEP, &within_limits(&Irp6Track::KEEP, &truth), within_limits(&Irp6Track::KEEP, &near))?;
    }

    #[test]
    fn nearest_to_itself_is_itself(truth in prop::array::uniform7(0.0..1.0f64)) {
        let q = within_limits(&Irp6Track::KEEP, &truth);
        let found = Irp6Track::KEEP.inverse(&Irp6Track::KEEP.forward(&q), &q).unwrap();
        prop_assert!(apart(&found.nearest().0, &q.0) < 1e-8, "{q:?} {:?}", found.nearest());
    }

    #[test]
    fn arbitrary_input_never_yields_a_wrong_branch(
        p in prop::array::uniform3(-1.5..1.5f64), w in prop::array::uniform3(-2.0..2.0f64),
    ) {
        let pose = Pose::from_rotation_vector(Vector3::from(p), Vector3::from(w));
        let near = Joints([0.0, -1.5, 0.0, 0.5, 1.0, 0.0]);
        match Irp6Postument.inverse(&pose, &near) {
            Ok(found) => for q in found.branches() {
                prop_assert!(same_pose(&Irp6Postument.forward(q), &pose) < 1e-9);
                prop_assert_eq!(Irp6Postument.check_joints(q), Ok(()));
            },
            Err(KinematicError::Limit { axis, value, lower, upper, .. }) => {
                prop_assert!(axis < 6 && (value < lower || value > upper));
            }
            Err(error) => prop_assert_eq!(error, KinematicError::Unreachable),
        }
    }

    #[test]
    fn singular_wrist_keeps_t(
        unit in prop::array::uniform7(0.1..0.9f64), flip in any::<bool>(), shift in -0.2..0.2f64,
        tiny in -1e-10..1e-10f64,
    ) {
        let mut q = within_limits(&Irp6Postument, &unit);
        q.0[4] = tiny + if flip { PI } else { 0.0 };
        let pose = Irp6Postument.forward(&q);
        let mut near = q;
        near.0[3] += shift;
        // N takes back what T keeps, so it must have room
        let n = if flip { q.0[5] + shift } else { q.0[5] - shift };
        prop_assume!((-2.8..2.8).contains(&n));
        match Irp6Postument.inverse(&pose, &near) {
            Ok(found) => {
                let got = found.nearest();
                prop_assert!((pitch(&got) - pitch(&near)).abs() < 1e-12);
                prop_assert!((got.0[5] - n).abs() < 1e-6, "{got:?} {n}");
                prop_assert!(same_pose(&Irp6Postument.forward(&got), &pose) < 1e-9);
            }
            // the arm cannot always reach with T where it is
            Err(error) => prop_assert!(
                matches!(error, KinematicError::Singular | KinematicError::Limit { .. }), "{error:?}"
            ),
        }
    }
}

#[test]
fn singular_where_the_kept_pitch_does_not_reach() {
    // far out, T level and pointing outwards, wrist singular
    let (t2, q3) = ((-50.0_f64).to_radians(), (-25.0_f64).to_radians());
    let far = Joints([0.3, t2, q3, -(t2 + q3 + FRAC_PI_2), 0.0, 0.2]);
    assert!(pitch(&far).abs() < 1e-12);
    let pose = Irp6Postument.forward(&far);
    let mut near = far;
    near.0[3] += PI;
    assert_eq!(
        Irp6Postument.inverse(&pose, &near),
        Err(KinematicError::Singular)
    );
    // the same pose with T where it was is no problem
    let found = Irp6Postument.inverse(&pose, &far).unwrap();
    assert!(apart(&found.nearest().0, &far.0) < 1e-9);
    // further than the arm is long, T would not help
    let beyond = Pose {
        position: pose.position * 1.4,
        ..pose
    };
    assert_eq!(
        Irp6Postument.inverse(&beyond, &far),
        Err(KinematicError::Unreachable)
    );
}

#[test]
fn flange_over_the_column_keeps_the_column() {
    // search the wrist pitch that brings the flange over the axis
    let (t2, t3) = ((-130.0_f64).to_radians(), (-65.0_f64).to_radians());
    let reach = 0.455 * libm::cos(t2) + 0.67 * libm::cos(t3);
    let t4 = -libm::acos(-reach / 0.19);
    let q = Joints([0.7, t2, (-25.0_f64).to_radians(), t4 - t3, 1.0, 0.4]);
    Irp6Postument.check_joints(&q).unwrap();
    let pose = Irp6Postument.forward(&q);
    assert!(pose.position.xy().norm() < 1e-12);
    let found = Irp6Postument.inverse(&pose, &q).unwrap();
    assert!(apart(&found.nearest().0, &q.0) < 1e-9);
    assert!(
        found
            .branches()
            .iter()
            .all(|b| (b.0[0] - 0.7).abs() < 1e-15)
    );
}

#[test]
fn reaching_over_the_back_is_a_branch() {
    let q = Joints([
        -2.0,
        (-129.0_f64).to_radians(),
        (-24.0_f64).to_radians(),
        (-89.0_f64).to_radians(),
        1.0,
        0.1,
    ]);
    Irp6Postument.check_joints(&q).unwrap();
    let pose = Irp6Postument.forward(&q);
    let (x, y) = (pose.position.x, pose.position.y);
    let towards = libm::atan2(y, x);
    assert!(
        (towards - (-2.0 + PI)).abs() < 1e-9,
        "the arm leans over its back"
    );
    let found = Irp6Postument
        .inverse(&pose, &Joints([0.0, -1.5, 0.0, 0.0, 1.0, 0.0]))
        .unwrap();
    assert!(found.branches().iter().any(|b| apart(&b.0, &q.0) < 1e-9));
}

#[test]
fn the_mirrored_elbow_is_never_inside_the_limits() {
    // opening δ = q3 + π/2; its mirror −δ is q3' = −q3 − π, up to full turns
    let range = Irp6Postument.description().axes[2].joint_position;
    for turn in [-1.0, 0.0, 1.0] {
        let (a, b) = (
            -range.lower - PI + turn * 2.0 * PI,
            -range.upper - PI + turn * 2.0 * PI,
        );
        assert!(a < range.lower || b > range.upper, "q3 from {b} to {a}");
    }
}

#[test]
fn out_of_reach() {
    let near = Joints([0.0, -1.57, 0.0, 1.56, 1.57, -1.57]);
    let mut pose = Irp6Postument.forward(&near);
    pose.position.x = 3.0;
    assert_eq!(
        Irp6Postument.inverse(&pose, &near),
        Err(KinematicError::Unreachable)
    );
}

#[test]
fn outside_a_limit_names_the_axis() {
    let near = Joints([0.0, -1.57, 0.0, 1.56, 1.57, -1.57]);
    // the same arm, turned behind its back
    let behind = Joints([PI, -1.57, 0.0, 1.56, 1.57, -1.57]);
    let error = Irp6Postument
        .inverse(&Irp6Postument.forward(&behind), &near)
        .unwrap_err();
    assert!(
        matches!(
            error,
            KinematicError::Limit {
                quantity: Quantity::Joint,
                ..
            }
        ),
        "{error:?}"
    );
    let mut off_track = Joints([1.3, 0.0, -1.57, 0.0, 1.56, 1.57, -1.57]);
    let pose = Irp6Track::KEEP.forward(&off_track);
    let error = Irp6Track::KEEP.inverse(&pose, &off_track).unwrap_err();
    assert!(
        matches!(
            error,
            KinematicError::Limit {
                axis: 0,
                name: "track",
                ..
            }
        ),
        "{error:?}"
    );
    off_track.0[0] = f64::NAN;
    assert_eq!(
        Irp6Track::KEEP.inverse(&pose, &off_track),
        Err(KinematicError::NotFinite)
    );
}

#[test]
fn malformed_poses_are_refused() {
    let near = Joints([0.0, -1.57, 0.0, 1.56, 1.57, -1.57]);
    let good = Irp6Postument.forward(&near);
    let with = |rotation| Irp6Postument.inverse(&Pose { rotation, ..good }, &near);
    for bad in [
        good.rotation * 1.001,
        Matrix3::zeros(),
        Matrix3::identity() * -1.0,
        Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, -1.0)),
        Matrix3::from_element(1e200),
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
    let nowhere = Pose {
        position: Vector3::new(0.0, f64::INFINITY, 0.0),
        ..good
    };
    assert_eq!(
        Irp6Postument.inverse(&nowhere, &near),
        Err(KinematicError::NotFinite)
    );
    // a rotation written with seven digits is one
    let rounded = good.rotation.map(|v| libm::round(v * 1e7) / 1e7);
    let found = with(rounded).unwrap();
    assert!(apart(&found.nearest().0, &near.0) < 1e-6);
}

#[test]
fn a_solution_on_its_limit_is_kept() {
    for (k, axis) in Irp6Postument.description().axes.iter().enumerate() {
        for bound in [axis.joint_position.lower, axis.joint_position.upper] {
            let mut q = Joints([0.1, -1.57, 0.1, 0.3, 1.0, 0.2]);
            q.0[k] = bound;
            let found = Irp6Postument
                .inverse(&Irp6Postument.forward(&q), &q)
                .unwrap();
            assert!(
                apart(&found.nearest().0, &q.0) < 1e-9,
                "{} at {bound}",
                axis.name
            );
            Irp6Postument.check_joints(&found.nearest()).unwrap();
        }
    }
}

#[test]
fn the_nearest_driveable_branch_can_be_asked_for() {
    let q = Joints([0.0, -1.57, 0.0, 1.56, 1.57, -1.57]);
    let away = Joints([0.0, -1.57, 0.0, 1.56, 1.57 - 2.0 * PI, -1.57]);
    let pose = Irp6Postument.forward(&q);
    let found = Irp6Postument.inverse(&pose, &away).unwrap();
    let driven = |q: &Joints<6>| {
        Irp6Postument
            .motors(q)
            .is_ok_and(|m| Irp6Postument.check_motors(&m).is_ok())
    };
    assert!(apart(&found.nearest().0, &away.0) < 1e-9);
    let nearest = found.nearest_where(&away, driven).unwrap();
    assert!(
        apart(&nearest.0, &q.0) < 1e-9,
        "V's motor does not turn that far: {nearest:?}"
    );
    assert!(found.nearest_where(&away, |_| false).is_none());
    assert!((pitch(&q) - FRAC_PI_2).abs() < 0.02);
}
