//! Lines, arcs, quintics: derivatives, lengths, ends, and what cannot be made.

use crate::support::{
    apart, at, derivatives_are_limits, jumps, moved, pose, simpson, straight, vector,
};
use motion::path::{
    Arc, Curve, METRES_PER_RADIAN, PathPoint, PieceError, Quintic, SHORTEST_M, Straight,
};
use motion::pose::{Pose, log};
use motion::{Line, Twist};
use nalgebra::Vector3;
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};

fn twist(linear: f64, angular: f64) -> impl Strategy<Value = Twist> {
    (vector(linear), vector(angular)).prop_map(|(linear, angular)| Twist { linear, angular })
}

fn point() -> impl Strategy<Value = PathPoint> {
    (pose(), twist(1.0, 1.0), twist(2.0, 2.0)).prop_map(|(pose, first, second)| PathPoint {
        pose,
        first,
        second,
        third: Twist::zero(),
    })
}

/// Any helix: start, centre off the start, normal, angle, advance, end orientation.
fn helix() -> impl Strategy<Value = Arc> {
    let angle = prop_oneof![0.05..3.0 * TAU, -3.0 * TAU..-0.05];
    (
        pose(),
        vector(1.0),
        vector(1.0),
        angle,
        -0.5..0.5f64,
        pose(),
    )
        .prop_filter_map(
            "a radius and a normal",
            |(start, to_centre, normal, angle, advance, end)| {
                let (centre, radial) =
                    (start.position + to_centre, normal.cross(&to_centre).norm());
                (radial > 0.02 && normal.norm() > 0.1).then(|| {
                    Arc::about(start, centre, normal, angle, advance, &end.rotation).unwrap()
                })
            },
        )
}

proptest! {
    #[test]
    fn a_straight_is_its_line_over_the_length(a in pose(), b in pose(), u in -0.9..1.9f64) {
        let (piece, line) = (straight(a, b), Line::new(a, b));
        let s = u * piece.length();
        derivatives_are_limits(&piece, s)?;
        let expected = line.length_m().max(METRES_PER_RADIAN * line.angle_rad());
        prop_assert_eq!(piece.length(), expected);
        prop_assert!(apart(&piece.at(s).pose, &line.extended(u)).0 < 1e-15 * 4.0);
        prop_assert_eq!(piece.at(0.0).pose, a);
        prop_assert_eq!(piece.at(piece.length()).pose, b);
        prop_assert_eq!(piece.at(s).curvature(), 0.0);
        prop_assert!((piece.arc_length(0.0, piece.length()) - line.length_m()).abs() < 1e-15);
    }

    #[test]
    fn a_turn_on_the_spot_counts_its_angle(a in pose(), w in vector(1.5)) {
        prop_assume!(w.norm() > 1e-3 && w.norm() < 3.0);
        let b = Pose { rotation: Pose::from_rotation_vector(a.position, w).rotation * a.rotation, ..a };
        let piece = straight(a, b);
        prop_assert!((piece.length() - METRES_PER_RADIAN * w.norm()).abs() < 1e-12);
        // log loses up to 1e-16/(π − 3) of the axis
        prop_assert!((piece.at(0.0).first.angular.norm() * METRES_PER_RADIAN - 1.0).abs() < 1e-12);
        prop_assert_eq!(piece.at(0.3 * piece.length()).first.linear, Vector3::zeros());
        prop_assert_eq!(piece.at(0.3 * piece.length()).curvature(), 0.0);
    }

    #[test]
    fn an_arc_has_the_derivatives_and_the_length_of_a_helix(arc in helix(), u in -0.3..1.3f64) {
        let s = u * arc.length();
        // steps of 1 % of many turns are no steps of a derivative: look at the part up to a radian
        let part = Part { curve: &arc, length: arc.length() / arc.angle().max(1.0), from: s };
        derivatives_are_limits(&part, 0.0)?;
        let here = arc.at(s);
        let arc_length = arc.arc_length(0.0, arc.length());
        // the length is the parameter, unless it turns faster than 1 rad per METRES_PER_RADIAN
        let angle = log(&(arc.at(arc.length()).pose.rotation * arc.at(0.0).pose.rotation.transpose())).norm();
        if METRES_PER_RADIAN * angle < arc_length {
            prop_assert!((arc_length - arc.length()).abs() < 1e-12 * arc_length);
            prop_assert!((here.first.linear_norm() - 1.0).abs() < 1e-13);
        }
        prop_assert!(here.first.linear_norm() < 1.0 + 1e-13);
        // of a helix: r/(r² + b²), with r·θ and b·θ the ways across and along the axis
        let across = arc.radius() * arc.angle();
        let expected = arc.radius() * (arc.angle() / arc_length).powf(2.0);
        prop_assert!((here.curvature() - expected).abs() < 1e-11 * expected);
        prop_assert!(across <= arc_length * (1.0 + 1e-14));
        // 64 chords a turn and more: each is shorter than its arc by (1/24)·(κ·step)²
        let steps = 2000;
        let mut sum = 0.0;
        for i in 0..steps {
            let place = |i: i32| arc.at(arc.length() * f64::from(i) / f64::from(steps)).pose.position;
            sum += (place(i + 1) - place(i)).norm();
        }
        let short = (expected * arc_length / f64::from(steps)).powf(2.0) / 24.0;
        prop_assert!(sum <= arc_length * (1.0 + 1e-12) && sum >= arc_length * (1.0 - 1.1 * short - 1e-12));
    }

    #[test]
    fn an_arc_through_three_points_passes_them_at_one_distance_from_its_centre(a in pose(), via in vector(1.0), b in pose()) {
        let (p, q) = (via - a.position, b.position - a.position);
        prop_assume!(p.cross(&q).norm() > 0.05 * p.norm() * q.norm() && p.norm() > 0.05 && q.norm() > 0.05);
        let arc = Arc::through(a, via, b).unwrap();
        // the radius is at most 40 times the chord: rounding 1e-16·R, times the conditioning 1/sine
        let (start, end) = (arc.at(0.0), arc.at(arc.length()));
        prop_assert_eq!(start.pose.position, a.position);
        let (metres, radians) = apart(&end.pose, &b);
        prop_assert!(metres < 1e-11 && radians < 1e-9, "{metres:e} {radians:e}");
        // by bisection of the angle seen from the start: where via is passed
        let centre = start.pose.position + start.second.linear * (arc.radius() / start.second.linear.norm());
        prop_assert!(((via - centre).norm() - arc.radius()).abs() < 1e-10);
        let distance = |s: f64| (arc.at(s).pose.position - via).norm();
        let steps = 4000;
        let nearest = (0..=steps).map(|i| distance(arc.length() * f64::from(i) / f64::from(steps))).fold(f64::INFINITY, f64::min);
        let metres = arc.arc_length(0.0, arc.length());
        prop_assert!(nearest <= metres / f64::from(steps), "via is not between the ends: {nearest}");
        prop_assert!(arc.angle() < TAU);
    }

    #[test]
    fn an_arc_to_an_end_meets_it(arc in helix(), turns in 0..3u16, noise in -1e-7..1e-7f64) {
        let (start, end) = (arc.at(0.0).pose, arc.at(arc.length() / arc.angle() * (arc.angle() % TAU)).pose);
        let out = arc.at(0.0).second.linear.normalize();
        let centre = start.position + out * arc.radius();
        // the second derivative turns with the arc; after one radian it shows the sense of rotation
        let normal = out.cross(&arc.at(arc.length() / arc.angle()).second.linear).normalize();
        let along = end.position - start.position;
        let across = along - normal * normal.dot(&along);
        prop_assume!(across.norm() > 0.1 * arc.radius());
        let off = centre + across.normalize() * noise;
        let again = Arc::to(start, end, off, normal, turns, 1e-6).unwrap();
        let (metres, radians) = apart(&again.at(again.length()).pose, &end);
        prop_assert!(metres < 1e-12 && radians < 1e-9, "{metres:e} {radians:e}");
        prop_assert!((again.radius() - arc.radius()).abs() <= 1e-7 * 1.1);
        prop_assert!((again.angle() - arc.angle() % TAU - TAU * f64::from(turns)).abs() < 1e-4);
        prop_assert_eq!(Arc::to(start, end, off + across.normalize() * 3e-6, normal, turns, 1e-6), Err(PieceError::NotEquidistant));
    }

    #[test]
    fn a_quintic_meets_both_points_in_two_derivatives(a in point(), b in point(), length in 0.2..2.0f64, u in -0.1..1.1f64) {
        let turn = log(&(b.pose.rotation * a.pose.rotation.transpose())).norm();
        prop_assume!(turn < 2.5);
        let curve = Quintic::between(&a, &b, length).unwrap();
        for (seen, given) in [(curve.at(0.0), a), (curve.at(length), b)] {
            let (metres, radians) = apart(&seen.pose, &given.pose);
            prop_assert!(metres < 1e-13 && radians < 1e-12, "{metres:e} {radians:e}");
            let jumps = jumps(&seen, &given);
            // coefficients up to 10³ over lengths down to 0.2: 1e-13·/0.2²
            prop_assert!(jumps[..4].iter().all(|j| *j < 1e-10), "{jumps:?}");
        }
        derivatives_are_limits(&curve, u * length)?;
    }

    #[test]
    fn a_quintic_is_the_same_in_both_directions(a in point(), b in point(), length in 0.2..2.0f64, u in 0.0..1.0f64) {
        let back = |x: &PathPoint| PathPoint {
            first: Twist { linear: -x.first.linear, angular: -x.first.angular },
            third: Twist { linear: -x.third.linear, angular: -x.third.angular },
            ..*x
        };
        prop_assume!(log(&(b.pose.rotation * a.pose.rotation.transpose())).norm() < 2.5);
        let there = Quintic::between(&a, &b, length).unwrap().at(u * length);
        let again = Quintic::between(&back(&b), &back(&a), length).unwrap().at((1.0 - u) * length);
        let (metres, radians) = apart(&there.pose, &again.pose);
        prop_assert!(metres < 1e-13 && radians < 1e-12);
        let jumps = jumps(&there, &back(&again));
        prop_assert!(jumps.iter().all(|j| *j < 1e-8), "{jumps:?}");
    }

    #[test]
    fn lengths_add_up(a in point(), b in point(), length in 0.2..2.0f64, u in 0.0..1.0f64) {
        let curve = Quintic::between(&a, &b, length).unwrap();
        let (s, all) = (u * length, curve.arc_length(0.0, length));
        let sum = curve.arc_length(0.0, s) + curve.arc_length(s, length);
        // random ends make wild curves, where |p'| may almost vanish and quadrature is worst
        prop_assert!((all - sum).abs() < 2e-3 * all, "{all} {sum}");
        prop_assert!((curve.arc_length(s, 0.0) + curve.arc_length(0.0, s)).abs() < 1e-15 * 100.0 * all);
        let chord = (b.pose.position - a.pose.position).norm();
        prop_assert!(all >= chord * (1.0 - 2e-3));
    }

    #[test]
    fn a_rigid_motion_of_the_ends_moves_the_curve(g in pose(), a in point(), b in point(), length in 0.2..2.0f64, u in 0.0..1.0f64) {
        prop_assume!(log(&(b.pose.rotation * a.pose.rotation.transpose())).norm() < 2.5);
        let here = Quintic::between(&a, &b, length).unwrap().at(u * length);
        let there = Quintic::between(&moved(&g, &a), &moved(&g, &b), length).unwrap().at(u * length);
        let (metres, radians) = apart(&moved(&g, &here).pose, &there.pose);
        prop_assert!(metres < 1e-13 && radians < 1e-12);
        prop_assert!(jumps(&moved(&g, &here), &there).iter().all(|j| *j < 1e-8));
    }
}

/// A piece seen from one of its points, with another length.
struct Part<'a, C> {
    curve: &'a C,
    length: f64,
    from: f64,
}

impl<C: Curve> Curve for Part<'_, C> {
    fn length(&self) -> f64 {
        self.length
    }

    fn at(&self, s: f64) -> PathPoint {
        self.curve.at(self.from + s)
    }
}

#[test]
fn a_whole_circle_comes_back() {
    let start = at(0.3, 0.0, 0.1);
    for circle in [
        Arc::about(
            start,
            Vector3::new(0.1, 0.0, -4.0),
            Vector3::z(),
            TAU,
            0.0,
            &start.rotation,
        ),
        Arc::to(
            start,
            start,
            Vector3::new(0.1, 0.0, 0.1),
            Vector3::z(),
            0,
            1e-6,
        ),
    ] {
        let circle = circle.unwrap();
        assert!((circle.length() - 0.2 * TAU).abs() < 1e-15);
        let half = circle.at(0.5 * circle.length()).pose.position;
        assert!((half - Vector3::new(-0.1, 0.0, 0.1)).norm() < 1e-15);
        assert!(apart(&circle.at(circle.length()).pose, &start).0 < 1e-15);
        assert!((circle.at(0.25 * circle.length()).first.linear + Vector3::x()).norm() < 1e-15);
    }
}

#[test]
fn a_negative_angle_turns_clockwise_and_advances_along_the_normal() {
    let start = at(1.0, 0.0, 0.0);
    let arc = Arc::about(
        start,
        Vector3::zeros(),
        Vector3::z(),
        -PI / 2.0,
        0.25,
        &start.rotation,
    )
    .unwrap();
    let end = arc.at(arc.length()).pose.position;
    assert!(
        (end - Vector3::new(0.0, -1.0, 0.25)).norm() < 1e-15,
        "{end}"
    );
}

#[test]
fn the_quadrature_of_a_quarter_circle_as_a_quintic_is_exact_to_rounding() {
    let arc = Arc::about(
        at(1.0, 0.0, 0.0),
        Vector3::zeros(),
        Vector3::z(),
        PI / 2.0,
        0.0,
        &Pose::identity().rotation,
    )
    .unwrap();
    let quintic = Quintic::between(&arc.at(0.0), &arc.at(arc.length()), arc.length()).unwrap();
    let expected = simpson(&quintic);
    let got = quintic.arc_length(0.0, quintic.length());
    assert!(
        (got - expected).abs() < 1e-13 * expected,
        "{got} {expected}"
    );
}

#[test]
fn pieces_without_length_are_refused() {
    let a = at(0.1, 0.2, 0.3);
    assert_eq!(Straight::new(a, a), Err(PieceError::TooShort));
    let near = Pose {
        position: a.position + Vector3::x() * 0.9 * SHORTEST_M,
        ..a
    };
    assert_eq!(Straight::new(a, near), Err(PieceError::TooShort));
    let turned = Pose::from_rotation_vector(
        a.position,
        Vector3::x() * 0.9 * SHORTEST_M / METRES_PER_RADIAN,
    );
    assert_eq!(Straight::new(a, turned), Err(PieceError::TooShort));
    let x = straight(a, at(0.2, 0.2, 0.3)).at(0.0);
    for length in [0.0, -1.0, 0.9 * SHORTEST_M] {
        assert_eq!(Quintic::between(&x, &x, length), Err(PieceError::TooShort));
    }
    let (zero, up) = (Vector3::zeros(), Vector3::z());
    assert_eq!(
        Arc::about(a, zero, up, 0.0, 0.0, &a.rotation),
        Err(PieceError::TooShort)
    );
    assert_eq!(
        Arc::about(a, zero, up, 1e-7, 0.0, &a.rotation),
        Err(PieceError::TooShort)
    );
}

#[test]
fn degenerate_arcs_are_refused() {
    let (a, b, c) = (at(0.0, 0.0, 0.0), at(1.0, 0.0, 0.0), at(2.0, 0.0, 0.0));
    let p = |pose: Pose| pose.position;
    assert_eq!(Arc::through(a, p(b), c), Err(PieceError::Collinear));
    assert_eq!(Arc::through(a, p(c), b), Err(PieceError::Collinear));
    assert_eq!(Arc::through(a, p(a), c), Err(PieceError::Collinear));
    assert_eq!(Arc::through(a, p(c), c), Err(PieceError::Collinear));
    assert_eq!(Arc::through(a, p(b), a), Err(PieceError::Collinear));
    assert_eq!(Arc::through(a, p(a), a), Err(PieceError::Collinear));
    let (z, r) = (Vector3::z(), a.rotation);
    assert_eq!(
        Arc::about(a, p(a) + z, z, 1.0, 0.0, &r),
        Err(PieceError::NoRadius)
    );
    assert_eq!(Arc::to(a, a, p(a), z, 0, 1e-6), Err(PieceError::NoRadius));
    for normal in [Vector3::zeros(), Vector3::x() * 1e-200] {
        assert_eq!(
            Arc::about(a, p(b), normal, 1.0, 0.0, &r),
            Err(PieceError::NoNormal)
        );
        assert_eq!(
            Arc::to(a, b, p(b), normal, 0, 1e-6),
            Err(PieceError::NoNormal)
        );
    }
    assert_eq!(
        Arc::to(a, c, Vector3::new(0.9, 0.0, 0.0), z, 0, 1e-6),
        Err(PieceError::NotEquidistant)
    );
}

#[test]
fn what_is_not_a_number_is_refused() {
    let (a, b) = (at(0.0, 0.0, 0.0), at(1.0, 1.0, 0.0));
    let (z, via) = (Vector3::z(), Vector3::x());
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let no = at(0.0, bad, 0.0);
        let mut twisted = b;
        twisted.rotation[(1, 2)] = bad;
        for no in [no, twisted] {
            assert_eq!(Straight::new(a, no), Err(PieceError::NotFinite));
            assert_eq!(Straight::new(no, a), Err(PieceError::NotFinite));
            assert_eq!(Arc::through(no, via, b), Err(PieceError::NotFinite));
            assert_eq!(Arc::through(a, via, no), Err(PieceError::NotFinite));
            assert_eq!(Arc::to(a, no, via, z, 0, 1e-6), Err(PieceError::NotFinite));
            assert_eq!(
                Arc::about(no, via, z, 1.0, 0.0, &a.rotation),
                Err(PieceError::NotFinite)
            );
        }
        let vector = Vector3::new(bad, 0.0, 0.0);
        assert_eq!(Arc::through(a, vector, b), Err(PieceError::NotFinite));
        assert_eq!(
            Arc::about(a, vector, z, 1.0, 0.0, &a.rotation),
            Err(PieceError::NotFinite)
        );
        assert_eq!(
            Arc::about(a, via, vector, 1.0, 0.0, &a.rotation),
            Err(PieceError::NotFinite)
        );
        assert_eq!(
            Arc::about(a, via, z, bad, 0.0, &a.rotation),
            Err(PieceError::NotFinite)
        );
        assert_eq!(
            Arc::about(a, via, z, 1.0, bad, &a.rotation),
            Err(PieceError::NotFinite)
        );
        assert_eq!(
            Arc::to(a, b, vector, z, 0, 1e-6),
            Err(PieceError::NotFinite)
        );
        let x = straight(a, b).at(0.0);
        let mut no = x;
        no.second.angular.y = bad;
        assert_eq!(Quintic::between(&x, &no, 1.0), Err(PieceError::NotFinite));
        assert_eq!(Quintic::between(&x, &x, bad), Err(PieceError::NotFinite));
    }
}

#[test]
fn far_beyond_the_ends_is_one_length_beyond_and_no_number_is_the_start() {
    let line = straight(at(0.0, 0.0, 0.0), at(2.0, 0.0, 0.0));
    for (s, x) in [
        (-9.0, -2.0),
        (99.0, 4.0),
        (f64::INFINITY, 4.0),
        (f64::NAN, 0.0),
        (-1.0, -1.0),
    ] {
        assert_eq!(line.at(s).pose.position.x, x);
    }
}

#[test]
fn curvature_is_that_of_a_cusp_or_of_rest_where_nothing_moves() {
    let mut x = straight(at(0.0, 0.0, 0.0), at(1.0, 0.0, 0.0)).at(0.0);
    x.first = Twist::zero();
    assert_eq!(x.curvature(), 0.0);
    x.second.linear.y = 1.0;
    assert_eq!(x.curvature(), f64::INFINITY);
}
