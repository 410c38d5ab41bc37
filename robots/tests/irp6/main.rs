//! Both IRp-6 against published figures, independent formulas and their own inverses.

mod along;
mod golden;
mod inverse;
mod kinematics;
mod limits;
mod planning;
mod transmission;

use core::f64::consts::FRAC_PI_2;

use proptest::prelude::ProptestConfig;
use robots::{Joints, Robot};

/// Cases as set from outside, and as many rejects as they take: a box of joints is not one of motors, so a constant
/// share of its corners is left out however many cases are asked for.
fn patient() -> ProptestConfig {
    ProptestConfig {
        max_global_rejects: u32::MAX,
        ..ProptestConfig::default()
    }
}

/// A configuration inside the joint limits from numbers in 0..1.
fn within_limits<const N: usize>(robot: &impl Robot<N>, unit: &[f64; 7]) -> Joints<N> {
    let axes = &robot.description().axes;
    Joints(core::array::from_fn(|k| {
        let range = axes[k].joint_position;
        range.lower + unit[7 - N + k] * (range.upper - range.lower)
    }))
}

/// The same, only where the motors are inside their limits too. V's number spans what its motor can
/// turn with T where it is, or too few samples would be left.
fn driveable<const N: usize>(robot: &impl Robot<N>, unit: &[f64; 7]) -> Option<Joints<N>> {
    let mut joints = within_limits(robot, unit);
    let v = &robot.description().axes[N - 2];
    joints.0[N - 2] = 0.0;
    let at_zero = robot.motors(&joints).ok()?.0[N - 2];
    let range = v.motor_position;
    let motor = range.lower + unit[5] * (range.upper - range.lower);
    joints.0[N - 2] = (motor - at_zero) / (-128.0 * 0.6);
    robot.check_joints(&joints).ok()?;
    robot.check_motors(&robot.motors(&joints).ok()?).ok()?;
    Some(joints)
}

/// t4 of the arm: T's angle against the horizontal.
fn pitch<const N: usize>(joints: &Joints<N>) -> f64 {
    let q = &joints.0[N - 6..];
    q[1] + q[2] + q[3] + FRAC_PI_2
}

/// The greatest |a − b|.
fn apart<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, |m, d| if d > m || d.is_nan() { d } else { m })
}
