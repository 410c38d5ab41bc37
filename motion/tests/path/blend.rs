//! Blends: within the tolerance, C2 at both ends, and as large as they may be.

use crate::support::{apart, at, derivatives_are_limits, jumps, pose, simpson, straight, vector};
use motion::Pose;
use motion::path::{Arc, Blend, BlendError, Curve, Piece, Straight, Tolerance};
use nalgebra::Vector3;
use proptest::prelude::*;
use std::cell::Cell;
use std::f64::consts::PI;

/// The path with the corner at 0.
fn corner(first: &Piece, second: &Piece, s: f64) -> Pose {
    if s < 0.0 {
        first.at(first.length() + s).pose
    } else {
        second.at(s).pose
    }
}

/// The greatest share of the tolerance that any point of the blend needs to find a point of the path within
/// position and orientation tolerance, and any point of the path to find one of the blend.
fn used(first: &Piece, second: &Piece, blend: &Blend, tolerance: &Tolerance) -> f64 {
    let (curve, d) = (blend.curve(), blend.distance());
    let many = 300;
    let sample = |f: &dyn Fn(f64) -> Pose| -> Vec<Pose> {
        (0..=many)
            .map(|i| f(f64::from(i) / f64::from(many)))
            .collect()
    };
    let rounded = sample(&|u| curve.at(u * curve.length()).pose);
    let original = sample(&|u| corner(first, second, (2.0 * u - 1.0) * d));
    let share = |a: &Pose, b: &Pose| {
        let metres = (a.position - b.position).norm() / tolerance.metres;
        // the angle by the chord of the rotation matrices: ‖A − B‖ = 2·√2·sin(angle/2)
        let chord: f64 = (a.rotation - b.rotation).norm() / 8.0_f64.sqrt();
        metres.max(2.0 * chord.min(1.0).asin() / tolerance.radians)
    };
    let farthest = |from: &[Pose], to: &[Pose]| {
        let nearest = |a: &Pose| to.iter().map(|b| share(a, b)).fold(f64::INFINITY, f64::min);
        from.iter().map(nearest).fold(0.0, f64::max)
    };
    farthest(&rounded, &original).max(farthest(&original, &rounded))
}

/// The greatest share of the tolerance between the blend and the path, both over [0, 1].
fn at_equal_parameter(first: &Piece, second: &Piece, blend: &Blend, tolerance: &Tolerance) -> f64 {
    let share = |i: i32| {
        let u = f64::from(i) / 1000.0;
        let here = blend.curve().at(u * blend.curve().length()).pose;
        let there = corner(first, second, (2.0 * u - 1.0) * blend.distance());
        let (metres, radians) = apart(&here, &there);
        (metres / tolerance.metres).max(radians / tolerance.radians)
    };
    (0..=1000).map(share).fold(0.0, f64::max)
}

/// Joins at both ends, derivatives inside, tolerance.
fn check(
    first: &Piece,
    second: &Piece,
    blend: &Blend,
    tolerance: &Tolerance,
) -> Result<(), TestCaseError> {
    let (curve, d) = (blend.curve(), blend.distance());
    prop_assert!(d <= 0.5 * first.length() && d <= 0.5 * second.length());
    for (seen, expected) in [
        (curve.at(0.0), first.at(first.length() - d)),
        (curve.at(curve.length()), second.at(d)),
    ] {
        let (metres, radians) = apart(&seen.pose, &expected.pose);
        prop_assert!(metres < 1e-14 && radians < 1e-12, "{metres:e} {radians:e}");
        let jump = jumps(&seen, &expected);
        // rounding of positions of 1 m: 1e-16·10/d and 1e-16·100/d²; ω up to 50 times as large
        let room = 1e-15 / d + 1e-15;
        prop_assert!(
            jump[0] < 10.0 * room && jump[2] < 100.0 * room / d,
            "{jump:?} {d:e}"
        );
        prop_assert!(
            jump[1] < 500.0 * room && jump[3] < 5000.0 * room / d,
            "{jump:?} {d:e}"
        );
    }
    if d > 1e-3 {
        derivatives_are_limits(curve, 0.41 * curve.length())?;
    }
    let most = at_equal_parameter(first, second, blend, tolerance);
    prop_assert!(most <= 1.0, "{most}");
    let turning = first.at(0.0).first.angular_norm() + second.at(0.0).first.angular_norm();
    prop_assert!(d * turning <= 1.5);
    // 1.5 rad, less 2 % for what lies between samples
    let limited = d > 0.499 * first.length().min(second.length()) || d * turning > 1.468;
    prop_assert!(limited || most > 0.88, "{most} of the tolerance, d {d:e}");
    let used = used(first, second, blend, tolerance);
    // both are sampled at 300 points; what is nearest between them is nearer still
    prop_assert!(used <= 1.0, "{used} of the tolerance, d {d:e}");
    Ok(())
}

/// Two lines that turn by an angle: lengths from 10 µm to 1 m, orientations too.
fn lines() -> impl Strategy<Value = (Piece, Piece)> {
    let length = || (-5.0..0.0f64).prop_map(|e| 10.0_f64.powf(e));
    let angle = prop_oneof![0.01..PI, PI - 1e-3..=PI, Just(PI), 1e-6..1e-2];
    let turns = || prop_oneof![Just(Vector3::zeros()), vector(0.5)];
    (
        pose(),
        vector(1.0),
        vector(1.0),
        length(),
        length(),
        angle,
        turns(),
        turns(),
    )
        .prop_filter_map(
            "directions",
            |(start, ahead, aside, l1, l2, angle, w1, w2)| {
                let (t1, normal) = (ahead.normalize(), ahead.cross(&aside));
                (normal.norm() > 1e-2).then_some(())?;
                let t2 = t1 * angle.cos() + normal.normalize().cross(&t1) * angle.sin();
                let turned = |from: &Pose, way: Vector3<f64>, w: Vector3<f64>| Pose {
                    position: from.position + way,
                    rotation: Pose::from_rotation_vector(way, w).rotation * from.rotation,
                };
                let middle = turned(&start, t1 * l1, w1);
                let end = turned(&middle, t2 * l2, w2);
                Some((straight(start, middle).into(), straight(middle, end).into()))
            },
        )
}

fn tolerances() -> impl Strategy<Value = Tolerance> {
    ((-5.0..-2.0f64), (-3.0..-1.0f64)).prop_map(|(m, r)| Tolerance {
        metres: 10.0_f64.powf(m),
        radians: 10.0_f64.powf(r),
    })
}

/// An arc from a pose, of any direction.
fn arc(
    start: Pose,
    to_centre: Vector3<f64>,
    aside: Vector3<f64>,
    angle: f64,
    end: &Pose,
) -> Option<Piece> {
    let normal = to_centre.cross(&aside);
    if normal.norm() < 1e-3 || to_centre.norm() < 0.02 {
        return None;
    }
    let centre = start.position + to_centre;
    Some(
        Arc::about(start, centre, normal, angle, 0.0, &end.rotation)
            .unwrap()
            .into(),
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn a_blend_of_two_lines_is_within_the_tolerance((first, second) in lines(), tolerance in tolerances()) {
        match Blend::between(&first, &second, &tolerance) {
            Ok(blend) => check(&first, &second, &blend, &tolerance)?,
            // nothing but lack of room: only a corner that turns quickly for its tolerance may need so little
            Err(error) => {
                prop_assert_eq!(error, BlendError::TooShort);
                let quick = first.at(0.0).first.angular_norm() + second.at(0.0).first.angular_norm();
                prop_assert!(quick * 2e-6 > tolerance.radians * 0.3);
            }
        }
    }

    #[test]
    fn the_work_is_bounded(
        start in pose(), c1 in vector(0.3), c2 in vector(0.3), aside in vector(1.0),
        a1 in 0.1..6.0f64, a2 in 0.1..6.0f64, tolerance in tolerances(), (line, other) in lines(),
    ) {
        let arcs = arc(start, c1, aside, a1, &start).and_then(|first| {
            let corner = first.at(first.length()).pose;
            Some((first, arc(corner, c2, aside, a2, &start)?))
        });
        for (first, second) in arcs.into_iter().chain([(line, other)]) {
            let (first, second) = (Counted(&first, Cell::new(0)), Counted(&second, Cell::new(0)));
            let made = Blend::between(&first, &second, &tolerance).is_ok();
            // the corner once; an attempt takes both ends of the blend, where orientations count from, and 15 positions
            // and orientations, each from there
            let attempts = (first.1.get() + second.1.get() - 2) / 49;
            let turning = first.at(0.0).first.angular_norm() + second.at(0.0).first.angular_norm();
            let lines = matches!((first.0, second.0), (Piece::Straight(_), Piece::Straight(_)));
            prop_assert!(attempts <= 16);
            if made && lines && turning == 0.0 {
                prop_assert_eq!(attempts, 1);
            }
        }
    }

    #[test]
    fn a_blend_with_arcs_is_within_the_tolerance(
        start in pose(), c1 in vector(0.3), c2 in vector(0.3), aside in vector(1.0), way in vector(0.3),
        a1 in 0.1..6.0f64, a2 in 0.1..6.0f64, tolerance in tolerances(), which in 0..3,
    ) {
        let first = if which == 0 {
            straight(start, Pose { position: start.position + way, ..start }).into()
        } else {
            prop_assume!(arc(start, c1, aside, a1, &start).is_some());
            arc(start, c1, aside, a1, &start).unwrap()
        };
        let corner = first.at(first.length()).pose;
        let second = if which == 1 {
            straight(corner, Pose { position: corner.position + way, ..corner }).into()
        } else {
            prop_assume!(arc(corner, c2, aside, a2, &start).is_some());
            arc(corner, c2, aside, a2, &start).unwrap()
        };
        let blend = Blend::between(&first, &second, &tolerance).unwrap();
        check(&first, &second, &blend, &tolerance)?;
    }

    #[test]
    fn a_tangential_join_of_line_and_arc_becomes_c2(radius in 0.02..0.5f64, angle in 0.2..3.0f64, length in 0.01..0.5f64, tolerance in tolerances()) {
        let (start, corner) = (at(-length, 0.0, 0.0), at(0.0, 0.0, 0.0));
        let first: Piece = straight(start, corner).into();
        let second: Piece = Arc::about(corner, Vector3::y() * radius, Vector3::z(), angle, 0.0, &corner.rotation).unwrap().into();
        let blend = Blend::between(&first, &second, &tolerance).unwrap();
        check(&first, &second, &blend, &tolerance)?;
        for i in 0..=100 {
            let x = blend.curve().at(blend.curve().length() * f64::from(i) / 100.0);
            prop_assert!(x.curvature() < 1.12 / radius, "{}", x.curvature() * radius);
            prop_assert!(x.first.linear_norm() > 0.93 && x.first.linear_norm() < 1.06);
        }
    }

    #[test]
    fn the_tolerance_is_used_up_where_there_is_room(angle in 0.1..PI, tolerance in 1e-5..1e-3f64) {
        let (first, second) = bend(angle, 1.0);
        let blend = Blend::between(&first, &second, &Tolerance { metres: tolerance, radians: 0.1 }).unwrap();
        let off = blend.curve().at(0.5 * blend.curve().length()).pose.position.norm();
        prop_assert!(off > 0.97 * tolerance && off <= tolerance, "{}", off / tolerance);
        // the closed form of the description
        let k = blend.curve().length() / (2.0 * blend.distance());
        let half = (angle / 2.0).cos();
        prop_assert!((k - (1.875 * half / (1.0 + 0.875 * half)).max(0.5)).abs() < 1e-12);
        let expected = blend.distance() * 2.0 * (angle / 2.0).sin() * (0.5 - 0.3125 * k);
        prop_assert!((off - expected).abs() < 1e-12);
    }

    #[test]
    fn the_orientation_tolerance_counts_where_only_the_orientation_turns(w1 in vector(1.0), w2 in vector(1.0), tolerance in tolerances()) {
        prop_assume!(w1.norm() > 0.1 && w2.norm() > 0.1);
        let a = Pose::identity();
        let b = Pose::from_rotation_vector(Vector3::zeros(), w1);
        let c = Pose { rotation: Pose::from_rotation_vector(Vector3::zeros(), w2).rotation * b.rotation, ..b };
        let (first, second): (Piece, Piece) = (straight(a, b).into(), straight(b, c).into());
        let blend = Blend::between(&first, &second, &tolerance).unwrap();
        check(&first, &second, &blend, &tolerance)?;
    }
}

#[test]
fn the_orientation_counts_where_only_the_position_turns_back() {
    // ω goes on through the corner; the blend of the way, at half the parameter's rate, would make it lag
    let pose =
        |x: f64, angle: f64| Pose::from_rotation_vector(Vector3::x() * x, Vector3::z() * angle);
    let (first, second) = (
        straight(pose(0.0, 0.0), pose(0.1, 1.0)),
        straight(pose(0.1, 1.0), pose(0.0, 2.0)),
    );
    for radians in [0.05, 0.01, 1e-3] {
        let tolerance = Tolerance {
            metres: 1.0,
            radians,
        };
        let blend = Blend::between(&first, &second, &tolerance).unwrap();
        let most = at_equal_parameter(&first.into(), &second.into(), &blend, &tolerance);
        assert!(most > 0.88 && most <= 1.0, "{most}");
    }
}

#[test]
fn a_blend_turns_the_tool_by_less_than_the_shortest_way_can_tell() {
    let half_turn = |axis: Vector3<f64>, from: Pose| Pose {
        rotation: Pose::from_rotation_vector(Vector3::zeros(), axis * 3.1).rotation * from.rotation,
        ..from
    };
    let a = Pose::identity();
    let b = half_turn(Vector3::z(), a);
    for axis in [Vector3::z(), Vector3::x(), Vector3::new(0.0, 0.6, 0.8)] {
        let (first, second) = (straight(a, b), straight(b, half_turn(axis, b)));
        let wide = Tolerance {
            metres: 1.0,
            radians: 3.0,
        };
        let blend = Blend::between(&first, &second, &wide).unwrap();
        let turned = blend.distance()
            * (first.at(0.0).first.angular_norm() + second.at(0.0).first.angular_norm());
        assert!(turned > 1.4 && turned < 1.5, "{turned}");
    }
}

/// Two lines that meet in the origin and turn by an angle.
fn bend(angle: f64, length: f64) -> (Piece, Piece) {
    let (start, corner) = (at(-length, 0.0, 0.0), at(0.0, 0.0, 0.0));
    let end = at(length * angle.cos(), length * angle.sin(), 0.0);
    (straight(start, corner).into(), straight(corner, end).into())
}

#[test]
fn speed_and_curvature_of_blends_of_lines_are_as_described() {
    println!("angle/°     k  |p'| least  most    |p''|·h/sin(α/2)  κ·h/sin(α/2)  length/h");
    for degrees in [
        1.0, 15.0, 30.0, 45.0, 60.0, 75.0, 90.0, 105.0, 120.0, 135.0, 150.0, 165.0, 175.0, 179.0,
        180.0,
    ] {
        let angle = f64::to_radians(degrees);
        let (first, second) = bend(angle, 1.0);
        let blend = Blend::between(
            &first,
            &second,
            &Tolerance {
                metres: 1e-3,
                radians: 0.1,
            },
        )
        .unwrap();
        let (curve, h) = (blend.curve(), blend.curve().length());
        let points: Vec<_> = (0..=1000)
            .map(|i| curve.at(h * f64::from(i) / 1000.0))
            .collect();
        let most =
            |f: &dyn Fn(&motion::path::PathPoint) -> f64| points.iter().map(f).fold(0.0, f64::max);
        let least = points
            .iter()
            .map(|x| x.first.linear_norm())
            .fold(f64::INFINITY, f64::min);
        let fastest = most(&|x| x.first.linear_norm());
        let half = (angle / 2.0).sin();
        let (second, curvature) = (
            most(&|x| x.second.linear_norm()) * h / half,
            most(&|x| x.curvature()) * h / half,
        );
        let length = curve.arc_length(0.0, h) / h;
        let k = h / (2.0 * blend.distance());
        assert!(fastest < 1.003 && second < 3.11);
        if degrees <= 90.0 {
            assert!(least > 0.997);
        }
        if degrees <= 135.0 {
            assert!(least > 0.96 && curvature < 3.11 * 1.06 && (length - 1.0).abs() < 0.02);
        }
        println!(
            "{degrees:6} {k:8.3} {least:8.3} {fastest:8.3} {second:12.3} {curvature:12.3} {length:12.4}"
        );
    }
}

#[test]
fn the_quadrature_of_the_length_is_as_exact_as_described() {
    for (degrees, allowed) in [
        (30.0, 1e-11),
        (90.0, 1e-11),
        (135.0, 1e-11),
        (150.0, 1e-11),
        (165.0, 1e-6),
        (175.0, 1e-6),
        (180.0, 1e-6),
    ] {
        let (first, second) = bend(f64::to_radians(degrees), 1.0);
        let blend = Blend::between(
            &first,
            &second,
            &Tolerance {
                metres: 1e-3,
                radians: 0.1,
            },
        )
        .unwrap();
        let (got, expected) = (
            blend.curve().arc_length(0.0, blend.curve().length()),
            simpson(blend.curve()),
        );
        assert!(
            (got / expected - 1.0).abs() < allowed,
            "{degrees}: {got} {expected}"
        );
    }
}

#[test]
fn corners_without_room_or_sense_are_refused() {
    let (first, second) = bend(1.0, 1.0);
    let tolerance = |metres, radians| Tolerance { metres, radians };
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(
            Blend::between(&first, &second, &tolerance(bad, 0.1)),
            Err(BlendError::Tolerance)
        );
        assert_eq!(
            Blend::between(&first, &second, &tolerance(1e-3, bad)),
            Err(BlendError::Tolerance)
        );
    }
    let fine = tolerance(1e-3, 0.1);
    assert_eq!(Blend::between(&second, &first, &fine), Err(BlendError::Gap));
    let turned: Piece = straight(
        Pose::from_rotation_vector(Vector3::zeros(), Vector3::x()),
        at(1.0, 0.0, 0.0),
    )
    .into();
    assert_eq!(Blend::between(&first, &turned, &fine), Err(BlendError::Gap));
    assert_eq!(
        Blend::between(&first, &second, &tolerance(1e-8, 0.1)),
        Err(BlendError::TooShort)
    );
    let tiny: Piece = straight(at(0.0, 0.0, 0.0), at(0.0, 1.5e-6, 0.0)).into();
    assert_eq!(
        Blend::between(&first, &tiny, &fine),
        Err(BlendError::TooShort)
    );
}

/// A piece that counts its points.
struct Counted<'a>(&'a Piece, Cell<u32>);

impl Curve for Counted<'_> {
    fn length(&self) -> f64 {
        self.0.length()
    }

    fn at(&self, s: f64) -> motion::path::PathPoint {
        self.1.set(self.1.get() + 1);
        self.0.at(s)
    }
}

/// A curve with a number missing.
struct Broken(Straight);

impl Curve for Broken {
    fn length(&self) -> f64 {
        self.0.length()
    }

    fn at(&self, s: f64) -> motion::path::PathPoint {
        let mut x = self.0.at(s);
        if s > 0.1 {
            x.second.linear.x = f64::NAN;
        }
        x
    }
}

#[test]
fn a_curve_that_is_not_a_number_gets_no_blend() {
    let first = straight(at(-1.0, 0.0, 0.0), at(0.0, 0.0, 0.0));
    let second = Broken(straight(at(0.0, 0.0, 0.0), at(0.0, 1.0, 0.0)));
    let result = Blend::between(
        &first,
        &second,
        &Tolerance {
            metres: 1.0,
            radians: 0.1,
        },
    );
    assert_eq!(result, Err(BlendError::NotFinite));
}
