//! Mass matrix, acceleration of given torques, energy.
//!
//! The mass matrix is found by the composite rigid body algorithm (Walker and Orin 1982; Featherstone,
//! RBDA, table 6.2): column j is the momentum of all links from j on, as one rigid body that moves at a
//! unit rate of joint j, handed inwards and projected on each axis passed.
//!
//! Forward dynamics solves M·q̈ = τ − bias by M = Lᵀ·D·L with L unit lower triangular, the
//! factorisation of RBDA table 6.3, here from the last row up, in the order in which the rows arise.

use nalgebra::{SMatrix, Vector3};

use super::algebra::{Triple, add, cross, outward};
use super::body::{Moments, field};
use super::chain::Posture;
use super::inverse::Wrench;
use crate::description::JointKind;

impl Moments {
    /// Linear and angular momentum about the origin, N·s and N·m·s, at a unit rate of the joint whose
    /// axis is z: turning, (z × h, (tr(Σ)·1 − Σ)·z); sliding, (m·z, h × z).
    #[inline]
    const fn unit_momentum(&self, kind: JointKind) -> (Triple, Triple) {
        let ([x, y, _], second) = (self.first, self.second);
        match kind {
            JointKind::Revolute => (
                [-y, x, 0.0],
                [-second.xz, -second.yz, second.xx + second.yy],
            ),
            JointKind::Prismatic => ([0.0, 0.0, self.mass], [y, -x, 0.0]),
        }
    }
}

/// The component a joint feels.
#[inline]
const fn along_axis(kind: JointKind, (f, n): (Triple, Triple)) -> f64 {
    match kind {
        JointKind::Revolute => n[2],
        JointKind::Prismatic => f[2],
    }
}

impl<const N: usize> Posture<'_, N> {
    /// The rows of M up to the diagonal; what is beyond it is zero.
    fn lower_rows(&self) -> [[f64; N]; N] {
        let mut rows = [[0.0; N]; N];
        let mut composite: Option<Moments> = None;
        let (mut links, mut placed) = (self.chain.links.as_slice(), self.placed.as_slice());
        for row in rows.iter_mut().rev() {
            let (Some((link, before)), Some((here, placed_before))) =
                (links.split_last(), placed.split_last())
            else {
                break;
            };
            let body = match composite {
                Some(after) => link.moments().plus(after),
                None => *link.moments(),
            };
            let mut momentum = body.unit_momentum(link.kind);
            let mut entries = row.iter_mut().take(links.len()).rev();
            if let Some(diagonal) = entries.next() {
                *diagonal = along_axis(link.kind, momentum);
            }
            // from frame to frame inwards
            for ((entry, link), placed) in entries.zip(before.iter().rev()).zip(placed.iter().rev())
            {
                let f = outward(&placed.axes, momentum.0);
                let n = add(outward(&placed.axes, momentum.1), cross(placed.offset, f));
                momentum = (f, n);
                *entry = along_axis(link.kind, momentum);
            }
            composite = Some(body.moved(&here.axes, here.offset));
            (links, placed) = (before, placed_before);
        }
        rows
    }

    /// The mass matrix M(q): kg·m², and kg and kg·m where joints slide. Symmetric, positive definite.
    #[must_use]
    pub fn mass_matrix(&self) -> SMatrix<f64, N, N> {
        let rows = self.lower_rows();
        let mut matrix = SMatrix::<f64, N, N>::zeros();
        // columns of the matrix are the rows, which hold its upper triangle so
        for (mut column, row) in matrix.column_iter_mut().zip(&rows) {
            for (entry, value) in column.iter_mut().zip(row) {
                *entry = *value;
            }
        }
        matrix.fill_lower_triangle_with_upper_triangle();
        matrix
    }

    /// Accelerations of the joints, rad/s² or m/s², under torques `tau`, N·m or N, while they move at
    /// `dq`, rad/s or m/s: the inverse of [`Posture::inverse_dynamics`], with the same arguments.
    ///
    /// A chain whose last links have no mass gives infinities or NaN.
    #[must_use]
    pub fn forward_dynamics(
        &self,
        dq: &[f64; N],
        tau: &[f64; N],
        gravity: &Vector3<f64>,
        wrench: &Wrench,
    ) -> [f64; N] {
        let mut right = self.bias_torques(dq, gravity, wrench);
        for (right, tau) in right.iter_mut().zip(tau) {
            *right = tau - *right;
        }
        solve(self.lower_rows(), right)
    }

    /// Kinetic energy at joint velocities, rad/s or m/s, in J: half the sum over the links of
    /// ∫|v + ω × r|² dm = m·|v|² + 2·v·(ω × h) − tr(\[ω×\]²·Σ).
    #[must_use]
    pub fn kinetic_energy(&self, dq: &[f64; N]) -> f64 {
        let (mut v, mut w) = ([0.0; 3], [0.0; 3]);
        let mut twice = 0.0;
        for ((placed, link), dq) in self.placed.iter().zip(&self.chain.links).zip(dq) {
            v = super::algebra::inward(&placed.axes, add(v, cross(w, placed.offset)));
            w = super::algebra::inward(&placed.axes, w);
            match link.kind {
                JointKind::Revolute => w[2] += dq,
                JointKind::Prismatic => v[2] += dq,
            }
            let Moments {
                mass,
                first,
                second,
            } = *link.moments();
            let [ex, ey, ez] = field(w, [0.0; 3]);
            let [sx, sy, sz] = second.columns();
            let dot = super::algebra::dot;
            twice += mass * dot(v, v) + 2.0 * dot(v, cross(w, first))
                - (dot(ex, sx) + dot(ey, sy) + dot(ez, sz));
        }
        0.5 * twice
    }

    /// Potential energy in a field of gravity, m/s² in the base frame, in J: −g·Σ m·c; zero where the
    /// centre of mass is at the base's origin.
    #[must_use]
    pub fn potential_energy(&self, gravity: &Vector3<f64>) -> f64 {
        let mut energy = 0.0;
        for (pose, link) in self.link_poses().iter().zip(&self.chain.links) {
            let Moments { mass, first, .. } = *link.moments();
            let moment = pose.position * mass + pose.rotation * Vector3::from(first);
            energy -= gravity.dot(&moment);
        }
        energy
    }
}

/// x of M·x = b, M symmetric and positive definite and given by its rows up to the diagonal.
///
/// M = Lᵀ·D·L from the last row up; the division of b by Lᵀ goes along. Then L·x = y/D downwards.
pub(super) fn solve<const N: usize>(mut rows: [[f64; N]; N], mut b: [f64; N]) -> [f64; N] {
    let (mut above, mut b_above) = (rows.as_mut_slice(), b.as_mut_slice());
    for _ in 0..N {
        let (Some((pivot_row, rest)), Some((pivot_b, b_rest))) =
            (above.split_last_mut(), b_above.split_last_mut())
        else {
            break;
        };
        let Some(pivot) = pivot_row.get(rest.len()) else {
            break;
        };
        let inverse = 1.0 / pivot;
        let ratios = pivot_row.map(|entry| entry * inverse);
        for ((row, b), ratio) in rest.iter_mut().zip(b_rest.iter_mut()).zip(ratios) {
            // entries beyond the diagonal change too, and are never read
            for (entry, pivot) in row.iter_mut().zip(&*pivot_row) {
                *entry -= ratio * pivot;
            }
            *b -= ratio * *pivot_b;
        }
        *pivot_b *= inverse;
        *pivot_row = ratios;
        (above, b_above) = (rest, b_rest);
    }
    let mut x = [0.0; N];
    for (k, (row, y)) in rows.iter().zip(b).enumerate() {
        let known: f64 = row.iter().zip(&x).take(k).map(|(l, x)| l * x).sum();
        if let Some(x) = x.get_mut(k) {
            *x = y - known;
        }
    }
    x
}
