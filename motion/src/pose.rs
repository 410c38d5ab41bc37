//! Rigid displacements: the pose of one frame in another.

use nalgebra::{Matrix3, Vector3};

/// `t_a_b`: the pose of frame b in frame a. Poses compose as `t_a_c = t_a_b * t_b_c`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Origin of b in a, m.
    pub position: Vector3<f64>,
    /// Axes of b in a, as columns (N, O, A of the robotics literature).
    pub rotation: Matrix3<f64>,
}

impl Pose {
    /// No displacement.
    #[must_use]
    pub fn identity() -> Self {
        Self {
            position: Vector3::zeros(),
            rotation: Matrix3::identity(),
        }
    }

    /// From a position (m) and a rotation vector (axis · angle, rad).
    #[must_use]
    pub fn from_rotation_vector(position: Vector3<f64>, rotation_vector: Vector3<f64>) -> Self {
        Self {
            position,
            rotation: exp(rotation_vector),
        }
    }

    /// The rotation vector (axis · angle) of the orientation, rad; angle in \[0, π\].
    #[must_use]
    pub fn rotation_vector(&self) -> Vector3<f64> {
        log(&self.rotation)
    }

    /// The displacement the other way: `t_b_a`.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.transpose();
        Self {
            position: -(rotation * self.position),
            rotation,
        }
    }
}

impl core::ops::Mul for Pose {
    type Output = Self;
    fn mul(self, t_b_c: Self) -> Self {
        Self {
            position: self.position + self.rotation * t_b_c.position,
            rotation: self.rotation * t_b_c.rotation,
        }
    }
}

/// Rodrigues' formula: the rotation by |w| about w.
#[must_use]
pub fn exp(w: Vector3<f64>) -> Matrix3<f64> {
    let angle2 = w.dot(&w);
    let k = w.cross_matrix();
    // sin(x)/x and (1 - cos(x))/x², by series where the quotients lose their digits
    let (a, b) = if angle2 < 1e-8 {
        (1.0 - angle2 / 6.0, 0.5 - angle2 / 24.0)
    } else {
        let angle = libm::sqrt(angle2);
        let half = libm::sin(0.5 * angle);
        (libm::sin(angle) / angle, 2.0 * half * half / angle2)
    };
    Matrix3::identity() + k * a + k * k * b
}

/// The inverse of [`exp`], with the angle in \[0, π\].
#[must_use]
pub fn log(r: &Matrix3<f64>) -> Vector3<f64> {
    // 2·sin(angle)·axis
    let s = Vector3::new(r.m32 - r.m23, r.m13 - r.m31, r.m21 - r.m12);
    let sin2 = libm::sqrt(s.dot(&s));
    let cos2 = r.m11 + r.m22 + r.m33 - 1.0;
    let angle = libm::atan2(sin2, cos2);
    if cos2 > 0.0 {
        // angle/(2·sin(angle)) → 1/2
        let f = if sin2 < 1e-6 {
            0.5 + angle * angle / 12.0
        } else {
            angle / sin2
        };
        return s * f;
    }
    // Beyond 90° the symmetric part is better conditioned: r + rᵀ = 2cosθ·I + 2(1-cosθ)·aaᵀ
    let c = 0.5 * cos2;
    let d = 1.0 - c;
    let (xx, yy, zz) = ((r.m11 - c) / d, (r.m22 - c) / d, (r.m33 - c) / d);
    let (xy, xz, yz) = (
        (r.m12 + r.m21) / (2.0 * d),
        (r.m13 + r.m31) / (2.0 * d),
        (r.m23 + r.m32) / (2.0 * d),
    );
    let axis = if xx >= yy && xx >= zz {
        Vector3::new(xx, xy, xz)
    } else if yy >= zz {
        Vector3::new(xy, yy, yz)
    } else {
        Vector3::new(xz, yz, zz)
    };
    let length = libm::sqrt(axis.dot(&axis));
    let axis = axis / length;
    let sign = if axis.dot(&s) < 0.0 { -1.0 } else { 1.0 };
    axis * (sign * angle)
}

#[cfg(test)]
mod test {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn log_inverts_exp(x in -1.0..1.0f64, y in -1.0..1.0f64, z in -1.0..1.0f64, angle in 0.0..core::f64::consts::PI - 1e-5) {
            let axis = Vector3::new(x, y, z);
            prop_assume!(axis.norm() > 1e-3);
            let w = axis.normalize() * angle;
            prop_assert!((log(&exp(w)) - w).norm() < 1e-9, "{w:?} {:?}", log(&exp(w)));
        }

        #[test]
        fn inverse_composes_to_identity(x in -3.0..3.0f64, y in -3.0..3.0f64, z in -3.0..3.0f64) {
            let t = Pose::from_rotation_vector(Vector3::new(x, y, z), Vector3::new(z, x, y) * 0.3);
            let i = t * t.inverse();
            prop_assert!(i.position.norm() < 1e-12);
            prop_assert!((i.rotation - Matrix3::identity()).norm() < 1e-12);
        }
    }

    #[test]
    fn half_turns_have_an_axis() {
        for axis in [
            Vector3::x(),
            Vector3::y(),
            Vector3::z(),
            Vector3::new(0.6, 0.8, 0.0),
        ] {
            let w = axis * core::f64::consts::PI;
            let got = log(&exp(w));
            assert!(
                (got - w).norm() < 1e-7 || (got + w).norm() < 1e-7,
                "{got:?}"
            );
        }
    }
}
