//! Busy time over a sliding window.

use super::LOAD_WINDOW_NS;

const PARTS: usize = 10;
const PART_NS: u64 = LOAD_WINDOW_NS / PARTS as u64;

/// The last [`PARTS`] parts of time, each with its busy time; the window slides by whole parts.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Load {
    parts: [u64; PARTS],
    /// The part in `parts[current % PARTS]`, counted from time 0.
    current: u64,
    /// Of all parts.
    sum: u64,
    busiest: u64,
}

impl Load {
    /// The bus is busy from `start` to `end`; intervals come in order and do not overlap.
    pub(super) fn occupy(&mut self, start: u64, end: u64) {
        let mut from = start;
        while from < end {
            let part = from / PART_NS;
            let until = end.min((part + 1) * PART_NS);
            self.slide(part);
            self.add(part, until - from);
            from = until;
        }
    }

    pub(super) fn busiest_ns(&self) -> u64 {
        self.busiest
    }

    fn slide(&mut self, part: u64) {
        if part >= self.current + PARTS as u64 {
            self.parts = [0; PARTS];
            self.sum = 0;
            self.current = part;
        }
        while self.current < part {
            self.current += 1;
            if let Some(oldest) = self.parts.get_mut(slot(self.current)) {
                self.sum -= *oldest;
                *oldest = 0;
            }
        }
    }

    fn add(&mut self, part: u64, busy: u64) {
        if let Some(place) = self.parts.get_mut(slot(part)) {
            *place += busy;
            self.sum += busy;
            self.busiest = self.busiest.max(self.sum);
        }
    }
}

fn slot(part: u64) -> usize {
    usize::try_from(part % PARTS as u64).unwrap_or(0)
}
