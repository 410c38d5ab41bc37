//! Senseless requests: an error that names the axis, or an answer that passes the checker; never a panic.
use super::cases::{alone, at, symmetric};
use motion::profile::{
    AxisBounds, Boundary, ProfileError, Request, Synchronisation, Trajectory, TrajectoryError,
};
use proptest::prelude::*;

fn number() -> impl Strategy<Value = f64> {
    // any bits, and magnitudes at which squares and cubes over- and underflow
    prop_oneof![
        any::<u64>().prop_map(f64::from_bits),
        any::<f64>(),
        (-310.0..308.0f64, any::<bool>()).prop_map(|(e, up)| if up {
            libm::exp10(e)
        } else {
            -libm::exp10(e)
        }),
        Just(0.0),
        Just(f64::MAX),
        Just(f64::MIN_POSITIVE),
        Just(5e-324),
    ]
}

fn boundary() -> impl Strategy<Value = Boundary> {
    (number(), number(), number()).prop_map(|(p, v, a)| at(p, v, a))
}

fn bounds() -> impl Strategy<Value = AxisBounds> {
    let limit = || number().prop_map(f64::abs);
    (
        (limit(), limit(), limit(), limit()),
        limit(),
        number(),
        number(),
        any::<bool>(),
    )
        .prop_map(
            |((v_min, v_max, a_min, a_max), j_max, p_min, p_max, ranged)| AxisBounds {
                v_min: -v_min,
                v_max,
                a_min: -a_min,
                a_max,
                j_max,
                p_min: if ranged { p_min } else { f64::NEG_INFINITY },
                p_max: if ranged { p_max } else { f64::INFINITY },
            },
        )
}

fn request() -> impl Strategy<Value = Request<2>> {
    let two = |s| prop::array::uniform2(s);
    let ways = prop::sample::select(vec![
        Synchronisation::None,
        Synchronisation::Time,
        Synchronisation::Phase,
    ]);
    let least = prop_oneof![Just(0.0), number()];
    (
        two(boundary().boxed()),
        two(boundary().boxed()),
        prop::array::uniform2(bounds()),
        ways,
        least,
    )
        .prop_map(
            |(start, end, bounds, synchronisation, minimum_duration)| Request {
                start,
                end,
                bounds,
                synchronisation,
                minimum_duration,
            },
        )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(5000))]

    #[test]
    fn whatever_is_asked_the_answer_is_finite_or_an_error(request in request(), u in -0.5..1.5f64) {
        let mut trajectory = Trajectory::empty();
        for velocity in [false, true] {
            let planned = if velocity { trajectory.plan_velocity(&request) } else { trajectory.plan(&request) };
            match planned {
                Ok(()) => {
                    prop_assert!(trajectory.duration().is_finite() && trajectory.duration() >= 0.0);
                    let _ = trajectory.check(&request);
                    let _ = trajectory.at(u * trajectory.duration());
                }
                Err(error) => {
                    prop_assert!(!error.to_string().is_empty());
                    prop_assert!(trajectory.duration() <= 0.0 && trajectory.phases(0).is_empty());
                }
            }
        }
    }

    #[test]
    fn at_rest_any_distance_and_any_limits_are_planned_or_refused(d in number(), v in number(), a in number(), j in number()) {
        let request = alone(Boundary::default(), at(d, 0.0, 0.0), symmetric(v, a, j));
        if let Ok(trajectory) = Trajectory::new(&request) {
            prop_assert!(trajectory.duration().is_finite());
        }
    }
}

const UNIT: AxisBounds = AxisBounds {
    v_min: -1.0,
    v_max: 1.0,
    a_min: -1.0,
    a_max: 1.0,
    j_max: 1.0,
    p_min: f64::NEG_INFINITY,
    p_max: f64::INFINITY,
};

fn refusal(edit: impl Fn(&mut Request<2>)) -> (Option<usize>, ProfileError) {
    let mut request = Request {
        start: [Boundary::default(); 2],
        end: [at(1.0, 0.0, 0.0); 2],
        bounds: [UNIT; 2],
        synchronisation: Synchronisation::Time,
        minimum_duration: 0.0,
    };
    assert_eq!(
        Trajectory::new(&request).map(|t| t.check(&request)),
        Ok(Ok(()))
    );
    edit(&mut request);
    let TrajectoryError { axis, reason } = Trajectory::new(&request).unwrap_err();
    (axis, reason)
}

#[test]
fn refusals_name_axis_and_reason() {
    use ProfileError::{EndOutsideLimits, NonPositiveLimit, NotFinite, OutsideRange};
    let (nan, infinity) = (f64::NAN, f64::INFINITY);
    for bad in [nan, infinity, -infinity] {
        assert_eq!(refusal(|r| r.start[0].p = bad), (Some(0), NotFinite));
        assert_eq!(refusal(|r| r.start[1].v = bad), (Some(1), NotFinite));
        assert_eq!(refusal(|r| r.start[1].a = bad), (Some(1), NotFinite));
        assert_eq!(refusal(|r| r.end[0].p = bad), (Some(0), NotFinite));
        assert_eq!(refusal(|r| r.end[1].v = bad), (Some(1), NotFinite));
        assert_eq!(refusal(|r| r.end[0].a = bad), (Some(0), NotFinite));
        assert_eq!(refusal(|r| r.bounds[1].v_max = bad), (Some(1), NotFinite));
        assert_eq!(refusal(|r| r.bounds[1].a_min = bad), (Some(1), NotFinite));
        assert_eq!(refusal(|r| r.bounds[0].j_max = bad), (Some(0), NotFinite));
        assert_eq!(refusal(|r| r.minimum_duration = bad), (None, NotFinite));
    }
    assert_eq!(refusal(|r| r.bounds[0].p_min = nan), (Some(0), NotFinite));
    assert_eq!(refusal(|r| r.bounds[0].p_max = nan), (Some(0), NotFinite));
    assert_eq!(refusal(|r| r.minimum_duration = -1e-9), (None, NotFinite));
    for bad in [0.0, -1.0, -0.0] {
        assert_eq!(
            refusal(|r| r.bounds[1].v_max = bad),
            (Some(1), NonPositiveLimit)
        );
        assert_eq!(
            refusal(|r| r.bounds[1].v_min = -bad),
            (Some(1), NonPositiveLimit)
        );
        assert_eq!(
            refusal(|r| r.bounds[0].a_max = bad),
            (Some(0), NonPositiveLimit)
        );
        assert_eq!(
            refusal(|r| r.bounds[0].a_min = -bad),
            (Some(0), NonPositiveLimit)
        );
        assert_eq!(
            refusal(|r| r.bounds[1].j_max = bad),
            (Some(1), NonPositiveLimit)
        );
    }
    assert_eq!(refusal(|r| r.end[1].v = 1.001), (Some(1), EndOutsideLimits));
    assert_eq!(
        refusal(|r| r.end[1].a = -1.001),
        (Some(1), EndOutsideLimits)
    );
    // inside both limits, but the velocity was above its own before: 0.6 + 1²/2
    assert_eq!(
        refusal(|r| r.end[0] = at(1.0, 0.6, -1.0)),
        (Some(0), EndOutsideLimits)
    );
    assert_eq!(
        refusal(|r| r.bounds[0].p_max = 0.5),
        (Some(0), OutsideRange)
    );
    assert_eq!(
        refusal(|r| r.bounds[0].p_min = 0.5),
        (Some(0), OutsideRange)
    );
}
