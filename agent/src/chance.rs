//! Probabilistic selection: behaviours invited by a stimulus.

use crate::args::On;
use crate::behaviour::Behaviour;
use crate::condition::{Condition, Pure};
use crate::instruction::Step;
use crate::random::Uniform;
use crate::response::{Adaptation, Response};
use crate::select::{Choice, Choices, decide_and_run};
use crate::subsystem::{Input, Subsystem, X};

/// The stimulus `ζ`: one component of what the sensors or other agents tell. \[Z2\] §3.
pub trait Stimulus<S: Subsystem> {
    /// The argument list, usually `F<(), (), V>` or `F<(), (), (), T>`.
    type Args: On<S::Level>;

    /// `ζ`, in the unit of the threshold `θ`.
    fn zeta(&self, x: X<'_, S, Self::Args>) -> f64;
}

/// A stimulus of a closure.
pub const fn stimulus<S, A, P>(zeta: P) -> Pure<A, P>
where
    S: Subsystem,
    A: On<S::Level>,
    P: Fn(X<'_, S, A>) -> f64,
{
    Pure::new(zeta)
}

impl<S, A, P> Stimulus<S> for Pure<A, P>
where
    S: Subsystem,
    A: On<S::Level>,
    P: Fn(X<'_, S, A>) -> f64,
{
    type Args = A;

    fn zeta(&self, x: X<'_, S, A>) -> f64 {
        (self.of)(x)
    }
}

/// A behaviour that is executed with a probability that grows or falls with a stimulus.
///
/// Where `when` holds, the probability is `P_q(ζ)` of \[Z2\] (21) or (22), else 0.
#[derive(Clone, Copy, Debug)]
pub struct Urge<P, Z, B> {
    when: P,
    stimulus: Z,
    response: Response,
    adaptation: Adaptation,
    then: B,
}

impl<P, Z, B> Urge<P, Z, B> {
    /// Where `when` holds, `then` with the probability `response(stimulus)`.
    pub const fn new(when: P, stimulus: Z, response: Response, then: B) -> Self {
        Self {
            when,
            stimulus,
            response,
            adaptation: Adaptation::NONE,
            then,
        }
    }

    /// The same, with a threshold that changes by the rule `adaptation` at every decision.
    #[must_use]
    pub const fn adapting(mut self, adaptation: Adaptation) -> Self {
        self.adaptation = adaptation;
        self
    }

    /// The response with the threshold as it is now.
    #[must_use]
    pub const fn response(&self) -> Response {
        self.response
    }
}

impl<S, P, Z, B> Choice<S> for Urge<P, Z, B>
where
    S: Subsystem,
    P: Condition<S>,
    Z: Stimulus<S>,
    B: Behaviour<S>,
{
    fn probability(&self, x: &Input<S>) -> f64 {
        if self.when.holds(X::new(x)) {
            self.response.probability(self.stimulus.zeta(X::new(x)))
        } else {
            0.0
        }
    }

    fn chosen(&mut self, chosen: bool) {
        let theta = self.response.theta();
        self.response = self
            .response
            .with_theta(self.adaptation.next(theta, chosen));
    }

    fn begin(&mut self) {
        self.then.begin();
    }

    fn step(&mut self, x: &Input<S>) -> Step<S::Command> {
        self.then.step(x)
    }
}

/// The loop \[Z2\] (15), (20) with predicates that hold by chance.
///
/// At a decision the choices are asked in their order; the first whose deviate `u`, uniform in
/// `[0, 1)`, is below its probability is run to its end. If none is, the step holds and the next
/// step decides again. Thresholds adapt at every decision and are not reset by
/// [`begin`](Behaviour::begin): they are what the agent has learnt, as is the state of the
/// random source.
#[derive(Clone, Copy, Debug)]
pub struct SelectByChance<R, U> {
    choices: R,
    uniform: U,
    current: Option<usize>,
}

impl<R, U> SelectByChance<R, U> {
    /// A loop over the choices ([`Urge`]s and [`Reaction`](crate::Reaction)s), drawing from
    /// `uniform`.
    pub const fn new(choices: R, uniform: U) -> Self {
        Self {
            choices,
            uniform,
            current: None,
        }
    }

    /// The index of the behaviour that runs, from 0.
    #[must_use]
    pub const fn current(&self) -> Option<usize> {
        self.current
    }

    /// The choices, with their thresholds as they are now.
    #[must_use]
    pub const fn choices(&self) -> &R {
        &self.choices
    }
}

impl<S: Subsystem, R: Choices<S>, U: Uniform> Behaviour<S> for SelectByChance<R, U> {
    fn begin(&mut self) {
        self.current = None;
    }

    fn step(&mut self, x: &Input<S>) -> Step<S::Command> {
        let uniform = &mut self.uniform;
        decide_and_run(&mut self.choices, &mut self.current, x, |choices| {
            let chosen = (0..choices.count()).find(|&q| {
                let p = choices.probability(q, x);
                // No deviate is spent on the impossible, so that a choice that is never possible
                // does not change the run of the others.
                p > 0.0 && uniform.draw() < p
            });
            (0..choices.count()).for_each(|q| choices.chosen(q, chosen == Some(q)));
            chosen
        })
    }
}
