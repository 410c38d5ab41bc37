//! One of the node's CAN ports: a controller, the frames that wait for it, and its way back from bus-off.

use crate::mcan::{BUFFERS, Counts, MCan, Sent, Words};
use crate::outbox::Outbox;
use crate::time_base::stamped;
use firmware::{Port, Received};
use protocol::frame::Frame;
use protocol::time::Micros;

/// A controller that went bus-off stays away for so long: drives and node have stopped by then, each for itself.
pub const AWAY: Micros = Micros::from_millis(100);

/// A port on which at most `N` frames wait.
#[derive(Debug)]
pub struct CanPort<W, const N: usize> {
    port: Port,
    can: MCan<W>,
    outbox: Outbox<N>,
    off_since: Option<Micros>,
}

impl<W: Words, const N: usize> CanPort<W, N> {
    /// This controller is this port.
    pub const fn new(port: Port, can: MCan<W>) -> Self {
        Self {
            port,
            can,
            outbox: Outbox::new(),
            off_since: None,
        }
    }

    /// The controller's interrupt: takes what has come, sends what waits. `now`: the time, read behind its beginning.
    pub fn interrupt(&mut self, now: Micros, mut deliver: impl FnMut(Received)) {
        self.can.acknowledge();
        // as many as both queues hold; what comes meanwhile is another interrupt
        for _ in 0..2 * BUFFERS {
            let Some((frame, stamp)) = self.can.receive() else {
                break;
            };
            deliver(Received {
                port: self.port,
                at: stamped(now, stamp),
                frame,
            });
        }
        self.can.transmit(&mut self.outbox);
    }

    /// A frame to be sent.
    pub fn send(&mut self, frame: Frame) {
        self.outbox.push(frame);
        self.can.transmit(&mut self.outbox);
    }

    /// At every tick: leaves bus-off when its time has come, with nothing to say of what was to be said before.
    pub fn tend(&mut self, now: Micros) {
        if !self.can.is_bus_off() {
            self.off_since = None;
            return;
        }
        let since = *self.off_since.get_or_insert(now);
        if now.since(since) >= AWAY {
            self.off_since = None;
            self.outbox.clear();
            self.can.rejoin();
        }
    }

    /// When the frame was sent of which that is told.
    pub fn sent(&mut self) -> Option<Sent> {
        self.can.sent()
    }

    /// What the controller counted, and the frames that found no room to wait.
    pub const fn counts(&self) -> (Counts, u32) {
        (self.can.counts(), self.outbox.lost())
    }
}

#[cfg(test)]
mod test {
    use super::*;
    use crate::mcan::test::{Model, drives, frame, started};
    use core::cell::RefCell;
    use std::rc::Rc;
    use std::vec::Vec;

    fn port() -> (Rc<RefCell<Model>>, CanPort<impl Words, 8>) {
        let (model, can) = started(&drives());
        (model, CanPort::new(Port::Drives(1), can))
    }

    #[test]
    fn frames_come_with_their_port_and_the_time_at_which_they_began() {
        let (model, mut port) = port();
        let now = Micros(7_000_000_000);
        for axis in 1..=6_u16 {
            let began = now.0 - 100 * u64::from(axis);
            let stamp = u16::try_from(began & 0xFFFF).unwrap();
            assert!(model.borrow_mut().receive(&frame(0x180 + axis, 0), stamp));
        }
        let mut got = Vec::new();
        port.interrupt(now, |received| got.push(received));
        assert_eq!(got.len(), 6);
        for received in &got {
            let protocol::frame::Id::Standard(id) = received.frame.id() else {
                panic!("11 bits");
            };
            let began = now.0 - 100 * u64::from(id - 0x180);
            assert_eq!(
                (received.port, received.at),
                (Port::Drives(1), Micros(began))
            );
        }
    }

    #[test]
    fn what_waits_is_sent_with_the_next_interrupts() {
        let (model, mut port) = port();
        for number in 0..3 {
            port.send(frame(0x201, number));
        }
        for stamp in 0..3 {
            model.borrow_mut().send(stamp);
            port.interrupt(Micros(0), |_| {});
        }
        let numbers: Vec<_> = model.borrow().wire().iter().map(|f| f.data()[0]).collect();
        assert_eq!(numbers, [0, 1, 2]);
    }

    #[test]
    fn it_comes_back_from_bus_off_behind_100_ms_and_forgets_what_it_had_to_say() {
        let (model, mut port) = port();
        for number in 0..9 {
            port.send(frame(0x201, number));
        }
        assert_eq!(port.counts().1, 0);
        model.borrow_mut().go_off();
        port.interrupt(Micros(1000), |_| {});
        assert_eq!(port.counts().0.bus_off, 1);
        port.tend(Micros(1000));
        port.tend(Micros(100_999));
        assert!(model.borrow().is_off());
        port.tend(Micros(101_000));
        assert!(!model.borrow().is_off());
        port.interrupt(Micros(101_500), |_| {});
        model.borrow_mut().send(0);
        assert!(model.borrow().wire().is_empty());
        // it is as good as new
        port.send(frame(0x80, 1));
        model.borrow_mut().send(0);
        assert_eq!(model.borrow().wire(), [frame(0x80, 1)]);
    }
}
