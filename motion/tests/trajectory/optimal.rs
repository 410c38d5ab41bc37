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
        let mut before = f64::INFINITY;
        for jerks in [1e4, 1e6, 1e8] {
            let j = a * jerks;
            let request = alone(at(0.0, u * v, 0.0), at(d, 0.0, 0.0), symmetric(v, a, j));
            let taken = Trajectory::new(&request).unwrap().duration();
            let expected = trapezoid(d, u * v, v, a);
            // never faster; each of at most three changes of acceleration, of 2a at most, costs its time a/j, and
            // what is covered in it is made good at the speed then: three times as much
            prop_assert!(taken >= expected - 1e-9, "{taken} {expected}");
            prop_assert!(taken <= expected + 20.0 * a / j + 1e-9, "{taken} {expected}");
            prop_assert!(taken <= before + 1e-9);
            before = taken;
        }
    }
}
