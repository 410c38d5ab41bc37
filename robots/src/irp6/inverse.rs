//! Inverse kinematics of the six axes from the column on: every branch.
//!
//! # Derivation
//!
//! *Column.* The wrist links lie in the arm's plane, so the flange's origin does too:
//! t1 = atan2(y, x), or half a turn further with the arm reaching over its back (r < 0).
//!
//! *Wrist.* B = Z(t1)ᵀ·R·Πᵀ = Y(t4)·X(t5)·Y(t6) has the second column
//! (sin t4·sin t5, cos t5, cos t4·sin t5). Either sign of sin t5 gives one t4; what is left,
//! X(t5)ᵀ·Y(t4)ᵀ·B = Y(t6), gives t6 whatever t4 was, so an ill-conditioned t4 never spoils the
//! orientation.
//!
//! *Arm.* With the wrist's centre e = r − d5·cos t4, f = −h − d5·sin t4 and the elbow's opening
//! δ = t3 − t2, the law of cosines gives
//! cos δ = (e² + f² − a2² − a3²)/(2·a2·a3), t2 = atan2(f, e) − atan2(a3·sin δ, a2 + a3·cos δ).
//! q3 = δ − π/2 in its range of −25° to 40° needs δ between 65° and 130°: never the mirrored elbow −δ,
//! which the machine's screws could not take either. A test holds the range to that.
//!
//! *Turns.* V reaches ±10 rad, so up to four turns of the same angle are solutions; all others have
//! less than a full turn.
//!
//! # Where a joint is free
//!
//! sin t5 = 0 (A along the arm's normal): T and N turn about one line, only a sum of them is given. T
//! keeps its angle against the horizontal from `near`, as the original did. Where that leaves nothing
//! inside the limits although the column can face a flange within reach, the answer is *singular*:
//! another T may do. x = y = 0: any angle of the column is as good, it keeps that of `near`.

use core::f64::consts::{FRAC_PI_2, PI};

use motion::Pose;
use nalgebra::Matrix3;

use super::arm::{about_x, about_y, about_z, flange_axes, forward};
use super::data::{LOWER_ARM_M, UPPER_ARM_M, WRIST_M};
use crate::description::AxisDescription;
use crate::error::{KinematicError, Quantity};
use crate::gearing::finite;
use crate::orientation::{TURN, orthonormal, wrapped};
use crate::robot::MAX_BRANCHES;

/// Below this, m, the flange is on the column's axis.
const ON_AXIS_M: f64 = 1e-9;
/// Below this sine of t5 the wrist is singular: keeping T costs less orientation than this.
const SINGULAR_SINE: f64 = 1e-9;
/// A solution this little outside its range is put on the bound, rad.
pub(crate) const LIMIT_SLACK: f64 = 1e-9;
/// How well a branch must reproduce the pose, m and 1. Above the two slacks, which it has to allow.
const VERIFY: f64 = 1e-8;

/// No flange is further from the shoulder.
const REACH_M: f64 = LOWER_ARM_M + UPPER_ARM_M + WRIST_M;

/// Farther than this from the column's axis (m) and from a singular wrist (sine), a branch is plain.
const PLAIN: f64 = 1e-4;

/// Solutions inside the joint limits.
#[derive(Clone, Copy, Debug)]
pub(super) struct Branches {
    joints: [[f64; 6]; MAX_BRANCHES],
    count: usize,
}

impl Branches {
    pub(super) fn iter(&self) -> impl Iterator<Item = [f64; 6]> {
        self.joints.iter().copied().take(self.count)
    }

    fn push(&mut self, joints: [f64; 6]) {
        if let Some(slot) = self.joints.get_mut(self.count) {
            *slot = joints;
            self.count = self.count.saturating_add(1);
        }
    }
}

/// Wrist angles t4, t5, t6, and whether t4 was free.
#[derive(Clone, Copy, Debug)]
struct Wrist {
    t4: f64,
    t5: f64,
    t6: f64,
    free: bool,
}

/// Every configuration of `axes` that puts the flange at `pose` (in the frame of the shoulder).
///
/// `first_axis` is the index of the column in the robot, for errors.
pub(super) fn solve(
    pose: &Pose,
    near: &[f64; 6],
    axes: &[AxisDescription; 6],
    first_axis: usize,
) -> Result<Branches, KinematicError> {
    finite(near)?;
    finite(pose.position.as_slice())?;
    let rotation = orthonormal(&pose.rotation)?;
    let mut search = Search {
        pose: Pose { rotation, ..*pose },
        near,
        axes,
        first_axis,
        found: Branches {
            joints: [[0.0; 6]; MAX_BRANCHES],
            count: 0,
        },
        limit: None,
        singular: false,
    };
    search.sides();
    search.result()
}

/// A search for branches: what is asked, what was found, and the best reason if nothing is.
/// The solution on the branch of `near`, without looking at the others; nothing where the
/// branch is not plain (on the column's axis, at a singular wrist, outside the limits or the reach):
/// then all branches must be looked at.
pub(super) fn continuing(
    pose: &Pose,
    near: &[f64; 6],
    axes: &[AxisDescription; 6],
) -> Option<[f64; 6]> {
    let [near1, near2, near3, near4, ..] = *near;
    let (p, near_t4) = (pose.position, near4 + near3 + near2 + FRAC_PI_2);
    if libm::sqrt(p.x * p.x + p.y * p.y) < PLAIN {
        return None;
    }
    let facing = libm::atan2(p.y, p.x);
    let away = libm::cos(facing - near1) < 0.0;
    let t1 = if away { facing + PI } else { facing };
    let (s1, c1) = libm::sincos(t1);
    let b = about_z(-s1, c1) * pose.rotation * flange_axes().transpose();
    let sine = libm::sqrt(b.m12 * b.m12 + b.m32 * b.m32);
    if sine < PLAIN {
        return None;
    }
    let t4 = libm::atan2(b.m12, b.m32);
    let flipped = libm::cos(t4 - near_t4) < 0.0;
    let (t4, s5) = if flipped {
        (t4 + PI, -sine)
    } else {
        (t4, sine)
    };
    let wrist = wrist(&b, t4, s5, false);
    let (t2, opening) = elbow(c1 * p.x + s1 * p.y, p.z, t4)?;
    let mut joints = [
        t1,
        t2,
        opening - FRAC_PI_2,
        t4 - (t2 + opening),
        wrist.t5,
        wrist.t6,
    ];
    for ((q, near), axis) in joints.iter_mut().zip(near).zip(axes) {
        *q = wrapped(*q, *near);
        if !axis.joint_position.contains(*q) {
            return None;
        }
    }
    Some(joints)
}

#[derive(Clone, Copy, Debug)]
struct Search<'a> {
    pose: Pose,
    near: &'a [f64; 6],
    axes: &'a [AxisDescription; 6],
    first_axis: usize,
    found: Branches,
    /// The limit that stopped the candidate nearest to `near`, with its squared distance.
    limit: Option<(f64, KinematicError)>,
    singular: bool,
}

impl Search<'_> {
    fn result(self) -> Result<Branches, KinematicError> {
        match self.limit {
            _ if self.found.count > 0 => Ok(self.found),
            _ if self.singular => Err(KinematicError::Singular),
            Some((_, error)) => Err(error),
            None => Err(KinematicError::Unreachable),
        }
    }

    /// The column facing the flange, and facing away from it.
    fn sides(&mut self) {
        let [near1, near2, near3, near4, ..] = self.near;
        let [column, ..] = self.axes;
        let near_t4 = near4 + near3 + near2 + FRAC_PI_2;
        let p = self.pose.position;
        let on_axis = libm::sqrt(p.x * p.x + p.y * p.y) < ON_AXIS_M;
        let facing = if on_axis {
            *near1
        } else {
            libm::atan2(p.y, p.x)
        };
        let range = column.joint_position;
        let in_reach = p.dot(&p) <= REACH_M * REACH_M;
        let could_face = in_reach && range.contains(wrapped(facing, range.centre()));
        for t1 in [Some(facing), (!on_axis).then_some(facing + PI)]
            .into_iter()
            .flatten()
        {
            let (s1, c1) = libm::sincos(t1);
            let b = about_z(-s1, c1) * self.pose.rotation * flange_axes().transpose();
            for wrist in wrists(&b, near_t4).into_iter().flatten() {
                self.singular |= wrist.free && could_face;
                if let Some((t2, opening)) = elbow(c1 * p.x + s1 * p.y, p.z, wrist.t4) {
                    let q3 = opening - FRAC_PI_2;
                    let q4 = wrist.t4 - (t2 + opening);
                    self.turns([t1, t2, q3, q4, wrist.t5, wrist.t6]);
                }
            }
        }
    }

    /// Puts a candidate's angles into their ranges, in every turn of V, and files it.
    fn turns(&mut self, mut joints: [f64; 6]) {
        for (q, axis) in joints.iter_mut().zip(self.axes) {
            *q = wrapped(*q, axis.joint_position.centre());
        }
        let [q1, q2, q3, q4, v, q6] = joints;
        let [.., near_v, _] = self.near;
        let [.., v_axis, _] = self.axes;
        let reach = v_axis.joint_position;
        let inside = [-2.0, -1.0, 0.0, 1.0, 2.0]
            .map(|turn| v + turn * TURN)
            .map(|v| {
                (reach.lower - LIMIT_SLACK <= v && v <= reach.upper + LIMIT_SLACK).then_some(v)
            });
        let mut verified = None;
        if inside.iter().all(Option::is_none) {
            self.file([q1, q2, q3, q4, wrapped(v, *near_v), q6], &mut verified);
        }
        for v in inside.into_iter().flatten() {
            self.file([q1, q2, q3, q4, v, q6], &mut verified);
        }
    }

    /// Keeps a candidate inside the limits that reproduces the pose, else notes the reason. Whether another turn
    /// of V does, `verified`, holds for this one too, where none of both was put on a bound.
    fn file(&mut self, candidate: [f64; 6], verified: &mut Option<bool>) {
        let mut joints = candidate;
        let mut moved = false;
        for (k, (q, axis)) in (0..6_usize).zip(joints.iter_mut().zip(self.axes)) {
            let (range, value) = (axis.joint_position, *q);
            if value < range.lower && range.lower - value <= LIMIT_SLACK {
                *q = range.lower;
                moved = true;
            } else if value > range.upper && value - range.upper <= LIMIT_SLACK {
                *q = range.upper;
                moved = true;
            } else if !range.contains(value) {
                let squares = candidate
                    .iter()
                    .zip(self.near)
                    .map(|(q, n)| (q - n) * (q - n));
                let distance2 = squares.sum();
                if self.limit.is_none_or(|(least, _)| distance2 < least) {
                    let error = KinematicError::Limit {
                        axis: self.first_axis.saturating_add(k),
                        name: axis.name,
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
        let good = match *verified {
            Some(good) if !moved => good,
            _ => self.reproduces(&joints),
        };
        if !moved {
            *verified = Some(good);
        }
        if good {
            self.found.push(joints);
        }
    }

    /// Whether these joints put the flange at the pose.
    fn reproduces(&self, joints: &[f64; 6]) -> bool {
        let reached = forward(joints);
        let position = reached.position - self.pose.position;
        let rotation = reached.rotation - self.pose.rotation;
        let mut off = position.iter().chain(rotation.iter());
        off.all(|v| v.abs() <= VERIFY)
    }
}

/// The one or two decompositions of B = Y(t4)·X(t5)·Y(t6).
fn wrists(b: &Matrix3<f64>, near_t4: f64) -> [Option<Wrist>; 2] {
    let sine = libm::sqrt(b.m12 * b.m12 + b.m32 * b.m32);
    let complete = |t4: f64, s5: f64, free: bool| Some(wrist(b, t4, s5, free));
    if sine < SINGULAR_SINE {
        let s5 = b.m12 * libm::sin(near_t4) + b.m32 * libm::cos(near_t4);
        [complete(near_t4, s5, true), None]
    } else {
        [
            complete(libm::atan2(b.m12, b.m32), sine, false),
            complete(libm::atan2(-b.m12, -b.m32), -sine, false),
        ]
    }
}

/// The wrist for one of the two signs of its sine.
fn wrist(b: &Matrix3<f64>, t4: f64, s5: f64, free: bool) -> Wrist {
    let t5 = libm::atan2(s5, b.m22);
    let ((s4, c4), (sin5, cos5)) = (libm::sincos(t4), libm::sincos(t5));
    let rest = about_x(-sin5, cos5) * about_y(-s4, c4) * b;
    let t6 = libm::atan2(rest.m13 - rest.m31, rest.m11 + rest.m33);
    Wrist { t4, t5, t6, free }
}

/// t2 and the elbow's opening δ ∈ \[0, π\], or nothing where the wrist's centre is out of reach.
fn elbow(r: f64, h: f64, t4: f64) -> Option<(f64, f64)> {
    let (s4, c4) = libm::sincos(t4);
    let (e, f) = (r - WRIST_M * c4, -h - WRIST_M * s4);
    let cos = (e * e + f * f - LOWER_ARM_M * LOWER_ARM_M - UPPER_ARM_M * UPPER_ARM_M)
        / (2.0 * LOWER_ARM_M * UPPER_ARM_M);
    if !(-1.0..=1.0).contains(&cos) {
        return None;
    }
    let sin = libm::sqrt((1.0 - cos) * (1.0 + cos));
    let t2 = libm::atan2(f, e) - libm::atan2(UPPER_ARM_M * sin, LOWER_ARM_M + UPPER_ARM_M * cos);
    Some((t2, libm::atan2(sin, cos)))
}
