//! Frames that have come and wait for the node.

use firmware::Received;

/// At most `N` of them.
#[derive(Debug, Default)]
pub struct Inbox<const N: usize> {
    frames: heapless::Deque<Received, N>,
    lost: u32,
}

impl<const N: usize> Inbox<N> {
    /// A frame that has come. If there is no room it is left out and counted.
    pub fn push(&mut self, received: Received) {
        if self.frames.push_back(received).is_err() {
            self.lost = self.lost.saturating_add(1);
        }
    }

    /// The oldest.
    pub fn pop(&mut self) -> Option<Received> {
        self.frames.pop_front()
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
    use firmware::Port;
    use protocol::frame::{Frame, Id};
    use protocol::time::Micros;

    #[test]
    fn frames_leave_in_the_order_in_which_they_came_and_the_newest_are_lost() {
        let received = |at| Received {
            port: Port::Mp,
            at: Micros(at),
            frame: Frame::classic(Id::Standard(1), &[]).unwrap(),
        };
        let mut inbox = Inbox::<3>::default();
        for at in 0..5 {
            inbox.push(received(at));
        }
        assert_eq!(inbox.lost(), 2);
        for at in 0..3 {
            assert_eq!(inbox.pop(), Some(received(at)));
        }
        assert_eq!(inbox.pop(), None);
    }
}
