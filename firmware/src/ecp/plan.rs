//! What the ECP's work comes to: knots of the motor shafts, and how the instruction goes on.

use super::{Demand, refusal};
use crate::capacity::KNOTS_PER_PLAN;
use protocol::clock::Clock;
use protocol::fault::Refusal;
use protocol::time::Micros;
use robots::{JointMotion, MotorMotion, Robot};

/// When a knot is to be reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum When {
    /// At this instant of bus time.
    At(Micros),
    /// Half a macrostep after the knot before it.
    Half,
    /// As long after it as is left of the macrostep that [`When::Half`] has begun.
    Rest,
    /// A macrostep after it.
    Whole,
}

impl When {
    /// In local time; `before` is the knot before it.
    pub(crate) fn after(self, before: Micros, macrostep: Micros, clock: &Clock) -> Micros {
        let half = Micros(macrostep.0 / 2);
        match self {
            Self::At(at) => clock.to_local(at),
            Self::Half => before + half,
            Self::Rest => before + Micros(macrostep.0.saturating_sub(half.0)),
            Self::Whole => before + macrostep,
        }
    }
}

/// A motion state of the motor shafts, to be attained.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorKnot<const N: usize> {
    /// When.
    pub when: When,
    /// What.
    pub motion: MotorMotion<N>,
    /// Does it say an acceleration? If not, the segment to it is cubic.
    pub has_acceleration: bool,
}

/// How the instruction goes on after the knots of a plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// It goes on.
    Goes,
    /// It is complete.
    Ended,
    /// It cannot go on.
    Failed(Refusal),
    /// `f_E` holds: an error, even if the terminal condition holds too.
    Error,
}

/// The plan of a macrostep.
#[derive(Clone, Debug)]
pub struct Plan<const N: usize> {
    knots: heapless::Vec<MotorKnot<N>, KNOTS_PER_PLAN>,
    pub(super) verdict: Verdict,
}

impl<const N: usize> Plan<N> {
    /// Empty.
    #[expect(
        clippy::inline_always,
        reason = "so that what is large is made where it stays, and not on the stack"
    )]
    #[inline(always)]
    pub(super) const fn new() -> Self {
        Self {
            knots: heapless::Vec::new(),
            verdict: Verdict::Goes,
        }
    }

    pub(super) fn clear(&mut self) {
        self.knots.clear();
        self.verdict = Verdict::Goes;
    }

    /// The knots, in time.
    #[must_use]
    pub fn knots(&self) -> &[MotorKnot<N>] {
        &self.knots
    }

    /// How the instruction goes on after them.
    #[must_use]
    pub const fn verdict(&self) -> Verdict {
        self.verdict
    }

    /// A demand becomes one knot, or two, or none.
    ///
    /// # Errors
    /// Why it cannot be; nothing of it is in the plan then.
    pub(super) fn add<R: Robot<N>>(
        &mut self,
        robot: &R,
        demand: &Demand<N>,
    ) -> Result<(), Refusal> {
        match demand {
            Demand::Stay => Ok(()),
            Demand::Refuse(refusal) => Err(*refusal),
            Demand::Motors(motion) => self.push(When::Whole, *motion, true),
            Demand::At {
                at,
                motion,
                has_acceleration,
            } => self.push(When::At(*at), *motion, *has_acceleration),
            Demand::Joints(motion) => self.push(When::Whole, motors(robot, motion)?, true),
            Demand::JointsTwice([middle, end]) => {
                let (middle, end) = (motors(robot, middle)?, motors(robot, end)?);
                self.push(When::Half, middle, true)?;
                self.push(When::Rest, end, true)
            }
            Demand::JointsAt {
                at,
                motion,
                has_acceleration,
            } => self.push(When::At(*at), motors(robot, motion)?, *has_acceleration),
        }
    }

    fn push(
        &mut self,
        when: When,
        motion: MotorMotion<N>,
        has_acceleration: bool,
    ) -> Result<(), Refusal> {
        let knot = MotorKnot {
            when,
            motion,
            has_acceleration,
        };
        // a step has two at most, and only tight coordination, which has one, makes several steps
        self.knots.push(knot).map_err(|_| Refusal::QueueFull)
    }
}

fn motors<R: Robot<N>, const N: usize>(
    robot: &R,
    motion: &JointMotion<N>,
) -> Result<MotorMotion<N>, Refusal> {
    robot
        .check_joints(&motion.position)
        .map_err(|e| refusal::from_kinematics(&e))?;
    robot
        .motor_motion(motion)
        .map_err(|e| refusal::from_kinematics(&e))
}
