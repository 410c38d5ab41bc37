//! Curves through points: joins, order of convergence, invariances, ends, and what is refused.

use crate::support::{apart, at, derivatives_are_limits, jumps, moved, pose, vector};
use motion::Pose;
use motion::path::{
    Curve, METRES_PER_RADIAN, MovingSegment, PathPoint, PointError, Quintic, SHORTEST_M,
};
use nalgebra::Vector3;
use proptest::prelude::*;

/// All spans of a curve.
pub(crate) fn spans(points: impl IntoIterator<Item = Pose>) -> Vec<Quintic> {
    let mut curve = MovingSegment::new();
    let mut spans: Vec<Quintic> = points
        .into_iter()
        .filter_map(|point| curve.push(point).unwrap())
        .collect();
    spans.extend(std::iter::from_fn(|| curve.finish()));
    spans
}

/// Jumps from each span to the next.
pub(crate) fn joins(spans: &[Quintic]) -> Vec<[f64; 6]> {
    spans
        .windows(2)
        .map(|pair| jumps(&pair[0].at(pair[0].length()), &pair[1].at(0.0)))
        .collect()
}

fn max(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, f64::max)
}

/// The least |p'|.
fn slowest(span: &Quintic) -> f64 {
    let speed = |i: i32| {
        span.at(span.length() * f64::from(i) / 40.0)
            .first
            .linear_norm()
    };
    (0..=40).map(speed).fold(f64::INFINITY, f64::min)
}

/// A walk: steps of 2 to 40 mm, up to 60° away from the direction before, turning up to 0.3 rad.
fn walk(points: std::ops::RangeInclusive<usize>) -> impl Strategy<Value = Vec<Pose>> {
    let step = (vector(1.0), 0.002..0.04f64, vector(0.17));
    prop::collection::vec(step, points).prop_map(|steps| {
        let (mut here, mut ahead) = (Pose::identity(), Vector3::x());
        let mut points = Vec::new();
        for (aside, length, turn) in steps {
            ahead = (ahead + aside * 0.5).normalize();
            here = Pose {
                position: here.position + ahead * length,
                rotation: Pose::from_rotation_vector(Vector3::zeros(), turn).rotation
                    * here.rotation,
            };
            points.push(here);
        }
        points
    })
}

proptest! {
    #[test]
    fn the_curve_is_through_all_points_and_c2(points in walk(2..=24)) {
        let spans = spans(points.iter().copied());
        prop_assert_eq!(spans.len(), points.len() - 1);
        for (pair, span) in points.windows(2).zip(&spans) {
            for (s, point) in [(0.0, pair[0]), (span.length(), pair[1])] {
                let (metres, radians) = apart(&span.at(s).pose, &point);
                prop_assert!(metres < 1e-14 && radians < 1e-12, "{metres:e} {radians:e}");
            }
            let (metres, radians) = apart(&pair[0], &pair[1]);
            prop_assert!((span.length() - metres.max(METRES_PER_RADIAN * radians)).abs() < 1e-15);
            derivatives_are_limits(span, 0.37 * span.length())?;
            let (least, length) = (slowest(span), span.length());
            let parts = span.arc_length(0.0, 0.4 * length) + span.arc_length(0.4 * length, length);
            let error = (span.arc_length(0.0, length) / parts - 1.0).abs();
            prop_assert!(error < if least > 0.7 { 1e-8 } else { 1e-3 }, "{error:e} {least}");
        }
        for jump in joins(&spans) {
            // rounding: coefficients of some 10 steps, 1e-15·10/step² at steps of 2 mm; the orientation's rates are
            // 1/METRES_PER_RADIAN times as large
            prop_assert!(jump[0] < 1e-11 && jump[1] < 1e-9 && jump[2] < 1e-8 && jump[3] < 1e-6, "{jump:?}");
        }
    }

    #[test]
    fn a_rigid_motion_of_the_points_moves_the_curve(g in pose(), tool in pose(), points in walk(2..=12), u in 0.0..1.0f64) {
        // in the base frame, and with another tool frame for the orientation
        let there = spans(points.iter().map(|p| g * *p));
        let rotated = spans(points.iter().map(|p| Pose { rotation: p.rotation * tool.rotation, ..*p }));
        for ((a, b), c) in spans(points).iter().zip(&there).zip(&rotated) {
            let (x, y, z) = (a.at(u * a.length()), b.at(u * b.length()), c.at(u * c.length()));
            let (metres, radians) = apart(&moved(&g, &x).pose, &y.pose);
            prop_assert!(metres < 1e-12 && radians < 1e-11, "{metres:e} {radians:e}");
            let jump = jumps(&moved(&g, &x), &y);
            // rounding of positions of 1 m, 1e-16/step² and /step³ at steps of 2 mm, times 100
            prop_assert!(jump[0] < 1e-10 && jump[2] < 1e-7 && jump[4] < 1e-3, "{jump:?}");
            prop_assert!(jump[1] < 1e-9 && jump[3] < 1e-6 && jump[5] < 1e-2, "{jump:?}");
            let retooled = Pose { rotation: x.pose.rotation * tool.rotation, ..x.pose };
            prop_assert!(apart(&retooled, &z.pose).1 < 1e-11);
            prop_assert!(jumps(&x, &z)[3] < 1e-6);
        }
    }

    #[test]
    fn the_way_back_is_the_same_curve(points in walk(2..=12), u in 0.0..1.0f64) {
        let back = spans(points.iter().rev().copied());
        for (a, b) in spans(points).iter().zip(back.iter().rev()) {
            let (x, y) = (a.at(u * a.length()), b.at((1.0 - u) * b.length()));
            let (metres, radians) = apart(&x.pose, &y.pose);
            prop_assert!(metres < 1e-13 && radians < 1e-12, "{metres:e} {radians:e}");
            prop_assert!((x.first.linear + y.first.linear).norm() < 1e-10);
            prop_assert!((x.second.linear - y.second.linear).norm() < 1e-7);
            prop_assert!((x.second.angular - y.second.angular).norm() < 1e-6);
            prop_assert!((x.third.linear + y.third.linear).norm() < 1e-3);
        }
    }

    #[test]
    fn a_span_depends_on_its_eight_points_only(points in walk(16..=16), aside in vector(0.01), which in 0..16usize) {
        let mut other = points.clone();
        other[which].position += aside;
        prop_assume!(aside.norm() > 1e-4);
        let (a, b) = (spans(points), spans(other));
        for (i, (a, b)) in a.iter().zip(&b).enumerate() {
            // span i is between points i and i+1: points i−3 to i+4
            let depends = which + 3 >= i && which <= i + 4;
            prop_assert_eq!(a == b, !depends, "span {} of a change at point {}", i, which);
        }
    }

    #[test]
    fn straight_rows_of_points_make_straight_lines(steps in prop::collection::vec(0.001..0.05f64, 1..10), direction in vector(1.0)) {
        prop_assume!(direction.norm() > 0.1);
        let (mut x, ahead) = (0.0, direction.normalize());
        let mut points = vec![at(0.0, 0.0, 0.0)];
        for step in &steps {
            x += step;
            points.push(Pose { position: ahead * x, ..points[0] });
        }
        for span in spans(points) {
            for u in [0.0, 0.3, 1.0] {
                let here = span.at(u * span.length());
                prop_assert!((here.first.linear - ahead).norm() < 1e-11);
                // rounding 1e-16·0.5/step² and step ratios up to 50
                prop_assert!(here.second.linear.norm() < 1e-7, "{}", here.second.linear.norm());
            }
        }
    }
}

/// Points of a circle of 0.1 m, turning along with it; a step is `angle`.
fn circle(angle: f64, count: i32) -> Vec<Pose> {
    let place = |i: i32| {
        let a = angle * f64::from(i);
        Pose::from_rotation_vector(
            Vector3::new(0.1 * a.cos(), 0.1 * a.sin(), 0.0),
            Vector3::z() * a,
        )
    };
    (0..count).map(place).collect()
}

/// Greatest errors over the spans in the middle: distance from the circle, |p'| − 1, curvature·R − 1, ω off
/// the direction of motion.
fn errors(angle: f64) -> [f64; 5] {
    let spans = spans(circle(angle, 24));
    let mut most = [0.0_f64; 5];
    for span in &spans[8..16] {
        for i in 0..=32 {
            let x = span.at(span.length() * f64::from(i) / 32.0);
            let off = x.pose.position.norm() / 0.1 - 1.0;
            let heading = x
                .pose
                .rotation
                .column(1)
                .dot(&x.first.linear.normalize())
                .acos();
            let seen = [
                off,
                x.first.linear_norm() - 1.0,
                x.curvature() * 0.1 - 1.0,
                heading,
                x.first.angular.z * 0.1 - x.first.linear_norm(),
            ];
            for (most, seen) in most.iter_mut().zip(seen) {
                *most = most.max(seen.abs());
            }
        }
    }
    most
}

#[test]
fn a_circle_is_met_with_fourth_order_and_its_curvature_with_second() {
    println!("step/°  off/R  |p'|-1  curvature  heading  ω");
    let steps = [30.0, 15.0, 7.5];
    let seen: Vec<[f64; 5]> = steps
        .iter()
        .map(|step| errors(f64::to_radians(*step)))
        .collect();
    for (step, e) in steps.iter().zip(&seen) {
        println!(
            "{step:6} {:9.2e} {:9.2e} {:9.2e} {:9.2e} {:9.2e}",
            e[0], e[1], e[2], e[3], e[4]
        );
    }
    for pair in seen.windows(2) {
        let order = |k: usize| (pair[0][k] / pair[1][k]).log2();
        println!("orders {:.2} {:.2} {:.2}", order(0), order(1), order(2));
        // half a power on either side: the next term of the expansion at 30°
        assert!((order(0) - 4.0).abs() < 0.5, "{}", order(0));
        assert!((order(1) - 2.0).abs() < 0.5, "{}", order(1));
        assert!((order(2) - 2.0).abs() < 0.5, "{}", order(2));
    }
}

#[test]
fn few_points_make_a_line_a_parabola_and_a_cubic() {
    let points = [
        at(0.0, 0.0, 0.0),
        at(0.1, 0.0, 0.0),
        at(0.1, 0.1, 0.0),
        at(0.0, 0.1, 0.1),
    ];
    assert!(spans(points[..0].iter().copied()).is_empty());
    assert!(spans(points[..1].iter().copied()).is_empty());
    // the derivative of order n of a polynomial of degree n is constant: over all spans
    for (count, order) in [(2, 1), (3, 2), (4, 3)] {
        let spans = spans(points[..count].iter().copied());
        assert_eq!(spans.len(), count - 1);
        let derivative = |x: PathPoint| [x.first, x.second, x.third][order - 1].linear;
        let expected = derivative(spans[0].at(0.0));
        assert!(expected.norm() > 0.5);
        for span in &spans {
            for u in [0.0, 0.5, 1.0] {
                let seen = derivative(span.at(u * span.length()));
                assert!(
                    (seen - expected).norm() < 1e-10 * expected.norm(),
                    "{count} {seen} {expected}"
                );
            }
        }
    }
}

#[test]
fn each_point_from_the_fifth_on_brings_a_span_and_the_end_the_last_three() {
    let mut curve = MovingSegment::new();
    let brought: Vec<bool> = circle(0.1, 12)
        .into_iter()
        .map(|p| curve.push(p).unwrap().is_some())
        .collect();
    assert_eq!(brought.iter().position(|b| *b), Some(4));
    assert!(brought[4..].iter().all(|b| *b));
    for _ in 0..3 {
        assert!(curve.finish().is_some());
        if curve != MovingSegment::new() {
            assert_eq!(curve.push(at(0.0, 0.0, 0.0)), Err(PointError::Finishing));
        }
    }
    assert_eq!(curve.finish(), None);
    assert_eq!(curve, MovingSegment::new());
    assert_eq!(curve.finish(), None);
}

#[test]
fn repeated_points_are_left_out_without_a_trace() {
    let points = circle(0.3, 10);
    let near = |p: &Pose| Pose {
        position: p.position + Vector3::z() * 0.9 * SHORTEST_M,
        ..*p
    };
    let twice: Vec<Pose> = points.iter().flat_map(|p| [*p, *p, near(p)]).collect();
    assert_eq!(spans(points), spans(twice));
    // slow creeping is no repetition: what counts is the distance to the last point that was kept
    let creep = (0..100).map(|i| at(0.3 * SHORTEST_M * f64::from(i), 0.0, 0.0));
    assert_eq!(spans(creep).len(), 24);
}

#[test]
fn bad_points_are_refused_and_change_nothing() {
    let mut curve = MovingSegment::new();
    for p in circle(0.2, 6) {
        curve.push(p).unwrap();
    }
    let before = curve.clone();
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e7, 1e300] {
        assert_eq!(curve.push(at(0.0, bad, 0.0)), Err(PointError::NotFinite));
    }
    let turned =
        |angle: f64| Pose::from_rotation_vector(Vector3::x(), Vector3::z() * (1.0 + angle));
    assert_eq!(curve.push(turned(1.001)), Err(PointError::TurnTooLarge));
    assert_eq!(curve.push(turned(-3.0)), Err(PointError::TurnTooLarge));
    let mut no = turned(0.0);
    no.rotation[(2, 0)] = f64::NAN;
    assert_eq!(curve.push(no), Err(PointError::NotFinite));
    assert_eq!(curve, before);
    assert!(curve.push(turned(0.999)).unwrap().is_some());
}

#[test]
fn chords_of_very_different_length_stay_numbers() {
    let mut x = 0.0;
    let points: Vec<Pose> = [1e-6, 1.0, 1e-6, 1e3, 1e-6, 1e-6, 1e5, 1e-3, 1.0, 1e-6]
        .into_iter()
        .enumerate()
        .map(|(i, step)| {
            x += step;
            at(x, if i % 2 == 0 { step } else { 0.0 }, 0.0)
        })
        .collect();
    for span in spans(points) {
        let here = span.at(0.5 * span.length());
        for twist in [here.first, here.second, here.third] {
            assert!(twist.linear.iter().all(|x| x.is_finite()));
        }
    }
}

#[test]
fn a_turn_on_the_spot_is_a_curve_too() {
    // about an axis that tilts: rotation vectors that do not commute
    let points = (0..12).map(|i| {
        let a = 0.25 * f64::from(i);
        Pose::from_rotation_vector(
            Vector3::x(),
            Vector3::new(0.3 * a.sin(), 0.2 * a, 0.3 * a.cos()),
        )
    });
    let points: Vec<Pose> = points.collect();
    let spans = spans(points.iter().copied());
    for (span, pair) in spans.iter().zip(points.windows(2)) {
        assert!((span.length() - METRES_PER_RADIAN * apart(&pair[0], &pair[1]).1).abs() < 1e-15);
        assert!(
            max((0..=10).map(|i| span
                .at(span.length() * f64::from(i) / 10.0)
                .first
                .linear_norm()))
                == 0.0
        );
    }
    let jumps = joins(&spans);
    // ω ≈ 50 rad/m, ω' some thousand: rounding 1e-15/step², steps of 5 mm
    assert!(max(jumps.iter().map(|j| j[1])) < 1e-10 && max(jumps.iter().map(|j| j[3])) < 1e-7);
    assert!(
        max(jumps.iter().map(|j| j[5])) > 1e-3,
        "and a third derivative that jumps"
    );
}
