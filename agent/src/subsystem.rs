//! A control subsystem, what it perceives, and what it may see of it.

use core::fmt;
use core::marker::PhantomData;

use crate::args::{Args, C0, E, Level, On, Reads, T, Union, V};

/// A control subsystem `C`: the coordinator `C_0` or an executor `C_j`.
///
/// Only names types; never constructed by this crate. What the subsystem perceives is
/// [`Input`] (`xC`, \[Z2\] (5)), what it commands is `Command` (`yC`, \[Z2\] (6)).
pub trait Subsystem {
    /// [`Coordinator`](crate::args::Coordinator) for an MP,
    /// [`Executor`](crate::args::Executor) for an ECP.
    type Level: Level;
    /// `c_0` as received from the coordinator; `()` on the MP level.
    type Coordination;
    /// `xc_e`: the image of the effector; on the MP level the list of all images.
    type Effector;
    /// `xc_V`: the images of the bundle of virtual sensors, one field per sensor.
    type Sensors;
    /// `xc_T`: what other agents transmitted; `()` where agents do not talk directly.
    type Transmissions;
    /// `yC`: what the subsystem demands by the next instant, see [`Command`].
    type Command;
}

/// The three outputs of a subsystem, `yC = ⟨yc_e, yc_V, yc_T⟩`. \[Z2\] (6).
///
/// The value of [`Subsystem::Command`] where sensors are configured or agents talk to each other;
/// a subsystem that only moves its effector uses the type of `e` itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Command<Effector, Sensors = (), Transmissions = ()> {
    /// `yc_e`: the effector state demanded for the instant `i + 1`.
    pub e: Effector,
    /// `yc_V`: configuration of the virtual sensors.
    pub v: Sensors,
    /// `yc_T`: what is transmitted to other agents.
    pub t: Transmissions,
}

/// The input `xC = ⟨xc_e, xc_V, xc_T⟩` of a subsystem at the instant `i`, with `c_0`. \[Z2\] (5).
pub struct Input<S: Subsystem> {
    /// `i`: the instant, counted in steps of this subsystem; wraps.
    pub i: u32,
    /// `c_0`: what the coordinator says.
    pub c0: S::Coordination,
    /// `xc_e`: the effector as perceived at `i`.
    pub e: S::Effector,
    /// `xc_V`: the virtual sensors as perceived at `i`.
    pub v: S::Sensors,
    /// `xc_T`: what other agents said until `i`.
    pub t: S::Transmissions,
}

impl<S: Subsystem> Input<S> {
    /// The view of a function with the argument list `A`.
    #[must_use]
    pub const fn seen_by<A: On<S::Level>>(&self) -> X<'_, S, A> {
        X::new(self)
    }
}

impl<S: Subsystem> Clone for Input<S>
where
    S::Coordination: Clone,
    S::Effector: Clone,
    S::Sensors: Clone,
    S::Transmissions: Clone,
{
    fn clone(&self) -> Self {
        Self {
            i: self.i,
            c0: self.c0.clone(),
            e: self.e.clone(),
            v: self.v.clone(),
            t: self.t.clone(),
        }
    }
}

impl<S: Subsystem> PartialEq for Input<S>
where
    S::Coordination: PartialEq,
    S::Effector: PartialEq,
    S::Sensors: PartialEq,
    S::Transmissions: PartialEq,
{
    fn eq(&self, other: &Self) -> bool {
        self.i == other.i
            && self.c0 == other.c0
            && self.e == other.e
            && self.v == other.v
            && self.t == other.t
    }
}

impl<S: Subsystem> fmt::Debug for Input<S>
where
    S::Coordination: fmt::Debug,
    S::Effector: fmt::Debug,
    S::Sensors: fmt::Debug,
    S::Transmissions: fmt::Debug,
{
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Input")
            .field("i", &self.i)
            .field("c0", &self.c0)
            .field("e", &self.e)
            .field("v", &self.v)
            .field("t", &self.t)
            .finish()
    }
}

/// `xC` seen through the argument list `A`: what `A` does not list cannot be read.
///
/// A view lives within one step: nothing read through it can be kept by reference, because the
/// images of `i` are gone at `i + 1`.
pub struct X<'i, S: Subsystem, A> {
    input: &'i Input<S>,
    list: PhantomData<fn() -> A>,
}

impl<'i, S: Subsystem, A> X<'i, S, A> {
    pub(crate) const fn new(input: &'i Input<S>) -> Self {
        Self {
            input,
            list: PhantomData,
        }
    }

    /// The same instant through another list; unchecked, so private to the combinators.
    pub(crate) const fn relist<B>(self) -> X<'i, S, B> {
        X::new(self.input)
    }

    /// The instant `i`. Every function may know it: counting steps is part of its own state.
    #[must_use]
    pub const fn i(self) -> u32 {
        self.input.i
    }

    /// `c_0`: what the coordinator says.
    #[must_use]
    pub const fn c0(self) -> &'i S::Coordination
    where
        A: Reads<C0>,
    {
        &self.input.c0
    }

    /// `e`: the effector as perceived.
    #[must_use]
    pub const fn e(self) -> &'i S::Effector
    where
        A: Reads<E>,
    {
        &self.input.e
    }

    /// `v`: the virtual sensors as perceived.
    #[must_use]
    pub const fn v(self) -> &'i S::Sensors
    where
        A: Reads<V>,
    {
        &self.input.v
    }

    /// `T`: what other agents said.
    #[must_use]
    pub const fn t(self) -> &'i S::Transmissions
    where
        A: Reads<T>,
    {
        &self.input.t
    }

    /// The view through a list `B` that is part of `A`, for functions built of functions.
    #[must_use]
    pub const fn narrow<B: Args>(self) -> X<'i, S, B>
    where
        A: Union<B, Of = A>,
    {
        self.relist()
    }
}

impl<S: Subsystem, A> Clone for X<'_, S, A> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<S: Subsystem, A> Copy for X<'_, S, A> {}

impl<S: Subsystem, A> fmt::Debug for X<'_, S, A> {
    /// The instant only: what `A` hides stays hidden.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("X")
            .field("i", &self.input.i)
            .finish_non_exhaustive()
    }
}
