//! One try to send a frame: its beginning, its outcome and its end.

use super::confinement::{SUSPEND_BITS, State};
use super::fault::{
    Disturbance, Faults, Seen, destroyed_ns, doubted_ns, shorted_ns, unacknowledged_ns,
};
use super::queue::{Queue, Waiting};
use super::{BusFault, Delivery, Outbox, Tap, Taps, Wire};
use protocol::budget::{self, Bits, Rates};
use protocol::frame::Id;

/// What a try comes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    /// The frame is at its end; some may have missed it.
    Sent,
    /// An error frame after so many bits; the tap that saw the error first, if it was one.
    Destroyed {
        bit: u32,
        seen: Seen,
        first: Option<Tap>,
    },
    /// An error frame after the acknowledge slot.
    Unacknowledged,
    /// Some rejected it in its last-but-one bit, the others have it.
    Doubted(Taps),
    /// The wires touch: all that began saw their start bit as recessive, and nobody else saw anything.
    Shorted(Taps),
}

impl Outcome {
    /// From start of frame to the end of the interframe space, for a frame of this length.
    pub(super) fn duration_ns(self, rates: Rates, length: Bits) -> u64 {
        match self {
            Self::Sent => rates.duration_ns(length),
            Self::Destroyed { bit, seen, .. } => destroyed_ns(rates, length, bit, seen),
            Self::Unacknowledged => unacknowledged_ns(rates, length),
            Self::Doubted(_) => doubted_ns(rates, length),
            Self::Shorted(_) => shorted_ns(rates),
        }
    }
}

/// The frame on the bus.
#[derive(Clone, Debug)]
pub(super) struct Transmission {
    pub(super) ends_ns: u64,
    pub(super) from: Tap,
    /// If it is destroyed, it is sent again.
    pub(super) again: bool,
    pub(super) waiting: Waiting,
    outcome: Outcome,
    missed: Taps,
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

    /// The tap with the most urgent offer at `at_ns`.
    pub(super) fn arbitrate(&self, at_ns: u64) -> Option<Tap> {
        let bit_ns = self.bit_ns();
        let mut best: Option<(u64, Tap)> = None;
        for (tap, (queue, controller)) in self.queues.taps.iter().zip(&self.controllers).enumerate()
        {
            let able = self.plain || controller.may_begin(at_ns, bit_ns);
            if able
                && let Some(urgency) = queue.urgency(at_ns)
                && best.is_none_or(|(lowest, _)| urgency < lowest)
            {
                best = Some((urgency, tap));
            }
        }
        best.map(|(_, tap)| tap)
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
        let Some(from) = self.arbitrate(start) else {
            return false;
        };
        let Some(queue) = self.queues.taps.get_mut(from) else {
            return false;
        };
        let Some(waiting) = queue.take(start) else {
            return false;
        };
        let urgency = waiting.frame.id().arbitration();
        let rivals = self.queues.taps.iter().skip(from + 1);
        if rivals
            .filter_map(|queue| queue.urgency(start))
            .any(|other| other == urgency)
        {
            self.statistics.collisions += 1;
        }
        let mut faults = std::mem::take(&mut self.faults);
        let (outcome, missed) = self.outcome(start, from, waiting.frame.id(), &mut faults);
        self.faults = faults;
        if !self.plain {
            let bit_ns = self.bit_ns();
            for controller in &mut self.controllers {
                controller.begun(start, bit_ns);
            }
        }
        let length = outcome.duration_ns(self.rates, budget::exact(&waiting.frame));
        self.load.occupy(start, start + length);
        self.statistics.busy_ns += length;
        self.on_bus = Some(Transmission {
            ends_ns: start + length,
            from,
            again: true,
            waiting,
            outcome,
            missed,
        });
        true
    }

    /// What a try that begins now will come to, and who will miss the frame.
    pub(super) fn outcome(
        &self,
        start_ns: u64,
        from: Tap,
        id: Id,
        faults: &mut Faults,
    ) -> (Outcome, Taps) {
        let disturbance = faults.take(start_ns, from, id).or(self.wrecking(from));
        if self.bus_fault == Some(BusFault::Short) {
            return (
                Outcome::Shorted(self.contenders(start_ns).with(from)),
                Taps::NONE,
            );
        }
        if self.plain && disturbance.is_none() && self.controllers.len() > 1 {
            return (Outcome::Sent, Taps::NONE);
        }
        let mut deaf = Taps::NONE;
        let mut listeners = 0;
        for (tap, controller) in self.controllers.iter().enumerate() {
            if tap != from && controller.takes_part() {
                listeners += 1;
            } else {
                deaf = deaf.with(tap);
            }
        }
        if listeners == 0 {
            return (Outcome::Unacknowledged, deaf);
        }
        let state = |tap: Tap| self.state(tap);
        match disturbance {
            None => (Outcome::Sent, deaf),
            Some(Disturbance::Bit(bit)) => {
                // the flag of a passive sender is recessive: the others see its silence as an error
                let seen = match state(from) {
                    State::Active => Seen::AtOnce,
                    State::Passive | State::BusOff => Seen::OneByOne,
                };
                let first = None;
                (Outcome::Destroyed { bit, seen, first }, deaf)
            }
            Some(Disturbance::BitAt { tap, .. }) if deaf.contains(tap) => (Outcome::Sent, deaf),
            Some(Disturbance::BitAt { tap, bit }) => match state(tap) {
                State::Active => {
                    let (seen, first) = (Seen::OneByOne, Some(tap));
                    (Outcome::Destroyed { bit, seen, first }, deaf)
                }
                State::Passive | State::BusOff => (Outcome::Sent, deaf.with(tap)),
            },
            Some(Disturbance::LastButOne(taps)) => {
                let reject = |tap: &Tap| taps.contains(*tap) && !deaf.contains(*tap);
                let rejecting: Vec<Tap> = (0..self.controllers.len()).filter(reject).collect();
                let missed = rejecting.iter().fold(deaf, |all, tap| all.with(*tap));
                let active = rejecting.iter().any(|tap| state(*tap) == State::Active);
                if active {
                    (Outcome::Doubted(taps), missed)
                } else {
                    (Outcome::Sent, missed)
                }
            }
        }
    }

    /// The try is over: counters, the frame back into its queue if it has to be sent again, and the
    /// delivery to those who have it.
    pub(super) fn finish(
        &mut self,
        transmission: Transmission,
        deliver: &mut impl FnMut(Delivery<'_>, &mut Outbox<'_>),
    ) {
        let Transmission {
            ends_ns: at_ns,
            from,
            outcome,
            missed,
            ref waiting,
            ..
        } = transmission;
        self.idle_from_ns = at_ns;
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
        if outcome != Outcome::Sent
            && transmission.again
            && let Some(queue) = self.queues.taps.get_mut(from)
        {
            queue.insert(transmission.waiting);
        }
    }

    /// Counts the errors and successes of a try.
    fn confine(&mut self, transmission: &Transmission) {
        let (from, missed) = (transmission.from, transmission.missed);
        let bit_ns = self.bit_ns();
        for (tap, controller) in self.controllers.iter_mut().enumerate() {
            controller.ended(transmission.ends_ns, bit_ns);
            if !controller.takes_part() {
                continue;
            }
            let counters = &mut controller.counters;
            match (tap == from, transmission.outcome) {
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
            if tap == from
                || matches!(transmission.outcome, Outcome::Shorted(all) if all.contains(tap))
            {
                controller.silent_until_ns = 0;
                match controller.counters.state() {
                    State::Active => {}
                    State::Passive => {
                        let silent_ns = bit_ns.saturating_mul(u64::from(SUSPEND_BITS));
                        controller.silent_until_ns = transmission.ends_ns + silent_ns;
                    }
                    State::BusOff => self.statistics.bus_off += 1,
                }
            }
        }
        self.refresh();
    }
}
