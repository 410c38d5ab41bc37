//! What a point of each piece of a path costs, and what it costs to make one: ns on this machine.
//!
//! `cargo run --release -p mrroc-motion --example path_cost`

use motion::Pose;
use motion::path::{Arc, Blend, Curve, MovingSegment, Path, Piece, Straight, Tolerance};
use nalgebra::Vector3;
use std::f64::consts::TAU;
use std::hint::black_box;
use std::time::Instant;

const REPETITIONS: u32 = 200_000;

/// The shorter of two mean durations, ns.
fn cost(what: &str, mut f: impl FnMut(f64)) {
    let mut mean = || {
        let start = Instant::now();
        for i in 0..REPETITIONS {
            f(f64::from(i) / f64::from(REPETITIONS));
        }
        start.elapsed().as_nanos() / u128::from(REPETITIONS)
    };
    let (first, second) = (mean(), mean());
    println!("{what:40} {:6} ns", first.min(second));
}

fn pose(u: f64) -> Pose {
    let a = u * TAU;
    let position = Vector3::new(libm::cos(a), libm::sin(a), u);
    Pose::from_rotation_vector(position, Vector3::y() * (2.0 * u))
}

fn at(name: &str, piece: &impl Curve) {
    cost(name, |u| {
        black_box(piece.at(black_box(u * piece.length())));
    });
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let straight = Straight::new(pose(0.0), pose(0.2))?;
    let (centre, end) = (Vector3::zeros(), pose(0.5).rotation);
    let arc = Arc::about(pose(0.2), centre, Vector3::z(), 2.0, 0.3, &end)?;
    let tolerance = Tolerance {
        metres: 1e-3,
        radians: 1e-2,
    };
    let blend = Blend::between(&straight, &arc, &tolerance)?;
    at("straight: a point", &straight);
    at("arc: a point", &arc);
    at("blend or span: a point", blend.curve());
    let mut path = Path::<64>::new();
    path.push(straight)?;
    path.push_blended(arc, &tolerance)?;
    cost("path: a point, going along", |u| {
        let s = black_box(u * path.end());
        black_box(path.at(s));
    });
    cost("straight: made", |_| {
        black_box(Straight::new(black_box(pose(0.0)), *straight.line().end()).is_ok());
    });
    cost("blend of line and arc: made", |_| {
        black_box(Blend::between(black_box(&straight), &arc, &tolerance).is_ok());
    });
    let next = Straight::new(pose(0.2), pose(0.3))?;
    cost("blend of two lines: made", |_| {
        black_box(Blend::between(black_box(&straight), &next, &tolerance).is_ok());
    });
    let ahead = straight.line().twist().linear;
    let (normal, corner) = (ahead.cross(&Vector3::x()), *straight.line().end());
    let centre = corner.position + ahead.cross(&normal).normalize() * 0.2;
    let tangential = Arc::about(corner, centre, normal, 1.0, 0.0, &corner.rotation)?;
    cost("blend of line and tangential arc: made", |_| {
        black_box(Blend::between(black_box(&straight), &tangential, &tolerance).is_ok());
    });
    let mut curve = MovingSegment::new();
    cost("curve through points: a point pushed", |u| {
        black_box(curve.push(black_box(pose(1e3 * u))).is_ok());
    });
    let (piece, path) = (size_of::<Piece>(), size_of::<Path<64>>());
    let curve = size_of::<MovingSegment>();
    println!("bytes: a piece {piece}, a path of 64 pieces {path}, a curve through points {curve}");
    Ok(())
}
