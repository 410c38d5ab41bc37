//! Motor ↔ joint: inverses, the chain rule, coupling.

use proptest::prelude::*;
use robots::rnt::HOME;
use robots::{JointMotion, Joints, KinematicError, MotorMotion, Motors, Rnt, Robot};

use super::{apart, distances, driveable, patient};

proptest! {
    #![proptest_config(patient())]

    #[test]
    fn motors_and_joints_are_inverse(unit in prop::array::uniform6(0.0..1.0f64)) {
        let Some(q) = driveable(&unit) else {
            return Err(TestCaseError::reject("motor limits"));
        };
        let m = Rnt.motors(&q).unwrap();
        let back = Rnt.joints(&m).unwrap();
        // 1e-12 m over a slope of at least 0.1 m/rad
        prop_assert!(apart(&q.0, &back.0) < 1e-11, "{q:?} {back:?}");
        let again = Rnt.motors(&back).unwrap();
        // 1e-12 m at 628 rad/m
        prop_assert!(apart(&m.0, &again.0) < 1e-9, "{m:?} {again:?}");
        for (m, l) in m.0.iter().zip(distances(q.0[0], q.0[1], q.0[2])) {
            prop_assert!((m - (l - 0.86) / 0.010 * core::f64::consts::TAU).abs() < 1e-9);
        }
    }

    #[test]
    fn motion_follows_the_chain_rule(
        unit in prop::array::uniform6(0.0..1.0f64),
        velocity in prop::array::uniform6(-1.0..1.0f64),
        acceleration in prop::array::uniform6(-2.0..2.0f64),
    ) {
        let Some(position) = driveable(&unit) else {
            return Err(TestCaseError::reject("motor limits"));
        };
        let got = Rnt.motor_motion(&JointMotion { position, velocity, acceleration }).unwrap();
        prop_assert_eq!(got.position, Rnt.motors(&position).unwrap());
        let h = 1e-3;
        let at = |t: f64| {
            let q = core::array::from_fn(|k| {
                position.0[k] + velocity[k] * t + 0.5 * acceleration[k] * t * t
            });
            Rnt.motors(&Joints(q)).unwrap().0
        };
        let here = got.position.0;
        let difference = |h: f64| {
            let (m, p) = (at(-h), at(h));
            let first: [f64; 6] = core::array::from_fn(|k| (p[k] - m[k]) / (2.0 * h));
            let second: [f64; 6] = core::array::from_fn(|k| (p[k] - 2.0 * here[k] + m[k]) / (h * h));
            (first, second)
        };
        let ((first, second), (near_first, near_second)) = (difference(h), difference(0.5 * h));
        for k in 0..6 {
            // Richardson: h⁴ and rounding, 1e-13 over h and (h/2)², of numbers of some 1000
            let first = (4.0 * near_first[k] - first[k]) / 3.0;
            let second = (4.0 * near_second[k] - second[k]) / 3.0;
            prop_assert!((first - got.velocity[k]).abs() < 1e-7, "{k}: {first} {got:?}");
            prop_assert!((second - got.acceleration[k]).abs() < 1e-5, "{k}: {second} {got:?}");
        }
        let back = Rnt.joint_motion(&got).unwrap();
        prop_assert!(apart(&back.position.0, &position.0) < 1e-11);
        prop_assert!(apart(&back.velocity, &velocity) < 1e-10, "{back:?}");
        prop_assert!(apart(&back.acceleration, &acceleration) < 1e-9, "{back:?}");
    }
}

#[test]
fn every_leg_feels_the_platform_and_the_wrist_feels_only_itself() {
    let q = Joints([0.1, -0.2, 1.1, 0.3, 0.4, 0.5]);
    let here = Rnt.motors(&q).unwrap();
    let turned = |k: usize| {
        let mut q = q;
        q.0[k] += 0.01;
        let m = Rnt.motors(&q).unwrap();
        core::array::from_fn::<bool, 6, _>(|i| (m.0[i] - here.0[i]).abs() > 1e-9)
    };
    // the foot of leg 1 is on the axis of the tilt about y
    assert_eq!(turned(0), [false, true, true, false, false, false]);
    assert_eq!(turned(1), [true, true, true, false, false, false]);
    assert_eq!(turned(2), [true, true, true, false, false, false]);
    for k in 3..6 {
        assert_eq!(turned(k), core::array::from_fn(|i| i == k));
    }
}

#[test]
fn motors_that_pull_the_platform_over_are_refused() {
    // one leg at its longest, the others at their shortest: each inside its limits
    let axes = &Rnt.description().axes;
    let mut m = Motors([0.0; 6]);
    m.0[0] = axes[0].motor_position.upper;
    Rnt.check_motors(&m).unwrap();
    assert_eq!(Rnt.joints(&m), Err(KinematicError::Unreachable));
    let motion = MotorMotion {
        position: m,
        velocity: [0.0; 6],
        acceleration: [0.0; 6],
    };
    assert_eq!(Rnt.joint_motion(&motion), Err(KinematicError::Unreachable));
    // a leg off its screw
    m.0[0] = 700.0;
    assert!(matches!(
        Rnt.joints(&m),
        Err(KinematicError::Limit { axis: 0, .. })
    ));
}

#[test]
fn not_finite_is_refused_everywhere() {
    let good = HOME;
    let motors = Rnt.motors(&good).unwrap();
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for k in 0..6 {
            let (mut q, mut m, mut rates) = (good, motors, [0.0; 6]);
            q.0[k] = bad;
            m.0[k] = bad;
            rates[k] = bad;
            let refused = KinematicError::NotFinite;
            assert_eq!(Rnt.motors(&q), Err(refused));
            assert_eq!(Rnt.joints(&m), Err(refused));
            assert_eq!(Rnt.inverse(&Rnt.forward(&good), &q), Err(refused));
            assert_eq!(Rnt.inverse_near(&Rnt.forward(&q), &good), Err(refused));
            assert_eq!(
                Rnt.limits_along(&good, &q, robots::VelocityFactor::FULL),
                Err(refused)
            );
            assert_eq!(Rnt.legs(&q), Err(refused));
            for (velocity, acceleration) in [(rates, [0.0; 6]), ([0.0; 6], rates)] {
                let motion = JointMotion {
                    position: good,
                    velocity,
                    acceleration,
                };
                assert_eq!(Rnt.motor_motion(&motion), Err(refused));
                let motion = MotorMotion {
                    position: motors,
                    velocity,
                    acceleration,
                };
                assert_eq!(Rnt.joint_motion(&motion), Err(refused));
            }
        }
    }
}
