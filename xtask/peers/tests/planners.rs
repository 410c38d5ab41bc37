//! The planners, as they are asked here: an answer known by formula, bad questions, and that what is
//! timed and sampled is what is judged.

use peers::apart::Apart;
use peers::case::{Axis, Case};
use peers::class::Class;
use peers::judge::judge;
use peers::plan::{Batch, Outcome, Phase, Plan};
use peers::planner::Planner;

fn plan(batch: &mut dyn Batch, index: usize) -> Plan {
    match batch.plan(index) {
        Outcome::Planned(plan) => plan,
        other => panic!("{other:?}"),
    }
}

/// The shortest time from rest to rest over a distance, with limits that are the same both ways.
fn rest_to_rest(distance: f64, v: f64, a: f64, j: f64) -> f64 {
    let ramp = if a * a / j > v {
        2.0 * libm::sqrt(v / j)
    } else {
        a / j + v / a
    };
    let tj = a / j;
    if distance >= v * ramp {
        ramp + distance / v
    } else if distance >= 2.0 * a * tj * tj {
        tj + libm::sqrt(tj * tj + 4.0 * distance / a)
    } else {
        4.0 * libm::cbrt(distance / (2.0 * j))
    }
}

#[test]
fn every_planner_needs_the_time_of_the_formula_from_rest_to_rest() {
    let symmetric = (0..400).filter(|index| index % 4 != 3);
    let cases: Vec<Case<1>> = symmetric.map(|index| Class::R.case(3, index)).collect();
    for planner in Planner::ALL {
        let mut batch = planner.batch(&cases);
        for (index, [x]) in cases.iter().enumerate() {
            let wanted = rest_to_rest((x.p1 - x.p0).abs(), x.v_max, x.a_max, x.j_max);
            let got = plan(batch.as_mut(), index).duration;
            // a few hundred roundings of numbers of this size
            assert!(
                (got - wanted).abs() <= 1e-12 * wanted,
                "{planner} {index}: {got} {wanted}"
            );
        }
    }
}

#[test]
fn no_planner_plans_from_or_to_what_is_not_a_number() {
    let good = Class::S.case::<1>(1, 0)[0];
    let bad = [
        Axis {
            p0: f64::NAN,
            ..good
        },
        Axis {
            v0: f64::NAN,
            ..good
        },
        Axis {
            a0: f64::NAN,
            ..good
        },
        Axis {
            p1: f64::NAN,
            ..good
        },
        Axis {
            v1: f64::NAN,
            ..good
        },
        Axis {
            a1: f64::NAN,
            ..good
        },
        Axis {
            v_max: f64::NAN,
            ..good
        },
        Axis {
            a_max: f64::NAN,
            ..good
        },
        Axis {
            j_max: f64::NAN,
            ..good
        },
        Axis {
            v_min: f64::NAN,
            ..good
        },
        Axis {
            a_min: f64::NAN,
            ..good
        },
        Axis {
            v_max: -1.0,
            ..good
        },
        Axis {
            a_max: -1.0,
            ..good
        },
        Axis {
            j_max: -1.0,
            ..good
        },
    ];
    let cases = bad.map(|axis| [axis]);
    for planner in Planner::ALL {
        let mut batch = planner.batch(&cases);
        for (index, case) in cases.iter().enumerate() {
            let outcome = batch.plan(index);
            assert!(
                matches!(outcome, Outcome::Refused(_)),
                "{planner} {case:?}: {outcome:?}"
            );
        }
    }
}

#[test]
fn an_end_outside_its_limits_is_refused_by_all() {
    let good = Axis {
        v1: 0.0,
        a1: 0.0,
        ..Class::S.case::<1>(1, 0)[0]
    };
    let cases = [
        [Axis {
            v1: 2.0 * good.v_max,
            ..good
        }],
        [Axis {
            a1: 2.0 * good.a_min,
            ..good
        }],
        [Axis {
            v1: good.v_max,
            a1: 0.5 * good.a_min,
            ..good
        }],
    ];
    assert!(cases.iter().all(|[axis]| !axis.has_valid_end()));
    for planner in Planner::ALL {
        let mut batch = planner.batch(&cases);
        for index in 0..cases.len() {
            assert!(
                matches!(batch.plan(index), Outcome::Refused(_)),
                "{planner} {index}"
            );
        }
    }
}

#[test]
fn what_is_timed_is_what_is_judged() {
    for class in [Class::R, Class::T, Class::S] {
        let cases: Vec<Case<3>> = (0..100).map(|index| class.case(1, index)).collect();
        for planner in Planner::ALL {
            let mut batch = planner.batch(&cases);
            let plans: Vec<_> = (0..cases.len())
                .map(|at| plan(batch.as_mut(), at))
                .collect();
            for (case, plan) in cases.iter().zip(&plans) {
                let amounts = judge(case, plan);
                assert!(amounts.pass(), "{class} {planner}: {amounts:?}");
            }
            let sum: f64 = plans.iter().map(|plan| plan.duration).sum();
            assert_eq!(batch.run().to_bits(), sum.to_bits(), "{class} {planner}");
            let mut least = vec![f64::INFINITY; cases.len()];
            batch.calls(&mut least);
            assert!(least.iter().all(|ns| ns.is_finite() && *ns > 0.0));
        }
    }
}

/// The sum of position, velocity, acceleration and jerk of one axis at a time.
fn state_sum(phases: &[Phase], t: f64) -> f64 {
    let mut left = t;
    for phase in phases {
        if left < phase.t {
            let p = phase.p0 + left * (phase.v0 + left * (0.5 * phase.a0 + left * phase.j / 6.0));
            let v = phase.v0 + left * (phase.a0 + 0.5 * left * phase.j);
            return p + v + (phase.a0 + left * phase.j) + phase.j;
        }
        left -= phase.t;
    }
    panic!("{t} is after the end")
}

#[test]
fn what_is_sampled_is_what_is_judged() {
    const SAMPLES: u32 = 97;
    let cases: Vec<Case<3>> = (0..50).map(|index| Class::T.case(2, index)).collect();
    for planner in Planner::ALL {
        let mut batch = planner.batch(&cases);
        let mut sum = 0.0;
        for at in 0..cases.len() {
            let plan = plan(batch.as_mut(), at);
            for i in 0..SAMPLES {
                let t = f64::from(i) * (plan.duration / f64::from(SAMPLES));
                sum += plan.axes.iter().map(|axis| state_sum(axis, t)).sum::<f64>();
            }
        }
        batch.keep();
        let sampled = batch.sample(SAMPLES as usize);
        // 15 000 states of size 10, each rounded a few times; a time on the edge of a phase could
        // choose the other jerk, which these cases do not
        assert!((sampled - sum).abs() < 1e-8, "{planner}: {sampled} {sum}");
    }
}

#[test]
fn a_crash_of_ruckig_costs_one_case_and_no_other() {
    // in version 0.19.4 case 53866 may kill it
    let range = 53_860..53_872;
    let program = std::path::Path::new(env!("CARGO_BIN_EXE_compare"));
    let mut apart = Apart::new(program, Class::E, 1, 7, range.clone());
    for index in range {
        let outcome = apart.ask_next().unwrap();
        if index == 53_866 {
            continue;
        }
        let alone = Planner::Ruckig
            .batch(&[Class::E.case::<7>(1, index)])
            .plan(0);
        assert_eq!(outcome, alone, "{index}");
    }
}

#[test]
fn a_process_that_says_nothing_is_an_error_and_no_outcome() {
    let nobody = std::path::Path::new("no such program");
    assert!(Apart::new(nobody, Class::R, 1, 1, 0..2).ask_next().is_err());
    // not a class for which anything is planned: it ends by itself
    let program = std::path::Path::new(env!("CARGO_BIN_EXE_oracle"));
    let error = Apart::new(program, Class::R, 1, 5, 0..2)
        .ask_next()
        .unwrap_err();
    assert!(
        error.to_string().contains("Ruckig's own process"),
        "{error}"
    );
}
