//! Orders to the ECP, and its plans: the hand-over between the two halves of a node.
//!
//! ```text
//!  servo steps of a macrostep   0      1  2  3  4  5  6  7   8          9          0
//!  foreground                   order                        1st piece  2nd piece  order
//!  ECP                          [work .................. ]   (fault 15 if it is not done)
//! ```
//! A plan is taken at the same step whether the work took long or not: so a node behaves the same on every
//! machine, and no servo step ever waits. Its pieces have been made and checked ahead of the queue as it was at the order;
//! they come into it one a step, if it still ends there.
//! So what a coordinator says has its effect those eight steps later than it would by an ECP that takes no time.

use super::foreground::Foreground;
use crate::capacity::KNOTS_PER_PLAN;
use crate::ecp::{Ecp, Plan, Programs, Verdict};
use crate::edp::mode::{Event as ModeEvent, Mode};
use protocol::fault::{Cause, Reaction, Refusal};
use protocol::time::Micros;
use robots::Robot;

/// Where the ECP is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Whereabouts {
    /// At hand, with nothing to do.
    AtHand,
    /// At work since this servo step.
    Ordered(u32),
    /// Done; so many pieces of its plan are taken.
    Taken(usize),
    /// At work, and late.
    Late,
}

/// The ECP's work, as the foreground knows it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Work {
    /// Servo steps of a macrostep.
    macrostep: u32,
    ecp: Whereabouts,
    /// The rim has not heard of the order yet.
    ordered: bool,
}

impl Work {
    pub(super) const fn new(macrostep: u32) -> Self {
        Self {
            macrostep,
            ecp: Whereabouts::AtHand,
            ordered: false,
        }
    }

    /// Servo steps from an order to the first knot of its plan: as late as the last knot comes before the next order.
    fn hand_over(&self) -> u32 {
        let knots = u32::try_from(KNOTS_PER_PLAN).unwrap_or(u32::MAX);
        match self.macrostep.saturating_sub(knots) {
            0 => 1,
            steps => steps,
        }
    }

    pub(super) fn is_at_hand(&self) -> bool {
        self.ecp == Whereabouts::AtHand
    }
}

impl<R: Robot<N> + Copy, const N: usize> Foreground<R, N> {
    /// Since the last question, was the ECP given an order? Then it is to work, and must not be handed to
    /// [`Self::step`] until it has.
    pub const fn take_order(&mut self) -> bool {
        core::mem::replace(&mut self.work.ordered, false)
    }

    /// Takes of a plan what is due, and gives orders. No frame of its own: it is most often nothing.
    pub(super) fn coordinate<P: Programs<N>, const W: usize>(
        &mut self,
        now: Micros,
        ecp: Option<&mut Ecp<R, N, P, W>>,
    ) {
        let step = self.edp.servo_step();
        let mut again = false;
        match (self.work.ecp, &ecp) {
            (Whereabouts::Ordered(_), Some(ecp)) if self.plan_is_due(step) => {
                self.take(now, ecp.plan(), 0);
                again = true;
            }
            (Whereabouts::Ordered(_), None) if self.plan_is_due(step) => {
                self.work.ecp = Whereabouts::Late;
                if self.agenda.take_at_work() {
                    self.edp.raise(now, Cause::PlanLate, None);
                }
            }
            (Whereabouts::Taken(knots), Some(ecp)) => {
                self.take(now, ecp.plan(), knots);
                again = true;
            }
            (Whereabouts::Late, Some(_)) => self.work.ecp = Whereabouts::AtHand,
            _ => {}
        }
        let phase = step.checked_rem(self.work.macrostep).unwrap_or(0);
        if phase == self.work.macrostep.saturating_sub(1) {
            self.complete(now);
        }
        if (phase == 0 || again && self.agenda.knots_wait())
            && self.work.is_at_hand()
            && let Some(ecp) = ecp
        {
            self.order(now, step, ecp);
        }
    }

    /// Would a servo step of this number take a plan?
    fn plan_is_due(&self, step: u32) -> bool {
        match self.work.ecp {
            Whereabouts::Ordered(at) => step.wrapping_sub(at) >= self.work.hand_over(),
            Whereabouts::AtHand | Whereabouts::Taken(_) | Whereabouts::Late => false,
        }
    }

    /// Will the next servo step take a plan?
    pub fn takes_next(&self) -> bool {
        self.plan_is_due(self.edp.servo_step().wrapping_add(1))
    }

    // a frame of its own: what else its caller does must not lie below it on the stack
    #[inline(never)]
    fn order<P: Programs<N>, const W: usize>(
        &mut self,
        now: Micros,
        step: u32,
        ecp: &mut Ecp<R, N, P, W>,
    ) {
        let moves = matches!(self.edp.mode(), Mode::Resting(_) | Mode::Moving { .. });
        if !moves || self.ending || !self.agenda.due(self.clock.to_bus(now)) {
            return;
        }
        self.agenda.set_at_work();
        let ahead = self
            .edp
            .ahead(now, self.work.hand_over(), self.clock.line());
        ecp.order(&mut self.agenda, &self.edp.image(), self.sensors, ahead);
        self.work.ecp = Whereabouts::Ordered(step);
        self.work.ordered = true;
    }

    /// The next piece of a plan; after the last one, how the instruction goes on.
    // a frame of its own: what else its caller does must not lie below it on the stack
    #[inline(never)]
    fn take(&mut self, now: Micros, plan: &Plan<N>, taken: usize) {
        self.work.ecp = Whereabouts::AtHand;
        let moves = matches!(self.edp.mode(), Mode::Resting(_) | Mode::Moving { .. });
        // of an instruction that was stopped meanwhile nobody wants the plan
        if !self.agenda.take_at_work() || !moves {
            return;
        }
        let demands = plan.verdict() == Verdict::Goes || !plan.pieces().is_empty();
        if demands && matches!(self.edp.mode(), Mode::Resting(_)) {
            let _ = self.edp.on(now, ModeEvent::Start);
        }
        if let Some(piece) = plan.pieces().get(taken)
            && let Err(refusal) = self.edp.queue(now, piece)
        {
            self.fail(now, &refusal);
            return;
        }
        let taken = taken.saturating_add(1);
        if taken < plan.pieces().len() {
            self.agenda.set_at_work();
            self.work.ecp = Whereabouts::Taken(taken);
            return;
        }
        match plan.verdict() {
            Verdict::Goes => {}
            Verdict::Ended => {
                self.agenda.end();
                self.ending = true;
                self.edp.come_to_rest();
            }
            Verdict::Failed(refusal) => self.fail(now, &refusal),
            Verdict::Error => {
                self.agenda.abort();
                self.edp.raise(now, Cause::ErrorCondition, None);
            }
        }
    }

    /// Is an instruction complete, since the set-points have come to rest?
    fn complete(&mut self, now: Micros) {
        let moves = matches!(self.edp.mode(), Mode::Resting(_) | Mode::Moving { .. });
        if moves && (self.ending || !self.agenda.busy()) && self.edp.at_rest(now) {
            if self.ending {
                self.ending = false;
                self.agenda.complete();
            }
            self.edp.flush();
            if matches!(self.edp.mode(), Mode::Moving { .. }) {
                let _ = self.edp.on(now, ModeEvent::Ended);
            }
        }
    }

    fn fail(&mut self, now: Micros, refusal: &Refusal) {
        self.agenda.fail(*refusal);
        self.refused(now, refusal);
    }

    /// What the instruction asked for cannot be: harmless at rest, a fault in motion.
    fn refused(&mut self, now: Micros, refusal: &Refusal) {
        self.ending = false;
        if self.edp.at_rest(now) {
            return;
        }
        let (cause, axis) = match refusal {
            Refusal::Limit { axis, .. } => (Cause::PositionLimit, Some(usize::from(*axis))),
            Refusal::NotFinite { index } => (Cause::NotFinite, Some(usize::from(*index))),
            _ => (Cause::Unreachable, None),
        };
        let fault = Cause::reaction(cause);
        let reaction = if fault > Reaction::PathStop {
            Reaction::PathStop
        } else {
            fault
        };
        // the path so far was checked: stopping on it is the safest thing to do
        self.edp.raise_with(now, cause, axis, reaction);
    }
}
