//! The SYNC message: the heartbeat of the cycle, at which drives latch targets and sample actuals.

use super::node::{frame, standard};
use crate::frame::Frame;

/// The identifier of SYNC by default (object 1005).
pub const DEFAULT_COB: u16 = 0x080;

/// Produces SYNC messages, optionally counted from 1 to `overflow`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SyncProducer {
    cob: u16,
    overflow: u8,
    counter: u8,
}

impl SyncProducer {
    /// A producer on identifier `cob`. `overflow` is object 1019: 2 to 240 count, anything else
    /// sends the empty message. Several masters on one wire need several identifiers.
    #[must_use]
    pub const fn new(cob: u16, overflow: u8) -> Self {
        let overflow = if overflow >= 2 && overflow <= 240 {
            overflow
        } else {
            0
        };
        Self {
            cob: cob & 0x7FF,
            overflow,
            counter: 0,
        }
    }

    /// The identifier.
    #[must_use]
    pub const fn cob(&self) -> u16 {
        self.cob
    }

    /// The next SYNC message.
    #[must_use]
    pub fn produce(&mut self) -> Frame {
        if self.overflow == 0 {
            return frame(self.cob, []);
        }
        self.counter = if self.counter >= self.overflow {
            1
        } else {
            self.counter.saturating_add(1)
        };
        frame(self.cob, [self.counter])
    }
}

/// What a SYNC message says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sync {
    /// Without a counter.
    Plain,
    /// With a counter.
    Counted(u8),
}

/// What a consumer makes of a frame on the identifier of SYNC.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Consumed {
    /// A SYNC.
    Sync(Sync),
    /// A frame of another length than object 1019 says: it is none, and worth [EMCY
    /// 8240](super::emcy::ErrorCode::SYNC_LENGTH).
    Length,
}

/// Takes SYNC messages as object 1019 wants them: `overflow` 0 without a counter, else with one; `None`
/// if the frame has another identifier.
#[must_use]
pub fn consume(cob: u16, overflow: u8, frame: &Frame) -> Option<Consumed> {
    if standard(frame) != Some(cob) {
        return None;
    }
    Some(match (decode(cob, frame), overflow) {
        (Some(Sync::Plain), 0) => Consumed::Sync(Sync::Plain),
        (Some(Sync::Counted(counter)), 1..) => Consumed::Sync(Sync::Counted(counter)),
        (Some(_) | None, _) => Consumed::Length,
    })
}

/// Reads a SYNC message on identifier `cob`; `None` if `frame` is none.
#[must_use]
pub fn decode(cob: u16, frame: &Frame) -> Option<Sync> {
    if standard(frame) != Some(cob) {
        return None;
    }
    match frame.data() {
        [] => Some(Sync::Plain),
        [counter] => Some(Sync::Counted(*counter)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::frame::Id;
    use std::vec::Vec;

    #[test]
    fn plain_golden() {
        let mut sync = SyncProducer::new(DEFAULT_COB, 0);
        let frame = sync.produce();
        assert_eq!((frame.id(), frame.data()), (Id::Standard(0x80), &[][..]));
        assert_eq!(decode(0x80, &frame), Some(Sync::Plain));
        assert_eq!(decode(0x81, &frame), None);
    }

    #[test]
    fn the_counter_runs_from_one_to_the_overflow() {
        let mut sync = SyncProducer::new(0x081, 3);
        let seen: Vec<_> = (0..5).map(|_| decode(0x081, &sync.produce())).collect();
        let counted = [1, 2, 3, 1, 2].map(|n| Some(Sync::Counted(n)));
        assert_eq!(seen, counted);
    }

    #[test]
    fn invalid_overflow_means_no_counter() {
        for overflow in [0, 1, 241, 255] {
            assert!(
                SyncProducer::new(0x80, overflow)
                    .produce()
                    .data()
                    .is_empty()
            );
        }
    }

    #[test]
    fn a_consumer_wants_the_counter_it_was_told_of() {
        let plain = frame(0x80, []);
        let counted = frame(0x80, [7]);
        let sync = |s| Some(Consumed::Sync(s));
        assert_eq!(consume(0x80, 0, &plain), sync(Sync::Plain));
        assert_eq!(consume(0x80, 10, &counted), sync(Sync::Counted(7)));
        assert_eq!(consume(0x80, 10, &plain), Some(Consumed::Length));
        assert_eq!(consume(0x80, 0, &counted), Some(Consumed::Length));
        let long = frame(0x80, [1, 2]);
        assert_eq!(consume(0x80, 10, &long), Some(Consumed::Length));
        assert_eq!(consume(0x81, 0, &plain), None);
    }

    #[test]
    fn a_sync_with_two_bytes_is_not_a_sync() {
        assert_eq!(decode(0x80, &frame(0x80, [1, 2])), None);
    }
}
