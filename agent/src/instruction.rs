//! The two motion instructions, Move and Wait: the primitive behaviours.

use core::fmt;

use crate::behaviour::Behaviour;
use crate::condition::Condition;
use crate::generator::Generator;
use crate::subsystem::{Input, Subsystem, X};

/// What a behaviour asks for in one step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use = "a demand that is not transmitted is lost"]
pub enum Step<Y> {
    /// Attain this by the next instant: `e^{i+1} = yc_e`.
    Demand(Y),
    /// Stay: `e^{i+1} = e^i`.
    Hold,
    /// The behaviour has ended; nothing was computed in this step.
    Done,
}

impl<Y> Step<Y> {
    /// The demand, if there is one.
    pub fn demand(self) -> Option<Y> {
        match self {
            Self::Demand(y) => Some(y),
            Self::Hold | Self::Done => None,
        }
    }

    /// The same step with the demand converted.
    pub fn map<Z>(self, f: impl FnOnce(Y) -> Z) -> Step<Z> {
        match self {
            Self::Demand(y) => Step::Demand(f(y)),
            Self::Hold => Step::Hold,
            Self::Done => Step::Done,
        }
    }
}

/// Where a Move stands in the flow chart \[Z2\] Fig. 3.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase<C> {
    /// `i = i_0`: `f'` is due.
    First,
    /// `f_τ`, then `f''` are due, on the own state that `f'` created.
    Next(C),
    /// `f_τ` was true: `i = i_m`.
    Ended,
}

/// The Move instruction: a primitive behaviour (\[Z1\] (5), \[Z2\] (13) and Fig. 3).
///
/// `f'` in the first step; then in each step `f_τ` first, and `f''` where `f_τ` is false. So `f'`
/// is evaluated exactly once, and a Move makes at least one demand. Error conditions are not its
/// business: see [`Process`](crate::Process).
#[derive(Clone)]
pub struct Move<G, C> {
    f: G,
    phase: Phase<C>,
}

impl<G, C> Move<G, C> {
    /// `Move(f', f'', f_τ)`: at `i_0` of the generator `f`.
    pub const fn new(f: G) -> Self {
        Self {
            f,
            phase: Phase::First,
        }
    }

    /// The own state `c_c`, from the first step until the end.
    #[must_use]
    pub const fn own(&self) -> Option<&C> {
        match &self.phase {
            Phase::Next(c) => Some(c),
            Phase::First | Phase::Ended => None,
        }
    }

    /// The generator.
    #[must_use]
    pub const fn generator(&self) -> &G {
        &self.f
    }
}

impl<S, G, C> Behaviour<S> for Move<G, C>
where
    S: Subsystem,
    G: Generator<S, Own = C>,
{
    fn begin(&mut self) {
        self.phase = Phase::First;
    }

    fn step(&mut self, x: &Input<S>) -> Step<S::Command> {
        let x = X::new(x);
        match &mut self.phase {
            Phase::First => {
                let (c, y) = self.f.first(x);
                self.phase = Phase::Next(c);
                Step::Demand(y)
            }
            Phase::Next(c) if self.f.terminal(c, x) => {
                self.phase = Phase::Ended;
                Step::Done
            }
            Phase::Next(c) => Step::Demand(self.f.next(c, x)),
            Phase::Ended => Step::Done,
        }
    }
}

impl<G: fmt::Debug, C: fmt::Debug> fmt::Debug for Move<G, C> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Move")
            .field("f", &self.f)
            .field("phase", &self.phase)
            .finish()
    }
}

/// A [`Move`] whose own state lies elsewhere, in a place that is lent for each step: the same flow chart.
///
/// For own states that are too large to be copied, or that Moves which never run at once can share.
/// Not a behaviour, because its step needs the place; whoever keeps the place can make one of both.
#[derive(Clone, Copy, Debug)]
pub struct MoveIn<G> {
    f: G,
    phase: Phase<()>,
}

impl<G> MoveIn<G> {
    /// `Move(f', f'', f_τ)`: at `i_0` of the generator `f`.
    pub const fn new(f: G) -> Self {
        Self {
            f,
            phase: Phase::First,
        }
    }

    /// Whether what lies in the place is the own state of this Move: from the first step until the end.
    #[must_use]
    pub const fn runs(&self) -> bool {
        matches!(self.phase, Phase::Next(()))
    }

    /// One step; the place is the same each time, and nobody else writes there in between.
    pub fn step<S: Subsystem>(&mut self, c: &mut G::Own, x: &Input<S>) -> Step<S::Command>
    where
        G: Generator<S>,
    {
        let x = X::new(x);
        match self.phase {
            Phase::First => {
                self.phase = Phase::Next(());
                Step::Demand(self.f.first_in(c, x))
            }
            Phase::Next(()) if self.f.terminal(c, x) => {
                self.phase = Phase::Ended;
                Step::Done
            }
            Phase::Next(()) => Step::Demand(self.f.next(c, x)),
            Phase::Ended => Step::Done,
        }
    }
}

/// The Wait instruction: holds until `f_I` is true (\[Z1\] (4)). Never demands anything.
#[derive(Clone, Copy, Debug)]
pub struct Wait<P> {
    until: P,
    ended: bool,
}

impl<P> Wait<P> {
    /// `Wait(f_I)`
    pub const fn new(until: P) -> Self {
        Self {
            until,
            ended: false,
        }
    }
}

impl<S: Subsystem, P: Condition<S>> Behaviour<S> for Wait<P> {
    fn begin(&mut self) {
        self.ended = false;
    }

    fn step(&mut self, x: &Input<S>) -> Step<S::Command> {
        self.ended = self.ended || self.until.holds(X::new(x));
        if self.ended { Step::Done } else { Step::Hold }
    }
}
