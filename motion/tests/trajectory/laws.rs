//! What must hold of the fastest motion of one axis, whatever is asked.
use super::cases::{alone, at, duration, from_anywhere, larger, missed, within};
use motion::profile::{AxisBounds, Boundary, Request, Trajectory};
use proptest::prelude::*;

fn map(
    request: &Request<1>,
    state: impl Fn(&Boundary) -> Boundary,
    bounds: AxisBounds,
) -> Request<1> {
    alone(state(&request.start[0]), state(&request.end[0]), bounds)
}

fn magnified(bounds: &AxisBounds, v: f64, a: f64, j: f64) -> AxisBounds {
    AxisBounds {
        v_min: v * bounds.v_min,
        v_max: v * bounds.v_max,
        a_min: a * bounds.a_min,
        a_max: a * bounds.a_max,
        j_max: j * bounds.j_max,
        ..*bounds
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn any_start_leads_to_the_end_within_the_limits(request in from_anywhere(-0.5, 0.7)) {
        let trajectory = Trajectory::new(&request).unwrap();
        prop_assert_eq!(trajectory.check(&request), Ok(()));
        prop_assert_eq!(trajectory.end(0), Some(request.end[0]));
        // some thousand units in the last place of the way, which is up to 1e4 long here
        let [p, v, a] = missed(&trajectory, &request, 0);
        let way = trajectory.phases(0).iter().fold(0.0, |way, phase| larger(way, phase.p0.abs()));
        prop_assert!(p <= 1e-10 + 1e-12 * way && v <= 1e-10 && a <= 1e-10, "{p:e} {v:e} {a:e}");
    }

    #[test]
    fn with_moderate_limits_the_end_is_met_to_rounding(request in within(-0.5, 1.0)) {
        let trajectory = Trajectory::new(&request).unwrap();
        let [p, v, a] = missed(&trajectory, &request, 0);
        // some ten thousand units in the last place of positions, velocities and accelerations up to 10
        prop_assert!(p <= 1e-11 && v <= 1e-12 && a <= 1e-12, "{p:e} {v:e} {a:e}");
    }

    #[test]
    fn larger_limits_do_not_take_longer(
        request in within(-1.0, 1.0), v in 1.0..3.0f64, a in 1.0..3.0f64, j in 1.0..3.0f64,
    ) {
        let freer = Request { bounds: [magnified(&request.bounds[0], v, a, j)], ..request };
        // the same limits to 1e-9: that an end on a limit needs
        prop_assert!(duration(&freer) <= duration(&request) + 1e-9);
    }

    #[test]
    fn a_mirrored_problem_has_the_mirrored_motion(request in from_anywhere(-0.5, 0.7), u in 0.0..1.0f64) {
        let b = request.bounds[0];
        let mirror = AxisBounds { v_min: -b.v_max, v_max: -b.v_min, a_min: -b.a_max, a_max: -b.a_min, ..b };
        let mirrored = map(&request, |s| at(-s.p, -s.v, -s.a), mirror);
        let (one, other) = (Trajectory::new(&request).unwrap(), Trajectory::new(&mirrored).unwrap());
        // both are the same sums in another order at most
        prop_assert!((one.duration() - other.duration()).abs() <= 1e-12 * larger(1.0, one.duration()));
        let t = u * one.duration();
        let ([x], [y]) = (one.at(t), other.at(t));
        prop_assert!((x.p + y.p).abs() <= 1e-9 && (x.v + y.v).abs() <= 1e-9 && (x.a + y.a).abs() <= 1e-9);
    }

    #[test]
    fn backwards_in_time_it_takes_as_long(request in within(-1.0, 1.0)) {
        let b = request.bounds[0];
        // reversed in time, velocity and jerk change their sign, acceleration does not
        let back = |s: &Boundary| at(s.p, -s.v, s.a);
        let bounds = AxisBounds { v_min: -b.v_max, v_max: -b.v_min, ..b };
        let reversed = alone(back(&request.end[0]), back(&request.start[0]), bounds);
        let (there, back) = (duration(&request), duration(&reversed));
        prop_assert!((there - back).abs() <= 1e-9, "{there} {back}");
    }

    #[test]
    fn all_lengths_times_k_take_as_long(request in from_anywhere(-0.5, 0.7), n in -20..20i32) {
        let k = libm::ldexp(1.0, n);
        let bounds = magnified(&request.bounds[0], k, k, k);
        let scaled = map(&request, |s| at(k * s.p, k * s.v, k * s.a), bounds);
        // powers of two change no mantissa
        prop_assert_eq!(duration(&scaled).to_bits(), duration(&request).to_bits());
    }

    #[test]
    fn all_times_times_k_take_k_times_as_long(request in from_anywhere(-0.5, 0.7), n in -20..20i32) {
        let k = libm::ldexp(1.0, n);
        let bounds = magnified(&request.bounds[0], 1.0 / k, 1.0 / (k * k), 1.0 / (k * k * k));
        let scaled = map(&request, |s| at(s.p, s.v / k, s.a / (k * k)), bounds);
        let (slow, fast) = (duration(&scaled), k * duration(&request));
        // powers of two change no mantissa, but cube roots of other octaves may be rounded otherwise
        prop_assert!((slow - fast).abs() <= 1e-12 * fast, "{slow} {fast}");
    }

    #[test]
    fn it_begins_and_ends_as_asked(request in from_anywhere(-0.5, 0.7), more in 0.0..5.0f64) {
        let trajectory = Trajectory::new(&request).unwrap();
        let ([start], [end]) = (request.start, request.end);
        let [first] = trajectory.at(0.0);
        // velocity and acceleration are divided by the jerk limit and multiplied again
        prop_assert!(first.p.to_bits() == start.p.to_bits() || trajectory.duration() == 0.0);
        prop_assert!((first.v - start.v).abs() <= 1e-15 * start.v.abs());
        prop_assert!((first.a - start.a).abs() <= 1e-15 * start.a.abs());
        prop_assert_eq!(trajectory.at(-1.0), trajectory.at(0.0));
        let [last] = trajectory.at(trajectory.duration());
        prop_assert_eq!([last.p, last.v, last.a].map(f64::to_bits), [end.p, end.v, end.a].map(f64::to_bits));
        // from there on with the velocity and acceleration of the end
        let [after] = trajectory.at(trajectory.duration() + more);
        let expected = end.p + end.v * more + 0.5 * end.a * more * more;
        // the time after the end is a difference of times up to 1e3
        prop_assert!((after.p - expected).abs() <= 1e-10 && (after.v - end.v - end.a * more).abs() <= 1e-10);
    }

    #[test]
    fn a_sampler_reads_what_at_tells(request in from_anywhere(-0.5, 0.7), steps in 1..300u32) {
        let trajectory = Trajectory::new(&request).unwrap();
        let mut sampler = trajectory.sampler();
        for k in 0..=steps {
            let t = 1.1 * trajectory.duration() * f64::from(k) / f64::from(steps);
            let ([x], [y]) = (sampler.at(t), trajectory.at(t));
            // beginnings of phases are sums in another order: a unit in the last place of the time, 1e3 at most,
            // times velocity, acceleration, and jerk, which are below 30
            prop_assert!((x.p - y.p).abs() <= 1e-11 && (x.v - y.v).abs() <= 1e-11 && (x.a - y.a).abs() <= 1e-11);
        }
    }

    #[test]
    fn more_time_is_taken_where_it_can_be(request in from_anywhere(-0.5, 0.7), k in 1.0..4.0f64) {
        let shortest = duration(&request);
        let asked = k * shortest;
        let slow = Request { minimum_duration: asked, ..request };
        let trajectory = Trajectory::new(&slow).unwrap();
        prop_assert_eq!(trajectory.check(&slow), Ok(()));
        let taken = trajectory.duration();
        prop_assert!(taken >= asked);
        let total: f64 = trajectory.phases(0).iter().map(|phase| phase.t).sum();
        prop_assert!((total - taken).abs() <= 1e-12 * taken, "{total} {taken}");
        if taken > asked {
            // a time that is not possible: nor is any between
            let between = Request { minimum_duration: 0.5 * (asked + taken), ..request };
            prop_assert!((duration(&between) - taken).abs() <= 1e-9 * taken);
        }
    }
}

/// Motions that a search over the whole curve of reachable distances once missed or could not write.
#[test]
fn known_hard_cases() {
    let limits = super::cases::symmetric;
    for (request, expected) in [
        // the brake ends where the lower limit of velocity can just be kept: a rise without any rounding left
        (
            alone(
                at(-1.0, -1.0, 3.0),
                at(-1.0, -1.0, 0.0),
                limits(1.0, 3.0, 1.0),
            ),
            18.545_941_546_018_39,
        ),
        // the velocity is negative only between the ends: the reachable distances rise, fall and rise again
        (
            alone(
                at(-1.0, 4.0, -3.0),
                at(0.0, 0.0, 1.5),
                limits(4.0, 3.0, 1.0),
            ),
            4.815_000_374_573_841,
        ),
        // the brake takes longer than what the last unit of the whole time is worth
        (
            alone(
                at(
                    -1.190_514_024_752_945_3,
                    -5.415_111_020_989_247e-10,
                    0.552_074_970_632_837_3,
                ),
                at(-1.196_297_301_753_332_3, 0.0, 0.0),
                limits(
                    12.558_775_369_343_172,
                    0.528_421_844_574_778_6,
                    1.550_698_128_417_013_4,
                ),
            ),
            1.598_113_991_007_217,
        ),
    ] {
        let trajectory = Trajectory::new(&request).unwrap();
        assert_eq!(trajectory.check(&request), Ok(()));
        // Ruckig 0.19.4 takes as long
        assert!(
            (trajectory.duration() - expected).abs() <= 1e-9,
            "{}",
            trajectory.duration()
        );
    }
}
