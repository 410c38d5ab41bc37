//! `f^6(c_0, c_j, e_j)`: the tool along a path that the coordinator streams, at the feed rate it says.

use crate::ecp::tool_motion::ToolMotion;
use crate::ecp::tool_path::ToolPath;
use crate::ecp::{Coordinator, Demand, EcpOf};
use agent::args::{C0, E, F};
use agent::{Generator, X};
use protocol::fault::Refusal;
use robots::Robot;

/// Move the tool along a streamed path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathMove<R, const N: usize>(pub ToolMotion<R, N>);

impl<R: Robot<N>, const N: usize> PathMove<R, N> {
    fn demand(&self, path: &mut Result<ToolPath<N>, Refusal>, c0: &Coordinator) -> Demand<N> {
        match path {
            Ok(path) => {
                for (number, element) in &c0.path {
                    path.take(*number, element);
                }
                let share = if c0.end_motion { 0.0 } else { c0.feed_override };
                path.step(&self.0, share)
            }
            Err(refusal) => Demand::Refuse(*refusal),
        }
    }
}

impl<R: Robot<N>, const N: usize> Generator<EcpOf<N>> for PathMove<R, N> {
    type Own = Result<ToolPath<N>, Refusal>;
    type Args = F<C0, E, ()>;

    fn first(&self, x: X<'_, EcpOf<N>, Self::Args>) -> (Self::Own, Demand<N>) {
        let mut path = x
            .e()
            .demanded_joints
            .ok_or(Refusal::NotSynchronised)
            .and_then(|from| ToolPath::begin(&self.0, &from));
        let y = self.demand(&mut path, x.c0());
        (path, y)
    }

    fn next(&self, path: &mut Self::Own, x: X<'_, EcpOf<N>, Self::Args>) -> Demand<N> {
        self.demand(path, x.c0())
    }

    fn terminal(&self, path: &Self::Own, x: X<'_, EcpOf<N>, Self::Args>) -> bool {
        path.as_ref().map_or(true, |path| {
            path.done() || x.c0().end_motion && path.rests()
        })
    }
}
