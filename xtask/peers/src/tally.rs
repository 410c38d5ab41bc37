//! What is counted over many cases.

use crate::judge::{Amounts, TOLERANCE};
use crate::plan::Outcome;
use crate::planner::Planner;
use std::collections::BTreeMap;

/// Numbers of cases kept as examples of each kind of finding, the lowest.
const EXAMPLES: usize = 5;
/// Errors at the end above this are counted: the goal for ours.
pub const END_GOAL: f64 = 1e-10;

/// A largest value, and the case it comes from: the lowest of several.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Worst {
    /// The value.
    pub value: f64,
    /// The number of the case.
    pub case: u64,
}

impl Worst {
    fn note(&mut self, value: f64, case: u64) {
        let worse = value > self.value || value.is_nan();
        if worse || (value.to_bits() == self.value.to_bits() && case < self.case) {
            *self = Self { value, case };
        }
    }
}

/// Cases of one kind: how many, and a few of them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Found {
    /// How many.
    pub count: u64,
    /// The lowest numbers of them.
    pub examples: Vec<u64>,
}

impl Found {
    fn note(&mut self, case: u64) {
        self.merge(&Self {
            count: 1,
            examples: vec![case],
        });
    }

    fn merge(&mut self, other: &Self) {
        self.count += other.count;
        self.examples.extend(&other.examples);
        self.examples.sort_unstable();
        self.examples.truncate(EXAMPLES);
    }
}

/// One planner, over all cases of a class.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    /// Cases it planned.
    pub planned: u64,
    /// Cases that Ruckig's check of the input refuses and this planner refuses or fails.
    pub refused: u64,
    /// Cases that Ruckig's check refuses and this planner has planned.
    pub beyond: u64,
    /// Cases that Ruckig's check takes and this planner has not planned, by what it says.
    pub errors: BTreeMap<String, Found>,
    /// Plans with a violation, whichever.
    pub faulty: Found,
    /// Plans with each violation, named as in [`Amounts::NAMES`].
    pub violations: BTreeMap<&'static str, Found>,
    /// Plans whose error at the end is above [`END_GOAL`].
    pub off_end: Found,
    /// The worst of each amount, in the order of [`Amounts::NAMES`]; of plans without violation the
    /// ends only.
    pub worst: [Worst; 9],
    /// Duration of all plans, s.
    pub duration_sum: f64,
    /// Against Ruckig's plan, where both keep all promises.
    pub against: Against,
}

/// Durations against Ruckig's.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Against {
    /// Cases compared: both have a plan without violation.
    pub compared: u64,
    /// Longer by more than [`TOLERANCE`], s.
    pub longer: Found,
    /// The worst of those, s.
    pub most_longer: Worst,
    /// Shorter by more than [`TOLERANCE`], s.
    pub shorter: Found,
    /// The best of those, s.
    pub most_shorter: Worst,
    /// The sum of all differences to Ruckig, s.
    pub difference_sum: f64,
}

/// An outcome with its judgement.
#[derive(Clone, Debug)]
pub struct Judged {
    /// What the planner said.
    pub outcome: Outcome,
    /// What the judge says of the plan; nothing without one.
    pub amounts: Option<Amounts>,
}

impl Judged {
    /// The duration of a plan that keeps every promise.
    fn good(&self) -> Option<f64> {
        match (&self.outcome, self.amounts) {
            (Outcome::Planned(plan), Some(amounts)) if amounts.pass() => Some(plan.duration),
            _ => None,
        }
    }
}

impl Tally {
    /// Counts a case: what the planner said, beside what Ruckig said.
    pub fn note(&mut self, case: u64, own: &Judged, ruckig: &Judged) {
        let refused = matches!(ruckig.outcome, Outcome::Refused(_));
        match &own.outcome {
            Outcome::Planned(plan) => {
                self.planned += 1;
                self.beyond += u64::from(refused);
                self.duration_sum += plan.duration;
            }
            Outcome::Refused(_) | Outcome::Failed(_) if refused => self.refused += 1,
            Outcome::Refused(why) => self.error(&format!("refused: {why}"), case),
            Outcome::Failed(why) => self.error(why, case),
        }
        if let Some(amounts) = &own.amounts {
            self.judgement(case, amounts);
        }
        if let (Some(own), Some(theirs)) = (own.good(), ruckig.good()) {
            self.against.note(case, own - theirs);
        }
    }

    fn error(&mut self, why: &str, case: u64) {
        self.errors.entry(why.to_owned()).or_default().note(case);
    }

    fn judgement(&mut self, case: u64, amounts: &Amounts) {
        for (worst, value) in self.worst.iter_mut().zip(amounts.list()) {
            worst.note(value, case);
        }
        if !amounts.pass() {
            self.faulty.note(case);
        }
        for (name, found) in Amounts::NAMES.into_iter().zip(amounts.violations()) {
            if found {
                self.violations.entry(name).or_default().note(case);
            }
        }
        if amounts.end() > END_GOAL {
            self.off_end.note(case);
        }
    }

    /// Adds what another thread has counted.
    pub fn merge(&mut self, other: &Self) {
        self.planned += other.planned;
        self.refused += other.refused;
        self.beyond += other.beyond;
        for (why, found) in &other.errors {
            self.errors.entry(why.clone()).or_default().merge(found);
        }
        self.faulty.merge(&other.faulty);
        for (name, found) in &other.violations {
            self.violations.entry(name).or_default().merge(found);
        }
        self.off_end.merge(&other.off_end);
        for (worst, other) in self.worst.iter_mut().zip(other.worst) {
            worst.note(other.value, other.case);
        }
        self.duration_sum += other.duration_sum;
        self.against.merge(&other.against);
    }

    /// Cases not planned though Ruckig's check of the input takes them.
    #[must_use]
    pub fn error_count(&self) -> u64 {
        self.errors.values().map(|found| found.count).sum()
    }

    /// The worst excess of a limit, relative to it.
    #[must_use]
    pub fn worst_excess(&self) -> f64 {
        let [_, jerk, acceleration, velocity, ..] = self.worst;
        [jerk, acceleration, velocity].iter().fold(0.0, larger)
    }

    /// The worst error at the end.
    #[must_use]
    pub fn worst_end(&self) -> f64 {
        let [.., p, v, a] = self.worst;
        [p, v, a].iter().fold(0.0, larger)
    }
}

fn larger(most: f64, worst: &Worst) -> f64 {
    if worst.value > most || worst.value.is_nan() {
        worst.value
    } else {
        most
    }
}

impl Against {
    fn note(&mut self, case: u64, difference: f64) {
        self.compared += 1;
        self.difference_sum += difference;
        self.most_longer.note(difference, case);
        self.most_shorter.note(-difference, case);
        if difference > TOLERANCE {
            self.longer.note(case);
        } else if difference < -TOLERANCE {
            self.shorter.note(case);
        }
    }

    fn merge(&mut self, other: &Self) {
        self.compared += other.compared;
        self.difference_sum += other.difference_sum;
        self.longer.merge(&other.longer);
        self.shorter.merge(&other.shorter);
        for (own, other) in [
            (&mut self.most_longer, other.most_longer),
            (&mut self.most_shorter, other.most_shorter),
        ] {
            own.note(other.value, other.case);
        }
    }
}

/// All planners over all cases of a class.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tallies([Tally; Planner::ALL.len()]);

impl Tallies {
    /// That of a planner.
    #[must_use]
    pub fn of(&self, planner: Planner) -> &Tally {
        &self.0[planner as usize]
    }

    #[cfg(test)]
    pub(crate) fn of_mut(&mut self, planner: Planner) -> &mut Tally {
        &mut self.0[planner as usize]
    }

    /// Counts a case; what was said in the order of [`Planner::ALL`].
    pub fn note(&mut self, case: u64, said: &[Judged; Planner::ALL.len()]) {
        let ruckig = &said[Planner::Ruckig as usize];
        for (tally, own) in self.0.iter_mut().zip(said) {
            tally.note(case, own, ruckig);
        }
    }

    /// Adds what another thread has counted.
    pub fn merge(&mut self, other: &Self) {
        for (tally, other) in self.0.iter_mut().zip(&other.0) {
            tally.merge(other);
        }
    }
}

#[cfg(test)]
mod test {
    use super::*;
    use crate::plan::Plan;

    fn planned(duration: f64, velocity: f64) -> Judged {
        let plan = Plan {
            duration,
            axes: vec![],
        };
        Judged {
            outcome: Outcome::Planned(plan),
            amounts: Some(Amounts {
                velocity,
                ..Amounts::default()
            }),
        }
    }

    fn without(outcome: Outcome) -> Judged {
        Judged {
            outcome,
            amounts: None,
        }
    }

    fn refused() -> Judged {
        without(Outcome::Refused("r".into()))
    }

    fn failed() -> Judged {
        without(Outcome::Failed("f".into()))
    }

    #[test]
    fn a_refusal_is_an_error_only_where_ruckig_takes_the_question() {
        let mut tally = Tally::default();
        tally.note(1, &refused(), &refused());
        tally.note(2, &failed(), &refused());
        assert_eq!((tally.refused, tally.error_count()), (2, 0));
        tally.note(3, &refused(), &planned(1.0, 0.0));
        tally.note(4, &failed(), &failed());
        assert_eq!((tally.refused, tally.error_count()), (2, 2));
        assert_eq!(tally.errors["refused: r"].examples, [3]);
        tally.note(5, &planned(1.0, 0.0), &refused());
        assert_eq!((tally.planned, tally.beyond), (1, 1));
    }

    #[test]
    fn durations_are_compared_between_plans_without_violation_only() {
        let mut tally = Tally::default();
        tally.note(1, &planned(1.0, 0.0), &planned(1.0, 1e-8));
        tally.note(2, &planned(2.0, 1e-8), &planned(1.0, 0.0));
        tally.note(3, &planned(2.0, 0.0), &failed());
        assert_eq!(tally.against.compared, 0);
        assert_eq!(
            (tally.faulty.count, tally.faulty.examples.as_slice()),
            (1, &[2][..])
        );
        tally.note(4, &planned(1.0 + 2e-9, 0.0), &planned(1.0, 0.0));
        tally.note(5, &planned(1.0 - 2e-9, 0.0), &planned(1.0, 0.0));
        tally.note(6, &planned(1.0 + 5e-10, 0.0), &planned(1.0, 0.0));
        assert_eq!(tally.against.compared, 3);
        assert_eq!(tally.against.longer.examples, [4]);
        assert_eq!(tally.against.shorter.examples, [5]);
        assert_eq!(
            (
                tally.against.most_longer.case,
                tally.against.most_shorter.case
            ),
            (4, 5)
        );
    }

    #[test]
    fn what_threads_counted_adds_up_in_any_order() {
        let part = |cases: [u64; 4]| {
            let mut tally = Tally::default();
            for case in cases {
                let velocity = if case % 2 == 0 { 1e-8 } else { 0.0 };
                tally.note(case, &planned(1.0, velocity), &planned(1.0, 0.0));
            }
            tally.note(cases[0], &failed(), &planned(1.0, 0.0));
            tally
        };
        let parts = [
            part([8, 1, 2, 3]),
            part([4, 12, 6, 7]),
            part([10, 9, 14, 11]),
        ];
        let sum = |order: [usize; 3]| {
            let mut all = Tally::default();
            for i in order {
                all.merge(&parts[i]);
            }
            all
        };
        let all = sum([0, 1, 2]);
        assert_eq!(all, sum([2, 0, 1]));
        assert_eq!(
            (all.planned, all.faulty.count, all.error_count()),
            (12, 7, 3)
        );
        assert_eq!(all.faulty.examples, [2, 4, 6, 8, 10]);
        assert_eq!((all.worst[3].value, all.worst[3].case), (1e-8, 2));
    }

    #[test]
    fn what_is_not_a_number_is_the_worst() {
        let mut worst = Worst::default();
        worst.note(1.0, 7);
        worst.note(f64::NAN, 8);
        worst.note(2.0, 9);
        assert!(worst.value.is_nan() && worst.case == 8);
    }
}
