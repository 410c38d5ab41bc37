//! Torques of a given motion: the recursive Newton–Euler algorithm, in the frames of the links.
//!
//! Outwards, with R and p the link's axes and origin in the link before it (primed), z its own axis
//! (revolute; for a prismatic joint the terms of q̇ and q̈ move to a):
//!
//! ```text
//!   ω = Rᵀω' + z·q̇          α = Rᵀα' + z·q̈ + Rᵀω' × z·q̇          a = Rᵀ(a' + E'·p)
//!   prismatic:  ω = Rᵀω'    α = Rᵀα'                              a = Rᵀ(a' + E'·p) + z·q̈ + 2ω × z·q̇
//! ```
//!
//! E = \[α×\] + \[ω×\]² is formed once a link and serves its body and the origin of the next. Inwards,
//! f and n are the rates of momentum of the link and all after it; τ is n·z or f·z. Gravity enters as an
//! acceleration −g of the base. Luh, Walker and Paul (1980); Featherstone, "Rigid Body Dynamics
//! Algorithms" (2008), table 5.1. Instead of the inertia about the centre it uses the moments of mass
//! about the link's origin ([`Moments`](super::body::Moments)): fewer products, no centre.

use nalgebra::Vector3;

use super::algebra::{Triple, add, cross, dot, inward, outward, scale};
use super::body::field;
use super::chain::Posture;
use crate::description::JointKind;

/// What the surroundings exert on the flange, along the flange's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wrench {
    /// N.
    pub force: Vector3<f64>,
    /// About the flange's origin, N·m.
    pub moment: Vector3<f64>,
}

impl Wrench {
    /// A flange that touches nothing.
    pub const NONE: Self = Self {
        force: Vector3::new(0.0, 0.0, 0.0),
        moment: Vector3::new(0.0, 0.0, 0.0),
    };
}

/// What a link carries inwards: force and moment about its origin, along its axes.
type Load = (Triple, Triple);

impl<const N: usize> Posture<'_, N> {
    /// Torques of the joints, N·m (N where one slides), that give the chain accelerations `ddq`, rad/s²
    /// or m/s², while it moves at `dq`, rad/s or m/s: τ = M(q)·q̈ + c(q, q̇) + τg(q) − Jᵀ·w.
    ///
    /// `gravity`: acceleration of free fall in the base frame, m/s². A NaN goes through.
    #[must_use]
    pub fn inverse_dynamics(
        &self,
        dq: &[f64; N],
        ddq: &[f64; N],
        gravity: &Vector3<f64>,
        wrench: &Wrench,
    ) -> [f64; N] {
        let mut loads: [Load; N] = [([0.0; 3], [0.0; 3]); N];
        let (mut w, mut alpha): Load = ([0.0; 3], [0.0; 3]);
        let mut a: Triple = (-gravity).into();
        let mut e = [[0.0; 3]; 3];
        for ((((placed, link), dq), ddq), load) in self
            .placed
            .iter()
            .zip(&self.chain.links)
            .zip(dq)
            .zip(ddq)
            .zip(&mut loads)
        {
            let p = placed.offset;
            let [ex, ey, ez] = e;
            a = inward(&placed.axes, add(a, [dot(ex, p), dot(ey, p), dot(ez, p)]));
            w = inward(&placed.axes, w);
            alpha = inward(&placed.axes, alpha);
            // ω × z·q̇, with Rᵀω' or with ω: they differ along z only
            let [x, y, z] = [w[1] * dq, -w[0] * dq, *ddq];
            match link.kind {
                JointKind::Revolute => {
                    w[2] += dq;
                    alpha = add(alpha, [x, y, z]);
                }
                JointKind::Prismatic => a = add(a, [2.0 * x, 2.0 * y, z]),
            }
            e = field(w, alpha);
            *load = link.moments().rates(a, &e);
        }
        self.gather(&loads, wrench)
    }

    /// τ of every joint from the momentum rates of the links and what pushes at the flange.
    fn gather(&self, loads: &[Load; N], wrench: &Wrench) -> [f64; N] {
        let flange = &self.chain.flange;
        let mut f = scale(-1.0, outward(&flange.axes, wrench.force.into()));
        let mut n = add(
            scale(-1.0, outward(&flange.axes, wrench.moment.into())),
            cross(flange.position_m, f),
        );
        let mut torques = [0.0; N];
        for (((torque, (link_f, link_n)), placed), link) in torques
            .iter_mut()
            .zip(loads)
            .zip(&self.placed)
            .zip(&self.chain.links)
            .rev()
        {
            (f, n) = (add(f, *link_f), add(n, *link_n));
            *torque = match link.kind {
                JointKind::Revolute => n[2],
                JointKind::Prismatic => f[2],
            };
            f = outward(&placed.axes, f);
            n = add(outward(&placed.axes, n), cross(placed.offset, f));
        }
        torques
    }

    /// Torques that hold the chain at rest against gravity: τg(q).
    #[must_use]
    pub fn gravity_torques(&self, gravity: &Vector3<f64>) -> [f64; N] {
        self.inverse_dynamics(&[0.0; N], &[0.0; N], gravity, &Wrench::NONE)
    }

    /// Torques at zero acceleration: c(q, q̇) + τg(q) − Jᵀ·w.
    #[must_use]
    pub fn bias_torques(&self, dq: &[f64; N], gravity: &Vector3<f64>, wrench: &Wrench) -> [f64; N] {
        self.inverse_dynamics(dq, &[0.0; N], gravity, wrench)
    }
}
