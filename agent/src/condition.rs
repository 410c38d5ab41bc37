//! Conditions: `f_I` of a Wait, and the predicates `p` of reactions.

use core::fmt;
use core::marker::PhantomData;

use crate::args::{F, On, Union};
use crate::subsystem::{Subsystem, X};

/// A Boolean function of the state: `f_I` of \[Z1\] (4), or a predicate `p` of \[Z2\] (11), (14).
///
/// Pure: it reads `self` and the view, and decides. A reference to a condition is one; with the
/// feature `alloc`, so is a `Box`. Composed with [`And`], [`Or`], [`Not`]; the class of the whole is the union of the classes.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a condition of the subsystem `{S}`",
    label = "needs `holds`; from a closure, use `agent::condition`"
)]
pub trait Condition<S: Subsystem> {
    /// The argument list, and by it the class.
    type Args: On<S::Level>;

    /// Does it hold at the instant of `x`?
    fn holds(&self, x: X<'_, S, Self::Args>) -> bool;
}

macro_rules! pointer {
    ($(#[$cfg:meta])? $Pointer:ty) => {
        $(#[$cfg])?
        impl<S: Subsystem, P: Condition<S> + ?Sized> Condition<S> for $Pointer {
            type Args = P::Args;

            fn holds(&self, x: X<'_, S, P::Args>) -> bool {
                (**self).holds(x)
            }
        }
    };
}
pointer!(&P);
pointer!(#[cfg(feature = "alloc")] alloc::boxed::Box<P>);

/// Conjunction: both hold. Its list is the union of the lists.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct And<P, Q>(pub P, pub Q);

/// Disjunction: at least one holds. Its list is the union of the lists.
///
/// Of two error conditions: the first fault found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Or<P, Q>(pub P, pub Q);

/// Negation, with the same list.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Not<P>(pub P);

impl<S, P, Q, A> Condition<S> for And<P, Q>
where
    S: Subsystem,
    P: Condition<S>,
    Q: Condition<S>,
    P::Args: Union<Q::Args, Of = A>,
    A: On<S::Level>,
{
    type Args = A;

    fn holds(&self, x: X<'_, S, A>) -> bool {
        self.0.holds(x.relist()) && self.1.holds(x.relist())
    }
}

impl<S, P, Q, A> Condition<S> for Or<P, Q>
where
    S: Subsystem,
    P: Condition<S>,
    Q: Condition<S>,
    P::Args: Union<Q::Args, Of = A>,
    A: On<S::Level>,
{
    type Args = A;

    fn holds(&self, x: X<'_, S, A>) -> bool {
        self.0.holds(x.relist()) || self.1.holds(x.relist())
    }
}

impl<S: Subsystem, P: Condition<S>> Condition<S> for Not<P> {
    type Args = P::Args;

    fn holds(&self, x: X<'_, S, P::Args>) -> bool {
        !self.0.holds(x)
    }
}

/// Holds in every state; the predicate of a main reaction (\[Z2\] (15)).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Always;

/// Holds in no state: a Wait that only an error ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Never;

impl<S: Subsystem> Condition<S> for Always
where
    F<(), (), ()>: On<S::Level>,
{
    type Args = F<(), (), ()>;

    fn holds(&self, _: X<'_, S, Self::Args>) -> bool {
        true
    }
}

impl<S: Subsystem> Condition<S> for Never
where
    F<(), (), ()>: On<S::Level>,
{
    type Args = F<(), (), ()>;

    fn holds(&self, _: X<'_, S, Self::Args>) -> bool {
        false
    }
}

/// The same condition under a longer list, so that conditions of several classes become one type
/// (`&dyn Condition<S, Args = A>`). Made by [`widen`].
pub struct Widen<A, P> {
    condition: P,
    list: PhantomData<fn() -> A>,
}

/// `condition` under the longer argument list `A`.
pub const fn widen<A, P>(condition: P) -> Widen<A, P> {
    Widen {
        condition,
        list: PhantomData,
    }
}

impl<S, A, P> Condition<S> for Widen<A, P>
where
    S: Subsystem,
    P: Condition<S>,
    A: On<S::Level> + Union<P::Args, Of = A>,
{
    type Args = A;

    fn holds(&self, x: X<'_, S, A>) -> bool {
        self.condition.holds(x.relist())
    }
}

impl<A, P: fmt::Debug> fmt::Debug for Widen<A, P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Widen").field(&self.condition).finish()
    }
}

/// A closure with a declared argument list: a condition, a stimulus or a transition function.
///
/// Made by [`condition`], [`stimulus`](crate::stimulus) and [`function`](crate::function).
pub struct Pure<A, P> {
    pub(crate) of: P,
    list: PhantomData<fn() -> A>,
}

impl<A, P> Pure<A, P> {
    pub(crate) const fn new(of: P) -> Self {
        Self {
            of,
            list: PhantomData,
        }
    }
}

impl<A, P> fmt::Debug for Pure<A, P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Pure(f)")
    }
}

impl<A, P: Clone> Clone for Pure<A, P> {
    fn clone(&self) -> Self {
        Self::new(self.of.clone())
    }
}

/// A condition of a closure.
///
/// ```
/// # use agent::{args::{self, F, V}, condition, Behaviour, Input, Step, Subsystem, Wait};
/// # struct Axis;
/// # impl Subsystem for Axis {
/// #     type Level = args::Executor;
/// #     type Coordination = ();
/// #     type Effector = f64;
/// #     type Sensors = f64;
/// #     type Transmissions = ();
/// #     type Command = f64;
/// # }
/// // f_I^1(c_j, v_j)
/// let mut wait = Wait::new(condition::<Axis, F<(), (), V>, _>(|x| *x.v() > 5.0));
/// let x = Input::<Axis> { i: 0, c0: (), e: 0.0, v: 7.5, t: () };
/// assert_eq!(wait.step(&x), Step::Done);
/// ```
pub const fn condition<S, A, P>(holds: P) -> Pure<A, P>
where
    S: Subsystem,
    A: On<S::Level>,
    P: Fn(X<'_, S, A>) -> bool,
{
    Pure::new(holds)
}

impl<S, A, P> Condition<S> for Pure<A, P>
where
    S: Subsystem,
    A: On<S::Level>,
    P: Fn(X<'_, S, A>) -> bool,
{
    type Args = A;

    fn holds(&self, x: X<'_, S, A>) -> bool {
        (self.of)(x)
    }
}
