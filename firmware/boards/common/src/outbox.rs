//! Frames that wait for a CAN controller with a few transmit buffers, of which it sends the one with the lowest
//! identifier first.
//!
//! Two rules: the most urgent frame goes first, whatever came before it (else an urgent one would wait behind the others:
//! the Cyphal specification's inner priority inversion); and frames of one identifier keep their order, which the
//! controller would not keep: so at most one of each identifier is in its buffers.

use protocol::frame::Frame;

/// At most `N` frames that wait.
#[derive(Clone, Debug, Default)]
pub struct Outbox<const N: usize> {
    /// In the order in which they came.
    waiting: heapless::Vec<Frame, N>,
    lost: u32,
}

impl<const N: usize> Outbox<N> {
    /// Empty.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            waiting: heapless::Vec::new(),
            lost: 0,
        }
    }

    /// A frame to be sent. If there is no room it is left out and counted.
    pub fn push(&mut self, frame: Frame) {
        if self.waiting.push(frame).is_err() {
            self.lost = self.lost.saturating_add(1);
        }
    }

    /// The next frame for a controller that holds frames of these identifiers ([`protocol::frame::Id::arbitration`]).
    pub fn take(&mut self, held: &[u64]) -> Option<Frame> {
        let urgency = |frame: &Frame| frame.id().arbitration();
        let (at, _) = (0..N)
            .zip(&self.waiting)
            .filter(|(_, frame)| !held.contains(&urgency(frame)))
            // the first of equals
            .min_by_key(|(_, frame)| urgency(frame))?;
        if at < self.waiting.len() {
            Some(self.waiting.remove(at))
        } else {
            None
        }
    }

    /// Nothing of this is to be sent any more: the controller went bus-off.
    pub fn clear(&mut self) {
        self.waiting.clear();
    }

    /// Frames left out so far.
    #[must_use]
    pub const fn lost(&self) -> u32 {
        self.lost
    }
}

#[cfg(test)]
mod test {
    use super::*;
    use proptest::prelude::*;
    use protocol::frame::Id;
    use std::vec::Vec;

    fn frame(id: u16, number: u8) -> Frame {
        Frame::classic(Id::Standard(id), &[number]).unwrap()
    }

    #[test]
    fn the_most_urgent_goes_first_and_equals_in_their_order() {
        let mut outbox = Outbox::<8>::new();
        for (id, number) in [(0x601, 0), (0x201, 1), (0x80, 2), (0x201, 3)] {
            outbox.push(frame(id, number));
        }
        let order: Vec<_> = core::iter::from_fn(|| outbox.take(&[])).collect();
        assert_eq!(
            order,
            [
                frame(0x80, 2),
                frame(0x201, 1),
                frame(0x201, 3),
                frame(0x601, 0)
            ]
        );
    }

    #[test]
    fn a_frame_does_not_overtake_one_of_its_identifier_in_the_controller() {
        let mut outbox = Outbox::<8>::new();
        outbox.push(frame(0x201, 1));
        outbox.push(frame(0x601, 2));
        let held = [Id::Standard(0x201).arbitration()];
        assert_eq!(outbox.take(&held), Some(frame(0x601, 2)));
        assert_eq!(outbox.take(&held), None);
        assert_eq!(outbox.take(&[]), Some(frame(0x201, 1)));
    }

    #[test]
    fn what_finds_no_room_is_counted() {
        let mut outbox = Outbox::<2>::new();
        for number in 0..5 {
            outbox.push(frame(0x201, number));
        }
        assert_eq!(outbox.lost(), 3);
        assert_eq!(outbox.take(&[]), Some(frame(0x201, 0)));
        outbox.clear();
        assert_eq!(outbox.take(&[]), None);
    }

    proptest! {
        /// A controller of three buffers that sends the lowest identifier first: every frame is sent once, those of
        /// one identifier in their order, and none waits behind a less urgent one but for that which is on the wire.
        #[test]
        fn whatever_waits_is_sent_in_order(ids in proptest::collection::vec(0_u16..6, 0..60)) {
            let mut outbox = Outbox::<60>::new();
            for (number, id) in (0..).zip(&ids) {
                outbox.push(frame(*id, number));
            }
            let (mut held, mut sent) = (Vec::<Frame>::new(), Vec::new());
            loop {
                while held.len() < 3 {
                    let ids: Vec<_> = held.iter().map(|f| f.id().arbitration()).collect();
                    let Some(next) = outbox.take(&ids) else { break };
                    held.push(next);
                }
                let next = (0..held.len()).min_by_key(|k| held[*k].id().arbitration());
                let Some(next) = next else { break };
                sent.push(held.remove(next));
            }
            let mut wanted: Vec<_> = (0..).zip(&ids).map(|(n, id)| frame(*id, n)).collect();
            // stable: by identifier, then by number. All were there from the start
            wanted.sort_by_key(|f| f.id().arbitration());
            prop_assert_eq!(sent, wanted);
        }
    }
}
