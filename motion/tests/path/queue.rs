//! The queue of pieces: joins, cursor, blending, discarding.

use crate::moving_segment::spans;
use crate::support::{apart, at, jumps, straight};
use motion::path::{
    Arc, BlendError, Curve, Join, MovingSegment, Path, PathPoint, QueueError, Quintic, Tolerance,
};
use motion::{Pose, Twist};
use nalgebra::Vector3;
use proptest::prelude::*;

const FINE: Tolerance = Tolerance {
    metres: 1e-3,
    radians: 1e-2,
};

fn zigzag(i: u32) -> Pose {
    at(0.1 * f64::from(i), 0.1 * f64::from(i % 2), 0.0)
}

/// A path of blended zigzags.
fn blended<const N: usize>(corners: u32) -> Path<N> {
    let mut path = Path::new();
    for i in 0..=corners {
        path.push_blended(straight(zigzag(i), zigzag(i + 1)), &FINE)
            .unwrap();
    }
    path
}

#[test]
fn equal_derivatives_join_smoothly_and_others_stop() {
    let mut path = Path::<8>::new();
    assert_eq!(path.at(0.0), None);
    assert_eq!(
        path.push(straight(at(0.0, 0.0, 0.0), at(1.0, 0.0, 0.0))),
        Ok(Join::Stop)
    );
    // straight on
    assert_eq!(
        path.push(straight(at(1.0, 0.0, 0.0), at(1.5, 0.0, 0.0))),
        Ok(Join::Smooth)
    );
    // tangential, but the curvature jumps
    let arc = Arc::about(
        at(1.5, 0.0, 0.0),
        Vector3::new(1.5, 1.0, 0.0),
        Vector3::z(),
        1.0,
        0.0,
        &Pose::identity().rotation,
    )
    .unwrap();
    assert_eq!(path.push(arc), Ok(Join::Stop));
    // the same circle goes on
    let end = arc.at(arc.length()).pose;
    let on = Arc::about(
        end,
        Vector3::new(1.5, 1.0, 0.0),
        Vector3::z(),
        0.5,
        0.0,
        &Pose::identity().rotation,
    )
    .unwrap();
    assert_eq!(path.push(on), Ok(Join::Smooth));
    // turning begins
    let (a, b) = (
        on.at(0.5).pose,
        Pose::from_rotation_vector(Vector3::x(), Vector3::y()),
    );
    assert_eq!(path.push(straight(a, b)), Ok(Join::Stop));
    assert_eq!(path.stop_after(0.0), Some(1.5));
    assert_eq!(path.stop_after(1.5), Some(3.0));
    assert_eq!(path.stop_after(3.0), None);
    assert_eq!(path.stop_before(3.0), Some(1.5));
    assert_eq!(path.stop_before(1.5), None);
}

/// A derivative of a point.
type Part = fn(&mut PathPoint) -> &mut Twist;

#[test]
fn each_derivative_alone_makes_a_stop() {
    let x = straight(at(0.0, 0.0, 0.0), at(1.0, 0.0, 0.0)).at(1.0);
    assert_eq!(Join::between(&x, &x), Some(Join::Smooth));
    // just below and just above the bounds of the description
    let cases: [(Part, bool, f64); 4] = [
        (|x| &mut x.first, true, 1e-6),
        (|x| &mut x.first, false, 5e-5),
        (|x| &mut x.second, true, 1e-2),
        (|x| &mut x.second, false, 1e-1),
    ];
    for (part, linear, bound) in cases {
        for (jump, expected) in [
            (0.99 * bound, Join::Smooth),
            (1.01 * bound, Join::Stop),
            (f64::NAN, Join::Stop),
        ] {
            let mut y = x;
            let twist = part(&mut y);
            let vector = if linear {
                &mut twist.linear
            } else {
                &mut twist.angular
            };
            vector.z += jump;
            assert_eq!(Join::between(&x, &y), Some(expected));
        }
    }
    for (way, turn, expected) in [
        (0.99e-6, 0.0, Some(Join::Smooth)),
        (1.01e-6, 0.0, None),
        (0.0, 0.99e-5, Some(Join::Smooth)),
        (0.0, 1.01e-5, None),
        (f64::NAN, 0.0, None),
    ] {
        let step = Pose::from_rotation_vector(Vector3::x() * way, Vector3::y() * turn);
        assert_eq!(
            Join::between(
                &x,
                &PathPoint {
                    pose: x.pose * step,
                    ..x
                }
            ),
            expected
        );
    }
}

#[test]
fn the_path_is_c2_over_all_its_blends() {
    let mut path = blended::<32>(9);
    assert_eq!(path.len(), 19);
    assert_eq!(path.stop_after(0.0), None);
    let steps = 20_000;
    let h = path.end() / f64::from(steps);
    let mut before = path.at(0.0).unwrap();
    let mut greatest = [0.0_f64; 6];
    for i in 1..=steps {
        let here = path.at(h * f64::from(i)).unwrap();
        for (greatest, jump) in greatest.iter_mut().zip(jumps(&before, &here)) {
            *greatest = greatest.max(jump);
        }
        before = here;
    }
    // continuous: over a step p' changes by at most max|p''|·h, p'' by max|p'''|·h. d ≈ 3 mm: |p''| < 600,
    // |p'''| < 6·10⁵ (1/m²)
    assert!(
        greatest[0] < 600.0 * h && greatest[2] < 6e5 * h,
        "{greatest:?} {h}"
    );
    assert_eq!(path.at(path.end()).unwrap().pose, zigzag(10));
}

proptest! {
    #[test]
    fn jumping_about_and_going_along_see_the_same(at in prop::collection::vec(0.0..1.0f64, 1..40)) {
        let path = blended::<32>(8);
        let (mut jumping, mut along) = (path.clone(), path.clone());
        let mut sorted = at.clone();
        sorted.sort_by(f64::total_cmp);
        for u in at {
            let s = u * path.end();
            // a fresh cursor starts at the first piece
            prop_assert_eq!(jumping.at(s), path.clone().at(s));
        }
        for u in sorted.iter().chain(sorted.iter().rev()) {
            let s = u * path.end();
            prop_assert_eq!(along.at(s), path.clone().at(s));
        }
    }

    #[test]
    fn differences_across_joins_are_the_derivatives(u in 0.01..0.99f64) {
        let mut path = blended::<32>(8);
        // a step of 1e-4 m: at every 20th place it reaches over a join
        let (s, h) = (u * path.end(), 1e-4);
        let (x, here, y) = (path.at(s - h).unwrap(), path.at(s).unwrap(), path.at(s + h).unwrap());
        let velocity = (y.pose.position - x.pose.position) / (2.0 * h);
        // h²/6 of the greatest |p'''|, 6e5/m²
        prop_assert!((velocity - here.first.linear).norm() < 6e5 * h * h / 6.0);
    }
}

#[test]
fn a_curve_through_points_is_one_smooth_path() {
    let points = (0..30).map(|i| {
        let a = 0.3 * f64::from(i);
        Pose::from_rotation_vector(
            Vector3::new(a.cos(), a.sin(), 0.1 * a) * 0.1,
            Vector3::z() * a,
        )
    });
    let mut path = Path::<64>::new();
    for (i, span) in spans(points).into_iter().enumerate() {
        let expected = if i == 0 { Join::Stop } else { Join::Smooth };
        assert_eq!(path.push(span), Ok(expected));
    }
    assert_eq!((path.len(), path.room()), (29, 35));
    assert_eq!(path.stop_after(-1.0), None);
}

#[test]
fn joins_of_the_shortest_spans_are_smooth_in_spite_of_rounding() {
    for step in [1.1e-6, 3e-6, 1e-5, 1e-4] {
        let mut path = Path::<64>::new();
        let points = (0..60).map(|i| {
            let (i, place) = (f64::from(i), step * f64::from(i));
            let aside = 0.7 + 0.3 * step * (0.9 * i).sin();
            Pose::from_rotation_vector(
                Vector3::new(1.0 + place, aside, 0.3),
                Vector3::new(1.0, 0.1 * place, 0.0),
            )
        });
        for span in spans(points) {
            path.push(span).unwrap();
        }
        assert_eq!((path.len(), path.stop_after(-1.0)), (59, None));
    }
}

#[test]
fn a_piece_blended_at_both_ends_over_its_halves_is_gone() {
    let mut path = Path::<8>::new();
    let wide = Tolerance {
        metres: 1.0,
        radians: 1.0,
    };
    let corners = [
        at(0.0, 0.0, 0.0),
        at(1.0, 0.0, 0.0),
        at(1.0, 0.5, 0.0),
        at(2.0, 0.5, 0.0),
    ];
    for pair in corners.windows(2) {
        path.push_blended(straight(pair[0], pair[1]), &wide)
            .unwrap();
    }
    // line, blend, blend, line: of the short one in the middle nothing is left
    assert_eq!(path.len(), 4);
    assert_eq!(path.stop_after(0.0), None);
    let middle = path.at(0.5 * path.end()).unwrap();
    assert!((middle.pose.position - Vector3::new(1.0, 0.25, 0.0)).norm() < 1e-12);
    assert!((middle.first.linear - Vector3::y()).norm() < 1e-12);
    assert_eq!(path.at(path.end()).unwrap().pose, corners[3]);
}

#[test]
fn what_is_settled_does_not_change() {
    // blends of a few millimetres, of a tenth of the pieces or so, and of half of them
    for metres in [1e-3, 1e-2, 1.0] {
        let tolerance = Tolerance {
            metres,
            radians: 1.0,
        };
        let mut path = Path::<32>::new();
        path.push(straight(zigzag(0), zigzag(1))).unwrap();
        for i in 1..10 {
            let (settled, mut before) = (path.settled(), path.clone());
            path.push_blended(straight(zigzag(i), zigzag(i + 1)), &tolerance)
                .unwrap();
            for k in 0..100 {
                let s = settled * f64::from(k) / 100.0;
                assert_eq!(before.at(s), path.at(s));
            }
            assert!(path.settled() > settled && path.settled() < path.end());
            // a blend yet to come takes half of the last piece at most
            let half = 0.5 * straight(zigzag(i), zigzag(i + 1)).length();
            assert!((path.end() - path.settled() - half).abs() < 1e-12);
        }
    }
}

#[test]
fn discarded_pieces_make_room_and_s_goes_on() {
    let mut path = blended::<5>(1);
    assert_eq!((path.len(), path.room()), (3, 2));
    let whole = blended::<128>(40);
    for i in 2..=40 {
        let s = path.settled();
        let expected = whole.clone().at(s).unwrap();
        let seen = path.at(s).unwrap();
        assert!((seen.pose.position - expected.pose.position).norm() < 1e-12);
        path.discard_before(s);
        assert!(path.retained_from() <= s);
        let end = path.end();
        assert_eq!(
            path.push_blended(straight(zigzag(i), zigzag(i + 1)), &FINE),
            Ok(Join::Smooth)
        );
        assert!(path.end() > end);
    }
    assert!((path.end() - whole.end()).abs() < 1e-12);
    path.discard_before(f64::INFINITY);
    assert_eq!(path.len(), 1);
    assert!(!path.is_empty());
    // backwards as far as pieces are retained, and a little beyond
    let from = path.retained_from();
    assert!(path.at(from - 1e-3).is_some());
    path.discard_before(f64::NAN);
    assert_eq!(path.len(), 1);
}

#[test]
fn a_full_path_and_a_gap_are_refused_and_change_nothing() {
    let mut path = blended::<3>(1);
    let next = straight(zigzag(2), zigzag(3));
    let before = path.clone();
    assert_eq!(path.push(next), Err(QueueError::Full));
    assert_eq!(path.push_blended(next, &FINE), Err(QueueError::Full));
    assert_eq!(path, before);
    // one place is not enough for a blend and a piece
    let mut path = blended::<4>(1);
    let before = path.clone();
    assert_eq!(path.push_blended(next, &FINE), Err(QueueError::Full));
    assert_eq!(path, before);
    let mut path = blended::<8>(1);
    let before = path.clone();
    let far = straight(zigzag(4), zigzag(5));
    assert_eq!(path.push(far), Err(QueueError::Gap));
    assert_eq!(path.push_blended(far, &FINE), Err(QueueError::Gap));
    let none = Tolerance {
        metres: 0.0,
        ..FINE
    };
    assert_eq!(
        path.push_blended(next, &none),
        Err(QueueError::Corner(BlendError::Tolerance))
    );
    assert_eq!(path, before);
    assert_eq!(path.push(next), Ok(Join::Stop));
}

#[test]
fn no_number_is_the_start_of_the_piece_last_asked_for() {
    let mut path = blended::<8>(2);
    let end = path.end();
    let _ = path.at(end);
    let x = path.at(f64::NAN).unwrap();
    assert!(x.pose.position.iter().all(|x| x.is_finite()));
}

#[test]
fn a_piece_of_a_node_is_small() {
    // what a queue of 64 pieces costs a node: 28 KiB
    assert!(size_of::<Quintic>() <= 400);
    assert!(size_of::<Path<64>>() <= 64 * 448 + 64);
}

/// A wavy curve that turns, as spans.
fn waves() -> Vec<Quintic> {
    let mut curve = MovingSegment::new();
    let point = |i: i32| {
        let u = 0.3 * f64::from(i);
        let at = Vector3::new(0.01 * u, 4e-3 * libm::sin(u), 2e-3 * libm::cos(1.3 * u));
        let turn = Vector3::new(0.1 * libm::sin(0.7 * u), 0.05 * u, 0.1 * libm::cos(u));
        Pose::from_rotation_vector(at, turn)
    };
    let mut spans: Vec<_> = (0..20)
        .filter_map(|i| curve.push(point(i)).unwrap())
        .collect();
    spans.extend(std::iter::from_fn(|| curve.finish()));
    spans
}

#[test]
fn spans_of_a_curve_join_without_a_look_as_they_do_with_one() {
    let (mut looked, mut trusted) = (Path::<20>::new(), Path::<20>::new());
    for (i, span) in waves().iter().enumerate() {
        let join = looked.push(*span).unwrap();
        if i == 0 {
            assert_eq!(trusted.push_span(span), Err(QueueError::Gap));
            trusted.push(*span).unwrap();
        } else {
            assert_eq!(join, Join::Smooth);
            trusted.push_span(span).unwrap();
        }
    }
    assert_eq!(looked, trusted);
    let more = waves();
    trusted.push_span(&more[0]).unwrap();
    assert_eq!(trusted.push_span(&more[0]), Err(QueueError::Full));
}

#[test]
fn a_path_is_followed_with_the_derivatives_that_it_has() {
    let mut path = Path::<20>::new();
    for span in waves() {
        path.push(span).unwrap();
    }
    for i in 0..=1000 {
        let s = path.end() * f64::from(i) / 1000.0;
        let (exact, short) = (path.at(s).unwrap(), path.followed_at(s).unwrap());
        let (metres, radians) = apart(&exact.pose, &short.pose);
        assert!(metres < 1e-15 && radians < 1e-14, "{metres:e} {radians:e}");
        // over spans of 3.5 mm: some units of 6e-8 of 1, of 1/3.5 mm and of its square; ω is up to 30 times p'
        let jump = jumps(&exact, &short);
        assert!(jump[0] < 1e-6 && jump[1] < 3e-5, "{jump:?}");
        assert!(jump[2] < 3e-4 && jump[3] < 1e-2, "{jump:?}");
        let thirds = exact.third.linear - short.third.linear;
        assert!(thirds.norm() < 0.3, "{thirds:?}");
    }
}
