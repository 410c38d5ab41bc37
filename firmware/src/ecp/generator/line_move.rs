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

/// Move the tool along a straight line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineMove<R, const N: usize> {
    /// The arm.
    pub motion: ToolMotion<R, N>,
    /// Where to.
    pub target: Pose,
    /// In which frame.
    pub reference: Reference,
}

impl<R: Robot<N>, const N: usize> LineMove<R, N> {
    fn begin(&self, from: Option<Joints<N>>) -> Result<ToolPath<N>, Refusal> {
        let from = from.ok_or(Refusal::NotSynchronised)?;
        let mut path = ToolPath::begin(&self.motion, &from)?;
        let t_base_goal = match self.reference {
            Reference::Base => self.target,
            Reference::Tool => *path.last() * self.target,
        };
        path.only_line(t_base_goal)?;
        Ok(path)
    }

    fn demand(&self, path: &mut Result<ToolPath<N>, Refusal>) -> Demand<N> {
        match path {
            Ok(path) => path.step(&self.motion, 1.0),
            Err(refusal) => Demand::Refuse(*refusal),
        }
    }
}

impl<R: Robot<N>, const N: usize> Generator<EcpOf<N>> for LineMove<R, N> {
    type Own = Result<ToolPath<N>, Refusal>;
    type Args = F<(), E, ()>;

    fn first(&self, x: X<'_, EcpOf<N>, Self::Args>) -> (Self::Own, Demand<N>) {
        let mut path = self.begin(x.e().demanded_joints);
        let y = self.demand(&mut path);
        (path, y)
    }

    fn next(&self, path: &mut Self::Own, _: X<'_, EcpOf<N>, Self::Args>) -> Demand<N> {
        self.demand(path)
    }

    fn terminal(&self, path: &Self::Own, _: X<'_, EcpOf<N>, Self::Args>) -> bool {
        path.as_ref().map_or(true, ToolPath::done)
    }
}
