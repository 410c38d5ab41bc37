//! Behaviours: sequences of steps, and how they follow one another.

use crate::args::On;
use crate::bundle::Bundle;
use crate::condition::Pure;
use crate::instruction::Step;
use crate::subsystem::{Input, Subsystem, X};

/// A sequence of total states, produced one step at a time (\[Z2\] (13)).
///
/// [`Move`](crate::Move) and [`Wait`](crate::Wait) are the primitive ones; all others are made of
/// behaviours, so that \[Z2\] (13) with (15) is the recursive definition the paper gives.
///
/// # Contract
/// - A new behaviour stands at `i_0`, as after [`begin`](Self::begin).
/// - [`step`](Self::step) is called once per instant. It performs no I/O, and allocates nothing.
/// - Once it returned [`Step::Done`], it returns that until `begin`.
///
/// `&mut dyn Behaviour<S>` is a behaviour; with the feature `alloc`, so is `Box<dyn Behaviour<S>>`.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a behaviour of the subsystem `{S}`",
    label = "not a behaviour: a generator is run by `Move::new`, a condition by `Wait::new`"
)]
pub trait Behaviour<S: Subsystem> {
    /// `i := i_0`: stand before the first step again.
    fn begin(&mut self);

    /// One step: from the input at `i` to the demand for `i + 1`.
    fn step(&mut self, x: &Input<S>) -> Step<S::Command>;
}

macro_rules! pointer {
    ($(#[$cfg:meta])? $Pointer:ty) => {
        $(#[$cfg])?
        impl<S: Subsystem, B: Behaviour<S> + ?Sized> Behaviour<S> for $Pointer {
            fn begin(&mut self) {
                (**self).begin();
            }

            fn step(&mut self, x: &Input<S>) -> Step<S::Command> {
                (**self).step(x)
            }
        }
    };
}
pointer!(&mut B);
pointer!(#[cfg(feature = "alloc")] alloc::boxed::Box<B>);

/// Holds for ever.
///
/// With [`ForSteps`] a pause, in [`Select`](crate::Select) a main reaction that does nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rest;

impl<S: Subsystem> Behaviour<S> for Rest {
    fn begin(&mut self) {}

    fn step(&mut self, _: &Input<S>) -> Step<S::Command> {
        Step::Hold
    }
}

/// A partial transition function `^m f_c` of a closure: one demand in each step, without end.
///
/// Stateless, so purely reactive; the functions of \[Z2\] (10) that (12) and (18) choose among.
pub const fn function<S, A, P>(of: P) -> Pure<A, P>
where
    S: Subsystem,
    A: On<S::Level>,
    P: Fn(X<'_, S, A>) -> S::Command,
{
    Pure::new(of)
}

impl<S, A, P> Behaviour<S> for Pure<A, P>
where
    S: Subsystem,
    A: On<S::Level>,
    P: Fn(X<'_, S, A>) -> S::Command,
{
    fn begin(&mut self) {}

    fn step(&mut self, x: &Input<S>) -> Step<S::Command> {
        Step::Demand((self.of)(X::new(x)))
    }
}

/// One behaviour, then another.
///
/// The second begins in the very step in which the first ends: no instant is lost.
#[derive(Clone, Copy, Debug)]
pub struct Then<A, B> {
    a: A,
    b: B,
    second: bool,
}

impl<A, B> Then<A, B> {
    /// `a`, then `b`
    pub const fn new(a: A, b: B) -> Self {
        Self {
            a,
            b,
            second: false,
        }
    }
}

impl<S: Subsystem, A: Behaviour<S>, B: Behaviour<S>> Behaviour<S> for Then<A, B> {
    fn begin(&mut self) {
        self.second = false;
        self.a.begin();
    }

    fn step(&mut self, x: &Input<S>) -> Step<S::Command> {
        if !self.second {
            match self.a.step(x) {
                Step::Done => {
                    self.second = true;
                    self.b.begin();
                }
                step => return step,
            }
        }
        self.b.step(x)
    }
}

/// Behaviours one after another: `Move(…); Move(…); …` of \[Z2\] (19).
///
/// The parts are a [`Bundle`]: a tuple, an array, or a [`List`](crate::List).
#[derive(Clone, Copy, Debug)]
pub struct Sequence<B> {
    parts: B,
    at: usize,
    begun: bool,
}

impl<B> Sequence<B> {
    /// The parts in their order.
    pub const fn new(parts: B) -> Self {
        Self {
            parts,
            at: 0,
            begun: false,
        }
    }

    /// The index of the part that is due, from 0.
    #[must_use]
    pub const fn at(&self) -> usize {
        self.at
    }
}

impl<S: Subsystem, B: Bundle<S>> Behaviour<S> for Sequence<B> {
    fn begin(&mut self) {
        self.at = 0;
        self.begun = false;
    }

    fn step(&mut self, x: &Input<S>) -> Step<S::Command> {
        while self.at < self.parts.count() {
            if !self.begun {
                self.parts.begin(self.at);
                self.begun = true;
            }
            match self.parts.step(self.at, x) {
                Step::Done => {
                    self.at = self.at.saturating_add(1);
                    self.begun = false;
                }
                step => return step,
            }
        }
        Step::Done
    }
}

/// A behaviour again and again.
///
/// It begins anew in the step in which it ended, but only once per instant: where it then ends
/// again at once, that step holds.
#[derive(Clone, Copy, Debug)]
pub struct Repeat<B> {
    b: B,
    times: Option<u32>,
    ended: u32,
}

impl<B> Repeat<B> {
    /// `n` times.
    pub const fn times(n: u32, b: B) -> Self {
        Self {
            b,
            times: Some(n),
            ended: 0,
        }
    }

    /// Without end.
    pub const fn forever(b: B) -> Self {
        Self {
            b,
            times: None,
            ended: 0,
        }
    }
}

impl<S: Subsystem, B: Behaviour<S>> Behaviour<S> for Repeat<B> {
    fn begin(&mut self) {
        self.ended = 0;
        self.b.begin();
    }

    fn step(&mut self, x: &Input<S>) -> Step<S::Command> {
        for _ in 0..2 {
            if self.times.is_some_and(|n| self.ended >= n) {
                return Step::Done;
            }
            match self.b.step(x) {
                Step::Done => {
                    self.ended = self.ended.saturating_add(1);
                    self.b.begin();
                }
                step => return step,
            }
        }
        if self.times.is_some_and(|n| self.ended >= n) {
            Step::Done
        } else {
            Step::Hold
        }
    }
}

/// At most `n_s` steps of a behaviour: the length of a reaction in \[Z2\] (13).
///
/// `ForSteps::new(n, Rest)` is a pause; `ForSteps::new(n, Wait::new(p))` is a wait with a limit.
#[derive(Clone, Copy, Debug)]
pub struct ForSteps<B> {
    b: B,
    n: u32,
    left: u32,
}

impl<B> ForSteps<B> {
    /// The first `n` steps of `b`.
    pub const fn new(n: u32, b: B) -> Self {
        Self { b, n, left: n }
    }
}

impl<S: Subsystem, B: Behaviour<S>> Behaviour<S> for ForSteps<B> {
    fn begin(&mut self) {
        self.left = self.n;
        self.b.begin();
    }

    fn step(&mut self, x: &Input<S>) -> Step<S::Command> {
        let Some(left) = self.left.checked_sub(1) else {
            return Step::Done;
        };
        self.left = left;
        self.b.step(x)
    }
}
