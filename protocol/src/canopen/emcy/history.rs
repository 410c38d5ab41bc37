//! What is kept of emergencies (object 1003), and when they may be sent (object 1015).

use heapless::{Deque, Vec};

use super::{Emergency, ErrorCode};
use crate::time::Micros;

/// The pre-defined error field, object 1003: the last `N` errors, the newest first.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct History<const N: usize> {
    /// Oldest first.
    entries: Deque<u32, N>,
}

impl<const N: usize> History<N> {
    /// Nothing happened.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            entries: Deque::new(),
        }
    }

    /// Keeps an error with 16 bits of the maker; the oldest makes room. "No error" is none.
    pub fn push(&mut self, code: ErrorCode, detail: u16) {
        if code == ErrorCode::NONE {
            return;
        }
        if self.entries.is_full() {
            self.entries.pop_front();
        }
        // there is room now, unless N is 0
        let _ = self
            .entries
            .push_back(u32::from(detail) << 16 | u32::from(code.0));
    }

    /// Forgets all: 0 was written to sub-index 0.
    pub fn clear(&mut self) {
        self.entries.clear();
    }

    /// Sub-index 0: how many there are.
    #[must_use]
    pub fn len(&self) -> u8 {
        u8::try_from(self.entries.len()).unwrap_or(u8::MAX)
    }

    /// Is there none?
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Sub-index 1 (the newest) and up.
    #[must_use]
    pub fn get(&self, sub: u8) -> Option<u32> {
        let age = usize::from(sub).checked_sub(1)?;
        self.entries.iter().rev().nth(age).copied()
    }
}

/// Emergencies on their way out: no two closer than the inhibit time; at most `N` wait.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Producer<const N: usize> {
    inhibit: Micros,
    last: Option<Micros>,
    waiting: Vec<Emergency, N>,
}

impl<const N: usize> Producer<N> {
    /// With the inhibit time of object 1015 (which is in 100 µs).
    #[must_use]
    pub const fn new(inhibit_100us: u16) -> Self {
        Self {
            inhibit: Micros(inhibit_100us as u64 * 100),
            last: None,
            waiting: Vec::new(),
        }
    }

    /// Object 1015 was written.
    pub const fn set_inhibit(&mut self, inhibit_100us: u16) {
        self.inhibit = Micros(inhibit_100us as u64 * 100);
    }

    /// An emergency is to be sent. Where no more can wait, the newest that waits makes room: the first
    /// error says most, the last how it ended.
    pub fn push(&mut self, emergency: Emergency) {
        if self.waiting.is_full() {
            self.waiting.pop();
        }
        // there is room now, unless N is 0
        let _ = self.waiting.push(emergency);
    }

    /// Forgets what waits: the device is reset.
    pub fn reset(&mut self) {
        self.waiting.clear();
        self.last = None;
    }

    /// The next emergency, if one may be sent now.
    pub fn due(&mut self, now: Micros) -> Option<Emergency> {
        if self.waiting.is_empty() || self.last.is_some_and(|last| now.since(last) < self.inhibit) {
            return None;
        }
        self.last = Some(now);
        Some(self.waiting.remove(0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_error_comes_first_and_the_oldest_makes_room() {
        let mut history = History::<2>::new();
        assert!(history.is_empty());
        history.push(ErrorCode::OVER_CURRENT, 0);
        history.push(ErrorCode::NONE, 0);
        history.push(ErrorCode::SYNC_LOST, 0x1234);
        assert_eq!(history.len(), 2);
        assert_eq!(
            (history.get(1), history.get(2)),
            (Some(0x1234_8700), Some(0x2310))
        );
        history.push(ErrorCode::HARDWARE, 0);
        assert_eq!(
            (history.get(1), history.get(2)),
            (Some(0x5400), Some(0x1234_8700))
        );
        assert_eq!((history.get(0), history.get(3)), (None, None));
        history.clear();
        assert_eq!((history.len(), history.get(1)), (0, None));
    }

    #[test]
    fn emergencies_keep_the_inhibit_time() {
        let emergency = |code| Emergency {
            code,
            ..Emergency::default()
        };
        let mut producer = Producer::<2>::new(10);
        assert_eq!(producer.due(Micros(0)), None);
        for code in [
            ErrorCode::OVER_CURRENT,
            ErrorCode::SYNC_LOST,
            ErrorCode::NONE,
        ] {
            producer.push(emergency(code));
        }
        assert_eq!(
            producer.due(Micros(5)),
            Some(emergency(ErrorCode::OVER_CURRENT))
        );
        assert_eq!(producer.due(Micros(1004)), None);
        assert_eq!(producer.due(Micros(1005)), Some(emergency(ErrorCode::NONE)));
        assert_eq!(producer.due(Micros(9999)), None);
        let mut producer = Producer::<2>::new(0);
        producer.push(emergency(ErrorCode::SYNC_LOST));
        producer.reset();
        assert_eq!(producer.due(Micros(0)), None);
    }
}
