//! Error conditions `f_E`: what ends any instruction, and wins over everything else.

use core::convert::Infallible;
use core::fmt;

use crate::condition::Or;
use crate::subsystem::Subsystem;

/// The error condition `f_E(c, e, r)` of \[Z1\] (4), (5).
///
/// Reads `r` and not `v`: malfunctions are looked for in the receptors themselves (\[Z1\] §III).
/// `C` is what the control subsystem tells of itself, its interoceptors (\[Z2\] §2): counters,
/// failed computations, deadlines; `R` are the receptors. The whole `f_E` is the *disjunction* of
/// all error situations: compose them with [`Or`].
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not an error condition of the subsystem `{S}`",
    label = "needs `check`; from a closure, use `agent::Check`, and `agent::NoError` if there is none"
)]
pub trait ErrorCondition<S: Subsystem, C: ?Sized, R: ?Sized> {
    /// What is wrong.
    type Fault;

    /// Is everything in order?
    ///
    /// # Errors
    /// The first error situation found: `f_E = true`.
    fn check(&self, c: &C, e: &S::Effector, r: &R) -> Result<(), Self::Fault>;
}

macro_rules! pointer {
    ($(#[$cfg:meta])? $Pointer:ty) => {
        $(#[$cfg])?
        impl<S, C, R, Q> ErrorCondition<S, C, R> for $Pointer
        where
            S: Subsystem,
            C: ?Sized,
            R: ?Sized,
            Q: ErrorCondition<S, C, R> + ?Sized,
        {
            type Fault = Q::Fault;

            fn check(&self, c: &C, e: &S::Effector, r: &R) -> Result<(), Q::Fault> {
                (**self).check(c, e, r)
            }
        }
    };
}
pointer!(&Q);
pointer!(#[cfg(feature = "alloc")] alloc::boxed::Box<Q>);

impl<S, C, R, P, Q> ErrorCondition<S, C, R> for Or<P, Q>
where
    S: Subsystem,
    C: ?Sized,
    R: ?Sized,
    P: ErrorCondition<S, C, R>,
    Q: ErrorCondition<S, C, R, Fault = P::Fault>,
{
    type Fault = P::Fault;

    fn check(&self, c: &C, e: &S::Effector, r: &R) -> Result<(), P::Fault> {
        self.0.check(c, e, r)?;
        self.1.check(c, e, r)
    }
}

/// `f_E` without an error situation: a process that cannot fail.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NoError;

impl<S: Subsystem, C: ?Sized, R: ?Sized> ErrorCondition<S, C, R> for NoError {
    type Fault = Infallible;

    fn check(&self, _: &C, _: &S::Effector, _: &R) -> Result<(), Infallible> {
        Ok(())
    }
}

/// `f_E` of a closure `|c, e, r| -> Result<(), Fault>`.
#[derive(Clone, Copy)]
pub struct Check<F>(pub F);

impl<S, C, R, F, Fault> ErrorCondition<S, C, R> for Check<F>
where
    S: Subsystem,
    C: ?Sized,
    R: ?Sized,
    F: Fn(&C, &S::Effector, &R) -> Result<(), Fault>,
{
    type Fault = Fault;

    fn check(&self, c: &C, e: &S::Effector, r: &R) -> Result<(), Fault> {
        (self.0)(c, e, r)
    }
}

impl<F> fmt::Debug for Check<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Check(f_E)")
    }
}
