//! The RNT against formulas of its own in these tests, its inverses, and every bound it claims.

mod inverse;
mod kinematics;
mod legs;
mod planning;
mod regulator;
mod report;
mod transmission;
mod work_area;

use motion::pose::exp;
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::ProptestConfig;
use robots::{Joints, Range, Rnt, Robot};

/// Cases as set from outside, and as many rejects as they take: a box of joints is not one of motors, so a constant
/// share of its corners is left out however many cases are asked for.
fn patient() -> ProptestConfig {
    ProptestConfig {
        max_global_rejects: u32::MAX,
        ..ProptestConfig::default()
    }
}

/// A configuration inside the joint limits from numbers in 0..1.
fn within_limits(unit: &[f64; 6]) -> Joints<6> {
    let axes = &Rnt.description().axes;
    Joints(core::array::from_fn(|k| {
        at(axes[k].joint_position, unit[k])
    }))
}

/// The same, only where the motors are inside their limits too.
fn driveable(unit: &[f64; 6]) -> Option<Joints<6>> {
    let joints = within_limits(unit);
    Rnt.check_motors(&Rnt.motors(&joints).ok()?).ok()?;
    Some(joints)
}

fn at(range: Range, unit: f64) -> f64 {
    range.lower + unit * (range.upper - range.lower)
}

/// The greatest |a − b|.
fn apart<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, |m, d| if d > m || d.is_nan() { d } else { m })
}

/// The platform by rotation vectors, and the legs as distances of points: not by the crate's formulas.
fn platform(ty: f64, tx: f64) -> Matrix3<f64> {
    exp(Vector3::y() * ty) * exp(Vector3::x() * tx)
}

fn distances(ty: f64, tx: f64, reach: f64) -> [f64; 3] {
    let r = platform(ty, tx);
    [90.0_f64, 210.0, 330.0].map(|degrees| {
        let (s, c) = libm::sincos(degrees.to_radians());
        let foot = Vector3::new(0.40 * c, 0.40 * s, 0.0);
        let end = r * Vector3::new(0.15 * c, 0.15 * s, -reach);
        (end - foot).norm()
    })
}

/// Numbers in 0..1 from a counter: reproducible, and as many as a loop wants.
struct Numbers(u64);

impl Numbers {
    /// A step of `SplitMix64` (G. Steele et al., 2014).
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        f64::from(u32::try_from((z ^ (z >> 31)) >> 32).unwrap()) / f64::from(u32::MAX)
    }
}
