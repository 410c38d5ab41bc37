//! One try to send a frame: its beginning and its end.

use super::attempt::{Attempt, Outcome};
use super::collision::FALLEN_BITS;
use super::confinement::{SUSPEND_BITS, State};
use super::queue::{Queue, Waiting};
use super::{Delivery, Outbox, Tap, Taps, Wire};
use protocol::budget::Bits;

/// A frame that a tap has begun to send.
#[derive(Clone, Debug)]
pub(super) struct Sending {
    pub(super) tap: Tap,
    /// If it is destroyed, it is sent again.
    pub(super) again: bool,
    pub(super) waiting: Waiting,
}

/// The frame on the bus.
#[derive(Clone, Debug)]
pub(super) struct Transmission {
    pub(super) ends_ns: u64,
    /// Whose bits are on the wire.
    pub(super) first: Sending,
    /// Those who began with the same identifier.
    pub(super) others: Vec<Sending>,
    attempt: Attempt,
}

impl Transmission {
    /// When it began, ns.
    pub(super) const fn begun_ns(&self) -> u64 {
        self.ends_ns.saturating_sub(self.attempt.length_ns)
    }

    /// Will it get to its end?
    pub(super) fn is_sound(&self) -> bool {
        self.attempt.outcome == Outcome::Sent
    }

    /// Who sends it.
    pub(super) const fn senders(&self) -> Taps {
        self.attempt.senders.with(self.attempt.from)
    }

    /// Everybody who began it, and their frames.
    pub(super) fn into_all(self) -> impl Iterator<Item = Sending> {
        core::iter::once(self.first).chain(self.others)
    }

    /// The same.
    pub(super) fn all_mut(&mut self) -> impl Iterator<Item = &mut Sending> {
        core::iter::once(&mut self.first).chain(&mut self.others)
    }
}

impl Wire {
    /// When the bus will next be idle and have an offer.
    pub(super) fn next_start_ns(&self) -> Option<u64> {
        if self.dominance.is_some() {
            return None;
        }
        // whoever comes back to the bus does not begin in the past
        let idle_from_ns = self.idle_from_ns.max(self.now_ns);
        if self.plain {
            let all = self.queues.taps.iter();
            let earliest = all.filter_map(Queue::earliest_ns).min()?;
            return Some(earliest.max(idle_from_ns));
        }
        let bit_ns = self.bit_ns();
        let each = self.queues.taps.iter().zip(&self.controllers);
        let starts = each.filter_map(|(queue, controller)| {
            let able = controller.takes_part_from(bit_ns)?;
            let able = able.max(controller.silent_until_ns);
            Some(queue.earliest_ns()?.max(able))
        });
        Some(starts.min()?.max(idle_from_ns))
    }

    /// A nominal bit, ns, rounded up.
    pub(super) const fn bit_ns(&self) -> u64 {
        self.rates.duration_ns(Bits {
            nominal: 1,
            data: 0,
        })
    }

    /// Begins the next transmission if one can begin before `until_ns`; what is posted for that
    /// very moment may still take part in the arbitration.
    pub(super) fn start(&mut self, until_ns: u64) -> bool {
        let Some(start) = self.next_start_ns().filter(|start| *start < until_ns) else {
            return false;
        };
        let mut faults = std::mem::take(&mut self.faults);
        let attempt = self.attempt(start, &mut faults);
        self.faults = faults;
        let Some(attempt) = attempt else {
            return false;
        };
        let Some(first) = self.take(attempt.from, start) else {
            return false;
        };
        let mut others = Vec::new();
        if attempt.senders != Taps::NONE {
            self.statistics.collisions += 1;
            let rivals = (0..self.controllers.len())
                .filter(|tap| *tap != attempt.from && attempt.senders.contains(*tap));
            for tap in rivals {
                others.extend(self.take(tap, start));
            }
        }
        if !self.plain {
            let bit_ns = self.bit_ns();
            for controller in &mut self.controllers {
                controller.begun(start, bit_ns);
            }
        }
        self.load.occupy(start, start + attempt.length_ns);
        self.statistics.busy_ns += attempt.length_ns;
        self.on_bus = Some(Transmission {
            ends_ns: start + attempt.length_ns,
            first,
            others,
            attempt,
        });
        true
    }

    fn take(&mut self, tap: Tap, start_ns: u64) -> Option<Sending> {
        Some(Sending {
            tap,
            again: true,
            waiting: self.queues.taps.get_mut(tap)?.take(start_ns)?,
        })
    }

    /// The try is over: counters, the frame back into its queue if it has to be sent again, and the
    /// delivery to those who have it.
    pub(super) fn finish(
        &mut self,
        transmission: Transmission,
        deliver: &mut impl FnMut(Delivery<'_>, &mut Outbox<'_>),
    ) {
        let at_ns = transmission.ends_ns;
        let Attempt {
            from,
            fallen,
            outcome,
            missed,
            ..
        } = transmission.attempt;
        let waiting = &transmission.first.waiting;
        self.idle_from_ns = self.idle_from_ns.max(at_ns);
        self.now_ns = self.now_ns.max(at_ns);
        if !self.plain || outcome != Outcome::Sent || missed != Taps::NONE {
            self.confine(&transmission);
        }
        if outcome == Outcome::Sent {
            let latency = at_ns.saturating_sub(waiting.posted_ns);
            let statistics = &mut self.statistics;
            statistics.frames += 1;
            statistics.worst_latency_ns = statistics.worst_latency_ns.max(latency);
        } else {
            self.statistics.errors += 1;
        }
        let heard = matches!(outcome, Outcome::Sent | Outcome::Doubted(_));
        if heard {
            deliver(
                Delivery {
                    at_ns,
                    posted_ns: waiting.posted_ns,
                    from,
                    frame: &waiting.frame,
                    missed,
                },
                &mut Outbox {
                    at_ns,
                    queues: &mut self.queues,
                },
            );
        }
        for sending in transmission.into_all() {
            let through = outcome == Outcome::Sent && !fallen.contains(sending.tap);
            if !through && sending.again {
                self.put_back(sending);
            }
        }
    }

    /// Its frame is where it was.
    pub(super) fn put_back(&mut self, sending: Sending) {
        if let Some(queue) = self.queues.taps.get_mut(sending.tap) {
            queue.insert(sending.waiting);
        }
    }

    /// Counts the errors and successes of a try.
    fn confine(&mut self, transmission: &Transmission) {
        let attempt = &transmission.attempt;
        let missed = attempt.missed;
        let bit_ns = self.bit_ns();
        for (tap, controller) in self.controllers.iter_mut().enumerate() {
            controller.ended(transmission.ends_ns, bit_ns);
            if !controller.takes_part() {
                continue;
            }
            let counters = &mut controller.counters;
            let (sends, fell) = (attempt.is_sender(tap), attempt.fallen.contains(tap));
            match (sends, attempt.outcome) {
                (true, _) if fell => counters.send_failed(),
                (true, Outcome::Sent) => counters.sent(),
                (true, Outcome::Destroyed { .. } | Outcome::Doubted(_)) => counters.send_failed(),
                (true, Outcome::Unacknowledged) => counters.not_acknowledged(),
                (false, Outcome::Sent) if missed.contains(tap) => counters.receive_failed(false),
                (false, Outcome::Sent | Outcome::Doubted(_)) if !missed.contains(tap) => {
                    counters.received();
                }
                (false, Outcome::Sent | Outcome::Doubted(_)) => counters.receive_failed(true),
                (false, Outcome::Destroyed { first, .. }) => {
                    counters.receive_failed(first == Some(tap));
                }
                (_, Outcome::Shorted(senders)) => {
                    if senders.contains(tap) {
                        counters.send_failed();
                    }
                }
                (false, Outcome::Unacknowledged) => {}
            }
            if sends || matches!(attempt.outcome, Outcome::Shorted(all) if all.contains(tap)) {
                controller.silent_until_ns = 0;
                match controller.counters.state() {
                    State::Active => {}
                    State::Passive => {
                        let late = if fell { FALLEN_BITS } else { 0 };
                        let silent_ns = bit_ns.saturating_mul(u64::from(SUSPEND_BITS + late));
                        controller.silent_until_ns = transmission.ends_ns + silent_ns;
                    }
                    State::BusOff => self.statistics.bus_off += 1,
                }
            }
        }
        self.refresh();
    }
}
