//! Polycrank: seven direct-drive axes that turn without end.
//!
//! # Geometry
//!
//! Standard Denavit–Hartenberg, m (mzbikows/graspit, `Polycrank.xml`; the axes' directions agree with
//! mzbikows/zbik3d). Base frame: origin on the floor below axis 1, z up.
//!
//! ```text
//!   axis   1      2      3      4      5      6      7
//!   d      0.220  0.152  0.335  0.120  0.116  0.060  0.043
//!   a     −0.299  0.180  0      0.151  0.151  0      0
//!   α      0      0      90°    0      0      90°    0
//! ```
//!
//! Axes 1–3 are vertical and parallel, 4–6 horizontal and parallel, 7 is the roll about the flange's
//! A. With φ = q1 + q2 + q3, ψ = q4 + q5 + q6, x = (cos φ, sin φ, 0) and n = (sin φ, −cos φ, 0),
//!
//! ```text
//!   R = Z(φ)·X(90°)·Z(ψ)·X(90°)·Z(q7)        A = x·sin ψ − z·cos ψ
//!   p = c + x·u + z·(H + w) + n·D + A·d7     H = 0.925 + d1 + d2 + d3,  D = d4 + d5 + d6
//!   c = a1·(cos q1, sin q1) + a2·(cos(q1 + q2), sin(q1 + q2))     the first pair of cranks
//!   (u, w) = a4·(cos q4, sin q4) + a5·(cos(q4 + q5), sin(q4 + q5))     the second pair
//! ```

mod data;
mod inverse;

use motion::Pose;
use nalgebra::{ArrayStorage, Matrix3, SMatrix, Vector3};

use crate::description::RobotDescription;
use crate::dynamics::{Chain, POLYCRANK};
use crate::error::KinematicError;
use crate::robot::{Inverse, Robot};
use crate::space::Joints;
use data::{AXIS4_HEIGHT_M, CRANKS_M, FLANGE_M, SIDE_M};

/// Polycrank, 7 axes, no limits of position.
///
/// Seven axes for six coordinates: the free parameter of a pose is u, how far the second pair of
/// cranks reaches along its vertical plane ([`Polycrank::reach`]). [`Robot::inverse`] keeps the u of
/// `near` where the pose allows it, else takes the nearest that is allowed;
/// [`Polycrank::inverse_at`] takes it explicitly. Every joint comes in the turn nearest to `near`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Polycrank;

/// Points and directions of a configuration, in the base frame.
struct Frames {
    /// Points of the axes 2 and 3, which are vertical like the first through the origin.
    axis2: Vector3<f64>,
    axis3: Vector3<f64>,
    /// Points of the axes 4, 5 and 6, and their common direction n.
    axis4: Vector3<f64>,
    axis5: Vector3<f64>,
    axis6: Vector3<f64>,
    n: Vector3<f64>,
    flange: Pose,
}

fn frames(Joints([q1, q2, q3, q4, q5, q6, q7]): &Joints<7>) -> Frames {
    let [a1, a2, a4, a5] = CRANKS_M;
    let level = |angle: f64| Vector3::new(libm::cos(angle), libm::sin(angle), 0.0);
    let (phi, psi) = (q1 + q2 + q3, q4 + q5 + q6);
    let (x, z) = (level(phi), Vector3::z());
    let n = Vector3::new(x.y, -x.x, 0.0);
    let upright = |angle: f64| x * libm::cos(angle) + z * libm::sin(angle);
    let axis2 = level(*q1) * a1;
    let axis3 = axis2 + level(q1 + q2) * a2;
    let axis4 = axis3 + z * AXIS4_HEIGHT_M;
    let axis5 = axis4 + upright(*q4) * a4;
    let axis6 = axis5 + upright(q4 + q5) * a5;
    // the frame of axis 7: its x along ψ in the plane, its z is A
    let (along, a) = (upright(psi), x * libm::sin(psi) - z * libm::cos(psi));
    let across = a.cross(&along);
    let (s, c) = (libm::sin(*q7), libm::cos(*q7));
    Frames {
        axis2,
        axis3,
        axis4,
        axis5,
        axis6,
        n,
        flange: Pose {
            position: axis6 + n * SIDE_M + a * FLANGE_M,
            rotation: Matrix3::from_columns(&[along * c + across * s, across * c - along * s, a]),
        },
    }
}

impl Polycrank {
    /// u of a configuration, m: how far the second pair of cranks reaches along its plane.
    #[must_use]
    pub fn reach(&self, Joints([_, _, _, q4, q5, _, _]): &Joints<7>) -> f64 {
        let [_, _, a4, a5] = CRANKS_M;
        a4 * libm::cos(*q4) + a5 * libm::cos(q4 + q5)
    }

    /// Every configuration that reaches `flange` with the second pair of cranks reaching `reach_m`
    /// along its plane, in turns nearest to `near`; at most eight: the plane and its opposite, twice
    /// two bends of a pair of cranks.
    ///
    /// # Errors
    /// As [`Robot::inverse`]; [`KinematicError::Unreachable`] also where another reach would do.
    pub fn inverse_at(
        &self,
        flange: &Pose,
        near: &Joints<7>,
        reach_m: f64,
    ) -> Result<Inverse<7>, KinematicError> {
        inverse::solve(flange, near, |_| Some(reach_m))
    }
}

impl Robot<7> for Polycrank {
    fn description(&self) -> &'static RobotDescription<7> {
        &data::DESCRIPTION
    }

    fn forward(&self, joints: &Joints<7>) -> Pose {
        frames(joints).flange
    }

    fn inverse(&self, flange: &Pose, near: &Joints<7>) -> Result<Inverse<7>, KinematicError> {
        let wanted = self.reach(near);
        inverse::solve(flange, near, |allowed| allowed.nearest(wanted))
    }

    /// With u exactly as in `near`: where the pose does not allow it the way ends, since another u
    /// would be a jump.
    fn inverse_near(&self, flange: &Pose, near: &Joints<7>) -> Result<Joints<7>, KinematicError> {
        self.inverse_at(flange, near, self.reach(near))
            .map(|solution| solution.nearest())
    }

    /// A turn about the unit vector w through the point o moves the flange at (w × (p − o); w).
    fn chain(&self) -> Option<Chain<7>> {
        Some(POLYCRANK)
    }

    fn jacobian(&self, joints: &Joints<7>) -> SMatrix<f64, 6, 7> {
        let f = frames(joints);
        let p = f.flange.position;
        let a = f.flange.rotation.column(2).into_owned();
        let turn = |w: Vector3<f64>, o: Vector3<f64>| {
            let v = w.cross(&(p - o));
            [v.x, v.y, v.z, w.x, w.y, w.z]
        };
        SMatrix::from_array_storage(ArrayStorage([
            turn(Vector3::z(), Vector3::zeros()),
            turn(Vector3::z(), f.axis2),
            turn(Vector3::z(), f.axis3),
            turn(f.n, f.axis4),
            turn(f.n, f.axis5),
            turn(f.n, f.axis6),
            turn(a, p),
        ]))
    }
}
