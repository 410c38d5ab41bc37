//! Motor ↔ joint: inverses, the chain rule, coupling, dead centres.

use core::f64::consts::PI;

use proptest::prelude::*;
use robots::{
    Irp6Postument, Irp6Track, JointMotion, Joints, KinematicError, MotorMotion, Motors, Quantity,
    Robot,
};

use super::{apart, driveable, patient};

fn round_trips<const N: usize>(
    robot: &impl Robot<N>,
    unit: &[f64; 7],
) -> Result<(), TestCaseError> {
    if let Some(q) = driveable(robot, unit) {
        let back = robot.joints(&robot.motors(&q).unwrap()).unwrap();
        prop_assert!(apart(&q.0, &back.0) < 1e-12, "{q:?} {back:?}");
    }
    // any motor angles inside their limits close the triangles
    let axes = &robot.description().axes;
    let m = Motors(core::array::from_fn(|k| {
        let range = axes[k].motor_position;
        range.lower + unit[7 - N + k] * (range.upper - range.lower)
    }));
    let back = robot.motors(&robot.joints(&m).unwrap()).unwrap();
    // 1e-15 of 3000 rad
    prop_assert!(apart(&m.0, &back.0) < 1e-10, "{m:?} {back:?}");
    Ok(())
}

fn chain_rule<const N: usize>(
    robot: &impl Robot<N>,
    unit: &[f64; 7],
    v: &[f64; 7],
    a: &[f64; 7],
) -> Result<(), TestCaseError> {
    let Some(position) = driveable(robot, unit) else {
        return Err(TestCaseError::reject("motor limits"));
    };
    let velocity: [f64; N] = core::array::from_fn(|k| v[k]);
    let acceleration: [f64; N] = core::array::from_fn(|k| a[k]);
    let motion = JointMotion {
        position,
        velocity,
        acceleration,
    };
    let got = robot.motor_motion(&motion).unwrap();
    prop_assert_eq!(got.position, robot.motors(&position).unwrap());
    let h = 1e-4;
    let at = |t: f64| {
        let moved = |k: usize| position.0[k] + velocity[k] * t + 0.5 * acceleration[k] * t * t;
        robot
            .motors(&Joints(core::array::from_fn(moved)))
            .map(|m| m.0)
    };
    let (Ok(minus), here, Ok(plus)) = (at(-h), got.position.0, at(h)) else {
        return Ok(());
    };
    let (Ok(near_minus), Ok(near_plus)) = (at(-0.5 * h), at(0.5 * h)) else {
        return Ok(());
    };
    for k in 0..N {
        let first = |p: &[f64; N], m: &[f64; N], h: f64| (p[k] - m[k]) / (2.0 * h);
        let second = |p: &[f64; N], m: &[f64; N], h: f64| (p[k] - 2.0 * here[k] + m[k]) / (h * h);
        // Near a dead centre the higher derivatives grow without bound: Richardson's extrapolation
        // takes the term in h² away. What is left is rounding, some 1e-13 over h and over (h/2)².
        let extrapolated = |far: f64, near: f64| (4.0 * near - far) / 3.0;
        let first = extrapolated(
            first(&plus, &minus, h),
            first(&near_plus, &near_minus, 0.5 * h),
        );
        let second = extrapolated(
            second(&plus, &minus, h),
            second(&near_plus, &near_minus, 0.5 * h),
        );
        prop_assert!(
            (first - got.velocity[k]).abs() < 1e-5,
            "{k}: {first} {:?}",
            got.velocity
        );
        prop_assert!(
            (second - got.acceleration[k]).abs() < 2e-3,
            "{k}: {second} {:?}",
            got.acceleration
        );
    }
    let back = robot.joint_motion(&got).unwrap();
    prop_assert!(apart(&back.position.0, &position.0) < 1e-12);
    prop_assert!(apart(&back.velocity, &velocity) < 1e-11, "{back:?}");
    prop_assert!(apart(&back.acceleration, &acceleration) < 1e-10, "{back:?}");
    Ok(())
}

proptest! {
    #![proptest_config(patient())]

    #[test]
    fn motors_and_joints_are_inverse(unit in prop::array::uniform7(0.0..1.0f64)) {
        round_trips(&Irp6Postument, &unit)?;
        round_trips(&Irp6Track::KEEP, &unit)?;
    }

    #[test]
    fn motion_follows_the_chain_rule(
        unit in prop::array::uniform7(0.0..1.0f64),
        v in prop::array::uniform7(-1.0..1.0f64),
        a in prop::array::uniform7(-2.0..2.0f64),
    ) {
        chain_rule(&Irp6Postument, &unit, &v, &a)?;
        chain_rule(&Irp6Track::KEEP, &unit, &v, &a)?;
    }
}

#[test]
fn only_v_feels_t_and_only_the_parallelogram_feels_the_lower_arm() {
    let q = Joints([0.0, -1.5, 0.1, 0.9, 2.0, 0.3]);
    let at = Irp6Postument.motors(&q).unwrap();
    let turned = |k: usize| {
        let mut q = q;
        q.0[k] += 0.01;
        let m = Irp6Postument.motors(&q).unwrap();
        core::array::from_fn::<bool, 6, _>(|i| (m.0[i] - at.0[i]).abs() > 1e-9)
    };
    assert_eq!(turned(0), [true, false, false, false, false, false]);
    assert_eq!(turned(1), [false, true, true, true, true, false]);
    assert_eq!(turned(2), [false, false, true, true, true, false]);
    assert_eq!(turned(3), [false, false, false, true, true, false]);
    assert_eq!(turned(4), [false, false, false, false, true, false]);
    assert_eq!(turned(5), [false, false, false, false, false, true]);
}

#[test]
fn track_is_a_screw_of_4_mm_a_turn() {
    let mut q = Irp6Track::KEEP.joints(&Motors([0.0; 7])).unwrap();
    q.0[0] = 0.004;
    let m = Irp6Track::KEEP.motors(&q).unwrap();
    assert!((m.0[0] - 2.0 * PI).abs() < 1e-12);
    assert!((m.0[0] / 0.004 - 1570.796).abs() < 5e-4);
}

#[test]
fn beyond_the_dead_centre_is_refused() {
    // t3 = −25° − 130° + 90° = −65°: inside the joint limits, past the folded triangle at −49.3°
    let q = Joints([
        0.0,
        (-130.0_f64).to_radians(),
        (-25.0_f64).to_radians(),
        0.0,
        0.0,
        0.0,
    ]);
    Irp6Postument.check_joints(&q).unwrap();
    let error = Irp6Postument.motors(&q).unwrap_err();
    let KinematicError::Limit {
        axis: 2,
        name: "upper arm",
        quantity: Quantity::ScrewAngle,
        value,
        ..
    } = error
    else {
        panic!("{error:?}")
    };
    assert!((value - (-65.0_f64).to_radians()).abs() < 1e-12);
    let m = Motors([0.0, -300.0, 0.0, 0.0, 0.0, 0.0]);
    let error = Irp6Postument.joints(&m).unwrap_err();
    assert!(
        matches!(
            error,
            KinematicError::Limit {
                axis: 1,
                quantity: Quantity::ScrewLength,
                ..
            }
        ),
        "{error:?}"
    );
}

#[test]
fn not_finite_is_refused_everywhere() {
    let good = Irp6Postument.joints(&Motors([0.0; 6])).unwrap();
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for k in 0..6 {
            let mut q = good;
            q.0[k] = bad;
            assert_eq!(Irp6Postument.motors(&q), Err(KinematicError::NotFinite));
            assert_eq!(
                Irp6Postument.check_joints(&q),
                Err(KinematicError::NotFinite)
            );
            let mut m = [0.0; 6];
            m[k] = bad;
            assert_eq!(
                Irp6Postument.joints(&Motors(m)),
                Err(KinematicError::NotFinite)
            );
            assert_eq!(
                Irp6Postument.check_motors(&Motors(m)),
                Err(KinematicError::NotFinite)
            );
            let motion = JointMotion {
                position: good,
                velocity: m,
                acceleration: [0.0; 6],
            };
            assert_eq!(
                Irp6Postument.motor_motion(&motion),
                Err(KinematicError::NotFinite)
            );
            let motion = MotorMotion {
                position: Motors([0.0; 6]),
                velocity: [0.0; 6],
                acceleration: m,
            };
            assert_eq!(
                Irp6Postument.joint_motion(&motion),
                Err(KinematicError::NotFinite)
            );
        }
    }
}
