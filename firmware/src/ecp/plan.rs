//! What the ECP's work comes to: pieces for the set-point queue, and how the instruction goes on.
//!
//! The pieces are made and checked here, in f64, against the queue as it was at the [order](Ahead): the servo step that
//! takes them compares but where they begin.

use super::{Demand, refusal};
use crate::capacity::KNOTS_PER_PLAN;
use crate::edp::servo::narrow;
use motion::Knot;
use motion::interpolator::{Made, PathLimits, Piece, Tip};
use protocol::clock::Line;
use protocol::fault::Refusal;
use protocol::message::NodeState;
use protocol::time::Micros;
use robots::{JointMotion, MotorMotion, Robot};

/// When a knot is to be reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum When {
    /// At this instant of bus time.
    At(Micros),
    /// Half a macrostep after the knot before it.
    Half,
    /// As long after it as is left of the macrostep that [`When::Half`] has begun.
    Rest,
    /// A macrostep after it.
    Whole,
}

/// A motion state of the motor shafts, to be attained.
#[derive(Clone, Copy, Debug, PartialEq)]
struct MotorKnot<const N: usize> {
    when: When,
    motion: MotorMotion<N>,
    /// Does it say an acceleration? If not, the piece to it is cubic.
    has_acceleration: bool,
}

/// What a plan is made ahead of: the set-point queue, as it was when the plan was ordered.
///
/// Nothing but a plan, a stop or a return to rest changes where the queue ends; a plan that comes after one of these is
/// refused, for its pieces do not fit then ([`Tip`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ahead<const N: usize> {
    /// Where the queue ends.
    pub tip: Tip<N>,
    /// There will be no path when the plan is taken: it begins one.
    pub begins: bool,
    /// The axes are homed: their ranges count.
    pub homed: bool,
    /// When the plan will be taken, local time.
    pub taken_at: Micros,
    /// A macrostep.
    pub macrostep: Micros,
    /// From bus time to local time.
    pub line: Line,
}

impl<const N: usize> Ahead<N> {
    /// Of no queue.
    pub(super) const fn nothing() -> Self {
        Self {
            tip: Tip::nowhere(),
            begins: true,
            homed: false,
            taken_at: Micros(0),
            macrostep: Micros(0),
            line: Line::IDENTITY,
        }
    }

    /// Where the first knot's piece begins.
    fn begin(&self, when: When) -> Tip<N> {
        if !self.begins {
            return self.tip;
        }
        let (now, macrostep) = (self.taken_at, self.macrostep);
        // one macrostep of lead, so that the queue never runs dry between two of them
        let start = match when {
            When::At(at) => {
                let at = self.line.to_local(at);
                if at.since(now) > macrostep {
                    Micros(at.0.saturating_sub(macrostep.0))
                } else {
                    now
                }
            }
            When::Half | When::Rest | When::Whole => now + macrostep,
        };
        self.tip.starting_at(start.0)
    }

    /// When a knot is to be reached, local time; `before` is the knot before it.
    fn local(&self, when: When, before: Micros) -> Micros {
        let half = Micros(self.macrostep.0 / 2);
        match when {
            When::At(at) => self.line.to_local(at),
            When::Half => before + half,
            When::Rest => before + Micros(self.macrostep.0.saturating_sub(half.0)),
            When::Whole => before + self.macrostep,
        }
    }
}

/// A piece for the set-point queue.
#[derive(Clone, Copy, Debug)]
pub struct PlannedPiece<const N: usize> {
    /// The piece.
    pub piece: Piece<N>,
    /// It leads to a knot at an instant of its own: where it was made to begin, it must.
    pub timed: bool,
    /// Greatest step of acceleration where it begins, of a cubic, rad/s².
    pub acceleration_step: f32,
}

/// How the instruction goes on after the pieces of a plan.
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
    pieces: heapless::Vec<PlannedPiece<N>, KNOTS_PER_PLAN>,
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
            pieces: heapless::Vec::new(),
            verdict: Verdict::Goes,
        }
    }

    pub(super) fn clear(&mut self) {
        self.pieces.clear();
        self.verdict = Verdict::Goes;
    }

    /// The pieces, in time.
    #[must_use]
    pub fn pieces(&self) -> &[PlannedPiece<N>] {
        &self.pieces
    }

    /// How the instruction goes on after them.
    #[must_use]
    pub const fn verdict(&self) -> Verdict {
        self.verdict
    }

    /// A demand becomes one piece, or two, or none.
    ///
    /// # Errors
    /// Why it cannot be.
    pub(super) fn add<R: Robot<N>>(
        &mut self,
        robot: &R,
        path: &PathLimits<N>,
        ahead: &Ahead<N>,
        demand: &Demand<N>,
    ) -> Result<(), Refusal> {
        let mut push = |when, motion: &MotorMotion<N>, has_acceleration| {
            let knot = MotorKnot {
                when,
                motion: *motion,
                has_acceleration,
            };
            self.push(path, ahead, &knot)
        };
        match demand {
            Demand::Stay => Ok(()),
            Demand::Refuse(refusal) => Err(*refusal),
            Demand::Motors(motion) => push(When::Whole, motion, true),
            Demand::At {
                at,
                motion,
                has_acceleration,
            } => push(When::At(*at), motion, *has_acceleration),
            Demand::Joints(motion) => push(When::Whole, &motors(robot, motion)?, true),
            Demand::JointsTwice([middle, end]) => {
                let (middle, end) = (motors(robot, middle)?, motors(robot, end)?);
                push(When::Half, &middle, true)?;
                push(When::Rest, &end, true)
            }
            Demand::JointsAt {
                at,
                motion,
                has_acceleration,
            } => push(When::At(*at), &motors(robot, motion)?, *has_acceleration),
        }
    }

    // a frame of its own: what else its caller does must not lie below it on the stack
    #[inline(never)]
    fn push(
        &mut self,
        path: &PathLimits<N>,
        ahead: &Ahead<N>,
        knot: &MotorKnot<N>,
    ) -> Result<(), Refusal> {
        let MotorKnot {
            when,
            motion,
            has_acceleration,
        } = knot;
        let from = match self.pieces.last() {
            Some(last) => last.piece.tip(),
            None => ahead.begin(*when),
        };
        let knot = Knot {
            at_us: ahead.local(*when, Micros(from.at_us())).0,
            position: motion.position.0,
            velocity: motion.velocity,
            acceleration: has_acceleration.then_some(motion.acceleration),
        };
        let Made {
            piece,
            acceleration_step,
        } = path
            .piece(&from, &knot)
            .map_err(|e| refusal::from_push(&e, NodeState::Moving))?;
        let mut step = 0.0;
        if !has_acceleration {
            for axis in acceleration_step {
                step = if axis > step { axis } else { step };
            }
        }
        let planned = PlannedPiece {
            piece,
            timed: matches!(when, When::At(_)),
            acceleration_step: narrow(step),
        };
        // a step has two at most, and only tight coordination, which has one, makes several steps
        self.pieces.push(planned).map_err(|_| Refusal::QueueFull)
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
