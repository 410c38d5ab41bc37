//! What taps hand in: every tap's queue, and why a frame is refused.

use super::queue::Queue;
use super::{Kind, Tap};
use protocol::frame::Frame;

/// Frames a tap's queue holds unless another capacity is asked for.
pub const DEFAULT_CAPACITY: usize = 256;

/// Why a frame was not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PostError {
    /// An FD frame on a classical wire.
    #[error("a CAN FD frame cannot be sent on a classical wire")]
    FdOnClassic,
    /// The tap's transmit queue is full.
    #[error("the transmit queue of tap {tap} is full ({capacity} frames)")]
    Full {
        /// Whose.
        tap: Tap,
        /// How many frames it holds.
        capacity: usize,
    },
    /// There is no such tap.
    #[error("there is no tap {tap} (the wire has {taps})")]
    NoTap {
        /// Which.
        tap: Tap,
        /// How many there are, numbered from 0.
        taps: usize,
    },
}

#[derive(Clone, Debug)]
pub(super) struct Queues {
    pub(super) kind: Kind,
    pub(super) taps: Vec<Queue>,
    pub(super) capacity: usize,
    pub(super) refused: u64,
    /// Numbers the posts, so that equal identifiers keep their order.
    posts: u64,
}

impl Queues {
    pub(super) fn new(kind: Kind, taps: usize) -> Self {
        Self {
            kind,
            taps: vec![Queue::default(); taps],
            capacity: DEFAULT_CAPACITY,
            refused: 0,
            posts: 0,
        }
    }

    pub(super) fn post(&mut self, tap: Tap, at_ns: u64, frame: Frame) -> Result<(), PostError> {
        let taps = self.taps.len();
        let Some(queue) = self.taps.get_mut(tap) else {
            self.refused += 1;
            return Err(PostError::NoTap { tap, taps });
        };
        if frame.is_fd() && self.kind == Kind::Classic {
            self.refused += 1;
            return Err(PostError::FdOnClassic);
        }
        if queue.len() >= self.capacity {
            self.refused += 1;
            return Err(PostError::Full {
                tap,
                capacity: self.capacity,
            });
        }
        self.posts += 1;
        queue.push(at_ns, self.posts, frame);
        Ok(())
    }
}

/// Takes the frames that taps send in answer to a delivery, posted at the time of the delivery.
#[derive(Debug)]
pub struct Outbox<'a> {
    pub(super) at_ns: u64,
    pub(super) queues: &'a mut Queues,
}

impl Outbox<'_> {
    /// The time of the delivery.
    #[must_use]
    pub const fn at_ns(&self) -> u64 {
        self.at_ns
    }

    /// Posts a frame now.
    ///
    /// # Errors
    /// As [`super::Wire::post`].
    pub fn post(&mut self, tap: Tap, frame: Frame) -> Result<(), PostError> {
        self.queues.post(tap, self.at_ns, frame)
    }

    /// Posts a frame later: a participant that takes `at_ns - self.at_ns()` to answer.
    ///
    /// # Errors
    /// As [`super::Wire::post`].
    pub fn post_at(&mut self, tap: Tap, at_ns: u64, frame: Frame) -> Result<(), PostError> {
        self.queues.post(tap, at_ns.max(self.at_ns), frame)
    }
}
