//! A step of the node on a board: what has come, what is due, what is sent, and the emergency stop's call.

use crate::time_base;
use firmware::{NodeProcess, Port, Received};
use protocol::budget::Rates;
use protocol::frame::Frame;
use protocol::id::NodeId;
use protocol::link::{Endpoint, Role};
use protocol::message::{StopAll, StopKind};
use protocol::time::Micros;
use protocol::transfer::Mtu;

/// A step may be so late and still be told the instant it was due for: less than the time to the next tick.
const IN_TIME: Micros = Micros(500);
/// The panel of effector j speaks on the MP bus as node `PANEL_BASE + j`.
pub const PANEL_BASE: u8 = 100;
/// The first calls follow each other so closely (`docs/wire.md`), the later ones so.
const SOON: Micros = Micros::from_millis(5);
const LATER: Micros = Micros::from_millis(100);
/// How many calls follow each other closely.
const CLOSE_CALLS: u8 = 3;

/// What the tick wants of the node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Call {
    /// To stop so.
    pub kind: StopKind,
    /// And everybody else on the MP bus too.
    pub everybody: bool,
}

/// The node and the voice of its panel.
#[derive(Debug)]
pub struct Rim<'a> {
    node: &'a mut (dyn NodeProcess + Send),
    rates: Rates,
    panel: Endpoint<1>,
    /// The call of the step before, how often it was made, and when next.
    calling: Option<Call>,
    calls: u8,
    next_call: Micros,
    late: u32,
}

impl<'a> Rim<'a> {
    /// The node of this effector, whose MP bus has these bit rates.
    pub fn new(
        node: &'a mut (dyn NodeProcess + Send),
        effector: u8,
        mtu: Mtu,
        rates: Rates,
    ) -> Self {
        let panel = NodeId::new(PANEL_BASE.saturating_add(effector)).unwrap_or(NodeId::MP);
        Self {
            node,
            rates,
            panel: Endpoint::new(panel, Role::Observer, mtu),
            calling: None,
            calls: 0,
            next_call: Micros(0),
            late: 0,
        }
    }

    /// The node.
    #[must_use]
    pub fn node(&self) -> &(dyn NodeProcess + Send) {
        self.node
    }

    /// Steps that came a tick or more too late.
    #[must_use]
    pub const fn late(&self) -> u32 {
        self.late
    }

    /// Whatever is due at `now`. `received`: with the times at which the frames began; those that the node took are
    /// taken out of it.
    pub fn step<const N: usize>(
        &mut self,
        now: Micros,
        received: &mut heapless::Vec<Received, N>,
        call: Option<Call>,
        send: &mut impl FnMut(Port, Frame),
    ) {
        self.call(now, received, call, send);
        let due = self.node.next_wake();
        if now < due {
            return;
        }
        // what was due counts, not when the processor came to it; but one who is a tick late has to be told so
        let told = if now.since(due) < IN_TIME {
            due
        } else {
            self.late = self.late.saturating_add(1);
            now
        };
        for frame in received.iter_mut().filter(|r| r.port == Port::Mp) {
            frame.at = time_base::ended(frame.at, &frame.frame, self.rates);
        }
        self.node
            .step(told, received, &mut |port, frame| send(port, frame));
        received.clear();
    }

    fn call<const N: usize>(
        &mut self,
        now: Micros,
        received: &mut heapless::Vec<Received, N>,
        call: Option<Call>,
        send: &mut impl FnMut(Port, Frame),
    ) {
        if call != self.calling {
            self.calling = call;
            self.calls = 0;
            self.next_call = now;
        }
        let Some(call) = call else { return };
        if now < self.next_call {
            return;
        }
        self.calls = self.calls.saturating_add(1);
        let pause = if self.calls < CLOSE_CALLS {
            SOON
        } else {
            LATER
        };
        self.next_call = now + pause;
        let stop = StopAll { kind: call.kind };
        // a stop is short enough for every frame; and one that could not be said is said again
        let _ = self.panel.send_stop_all(&stop, &mut |frame| {
            let own = Received {
                port: Port::Mp,
                at: now,
                frame,
            };
            // the newest of a full queue gives way: nothing is more urgent than this
            if received.is_full() {
                let _ = received.pop();
            }
            let _ = received.push(own);
            if call.everybody {
                send(Port::Mp, frame);
            }
        });
    }
}

#[cfg(test)]
mod test {
    use super::*;
    use protocol::frame::Id;
    use protocol::message::{Identity, NodeState};
    use std::vec;
    use std::vec::Vec;

    /// A node that is due every millisecond and writes down what it is told.
    #[derive(Debug)]
    struct Scribe {
        due: Micros,
        told: Vec<(Micros, Vec<Received>)>,
        listener: Endpoint<4>,
        stops: Vec<StopKind>,
    }

    impl Scribe {
        fn new() -> Self {
            Self {
                due: Micros(1000),
                told: vec![],
                listener: Endpoint::new(NodeId::effector(2).unwrap(), Role::Node, Mtu::Fd),
                stops: vec![],
            }
        }
    }

    impl NodeProcess for Scribe {
        fn step(&mut self, now: Micros, rx: &[Received], tx: &mut dyn FnMut(Port, Frame)) {
            self.told.push((now, rx.to_vec()));
            for received in rx {
                let heard = self.listener.receive(&received.frame, received.at);
                if let Some(protocol::link::Message::StopAll(stop)) = heard.map(|i| i.message) {
                    self.stops.push(stop.kind);
                }
            }
            self.due = now + Micros(1000);
            tx(
                Port::Drives(0),
                Frame::classic(Id::Standard(0x80), &[]).unwrap(),
            );
        }
        fn next_wake(&self) -> Micros {
            self.due
        }
        fn state(&self) -> NodeState {
            NodeState::Holding
        }
        fn identity(&self) -> Identity {
            unreachable!("nobody asks")
        }
    }

    type Queue = heapless::Vec<Received, 8>;

    fn frame(port: Port, at: u64) -> Received {
        Received {
            port,
            at: Micros(at),
            frame: Frame::classic(Id::Extended(7), &[1; 8]).unwrap(),
        }
    }

    #[test]
    fn the_node_is_told_the_instant_it_asked_for_unless_it_is_a_tick_late() {
        let mut node = Scribe::new();
        let mut rim = Rim::new(&mut node, 2, Mtu::Fd, Rates::FD_1M_5M);
        let mut sent = 0;
        for now in [500, 999, 1000, 1500, 2499, 3100, 4600] {
            rim.step(Micros(now), &mut Queue::new(), None, &mut |_, _| sent += 1);
        }
        assert_eq!((sent, rim.late()), (4, 1));
        let told: Vec<_> = node.told.iter().map(|(at, _)| at.0).collect();
        // 2499 is 499 late, 3100 is 100 late, 4600 is 600 late
        assert_eq!(told, [1000, 2000, 3000, 4600]);
    }

    #[test]
    fn frames_wait_for_the_step_and_those_of_the_mp_are_given_the_time_of_their_end() {
        let mut node = Scribe::new();
        let mut rim = Rim::new(&mut node, 2, Mtu::Fd, Rates::CLASSIC_1M);
        let mut queue =
            Queue::from_slice(&[frame(Port::Mp, 300), frame(Port::Drives(0), 300)]).unwrap();
        rim.step(Micros(500), &mut queue, None, &mut |_, _| {});
        assert_eq!(queue.len(), 2);
        rim.step(Micros(1000), &mut queue, None, &mut |_, _| {});
        assert!(queue.is_empty());
        let [mp, drive] = &node.told[0].1[..] else {
            panic!("two frames")
        };
        assert_eq!(drive.at, Micros(300));
        // a 29-bit frame of 8 bytes has 131 to 160 bits
        assert!((431..=460).contains(&mp.at.0), "{:?}", mp.at);
    }

    #[test]
    fn a_call_reaches_the_node_and_everybody_else_thrice_and_then_every_100_ms() {
        let mut node = Scribe::new();
        let mut rim = Rim::new(&mut node, 2, Mtu::Fd, Rates::FD_1M_5M);
        let call = Call {
            kind: StopKind::Quick,
            everybody: true,
        };
        let (mut queue, mut sent) = (Queue::new(), vec![]);
        for now in (500..400_000).step_by(500) {
            let call = (now >= 10_000).then_some(call);
            rim.step(Micros(now), &mut queue, call, &mut |port, _| {
                if port == Port::Mp {
                    sent.push(now);
                }
            });
        }
        assert_eq!(sent, [10_000, 15_000, 20_000, 120_000, 220_000, 320_000]);
        assert_eq!(node.stops, [StopKind::Quick; 6]);
    }

    #[test]
    fn a_call_for_this_node_alone_is_not_heard_on_the_bus_and_a_full_queue_does_not_stop_it() {
        let mut node = Scribe::new();
        let mut rim = Rim::new(&mut node, 2, Mtu::Classic, Rates::CLASSIC_1M);
        let call = Call {
            kind: StopKind::TorqueOff,
            everybody: false,
        };
        let mut queue = Queue::new();
        while queue.push(frame(Port::Drives(0), 0)).is_ok() {}
        let mut ports = vec![];
        rim.step(Micros(1000), &mut queue, Some(call), &mut |port, _| {
            ports.push(port);
        });
        assert_eq!(ports, [Port::Drives(0)]);
        assert_eq!(node.stops, [StopKind::TorqueOff]);
    }
}
