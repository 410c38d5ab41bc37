//! The pieces of the path that are still to be passed.

use super::fixed::FixedSegment;

/// A first-in first-out queue of at most Q pieces.
#[derive(Clone, Debug)]
pub(crate) struct Queue<const N: usize, const Q: usize> {
    pieces: heapless::Deque<FixedSegment<N>, Q>,
}

impl<const N: usize, const Q: usize> Queue<N, Q> {
    pub(crate) const fn new() -> Self {
        const { assert!(Q > 0, "a queue without room") };
        Self {
            pieces: heapless::Deque::new(),
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.pieces.len()
    }

    pub(crate) fn is_full(&self) -> bool {
        self.pieces.is_full()
    }

    pub(crate) fn clear(&mut self) {
        self.pieces.clear();
    }

    /// Appends; the caller has asked [`is_full`](Self::is_full).
    pub(crate) fn push(&mut self, piece: FixedSegment<N>) {
        let _ = self.pieces.push_back(piece);
    }

    pub(crate) fn front(&self) -> Option<&FixedSegment<N>> {
        self.pieces.front()
    }

    /// Drops pieces that end at or before `us`, except the last piece.
    pub(crate) fn drop_passed(&mut self, us: u64) {
        for _ in 1..self.len() {
            if self.front().is_some_and(|piece| piece.end_us() > us) {
                break;
            }
            let _ = self.pieces.pop_front();
        }
    }
}
