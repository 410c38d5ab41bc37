//! What the ECP has been told, and how far it is: the side of it that answers requests at once.
//!
//! The other side, [`Ecp`](super::Ecp), may be at work for most of a macrostep; nothing here waits for it.

use crate::capacity::{KNOT_INBOX, PATH_ELEMENTS_PER_MACROSTEP, PATH_INBOX};
use protocol::fault::Refusal;
use protocol::message::{
    Coordination, Decision, Instruction, KnotMessage, NodeState, PathElement, Progress,
};
use protocol::time::Micros;

/// What is streamed to an instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Streamed {
    Nothing,
    Knots,
    Path,
}

/// The latest instruction, and what waits for its next steps.
#[derive(Debug)]
pub struct Agenda {
    /// Of the instruction that runs or waits for its start.
    running: Option<Streamed>,
    /// The ECP makes a step of it.
    at_work: bool,
    start_at: Micros,
    id: u32,
    progress: Progress,
    decision: Option<Decision>,
    inbox: heapless::Deque<KnotMessage, KNOT_INBOX>,
    end_motion: bool,
    /// Elements of a path that wait to be taken, and the number of the one wanted next.
    path: heapless::Deque<PathElement, PATH_INBOX>,
    path_next: u32,
    feed_override: f64,
}

impl Agenda {
    /// Nothing to do.
    pub(crate) const fn new() -> Self {
        Self {
            running: None,
            at_work: false,
            start_at: Micros(0),
            id: 0,
            progress: Progress::Idle,
            decision: None,
            inbox: heapless::Deque::new(),
            end_motion: false,
            path: heapless::Deque::new(),
            path_next: 0,
            feed_override: 1.0,
        }
    }

    /// The latest instruction and how far it is.
    pub(crate) const fn progress(&self) -> (u32, Progress) {
        (self.id, self.progress)
    }

    /// Is an instruction running or waiting for its start?
    pub(crate) const fn busy(&self) -> bool {
        self.running.is_some()
    }

    /// Is a step of an instruction due, by the bus' time?
    pub(crate) fn due(&self, bus_now: Micros) -> bool {
        self.busy() && bus_now >= self.start_at
    }

    /// Does the running instruction take its knots from the coordinator, and do knots wait?
    pub(crate) fn knots_wait(&self) -> bool {
        self.running == Some(Streamed::Knots) && !self.inbox.is_empty()
    }

    /// A new epoch: forget the last one's instruction.
    pub(crate) fn forget(&mut self) {
        self.abort();
        self.id = 0;
        self.progress = Progress::Idle;
        self.decision = None;
    }

    /// What the coordinator says in its cyclic message.
    ///
    /// # Errors
    /// [`Refusal::QueueFull`] when knots come faster than they are consumed.
    pub(crate) fn coordinate(&mut self, says: &Coordination) -> Result<(), Refusal> {
        match says {
            Coordination::Loose(decision) => {
                self.decision = Some(*decision);
                Ok(())
            }
            Coordination::Tight(knot) if self.running == Some(Streamed::Knots) => self
                .inbox
                .push_back(knot.clone())
                .map_err(|_| Refusal::QueueFull),
            Coordination::None | Coordination::Tight(_) => Ok(()),
        }
    }

    /// An instruction that the ECP has accepted.
    pub(crate) fn begin(&mut self, id: u32, start_at: Micros, instruction: &Instruction) {
        self.running = Some(match instruction {
            Instruction::Follow => Streamed::Knots,
            Instruction::FollowPath { .. } => Streamed::Path,
            _ => Streamed::Nothing,
        });
        self.id = id;
        self.start_at = start_at;
        self.progress = Progress::Pending;
        self.clear_streams();
    }

    /// The coordinator ends the motion.
    pub(crate) const fn end_motion(&mut self) {
        self.end_motion = true;
    }

    /// Did it?
    pub(crate) const fn motion_ends(&self) -> bool {
        self.end_motion
    }

    /// The ECP makes a step.
    pub(crate) const fn set_at_work(&mut self) {
        self.at_work = true;
        self.progress = Progress::Running;
    }

    /// The step has been made; is it still wanted?
    pub(crate) const fn take_at_work(&mut self) -> bool {
        core::mem::replace(&mut self.at_work, false)
    }

    /// The instruction ends here, because of a stop or a fault.
    pub(crate) fn abort(&mut self) {
        if self.busy() {
            self.progress = Progress::Failed(Refusal::Aborted);
        }
        self.end();
    }

    /// It has made its last step.
    pub(crate) fn end(&mut self) {
        self.running = None;
        self.at_work = false;
        self.clear_streams();
    }

    /// The arm has come to rest after the instruction ended: it is complete.
    pub(crate) fn complete(&mut self) {
        if self.progress == Progress::Running || self.progress == Progress::Pending {
            self.progress = Progress::Done;
        }
    }

    /// What the instruction demands cannot be.
    pub(crate) fn fail(&mut self, refusal: Refusal) {
        self.end();
        self.progress = Progress::Failed(refusal);
    }

    /// The next knot of tight coordination.
    pub(crate) fn take_knot(&mut self) -> Option<KnotMessage> {
        self.inbox.pop_front()
    }

    /// The latest decision of loose coordination.
    pub(crate) const fn decision(&self) -> Option<Decision> {
        self.decision
    }

    /// More of the path of the running instruction: which element is wanted next, and room for how many.
    ///
    /// # Errors
    /// [`Refusal::WrongState`] if no path is followed.
    pub(crate) fn extend_path(
        &mut self,
        first: u32,
        elements: &[PathElement],
    ) -> Result<(u32, u16), Refusal> {
        if self.running != Some(Streamed::Path) {
            return Err(Refusal::WrongState {
                state: NodeState::Holding,
            });
        }
        for (number, element) in (first..u32::MAX).zip(elements) {
            if number == self.path_next && self.path.push_back(*element).is_ok() {
                self.path_next = self.path_next.saturating_add(1);
            }
        }
        let room = PATH_INBOX.saturating_sub(self.path.len());
        Ok((self.path_next, u16::try_from(room).unwrap_or(u16::MAX)))
    }

    /// The feed rate on a path, from the next macrostep on.
    ///
    /// # Errors
    /// [`Refusal::OutOfRange`]
    pub(crate) fn override_feed(&mut self, share: f32) -> Result<(), Refusal> {
        if !(-1.0..=1.0).contains(&share) {
            return Err(Refusal::OutOfRange {
                index: 0,
                value: share,
                lower: -1.0,
                upper: 1.0,
            });
        }
        self.feed_override = f64::from(share);
        Ok(())
    }

    /// The feed rate on a path, as a share of the programmed one.
    pub(crate) const fn feed_override(&self) -> f64 {
        self.feed_override
    }

    /// Elements of the path that the next step takes, with their numbers: at most so many.
    pub(crate) fn take_path(
        &mut self,
        room: usize,
        taken: &mut heapless::Vec<(u32, PathElement), PATH_ELEMENTS_PER_MACROSTEP>,
    ) {
        taken.clear();
        for _ in 0..room {
            if taken.is_full() {
                break;
            }
            let waiting = u32::try_from(self.path.len()).unwrap_or(u32::MAX);
            let Some(element) = self.path.pop_front() else {
                break;
            };
            let _ = taken.push((self.path_next.saturating_sub(waiting), element));
        }
    }

    /// What was streamed to an instruction is of no use to another.
    fn clear_streams(&mut self) {
        self.inbox.clear();
        self.end_motion = false;
        self.path.clear();
        self.path_next = 0;
        self.feed_override = 1.0;
    }
}
