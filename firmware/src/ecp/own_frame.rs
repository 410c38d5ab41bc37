//! Steps of behaviours, each in a frame of its own on the stack.

use agent::{Behaviour, Generator, Input, MoveIn, Step, Subsystem};

/// One step, in a frame of its own on the stack: that of the deepest behaviour is not below those of all others.
#[inline(never)]
pub(super) fn one_step<S: Subsystem>(b: &mut impl Behaviour<S>, x: &Input<S>) -> Step<S::Command> {
    b.step(x)
}

/// The same of a Move in a lent place.
#[inline(never)]
pub(super) fn one_step_in<S: Subsystem, G: Generator<S>>(
    b: &mut MoveIn<G>,
    c: &mut G::Own,
    x: &Input<S>,
) -> Step<S::Command> {
    b.step(c, x)
}
