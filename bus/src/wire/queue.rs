//! The transmit queue of one tap: most urgent first, first come first served among equals.
//!
//! With as many mailboxes as frames that is all. With fewer, the oldest frames fill them, and only those
//! arbitrate: an urgent frame may wait behind less urgent ones (inner priority inversion).

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
#[derive(Clone, Debug)]
pub(super) struct Queue {
    /// Sorted by (urgency, number), the most urgent last.
    waiting: Vec<Waiting>,
    /// The least `posted_ns` of `waiting`.
    earliest_ns: Option<u64>,
    /// The greatest.
    latest_ns: u64,
    mailboxes: usize,
}

impl Default for Queue {
    fn default() -> Self {
        Self {
            waiting: Vec::new(),
            earliest_ns: None,
            latest_ns: 0,
            mailboxes: usize::MAX,
        }
    }
}

impl Queue {
    pub(super) fn len(&self) -> usize {
        self.waiting.len()
    }

    pub(super) fn clear(&mut self) {
        self.waiting.clear();
        self.refresh();
    }

    /// At least one.
    pub(super) fn set_mailboxes(&mut self, mailboxes: usize) {
        self.mailboxes = mailboxes.max(1);
    }

    pub(super) fn push(&mut self, posted_ns: u64, number: u64, frame: Frame) {
        self.insert(Waiting {
            posted_ns,
            frame,
            urgency: frame.id().arbitration(),
            number,
        });
    }

    /// A frame that was taken and did not get through: it is where it was.
    pub(super) fn insert(&mut self, waiting: Waiting) {
        let key = (waiting.urgency, waiting.number);
        let posted_ns = waiting.posted_ns;
        let place = self
            .waiting
            .partition_point(|other| (other.urgency, other.number) > key);
        self.waiting.insert(place, waiting);
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
        if self.waiting.len() > self.mailboxes {
            return self.best_of_mailboxes(at_ns);
        }
        if self.latest_ns <= at_ns {
            return self.waiting.len().checked_sub(1);
        }
        self.waiting
            .iter()
            .rposition(|waiting| waiting.posted_ns <= at_ns)
    }

    /// The most urgent of the oldest frames.
    fn best_of_mailboxes(&self, at_ns: u64) -> Option<usize> {
        let ready = |waiting: &&Waiting| waiting.posted_ns <= at_ns;
        let mut numbers: Vec<u64> = self
            .waiting
            .iter()
            .filter(ready)
            .map(|w| w.number)
            .collect();
        numbers.sort_unstable();
        let youngest = numbers
            .get(self.mailboxes.checked_sub(1)?)
            .or(numbers.last())?;
        let in_mailbox = |w: &Waiting| w.posted_ns <= at_ns && w.number <= *youngest;
        self.waiting.iter().rposition(in_mailbox)
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
