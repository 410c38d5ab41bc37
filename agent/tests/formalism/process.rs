//! The process: `f_E` first, three exclusive branches, and the record of total states.

use agent::args::{F, V};
use agent::{
    Behaviour, Check, ErrorCondition, Input, Move, NoError, Or, Outcome, Process, Recorder, Step,
    TotalState, Wait, condition, generator,
};
use proptest::collection::vec;
use proptest::prelude::*;

use crate::cell::{Arm, Script, arm};

#[derive(Clone, Debug, PartialEq)]
enum Fault {
    Overload { force: f64 },
    LateMessage,
}

/// `c`: the count of messages that came late. `r`: the raw force, N.
struct Overload;
impl ErrorCondition<Arm, u32, f64> for Overload {
    type Fault = Fault;
    fn check(&self, _: &u32, _: &f64, r: &f64) -> Result<(), Fault> {
        if *r > 50.0 {
            Err(Fault::Overload { force: *r })
        } else {
            Ok(())
        }
    }
}

fn push_to(limit: f64) -> impl Behaviour<Arm> {
    Move::new(generator::<Arm, F<(), (), V>, _, _, _, _>(
        |_| ((), 0.5),
        |(), x| *x.v(),
        move |(), x| *x.v() >= limit,
    ))
}

#[test]
fn an_error_wins_over_the_terminal_condition_of_the_same_step() {
    let mut p = Process::new(push_to(60.0), Overload);
    assert_eq!(
        p.step(&arm(7, 0.0), &0, &0.0, &mut ()),
        Outcome::Demand(0.5)
    );
    assert_eq!(
        p.step(&arm(8, 20.0), &0, &20.0, &mut ()),
        Outcome::Demand(20.0)
    );
    let error = Outcome::Error {
        at: 9,
        fault: Fault::Overload { force: 61.0 },
    };
    assert_eq!(p.step(&arm(9, 61.0), &0, &61.0, &mut ()), error);
    // Final, although the cause is gone.
    assert_eq!(p.step(&arm(10, 0.0), &0, &0.0, &mut ()), error);
    p.begin();
    assert_eq!(
        p.step(&arm(11, 0.0), &0, &0.0, &mut ()),
        Outcome::Demand(0.5)
    );
}

#[test]
fn an_error_wins_over_the_first_step_and_over_a_wait() {
    let mut p = Process::new(Script::new(&[Step::Demand(1.0)]), Overload);
    let error = Outcome::Error {
        at: 0,
        fault: Fault::Overload { force: 99.0 },
    };
    assert_eq!(p.step(&arm(0, 0.0), &0, &99.0, &mut ()), error);
    let now = condition::<Arm, F<(), (), ()>, _>(|_| true);
    let mut p = Process::new(Wait::new(now), Overload);
    assert_eq!(p.step(&arm(0, 0.0), &0, &99.0, &mut ()), error);
}

#[test]
fn without_error_it_ends_and_stays_ended() {
    let mut p = Process::new(push_to(20.0), Overload);
    assert_eq!(
        p.step(&arm(0, 0.0), &0, &0.0, &mut ()),
        Outcome::Demand(0.5)
    );
    assert_eq!(
        p.step(&arm(1, 20.0), &0, &20.0, &mut ()),
        Outcome::Ended { at: 1 }
    );
    assert!(p.has_ended());
    // Nothing is executed any more, so nothing can fail.
    assert_eq!(
        p.step(&arm(2, 20.0), &0, &99.0, &mut ()),
        Outcome::Ended { at: 1 }
    );
}

#[test]
fn error_situations_are_a_disjunction_in_order() {
    let check = |c: u32, r: f64| {
        let late = Check(|c: &u32, _: &f64, _: &f64| match c {
            0 => Ok(()),
            _ => Err(Fault::LateMessage),
        });
        let mut p = Process::new(push_to(60.0), Or(late, Overload));
        p.step(&arm(0, 0.0), &c, &r, &mut ())
    };
    assert_eq!(check(0, 0.0), Outcome::Demand(0.5));
    assert_eq!(
        check(1, 0.0),
        Outcome::Error {
            at: 0,
            fault: Fault::LateMessage
        }
    );
    assert_eq!(
        check(1, 99.0),
        Outcome::Error {
            at: 0,
            fault: Fault::LateMessage
        }
    );
    let overloaded = Outcome::Error {
        at: 0,
        fault: Fault::Overload { force: 99.0 },
    };
    assert_eq!(check(0, 99.0), overloaded);
}

#[test]
fn a_process_runs_whatever_dereferences_to_a_behaviour() {
    let mut script = Script::new(&[Step::Demand(1.0), Step::Hold]);
    let borrowed: &mut dyn Behaviour<Arm> = &mut script;
    let mut p = Process::new(borrowed, NoError);
    assert_eq!(
        p.step(&arm(0, 0.0), &(), &(), &mut ()),
        Outcome::Demand(1.0)
    );
    let boxed: Box<dyn Behaviour<Arm>> = Box::new(script);
    let mut p = Process::new(boxed, NoError);
    assert_eq!(p.step(&arm(0, 0.0), &(), &(), &mut ()), Outcome::Hold);
    assert_eq!(
        p.step(&arm(1, 0.0), &(), &(), &mut ()),
        Outcome::Ended { at: 1 }
    );
}

/// Keeps inputs and outcomes.
#[derive(Default)]
struct Tape(Vec<(Input<Arm>, Outcome<f64, Fault>)>);
impl<B: ?Sized> Recorder<Arm, B, Fault> for Tape {
    fn record(&mut self, state: TotalState<'_, Arm, B, Fault>) {
        assert_eq!(state.i, state.x.i);
        self.0.push((state.x.clone(), state.y.clone()));
    }
}

#[test]
fn the_total_state_holds_the_own_state_after_the_step() {
    let count = generator::<Arm, F<(), (), ()>, _, _, _, _>(
        |_| (1_u32, 0.0),
        |n, _| {
            *n += 1;
            0.0
        },
        |n, _| *n >= 2,
    );
    let mut p = Process::new(Move::new(count), NoError);
    let mut own = Vec::new();
    for i in 0..4 {
        let _ = p.step(&arm(i, 0.0), &(), &(), &mut |state: TotalState<
            '_,
            _,
            Move<_, u32>,
            _,
        >| {
            own.push((state.i, state.c.own().copied()));
        });
    }
    assert_eq!(own, [(0, Some(1)), (1, Some(2)), (2, None)]);
}

#[test]
fn a_total_state_prints() {
    let mut p = Process::new(Script::new(&[Step::Hold]), NoError);
    let mut text = String::new();
    let _ = p.step(&arm(5, 0.0), &(), &(), &mut |s: TotalState<'_, _, _, _>| {
        text = format!("{s:?}");
    });
    assert!(text.starts_with("TotalState { i: 5, c: Script"), "{text}");
    assert!(text.ends_with("y: Hold }"), "{text}");
}

proptest! {
    /// The branches of (4) and (5) exclude each other, and the record repeats the run.
    #[test]
    fn a_recorded_run_replays(
        forces in vec(0.0..70.0_f64, 0..40),
        limit in 0.0..70.0_f64,
    ) {
        let mut tape = Tape::default();
        let mut p = Process::new(push_to(limit), Overload);
        for (i, &v) in (0..).zip(&forces) {
            let outcome = p.step(&arm(i, v), &0, &v, &mut tape);
            let ended = matches!(outcome, Outcome::Ended { .. } | Outcome::Error { .. });
            prop_assert_eq!(ended, p.has_ended());
        }
        let errors = forces.iter().position(|&v| v > 50.0);
        let ends = forces.iter().skip(1).position(|&v| v >= limit).map(|n| n + 1);
        let last = tape.0.last().map(|(_, outcome)| outcome.clone());
        match (errors, ends) {
            (Some(m), n) if n.is_none_or(|n| m <= n) => {
                prop_assert_eq!(tape.0.len(), m + 1);
                let fault = Fault::Overload { force: forces[m] };
                prop_assert_eq!(last, Some(Outcome::Error { at: u32::try_from(m).unwrap(), fault }));
            }
            (_, Some(n)) => {
                prop_assert_eq!(tape.0.len(), n + 1);
                prop_assert_eq!(last, Some(Outcome::Ended { at: u32::try_from(n).unwrap() }));
            }
            _ => prop_assert_eq!(tape.0.len(), forces.len()),
        }
        let mut again = Process::new(push_to(limit), Overload);
        for (x, outcome) in &tape.0 {
            prop_assert_eq!(&again.step(x, &0, &x.v, &mut ()), outcome);
        }
    }
}
