//! Straight lines in closed form; holds, reversals, corners, and samples that come late.

use crate::random::{Case, Random};
use crate::support::{Course, Path, Source, Wave, joint_limits, run};
use motion::AxisLimits;
use motion::feed::{Feed, Sample, Status};
use motion::profile::rest_time;

fn straight() -> Path<1> {
    Path::of_joints([Wave {
        slope: 1.0,
        ..Wave::default()
    }])
}

#[test]
fn a_straight_line_without_jerk_limit_takes_the_time_of_the_trapezoid() {
    for (length, step_s) in [(1.0, 0.001), (1.0, 0.02), (0.1, 0.001), (0.1, 0.004)] {
        let limits = joint_limits::<1>(1.0, 5.0, f64::INFINITY);
        let course = Course {
            length,
            grid: length / 200.0,
            step_s,
        };
        let run = run::<1, 256, 1>(&straight(), &limits, &course, 1000, |_| 1.0);
        let best = if length >= 0.2 {
            length / 1.0 + 1.0 / 5.0
        } else {
            2.0 * libm::sqrt(length / 5.0)
        };
        // 1 % of braking is reserve, 20 % in the last cell, which so takes (0.8^-½ − 1) longer; and the
        // last macrosteps are whole
        let last_cell = libm::sqrt(2.0 * course.grid / 5.0);
        let bound = 0.004 * best + 0.12 * last_cell + 4.0 * step_s;
        assert!(
            run.duration >= best - 1e-9 && run.duration <= best + bound,
            "{} {best}",
            run.duration
        );
    }
}

#[test]
fn a_straight_line_with_jerk_limit_takes_the_smoothing_time_longer_than_without() {
    // τ = 2·A/(0.65·J) against A/J of the closed form
    let axis = AxisLimits {
        v: 1.0,
        a: 5.0,
        j: 100.0,
    };
    for length in [0.5, 1.0, 2.0] {
        let limits = joint_limits::<1>(axis.v, axis.a, axis.j);
        let course = Course {
            length,
            grid: length / 200.0,
            step_s: 0.001,
        };
        let run = run::<1, 256, 256>(&straight(), &limits, &course, 1000, |_| 1.0);
        let plain = length / axis.v + axis.v / axis.a;
        let tau = 2.0 * axis.a / (0.65 * axis.j);
        let excess = run.duration - plain - tau;
        assert!(
            excess > -0.001 && excess < 0.006 * plain + 0.006,
            "{excess}"
        );
        let ratio = run.duration / rest_time(length, &axis);
        assert!(ratio > 1.0 && ratio < 1.16, "{ratio} at {length}");
    }
}

#[test]
fn a_hold_stops_where_it_was_said_and_goes_on() {
    for seed in 0..24 {
        let mut random = Random(seed);
        let case = Case::new(&mut random);
        let mut feed =
            Feed::<3, 256, 64>::new(&case.limits, case.course.grid, case.course.step_s).unwrap();
        let mut source = Source::new();
        let hold_at = 5 + (random.share() * 200.0) as usize;
        for _ in 0..hold_at {
            source.supply(&mut feed, &case.path, &case.course, 1000);
            feed.step(1.0);
        }
        let promised = feed.stops_at();
        let mut step = feed.step(0.0);
        for _ in 0..2000 {
            step = feed.step(0.0);
        }
        assert!(
            matches!(step.status, Status::Held | Status::Done),
            "{step:?}"
        );
        assert_eq!(step.end.p.to_bits(), promised.to_bits());
        let mut last = step;
        for _ in 0..20_000 {
            source.supply(&mut feed, &case.path, &case.course, 1000);
            last = feed.step(1.0);
            if last.status == Status::Done {
                break;
            }
        }
        assert_eq!(last.status, Status::Done);
    }
}

#[test]
fn a_negative_override_runs_back_to_what_is_retained() {
    let limits = joint_limits::<1>(1.0, 5.0, 100.0);
    let course = Course {
        length: 1.0,
        grid: 0.005,
        step_s: 0.004,
    };
    let mut feed = Feed::<1, 64, 64>::new(&limits, course.grid, course.step_s).unwrap();
    let mut source = Source::new();
    for _ in 0..200 {
        source.supply(&mut feed, &straight(), &course, 1000);
        feed.step(1.0);
    }
    let from = feed.retained_from();
    assert!(from > 0.0, "the window moves on");
    let mut step = feed.step(-1.0);
    let turned_at = step.end.p;
    for _ in 0..1000 {
        let now = feed.step(-1.0);
        assert!(now.end.p >= from);
        step = now;
    }
    assert_eq!(step.status, Status::AtStart);
    assert_eq!(step.end.p.to_bits(), from.to_bits());
    // a quarter of the window is kept behind, and the way that stopping took
    assert!(turned_at - from > 16.0 * course.grid);
    for _ in 0..3000 {
        source.supply(&mut feed, &straight(), &course, 1000);
        step = feed.step(1.0);
    }
    assert_eq!(step.status, Status::Done);
    assert!((step.end.p - 1.0).abs() < 1e-12);
}

#[test]
fn it_rests_exactly_at_a_corner_both_ways() {
    let limits = joint_limits::<2>(1.0, 5.0, 100.0);
    let along = |first: [f64; 2]| Sample {
        first,
        ..Path::of_joints([Wave::default(), Wave::default()]).sample(0.0)
    };
    let mut feed = Feed::<2, 128, 64>::new(&limits, 0.01, 0.004).unwrap();
    for first in [[1.0, 0.0], [0.0, 1.0]] {
        for _ in 0..30 {
            feed.push(&along(first)).unwrap();
        }
        feed.end_piece(&along(first), 0.5).unwrap();
    }
    feed.finish().unwrap();
    let corner = 29.5 * 0.01;
    for (feed_override, status) in [
        (1.0, Status::Done),
        (-1.0, Status::AtStart),
        (1.0, Status::Done),
    ] {
        let mut before = feed.step(feed_override).end;
        let mut rested = false;
        for _ in 0..2000 {
            let step = feed.step(feed_override);
            let passed = (before.p - corner) * (step.end.p - corner) < -1e-20;
            assert!(!passed, "passed the corner in motion: {before:?} {step:?}");
            rested |= (step.end.p - corner).abs() < 1e-14 && step.end.v == 0.0 && step.end.a == 0.0;
            before = step.end;
            if step.status == status {
                break;
            }
        }
        assert!(rested);
        assert_eq!(feed.step(feed_override).status, status);
    }
    assert!((feed.step(1.0).end.p - 0.59).abs() < 1e-14);
}

#[test]
fn it_waits_where_samples_end_and_goes_on_when_they_come() {
    let limits = joint_limits::<1>(1.0, 5.0, 100.0);
    let course = Course {
        length: 1.0,
        grid: 0.01,
        step_s: 0.004,
    };
    let mut feed = Feed::<1, 128, 64>::new(&limits, course.grid, course.step_s).unwrap();
    assert_eq!(feed.step(1.0).status, Status::Waiting);
    let mut source = Source::new();
    source.supply(&mut feed, &straight(), &course, 40);
    let mut step = feed.step(1.0);
    for _ in 0..2000 {
        step = feed.step(1.0);
        assert!(step.end.p < 0.39, "beyond what is known");
    }
    assert_eq!(step.status, Status::Waiting);
    assert!(step.end.p > 0.2 && step.end.v == 0.0, "{step:?}");
    for _ in 0..2000 {
        source.supply(&mut feed, &straight(), &course, 1);
        step = feed.step(1.0);
    }
    assert_eq!(step.status, Status::Done);
}

#[test]
fn an_override_is_of_the_programmed_feed_and_not_of_what_limits_allow() {
    let mut path = straight();
    path.linear[0] = Wave {
        slope: 1.0,
        ..Wave::default()
    };
    path.feed = 0.5;
    let course = Course {
        length: 1.0,
        grid: 0.005,
        step_s: 0.004,
    };
    let fastest = |v: f64, feed_override: f64| {
        let limits = joint_limits::<1>(v, 5.0, 100.0);
        let run = run::<1, 256, 64>(&path, &limits, &course, 1000, |_| feed_override);
        run.steps.iter().fold(
            0.0,
            |most, step| if step.end.v > most { step.end.v } else { most },
        )
    };
    // (speed limit, override) → speed; 3e-5 of it: the margin of the limits
    for (v, share, expected) in [
        (2.0, 1.0, 0.5),
        (2.0, 0.4, 0.2),
        (0.3, 0.4, 0.2),
        (0.1, 0.4, 0.1),
    ] {
        let speed = fastest(v, share);
        assert!(
            (speed - expected).abs() < 3e-5 * expected + 1e-9,
            "{v} {share}: {speed}"
        );
    }
}

#[test]
fn a_feed_in_the_place_of_another_is_as_a_new_one() {
    let mut random = Random(7);
    let (first, second) = (Case::new(&mut random), Case::new(&mut random));
    let steps = |feed: &mut Feed<3, 256, 64>, case: &Case| {
        let mut source = Source::new();
        let mut steps = Vec::new();
        for _ in 0..100 {
            source.supply(feed, &case.path, &case.course, 20);
            steps.push(feed.step(1.0));
        }
        steps
    };
    let begin = |feed: &mut Feed<3, 256, 64>, case: &Case| {
        let Course { grid, step_s, .. } = case.course;
        feed.begin(&case.limits, grid, step_s).unwrap();
    };
    let mut place = Feed::nothing();
    begin(&mut place, &first);
    let of_first = steps(&mut place, &first);
    // in the middle of the first path
    begin(&mut place, &second);
    let Course { grid, step_s, .. } = second.course;
    let mut new = Feed::new(&second.limits, grid, step_s).unwrap();
    let of_second = steps(&mut place, &second);
    assert_eq!(of_second, steps(&mut new, &second));
    assert_ne!(of_first, of_second);
    assert!(of_second.iter().any(|step| step.end.v > 0.0));
}
