//! Any generator, ended early by a condition; its class is the union of both classes.
//!
//! This is how the classes that read `v_j` come about: a blind motion guarded by a sensor. With
//! `Hold` and [`Contact`](crate::ecp::condition::Contact) it is `f^1(c_j, v_j)`, with a joint move
//! `f^3(c_j, e_j, v_j)`, with `Follow` `f^5(c_0, c_j, v_j)`.

use agent::args::{Generates, Union};
use agent::{Condition, Generator, Subsystem, X};

/// `f` until its own end or until `until` holds, whichever comes first.
///
/// The arm is then demanded to stay: where the guarded motion is not at rest, the EDP brings it to
/// rest within the limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Guarded<G, P> {
    /// The motion.
    pub motion: G,
    /// The guard.
    pub until: P,
}

/// The union of two argument lists.
type Joint<A, B> = <A as Union<B>>::Of;

impl<S, G, P> Generator<S> for Guarded<G, P>
where
    S: Subsystem,
    G: Generator<S>,
    P: Condition<S>,
    G::Args: Union<P::Args>,
    Joint<G::Args, P::Args>: Generates<S::Level, G::Own>
        + Union<G::Args, Of = Joint<G::Args, P::Args>>
        + Union<P::Args, Of = Joint<G::Args, P::Args>>,
{
    type Own = G::Own;
    type Args = Joint<G::Args, P::Args>;

    fn first(&self, x: X<'_, S, Self::Args>) -> (G::Own, S::Command) {
        self.motion.first(x.narrow())
    }

    fn first_in(&self, c: &mut G::Own, x: X<'_, S, Self::Args>) -> S::Command {
        self.motion.first_in(c, x.narrow())
    }

    fn next(&self, c: &mut G::Own, x: X<'_, S, Self::Args>) -> S::Command {
        self.motion.next(c, x.narrow())
    }

    fn terminal(&self, c: &G::Own, x: X<'_, S, Self::Args>) -> bool {
        self.until.holds(x.narrow()) || self.motion.terminal(c, x.narrow())
    }
}
