//! What is wrong with a wire as a whole, until somebody mends it.

use super::confinement::{DOMINANT_FIRST, DOMINANT_NEXT, State};
use super::{Disturbance, Tap, Taps, Wire};
use core::fmt;
use core::str::FromStr;

/// The sixth dominant bit in a row breaks the rule of stuffing: who only listens knows it then.
const STUFF_ERROR: u64 = 6;
/// A bit behind the arbitration of either format, where a destroyed frame is its sender's error.
const WRECKED_BIT: u32 = 40;
/// Recessive bits after which a wire that was dominant is idle.
const IDLE_BITS: u64 = 11;
/// After so many counts no counter changes any more: 32 make bus-off.
const COUNTS: u64 = 32;

/// A fault of the wire itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BusFault {
    /// A dominant level does not end. Who was sending goes bus-off; the others see errors, become error-passive and wait
    /// for the wire to be idle (ISO 11898-1:2015, 12.1.4.2 f: only a transmitter's counter leads to bus-off).
    StuckDominant,
    /// The two lines touch: nobody sees a dominant bit, not even who sends it. Everybody who tries to send goes
    /// bus-off; who only listens sees an idle wire. Of the errors within one error flag only the first counts.
    Short,
    /// The cable is cut behind this tap: those with higher numbers are on the other side, which nobody looks at.
    Cut(Tap),
    /// Every frame of this tap is destroyed behind its arbitration: a node whose transceiver is going.
    Wrecked(Tap),
}

/// A text that names no [`BusFault`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "no fault of a bus is called {0:?} (expected stuck-dominant, short, cut:TAP or wrecked:TAP)"
)]
pub struct UnknownBusFault(pub String);

impl fmt::Display for BusFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::StuckDominant => f.write_str("stuck-dominant"),
            Self::Short => f.write_str("short"),
            Self::Cut(tap) => write!(f, "cut:{tap}"),
            Self::Wrecked(tap) => write!(f, "wrecked:{tap}"),
        }
    }
}

impl FromStr for BusFault {
    type Err = UnknownBusFault;

    /// What [`fmt::Display`] writes.
    fn from_str(text: &str) -> Result<Self, UnknownBusFault> {
        let unknown = || UnknownBusFault(text.to_owned());
        match (text, text.split_once(':')) {
            ("stuck-dominant", _) => Ok(Self::StuckDominant),
            ("short", _) => Ok(Self::Short),
            (_, Some(("cut", tap))) => tap.parse().map(Self::Cut).map_err(|_| unknown()),
            (_, Some(("wrecked", tap))) => tap.parse().map(Self::Wrecked).map_err(|_| unknown()),
            _ => Err(unknown()),
        }
    }
}

/// A dominant level that does not end.
#[derive(Clone, Copy, Debug)]
pub(super) struct Dominance {
    /// Who was sending when it began.
    transmitter: Option<Tap>,
    /// When error flags began, ns.
    since_ns: u64,
    /// How often the counters went up.
    counted: u64,
}

impl Wire {
    /// Something is wrong with the wire from now on, or nothing any more. What is on it ends as it would have, unless
    /// the level is stuck: that destroys it.
    pub fn set_bus_fault(&mut self, fault: Option<BusFault>) {
        let now_ns = self.now_ns;
        if self.dominance.take().is_some() {
            self.idle_from_ns = now_ns + IDLE_BITS * self.bit_ns();
            for controller in &mut self.controllers {
                controller.released(now_ns);
            }
        }
        self.bus_fault = fault;
        for (tap, controller) in self.controllers.iter_mut().enumerate() {
            controller.cut = matches!(fault, Some(BusFault::Cut(last)) if tap > last);
        }
        if fault == Some(BusFault::StuckDominant) {
            self.become_dominant();
        }
        self.refresh();
    }

    /// What is wrong with it.
    #[must_use]
    pub const fn bus_fault(&self) -> Option<BusFault> {
        self.bus_fault
    }

    fn become_dominant(&mut self) {
        let bit_ns = self.bit_ns();
        let sending = self.on_bus.take();
        let transmitter = sending.as_ref().map(|transmission| transmission.from);
        for (tap, controller) in self.controllers.iter_mut().enumerate() {
            controller.begun(self.now_ns, bit_ns);
            if !controller.takes_part() {
                continue;
            }
            if Some(tap) != transmitter {
                controller.counters.receive_failed(false);
                continue;
            }
            controller.counters.send_failed();
            if controller.counters.state() == State::BusOff {
                self.statistics.bus_off += 1;
            }
        }
        // a sender sees its next recessive bit as dominant, the others wait for the sixth
        let seen_after = if sending.is_some() { 1 } else { STUFF_ERROR };
        self.dominance = Some(Dominance {
            transmitter,
            since_ns: self.now_ns + seen_after * bit_ns,
            counted: 0,
        });
        self.statistics.errors += 1;
        if let Some(transmission) = sending.filter(|transmission| transmission.again)
            && let Some(queue) = self.queues.taps.get_mut(transmission.from)
        {
            queue.insert(transmission.waiting);
        }
    }

    /// Counts the errors of a level that is dominant still.
    pub(super) fn dominate(&mut self) {
        let Some(mut dominance) = self.dominance else {
            return;
        };
        let bits = self.now_ns.saturating_sub(dominance.since_ns) / self.bit_ns().max(1);
        let due = if bits < DOMINANT_FIRST {
            0
        } else {
            (bits - DOMINANT_FIRST) / DOMINANT_NEXT + 1
        };
        for _ in dominance.counted..due.min(COUNTS) {
            for (tap, controller) in self.controllers.iter_mut().enumerate() {
                if !controller.takes_part() {
                    continue;
                }
                if dominance.transmitter != Some(tap) {
                    controller.counters.held_dominant();
                    continue;
                }
                controller.counters.send_failed();
                if controller.counters.state() == State::BusOff {
                    self.statistics.bus_off += 1;
                }
            }
        }
        dominance.counted = due.min(COUNTS);
        self.dominance = Some(dominance);
    }

    /// What happens to every frame of a tap.
    pub(super) fn wrecking(&self, from: Tap) -> Option<Disturbance> {
        (self.bus_fault == Some(BusFault::Wrecked(from))).then_some(Disturbance::Bit(WRECKED_BIT))
    }

    /// All that begin to send at `at_ns`.
    pub(super) fn contenders(&self, at_ns: u64) -> Taps {
        let bit_ns = self.bit_ns();
        let mut all = Taps::NONE;
        for (tap, (queue, controller)) in self.queues.taps.iter().zip(&self.controllers).enumerate()
        {
            if queue.urgency(at_ns).is_some() && controller.may_begin(at_ns, bit_ns) {
                all = all.with(tap);
            }
        }
        all
    }
}
