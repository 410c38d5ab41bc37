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

/// (−1)ᵏ/(2k + 2)!: (1 − cos θ)/θ² in powers of θ²; the last term at θ = π is 3e-17.
pub(crate) const VERSINE: [f64; 14] = [
    0.5,
    -0.041_666_666_666_666_664,
    0.001_388_888_888_888_889,
    -2.480_158_730_158_73e-5,
    2.755_731_922_398_589e-7,
    -2.087_675_698_786_81e-9,
    1.147_074_559_772_972_5e-11,
    -4.779_477_332_387_385e-14,
    1.561_920_696_858_622_5e-16,
    -4.110_317_623_312_165e-19,
    8.896_791_392_450_574e-22,
    -1.611_737_571_096_118_4e-24,
    2.479_596_263_224_797_6e-27,
    -3.279_889_237_069_838e-30,
];
/// (−1)ᵏ/(2k + 3)!: (θ − sin θ)/θ³.
pub(crate) const SINE_DEFECT: [f64; 14] = [
    0.166_666_666_666_666_66,
    -0.008_333_333_333_333_333,
    0.000_198_412_698_412_698_4,
    -2.755_731_922_398_589_3e-6,
    2.505_210_838_544_172e-8,
    -1.605_904_383_682_161_3e-10,
    7.647_163_731_819_816e-13,
    -2.811_457_254_345_520_6e-15,
    8.220_635_246_624_33e-18,
    -1.957_294_106_339_126_3e-20,
    3.868_170_170_630_684e-23,
    -6.446_950_284_384_474e-26,
    9.183_689_863_795_546e-29,
    -1.130_996_288_644_771_6e-31,
];
/// θ² below which [`FEW`] terms of them suffice: the next is 8e-20.
pub(crate) const SMALL: f64 = 0.1;
pub(crate) const FEW: usize = 7;

/// The terms of one of these series that are needed at x = θ², the highest first.
pub(crate) fn terms(series: &[f64; 14], x: f64) -> impl Iterator<Item = &f64> {
    let skipped = if x < SMALL { series.len() - FEW } else { 0 };
    series.iter().rev().skip(skipped)
}

/// Rodrigues' formula: the rotation by |w| about w.
#[must_use]
pub fn exp(w: Vector3<f64>) -> Matrix3<f64> {
    let x = w.dot(&w);
    // sin θ/θ and (1 − cos θ)/θ²: of small angles by series, which take no root and no sine
    let (a, b) = if x < SMALL {
        let sum = |series| terms(series, x).fold(0.0, |sum, term| sum * x + term);
        (1.0 - x * sum(&SINE_DEFECT), sum(&VERSINE))
    } else {
        let angle = libm::sqrt(x);
        let half = libm::sin(0.5 * angle);
        (libm::sin(angle) / angle, 2.0 * half * half / x)
    };
    rodrigues(&w, a, b)
}

/// An orientation turned further by a share of a rotation vector; one of 0 leaves it as it is, to the bit.
pub(crate) fn turned(w: &Vector3<f64>, share: f64, from: &Matrix3<f64>) -> Matrix3<f64> {
    if is_zero(w.as_slice()) {
        *from
    } else {
        exp(w * share) * from
    }
}

/// Are all of them 0, of either sign?
pub(crate) fn is_zero(values: &[f64]) -> bool {
    let bits = values.iter().fold(0, |bits, x| bits | x.to_bits());
    bits << 1 == 0
}

/// I + a·\[w\]ₓ + b·\[w\]ₓ², written out.
pub(crate) fn rodrigues(w: &Vector3<f64>, a: f64, b: f64) -> Matrix3<f64> {
    let (bx, by, bz) = (b * w.x, b * w.y, b * w.z);
    let (xx, yy, zz) = (bx * w.x, by * w.y, bz * w.z);
    let (xy, xz, yz) = (bx * w.y, bx * w.z, by * w.z);
    let (ax, ay, az) = (a * w.x, a * w.y, a * w.z);
    Matrix3::new(
        1.0 - (yy + zz),
        xy - az,
        xz + ay,
        xy + az,
        1.0 - (xx + zz),
        yz - ax,
        xz - ay,
        yz + ax,
        1.0 - (xx + yy),
    )
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
