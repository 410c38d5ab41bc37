//! `f^2(c_j, e_j)`: to a pose of the tool, straight in joint space.

use crate::ecp::generator::axis_move::{Course, MotorShare, joint_demand};
use crate::ecp::generator::line_move::Reference;
use crate::ecp::{Demand, EcpOf, refusal};
use agent::args::{E, F};
use agent::{Generator, X};
use motion::Pose;
use motion::profile::AxisLimits;
use protocol::fault::Refusal;
use robots::{Joints, Robot};

/// Move the tool to a pose by the nearest joint configuration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseMove<R, const N: usize> {
    /// The robot's kinematics.
    pub robot: R,
    /// The tool in the flange frame.
    pub t_flange_tool: Pose,
    /// Where to.
    pub target: Pose,
    /// In which frame.
    pub reference: Reference,
    /// Velocity, acceleration and jerk per joint.
    pub limits: [AxisLimits; N],
    /// How far the motors may be used.
    pub motor_share: MotorShare,
    /// Macrostep, s.
    pub macrostep_s: f64,
}

impl<R: Robot<N>, const N: usize> Generator<EcpOf<N>> for PoseMove<R, N> {
    type Own = Course<N>;
    type Args = F<(), E, ()>;

    fn first(&self, x: X<'_, EcpOf<N>, Self::Args>) -> (Course<N>, Demand<N>) {
        let mut c = match &x.e().demanded_joints {
            None => Course::refused(Refusal::NotSynchronised),
            Some(from) => {
                let t_base_tool = match self.reference {
                    Reference::Base => self.target,
                    Reference::Tool => self.robot.forward(from) * self.t_flange_tool * self.target,
                };
                match self
                    .robot
                    .inverse(&(t_base_tool * self.t_flange_tool.inverse()), from)
                {
                    Ok(solution) => {
                        // the nearest branch that the motors reach too
                        let reachable = |q: &Joints<N>| {
                            self.robot
                                .motors(q)
                                .and_then(|m| self.robot.check_motors(&m))
                                .is_ok()
                        };
                        let to = solution.nearest_where(from, reachable);
                        let to = to.unwrap_or_else(|| solution.nearest());
                        Course::joints(&self.robot, from, &to, &self.limits, self.motor_share)
                    }
                    Err(e) => Course::refused(refusal::from_kinematics(&e)),
                }
            }
        };
        let y = joint_demand(&mut c, self.macrostep_s);
        (c, y)
    }

    fn next(&self, c: &mut Course<N>, _: X<'_, EcpOf<N>, Self::Args>) -> Demand<N> {
        joint_demand(c, self.macrostep_s)
    }

    fn terminal(&self, c: &Course<N>, _: X<'_, EcpOf<N>, Self::Args>) -> bool {
        c.ended(self.macrostep_s)
    }
}
