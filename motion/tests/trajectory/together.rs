//! Several axes: together in time, on a line, or each for itself.
use super::cases::{
    alone, at, axis, bounds, duration, from_anywhere, larger, several, symmetric, within,
};
use motion::profile::{AxisBounds, Boundary, Request, Synchronisation, Trajectory};
use proptest::prelude::*;

/// The earliest time from `least` on that is possible for every axis alone: in rounds, as no axis knows of another.
fn earliest_for_all<const N: usize>(request: &Request<N>, least: f64) -> f64 {
    let mut time = least;
    for _ in 0..50 {
        let latest = (0..N).fold(time, |latest, i| {
            let one = Request {
                minimum_duration: time,
                ..axis(request, i)
            };
            larger(latest, duration(&one))
        });
        if latest <= time {
            return time;
        }
        time = latest;
    }
    panic!("no time is possible for all axes");
}

/// Axes whose ends lie on a line: a shared motion of a parameter from 0 to 1, times a direction.
fn on_a_line() -> impl Strategy<Value = Request<3>> {
    let direction = prop::array::uniform3(prop_oneof![-4.0..-0.5f64, 0.5..4.0f64, Just(0.0)]);
    let limits = prop::array::uniform3(bounds(-0.5, 1.0));
    (direction, limits, prop::array::uniform4(-1.0..1.0f64)).prop_map(|(d, bounds, u)| {
        // what every axis can bear of the parameter
        let least = |limit: fn(&AxisBounds) -> f64| {
            (0..3)
                .filter(|i| d[*i] != 0.0)
                .fold(f64::INFINITY, |least, i| {
                    let share = limit(&bounds[i]) / d[i].abs();
                    if share < least { share } else { least }
                })
        };
        let v = least(|b| {
            if b.v_max < -b.v_min {
                b.v_max
            } else {
                -b.v_min
            }
        });
        let a = least(|b| {
            if b.a_max < -b.a_min {
                b.a_max
            } else {
                -b.a_min
            }
        });
        let j = least(|b| b.j_max);
        let (v, a, j) = if v.is_finite() {
            (v, a, j)
        } else {
            (1.0, 1.0, 1.0)
        };
        // 0.4 of the limits and of what the velocity allows an acceleration: inside in both directions
        let a = 0.4
            * if a < libm::sqrt(j * v) {
                a
            } else {
                libm::sqrt(j * v)
            };
        let state =
            |s: f64, i: usize, u: f64, w: f64| at(0.3 + s * d[i], 0.4 * v * u * d[i], a * w * d[i]);
        Request {
            start: core::array::from_fn(|i| state(0.0, i, u[0], u[1])),
            end: core::array::from_fn(|i| state(1.0, i, u[2], u[3])),
            bounds,
            synchronisation: Synchronisation::Phase,
            minimum_duration: 0.0,
        }
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    #[test]
    fn all_axes_arrive_at_the_earliest_time_possible_for_each(request in several::<4>(from_anywhere(-0.5, 0.7))) {
        let trajectory = Trajectory::new(&request).unwrap();
        prop_assert_eq!(trajectory.check(&request), Ok(()));
        let (taken, expected) = (trajectory.duration(), earliest_for_all(&request, 0.0));
        prop_assert!((taken - expected).abs() <= 1e-9, "{taken} {expected}");
        for i in 0..4 {
            let own: f64 = trajectory.phases(i).iter().map(|phase| phase.t).sum();
            // a state that is reached already needs no phases
            prop_assert!((own - taken).abs() <= 1e-12 * taken, "{i}: {own} {taken}");
        }
    }

    #[test]
    fn a_minimum_is_honoured_by_all(request in several::<3>(within(-1.0, 1.0)), least in 0.0..100.0f64) {
        let request = Request { minimum_duration: least, ..request };
        let trajectory = Trajectory::new(&request).unwrap();
        prop_assert_eq!(trajectory.check(&request), Ok(()));
        prop_assert!(trajectory.duration() >= least);
        let expected = earliest_for_all(&request, least);
        prop_assert!((trajectory.duration() - expected).abs() <= 1e-9, "{} {expected}", trajectory.duration());
    }

    #[test]
    fn without_synchronisation_every_axis_is_on_its_own(request in several::<3>(from_anywhere(-0.5, 0.7))) {
        let request = Request { synchronisation: Synchronisation::None, ..request };
        let trajectory = Trajectory::new(&request).unwrap();
        prop_assert_eq!(trajectory.check(&request), Ok(()));
        let mut last = 0.0;
        for i in 0..3 {
            let one = Trajectory::new(&axis(&request, i)).unwrap();
            prop_assert_eq!(one.phases(0), trajectory.phases(i));
            last = larger(last, one.duration());
        }
        prop_assert_eq!(trajectory.duration().to_bits(), f64::to_bits(last));
    }

    #[test]
    fn states_on_a_line_stay_on_it(request in on_a_line(), u in 0.0..1.0f64) {
        let trajectory = Trajectory::new(&request).unwrap();
        prop_assert_eq!(trajectory.check(&request), Ok(()));
        let states = trajectory.at(u * trajectory.duration());
        let way: [f64; 3] = core::array::from_fn(|i| request.end[i].p - request.start[i].p);
        let longest = (0..3).fold(0, |l, i| if way[i].abs() > way[l].abs() { i } else { l });
        let share = (states[longest].p - request.start[longest].p) / way[longest];
        for i in 0..3 {
            let expected = request.start[i].p + share * way[i];
            // of the way and of the positions, each rounded: some units in the last place of both
            let scale = 4.0 + share.abs() * way[longest].abs();
            prop_assert!(way[longest] == 0.0 || (states[i].p - expected).abs() <= 1e-12 * scale);
        }
        // the line costs time: never less than each axis needs
        let freely = Request { synchronisation: Synchronisation::Time, ..request };
        prop_assert!(trajectory.duration() >= duration(&freely) - 1e-9);
    }

    #[test]
    fn states_off_the_line_are_synchronised_in_time(request in several::<3>(within(-0.5, 1.0))) {
        let line = Trajectory::new(&Request { synchronisation: Synchronisation::Phase, ..request }).unwrap();
        prop_assert_eq!(line, Trajectory::new(&request).unwrap());
    }
}

#[test]
fn from_rest_the_line_is_as_fast_as_its_tightest_axis() {
    let rest = |p: f64| at(p, 0.0, 0.0);
    let request = Request {
        start: [rest(0.0), rest(0.0)],
        end: [rest(2.0), rest(-1.0)],
        bounds: [symmetric(1.0, 1.0, 1.0), symmetric(0.25, 1.0, 1.0)],
        synchronisation: Synchronisation::Phase,
        minimum_duration: 0.0,
    };
    // the second axis cruises at 0.25: two ramps of √(0.25/0.5)·2 s in the units of the first, 0.5 of its way
    let trajectory = Trajectory::new(&request).unwrap();
    let alone_slow = duration(&alone(rest(0.0), rest(-1.0), symmetric(0.25, 0.5, 0.5)));
    // the margin that the rounding of a direction needs is 1e-14
    assert!(
        (trajectory.duration() - alone_slow).abs() <= 1e-12,
        "{} {alone_slow}",
        trajectory.duration()
    );
}

#[test]
fn a_gap_of_one_axis_delays_all() {
    // both ends accelerate upwards at the same velocity, half a second of it apart: sooner or much later
    let (v, a) = (2.0, 1.0);
    let t = 0.1;
    let first = at(0.0, v, a);
    let end: Boundary = at(v * t + 0.5 * a * t * t, v + a * t, a);
    let bounds = symmetric(10.0, 1.0, 1.0);
    let quick = alone(first, end, bounds);
    assert!((duration(&quick) - t).abs() <= 1e-12);
    let slow = alone(Boundary::default(), at(0.5, 0.0, 0.0), bounds);
    let wanted = duration(&slow);
    let alone_later = duration(&Request {
        minimum_duration: wanted,
        ..quick
    });
    assert!(alone_later > wanted + 0.1, "{alone_later} {wanted}");
    let both = Request {
        start: [first, slow.start[0]],
        end: [end, slow.end[0]],
        bounds: [bounds; 2],
        synchronisation: Synchronisation::Time,
        minimum_duration: 0.0,
    };
    let trajectory = Trajectory::new(&both).unwrap();
    assert_eq!(trajectory.check(&both), Ok(()));
    assert!((trajectory.duration() - alone_later).abs() <= 1e-12);
}
