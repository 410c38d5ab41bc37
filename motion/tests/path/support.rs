//! Random poses, motions, and what every curve is held to.

use motion::path::{Curve, PathPoint, Straight};
use motion::pose::{Pose, log};
use nalgebra::Vector3;
use proptest::prelude::*;

pub(crate) fn vector(most: f64) -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-most..most).prop_map(Vector3::from)
}

/// Positions within a cube of ±1 m, orientations within ±1 rad about each axis.
pub(crate) fn pose() -> impl Strategy<Value = Pose> {
    (vector(1.0), vector(1.0)).prop_map(|(p, w)| Pose::from_rotation_vector(p, w))
}

pub(crate) fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::from_rotation_vector(Vector3::new(x, y, z), Vector3::zeros())
}

pub(crate) fn straight(a: Pose, b: Pose) -> Straight {
    Straight::new(a, b).unwrap()
}

/// m and rad.
pub(crate) fn apart(a: &Pose, b: &Pose) -> (f64, f64) {
    (
        (a.position - b.position).norm(),
        log(&(a.rotation * b.rotation.transpose())).norm(),
    )
}

/// Jumps of p', ω, p'', ω', p''', ω'' from one point to another.
pub(crate) fn jumps(a: &PathPoint, b: &PathPoint) -> [f64; 6] {
    let mut jumps = [0.0; 6];
    for (i, (a, b)) in [(a.first, b.first), (a.second, b.second), (a.third, b.third)]
        .into_iter()
        .enumerate()
    {
        jumps[2 * i] = (a.linear - b.linear).norm();
        jumps[2 * i + 1] = (a.angular - b.angular).norm();
    }
    jumps
}

/// Difference quotients of the curve at s with step h: p', ω, p'', ω', p''', ω''; the higher ones are the
/// first differences of what the curve says about the order below.
fn quotients(curve: &impl Curve, s: f64, h: f64) -> [Vector3<f64>; 6] {
    let (b, a) = (curve.at(s - h), curve.at(s + h));
    let step = 2.0 * h;
    [
        (a.pose.position - b.pose.position) / step,
        log(&(a.pose.rotation * b.pose.rotation.transpose())) / step,
        (a.first.linear - b.first.linear) / step,
        (a.first.angular - b.first.angular) / step,
        (a.second.linear - b.second.linear) / step,
        (a.second.angular - b.second.angular) / step,
    ]
}

/// Every derivative at s is the limit of difference quotients.
///
/// A central quotient Q(h) is off by c·h² + O(h⁴); Q(h) − Q(h/2) = ¾·c·h², of which the error of Q(h/2) is a
/// third. The whole difference is allowed, and what O(h⁴) may leave where c happens to vanish: 1e-3 of
/// the greatest value, over a step of 1 % of the length; and 1e-15/h of rounding.
pub(crate) fn derivatives_are_limits(curve: &impl Curve, s: f64) -> Result<(), TestCaseError> {
    let here = curve.at(s);
    let h = 0.01 * curve.length();
    let (coarse, fine) = (quotients(curve, s, h), quotients(curve, s, h / 2.0));
    let exact = [
        here.first.linear,
        here.first.angular,
        here.second.linear,
        here.second.angular,
        here.third.linear,
        here.third.angular,
    ];
    let rate = here.first.linear_norm().max(here.first.angular_norm());
    let length = curve.length();
    for (i, ((exact, coarse), fine)) in exact.iter().zip(coarse).zip(fine).enumerate() {
        // what a change by all of the first derivative over the piece would make of the order
        let unit = [1.0, 1.0 / length, 1.0 / (length * length)][i / 2];
        let scale = exact.norm() + 0.1 * rate * unit;
        let allowed = (coarse - fine).norm() + 1e-3 * scale + 1e-13 * unit / length;
        let error = (fine - exact).norm();
        prop_assert!(
            error <= allowed,
            "derivative {i} at {s}: {error:e} > {allowed:e}, exact {exact:?} quotient {fine:?}"
        );
    }
    Ok(())
}

/// The length of a curve by Simpson's rule with 50000 intervals: error of fourth order, and so far below
/// rounding unless the curve has a cusp.
pub(crate) fn simpson(curve: &impl Curve) -> f64 {
    let n = 50_000;
    let h = curve.length() / f64::from(n);
    let weight = |i: i32| match i {
        0 => 1.0,
        i if i == n => 1.0,
        i if i % 2 == 1 => 4.0,
        _ => 2.0,
    };
    let speed = |i: i32| curve.at(h * f64::from(i)).first.linear_norm();
    (0..=n).map(|i| weight(i) * speed(i)).sum::<f64>() * h / 3.0
}

/// The motion g applied to every derivative of a point.
pub(crate) fn moved(g: &Pose, x: &PathPoint) -> PathPoint {
    let turn = |t: motion::Twist| motion::Twist {
        linear: g.rotation * t.linear,
        angular: g.rotation * t.angular,
    };
    PathPoint {
        pose: *g * x.pose,
        first: turn(x.first),
        second: turn(x.second),
        third: turn(x.third),
    }
}
