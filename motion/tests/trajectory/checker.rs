//! The judge is judged: whatever is changed in a good motion is found.
use super::cases::{alone, at, from_anywhere, symmetric};
use motion::profile::{AxisBounds, Phase, Request, Trajectory, Violation, check};
use proptest::prelude::*;

fn judge(phases: &[Phase], request: &Request<1>, bounds: &AxisBounds) -> Result<(), Violation> {
    check(phases, &request.start[0], &request.end[0], bounds)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    #[test]
    fn a_change_of_any_field_of_any_phase_is_found(request in from_anywhere(-0.5, 0.5), up in any::<bool>()) {
        let bounds = request.bounds[0];
        let good = Trajectory::new(&request).unwrap().phases(0).to_vec();
        prop_assert_eq!(judge(&good, &request, &bounds), Ok(()));
        // far above what counts as rounding (1e-12 of lengths up to 1e3), far below what matters
        let change = if up { 1e-6 } else { -1e-6 };
        for i in 0..good.len() {
            for field in 0..5 {
                let mut bad = good.clone();
                let phase = &mut bad[i];
                match field {
                    0 => phase.p0 += change,
                    1 => phase.v0 += change,
                    2 => phase.a0 += change,
                    // what lasts less, or changes nothing while it lasts, is not to be found
                    3 if phase.t > 1e-2 => phase.j += change,
                    4 if phase.j.abs() > 1e-2 || phase.a0.abs() > 1e-2 || phase.v0.abs() > 1e-2 => {
                        phase.t += change;
                    }
                    _ => continue,
                }
                prop_assert!(judge(&bad, &request, &bounds).is_err(), "{i} {field} {:?}", good[i]);
            }
        }
    }

    #[test]
    fn narrower_bounds_are_found_to_be_broken(request in from_anywhere(-0.5, 0.5)) {
        let bounds = request.bounds[0];
        let phases = Trajectory::new(&request).unwrap().phases(0).to_vec();
        let most = |of: fn(&Phase) -> [f64; 2]| {
            phases.iter().flat_map(of).fold(f64::NEG_INFINITY, |m, x| if x > m { x } else { m })
        };
        let jerk = most(|p| [p.j.abs(); 2]);
        if jerk > 0.0 {
            let tight = AxisBounds { j_max: jerk * (1.0 - 1e-9), ..bounds };
            let found = judge(&phases, &request, &tight);
            prop_assert!(matches!(found, Err(Violation::Jerk { .. })), "{found:?}");
        }
        // below the position of an end or a beginning of a phase
        let highest = most(|p| [p.p0, p.at(p.t).p]);
        if highest.is_finite() {
            let tight = AxisBounds { p_max: highest - 1e-6, ..bounds };
            let found = judge(&phases, &request, &tight);
            prop_assert!(matches!(found, Err(Violation::Position { .. })), "{found:?}");
        }
    }
}

fn phase(t: f64, j: f64, a0: f64, v0: f64, p0: f64) -> Phase {
    Phase { t, j, a0, v0, p0 }
}

/// The phases that these jerks make, from the start of a request.
fn chain(request: &Request<1>, jerks: &[(f64, f64)]) -> Vec<Phase> {
    let [start] = request.start;
    let mut state = (start.p, start.v, start.a);
    jerks
        .iter()
        .map(|(t, j)| {
            let made = phase(*t, *j, state.2, state.1, state.0);
            let end = made.at(*t);
            state = (end.p, end.v, end.a);
            made
        })
        .collect()
}

#[test]
fn each_kind_of_fault_is_named() {
    let unit = symmetric(1.0, 1.0, 1.0);
    let request = alone(at(0.0, 0.0, 0.0), at(4.0, 0.0, 0.0), unit);
    let good = Trajectory::new(&request).unwrap().phases(0).to_vec();
    // 1 s of jerk, 1 s back, 2 s at full speed, and the same down
    assert_eq!(good.len(), 5);
    let broken = |edit: &dyn Fn(&mut Vec<Phase>)| {
        let mut phases = good.clone();
        edit(&mut phases);
        judge(&phases, &request, &unit)
    };
    assert!(matches!(
        broken(&|p| p[0].j = 1.001),
        Err(Violation::Jerk { phase: 0, .. })
    ));
    assert!(matches!(
        broken(&|p| p[1].a0 = 1.001),
        Err(Violation::Acceleration { phase: 1, .. })
    ));
    assert!(matches!(
        broken(&|p| p[2].v0 = 1.001),
        Err(Violation::Velocity { phase: 2, .. })
    ));
    assert_eq!(
        broken(&|p| p[2].p0 += 1e-9),
        Err(Violation::Jump { phase: 2 })
    );
    assert_eq!(
        broken(&|p| p[2].t = -1.0),
        Err(Violation::Malformed { phase: 2 })
    );
    assert_eq!(
        broken(&|p| p[4].j = f64::NAN),
        Err(Violation::Malformed { phase: 4 })
    );
    assert_eq!(
        broken(&|p| p[3].t = f64::INFINITY),
        Err(Violation::Malformed { phase: 3 })
    );
    assert_eq!(broken(&|p| p.truncate(4)), Err(Violation::End));
    assert_eq!(
        broken(&|p| p.rotate_left(1)),
        Err(Violation::Jump { phase: 0 })
    );
    assert_eq!(judge(&[], &request, &unit), Err(Violation::End));
    let narrow = AxisBounds { p_max: 3.9, ..unit };
    assert!(matches!(
        judge(&good, &request, &narrow),
        Err(Violation::Position { .. })
    ));
    let nothing = AxisBounds {
        v_max: f64::NAN,
        ..unit
    };
    assert!(judge(&good, &request, &nothing).is_err());
}

#[test]
fn a_turn_hidden_inside_a_phase_is_found() {
    // ends at the position and velocity mirrored; in between it is 1/2 further
    let request = alone(
        at(0.0, 1.0, -1.0),
        at(0.0, -1.0, -1.0),
        symmetric(2.0, 2.0, 1.0),
    );
    let phases = chain(&request, &[(2.0, 0.0)]);
    let bounds = request.bounds[0];
    assert_eq!(judge(&phases, &request, &bounds), Ok(()));
    let narrow = AxisBounds {
        p_max: 0.49,
        ..bounds
    };
    assert!(matches!(
        judge(&phases, &request, &narrow),
        Err(Violation::Position { phase: 0, .. })
    ));
    let wide = AxisBounds {
        p_max: 0.51,
        ..bounds
    };
    assert_eq!(judge(&phases, &request, &wide), Ok(()));
}

#[test]
fn from_outside_the_limits_no_more_is_allowed_than_cannot_be_avoided() {
    let unit = symmetric(1.0, 1.0, 1.0);
    let fast = alone(at(0.0, 2.0, 0.0), at(1.0, 0.0, 0.0), unit);
    let good = Trajectory::new(&fast).unwrap();
    assert_eq!(good.check(&fast), Ok(()));
    // faster still before it slows down
    let worse = chain(&fast, &[(0.1, 1.0), (1.1, -1.0)]);
    let found = judge(&worse, &fast, &unit);
    assert!(
        matches!(found, Err(Violation::Velocity { phase: 0, .. })),
        "{found:?}"
    );
    // down a little and up again: no more than at the start, but more than has been reached
    let again = chain(&fast, &[(0.5, -1.0), (1.0, 1.0), (0.4, -1.0)]);
    let found = judge(&again, &fast, &unit);
    assert!(
        matches!(found, Err(Violation::Velocity { phase: 2, .. })),
        "{found:?}"
    );
    // once inside, the limits hold
    let back = chain(
        &fast,
        &[(1.0, -1.0), (1.0, 0.0), (1.0, 1.0), (1.0, 1.0), (1.0, 0.0)],
    );
    let found = judge(&back, &fast, &unit);
    assert!(
        matches!(found, Err(Violation::Velocity { .. })),
        "{found:?}"
    );
    // the same of acceleration
    let hard = alone(
        at(0.0, 0.0, 2.0),
        at(1.0, 0.0, 0.0),
        symmetric(9.0, 1.0, 1.0),
    );
    let worse = chain(&hard, &[(0.1, 1.0)]);
    let found = judge(&worse, &hard, &hard.bounds[0]);
    assert!(
        matches!(found, Err(Violation::Acceleration { phase: 0, .. })),
        "{found:?}"
    );
}
