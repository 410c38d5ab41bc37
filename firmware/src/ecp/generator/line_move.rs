//! `f^2(c_j, e_j)`: the tool along a straight line, its orientation by slerp.

use crate::ecp::tool_motion::ToolMotion;
use crate::ecp::tool_path::ToolPath;
use crate::ecp::{Demand, EcpOf};
use agent::args::{E, F};
use agent::{Generator, X};
use motion::Pose;
use protocol::fault::Refusal;
use robots::{Joints, Robot};

/// What the target pose is relative to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reference {
    /// The robot's base frame.
    Base,
    /// The tool frame at the start.
    Tool,
}

/// Move the tool along a straight line, with a path of W samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineMove<R, const N: usize, const W: usize> {
    /// The arm.
    pub motion: ToolMotion<R, N>,
    /// Where to.
    pub target: Pose,
    /// In which frame.
    pub reference: Reference,
}

impl<R: Robot<N>, const N: usize, const W: usize> LineMove<R, N, W> {
    fn begin(&self, path: &mut ToolPath<N, W>, from: Option<Joints<N>>) -> Result<(), Refusal> {
        let from = from.ok_or(Refusal::NotSynchronised)?;
        path.begin(&self.motion, &from)?;
        let t_base_goal = match self.reference {
            Reference::Base => self.target,
            Reference::Tool => *path.last() * self.target,
        };
        path.only_line(t_base_goal)
    }
}

impl<R: Robot<N>, const N: usize, const W: usize> Generator<EcpOf<N>> for LineMove<R, N, W> {
    type Own = ToolPath<N, W>;
    type Args = F<(), E, ()>;

    fn first(&self, x: X<'_, EcpOf<N>, Self::Args>) -> (Self::Own, Demand<N>) {
        let mut path = ToolPath::new();
        let y = self.first_in(&mut path, x);
        (path, y)
    }

    fn first_in(&self, path: &mut Self::Own, x: X<'_, EcpOf<N>, Self::Args>) -> Demand<N> {
        if let Err(refusal) = self.begin(path, x.e().demanded_joints) {
            path.refuse_all(refusal);
        }
        path.step(&self.motion, 1.0)
    }

    fn next(&self, path: &mut Self::Own, _: X<'_, EcpOf<N>, Self::Args>) -> Demand<N> {
        path.step(&self.motion, 1.0)
    }

    fn terminal(&self, path: &Self::Own, _: X<'_, EcpOf<N>, Self::Args>) -> bool {
        path.done()
    }
}
