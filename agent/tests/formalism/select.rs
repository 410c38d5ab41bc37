//! Selection: (11), (12), (14), (15), (20).

use agent::args::{F, V};
use agent::{
    Always, Behaviour, ForSteps, List, Never, React, Reaction, Rest, Select, Step, condition,
};
use proptest::collection::vec;
use proptest::prelude::*;

use crate::cell::{Arm, Script, arm, run};

fn play(ys: &[f64]) -> Script {
    Script::new(&ys.iter().map(|&y| Step::Demand(y)).collect::<Vec<_>>())
}

fn over(limit: f64) -> impl agent::Condition<Arm, Args = F<(), (), V>> + Copy {
    #[derive(Clone, Copy)]
    struct Over(f64);
    impl agent::Condition<Arm> for Over {
        type Args = F<(), (), V>;
        fn holds(&self, x: agent::X<'_, Arm, Self::Args>) -> bool {
            *x.v() > self.0
        }
    }
    Over(limit)
}

fn demands(ys: &[f64]) -> Vec<Step<f64>> {
    ys.iter().map(|&y| Step::Demand(y)).collect()
}

#[test]
fn select_decides_once_per_behaviour() {
    let mut b = Select::new((
        Reaction::new(over(0.5), play(&[10.0, 11.0, 12.0])),
        Reaction::new(Always, play(&[20.0, 21.0])),
    ));
    // The force rises while the main reaction runs: it is run to its end first.
    let steps = run(&mut b, &[0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(steps, demands(&[20.0, 21.0, 10.0, 11.0, 12.0, 20.0, 21.0]));
}

#[test]
fn react_decides_in_every_step() {
    let mut b = React::new((
        Reaction::new(over(0.5), play(&[10.0, 11.0, 12.0])),
        Reaction::new(Always, play(&[20.0, 21.0])),
    ));
    let steps = run(&mut b, &[0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(steps, demands(&[20.0, 10.0, 11.0, 20.0, 21.0, 20.0, 21.0]));
}

#[test]
fn without_a_true_predicate_the_loop_holds() {
    let mut select = Select::new((Reaction::new(over(0.5), play(&[1.0])),));
    assert_eq!(
        run(&mut select, &[0.0, 1.0, 0.0]),
        [Step::Hold, Step::Demand(1.0), Step::Hold]
    );
    let mut react = React::new([Reaction::new(over(0.5), play(&[1.0]))]);
    assert_eq!(
        run(&mut react, &[0.0, 1.0, 0.0]),
        [Step::Hold, Step::Demand(1.0), Step::Hold]
    );
    let mut none = Select::new(List(Vec::<Reaction<Never, Rest>>::new()));
    assert_eq!(run(&mut none, &[0.0, 1.0]), [Step::Hold; 2]);
}

#[test]
fn a_behaviour_that_ends_at_once_costs_its_step() {
    let mut select = Select::new((Reaction::new(Always, Script::new(&[])),));
    assert_eq!(run(&mut select, &[0.0; 3]), [Step::Hold; 3]);
    let mut react = React::new((Reaction::new(Always, Script::new(&[])),));
    assert_eq!(run(&mut react, &[0.0; 3]), [Step::Hold; 3]);
}

#[test]
fn reactions_nest_with_predicates_of_their_own() {
    let inner = Select::new((
        Reaction::new(over(0.8), play(&[3.0])),
        Reaction::new(Always, play(&[2.0])),
    ));
    let mut outer = Select::new((
        Reaction::new(over(0.5), ForSteps::new(2, inner)),
        Reaction::new(Always, play(&[1.0])),
    ));
    let steps = run(&mut outer, &[0.0, 0.6, 0.9, 0.0, 0.9]);
    assert_eq!(steps, demands(&[1.0, 2.0, 3.0, 1.0, 3.0]));
}

#[test]
fn a_guard_begins_anew_whenever_its_predicate_becomes_true() {
    let mut guard = Reaction::new(over(0.5), play(&[1.0, 2.0]));
    let steps = run(&mut guard, &[1.0, 0.0, 1.0, 1.0, 1.0]);
    let (one, two) = (Step::Demand(1.0), Step::Demand(2.0));
    assert_eq!(steps, [one, Step::Hold, one, two, Step::Hold]);
}

#[test]
fn conditions_of_several_classes_share_a_list_behind_dyn() {
    use agent::args::E;
    use agent::{Condition, widen};
    type Any<'c> = &'c dyn Condition<Arm, Args = F<(), E, V>>;
    let force = widen::<F<(), E, V>, _>(over(0.5));
    let far = widen::<F<(), E, V>, _>(condition::<Arm, F<(), E, ()>, _>(|x| *x.e() > 0.5));
    let (force, far): (Any<'_>, Any<'_>) = (&force, &far);
    let mut reactions = [
        Reaction::new(force, play(&[1.0])),
        Reaction::new(far, play(&[2.0])),
    ];
    let mut b = Select::new(List(&mut reactions[..]));
    assert_eq!(run(&mut b, &[1.0, 0.0]), demands(&[1.0, 2.0]));
    assert_eq!(b.current(), Some(1));
}

#[test]
fn an_index_beyond_the_last_is_nothing() {
    use agent::{Bundle, Choices};
    let mut two = (play(&[1.0]), play(&[1.0]));
    assert_eq!(Bundle::<Arm>::count(&two), 2);
    Bundle::<Arm>::begin(&mut two, 2);
    assert_eq!((two.0.begun, two.1.begun), (0, 0));
    assert_eq!(Bundle::<Arm>::step(&mut two, 2, &arm(0, 0.0)), Step::Done);
    assert_eq!(
        Bundle::<Arm>::step(&mut [play(&[1.0])], 1, &arm(0, 0.0)),
        Step::Done
    );
    let one = [Reaction::new(Always, play(&[1.0]))];
    assert!(Choices::<Arm>::probability(&one, 1, &arm(0, 0.0)) <= 0.0);
}

proptest! {
    /// In each step of a selection one behaviour is stepped at most: the scripts advance in sum
    /// by the number of demands, and the demand is of the one that is current.
    #[test]
    fn select_runs_one(
        limits in vec(0.0..1.0_f64, 3),
        lengths in vec(1..4_usize, 3),
        forces in vec(0.0..1.0_f64, 0..40),
    ) {
        let reactions: Vec<_> = (0_u8..)
            .zip(limits.iter().zip(&lengths))
            .map(|(q, (&limit, &n))| {
                let ys: Vec<_> = (0..n).map(|_| f64::from(q)).collect();
                Reaction::new(over(limit), play(&ys))
            })
            .collect();
        let mut b = Select::new(List(reactions));
        let (mut running, mut left) = (None, 0);
        for (i, &v) in (0..).zip(&forces) {
            if left == 0 {
                running = (0..3_u8).find(|&q| v > limits[usize::from(q)]);
                left = running.map_or(0, |q| lengths[usize::from(q)]);
            }
            left = left.saturating_sub(1);
            let expected = running.map_or(Step::Hold, |q| Step::Demand(f64::from(q)));
            prop_assert_eq!(b.step(&arm(i, v)), expected);
            prop_assert_eq!(b.current(), running.map(usize::from));
        }
    }

    /// React is memoryless over functions: the demand is that of the first true predicate.
    #[test]
    fn react_is_a_case_distinction(forces in vec(0.0..1.0_f64, 0..40)) {
        let f = |k: f64| agent::function::<Arm, F<(), (), V>, _>(move |x| k * x.v());
        let mut b = React::new((
            Reaction::new(over(0.7), f(7.0)),
            Reaction::new(over(0.3), f(3.0)),
        ));
        for (i, &v) in (0..).zip(&forces) {
            let expected = if v > 0.7 {
                Step::Demand(7.0 * v)
            } else if v > 0.3 {
                Step::Demand(3.0 * v)
            } else {
                Step::Hold
            };
            prop_assert_eq!(b.step(&arm(i, v)), expected);
        }
    }
}
