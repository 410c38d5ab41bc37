//! Motion generators: the triple `(f', f'', f_τ)` over one argument list.

use core::fmt;
use core::marker::PhantomData;

use crate::args::{Const, Coordinator, Generates};
use crate::subsystem::{Subsystem, X};

/// A motion generator: `f'`, `f''` and `f_τ` (\[Z2\] Fig. 3) over one argument list.
///
/// `self` is the function: its parameters, never written while it runs, so they may lie in flash.
/// `c` is the part of the own state `c_c` that the function evolves; `f'` creates it. One call
/// is one evaluation of \[Z2\] (7): the new `c_c` and all outputs together. With \[Z1\] (5), (6) the
/// demanded effector state is `e^{i+1} = f*(c^i, e^i, v^i)`; `f_τ` is `f_T` of \[Z1\] (5) and has
/// the same arguments by construction (\[Z1\] §VII).
///
/// What has to outlive one Move, such as a map that grows from motion to motion, is a variable of
/// the program: it lends a `&Cell<…>` to the generators and conditions that share it.
///
/// A reference to a generator is one, so `&'static G`; with the feature `alloc`, so is `Box<G>`.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a motion generator of the subsystem `{S}`",
    label = "needs `first`, `next` and `terminal`: f', f'' and f_τ"
)]
pub trait Generator<S: Subsystem> {
    /// The own state `c_c` between the steps of one run; `()` if there is none.
    type Own;
    /// The argument list, and by it the class.
    type Args: Generates<S::Level, Self::Own>;

    /// `f'`: the first step. Creates the own state and makes the first demand.
    fn first(&self, x: X<'_, S, Self::Args>) -> (Self::Own, S::Command);

    /// The same where the own state has a place already, of which nothing is read.
    ///
    /// For an own state that is too large to be handed over by value: what is lent is made to be what
    /// [`first`](Self::first) would create. [`MoveIn`](crate::MoveIn) asks for this one.
    fn first_in(&self, c: &mut Self::Own, x: X<'_, S, Self::Args>) -> S::Command {
        let (created, y) = self.first(x);
        *c = created;
        y
    }

    /// `f''`: every other step. Evolves the own state and makes the next demand.
    fn next(&self, c: &mut Self::Own, x: X<'_, S, Self::Args>) -> S::Command;

    /// `f_τ`: has the motion reached its terminal state? Asked before every `f''`, never before
    /// `f'`.
    fn terminal(&self, c: &Self::Own, x: X<'_, S, Self::Args>) -> bool;
}

macro_rules! pointer {
    ($(#[$cfg:meta])? $Pointer:ty) => {
        $(#[$cfg])?
        impl<S: Subsystem, G: Generator<S> + ?Sized> Generator<S> for $Pointer {
            type Own = G::Own;
            type Args = G::Args;

            fn first(&self, x: X<'_, S, G::Args>) -> (G::Own, S::Command) {
                (**self).first(x)
            }

            fn first_in(&self, c: &mut G::Own, x: X<'_, S, G::Args>) -> S::Command {
                (**self).first_in(c, x)
            }

            fn next(&self, c: &mut G::Own, x: X<'_, S, G::Args>) -> S::Command {
                (**self).next(c, x)
            }

            fn terminal(&self, c: &G::Own, x: X<'_, S, G::Args>) -> bool {
                (**self).terminal(c, x)
            }
        }
    };
}
pointer!(&G);
pointer!(#[cfg(feature = "alloc")] alloc::boxed::Box<G>);

/// `f**() = const`: tells the ECPs to begin their own programs. MP only (\[Z1\] §VI).
///
/// Moves one step: the constant is sent once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Constant<Y>(pub Y);

impl<S> Generator<S> for Constant<S::Command>
where
    S: Subsystem<Level = Coordinator>,
    S::Command: Clone,
{
    type Own = ();
    type Args = Const;

    fn first(&self, _: X<'_, S, Const>) -> ((), S::Command) {
        ((), self.0.clone())
    }

    fn next(&self, (): &mut (), _: X<'_, S, Const>) -> S::Command {
        self.0.clone()
    }

    fn terminal(&self, (): &(), _: X<'_, S, Const>) -> bool {
        true
    }
}

/// A generator of three closures, with the argument list `A` and the own state `C`.
///
/// Made by [`generator`].
pub struct Triple<A, C, First, Next, Terminal> {
    first: First,
    next: Next,
    terminal: Terminal,
    list: PhantomData<fn() -> (A, C)>,
}

/// A generator of the closures `f'`, `f''` and `f_τ`.
///
/// ```
/// # use agent::{args::{self, E, F}, generator, Behaviour, Input, Move, Step, Subsystem};
/// # struct Axis;
/// # impl Subsystem for Axis {
/// #     type Level = args::Executor;
/// #     type Coordination = ();
/// #     type Effector = f64;
/// #     type Sensors = ();
/// #     type Transmissions = ();
/// #     type Command = f64;
/// # }
/// // f^2(c_j, e_j): three steps of 0.1 rad from wherever the axis stands
/// let mut by_offset = Move::new(generator::<Axis, F<(), E, ()>, _, _, _, _>(
///     |x| ((1, *x.e()), x.e() + 0.1),
///     |(n, from), _| {
///         *n += 1;
///         *from + 0.1 * f64::from(*n)
///     },
///     |(n, _), _| *n >= 3,
/// ));
/// let x = Input::<Axis> { i: 0, c0: (), e: 1.0, v: (), t: () };
/// assert_eq!(by_offset.step(&x), Step::Demand(1.1));
/// ```
pub const fn generator<S, A, C, First, Next, Terminal>(
    first: First,
    next: Next,
    terminal: Terminal,
) -> Triple<A, C, First, Next, Terminal>
where
    S: Subsystem,
    A: Generates<S::Level, C>,
    First: Fn(X<'_, S, A>) -> (C, S::Command),
    Next: Fn(&mut C, X<'_, S, A>) -> S::Command,
    Terminal: Fn(&C, X<'_, S, A>) -> bool,
{
    Triple {
        first,
        next,
        terminal,
        list: PhantomData,
    }
}

impl<S, A, C, First, Next, Terminal> Generator<S> for Triple<A, C, First, Next, Terminal>
where
    S: Subsystem,
    A: Generates<S::Level, C>,
    First: Fn(X<'_, S, A>) -> (C, S::Command),
    Next: Fn(&mut C, X<'_, S, A>) -> S::Command,
    Terminal: Fn(&C, X<'_, S, A>) -> bool,
{
    type Own = C;
    type Args = A;

    fn first(&self, x: X<'_, S, A>) -> (C, S::Command) {
        (self.first)(x)
    }

    fn next(&self, c: &mut C, x: X<'_, S, A>) -> S::Command {
        (self.next)(c, x)
    }

    fn terminal(&self, c: &C, x: X<'_, S, A>) -> bool {
        (self.terminal)(c, x)
    }
}

impl<A, C, First, Next, Terminal> fmt::Debug for Triple<A, C, First, Next, Terminal> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Triple(f', f'', f_τ)")
    }
}
