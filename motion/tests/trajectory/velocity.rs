//! Changes of velocity: optimal by the closed form of the double integrator, and stops.
use super::cases::{alone, at, axis, from_anywhere, larger, several, smaller, symmetric};
use motion::profile::{AxisBounds, Boundary, Request, Synchronisation, Trajectory};
use proptest::prelude::*;

fn planned<const N: usize>(request: &Request<N>) -> Trajectory<N> {
    let mut trajectory = Trajectory::empty();
    trajectory.plan_velocity(request).unwrap();
    trajectory
}

/// The shortest time of a double integrator (velocity and acceleration, jerk ≤ j) with limits of acceleration: the
/// least over all ways to rise to a peak and fall, or to fall and rise, that meet the velocity.
fn shortest(start: &Boundary, end: &Boundary, b: &AxisBounds) -> f64 {
    let j = b.j_max;
    let outside = larger(larger(start.a - b.a_max, b.a_min - start.a), 0.0) / j;
    let a0 = smaller(larger(start.a, b.a_min), b.a_max);
    // first the acceleration is brought inside, as fast as the jerk allows
    let v0 = start.v + outside * 0.5 * (start.a + a0);
    let (gain, a1) = (end.v - v0, end.a);
    let mut least = f64::INFINITY;
    for (gain, a0, a1, limit) in [(gain, a0, a1, b.a_max), (-gain, -a0, -a1, -b.a_min)] {
        // peak p: (2p² − a0² − a1²)/(2j) is gained in (2p − a0 − a1)/j; p² may have two roots
        let square = j * gain + 0.5 * (a0 * a0 + a1 * a1);
        // rounding of squares that should be zero
        let floor = 1e-13 * (a0 * a0 + a1 * a1 + j * gain.abs());
        if square < -floor {
            continue;
        }
        let top = libm::sqrt(larger(square, 0.0));
        for p in [top, -top] {
            if p >= larger(a0, a1) - 1e-7 * limit && p <= limit {
                least = smaller(least, (2.0 * p - a0 - a1) / j);
            }
        }
        if top > limit {
            let rest = gain - (2.0 * limit * limit - a0 * a0 - a1 * a1) / (2.0 * j);
            least = smaller(least, (2.0 * limit - a0 - a1) / j + rest / limit);
        }
    }
    outside + larger(least, 0.0)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn a_velocity_is_reached_in_the_shortest_time(request in from_anywhere(-0.5, 0.7)) {
        if (request.end[0].v - request.start[0].v).abs() < 1e-12 {
            return Ok(()); // less than the last unit of an acceleration is worth
        }
        let trajectory = planned(&request);
        prop_assert_eq!(trajectory.check(&request), Ok(()));
        let end = trajectory.end(0).unwrap();
        prop_assert_eq!((end.v.to_bits(), end.a.to_bits()), (request.end[0].v.to_bits(), request.end[0].a.to_bits()));
        // the time jumps where the ends can just be joined directly: on either side of that within rounding
        let (mut least, mut most) = (f64::INFINITY, 0.0);
        for shift in [-1e-13, 0.0, 1e-13] {
            let end = at(0.0, request.end[0].v + shift, request.end[0].a);
            let expected = shortest(&request.start[0], &end, &request.bounds[0]);
            (least, most) = (smaller(least, expected), larger(most, expected));
        }
        let taken = trajectory.duration();
        // a root of a difference of squares: half of the digits at worst
        prop_assert!(least - 1e-6 <= taken && taken <= most + 1e-6, "{taken} {least} {most}");
    }

    #[test]
    fn it_can_stop_from_any_state(request in several::<3>(from_anywhere(-0.5, 0.7)), alone in any::<bool>()) {
        let synchronisation = if alone { Synchronisation::None } else { Synchronisation::Time };
        let request = Request { end: [Boundary::default(); 3], synchronisation, ..request };
        let trajectory = planned(&request);
        prop_assert_eq!(trajectory.check(&request), Ok(()));
        for i in 0..3 {
            let end = trajectory.end(i).unwrap();
            prop_assert!(end.v.abs() <= 0.0 && end.a.abs() <= 0.0);
            let Some(last) = trajectory.phases(i).last().map(|phase| phase.at(phase.t)) else {
                continue; // it is at rest
            };
            // velocities up to 100 and their rounding
            prop_assert!(last.v.abs() <= 1e-12 && last.a.abs() <= 1e-12 && (last.p - end.p).abs() <= 1e-10);
        }
        let slowest = (0..3).fold(0.0, |t, i| larger(t, planned(&axis(&request, i)).duration()));
        prop_assert!(trajectory.duration() >= slowest);
    }

    #[test]
    fn limits_hold_however_long_the_others_take(
        request in several::<3>(from_anywhere(-0.5, 0.7)), more in 0.0..10.0f64,
    ) {
        let request = Request { minimum_duration: more, ..request };
        prop_assert_eq!(planned(&request).check(&request), Ok(()));
    }

    #[test]
    fn all_axes_reach_their_velocity_at_the_earliest_time_possible_for_each(
        request in several::<3>(from_anywhere(-0.5, 0.7)),
    ) {
        let trajectory = planned(&request);
        let mut time = 0.0;
        for _ in 0..10 {
            time = (0..3).fold(time, |t, i| {
                larger(t, planned(&Request { minimum_duration: time, ..axis(&request, i) }).duration())
            });
        }
        prop_assert!((trajectory.duration() - time).abs() <= 1e-9);
    }
}

#[test]
fn between_two_equal_accelerations_lies_a_gap() {
    let bounds = symmetric(10.0, 2.0, 1.0);
    // the same velocity with acceleration 1 at both ends: in no time, or down to −1 and up again in 4 s
    let still = alone(at(0.0, 0.0, 1.0), at(0.0, 0.0, 1.0), bounds);
    assert!(planned(&still).duration() <= 0.0);
    for least in [0.5, 2.0, 3.9] {
        let later = planned(&Request {
            minimum_duration: least,
            ..still
        });
        assert!(
            (later.duration() - 4.0).abs() <= 1e-12,
            "{}",
            later.duration()
        );
        assert_eq!(later.check(&still), Ok(()));
    }
    // another axis needs 2 s: both take 4
    let both = Request {
        start: [at(0.0, 0.0, 1.0), Boundary::default()],
        end: [at(0.0, 0.0, 1.0), at(0.0, 1.0, 0.0)],
        bounds: [bounds; 2],
        synchronisation: Synchronisation::Time,
        minimum_duration: 0.0,
    };
    let trajectory = planned(&both);
    assert_eq!(trajectory.check(&both), Ok(()));
    assert!(
        (trajectory.duration() - 4.0).abs() <= 1e-12,
        "{}",
        trajectory.duration()
    );
}
