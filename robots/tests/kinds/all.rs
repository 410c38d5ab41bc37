//! What every kind must answer.

use core::fmt::Debug;

use motion::Pose;
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;
use robots::{
    JointMotion, Joints, KinematicError, MotorMotion, Motors, Robot, RobotKind, RobotVisitor,
    TrackRule, VelocityFactor,
};

use crate::{apart, off, spread};

/// Runs the same check on every kind.
fn every<V: RobotVisitor<Output = ()>>(check: impl Fn(RobotKind) -> V) {
    for kind in RobotKind::ALL {
        kind.visit(TrackRule::Keep, check(kind));
    }
}

struct Complete(RobotKind);

impl RobotVisitor for Complete {
    type Output = ();
    fn visit<R: Robot<N> + Copy + Debug, const N: usize>(self, robot: R) {
        let d = robot.description();
        assert_eq!(d.name, self.0.name());
        assert_eq!(N, self.0.axes());
        let mut order = d.homing.order;
        order.sort_unstable();
        assert_eq!(order, core::array::from_fn(|k| k));
        for axis in &d.axes {
            assert!(axis.joint_position.lower < axis.joint_position.upper);
            assert!(axis.motor_position.contains(0.0), "{}", axis.name);
            let r = axis.pwm_regulator;
            assert!(r.epsilon > 0.0 && r.a > 0.0 && r.a < 1.0 && r.b0 > r.b1 && r.b1 > 0.0);
            assert!(axis.current_regulator.gain_ma > 0.0 && axis.current_regulator.limit_ma > 0.0);
            for (plan, hard) in [
                (axis.planning_limits.velocity, axis.hard_limits.velocity),
                (
                    axis.planning_limits.acceleration,
                    axis.hard_limits.acceleration,
                ),
                (axis.planning_limits.jerk, axis.hard_limits.jerk),
            ] {
                assert!(0.0 < plan && plan < hard, "{}", axis.name);
            }
        }
        for limits in robot.joint_limits_for_planning(VelocityFactor::DEFAULT) {
            assert!(limits.v > 0.0 && limits.v.is_finite(), "{limits:?}");
            assert!(limits.a > 0.0 && limits.a.is_finite(), "{limits:?}");
            assert!(limits.j > 0.0 && limits.j.is_finite(), "{limits:?}");
        }
    }
}

#[test]
fn every_description_is_complete() {
    every(Complete);
    let mut effectors = RobotKind::ALL.map(RobotKind::effector);
    effectors.sort_unstable();
    effectors.windows(2).for_each(|w| assert!(w[0] < w[1]));
}

struct Inverts([f64; 7]);

impl RobotVisitor for Inverts {
    type Output = ();
    fn visit<R: Robot<N> + Copy + Debug, const N: usize>(self, robot: R) {
        let q = spread(&robot, &self.0);
        let pose = robot.forward(&q);
        let found = robot.inverse(&pose, &q).unwrap();
        // rounding times the condition of elbows and wrists, which near a singularity is its root
        assert!(off(&found.nearest(), &q) < 1e-6, "{found:?} {q:?}");
        let near = robot.inverse_near(&pose, &q).unwrap();
        assert!(off(&near, &q) < 1e-6, "{near:?} {q:?}");
        for branch in found.branches() {
            robot.check_joints(branch).unwrap();
            let reached = robot.forward(branch);
            if N == 5 {
                let (a, b) = (reached.rotation.column(2), pose.rotation.column(2));
                assert!((reached.position - pose.position).norm() < 1e-7);
                assert!((a - b).norm() < 1e-7);
            } else {
                assert!(apart(&reached, &pose) < 1e-7, "{branch:?}");
            }
        }
    }
}

struct Differentiates([f64; 7]);

impl RobotVisitor for Differentiates {
    type Output = ();
    fn visit<R: Robot<N> + Copy + Debug, const N: usize>(self, robot: R) {
        let q = spread(&robot, &self.0);
        let (jacobian, here) = (robot.jacobian(&q), robot.forward(&q));
        let h = 1e-6;
        for k in 0..N {
            let at = |by: f64| {
                let mut q = q;
                q.0[k] += by;
                robot.forward(&q)
            };
            let (low, high) = (at(-h), at(h));
            let v = (high.position - low.position) / (2.0 * h);
            let w = (high.rotation - low.rotation) / (2.0 * h) * here.rotation.transpose();
            let angular = [w.m32, w.m13, w.m21];
            for row in 0..3 {
                // rounding 2e-16·10/h and h²
                assert!((jacobian[(row, k)] - v[row]).abs() < 1e-7, "{k} {row}");
                assert!(
                    (jacobian[(row + 3, k)] - angular[row]).abs() < 1e-7,
                    "{k} {row}"
                );
            }
        }
    }
}

struct Transmits([f64; 7], [f64; 7], [f64; 7]);

impl RobotVisitor for Transmits {
    type Output = ();
    fn visit<R: Robot<N> + Copy + Debug, const N: usize>(self, robot: R) {
        let q = spread(&robot, &self.0);
        // a screw may be beyond its dead centre within the joint limits
        let Ok(motors) = robot.motors(&q) else { return };
        let back = robot.joints(&motors).unwrap();
        assert!(off(&back, &q) < 1e-9, "{back:?} {q:?}");
        // rates only where the motors can be: towards the dead centre of a screw they grow without bound
        if robot.check_motors(&motors).is_err() {
            return;
        }
        let motion = JointMotion {
            position: q,
            velocity: core::array::from_fn(|k| self.1[k] * 0.05),
            acceleration: core::array::from_fn(|k| self.2[k] * 0.05),
        };
        let there = robot.motor_motion(&motion).unwrap();
        let again = robot.joint_motion(&there).unwrap();
        for k in 0..N {
            assert!((again.velocity[k] - motion.velocity[k]).abs() < 1e-9);
            assert!((again.acceleration[k] - motion.acceleration[k]).abs() < 1e-8);
        }
        // the chain rule against differences over ±t
        let t = 1e-4;
        let at = |t: f64| {
            let q = core::array::from_fn(|k| {
                q.0[k] + t * motion.velocity[k] + 0.5 * t * t * motion.acceleration[k]
            });
            robot.motors(&Joints(q))
        };
        let (Ok(low), Ok(high)) = (at(-t), at(t)) else {
            return;
        };
        for k in 0..N {
            let v = (high.0[k] - low.0[k]) / (2.0 * t);
            let scale = 1.0 + there.velocity[k].abs();
            let rounding = 4.0 * f64::EPSILON * (1.0 + motors.0[k].abs());
            // and t²/6 of the third derivative
            let most = 1e-6 * scale + rounding / t;
            assert!((v - there.velocity[k]).abs() < most, "{k}");
            let a = (high.0[k] - 2.0 * motors.0[k] + low.0[k]) / (t * t);
            let scale = 1.0 + there.acceleration[k].abs();
            // and t²/12 of the fourth derivative
            let most = 1e-4 * scale + rounding / (t * t);
            assert!((a - there.acceleration[k]).abs() < most, "{k} {a}");
        }
    }
}

proptest! {
    #[test]
    fn the_inverse_of_a_forward_has_the_joints_among_its_branches(
        unit in prop::array::uniform7(0.02..0.98f64),
    ) {
        every(|_| Inverts(unit));
    }

    #[test]
    fn jacobians_are_the_differences_of_the_forward(unit in prop::array::uniform7(0.0..1.0f64)) {
        every(|_| Differentiates(unit));
    }

    #[test]
    fn motors_and_joints_are_inverse_with_their_rates(
        unit in prop::array::uniform7(0.02..0.98f64),
        v in prop::array::uniform7(-1.0..1.0f64),
        a in prop::array::uniform7(-1.0..1.0f64),
    ) {
        every(|_| Transmits(unit, v, a));
    }
}

struct Refuses;

impl RobotVisitor for Refuses {
    type Output = ();
    fn visit<R: Robot<N> + Copy + Debug, const N: usize>(self, robot: R) {
        let q = spread(&robot, &[0.5; 7]);
        let good = robot.forward(&q);
        for bad in [f64::NAN, f64::INFINITY] {
            let mut joints = q;
            joints.0[N - 1] = bad;
            assert_eq!(
                robot.inverse(&good, &joints),
                Err(KinematicError::NotFinite)
            );
            assert_eq!(robot.motors(&joints), Err(KinematicError::NotFinite));
            assert_eq!(robot.check_joints(&joints), Err(KinematicError::NotFinite));
            let mut motors = Motors([0.0; N]);
            motors.0[N - 1] = bad;
            assert_eq!(robot.joints(&motors), Err(KinematicError::NotFinite));
            assert_eq!(robot.check_motors(&motors), Err(KinematicError::NotFinite));
            let motion = MotorMotion {
                position: Motors([0.0; N]),
                velocity: [bad; N],
                acceleration: [0.0; N],
            };
            assert_eq!(robot.joint_motion(&motion), Err(KinematicError::NotFinite));
            let mut pose = good;
            pose.position.y = bad;
            assert_eq!(robot.inverse(&pose, &q), Err(KinematicError::NotFinite));
        }
        let skewed = Pose {
            rotation: good.rotation * 1.01,
            ..good
        };
        let mirrored = Pose {
            rotation: good.rotation * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, -1.0)),
            ..good
        };
        for pose in [skewed, mirrored] {
            let error = robot.inverse(&pose, &q).unwrap_err();
            assert_eq!(error.code(), "not-a-rotation");
        }
        let away = Pose {
            position: Vector3::new(9.0, 9.0, 9.0),
            ..good
        };
        assert!(robot.inverse(&away, &q).is_err());
        assert!(robot.inverse_near(&away, &q).is_err());
    }
}

#[test]
fn malformed_questions_are_refused() {
    every(|_| Refuses);
}
