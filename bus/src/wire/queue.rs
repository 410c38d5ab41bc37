//! The transmit queue of one tap: most urgent first, first come first served among equals.

use protocol::frame::Frame;

/// A frame that waits.
#[derive(Clone, Debug)]
pub(super) struct Waiting {
    pub(super) posted_ns: u64,
    pub(super) frame: Frame,
    urgency: u64,
    number: u64,
}

/// Frames ready to be sent, and frames whose time has not come.
///
/// `ready` is a stack with the most urgent on top; queues are short, so an insertion into a sorted
/// vector beats a heap and keeps the order of equals.
#[derive(Clone, Debug, Default)]
pub(super) struct Queue {
    /// Sorted by (urgency, number), the most urgent last.
    waiting: Vec<Waiting>,
    /// The least `posted_ns` of `waiting`.
    earliest_ns: Option<u64>,
    /// The greatest.
    latest_ns: u64,
}

impl Queue {
    pub(super) fn len(&self) -> usize {
        self.waiting.len()
    }

    pub(super) fn clear(&mut self) {
        self.waiting.clear();
        self.refresh();
    }

    pub(super) fn push(&mut self, posted_ns: u64, number: u64, frame: Frame) {
        let urgency = frame.id().arbitration();
        let key = (urgency, number);
        let place = self
            .waiting
            .partition_point(|other| (other.urgency, other.number) > key);
        self.waiting.insert(
            place,
            Waiting {
                posted_ns,
                frame,
                urgency,
                number,
            },
        );
        self.earliest_ns = Some(
            self.earliest_ns
                .map_or(posted_ns, |least| least.min(posted_ns)),
        );
        self.latest_ns = self.latest_ns.max(posted_ns);
    }

    /// When the first of the frames wants to be sent.
    pub(super) fn earliest_ns(&self) -> Option<u64> {
        self.earliest_ns
    }

    fn best(&self, at_ns: u64) -> Option<usize> {
        if self.latest_ns <= at_ns {
            return self.waiting.len().checked_sub(1);
        }
        self.waiting
            .iter()
            .rposition(|waiting| waiting.posted_ns <= at_ns)
    }

    /// The identifier it would arbitrate with.
    pub(super) fn urgency(&self, at_ns: u64) -> Option<u64> {
        Some(self.waiting.get(self.best(at_ns)?)?.urgency)
    }

    /// The frame it would send.
    pub(super) fn offer(&self, at_ns: u64) -> Option<&Frame> {
        Some(&self.waiting.get(self.best(at_ns)?)?.frame)
    }

    /// The frame it sends.
    pub(super) fn take(&mut self, at_ns: u64) -> Option<Waiting> {
        let taken = self.waiting.remove(self.best(at_ns)?);
        self.refresh();
        Some(taken)
    }

    fn refresh(&mut self) {
        // Frames posted at the same time are common: as long as one of the earliest waits, it is
        // that time still.
        let earliest = self.earliest_ns;
        if !self
            .waiting
            .iter()
            .rev()
            .any(|waiting| Some(waiting.posted_ns) == earliest)
        {
            self.earliest_ns = self.waiting.iter().map(|waiting| waiting.posted_ns).min();
        }
        if self.waiting.is_empty() {
            self.latest_ns = 0;
        }
    }
}
