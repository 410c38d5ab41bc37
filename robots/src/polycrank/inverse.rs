//! Inverse kinematics of Polycrank: every branch at one reach u.
//!
//! # Derivation (symbols of the module's page)
//!
//! *Plane.* A = x·sin ψ − z·cos ψ lies in the vertical plane of the second pair of cranks, so its
//! level part gives φ up to half a turn, and then ψ. What is left of R is the roll q7.
//!
//! *Second pair.* p − A·d7 − n·D = c + x·u + z·(H + w) gives w; with the free u chosen, (u, w) is a
//! point two cranks reach in at most two ways, by the law of cosines: with lengths a, b and distance r
//!
//! ```text
//!   cos q'' = (r² − a² − b²)/(2·a·b)    q' = atan2(y, x) − atan2(b·sin q'', a + b·cos q'')
//! ```
//!
//! *First pair.* What is left of p in the plane of the floor, c, is reached likewise. Last
//! q3 = φ − q1 − q2 and q6 = ψ − q4 − q5.
//!
//! *Which u.* Two cranks reach w only with |u| ≤ U = √((a4 + a5)² − w²). With m the distance of
//! p − A·d7 − n·D along x and k across, the first pair must span (m − u)² + k² between
//! (|a1| − |a2|)² and (|a1| + |a2|)²: at most two intervals of u, below m and above.
//!
//! # Where a joint is free
//!
//! sin ψ = 0 (A vertical): only a sum of φ and q7 is given. φ keeps its value from `near`; where that
//! leaves nothing, the answer is *singular*. u = w = 0: the second pair is folded, q4 keeps its value.

use core::f64::consts::PI;

use motion::Pose;
use nalgebra::{Matrix3, Vector3};

use super::data::{AXIS4_HEIGHT_M, CRANKS_M, FLANGE_M, SIDE_M};
use super::frames;
use crate::error::KinematicError;
use crate::gearing::finite;
use crate::orientation::{orthonormal, wrapped};
use crate::robot::{Inverse, MAX_BRANCHES};
use crate::space::Joints;

/// Below this sine of ψ only a sum of φ and q7 is given: keeping φ costs less orientation than this.
const SINGULAR_SINE: f64 = 1e-9;
/// Below this, m, a pair of equal cranks is folded.
const FOLDED_M: f64 = 1e-9;
/// A cosine this little beyond ±1 is a pair of cranks stretched or folded.
const STRETCH_SLACK: f64 = 1e-12;
/// How well a branch must reproduce the pose, m and 1.
const VERIFY: f64 = 1e-8;
/// A reach that has to be changed is put this far inside what is allowed, m, or a quarter of it: at
/// the bound a pair of cranks is stretched.
const INSIDE_M: f64 = 0.01;

/// The reaches u a pose allows: at most two intervals, m.
#[derive(Clone, Copy, Debug)]
pub(super) struct Allowed([Option<(f64, f64)>; 2]);

impl Allowed {
    /// The allowed value nearest to `wanted`; somewhat inside where that is not allowed itself.
    pub(super) fn nearest(&self, wanted: f64) -> Option<f64> {
        let mut best: Option<(f64, f64)> = None;
        for (low, high) in self.0.into_iter().flatten() {
            let quarter = 0.25 * (high - low);
            let inside = if quarter < INSIDE_M {
                quarter
            } else {
                INSIDE_M
            };
            let value = if wanted < low {
                low + inside
            } else if wanted > high {
                high - inside
            } else {
                wanted
            };
            let away = libm::fabs(value - wanted);
            if best.is_none_or(|(least, _)| away < least) {
                best = Some((away, value));
            }
        }
        best.map(|(_, value)| value)
    }
}

/// A vertical plane for the second pair of cranks, and what the pose asks of it.
struct Plane {
    phi: f64,
    psi: f64,
    roll: f64,
    x: Vector3<f64>,
    /// p − A·d7 − n·D.
    axis6: Vector3<f64>,
    /// The component of that along x, across, and above axis 4.
    along: f64,
    across: f64,
    above: f64,
}

impl Plane {
    fn new(pose: &Pose, phi: f64, psi: f64) -> Self {
        let x = Vector3::new(libm::cos(phi), libm::sin(phi), 0.0);
        let n = Vector3::new(x.y, -x.x, 0.0);
        let (first, second, a) = columns(&pose.rotation);
        let u = x * libm::cos(psi) + Vector3::z() * libm::sin(psi);
        let roll = libm::atan2(
            n.dot(&first) - u.dot(&second),
            u.dot(&first) + n.dot(&second),
        );
        let axis6 = pose.position - a * FLANGE_M - n * SIDE_M;
        Self {
            phi,
            psi,
            roll,
            x,
            axis6,
            along: x.dot(&axis6),
            across: n.dot(&axis6),
            above: axis6.z - AXIS4_HEIGHT_M,
        }
    }

    fn allowed(&self) -> Allowed {
        let [a1, a2, a4, a5] = CRANKS_M;
        let (long, short) = (a1.abs() + a2.abs(), a1.abs() - a2.abs());
        let half = |radius: f64, off: f64| {
            let square = radius * radius - off * off;
            (square >= 0.0).then(|| libm::sqrt(square))
        };
        let (Some(reach), Some(outer)) = (half(a4 + a5, self.above), half(long, self.across))
        else {
            return Allowed([None; 2]);
        };
        let inner = half(short, self.across).unwrap_or(0.0);
        let cut = |low: f64, high: f64| {
            let low = if low < -reach { -reach } else { low };
            let high = if high > reach { reach } else { high };
            (low <= high).then_some((low, high))
        };
        let m = self.along;
        Allowed([cut(m - outer, m - inner), cut(m + inner, m + outer)])
    }

    /// The configurations with the reach `u`.
    fn configurations(&self, u: f64, near: &Joints<7>) -> [Option<Joints<7>>; 4] {
        let Joints([near1, _, _, near4, ..]) = near;
        let [a1, a2, a4, a5] = CRANKS_M;
        let c = self.axis6 - self.x * u;
        let first = pair(a1, a2, c.x, c.y, *near1);
        let second = pair(a4, a5, u, self.above, *near4);
        let mut found = [None; 4];
        let joined = first
            .into_iter()
            .flatten()
            .flat_map(|one| second.into_iter().flatten().map(move |two| (one, two)));
        for (slot, ((q1, q2), (q4, q5))) in found.iter_mut().zip(joined) {
            let mut q = [
                q1,
                q2,
                self.phi - q1 - q2,
                q4,
                q5,
                self.psi - q4 - q5,
                self.roll,
            ];
            for (q, near) in q.iter_mut().zip(near.0) {
                *q = wrapped(*q, near);
            }
            *slot = Some(Joints(q));
        }
        found
    }
}

fn columns(r: &Matrix3<f64>) -> (Vector3<f64>, Vector3<f64>, Vector3<f64>) {
    (
        r.column(0).into_owned(),
        r.column(1).into_owned(),
        r.column(2).into_owned(),
    )
}

/// The ways two cranks of (signed) lengths `a` and `b` reach the point: angle of the first, and of
/// the second against it.
fn pair(a: f64, b: f64, x: f64, y: f64, near: f64) -> [Option<(f64, f64)>; 2] {
    let square = x * x + y * y;
    let cos = (square - a * a - b * b) / (2.0 * a * b);
    let most = 1.0 + STRETCH_SLACK;
    if !(-most..=most).contains(&cos) {
        return [None; 2];
    }
    let rest = (1.0 - cos) * (1.0 + cos);
    let sin = if rest > 0.0 { libm::sqrt(rest) } else { 0.0 };
    let bend = |sin: f64| {
        let second = libm::atan2(sin, cos);
        let first = if square < FOLDED_M * FOLDED_M {
            near
        } else {
            libm::atan2(y, x) - libm::atan2(b * sin, a + b * cos)
        };
        Some((first, second))
    };
    [bend(sin), if sin > 0.0 { bend(-sin) } else { None }]
}

/// Every configuration that reaches the pose with the reach that `choose` takes of those allowed, in
/// each of the two planes.
pub(super) fn solve(
    pose: &Pose,
    near: &Joints<7>,
    choose: impl Fn(&Allowed) -> Option<f64>,
) -> Result<Inverse<7>, KinematicError> {
    finite(&near.0)?;
    finite(pose.position.as_slice())?;
    let pose = Pose {
        rotation: orthonormal(&pose.rotation)?,
        ..*pose
    };
    let Joints([near1, near2, near3, ..]) = near;
    let (_, _, a) = columns(&pose.rotation);
    let sine = libm::sqrt(a.x * a.x + a.y * a.y);
    let singular = sine < SINGULAR_SINE;
    let planes = if singular {
        let phi = near1 + near2 + near3;
        let s = a.x * libm::cos(phi) + a.y * libm::sin(phi);
        [Some(Plane::new(&pose, phi, libm::atan2(s, -a.z))), None]
    } else {
        let phi = libm::atan2(a.y, a.x);
        [
            Some(Plane::new(&pose, phi, libm::atan2(sine, -a.z))),
            Some(Plane::new(&pose, phi + PI, libm::atan2(-sine, -a.z))),
        ]
    };
    let mut found = [None; MAX_BRANCHES];
    let candidates = planes.iter().flatten().flat_map(|plane| {
        choose(&plane.allowed()).map_or([None; 4], |u| plane.configurations(u, near))
    });
    for (slot, joints) in found.iter_mut().zip(candidates.flatten()) {
        let reached = frames(&joints).flange;
        let position = reached.position - pose.position;
        let rotation = reached.rotation - pose.rotation;
        let off = position.iter().chain(rotation.iter());
        *slot = off
            .copied()
            .all(|v| libm::fabs(v) <= VERIFY)
            .then_some(joints);
    }
    let none = if singular {
        KinematicError::Singular
    } else {
        KinematicError::Unreachable
    };
    Inverse::new(found.into_iter().flatten(), near).ok_or(none)
}
