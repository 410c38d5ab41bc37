//! Bodies of simple shape, against sums over small parts of them.

use nalgebra::{Matrix3, Vector3};
use robots::dynamics::{Body, Shape};

/// Centre and inertia about it of equal point masses.
fn of_points(mass: f64, points: &[Vector3<f64>]) -> (Vector3<f64>, Matrix3<f64>) {
    #[expect(clippy::cast_precision_loss, reason = "a few thousand points")]
    let each = mass / points.len() as f64;
    let centre = points.iter().sum::<Vector3<f64>>() * (each / mass);
    let inertia = points.iter().map(|p| {
        let r = p - centre;
        (Matrix3::identity() * r.dot(&r) - r * r.transpose()) * each
    });
    (centre, inertia.sum())
}

fn matrix(body: &Body) -> Matrix3<f64> {
    let i = body.inertia;
    Matrix3::new(i.xx, i.xy, i.xz, i.xy, i.yy, i.yz, i.xz, i.yz, i.zz)
}

#[test]
fn a_skew_cylinder_is_the_sum_of_its_parts() {
    let (from, to, radius, mass) = ([0.1, -0.2, 0.3], [0.5, 0.4, -0.1], 0.15, 3.0);
    let (a, b) = (Vector3::from(from), Vector3::from(to));
    let u = (b - a).normalize();
    let v = u.cross(&Vector3::x()).normalize();
    let w = u.cross(&v);
    let mut points = vec![];
    let (slices, rings, sectors) = (60, 60, 12);
    for slice in 0..slices {
        let along = (f64::from(slice) + 0.5) / f64::from(slices);
        for ring in 0..rings {
            // rings of equal area
            let r = radius * libm::sqrt((f64::from(ring) + 0.5) / f64::from(rings));
            for sector in 0..sectors {
                let angle = std::f64::consts::TAU * f64::from(sector) / f64::from(sectors);
                points
                    .push(a + (b - a) * along + (v * libm::cos(angle) + w * libm::sin(angle)) * r);
            }
        }
    }
    let (centre, inertia) = of_points(mass, &points);
    let body = Body::homogeneous(mass, &Shape::Cylinder { from, to, radius });
    assert!((Vector3::from(body.centre_m) - centre).amax() < 1e-12);
    // the sum's error along the axis: m·(L/60)²/12 = 1e-4 · L²·m/12
    assert!((matrix(&body) - inertia).amax() < 1.2e-4 * mass * 0.68 / 12.0 * 2.0);
    assert!((matrix(&body) - inertia).amax() > 0.0);
}

#[test]
fn a_box_is_the_sum_of_its_parts() {
    let (centre, size, mass) = ([0.3, 0.2, -0.1], [0.2, 0.4, 0.6], 2.0);
    let n = 24;
    let mut points = vec![];
    for i in 0..n {
        for j in 0..n {
            for k in 0..n {
                let at = |index: i32| (f64::from(index) + 0.5) / f64::from(n) - 0.5;
                let inside = Vector3::new(at(i), at(j), at(k)).component_mul(&Vector3::from(size));
                points.push(Vector3::from(centre) + inside);
            }
        }
    }
    let (_, inertia) = of_points(mass, &points);
    let body = Body::homogeneous(mass, &Shape::Box { centre, size });
    assert_eq!(body.centre_m.map(f64::to_bits), centre.map(f64::to_bits));
    // cubes of 1/24: 1/24² of the inertia is missing
    assert!((matrix(&body) - inertia).amax() < 2.0 * 0.52 / 12.0 / 576.0 * 1.01);
    assert!((matrix(&body) - inertia * (576.0 / 575.0)).amax() < 1e-14);
}
