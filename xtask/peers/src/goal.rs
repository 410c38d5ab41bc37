//! The goals, and whether they are met by what was measured.

use crate::class::Class;
use crate::planner::Planner;
use crate::report::Report;
use crate::tally::{END_GOAL, Tally};
use crate::timing::Cost;

/// The axes for which the goals of cost are set.
pub const AXES: usize = 7;
/// A plan of ours costs at most this share of Ruckig's, time and instructions: G1, G2, G3.
const SHARES: [(&str, Class, f64); 3] = [
    ("G1", Class::R, 0.35),
    ("G2", Class::T, 0.6),
    ("G3", Class::S, 0.8),
];
/// The worst call of ours costs at most this many times the median.
const WORST: f64 = 2.0;
/// A sample of ours costs at most this share of Ruckig's.
const SAMPLE: f64 = 0.8;

/// A goal beside what was got.
#[derive(Clone, Debug, PartialEq)]
pub struct Goal {
    /// Its name.
    pub name: &'static str,
    /// What is wanted.
    pub wanted: String,
    /// What was got; nothing if it was not measured.
    pub got: Option<String>,
    /// Whether it is met; not if it was not measured.
    pub met: bool,
}

/// All goals.
#[must_use]
pub fn goals(report: &Report) -> Vec<Goal> {
    let mut goals: Vec<Goal> = SHARES
        .iter()
        .map(|(name, class, share)| cost(name, *class, *share, report))
        .collect();
    goals.extend([quality(report), worst(report), sample(report)]);
    goals
}

fn cost(name: &'static str, class: Class, share: f64, report: &Report) -> Goal {
    let wanted = format!("{}: at most {share} of Ruckig", class.title());
    let Some(costs) = report.cost(class, AXES) else {
        return not_measured(name, wanted);
    };
    let (own, theirs) = (of(costs, Planner::Ours), of(costs, Planner::Ruckig));
    let time = own.ns / theirs.ns;
    let counted = own.instructions.zip(theirs.instructions);
    let (met, work) = match counted.map(|(own, theirs)| own / theirs) {
        Some(work) => (work <= share, format!("{work:.3} instructions")),
        None => (true, "instructions not counted".into()),
    };
    Goal {
        name,
        wanted,
        got: Some(format!("{time:.3} time, {work}")),
        met: met && time <= share,
    }
}

fn quality(report: &Report) -> Goal {
    let wanted =
        format!("no error, no violation, never longer than Ruckig, end within {END_GOAL:.0e}");
    if report.classes.is_empty() {
        return not_measured("G4", wanted);
    }
    let sum = |of: fn(&Tally) -> u64| -> u64 {
        let own = report.classes.iter().map(|(_, t)| of(t.of(Planner::Ours)));
        own.sum()
    };
    let counts = [
        (sum(Tally::error_count), "errors"),
        (sum(|t| t.faulty.count), "violations"),
        (sum(|t| t.against.longer.count), "longer"),
        (sum(|t| t.off_end.count), "ends off"),
    ];
    let all = counts.map(|(count, what)| format!("{count} {what}"));
    Goal {
        name: "G4",
        wanted,
        got: Some(format!(
            "{} of {} plans",
            all.join(", "),
            sum(|t| t.planned)
        )),
        met: counts.iter().all(|(count, _)| *count == 0),
    }
}

fn worst(report: &Report) -> Goal {
    let wanted = format!("worst call at most {WORST} × the median call");
    let classes = SHARES.map(|(_, class, _)| class);
    let measured = classes.iter().filter_map(|class| {
        let own = of(report.cost(*class, AXES)?, Planner::Ours);
        Some((*class, own.worst_ns / own.median_ns))
    });
    let measured: Vec<_> = measured.collect();
    if measured.is_empty() {
        return not_measured("G5", wanted);
    }
    let got: Vec<_> = measured
        .iter()
        .map(|(class, x)| format!("{class} {x:.2}"))
        .collect();
    Goal {
        name: "G5",
        wanted,
        got: Some(got.join(", ")),
        met: measured.iter().all(|(_, times)| *times <= WORST),
    }
}

fn sample(report: &Report) -> Goal {
    let wanted = format!("a sample at most {SAMPLE} of Ruckig's");
    let rows = report.samples.iter().filter(|row| row.axes == AXES);
    let measured: Vec<_> = rows
        .map(|row| {
            let [own, theirs] = [Planner::Ours, Planner::Ruckig].map(|p| row.ns[p as usize].0);
            (row.class, own / theirs)
        })
        .collect();
    if measured.is_empty() {
        return not_measured("G6", wanted);
    }
    let got: Vec<_> = measured
        .iter()
        .map(|(class, x)| format!("{class} {x:.3}"))
        .collect();
    Goal {
        name: "G6",
        wanted,
        got: Some(got.join(", ")),
        met: measured.iter().all(|(_, share)| *share <= SAMPLE),
    }
}

fn of(costs: &[Cost; Planner::ALL.len()], planner: Planner) -> &Cost {
    &costs[planner as usize]
}

fn not_measured(name: &'static str, wanted: String) -> Goal {
    Goal {
        name,
        wanted,
        got: None,
        met: false,
    }
}

#[cfg(test)]
mod test {
    use super::*;
    use crate::report::{About, CostRow, SampleRow};
    use crate::tally::{Found, Tallies};

    fn report(share: f64, instructions: Option<f64>) -> Report {
        let cost = |planner, factor: f64| Cost {
            planner,
            ns: 1000.0 * factor,
            spread: 0.0,
            p99_ns: 0.0,
            median_ns: 100.0,
            worst_ns: 200.0 * factor,
            instructions: instructions.map(|x| x * factor),
        };
        let costs = [
            cost(Planner::Ours, share),
            cost(Planner::Ruckig, 1.0),
            cost(Planner::Rsruckig, 1.0),
        ];
        let row = |class| CostRow {
            class,
            axes: AXES,
            costs,
        };
        Report {
            about: About {
                cpu: String::new(),
                seed: 1,
                cases: 0,
                axes: AXES,
            },
            classes: vec![(Class::R, Tallies::default())],
            costs: [Class::R, Class::T, Class::S].map(row).into(),
            samples: vec![SampleRow {
                class: Class::R,
                axes: AXES,
                ns: [(8.0 * share, 0.0), (10.0, 0.0), (1.0, 0.0)],
            }],
        }
    }

    fn met(report: &Report) -> Vec<bool> {
        goals(report).iter().map(|goal| goal.met).collect()
    }

    #[test]
    fn goals_are_met_up_to_their_bound() {
        assert_eq!(met(&report(0.35, Some(9.0))), [true; 6]);
        assert_eq!(
            met(&report(0.36, None)),
            [false, true, true, true, true, true]
        );
        assert_eq!(
            met(&report(1.01, None)),
            [false, false, false, true, false, false]
        );
        assert_eq!(
            met(&report(f64::NAN, None)),
            [false, false, false, true, false, false]
        );
    }

    #[test]
    fn more_instructions_than_allowed_miss_a_goal_that_time_meets() {
        let mut report = report(0.35, Some(9.0));
        report.costs[0].costs[0].instructions = Some(4.0);
        assert_eq!(met(&report), [false, true, true, true, true, true]);
    }

    #[test]
    fn quality_counts_everything_of_ours() {
        let found = Found {
            count: 1,
            examples: vec![3],
        };
        for spoil in [
            (|tally, found| tally.faulty = found) as fn(&mut Tally, Found),
            |tally, found| tally.off_end = found,
            |tally, found| tally.against.longer = found,
            |tally, found| {
                tally.errors.insert("e".into(), found);
            },
        ] {
            let mut report = report(0.1, None);
            spoil(report.classes[0].1.of_mut(Planner::Ours), found.clone());
            assert!(!met(&report)[3]);
        }
        let mut report = report(0.1, None);
        report.classes[0].1.of_mut(Planner::Ruckig).faulty = found;
        assert!(met(&report)[3]);
    }

    #[test]
    fn what_was_not_measured_is_not_met() {
        let mut report = report(0.1, None);
        report.classes.clear();
        report.costs.clear();
        report.samples.clear();
        assert!(
            goals(&report)
                .iter()
                .all(|goal| !goal.met && goal.got.is_none())
        );
    }
}
