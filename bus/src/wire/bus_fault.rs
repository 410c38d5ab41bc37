//! What is wrong with a wire as a whole, until somebody mends it.

use super::{Disturbance, Tap, Taps, Wire};
use core::fmt;
use core::str::FromStr;

/// A bit behind the arbitration of either format, where a destroyed frame is its sender's error.
const WRECKED_BIT: u32 = 40;
/// Recessive bits after which a wire that was dominant is idle.
const IDLE_BITS: u64 = 11;
/// A fault of the wire itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BusFault {
    /// A dominant level does not end. Who was sending goes bus-off, unless its frame was in its arbitration still: then it
    /// has lost it. All others see errors, become error-passive and wait for the wire to be idle, which it never is; so
    /// nobody begins to send, and only a transmitter's counter leads to bus-off (ISO 11898-1:2015, 12.1.4.2 f).
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

impl Wire {
    /// Something is wrong with the wire from now on, or nothing any more. What is on it ends as it would have, unless
    /// the level is stuck: that destroys it.
    pub fn set_bus_fault(&mut self, fault: Option<BusFault>) {
        let now_ns = self.now_ns;
        if self.dominance.take().is_some() {
            self.idle_from_ns = self.idle_from_ns.max(now_ns + IDLE_BITS * self.bit_ns());
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

    /// What happens to every frame of a tap, if that is one of those who send.
    pub(super) fn wrecking(&self, sends: impl Fn(Tap) -> bool) -> Option<Disturbance> {
        let wrecked = matches!(self.bus_fault, Some(BusFault::Wrecked(tap)) if sends(tap));
        wrecked.then_some(Disturbance::Bit(WRECKED_BIT))
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
