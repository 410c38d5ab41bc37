//! Mass matrix, acceleration of given torques, energy.
//!
//! The mass matrix is found by the composite rigid body algorithm (Walker and Orin 1982; Featherstone,
//! RBDA, table 6.2): column j is the momentum of all links from j on, as one rigid body that moves at a
//! unit rate of joint j, handed inwards and projected on each axis passed.
//!
//! Forward dynamics solves M·q̈ = τ − bias by M = L·D·Lᵀ. `oracles/pinocchio` says what it costs beside
//! the articulated body algorithm of Pinocchio.

use nalgebra::{ArrayStorage, SMatrix, Vector3};

use super::algebra::{Triple, add, cross, dot, inward, outward};
use super::body::{Moments, field};
use super::chain::{Placed, Posture};
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
const fn along_axis(kind: JointKind, (f, n): &(Triple, Triple)) -> f64 {
    match kind {
        JointKind::Revolute => n[2],
        JointKind::Prismatic => f[2],
    }
}

impl<const N: usize> Posture<'_, N> {
    /// The rows of M from the diagonal on; what is before it is zero.
    #[inline]
    fn upper_rows(&self) -> [[f64; N]; N] {
        let mut rows = [[0.0; N]; N];
        let mut momenta = [([0.0; 3], [0.0; 3]); N];
        let mut after: Option<(Moments, &Placed)> = None;
        let links = self.chain.links.iter().zip(&self.placed);
        for (joint, (row, (link, placed))) in (0..N).zip(rows.iter_mut().zip(links)).rev() {
            let mut body = *link.moments();
            let (Some(momenta), Some(entries)) = (momenta.get_mut(joint..), row.get_mut(joint..))
            else {
                break;
            };
            let mut lanes = momenta.iter_mut().zip(entries);
            let own = lanes.next();
            if let Some((composite, placed)) = after {
                body = body.plus(composite.moved(&placed.axes, placed.offset));
                let Placed { axes, offset } = *placed;
                for (momentum, entry) in lanes {
                    let f = outward(&axes, momentum.0);
                    let n = add(outward(&axes, momentum.1), cross(offset, f));
                    *momentum = (f, n);
                    *entry = along_axis(link.kind, momentum);
                }
            }
            if let Some((momentum, diagonal)) = own {
                *momentum = body.unit_momentum(link.kind);
                *diagonal = along_axis(link.kind, momentum);
            }
            after = Some((body, placed));
        }
        rows
    }

    /// The mass matrix M(q): kg·m², and kg and kg·m where joints slide. Symmetric, positive definite.
    #[must_use]
    pub fn mass_matrix(&self) -> SMatrix<f64, N, N> {
        // rows become columns: the lower triangle
        let mut matrix = SMatrix::from_array_storage(ArrayStorage(self.upper_rows()));
        matrix.fill_upper_triangle_with_lower_triangle();
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
        solve(self.upper_rows(), right)
    }

    /// Kinetic energy at joint velocities, rad/s or m/s, in J: half the sum over the links of
    /// ∫|v + ω × r|² dm = m·|v|² + 2·v·(ω × h) − tr(\[ω×\]²·Σ).
    #[must_use]
    pub fn kinetic_energy(&self, dq: &[f64; N]) -> f64 {
        let (mut v, mut w) = ([0.0; 3], [0.0; 3]);
        let mut twice = 0.0;
        for ((placed, link), dq) in self.placed.iter().zip(&self.chain.links).zip(dq) {
            v = inward(&placed.axes, add(v, cross(w, placed.offset)));
            w = inward(&placed.axes, w);
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

/// x of M·x = b, M symmetric and positive definite and given by its rows from the diagonal on.
///
/// M = L·D·Lᵀ with L unit lower triangular. Row by row: the rows of Lᵀ, and y of L·D·y = b; then
/// Lᵀ·x = y from the last row up.
#[inline]
pub(super) fn solve<const N: usize>(mut rows: [[f64; N]; N], mut b: [f64; N]) -> [f64; N] {
    let (mut below, mut b_below) = (rows.as_mut_slice(), b.as_mut_slice());
    for k in 0..N {
        let (Some((pivot_row, rest)), Some((pivot_b, b_rest))) =
            (below.split_first_mut(), b_below.split_first_mut())
        else {
            break;
        };
        let Some(pivot) = pivot_row.get(k) else {
            break;
        };
        let inverse = 1.0 / pivot;
        let ratios = pivot_row.map(|entry| entry * inverse);
        let Some(after) = ratios.get(k + 1..) else {
            break;
        };
        for ((row, b), ratio) in rest.iter_mut().zip(b_rest.iter_mut()).zip(after) {
            // entries before the diagonal change too, and are never read
            for (entry, pivot) in row.iter_mut().zip(&*pivot_row) {
                *entry -= ratio * pivot;
            }
            *b -= ratio * *pivot_b;
        }
        *pivot_b *= inverse;
        *pivot_row = ratios;
        (below, b_below) = (rest, b_rest);
    }
    let mut x = [0.0; N];
    for (k, (row, y)) in (0..N).zip(rows.iter().zip(&b)).rev() {
        let known: f64 = row
            .iter()
            .zip(&x)
            .skip(k.saturating_add(1))
            .map(|(l, x)| l * x)
            .sum();
        if let Some(x) = x.get_mut(k) {
            *x = y - known;
        }
    }
    x
}
