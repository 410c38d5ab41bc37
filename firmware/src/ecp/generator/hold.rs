//! `f^0(c_j)`: stay for a number of macrosteps.

use crate::ecp::{Demand, EcpOf};
use agent::args::F;
use agent::{Generator, X};

/// Stay for a number of macrosteps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hold {
    /// How many macrosteps.
    pub macrosteps: u32,
}

impl<const N: usize> Generator<EcpOf<N>> for Hold {
    type Own = u32;
    type Args = F<(), (), ()>;

    fn first(&self, _: X<'_, EcpOf<N>, Self::Args>) -> (u32, Demand<N>) {
        (1, Demand::Stay)
    }

    fn next(&self, i: &mut u32, _: X<'_, EcpOf<N>, Self::Args>) -> Demand<N> {
        *i = i.saturating_add(1);
        Demand::Stay
    }

    fn terminal(&self, i: &u32, _: X<'_, EcpOf<N>, Self::Args>) -> bool {
        *i >= self.macrosteps
    }
}
