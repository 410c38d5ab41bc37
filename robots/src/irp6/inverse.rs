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
//! orientation. Sines and cosines of these angles are what they were found from, so none is taken of an angle.
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

use super::arm::forward;
use super::data::{LOWER_ARM_M, UPPER_ARM_M, WRIST_M};
use crate::along::PoseAlong;
use crate::description::AxisDescription;
use crate::error::{KinematicError, Quantity};
use crate::gearing::finite;
use crate::jet::{Jet, Turn, angle_rates};
use crate::narrow::narrow;
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

/// The solution on the branch of `near`, without looking at the others; nothing where the
/// branch is not plain (on the column's axis, at a singular wrist, outside the limits or the reach):
/// then all branches must be looked at.
pub(super) fn continuing(
    pose: &Pose,
    near: &[f64; 6],
    axes: &[AxisDescription; 6],
) -> Option<Plain> {
    let [near1, near2, near3, near4, ..] = *near;
    let (p, near_t4) = (pose.position, near4 + near3 + near2 + FRAC_PI_2);
    let level = libm::sqrt(p.x * p.x + p.y * p.y);
    if level < PLAIN {
        return None;
    }
    // the flange is in front of the column, or behind it: where it has been
    let facing = libm::atan2(p.y, p.x);
    let away = turned_over(facing, near1);
    let (t1, r) = if away {
        (facing + PI, -level)
    } else {
        (facing, level)
    };
    let (s1, c1) = (p.y / r, p.x / r);
    let b = Turned::new(&pose.rotation, s1, c1);
    let sine = b.sine();
    if sine < PLAIN {
        return None;
    }
    let t4 = libm::atan2(b.m12, b.m32);
    let (t4, s5) = if turned_over(t4, near_t4) {
        (t4 + PI, -sine)
    } else {
        (t4, sine)
    };
    let wrist = Wrist::new(&b, t4, s5);
    let elbow = Elbow::new(r, p.z, wrist.s4, wrist.c4)?;
    let mut joints = joined(t1, &elbow, &wrist);
    for ((q, near), axis) in joints.iter_mut().zip(near).zip(axes) {
        *q = wrapped(*q, *near);
        if !axis.joint_position.contains(*q) {
            return None;
        }
    }
    Some(Plain {
        joints,
        s1,
        c1,
        r,
        b,
        wrist,
        elbow,
    })
}

/// Is an angle more than a quarter of a turn from another, on the shorter way? Then the opposite one is nearer.
fn turned_over(angle: f64, near: f64) -> bool {
    libm::fabs(wrapped(angle, near) - near) > FRAC_PI_2
}

/// A solution, and the sines and cosines that it was found from.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plain {
    pub(super) joints: [f64; 6],
    s1: f64,
    c1: f64,
    /// Of the flange from the column's axis in the arm's plane, m.
    r: f64,
    b: Turned,
    wrist: Wrist,
    elbow: Elbow,
}

/// Nearer to a singular wrist (sine of t5) there are no rates: of T and N they would be off by 6e-8 over it.
const RATES_SINE: f64 = 0.01;

impl Plain {
    /// Derivatives of the joints on the flange's path: those of the equations above, by the product rule.
    pub(super) fn rates(&self, flange: &PoseAlong) -> Option<[[f32; 6]; 3]> {
        let Self {
            b, wrist, elbow, ..
        } = self;
        if libm::fabs(wrist.s5) < RATES_SINE {
            return None;
        }
        let [x, y, z] = flange.origin();
        let column = Turn::new(angle_rates(y, x), self.s1, self.c1);
        // along the arm's plane and across
        let ahead = |x: Jet, y: Jet| column.cosine * x + column.sine * y;
        let r = ahead(x, y).with_value(self.r);
        let frame = &flange.pose.rotation;
        let [ax, ay, az] = flange.turning(&frame.column(2).into_owned());
        let m12 = ahead(ax, ay).with_value(b.m12);
        let m22 = column.cosine * ay - column.sine * ax;
        let m32 = az.with_value(b.m32);
        let pitch = Turn::new(angle_rates(m12, m32), wrist.s4, wrist.c4);
        let s5 = (m12 * pitch.sine + m32 * pitch.cosine).with_value(wrist.s5);
        let v = angle_rates(s5, m22);
        let [nx, ny, nz] = flange.turning(&frame.column(0).into_owned());
        let [ox, oy, oz] = flange.turning(&frame.column(1).into_owned());
        let s6 = pitch.cosine * ahead(nx, ny) - pitch.sine * nz;
        let c6 = pitch.cosine * ahead(ox, oy) - pitch.sine * oz;
        let n = angle_rates(s6, c6);
        let e = (r - pitch.cosine * narrow(WRIST_M)).with_value(elbow.e);
        let f = (z + pitch.sine * narrow(WRIST_M)) * -1.0;
        let f = f.with_value(elbow.f);
        let cos =
            ((e * e + f * f) * narrow(0.5 / (LOWER_ARM_M * UPPER_ARM_M))).with_value(elbow.cos);
        let bend = Turn::new(opening_rates(cos, elbow.sin), elbow.sin, elbow.cos);
        let reach = (bend.cosine * narrow(UPPER_ARM_M)).plus(narrow(LOWER_ARM_M));
        let wrist_from_elbow = angle_rates(bend.sine * narrow(UPPER_ARM_M), reach);
        let wrist_centre = angle_rates(f, e);
        let mut out = [[0.0; 6]; 3];
        let arm = wrist_centre.iter().zip(&wrist_from_elbow);
        let wrist = pitch.rates.iter().zip(&v).zip(&n);
        let each = column.rates.iter().zip(&bend.rates).zip(arm).zip(wrist);
        for (out, (((q1, q3), (centre, inner)), ((t4, q5), q6))) in out.iter_mut().zip(each) {
            let t2 = centre - inner;
            *out = [*q1, t2, *q3, t4 - t2 - q3, *q5, *q6];
        }
        Some(out)
    }
}

/// The derivatives of an angle by those of its cosine: cos' = −sin·δ', and twice the product rule.
fn opening_rates(Jet([c, c1, c2, c3]): Jet, sine: f64) -> [f32; 3] {
    let s = narrow(sine);
    let per_sine = -1.0 / s;
    let first = c1 * per_sine;
    let second = (c2 + c * first * first) * per_sine;
    let third = (c3 + 3.0 * c * first * second - s * first * first * first) * per_sine;
    [first, second, third]
}

/// A search for branches: what is asked, what was found, and the best reason if nothing is.
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
            let b = Turned::new(&self.pose.rotation, s1, c1);
            let (free, found) = wrists(&b, near_t4);
            for wrist in found.into_iter().flatten() {
                self.singular |= free && could_face;
                if let Some(elbow) = Elbow::new(c1 * p.x + s1 * p.y, p.z, wrist.s4, wrist.c4) {
                    self.turns(joined(t1, &elbow, &wrist));
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

/// What is read of B = Z(t1)ᵀ·R·Πᵀ, whose columns are Z(t1)ᵀ times O, A and N.
#[derive(Clone, Copy, Debug)]
struct Turned {
    m11: f64,
    m12: f64,
    m13: f64,
    m22: f64,
    m31: f64,
    m32: f64,
    m33: f64,
}

impl Turned {
    fn new(r: &Matrix3<f64>, s1: f64, c1: f64) -> Self {
        Self {
            m11: c1 * r.m12 + s1 * r.m22,
            m12: c1 * r.m13 + s1 * r.m23,
            m13: c1 * r.m11 + s1 * r.m21,
            m22: c1 * r.m23 - s1 * r.m13,
            m31: r.m32,
            m32: r.m33,
            m33: r.m31,
        }
    }

    /// |sin t5|
    fn sine(&self) -> f64 {
        libm::sqrt(self.m12 * self.m12 + self.m32 * self.m32)
    }
}

/// Wrist angles t4, t5, t6, with what they were found from.
#[derive(Clone, Copy, Debug)]
struct Wrist {
    t4: f64,
    s4: f64,
    c4: f64,
    s5: f64,
    t5: f64,
    t6: f64,
}

impl Wrist {
    /// For one of the two signs of its sine, not 0.
    fn new(b: &Turned, t4: f64, s5: f64) -> Self {
        Self::at(b, t4, s5, b.m12 / s5, b.m32 / s5)
    }

    /// X leaves the first row alone: that of Y(t4)ᵀ·B is (cos t6, 0, sin t6).
    fn at(b: &Turned, t4: f64, s5: f64, s4: f64, c4: f64) -> Self {
        Self {
            t4,
            s4,
            c4,
            s5,
            t5: libm::atan2(s5, b.m22),
            t6: libm::atan2(c4 * b.m13 - s4 * b.m33, c4 * b.m11 - s4 * b.m31),
        }
    }
}

/// Whether t4 is free, and the one or two decompositions of B = Y(t4)·X(t5)·Y(t6).
fn wrists(b: &Turned, near_t4: f64) -> (bool, [Option<Wrist>; 2]) {
    let sine = b.sine();
    if sine < SINGULAR_SINE {
        let (s4, c4) = libm::sincos(near_t4);
        let s5 = b.m12 * s4 + b.m32 * c4;
        (true, [Some(Wrist::at(b, near_t4, s5, s4, c4)), None])
    } else {
        let found = [
            Wrist::new(b, libm::atan2(b.m12, b.m32), sine),
            Wrist::new(b, libm::atan2(-b.m12, -b.m32), -sine),
        ];
        (false, found.map(Some))
    }
}

/// The elbow's opening δ ∈ \[0, π\] and the lower arm's t2.
#[derive(Clone, Copy, Debug)]
struct Elbow {
    /// The wrist's centre from the shoulder, in the arm's plane, m.
    e: f64,
    f: f64,
    sin: f64,
    cos: f64,
    opening: f64,
    t2: f64,
}

impl Elbow {
    /// For a flange at r and h in the arm's plane; nothing where the wrist's centre is out of reach.
    fn new(r: f64, h: f64, s4: f64, c4: f64) -> Option<Self> {
        const TWICE: f64 = 2.0 * LOWER_ARM_M * UPPER_ARM_M;
        const SQUARES: f64 = LOWER_ARM_M * LOWER_ARM_M + UPPER_ARM_M * UPPER_ARM_M;
        let (e, f) = (r - WRIST_M * c4, -h - WRIST_M * s4);
        let cos = (e * e + f * f - SQUARES) / TWICE;
        if !(-1.0..=1.0).contains(&cos) {
            return None;
        }
        let sin = libm::sqrt((1.0 - cos) * (1.0 + cos));
        // the difference of two angles is the angle of (e, f) turned back by the other
        let (across, along) = (UPPER_ARM_M * sin, LOWER_ARM_M + UPPER_ARM_M * cos);
        Some(Self {
            e,
            f,
            sin,
            cos,
            opening: libm::atan2(sin, cos),
            t2: libm::atan2(f * along - e * across, e * along + f * across),
        })
    }
}

/// The joints of these angles, in any turn.
fn joined(t1: f64, elbow: &Elbow, wrist: &Wrist) -> [f64; 6] {
    let Elbow { t2, opening, .. } = *elbow;
    let (q3, q4) = (opening - FRAC_PI_2, wrist.t4 - (t2 + opening));
    [t1, t2, q3, q4, wrist.t5, wrist.t6]
}
