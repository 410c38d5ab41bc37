//! On a hub: which drives have answered the last SYNC, so that a late answer can be awaited.
//!
//! A hub is TCP between processes and not a bus in real time: whoever the operating system lets
//! wait is late, without any drive being at fault. There, and only there, the node is called when
//! the drives that answered the SYNC before have answered this one, or after [`PATIENCE`].

use protocol::frame::{Frame, Id};
use protocol::time::Micros;

/// How long an answer is awaited: a drive that has gone is noticed soon after.
pub(crate) const PATIENCE: Micros = Micros::from_millis(200);

/// COB-IDs of the first transmit PDO, less the node id (CiA 301).
const TPDO1: u16 = 0x180;
/// Greatest CANopen node id.
const DRIVES: u16 = 127;

/// The answers on one drive bus. Bit k: drive k.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Answers {
    before: u128,
    now: u128,
    awaited: bool,
}

impl Answers {
    /// The node sent a frame.
    pub(crate) fn sent(&mut self, frame: &Frame) {
        // of all frames to the drives only SYNC carries nothing
        if frame.data().is_empty() {
            self.before = self.now;
            self.now = 0;
            self.awaited = true;
        }
    }

    /// A drive sent a frame.
    pub(crate) fn received(&mut self, frame: &Frame) {
        if let Id::Standard(id) = frame.id()
            && let Some(drive @ 1..=DRIVES) = id.checked_sub(TPDO1)
        {
            self.now |= 1 << drive;
        }
    }

    /// Is an answer missing?
    pub(crate) const fn missing(&self) -> bool {
        self.awaited && self.before & !self.now != 0
    }

    /// Nothing is awaited until the next SYNC.
    pub(crate) const fn settle(&mut self) {
        self.awaited = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(id: u16, data: &[u8]) -> Frame {
        Frame::classic(Id::Standard(id), data).unwrap()
    }

    #[test]
    fn awaits_those_who_answered_the_sync_before() {
        let sync = frame(0x80, &[]);
        let mut answers = Answers::default();
        answers.sent(&sync);
        assert!(!answers.missing(), "nobody has ever answered");
        answers.received(&frame(0x181, &[1]));
        answers.received(&frame(0x182, &[1]));
        answers.received(&frame(0x701, &[5]));
        answers.received(&frame(0x200, &[5]));
        answers.sent(&frame(0x201, &[1]));
        assert!(!answers.missing());
        answers.sent(&sync);
        assert!(answers.missing());
        answers.received(&frame(0x182, &[1]));
        assert!(answers.missing());
        answers.settle();
        assert!(!answers.missing());
        answers.sent(&sync);
        answers.received(&frame(0x182, &[1]));
        assert!(
            !answers.missing(),
            "a drive that did not answer is awaited once"
        );
    }
}
