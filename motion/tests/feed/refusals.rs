//! What is refused, and that a refusal changes nothing.

use crate::random::NO_TOOL;
use crate::support::{Path, Wave, joint_limits};
use motion::AxisLimits;
use motion::feed::{Feed, FeedError, FeedLimits, NormLimits, PushError, Sample, Status};

type Small = Feed<1, 16, 8>;

fn sample() -> Sample<1> {
    Path::of_joints([Wave {
        slope: 1.0,
        ..Wave::default()
    }])
    .sample(0.0)
}

fn small() -> Small {
    Small::new(&joint_limits(1.0, 5.0, 100.0), 0.1, 0.02).unwrap()
}

#[test]
fn senseless_limits_are_refused() {
    let axis = AxisLimits {
        v: 1.0,
        a: 1.0,
        j: 1.0,
    };
    for (v, a, j, error) in [
        (0.0, 1.0, 1.0, FeedError::NotPositive),
        (1.0, -1.0, 1.0, FeedError::NotPositive),
        (1.0, 1.0, 0.0, FeedError::NotPositive),
        (f64::NAN, 1.0, 1.0, FeedError::NotFinite),
        (f64::INFINITY, 1.0, 1.0, FeedError::NotFinite),
        (1.0, f64::INFINITY, 1.0, FeedError::NotFinite),
        (1.0, 1.0, f64::NAN, FeedError::NotFinite),
    ] {
        assert_eq!(
            Small::new(&joint_limits(v, a, j), 0.1, 0.02).unwrap_err(),
            error
        );
    }
    for (limit, error) in [
        (0.0, FeedError::NotPositive),
        (f64::NAN, FeedError::NotFinite),
    ] {
        for order in 0..3 {
            let mut norm = [None; 3];
            norm[order] = Some(limit);
            let [v, a, j] = norm;
            let linear = NormLimits { v, a, j };
            let limits = FeedLimits {
                joints: [axis],
                linear,
                angular: NO_TOOL,
            };
            assert_eq!(Small::new(&limits, 0.1, 0.02).unwrap_err(), error);
        }
    }
    let limits = joint_limits(1.0, 1.0, 1.0);
    assert_eq!(
        Small::new(&limits, 0.0, 0.02).unwrap_err(),
        FeedError::NotPositive
    );
    assert_eq!(
        Small::new(&limits, 0.1, f64::INFINITY).unwrap_err(),
        FeedError::NotFinite
    );
    assert_eq!(
        Feed::<1, 15, 8>::new(&limits, 0.1, 0.02).unwrap_err(),
        FeedError::NoRoom
    );
    assert_eq!(
        Feed::<1, 16, 0>::new(&limits, 0.1, 0.02).unwrap_err(),
        FeedError::NoRoom
    );
}

#[test]
fn senseless_samples_are_refused_and_change_nothing() {
    let mut feed = small();
    feed.push(&sample()).unwrap();
    let room = feed.room();
    for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut bad = [sample(); 5];
        bad[0].first[0] = x;
        bad[1].second[0] = x;
        bad[2].third[0] = x;
        bad[3].tool.linear[1][2] = x;
        bad[4].tool.angular[2][0] = x;
        for bad in bad {
            assert_eq!(feed.push(&bad), Err(PushError::NotFinite));
            assert_eq!(feed.end_piece(&bad, 0.5), Err(PushError::NotFinite));
        }
    }
    for (rate, error) in [
        (f64::NAN, PushError::NotFinite),
        (0.0, PushError::NotPositive),
        (-1.0, PushError::NotPositive),
    ] {
        assert_eq!(
            feed.push(&Sample {
                feed: rate,
                ..sample()
            }),
            Err(error)
        );
    }
    for steep in [1e9, 1e200] {
        assert_eq!(
            feed.push(&Sample {
                first: [steep],
                ..sample()
            }),
            Err(PushError::Singular)
        );
        assert_eq!(
            feed.push(&Sample {
                second: [steep * 1e9],
                ..sample()
            }),
            Err(PushError::Singular)
        );
    }
    for fraction in [0.0, -0.5, 1.1, f64::NAN] {
        assert_eq!(
            feed.end_piece(&sample(), fraction),
            Err(PushError::Fraction)
        );
    }
    assert_eq!(feed.room(), room);
    feed.push(&sample()).unwrap();
    feed.end_piece(&sample(), 1.0).unwrap();
    feed.finish().unwrap();
    assert!((0..1000).any(|_| feed.step(1.0).status == Status::Done));
    assert!((feed.step(1.0).end.p - 0.2).abs() < 1e-15);
}

#[test]
fn a_piece_needs_a_beginning_and_a_path_an_end() {
    let mut feed = small();
    assert_eq!(feed.end_piece(&sample(), 1.0), Err(PushError::Fraction));
    feed.push(&sample()).unwrap();
    assert_eq!(feed.finish(), Err(PushError::Finished));
    feed.end_piece(&sample(), 1.0).unwrap();
    feed.finish().unwrap();
    assert_eq!(feed.push(&sample()), Err(PushError::Finished));
}

#[test]
fn a_full_window_refuses_until_the_motion_has_moved_on() {
    let mut feed = small();
    let mut pushed = 0;
    while feed.push(&sample()).is_ok() {
        pushed += 1;
        assert!(pushed < 100);
    }
    assert_eq!(feed.room(), 0);
    assert_eq!(feed.push(&sample()), Err(PushError::Full));
    for _ in 0..200 {
        feed.step(1.0);
    }
    assert!(feed.room() > 0);
    assert_eq!(feed.push(&sample()), Ok(()));
}

#[test]
fn an_override_that_is_not_a_number_is_a_hold() {
    let mut feed = small();
    for _ in 0..10 {
        feed.push(&sample()).unwrap();
    }
    for _ in 0..100 {
        let step = feed.step(f64::NAN);
        assert!(step.end.p == 0.0 && step.end.v == 0.0);
    }
    assert!(feed.step(7.0).end.v >= 0.0);
}

#[test]
fn a_place_without_a_path_takes_no_samples_and_rests() {
    let mut nothing = Small::nothing();
    assert_eq!(nothing.push(&sample()), Err(PushError::Finished));
    assert_eq!(nothing.end_piece(&sample(), 1.0), Err(PushError::Finished));
    for share in [1.0, 0.0, -1.0, f64::NAN] {
        let step = nothing.step(share);
        assert!(step.status != Status::Moving, "{step:?}");
        let rest = motion::profile::State::REST;
        assert_eq!((step.end, step.phase.at(0.02)), (rest, rest));
    }
}

#[test]
fn a_refused_beginning_leaves_the_path_as_it_was() {
    let mut feed = small();
    feed.push(&sample()).unwrap();
    let room = feed.room();
    let begun = feed.begin(&joint_limits(0.0, 5.0, 100.0), 0.1, 0.02);
    assert_eq!(begun, Err(FeedError::NotPositive));
    assert_eq!(feed.room(), room);
    assert_eq!(feed.end_piece(&sample(), 1.0), Ok(()));
}
