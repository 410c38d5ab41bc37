//! `f^6(c_0, c_j, e_j)`: the tool along a path that the coordinator streams, at the feed rate it says.

use crate::ecp::tool_motion::ToolMotion;
use crate::ecp::tool_path::ToolPath;
use crate::ecp::{Coordinator, Demand, EcpOf};
use agent::args::{C0, E, F};
use agent::{Generator, X};
use protocol::fault::Refusal;
use robots::Robot;

/// Move the tool along a streamed path, of which W samples are looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathMove<R, const N: usize, const W: usize>(pub ToolMotion<R, N>);

impl<R: Robot<N>, const N: usize, const W: usize> PathMove<R, N, W> {
    fn demand(&self, path: &mut ToolPath<N, W>, c0: &Coordinator) -> Demand<N> {
        for (number, element) in &c0.path {
            path.take(*number, element);
        }
        let share = if c0.end_motion { 0.0 } else { c0.feed_override };
        path.step(&self.0, share)
    }
}

impl<R: Robot<N>, const N: usize, const W: usize> Generator<EcpOf<N>> for PathMove<R, N, W> {
    type Own = ToolPath<N, W>;
    type Args = F<C0, E, ()>;

    fn first(&self, x: X<'_, EcpOf<N>, Self::Args>) -> (Self::Own, Demand<N>) {
        let mut path = ToolPath::new();
        let y = self.first_in(&mut path, x);
        (path, y)
    }

    fn first_in(&self, path: &mut Self::Own, x: X<'_, EcpOf<N>, Self::Args>) -> Demand<N> {
        match x.e().demanded_joints {
            Some(from) => {
                // one that cannot be refuses each of its steps
                let _ = path.begin(&self.0, &from);
            }
            None => path.refuse_all(Refusal::NotSynchronised),
        }
        self.demand(path, x.c0())
    }

    fn next(&self, path: &mut Self::Own, x: X<'_, EcpOf<N>, Self::Args>) -> Demand<N> {
        self.demand(path, x.c0())
    }

    fn terminal(&self, path: &Self::Own, x: X<'_, EcpOf<N>, Self::Args>) -> bool {
        path.done() || x.c0().end_motion && path.rests()
    }
}
