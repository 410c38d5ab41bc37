//! Every kind of robot: what all of them must answer alike, and what is particular to Polycrank, the
//! five-axis arm, the track's rules, the conveyor and the grippers.

mod all;
mod five;
mod guard;
mod polycrank;
mod slider;
mod track;

use motion::Pose;
use robots::{Joints, Robot};

/// A configuration from numbers in 0..1: inside the limits, or within three turns where there are none.
fn spread<const N: usize>(robot: &impl Robot<N>, unit: &[f64; 7]) -> Joints<N> {
    let axes = &robot.description().axes;
    Joints(core::array::from_fn(|k| {
        let range = axes[k].joint_position;
        if range.is_bounded() {
            range.lower + unit[k] * (range.upper - range.lower)
        } else {
            (unit[k] - 0.5) * 6.0 * core::f64::consts::TAU
        }
    }))
}

/// The greatest difference of two poses, m and 1.
fn apart(a: &Pose, b: &Pose) -> f64 {
    let position = a.position - b.position;
    let rotation = a.rotation - b.rotation;
    position.iter().chain(rotation.iter()).fold(0.0, |most, v| {
        if v.abs() > most || v.is_nan() {
            v.abs()
        } else {
            most
        }
    })
}

/// The greatest |a − b|.
fn off<const N: usize>(a: &Joints<N>, b: &Joints<N>) -> f64 {
    a.0.iter()
        .zip(b.0)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, |m, d| if d > m || d.is_nan() { d } else { m })
}
