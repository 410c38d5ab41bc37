//! What is streamed to the running instruction, above all a path.

use super::{Ecp, Programs, Running};
use crate::capacity::{PATH_ELEMENTS_PER_MACROSTEP, PATH_INBOX};
use protocol::fault::Refusal;
use protocol::message::{NodeState, PathElement};

impl<R, const N: usize, P: Programs<N>, const W: usize> Ecp<R, N, P, W> {
    /// More of the path of the running instruction: which element is wanted next, and room for how many.
    ///
    /// # Errors
    /// [`Refusal::WrongState`] if no path is followed.
    pub fn extend_path(
        &mut self,
        first: u32,
        elements: &[PathElement],
    ) -> Result<(u32, u16), Refusal> {
        if !matches!(self.running, Running::Path(_)) {
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
    pub fn override_feed(&mut self, share: f32) -> Result<(), Refusal> {
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

    /// Elements of the path that this macrostep takes, with their numbers.
    pub(super) fn path_elements(
        &mut self,
    ) -> heapless::Vec<(u32, PathElement), PATH_ELEMENTS_PER_MACROSTEP> {
        let mut taken = heapless::Vec::new();
        let Running::Path(running) = &self.running else {
            return taken;
        };
        let room = if running.runs() {
            self.tool_path.room()
        } else {
            // the first step begins with an empty path
            PATH_ELEMENTS_PER_MACROSTEP
        };
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
        taken
    }

    /// What was streamed to an instruction is of no use to another.
    pub(super) fn clear_streams(&mut self) {
        self.inbox.clear();
        self.end_motion = false;
        self.path.clear();
        self.path_next = 0;
        self.feed_override = 1.0;
    }
}
