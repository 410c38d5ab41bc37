//! Optimal by formulas that the planner does not use.
use super::cases::{alone, at, larger, smaller, symmetric};
use motion::profile::{AxisLimits, Boundary, Trajectory, rest_time};
use proptest::prelude::*;

fn magnitude(lo: f64, hi: f64) -> impl Strategy<Value = f64> {
    (lo..hi).prop_map(libm::exp10)
}

/// The shortest time with a limit of velocity and one of acceleration, without one of jerk, to rest: a trapezoid to
/// either side, whichever meets the distance. With s the side and w = s·v0, a peak u ≥ w covers
/// (2u² − w²)/(2a) in (2u − w)/a.
fn trapezoid(distance: f64, v0: f64, v: f64, a: f64) -> f64 {
    let mut least = f64::INFINITY;
    for side in [1.0, -1.0] {
        let (d, w) = (side * distance, side * v0);
        let square = a * d + 0.5 * w * w;
        if square < 0.0 {
            continue;
        }
        let u = libm::sqrt(square);
        if u < larger(w, 0.0) {
            continue;
        }
        let time = if u <= v {
            (2.0 * u - w) / a
        } else {
            (2.0 * v - w) / a + (d - (v * v - 0.5 * w * w) / a) / v
        };
        least = smaller(least, time);
    }
    least
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn from_rest_to_rest_it_takes_the_time_of_the_closed_form(
        d in magnitude(-6.0, 4.0), v in magnitude(-2.0, 3.0), a in magnitude(-2.0, 3.0), j in magnitude(-2.0, 5.0),
        back in any::<bool>(),
    ) {
        let p = if back { -d } else { d };
        let request = alone(Boundary::default(), at(p, 0.0, 0.0), symmetric(v, a, j));
        let trajectory = Trajectory::new(&request).unwrap();
        prop_assert_eq!(trajectory.check(&request), Ok(()));
        let expected = rest_time(d, &AxisLimits { v, a, j });
        // some roots and sums: a few units in the last place
        prop_assert!((trajectory.duration() - expected).abs() <= 1e-12 * expected);
    }

    #[test]
    fn almost_at_rest_it_takes_almost_that(
        d in magnitude(-1.0, 2.0), v in magnitude(-1.0, 1.0), a in magnitude(-1.0, 1.0), j in magnitude(-1.0, 1.0),
    ) {
        // the way through the search of any states, not the closed form
        let request = alone(at(0.0, 1e-12 * v, 0.0), at(d, 0.0, 0.0), symmetric(v, a, j));
        let taken = Trajectory::new(&request).unwrap().duration();
        let expected = rest_time(d, &AxisLimits { v, a, j });
        // a velocity of 1e-12 of the limit is worth less than 1e-12 of the times at limits
        prop_assert!((taken - expected).abs() <= 1e-10 * (expected + v / a + a / j), "{taken} {expected}");
    }

    #[test]
    fn without_a_limit_of_jerk_to_speak_of_it_is_the_trapezoid(
        d in -10.0..10.0f64, u in -1.0..1.0f64, v in magnitude(-1.0, 1.0), a in magnitude(-1.0, 1.0),
    ) {
        close_to_the_trapezoid(d, u, v, a)?;
    }
}

/// Over 2a/j any motion without a limit of jerk can be averaged: the mean keeps the limits of velocity and
/// acceleration, its jerk is at most j, it takes 2a/j longer, and for a/j it goes on as it started. So never slower
/// than a trapezoid over what is left of the distance then, and 2a/j; and never faster than the trapezoid.
fn close_to_the_trapezoid(d: f64, u: f64, v: f64, a: f64) -> Result<(), TestCaseError> {
    let mut before = f64::INFINITY;
    for jerks in [1e4, 1e6, 1e8] {
        let j = a * jerks;
        let request = alone(at(0.0, u * v, 0.0), at(d, 0.0, 0.0), symmetric(v, a, j));
        let taken = Trajectory::new(&request).unwrap().duration();
        let least = trapezoid(d, u * v, v, a);
        let most = trapezoid(d - u * v * a / j, u * v, v, a) + 2.0 * a / j;
        prop_assert!(taken >= least - 1e-9, "{taken} {least}");
        prop_assert!(taken <= most + 1e-9, "{taken} {most}");
        prop_assert!(taken <= before + 1e-9);
        before = taken;
    }
    Ok(())
}

#[test]
fn a_short_way_back_from_beyond_costs_more_than_the_changes_of_acceleration() {
    // 5.4 mm beyond after 5 m: the way back is slow, and 0.07 mm more of it worth 2 ms
    close_to_the_trapezoid(
        4.968_237_020_272_312,
        0.758_822_189_817_746,
        1.869_414_152_494_679_2,
        0.202_286_856_390_335_72,
    )
    .unwrap();
}
