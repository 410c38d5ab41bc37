//! Who begins when the wire is idle, and what the try will come to.

use super::confinement::State;
use super::fault::{
    Disturbance, Faults, Seen, destroyed_ns, doubted_ns, shorted_ns, unacknowledged_ns,
};
use super::{BusFault, Tap, Taps, Wire};
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

/// What a try that begins now comes to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Attempt {
    /// Who sends; of several whose bits are equal the lowest.
    pub(super) from: Tap,
    /// All that begin with the same identifier, if it is not `from` alone.
    pub(super) senders: Taps,
    /// Of them those that saw a bit error and are error-passive: they fell silent, and the frame went on.
    pub(super) fallen: Taps,
    pub(super) outcome: Outcome,
    pub(super) missed: Taps,
    pub(super) length_ns: u64,
}

impl Attempt {
    pub(super) fn is_sender(&self, tap: Tap) -> bool {
        tap == self.from || self.senders.contains(tap)
    }
}

impl Wire {
    /// The lowest of the taps with the most urgent offer at `at_ns`, and the others of them.
    fn arbitrate(&self, at_ns: u64) -> Option<(Tap, Taps)> {
        let bit_ns = self.bit_ns();
        let mut best: Option<(u64, Tap)> = None;
        let mut rivals = Taps::NONE;
        for (tap, (queue, controller)) in self.queues.taps.iter().zip(&self.controllers).enumerate()
        {
            let able = self.plain || controller.may_begin(at_ns, bit_ns);
            let Some(urgency) = queue.urgency(at_ns).filter(|_| able) else {
                continue;
            };
            match best {
                Some((lowest, _)) if urgency > lowest => {}
                Some((lowest, _)) if urgency == lowest => rivals = rivals.with(tap),
                _ => {
                    best = Some((urgency, tap));
                    rivals = Taps::NONE;
                }
            }
        }
        best.map(|(_, tap)| (tap, rivals))
    }

    /// Who begins at `start_ns`, and what it will come to.
    pub(super) fn attempt(&self, start_ns: u64, faults: &mut Faults) -> Option<Attempt> {
        let (lowest, rivals) = self.arbitrate(start_ns)?;
        let offer = |tap: Tap| self.queues.taps.get(tap)?.offer(start_ns);
        let mut attempt = Attempt {
            from: lowest,
            senders: Taps::NONE,
            fallen: Taps::NONE,
            outcome: Outcome::Sent,
            missed: Taps::NONE,
            length_ns: 0,
        };
        let alone = rivals == Taps::NONE || self.bus_fault == Some(BusFault::Short);
        let collided = if alone {
            None
        } else {
            attempt.senders = rivals.with(lowest);
            let collision = self.collide(start_ns, lowest, attempt.senders);
            (attempt.from, attempt.fallen) = (collision.from, collision.fallen);
            collision.destroyed
        };
        let frame = offer(attempt.from)?;
        (attempt.outcome, attempt.missed) = match collided {
            Some(outcome) => (outcome, Taps::NONE),
            None => self.outcome(start_ns, &attempt, frame.id(), faults),
        };
        attempt.length_ns = attempt
            .outcome
            .duration_ns(self.rates, budget::exact(frame));
        Some(attempt)
    }

    /// What a try that begins now will come to, and who will miss the frame.
    fn outcome(
        &self,
        start_ns: u64,
        attempt: &Attempt,
        id: Id,
        faults: &mut Faults,
    ) -> (Outcome, Taps) {
        let sends = |tap: Tap| attempt.is_sender(tap) && !attempt.fallen.contains(tap);
        let disturbance = faults.take(start_ns, sends, id).or(self.wrecking(sends));
        if self.bus_fault == Some(BusFault::Short) {
            return (
                Outcome::Shorted(self.contenders(start_ns).with(attempt.from)),
                Taps::NONE,
            );
        }
        let together = attempt.senders != Taps::NONE;
        if self.plain && disturbance.is_none() && !together && self.controllers.len() > 1 {
            return (Outcome::Sent, Taps::NONE);
        }
        let mut deaf = Taps::NONE;
        let mut listeners = 0;
        for (tap, controller) in self.controllers.iter().enumerate() {
            if !attempt.is_sender(tap) && controller.takes_part() {
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
                let mut taps = 0..self.controllers.len();
                let seen = if taps.any(|tap| sends(tap) && state(tap) == State::Active) {
                    Seen::AtOnce
                } else {
                    Seen::OneByOne
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
}
