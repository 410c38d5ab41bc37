//! Selection: which behaviour is executed, decided by predicates.

use core::ops::DerefMut;

use crate::behaviour::Behaviour;
use crate::bundle::List;
use crate::condition::Condition;
use crate::instruction::Step;
use crate::subsystem::{Input, Subsystem, X};

/// `if p then b`: \[Z2\] (11) and (14).
///
/// On its own it is the guarded function (11): in every step in which `p` holds, `b` makes its
/// step; in the others there is no result and the reaction holds. `b` begins anew whenever `p`
/// becomes true. In a [`Select`] it is the reaction (14): `p` is asked once per run of `b`.
#[derive(Clone, Copy, Debug)]
pub struct Reaction<P, B> {
    when: P,
    then: B,
    active: bool,
}

impl<P, B> Reaction<P, B> {
    /// `if when then then`
    pub const fn new(when: P, then: B) -> Self {
        Self {
            when,
            then,
            active: false,
        }
    }
}

impl<S: Subsystem, P: Condition<S>, B: Behaviour<S>> Behaviour<S> for Reaction<P, B> {
    fn begin(&mut self) {
        self.active = false;
    }

    fn step(&mut self, x: &Input<S>) -> Step<S::Command> {
        if !self.when.holds(X::new(x)) {
            self.active = false;
            return Step::Hold;
        }
        if !self.active {
            self.active = true;
            self.then.begin();
        }
        match self.then.step(x) {
            Step::Done => Step::Hold,
            step => step,
        }
    }
}

/// A behaviour that may be chosen, with the probability of choosing it.
///
/// [`Reaction`]: 1 where its predicate holds, else 0. [`Urge`](crate::Urge): `P_q` of its stimulus.
pub trait Choice<S: Subsystem> {
    /// The probability in `[0, 1]` of executing this behaviour now.
    fn probability(&self, x: &Input<S>) -> f64;
    /// A decision was taken: was this behaviour chosen? Called once per decision.
    fn chosen(&mut self, chosen: bool);
    /// Begin the behaviour.
    fn begin(&mut self);
    /// Step the behaviour; the predicate is not asked.
    fn step(&mut self, x: &Input<S>) -> Step<S::Command>;
}

impl<S: Subsystem, P: Condition<S>, B: Behaviour<S>> Choice<S> for Reaction<P, B> {
    fn probability(&self, x: &Input<S>) -> f64 {
        if self.when.holds(X::new(x)) { 1.0 } else { 0.0 }
    }

    fn chosen(&mut self, _: bool) {}

    fn begin(&mut self) {
        self.then.begin();
    }

    fn step(&mut self, x: &Input<S>) -> Step<S::Command> {
        self.then.step(x)
    }
}

/// Choices addressed by an index `q`, counted from 0, in their order of precedence.
///
/// Tuples of up to eight, arrays and [`List`]s. An index beyond the last one is never chosen.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a list of reactions of the subsystem `{S}`",
    label = "write a tuple of up to 8 reactions, an array, or a `List`"
)]
pub trait Choices<S: Subsystem> {
    /// How many there are.
    fn count(&self) -> usize;
    /// [`Choice::probability`] of the `q`-th.
    fn probability(&self, q: usize, x: &Input<S>) -> f64;
    /// [`Choice::chosen`] of the `q`-th.
    fn chosen(&mut self, q: usize, chosen: bool);
    /// Begin the `q`-th.
    fn begin(&mut self, q: usize);
    /// Step the `q`-th.
    fn step(&mut self, q: usize, x: &Input<S>) -> Step<S::Command>;
}

/// Choices that are all deterministic: [`Reaction`]s.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a list of deterministic reactions of `{S}`",
    label = "write a tuple of up to 8 `Reaction`s, an array, or a `List`; chance needs `SelectByChance`"
)]
pub trait Reactions<S: Subsystem>: Choices<S> {
    /// The index of the first reaction whose predicate holds.
    fn select(&self, x: &Input<S>) -> Option<usize> {
        (0..self.count()).find(|&q| self.probability(q, x) > 0.0)
    }
}

/// The step of a selection loop: run the chosen behaviour to its end, then decide again.
///
/// At most one decision per instant; where what it chose ends at once, the step holds.
pub(crate) fn decide_and_run<S: Subsystem, R: Choices<S>>(
    choices: &mut R,
    current: &mut Option<usize>,
    x: &Input<S>,
    decide: impl FnOnce(&mut R) -> Option<usize>,
) -> Step<S::Command> {
    if let Some(q) = *current {
        match choices.step(q, x) {
            Step::Done => *current = None,
            step => return step,
        }
    }
    let Some(q) = decide(choices) else {
        return Step::Hold;
    };
    choices.begin(q);
    match choices.step(q, x) {
        Step::Done => Step::Hold,
        step => {
            *current = Some(q);
            step
        }
    }
}

/// The endless loop \[Z2\] (15) and (20): select a behaviour, run it to its end, select again.
///
/// The first reaction whose predicate holds is selected. While none holds, the loop holds; a last
/// reaction on [`Always`](crate::Always) is the main reaction. A `Select` may be a behaviour of a
/// reaction again: with [`ForSteps`](crate::ForSteps) it ends.
#[derive(Clone, Copy, Debug)]
pub struct Select<R> {
    reactions: R,
    current: Option<usize>,
}

impl<R> Select<R> {
    /// A loop over the reactions, in their order of precedence.
    pub const fn new(reactions: R) -> Self {
        Self {
            reactions,
            current: None,
        }
    }

    /// The index of the reaction that runs, from 0.
    #[must_use]
    pub const fn current(&self) -> Option<usize> {
        self.current
    }
}

impl<S: Subsystem, R: Reactions<S>> Behaviour<S> for Select<R> {
    fn begin(&mut self) {
        self.current = None;
    }

    fn step(&mut self, x: &Input<S>) -> Step<S::Command> {
        decide_and_run(&mut self.reactions, &mut self.current, x, |r| r.select(x))
    }
}

/// The endless loop \[Z2\] (12): select a function anew in every step.
///
/// The first reaction whose predicate holds makes one step. A behaviour begins anew when the
/// selection changes to it, and when it has ended and is selected still.
#[derive(Clone, Copy, Debug)]
pub struct React<R> {
    reactions: R,
    current: Option<usize>,
}

impl<R> React<R> {
    /// A loop over the reactions, in their order of precedence.
    pub const fn new(reactions: R) -> Self {
        Self {
            reactions,
            current: None,
        }
    }

    /// The index of the reaction that made the last step, from 0.
    #[must_use]
    pub const fn current(&self) -> Option<usize> {
        self.current
    }
}

impl<S: Subsystem, R: Reactions<S>> Behaviour<S> for React<R> {
    fn begin(&mut self) {
        self.current = None;
    }

    fn step(&mut self, x: &Input<S>) -> Step<S::Command> {
        let selected = self.reactions.select(x);
        if selected != self.current {
            self.current = None;
        }
        decide_and_run(&mut self.reactions, &mut self.current, x, |_| selected)
    }
}

impl<S, L, C> Choices<S> for List<L>
where
    S: Subsystem,
    L: DerefMut<Target = [C]>,
    C: Choice<S>,
{
    fn count(&self) -> usize {
        self.0.len()
    }

    fn probability(&self, q: usize, x: &Input<S>) -> f64 {
        self.0.get(q).map_or(0.0, |c| c.probability(x))
    }

    fn chosen(&mut self, q: usize, chosen: bool) {
        if let Some(c) = self.0.get_mut(q) {
            c.chosen(chosen);
        }
    }

    fn begin(&mut self, q: usize) {
        if let Some(c) = self.0.get_mut(q) {
            Choice::begin(c);
        }
    }

    fn step(&mut self, q: usize, x: &Input<S>) -> Step<S::Command> {
        self.0.get_mut(q).map_or(Step::Done, |c| Choice::step(c, x))
    }
}

impl<S: Subsystem, C: Choice<S>, const N: usize> Choices<S> for [C; N] {
    fn count(&self) -> usize {
        N
    }

    fn probability(&self, q: usize, x: &Input<S>) -> f64 {
        self.get(q).map_or(0.0, |c| c.probability(x))
    }

    fn chosen(&mut self, q: usize, chosen: bool) {
        if let Some(c) = self.get_mut(q) {
            c.chosen(chosen);
        }
    }

    fn begin(&mut self, q: usize) {
        if let Some(c) = self.get_mut(q) {
            Choice::begin(c);
        }
    }

    fn step(&mut self, q: usize, x: &Input<S>) -> Step<S::Command> {
        self.get_mut(q).map_or(Step::Done, |c| Choice::step(c, x))
    }
}

impl<S, L, P, B> Reactions<S> for List<L>
where
    S: Subsystem,
    L: DerefMut<Target = [Reaction<P, B>]>,
    P: Condition<S>,
    B: Behaviour<S>,
{
}

impl<S: Subsystem, P: Condition<S>, B: Behaviour<S>, const N: usize> Reactions<S>
    for [Reaction<P, B>; N]
{
}

macro_rules! tuple {
    ($n:literal: $($q:tt $C:ident $P:ident),+) => {
        impl<S: Subsystem, $($C: Choice<S>),+> Choices<S> for ($($C,)+) {
            fn count(&self) -> usize {
                $n
            }

            fn probability(&self, q: usize, x: &Input<S>) -> f64 {
                match q {
                    $( $q => self.$q.probability(x), )+
                    _ => 0.0,
                }
            }

            fn chosen(&mut self, q: usize, chosen: bool) {
                match q {
                    $( $q => self.$q.chosen(chosen), )+
                    _ => {}
                }
            }

            fn begin(&mut self, q: usize) {
                match q {
                    $( $q => self.$q.begin(), )+
                    _ => {}
                }
            }

            fn step(&mut self, q: usize, x: &Input<S>) -> Step<S::Command> {
                match q {
                    $( $q => self.$q.step(x), )+
                    _ => Step::Done,
                }
            }
        }

        impl<S: Subsystem, $($P: Condition<S>, $C: Behaviour<S>),+> Reactions<S>
            for ($(Reaction<$P, $C>,)+)
        {
        }
    };
}
tuple!(1: 0 C0 P0);
tuple!(2: 0 C0 P0, 1 C1 P1);
tuple!(3: 0 C0 P0, 1 C1 P1, 2 C2 P2);
tuple!(4: 0 C0 P0, 1 C1 P1, 2 C2 P2, 3 C3 P3);
tuple!(5: 0 C0 P0, 1 C1 P1, 2 C2 P2, 3 C3 P3, 4 C4 P4);
tuple!(6: 0 C0 P0, 1 C1 P1, 2 C2 P2, 3 C3 P3, 4 C4 P4, 5 C5 P5);
tuple!(7: 0 C0 P0, 1 C1 P1, 2 C2 P2, 3 C3 P3, 4 C4 P4, 5 C5 P5, 6 C6 P6);
tuple!(8: 0 C0 P0, 1 C1 P1, 2 C2 P2, 3 C3 P3, 4 C4 P4, 5 C5 P5, 6 C6 P6, 7 C7 P7);
