//! The part of a transmission in which the first three gears drive the legs of a platform: every leg
//! depends on three joints at once.
//!
//! With L the legs' lengths, A = ∂L/∂q and the second derivatives of every length,
//!
//! ```text
//!   q̇ = A⁻¹·L̇        q̈ = A⁻¹·(L̈ − κ),  κ(k) = q̇ᵀ·∂²L(k)/∂q∂q·q̇        τL = A⁻ᵀ·τq
//! ```

use nalgebra::{Matrix3, Vector3};

/// How three legs move the first three joints, at fixed joint positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Legs {
    /// A⁻¹ = ∂q/∂L: rad/m, and m/m for a joint that slides.
    by_length: Matrix3<f64>,
    /// ∂²L/∂q∂q of every leg.
    second: [Matrix3<f64>; 3],
}

impl Legs {
    /// From ∂q/∂L, a column a leg, and the second derivatives of the lengths by the joints.
    pub(crate) fn new(joints_by_length: [[f64; 3]; 3], second: [[[f64; 3]; 3]; 3]) -> Self {
        Self {
            by_length: Matrix3::from(joints_by_length),
            second: second.map(Matrix3::from),
        }
    }

    /// Rates of the joints in the place of those of the legs.
    #[inline]
    pub(super) fn rates(&self, values: &mut [f64]) {
        if let Some(three) = values.first_chunk_mut::<3>() {
            *three = (self.by_length * Vector3::from(*three)).into();
        }
    }

    /// Accelerations of the joints in the place of those of the legs, while the joints move at `rates`.
    #[inline]
    pub(super) fn accelerations(&self, values: &mut [f64], rates: &[f64]) {
        if let (Some(three), Some(rates)) =
            (values.first_chunk_mut::<3>(), rates.first_chunk::<3>())
        {
            let rates = Vector3::from(*rates);
            let curvature = self.second.map(|leg| rates.dot(&(leg * rates)));
            let lengths = Vector3::from(*three) - Vector3::from(curvature);
            *three = (self.by_length * lengths).into();
        }
    }

    /// Forces along the legs in the place of the torques of the joints.
    #[inline]
    pub(super) fn forces(&self, torques: &mut [f64]) {
        if let Some(three) = torques.first_chunk_mut::<3>() {
            *three = self.by_length.tr_mul(&Vector3::from(*three)).into();
        }
    }

    /// The same for every column of a matrix given by its rows.
    #[inline]
    pub(super) fn forces_of_rows<const N: usize>(&self, rows: &mut [[f64; N]]) {
        let Some([a, b, c]) = rows.first_chunk_mut::<3>() else {
            return;
        };
        for ((a, b), c) in a.iter_mut().zip(b).zip(c) {
            let mut column = [*a, *b, *c];
            self.forces(&mut column);
            [*a, *b, *c] = column;
        }
    }
}
