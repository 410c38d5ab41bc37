//! Plans made by hand, each wrong in one way.

use super::*;

/// From rest to rest over 2 with v = a = j = 1: jerk +1, −1, −1, +1, a second each.
fn good() -> (Axis, Plan) {
    let axis = Axis {
        p1: 2.0,
        v_min: -1.0,
        v_max: 1.0,
        a_min: -1.0,
        a_max: 1.0,
        j_max: 1.0,
        ..Axis::default()
    };
    (
        axis,
        chain(&axis, &[(1.0, 1.0), (1.0, -1.0), (1.0, -1.0), (1.0, 1.0)]),
    )
}

/// A plan of phases (t, j), joined exactly.
fn chain(axis: &Axis, phases: &[(f64, f64)]) -> Plan {
    let mut state = State {
        p: axis.p0,
        v: axis.v0,
        a: axis.a0,
    };
    let phases: Vec<_> = phases
        .iter()
        .map(|(t, j)| {
            let phase = Phase {
                t: *t,
                j: *j,
                a0: state.a,
                v0: state.v,
                p0: state.p,
            };
            state = after(&phase, *t);
            phase
        })
        .collect();
    Plan {
        duration: phases.iter().map(|phase| phase.t).sum(),
        axes: vec![phases],
    }
}

fn names(axis: &Axis, plan: &Plan) -> Vec<&'static str> {
    let violations = judge(&[*axis], plan).violations();
    let all = Amounts::NAMES.into_iter().zip(violations);
    all.filter_map(|(name, found)| found.then_some(name))
        .collect()
}

#[test]
fn an_exact_plan_passes_with_nothing_to_say() {
    let (axis, plan) = good();
    // small integers and sixths of them: every number is exact, or off by one rounding
    assert!(
        judge(&[axis], &plan)
            .list()
            .iter()
            .all(|amount| *amount < 1e-15)
    );
}

#[test]
fn each_limit_is_judged_from_both_sides_of_the_tolerance() {
    let (axis, plan) = good();
    let narrowed = [
        (
            "jerk",
            (|x, k| Axis { j_max: k, ..x }) as fn(Axis, f64) -> Axis,
        ),
        ("acceleration", |x, k| Axis { a_max: k, ..x }),
        ("acceleration", |x, k| Axis { a_min: -k, ..x }),
        ("velocity", |x, k| Axis { v_max: k, ..x }),
    ];
    for (name, narrow) in narrowed {
        assert_eq!(
            names(&narrow(axis, 1.0 - 0.5 * TOLERANCE), &plan),
            [""; 0],
            "{name}"
        );
        assert_eq!(names(&narrow(axis, 1.0 - 2.0 * TOLERANCE), &plan), [name]);
    }
    // the lower limit of velocity: the same motion the other way round
    let back = Axis { p1: -2.0, ..axis };
    let plan = chain(&back, &[(1.0, -1.0), (1.0, 1.0), (1.0, 1.0), (1.0, -1.0)]);
    assert_eq!(names(&back, &plan), [""; 0]);
    assert_eq!(
        names(
            &Axis {
                v_min: -0.9,
                ..back
            },
            &plan
        ),
        ["velocity"]
    );
}

#[test]
fn a_velocity_beyond_its_limit_inside_a_phase_is_seen() {
    // one phase from a = 1 to a = −1: at its ends v = 0, at its middle v = 0.5
    let axis = Axis {
        a0: 1.0,
        p1: 2.0 / 3.0,
        a1: -1.0,
        ..good().0
    };
    let plan = chain(&axis, &[(2.0, -1.0)]);
    assert_eq!(names(&Axis { v_max: 0.5, ..axis }, &plan), [""; 0]);
    // 0.4 cannot be kept by any motion from there: not a violation, as 0.5 is the least possible
    assert_eq!(names(&Axis { v_max: 0.4, ..axis }, &plan), [""; 0]);
    // with a stronger jerk it could
    let strong = Axis {
        v_max: 0.4,
        j_max: 2.0,
        ..axis
    };
    assert_eq!(names(&strong, &plan), ["velocity"]);
}

#[test]
fn outside_at_the_start_is_no_violation_growing_is() {
    let start = Axis {
        v0: 2.0,
        a0: 1.0,
        a_max: 1.0,
        ..good().0
    };
    // straight to a = 0 and on to braking: the least velocity that can be reached is 2.5
    let brake = chain(&start, &[(1.0, -1.0), (1.0, -1.0), (1.0, 0.0), (1.0, 1.0)]);
    let end = after(&brake.axes[0][3], 1.0);
    let axis = Axis {
        p1: end.p,
        v1: end.v,
        a1: end.a,
        ..start
    };
    assert_eq!(names(&axis, &brake), [""; 0]);
    // dawdling: a tenth of a second more at a = 1
    let dawdle = chain(
        &start,
        &[(0.1, 0.0), (1.0, -1.0), (1.0, -1.0), (1.1, 0.0), (1.0, 1.0)],
    );
    let end = after(&dawdle.axes[0][4], 1.0);
    let axis = Axis {
        p1: end.p,
        v1: end.v,
        a1: end.a,
        ..start
    };
    assert_eq!(names(&axis, &dawdle), ["velocity"]);
    // inside for a moment, and outside again
    let phases = [
        (1.0, -1.0),
        (1.0, -1.0),
        (1.5, 0.0),
        (2.0, 1.0),
        (0.5, 0.0),
        (1.0, -1.0),
    ];
    let again = chain(&start, &phases);
    let end = after(&again.axes[0][5], 1.0);
    let axis = Axis {
        p1: end.p,
        v1: end.v,
        a1: end.a,
        ..start
    };
    assert!(end.v > axis.v_max);
    assert_eq!(names(&axis, &again), ["velocity"]);
}

#[test]
fn an_acceleration_outside_at_the_start_must_not_grow() {
    let start = Axis {
        a0: 2.0,
        v_max: 10.0,
        v_min: -10.0,
        ..good().0
    };
    let at_end = |plan: &Plan| {
        let last = plan.axes[0].last().unwrap();
        let end = after(last, last.t);
        Axis {
            p1: end.p,
            v1: end.v,
            a1: end.a,
            ..start
        }
    };
    let sinking = chain(&start, &[(1.0, -1.0), (1.0, 0.0)]);
    assert_eq!(names(&at_end(&sinking), &sinking), [""; 0]);
    let growing = chain(&start, &[(0.1, 1.0), (1.1, -1.0)]);
    assert_eq!(names(&at_end(&growing), &growing), ["acceleration"]);
    let again = chain(&start, &[(1.5, -1.0), (1.0, 1.0)]);
    assert_eq!(names(&at_end(&again), &again), ["acceleration"]);
}

#[test]
fn jumps_wrong_lengths_and_missed_ends_are_found() {
    let (axis, plan) = good();
    let mutated = |change: fn(&mut Plan)| {
        let mut plan = plan.clone();
        change(&mut plan);
        names(&axis, &plan)
    };
    assert_eq!(mutated(|plan| plan.axes[0][2].p0 += 1e-8), ["jump"]);
    assert_eq!(mutated(|plan| plan.axes[0][2].v0 -= 1e-8), ["jump"]);
    assert_eq!(mutated(|plan| plan.axes[0][0].a0 -= 1e-8), ["jump"]);
    assert_eq!(mutated(|plan| plan.axes[0][2].p0 += 1e-10), [""; 0]);
    assert_eq!(mutated(|plan| plan.duration += 1e-8), ["duration"]);
    assert_eq!(mutated(|plan| plan.duration += 1e-10), [""; 0]);
    for shifted in [
        Axis {
            p1: 2.0 + 2.0 * MISSED,
            ..axis
        },
        Axis {
            v1: 2.0 * MISSED,
            ..axis
        },
        Axis {
            a1: -2.0 * MISSED,
            ..axis
        },
    ] {
        assert_eq!(names(&shifted, &plan).len(), 1);
    }
    let near = Axis {
        p1: 2.0 + 0.5 * MISSED,
        ..axis
    };
    assert_eq!(names(&near, &plan), [""; 0]);
    let end = judge(&[near], &plan).end();
    assert!((end - 0.5 * MISSED).abs() < 1e-15, "{end}");
}

#[test]
fn what_is_no_motion_is_malformed() {
    let (axis, plan) = good();
    for bad in [f64::NAN, f64::INFINITY, -1.0] {
        let mut plan = plan.clone();
        plan.axes[0][1].t = bad;
        assert!(names(&axis, &plan).contains(&"malformed"), "{bad}");
    }
    let mut endless = plan.clone();
    endless.duration = f64::NAN;
    assert!(names(&axis, &endless).contains(&"malformed"));
    assert!(!judge(&[axis, axis], &plan).pass());
    let nothing = Plan {
        duration: 0.0,
        axes: vec![vec![]],
    };
    assert_eq!(names(&axis, &nothing), ["end position"]);
}
