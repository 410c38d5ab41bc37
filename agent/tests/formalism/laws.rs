//! Laws of the instructions and of sequences, for any program and any input.

use std::cell::Cell;

use agent::args::{E, F, V};
use agent::{
    Always, Behaviour, Compete, First, ForSteps, Greatest, List, Move, MoveIn, React, Reaction,
    Repeat, Rest, Select, Sequence, Step, Superpose, Then, Wait, condition, function, generator,
};
use proptest::collection::vec;
use proptest::prelude::*;

use crate::cell::{Arm, Script, arm, run};

type Program = Box<dyn Behaviour<Arm>>;

/// A recipe for a program of any depth.
#[derive(Clone, Debug)]
enum Recipe {
    Script(Vec<Option<i8>>),
    Move(u8),
    Wait(f64),
    Function,
    Then(Box<[Recipe; 2]>),
    Sequence(Vec<Recipe>),
    Repeat(u32, Box<Recipe>),
    ForSteps(u32, Box<Recipe>),
    Select(Vec<(f64, Recipe)>),
    React(Vec<(f64, Recipe)>),
    Guard(f64, Box<Recipe>),
    Superpose(Box<[Recipe; 2]>),
    Compete(Box<[Recipe; 2]>, bool),
}

fn script(steps: &[Option<i8>]) -> Script {
    let steps: Vec<_> = steps
        .iter()
        .map(|y| y.map_or(Step::Hold, |y| Step::Demand(f64::from(y))))
        .collect();
    Script::new(&steps)
}

fn over(limit: f64) -> impl agent::Condition<Arm> {
    condition::<Arm, F<(), (), V>, _>(move |x| *x.v() > limit)
}

fn count_to(n: u8) -> impl agent::Generator<Arm, Own = u8> {
    generator::<Arm, F<(), E, V>, _, _, _, _>(
        |x| (0, x.e() + x.v()),
        |c: &mut u8, x| {
            *c += 1;
            x.v() + f64::from(*c)
        },
        move |c, _| *c >= n,
    )
}

fn build(recipe: &Recipe) -> Program {
    let reactions = |list: &[(f64, Recipe)]| {
        let list: Vec<_> = list
            .iter()
            .map(|(v, r)| Reaction::new(over(*v), build(r)))
            .collect();
        List(list)
    };
    match recipe {
        Recipe::Script(steps) => Box::new(script(steps)),
        Recipe::Move(n) => Box::new(Move::new(count_to(*n))),
        Recipe::Wait(v) => Box::new(Wait::new(over(*v))),
        Recipe::Function => Box::new(function::<Arm, F<(), (), V>, _>(|x| *x.v())),
        Recipe::Then(ab) => Box::new(Then::new(build(&ab[0]), build(&ab[1]))),
        Recipe::Sequence(parts) => Box::new(Sequence::new(List(
            parts.iter().map(build).collect::<Vec<_>>(),
        ))),
        Recipe::Repeat(n, b) => Box::new(Repeat::times(*n, build(b))),
        Recipe::ForSteps(n, b) => Box::new(ForSteps::new(*n, build(b))),
        Recipe::Select(list) => Box::new(Select::new(reactions(list))),
        Recipe::React(list) => Box::new(React::new(reactions(list))),
        Recipe::Guard(v, b) => Box::new(Reaction::new(over(*v), build(b))),
        Recipe::Superpose(ab) => Box::new(Superpose::weighted(
            (build(&ab[0]), build(&ab[1])),
            [0.5, -2.0],
        )),
        Recipe::Compete(ab, true) => Box::new(Compete::new(
            (build(&ab[0]), build(&ab[1])),
            Greatest(|y: &f64| *y),
        )),
        Recipe::Compete(ab, false) => Box::new(Compete::new((build(&ab[0]), build(&ab[1])), First)),
    }
}

fn recipe() -> impl Strategy<Value = Recipe> {
    let leaf = prop_oneof![
        vec(proptest::option::of(any::<i8>()), 0..4).prop_map(Recipe::Script),
        (0..4_u8).prop_map(Recipe::Move),
        (0.0..1.0_f64).prop_map(Recipe::Wait),
        Just(Recipe::Function),
    ];
    leaf.prop_recursive(3, 12, 3, |inner| {
        let two = [inner.clone(), inner.clone()].prop_map(Box::new);
        let guarded = vec((0.0..1.0_f64, inner.clone()), 0..3);
        let one = inner.clone().prop_map(Box::new);
        prop_oneof![
            two.clone().prop_map(Recipe::Then),
            vec(inner, 0..4).prop_map(Recipe::Sequence),
            (0..4_u32, one.clone()).prop_map(|(n, b)| Recipe::Repeat(n, b)),
            (0..6_u32, one.clone()).prop_map(|(n, b)| Recipe::ForSteps(n, b)),
            guarded.clone().prop_map(Recipe::Select),
            guarded.prop_map(Recipe::React),
            (0.0..1.0_f64, one).prop_map(|(v, b)| Recipe::Guard(v, b)),
            two.clone().prop_map(Recipe::Superpose),
            (two, any::<bool>()).prop_map(|(ab, greatest)| Recipe::Compete(ab, greatest)),
        ]
    })
}

fn forces() -> impl Strategy<Value = Vec<f64>> {
    vec(0.0..1.0_f64, 0..30)
}

proptest! {
    /// The contract of `Behaviour`: once done, done until `begin`.
    #[test]
    fn an_end_is_final(recipe in recipe(), forces in forces()) {
        let mut b = build(&recipe);
        let mut ended = false;
        for (i, &v) in (0..).zip(&forces) {
            let done = b.step(&arm(i, v)) == Step::Done;
            prop_assert!(done || !ended);
            ended = done;
        }
    }

    /// The contract of `Behaviour`: `begin` at any step makes it as new. So a run is repeatable.
    #[test]
    fn begin_makes_new(recipe in recipe(), before in forces(), forces in forces()) {
        let mut used = build(&recipe);
        run(&mut used, &before);
        used.begin();
        prop_assert_eq!(run(&mut used, &forces), run(&mut build(&recipe), &forces));
    }

    /// `then` of any two programs plays the first to its end, and the second from that instant.
    #[test]
    fn then_loses_no_instant(a in recipe(), b in recipe(), forces in forces()) {
        let both = run(&mut Then::new(build(&a), build(&b)), &forces);
        let mut first = run(&mut build(&a), &forces);
        if first.last() == Some(&Step::Done) {
            first.pop();
            let rest: Vec<_> = (0..).zip(&forces).skip(first.len()).collect();
            let mut second = build(&b);
            for (i, &v) in rest {
                first.push(second.step(&arm(i, v)));
                if first.last() == Some(&Step::Done) {
                    break;
                }
            }
        }
        prop_assert_eq!(both, first);
    }

    #[test]
    fn a_sequence_is_a_chain_of_then(a in recipe(), b in recipe(), c in recipe(), forces in forces()) {
        let mut sequence = Sequence::new((build(&a), build(&b), build(&c)));
        let mut left = Then::new(Then::new(build(&a), build(&b)), build(&c));
        let mut right = Then::new(build(&a), Then::new(build(&b), build(&c)));
        let steps = run(&mut sequence, &forces);
        prop_assert_eq!(&steps, &run(&mut left, &forces));
        prop_assert_eq!(&steps, &run(&mut right, &forces));
    }

    #[test]
    fn for_steps_takes_the_first_n(recipe in recipe(), n in 0..40_u32, forces in forces()) {
        let limited = run(&mut ForSteps::new(n, build(&recipe)), &forces);
        let mut free = run(&mut build(&recipe), &forces);
        let n = usize::try_from(n).unwrap();
        if n < free.len() {
            free[n] = Step::Done;
            free.truncate(n + 1);
        }
        prop_assert_eq!(limited, free);
    }

    /// A script with at least one step, `n` times, is its steps `n` times.
    #[test]
    fn repeat_repeats(steps in vec(proptest::option::of(any::<i8>()), 1..4), n in 0..5_usize) {
        let forces = [0.0; 30];
        let times = u32::try_from(n).unwrap();
        let repeated = run(&mut Repeat::times(times, script(&steps)), &forces);
        let written = run(&mut script(&steps.repeat(n)), &forces);
        prop_assert_eq!(repeated, written);
    }

    /// [Z1] (4): a Wait never demands, and ends in the first step in which f_I is true.
    #[test]
    fn wait_never_demands(limit in 0.0..1.0_f64, forces in forces()) {
        let steps = run(&mut Wait::new(over(limit)), &forces);
        let end = forces.iter().position(|&v| v > limit);
        let holds = end.unwrap_or(forces.len());
        prop_assert!(steps.iter().take(holds).all(|s| *s == Step::Hold));
        prop_assert_eq!(steps.len(), holds + usize::from(end.is_some()));
    }

    /// [Z2] Fig. 3: f' once and first; f_τ before every f'', and nothing after it was true.
    #[test]
    fn a_move_in_a_lent_place_does_what_a_move_does(n in 0..6_u32, left in 0..9_u32, forces in forces()) {
        let counting = generator::<Arm, F<(), (), V>, _, _, _, _>(
            |x| (0_u32, *x.v()),
            |c, x| { *c += 1; f64::from(*c) + x.v() },
            |c, _| *c >= n,
        );
        let wanted = run(&mut Move::new(&counting), &forces);
        // of what another Move left in the place nothing is seen
        let (mut place, mut running) = (left, MoveIn::new(&counting));
        prop_assert!(!running.runs());
        for (i, (force, wanted)) in (0..).zip(forces.iter().zip(&wanted)) {
            let step = running.step::<Arm>(&mut place, &arm(i, *force));
            prop_assert_eq!(&step, wanted);
            prop_assert_eq!(running.runs(), step != Step::Done);
        }
    }

    #[test]
    fn move_follows_the_flow_chart(n in 0..6_u32, forces in forces()) {
        let (first, next, asked) = (Cell::new(0_u32), Cell::new(0_u32), Cell::new(0_u32));
        let counting = generator::<Arm, F<(), (), ()>, _, _, _, _>(
            |_| { first.set(first.get() + 1); (0_u32, -1.0) },
            |c, _| { next.set(next.get() + 1); *c += 1; f64::from(*c) },
            |c, _| { asked.set(asked.get() + 1); *c >= n },
        );
        let steps = run(&mut Move::new(&counting), &forces);
        let demands = u32::try_from(steps.iter().filter(|s| s.demand().is_some()).count()).unwrap();
        let done = u32::from(steps.last() == Some(&Step::Done));
        prop_assert_eq!(first.get(), u32::from(!forces.is_empty()));
        prop_assert_eq!(first.get() + next.get(), demands);
        prop_assert_eq!(asked.get(), next.get() + done);
        prop_assert!(demands <= n + 1);
        prop_assert!(steps.first().is_none_or(|s| *s == Step::Demand(-1.0)));
    }
}

#[test]
fn repeat_of_nothing_holds_and_ends() {
    let nothing = || Script::new(&[]);
    let mut forever = Repeat::forever(nothing());
    assert_eq!(run(&mut forever, &[0.0; 4]), [Step::Hold; 4]);
    let steps = run(&mut Repeat::times(3, nothing()), &[0.0; 4]);
    assert_eq!(steps, [Step::Hold, Step::Done]);
    assert_eq!(run(&mut Repeat::times(0, nothing()), &[0.0]), [Step::Done]);
}

#[test]
fn a_pause_and_a_wait_with_a_limit() {
    assert_eq!(
        run(&mut ForSteps::new(2, Rest), &[0.0; 9]),
        [Step::Hold, Step::Hold, Step::Done]
    );
    let mut wait = ForSteps::new(3, Wait::new(Always));
    assert_eq!(run(&mut wait, &[0.0; 9]), [Step::Done]);
}

/// Parameters in flash, state in the Move; one function in two motions at once.
#[test]
fn one_static_generator_runs_in_two_moves() {
    use agent::{Generator, X};
    struct By {
        rad: f64,
    }
    impl Generator<Arm> for By {
        type Own = f64;
        type Args = F<(), E, ()>;
        fn first(&self, x: X<'_, Arm, Self::Args>) -> (f64, f64) {
            (*x.e(), x.e() + self.rad)
        }
        fn next(&self, from: &mut f64, _: X<'_, Arm, Self::Args>) -> f64 {
            *from += self.rad;
            *from + self.rad
        }
        fn terminal(&self, from: &f64, _: X<'_, Arm, Self::Args>) -> bool {
            *from > 2.0
        }
    }
    static BY: By = By { rad: 0.5 };
    let (mut a, mut b) = (Move::new(&BY), Move::new(&BY));
    assert_eq!(a.step(&arm(0, 0.0)), Step::Demand(1.5));
    assert_eq!(a.step(&arm(1, 0.0)), Step::Demand(2.0));
    assert_eq!(b.step(&arm(1, 0.0)), Step::Demand(1.5));
    assert_eq!((a.own(), b.own()), (Some(&1.5), Some(&1.0)));
}

/// A variable of the program outlives the motions: lent to them as a `Cell`.
#[test]
fn motions_share_a_variable_of_the_program() {
    let touched = Cell::new(0_u32);
    let probe = generator::<Arm, F<(), (), V>, _, _, _, _>(
        |_| ((), 0.1),
        |(), _| 0.1,
        |(), x| {
            let touch = *x.v() > 0.5;
            touched.set(touched.get() + u32::from(touch));
            touch
        },
    );
    let thrice = condition::<Arm, F<(), (), ()>, _>(|_| touched.get() >= 3);
    let mut maze = React::new((
        Reaction::new(&thrice, Rest),
        Reaction::new(Always, Move::new(&probe)),
    ));
    let steps = run(&mut maze, &[0.0, 1.0, 1.0, 1.0, 1.0]);
    assert_eq!(steps[..4], [Step::Demand(0.1); 4]);
    assert_eq!(steps[4], Step::Hold);
}
