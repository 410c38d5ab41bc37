//! Argument lists of transition functions, as types.
//!
//! The papers classify generators and conditions by the arguments they take. Here the list is the
//! type [`F<C0, E, V, T>`](F): each slot holds its symbol if the function reads it and `()` if it
//! does not. The own state (`c_j` for an ECP, `c_0` for the MP) is always an argument and
//! therefore has no slot: it is what a [`Generator`](crate::Generator) keeps in `Own`.
//!
//! ```
//! use agent::args::{Args, C0, E, F, T, V};
//!
//! assert_eq!(<F<(), E, ()> as Args>::CLASS, Some(2)); //   f^2(c_j, e_j)
//! assert_eq!(<F<C0, E, V> as Args>::CLASS, Some(7)); //    f^7(c_0, c_j, e_j, v_j)
//! assert!(<F<(), (), (), T> as Args>::TRANSMISSIONS); //   f^0(c_j, T_j)
//! ```
//!
//! Source: \[Z1\] §VI and §VII. The transmissions between agents come from \[Z2\] (7); they have a
//! slot of their own, so that `c_0` stays what the coordinator says and `T` what other agents say.

use core::marker::PhantomData;

/// The symbol `c_0`: what the coordinator said to this executor.
#[derive(Clone, Copy, Debug)]
pub enum C0 {}

/// The symbol `e`: the input image of the effector, or on the MP level of all effectors.
#[derive(Clone, Copy, Debug)]
pub enum E {}

/// The symbol `v`: the input images of the bundle of virtual sensors.
#[derive(Clone, Copy, Debug)]
pub enum V {}

/// The symbol `T`: what other agents transmitted directly.
#[derive(Clone, Copy, Debug)]
pub enum T {}

/// The argument list `f(c_0, e, v, T)`; a slot is its symbol, or `()` where it is not read.
///
/// `C` is [`C0`] or `()`, `O` is [`E`] or `()`, `R` is [`V`] or `()`, `M` is [`T`] or `()`.
/// Never constructed: it exists as a type only.
#[derive(Debug)]
pub struct F<C, O, R, M = ()>(PhantomData<(C, O, R, M)>);

/// The argument list of `f**() = const`, the fifth class of the MP's generators.
///
/// Nothing can be read through it, and a generator of this class owns no state: without `c_0`
/// there are no resources to compute with (\[Z1\] §VI).
#[derive(Debug)]
pub struct Const(PhantomData<()>);

mod sealed {
    pub trait Sealed {}
    impl<C, O, R, M> Sealed for super::F<C, O, R, M> {}
    impl Sealed for super::Const {}
    impl Sealed for super::Coordinator {}
    impl Sealed for super::Executor {}
}
use sealed::Sealed;

/// What may stand in the slot of the symbol `S`: `S` itself, or `()`.
#[diagnostic::on_unimplemented(
    message = "`{Self}` cannot stand in the slot of `{S}`",
    label = "write `{S}` if the function reads it, `()` if it does not",
    note = "the slots of an argument list are, in this order, `F<C0, E, V, T>`"
)]
pub trait Slot<S> {
    /// Is the symbol read?
    const READ: bool;
    /// Read by this list or by the other one.
    type Or<O: Slot<S>>: Slot<S>;
}

impl<S> Slot<S> for () {
    const READ: bool = false;
    type Or<O: Slot<S>> = O;
}

macro_rules! slots {
    ($($symbol:ident),+) => { $(
        impl Slot<$symbol> for $symbol {
            const READ: bool = true;
            type Or<O: Slot<$symbol>> = $symbol;
        }
    )+ };
}
slots!(C0, E, V, T);

/// An argument list: [`F`] or [`Const`].
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not an argument list",
    label = "write `F<C0, E, V>` with `()` in the place of every symbol that is not read"
)]
pub trait Args: Sealed {
    /// The superscript `q` of `f^q`: `4·[c_0] + 2·[e] + [v]`; `None` for `f**`.
    const CLASS: Option<u8>;
    /// Are the transmissions of other agents read? They do not enter `q`.
    const TRANSMISSIONS: bool;
}

impl<C: Slot<C0>, O: Slot<E>, R: Slot<V>, M: Slot<T>> Args for F<C, O, R, M> {
    const CLASS: Option<u8> = Some((C::READ as u8) << 2 | (O::READ as u8) << 1 | (R::READ as u8));
    const TRANSMISSIONS: bool = M::READ;
}

impl Args for Const {
    const CLASS: Option<u8> = None;
    const TRANSMISSIONS: bool = false;
}

/// The union of two argument lists: the class of what is composed of both.
pub trait Union<B> {
    /// `Self ∪ B`
    type Of: Args;
}

impl<C, O, R, M, C2, O2, R2, M2> Union<F<C2, O2, R2, M2>> for F<C, O, R, M>
where
    C: Slot<C0>,
    O: Slot<E>,
    R: Slot<V>,
    M: Slot<T>,
    C2: Slot<C0>,
    O2: Slot<E>,
    R2: Slot<V>,
    M2: Slot<T>,
{
    type Of = F<C::Or<C2>, O::Or<O2>, R::Or<R2>, M::Or<M2>>;
}

/// `Self` lists the symbol `S` among its arguments.
#[diagnostic::on_unimplemented(
    message = "this transition function reads `{S}` without declaring it",
    label = "`{S}` is not in its argument list `{Self}`",
    note = "the class of a generator or condition is its argument list: put `{S}` into its slot of `type Args = F<C0, E, V, T>`, or do not read it"
)]
pub trait Reads<S> {}
impl<O, R, M> Reads<C0> for F<C0, O, R, M> {}
impl<C, R, M> Reads<E> for F<C, E, R, M> {}
impl<C, O, M> Reads<V> for F<C, O, V, M> {}
impl<C, O, R> Reads<T> for F<C, O, R, T> {}

/// The two roles of a control subsystem, as values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Role {
    /// The Master Process, `C_0`.
    Mp,
    /// An Effector Control Process, `C_j`, j ≥ 1.
    Ecp,
}

/// A level of control: [`Coordinator`] or [`Executor`].
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a level of control",
    label = "write `args::Coordinator` (an MP) or `args::Executor` (an ECP)"
)]
pub trait Level: Sealed {
    /// The level as a value.
    const ROLE: Role;
}

/// The level of the MP: `c_0` is its own state and never an argument from elsewhere.
#[derive(Clone, Copy, Debug)]
pub enum Coordinator {}
impl Level for Coordinator {
    const ROLE: Role = Role::Mp;
}

/// The level of an ECP: `c_0` comes from the MP.
#[derive(Clone, Copy, Debug)]
pub enum Executor {}
impl Level for Executor {
    const ROLE: Role = Role::Ecp;
}

/// The list exists on the level `L`: 4 lists for the MP, 8 for an ECP, each with or without `T`.
///
/// These are the classes of conditions (\[Z1\] §VII).
#[diagnostic::on_unimplemented(
    message = "there is no class `{Self}` of conditions on the level `{L}`",
    label = "not an argument list of this level",
    note = "on the MP level `c_0` is the own state: it is no argument, and `C0` must be `()`"
)]
pub trait On<L>: Args {}
impl<C: Slot<C0>, O: Slot<E>, R: Slot<V>, M: Slot<T>> On<Executor> for F<C, O, R, M> {}
impl<O: Slot<E>, R: Slot<V>, M: Slot<T>> On<Coordinator> for F<(), O, R, M> {}

/// A generator with this list and the own state `Own` exists on the level `L`.
///
/// These are the classes of generators (\[Z1\] §VI): those of [`On`], and on the MP level `f**`,
/// which owns nothing.
#[diagnostic::on_unimplemented(
    message = "there is no class `{Self}` of generators with the own state `{Own}` on the level `{L}`",
    label = "not an argument list of this level",
    note = "on the MP level `c_0` is the own state: it is no argument, and `C0` must be `()`",
    note = "`Const` is the class of `f**() = const`: MP only, and without own state"
)]
pub trait Generates<L, Own>: Args {}
impl<C: Slot<C0>, O: Slot<E>, R: Slot<V>, M: Slot<T>, Own> Generates<Executor, Own>
    for F<C, O, R, M>
{
}
impl<O: Slot<E>, R: Slot<V>, M: Slot<T>, Own> Generates<Coordinator, Own> for F<(), O, R, M> {}
impl Generates<Coordinator, ()> for Const {}
