//! Ranges of positions: kept whenever there is an answer, refused when they cannot be kept.
use super::cases::{alone, at, duration, larger, reach, smaller, symmetric, within};
use motion::profile::{AxisBounds, Boundary, ProfileError, Request, Synchronisation, Trajectory};
use proptest::prelude::*;

/// A move in a range that leaves `room` beyond both ends of it.
fn ranged() -> impl Strategy<Value = Request<1>> {
    (within(-0.5, 1.0), 0.0..2.0f64, 0.0..2.0f64).prop_map(|(request, below, above)| {
        let (p0, p1) = (request.start[0].p, request.end[0].p);
        let bounds = AxisBounds {
            p_min: smaller(p0, p1) - below * below,
            p_max: larger(p0, p1) + above * above,
            ..request.bounds[0]
        };
        Request {
            bounds: [bounds],
            ..request
        }
    })
}

fn endless(request: &Request<1>) -> Request<1> {
    let bounds = AxisBounds {
        p_min: f64::NEG_INFINITY,
        p_max: f64::INFINITY,
        ..request.bounds[0]
    };
    Request {
        bounds: [bounds],
        ..*request
    }
}

fn stays(trajectory: &Trajectory<1>, bounds: &AxisBounds) -> bool {
    let (low, high) = reach(trajectory, 0);
    // the rounding of positions up to 10
    trajectory.phases(0).is_empty() || low >= bounds.p_min - 1e-9 && high <= bounds.p_max + 1e-9
}

/// Whether the phases take the time of the trajectory: to the halvings of the planner, which meet a time to 1e-9.
fn lasts(trajectory: &Trajectory<1>) -> bool {
    let sum: f64 = trajectory.phases(0).iter().map(|phase| phase.t).sum();
    (sum - trajectory.duration()).abs() <= 2e-9 * trajectory.duration()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn an_answer_keeps_the_range_and_is_no_faster_than_without(request in ranged()) {
        let free = Trajectory::new(&endless(&request)).unwrap();
        let bounds = &request.bounds[0];
        match Trajectory::new(&request) {
            Ok(trajectory) => {
                prop_assert_eq!(trajectory.check(&request), Ok(()));
                prop_assert!(stays(&trajectory, bounds));
                prop_assert!(trajectory.duration() >= free.duration() - 1e-9);
                if stays(&free, bounds) && free.check(&request).is_ok() {
                    prop_assert_eq!(trajectory.phases(0), free.phases(0));
                }
            }
            Err(error) => {
                prop_assert_eq!(error.reason, ProfileError::LeavesRange);
                prop_assert!(!stays(&free, bounds) || free.check(&request).is_err());
            }
        }
    }

    #[test]
    fn given_more_time_it_stays_inside(request in ranged(), k in 1.0..3.0f64) {
        if let Ok(quick) = Trajectory::new(&request) {
            let slow = Request { minimum_duration: k * quick.duration(), ..request };
            // with more time the way may be another one, which may leave the range: a refusal then, not an exit
            if let Ok(trajectory) = Trajectory::new(&slow) {
                prop_assert_eq!(trajectory.check(&slow), Ok(()));
                prop_assert!(stays(&trajectory, &request.bounds[0]));
                prop_assert!(trajectory.duration() >= slow.minimum_duration);
                prop_assert!(lasts(&trajectory));
            }
        }
    }

    #[test]
    fn no_turn_is_faster_in_a_scan_over_the_acceleration_at_the_touch(request in ranged()) {
        let bounds = request.bounds[0];
        let free = endless(&request);
        let unlimited = Trajectory::new(&free).unwrap();
        let turned = Trajectory::new(&request);
        if stays(&unlimited, &bounds) {
            return Ok(()); // nothing to turn
        }
        // an end that is a rounding away from its limit of velocity, and not at it: there a turn may be refused that
        // exists
        let v = request.end[0].v;
        let nearly = |limit: f64| (1e-300..1e-12).contains(&(limit - v).abs());
        if nearly(bounds.v_max) || nearly(bounds.v_min) {
            return Ok(());
        }
        let (_, high) = reach(&unlimited, 0);
        let upper = high > bounds.p_max + 1e-9;
        let (edge, most) = if upper { (bounds.p_max, bounds.a_min) } else { (bounds.p_min, bounds.a_max) };
        // before and after the touch the velocity is inside its limits as well
        let bearable = libm::sqrt(2.0 * bounds.j_max * smaller(bounds.v_max, -bounds.v_min));
        let most = smaller(larger(most, -bearable), bearable);
        let mut least = f64::INFINITY;
        for k in 0..=400 {
            let touch = at(edge, 0.0, most * f64::from(k) / 400.0);
            let legs = [
                alone(free.start[0], touch, free.bounds[0]),
                alone(touch, free.end[0], free.bounds[0]),
            ];
            let motions = legs.map(|leg| Trajectory::new(&leg));
            if motions.iter().all(|m| m.as_ref().is_ok_and(|m| stays(m, &bounds))) {
                least = smaller(least, duration(&legs[0]) + duration(&legs[1]));
            }
        }
        match turned {
            Ok(trajectory) => prop_assert!(trajectory.duration() <= least + 1e-9, "{} {least}", trajectory.duration()),
            Err(error) => prop_assert!(least.is_infinite(), "{error}, but {least} s"),
        }
    }
}

/// How far it goes on from velocity v at acceleration 0 until it turns: with full jerk to the limit of acceleration,
/// and on with that.
fn turning_distance(v: f64, a: f64, j: f64) -> f64 {
    let t = smaller(a / j, libm::sqrt(2.0 * v / j));
    let left = v - 0.5 * j * t * t;
    t * (v - j * t * t / 6.0) + left * left / (2.0 * a)
}

proptest! {
    #[test]
    fn what_cannot_turn_in_time_is_refused(v in 0.1..2.0f64, a in 0.2..5.0f64, j in 0.2..20.0f64, up in any::<bool>()) {
        let needed = turning_distance(v, a, j);
        let side = if up { 1.0 } else { -1.0 };
        for (room, possible) in [(needed * (1.0 + 1e-6), true), (needed * (1.0 - 1e-6), false)] {
            let mut bounds = symmetric(2.0, a, j);
            if up { bounds.p_max = room } else { bounds.p_min = -room }
            let request = alone(at(0.0, side * v, 0.0), at(0.0, 0.0, 0.0), bounds);
            let planned = Trajectory::new(&request);
            match planned {
                Ok(trajectory) => {
                    prop_assert!(possible);
                    prop_assert_eq!(trajectory.check(&request), Ok(()));
                }
                Err(error) => prop_assert!(!possible && error.reason == ProfileError::LeavesRange, "{error}"),
            }
        }
    }
}

#[test]
fn several_axes_wait_inside_their_ranges() {
    let unit = symmetric(1.0, 1.0, 1.0);
    let rest = |p: f64| at(p, 0.0, 0.0);
    let tight = AxisBounds {
        p_min: -0.1,
        p_max: 0.6,
        ..unit
    };
    let request = Request {
        start: [at(0.0, 0.3, 0.0), rest(0.0)],
        end: [rest(0.05), rest(20.0)],
        bounds: [tight, unit],
        synchronisation: Synchronisation::Time,
        minimum_duration: 0.0,
    };
    let trajectory = Trajectory::new(&request).unwrap();
    assert_eq!(trajectory.check(&request), Ok(()));
    let slowest = duration(&alone(Boundary::default(), rest(20.0), unit));
    assert!((trajectory.duration() - slowest).abs() <= 1e-9);
}

/// Starts and ends, limits and a range, as they were found by chance.
#[expect(clippy::unreadable_literal, reason = "the digits as they were found")]
fn narrow() -> Request<1> {
    let mut bounds = symmetric(4.967189622255648, 8.918772812719933, 3.516748056210451);
    (bounds.p_min, bounds.p_max) = (1.3950119097972804, 5.536821766235046);
    let end = at(3.5800836451975275, bounds.v_max, 5.187252338640936);
    alone(at(1.5989407226273056, 0.0, 0.0), end, bounds)
}

#[test]
fn a_turn_with_little_choice_of_its_acceleration_is_found() {
    // the touch bears an acceleration of 4.13 to 4.25; a scan of 400 up to the most finds 6.0193 s
    let request = narrow();
    let trajectory = Trajectory::new(&request).unwrap();
    assert_eq!(trajectory.check(&request), Ok(()));
    assert!(stays(&trajectory, &request.bounds[0]));
    assert!(
        (6.0..6.0194).contains(&trajectory.duration()),
        "{}",
        trajectory.duration()
    );
}

#[test]
fn given_more_time_such_a_turn_waits_where_it_is_at_rest() {
    let slow = Request {
        minimum_duration: 9.0,
        ..narrow()
    };
    let trajectory = Trajectory::new(&slow).unwrap();
    assert_eq!(trajectory.check(&slow), Ok(()));
    assert!(lasts(&trajectory), "its phases take the time it takes");
    // and never at rest, it has nowhere to wait: refused, not torn
    let moving = Request {
        start: [at(slow.start[0].p, -0.01, 0.0)],
        ..slow
    };
    assert!(
        Trajectory::new(&Request {
            minimum_duration: 0.0,
            ..moving
        })
        .is_ok()
    );
    assert!(Trajectory::new(&moving).is_err());
}

#[test]
#[expect(clippy::unreadable_literal, reason = "the digits as they were found")]
fn a_start_on_the_way_out_is_refused_as_that_also_where_rounding_closes_the_earliest_way() {
    // the acceleration at the start takes the velocity to its limit exactly
    let mut bounds = symmetric(0.5488768317703799, 1.0, 0.3698752650759218);
    bounds.v_min = -4.6093159285277485;
    (bounds.p_min, bounds.p_max) = (-1.3999543489830433, -0.644356852015773);
    let start = at(bounds.p_max, 0.27487219505888394, 0.4502166981259052);
    let request = alone(start, at(bounds.p_min, bounds.v_max, 1.0), bounds);
    assert!(Trajectory::new(&endless(&request)).is_ok());
    let reason = Trajectory::new(&request).unwrap_err().reason;
    assert_eq!(reason, ProfileError::LeavesRange);
}
