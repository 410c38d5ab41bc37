//! Profiles from rest to rest: optimal, within limits, exact at the end, and typed when refused.
use motion::profile::{
    AxisLimits, Boundary, Phase, PhaseSynchronised, Profile, ProfileError, Violation,
};
use proptest::prelude::*;

/// The minimum time in closed form, written independently of the crate.
fn shortest(d: f64, l: &AxisLimits) -> f64 {
    let AxisLimits { v, a, j } = *l;
    let ramp = if a * a / j > v {
        2.0 * libm::sqrt(v / j)
    } else {
        a / j + v / a
    };
    if d >= v * ramp {
        return ramp + d / v;
    }
    let tj = a / j;
    if d >= 2.0 * a * tj * tj {
        tj + libm::sqrt(tj * tj + 4.0 * d / a)
    } else {
        4.0 * libm::cbrt(d / (2.0 * j))
    }
}

/// A value of any magnitude between 10^lo and 10^hi.
fn magnitude(lo: f64, hi: f64) -> impl Strategy<Value = f64> {
    (lo..hi).prop_map(libm::exp10)
}

fn limits(lo: f64, hi: f64) -> impl Strategy<Value = AxisLimits> {
    (magnitude(lo, hi), magnitude(lo, hi), magnitude(lo, hi)).prop_map(|(v, a, j)| AxisLimits {
        v,
        a,
        j,
    })
}

fn close(x: f64, y: f64, relative: f64) -> bool {
    (x - y).abs() <= relative * x.abs().max_of(y.abs())
}

/// From rest at 0 to rest at d.
fn check(phases: &[Phase], d: f64, limits: &AxisLimits) -> Result<(), Violation> {
    let end = Boundary {
        p: d,
        ..Boundary::default()
    };
    motion::profile::check(phases, &Boundary::default(), &end, &(*limits).into())
}

trait MaxOf {
    fn max_of(self, other: Self) -> Self;
}
impl MaxOf for f64 {
    fn max_of(self, other: Self) -> Self {
        if other > self { other } else { self }
    }
}

proptest! {
    #[test]
    fn one_axis_is_optimal_and_passes_the_checker(d in magnitude(-12.0, 6.0), l in limits(-3.0, 9.0)) {
        let profile = Profile::new(d, &l).unwrap();
        prop_assert!(close(profile.duration(), shortest(d, &l), 1e-12));
        prop_assert_eq!(check(&profile.phases(), d, &l), Ok(()));
        prop_assert_eq!(profile.at(profile.duration()).p.to_bits(), d.to_bits());
        prop_assert_eq!(profile.at(-1.0).p.to_bits(), 0.0f64.to_bits());
    }

    #[test]
    fn samples_obey_the_limits_to_the_last_bit(d in magnitude(-9.0, 4.0), l in limits(-2.0, 4.0), n in 1..200u32) {
        let profile = Profile::new(d, &l).unwrap();
        let mut before = 0.0;
        for i in 0..=n {
            let s = profile.at(profile.duration() * f64::from(i) / f64::from(n));
            prop_assert!(s.v >= 0.0 && s.v <= l.v && s.a.abs() <= l.a && s.j.abs() <= l.j, "{s:?}");
            prop_assert!(s.p >= before - 1e-15 * d && s.p <= d * (1.0 + 1e-15));
            before = s.p;
        }
    }

    #[test]
    fn samples_agree_with_the_phases(d in magnitude(-9.0, 4.0), l in limits(-2.0, 4.0), u in 0.0..1.0f64) {
        let profile = Profile::new(d, &l).unwrap();
        let t = u * profile.duration();
        let (mut begin, mut expected) = (0.0, None);
        for phase in profile.phases() {
            if expected.is_none() && t <= begin + phase.t {
                expected = Some(phase.at(t - begin));
            }
            begin += phase.t;
        }
        if let Some(e) = expected {
            let s = profile.at(t);
            prop_assert!((s.p - e.p).abs() <= 1e-12 * d);
            prop_assert!((s.v - e.v).abs() <= 1e-11 * l.v);
        }
    }

    #[test]
    fn phase_synchronised_axes_stay_on_the_line(
        start in prop::array::uniform7(-4.0..4.0f64), end in prop::array::uniform7(-4.0..4.0f64),
        l in prop::array::uniform7(limits(-2.0, 3.0)), u in 0.0..1.0f64,
    ) {
        let plan = PhaseSynchronised::new(start, end, &l).unwrap();
        prop_assert_eq!(plan.check(&l), Ok(()));
        let states = plan.at(u * plan.duration());
        let share = (states[0].p - start[0]) / (end[0] - start[0]);
        for (i, s) in states.iter().enumerate() {
            prop_assert!((s.p - (start[i] + share * (end[i] - start[i]))).abs() < 1e-12 / (end[0] - start[0]).abs());
            prop_assert!(s.v.abs() <= l[i].v && s.a.abs() <= l[i].a && s.j.abs() <= l[i].j);
        }
        // no axis could do it faster alone than all together do
        let alone = (0..7).fold(0.0, |m: f64, i| m.max_of(shortest((end[i] - start[i]).abs(), &l[i])));
        prop_assert!(plan.duration() >= alone * (1.0 - 1e-12));
        prop_assert!(plan.at(plan.duration()).iter().zip(&end).all(|(s, e)| s.p.to_bits() == e.to_bits()));
    }

    #[test]
    fn whatever_is_asked_the_answer_is_a_number_or_an_error(
        d in any::<f64>(), v in any::<f64>(), a in any::<f64>(), j in any::<f64>(), u in -0.5..1.5f64,
    ) {
        if let Ok(profile) = Profile::new(d, &AxisLimits { v, a, j }) {
            let s = profile.at(u * profile.duration());
            prop_assert!(profile.duration().is_finite());
            prop_assert!(s.p.is_finite() && s.v.is_finite() && s.a.is_finite() && s.j.is_finite());
        }
    }
}

const UNIT: AxisLimits = AxisLimits {
    v: 1.0,
    a: 1.0,
    j: 1.0,
};

#[test]
fn refusals_are_typed() {
    assert_eq!(Profile::new(f64::NAN, &UNIT), Err(ProfileError::NotFinite));
    assert_eq!(
        Profile::new(-1.0, &UNIT),
        Err(ProfileError::NegativeDistance)
    );
    let still = AxisLimits { v: 0.0, ..UNIT };
    assert_eq!(
        Profile::new(1.0, &still),
        Err(ProfileError::NonPositiveLimit)
    );
    let endless = AxisLimits {
        j: f64::INFINITY,
        ..UNIT
    };
    assert_eq!(Profile::new(1.0, &endless), Err(ProfileError::NotFinite));
    assert_eq!(
        Profile::new(1e308, &AxisLimits { v: 1e-308, ..UNIT }),
        Err(ProfileError::NotRepresentable)
    );
    assert_eq!(
        PhaseSynchronised::new([0.0, f64::MAX], [1.0, f64::MIN], &[UNIT; 2]),
        Err(ProfileError::NotFinite)
    );
}

#[test]
fn no_distance_takes_no_time() {
    let profile = Profile::new(0.0, &UNIT).unwrap();
    assert!(profile.duration() == 0.0 && profile.at(0.0).p == 0.0);
    assert_eq!(check(&profile.phases(), 0.0, &UNIT), Ok(()));
    let plan = PhaseSynchronised::new([2.0; 3], [2.0; 3], &[UNIT; 3]).unwrap();
    assert!(
        plan.duration() == 0.0
            && plan
                .at(0.0)
                .iter()
                .all(|s| s.p.to_bits() == 2.0f64.to_bits())
    );
}

#[test]
fn known_durations() {
    // all seven phases, six (no cruise), four (no constant acceleration), and the two borders
    for (d, l, expected) in [
        (
            1.0,
            AxisLimits {
                v: 0.5,
                a: 1.0,
                j: 10.0,
            },
            2.6,
        ),
        (
            2.0,
            AxisLimits {
                v: 9.0,
                a: 1.0,
                j: 1.0,
            },
            4.0,
        ),
        (
            6.0,
            AxisLimits {
                v: 9.0,
                a: 1.0,
                j: 1.0,
            },
            6.0,
        ),
        (
            2.0,
            AxisLimits {
                v: 9.0,
                a: 9.0,
                j: 1.0,
            },
            4.0,
        ),
        (2.0, UNIT, 4.0),
    ] {
        let t = Profile::new(d, &l).unwrap().duration();
        assert!((t - expected).abs() < 1e-14, "{d} {l:?} {t}");
    }
}

/// The judge is judged: every kind of broken profile is found.
#[test]
fn the_checker_finds_each_kind_of_fault() {
    let good = Profile::new(3.0, &UNIT).unwrap().phases();
    let broken = |edit: &dyn Fn(&mut [Phase; 7])| {
        let mut phases = good;
        edit(&mut phases);
        check(&phases, 3.0, &UNIT)
    };
    assert_eq!(check(&good, 3.0, &UNIT), Ok(()));
    assert_eq!(check(&good, 3.0 + 1e-9, &UNIT), Err(Violation::End));
    assert!(matches!(
        broken(&|p| p[0].j = 1.1),
        Err(Violation::Jerk { phase: 0, .. })
    ));
    assert!(matches!(
        broken(&|p| p[1].a0 = 1.1),
        Err(Violation::Acceleration { phase: 1, .. })
    ));
    assert!(matches!(
        broken(&|p| p[3].v0 = 1.1),
        Err(Violation::Velocity { phase: 3, .. })
    ));
    assert_eq!(
        broken(&|p| p[3].p0 += 1e-9),
        Err(Violation::Jump { phase: 3 })
    );
    assert_eq!(
        broken(&|p| p[4].t = -1.0),
        Err(Violation::Malformed { phase: 4 })
    );
    assert_eq!(
        broken(&|p| p[4].p0 = f64::NAN),
        Err(Violation::Malformed { phase: 4 })
    );
    // a velocity peak hidden between the ends of one phase
    let hidden = [Phase {
        t: 4.0,
        j: -1.0,
        a0: 2.0,
        v0: 0.0,
        p0: 0.0,
    }];
    let wide = AxisLimits {
        v: 1.5,
        a: 9.0,
        j: 9.0,
    };
    assert!(matches!(
        check(&hidden, 0.0, &wide),
        Err(Violation::Velocity { .. })
    ));
}
