//! Inverse kinematics: every branch.
//!
//! *Central leg.* The wrist's axes meet in the flange's origin p = −(r + d)·n, so r = |p| − d and
//! n = −p/|p| = (sin ty·cos tx, −sin tx, cos ty·cos tx): tx = atan2(−ny, √(nx² + nz²)),
//! ty = atan2(nx, nz). The other solutions (r + d < 0, cos tx < 0) are outside the limits.
//!
//! *Wrist.* B = Rwᵀ·R = Z(w1)·Y(w2)·Z(w3) has the third column
//! (cos w1·sin w2, sin w1·sin w2, cos w2). Either sign of sin w2 gives one w1; what is left,
//! Y(w2)ᵀ·Z(w1)ᵀ·B = Z(w3), gives w3 whatever w1 was.
//!
//! *Turns.* w3 reaches ±350°, so most angles are reached in two turns; all others have less than one.
//!
//! *Singular.* sin w2 = 0: w1 and w3 turn about one line. w1 stays where `near` has it.

use motion::Pose;
use nalgebra::Matrix3;

use super::arm::{forward, wrist_base};
use super::assumed::WRIST_CENTRE_M;
use crate::description::AxisDescription;
use crate::error::{KinematicError, Quantity};
use crate::gearing::finite;
use crate::irp6::arm::{about_y, about_z};
use crate::irp6::inverse::LIMIT_SLACK;
use crate::orientation::{orthonormal, wrapped};
use core::f64::consts::{PI, TAU};

/// Below this distance of the flange from the base's origin, m, the central leg has no direction.
const NO_DIRECTION_M: f64 = 1e-9;
/// Below this sine of w2 the wrist is singular: keeping w1 costs less orientation than this.
const SINGULAR_SINE: f64 = 1e-9;
/// How well a branch must reproduce the pose, m and 1. Above the two slacks, which it has to allow.
const VERIFY: f64 = 1e-8;
/// A greater sine of w2 is plain.
const PLAIN: f64 = 1e-4;
/// Two wrists, two turns of w3.
const MOST_BRANCHES: usize = 4;

/// Solutions inside the joint limits.
#[derive(Clone, Copy, Debug)]
pub(super) struct Branches([Option<[f64; 6]>; MOST_BRANCHES]);

impl Branches {
    pub(super) fn iter(self) -> impl Iterator<Item = [f64; 6]> {
        self.0.into_iter().flatten()
    }
}

/// ty, tx, r; nothing where the flange is in the base's origin.
fn central_leg(pose: &Pose) -> Option<[f64; 3]> {
    let p = pose.position;
    let level2 = p.x * p.x + p.z * p.z;
    let distance = libm::sqrt(level2 + p.y * p.y);
    (distance > NO_DIRECTION_M).then(|| {
        [
            libm::atan2(-p.x, -p.z),
            libm::atan2(p.y, libm::sqrt(level2)),
            distance - WRIST_CENTRE_M,
        ]
    })
}

/// w2 and w3 to a w1.
fn rest(b: &Matrix3<f64>, w1: f64) -> [f64; 3] {
    let (s1, c1) = libm::sincos(w1);
    let w2 = libm::atan2(c1 * b.m13 + s1 * b.m23, b.m33);
    let (s2, c2) = libm::sincos(w2);
    let z = about_y(-s2, c2) * about_z(-s1, c1) * b;
    [w1, w2, libm::atan2(z.m21 - z.m12, z.m11 + z.m22)]
}

fn sine(b: &Matrix3<f64>) -> f64 {
    libm::sqrt(b.m13 * b.m13 + b.m23 * b.m23)
}

/// Every configuration of `axes` that puts the flange at `pose`.
pub(super) fn solve(
    pose: &Pose,
    near: &[f64; 6],
    axes: &[AxisDescription; 6],
) -> Result<Branches, KinematicError> {
    finite(near)?;
    finite(pose.position.as_slice())?;
    let rotation = orthonormal(&pose.rotation)?;
    let pose = Pose { rotation, ..*pose };
    let [ty, tx, reach] = central_leg(&pose).ok_or(KinematicError::Unreachable)?;
    let b = wrist_base(ty, tx).transpose() * rotation;
    let [.., near_w1, _, _] = *near;
    let free = sine(&b) < SINGULAR_SINE;
    let facing = libm::atan2(b.m23, b.m13);
    let wrists = if free {
        [Some(rest(&b, near_w1)), None]
    } else {
        [Some(rest(&b, facing)), Some(rest(&b, facing + PI))]
    };
    let mut search = Search {
        pose,
        near,
        axes,
        found: Branches([None; MOST_BRANCHES]),
        count: 0,
        limit: None,
    };
    let [.., w3_axis] = axes;
    let range = w3_axis.joint_position;
    for [w1, w2, w3] in wrists.into_iter().flatten() {
        let w3 = wrapped(w3, 0.0);
        let turned = if w3 > 0.0 { w3 - TAU } else { w3 + TAU };
        let inside = range.lower - LIMIT_SLACK <= turned && turned <= range.upper + LIMIT_SLACK;
        for w3 in [Some(w3), inside.then_some(turned)].into_iter().flatten() {
            search.file([ty, tx, reach, wrapped(w1, 0.0), w2, w3]);
        }
    }
    // any other w1 with its w3 reaches the pose as well, if the rest of the arm does
    let others_do = free && b.m33 > 0.0 && inside_limits(&[ty, tx, reach], axes);
    match search.limit {
        _ if search.count > 0 => Ok(search.found),
        _ if others_do => Err(KinematicError::Singular),
        Some((_, error)) => Err(error),
        None => Err(KinematicError::Unreachable),
    }
}

fn inside_limits(values: &[f64], axes: &[AxisDescription]) -> bool {
    let mut both = values.iter().zip(axes);
    both.all(|(value, axis)| axis.joint_position.contains(*value))
}

/// The solution on the branch of `near`; nothing where it is not plain: a singular wrist, a joint
/// outside its limits, or no direction.
pub(super) fn continuing(
    pose: &Pose,
    near: &[f64; 6],
    axes: &[AxisDescription; 6],
) -> Option<[f64; 6]> {
    let [.., near_w1, _, _] = *near;
    let [ty, tx, reach] = central_leg(pose)?;
    let b = wrist_base(ty, tx).transpose() * pose.rotation;
    if sine(&b) < PLAIN {
        return None;
    }
    let facing = libm::atan2(b.m23, b.m13);
    let away = libm::cos(facing - near_w1) < 0.0;
    let [w1, w2, w3] = rest(&b, if away { facing + PI } else { facing });
    let mut joints = [ty, tx, reach, w1, w2, w3];
    for (q, near) in joints.iter_mut().zip(near).skip(3) {
        *q = wrapped(*q, *near);
    }
    inside_limits(&joints, axes).then_some(joints)
}

/// What is asked, what was found, and the best reason if nothing is.
#[derive(Clone, Copy, Debug)]
struct Search<'a> {
    pose: Pose,
    near: &'a [f64; 6],
    axes: &'a [AxisDescription; 6],
    found: Branches,
    count: usize,
    /// The limit that stopped the candidate nearest to `near`, with its squared distance.
    limit: Option<(f64, KinematicError)>,
}

impl Search<'_> {
    /// Keeps a candidate inside the limits that reproduces the pose, else notes the reason.
    fn file(&mut self, candidate: [f64; 6]) {
        let mut joints = candidate;
        for (axis, (q, data)) in joints.iter_mut().zip(self.axes).enumerate() {
            let (range, value) = (data.joint_position, *q);
            if value < range.lower && range.lower - value <= LIMIT_SLACK {
                *q = range.lower;
            } else if value > range.upper && value - range.upper <= LIMIT_SLACK {
                *q = range.upper;
            } else if !range.contains(value) {
                let squares = candidate
                    .iter()
                    .zip(self.near)
                    .map(|(q, n)| (q - n) * (q - n));
                let distance2 = squares.sum();
                if self.limit.is_none_or(|(most, _)| distance2 < most) {
                    let error = KinematicError::Limit {
                        axis,
                        name: data.name,
                        quantity: Quantity::Joint,
                        value,
                        lower: range.lower,
                        upper: range.upper,
                    };
                    self.limit = Some((distance2, error));
                }
                return;
            }
        }
        let reached = forward(&joints);
        let position = reached.position - self.pose.position;
        let rotation = reached.rotation - self.pose.rotation;
        let same = |v: &f64| v.abs() <= VERIFY;
        if position.iter().all(same)
            && rotation.iter().all(same)
            && let Some(slot) = self.found.0.get_mut(self.count)
        {
            *slot = Some(joints);
            self.count += 1;
        }
    }
}
