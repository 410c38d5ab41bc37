//! What goes wrong on a wire, as data.
//!
//! A [`Fault`] names a time, which frames, how many, and what happens to them. Faults are looked through in
//! the order in which they were given; a transmission suffers the first that fits. What is wrong with the wire
//! as a whole is a [`super::BusFault`].

use super::Tap;
use protocol::budget::{Bits, Rates};
use protocol::frame::Id;

/// Delimiters, acknowledge slot, end of frame and interframe space: the nominal bits after the CRC.
const TRAILER: u32 = 13;
/// Of them, the acknowledge slot is the second: whoever sees no dominant bit in it knows it at its end.
const ACKNOWLEDGE: u32 = 2;
/// Up to the last-but-one bit of the end of frame a frame can still be destroyed.
const DESTRUCTIBLE: u32 = 9;
/// An error flag; two of them, one after the other, where not all see the error at once.
const FLAG: u32 = 6;
/// Error delimiter and interframe space.
const DELIMITER: u32 = 8 + 3;

/// Some of the taps of a wire, of those numbered below 64.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Taps(u64);

impl Taps {
    /// None.
    pub const NONE: Self = Self(0);

    /// These; numbers from 64 on are left out.
    #[must_use]
    pub fn of(taps: &[Tap]) -> Self {
        taps.iter().fold(Self::NONE, |all, tap| all.with(*tap))
    }

    /// And this one.
    #[must_use]
    pub const fn with(self, tap: Tap) -> Self {
        if tap < 64 {
            Self(self.0 | 1 << tap)
        } else {
            self
        }
    }

    /// Is this one among them?
    #[must_use]
    pub const fn contains(self, tap: Tap) -> bool {
        tap < 64 && self.0 >> tap & 1 == 1
    }
}

/// What happens to a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Disturbance {
    /// A bit is wrong for everybody: the frame is destroyed and sent again. Bits are counted as they are on
    /// the wire, from 0, stuff bits included; what lies behind the frame counts as its last.
    Bit(u32),
    /// A bit is wrong for one receiver. If that is error-active, it destroys the frame for all; if it is
    /// error-passive, it alone misses it.
    BitAt {
        /// Who sees it.
        tap: Tap,
        /// Which.
        bit: u32,
    },
    /// The last-but-one bit of the end of frame is wrong for some receivers: they reject a frame that the
    /// others have. It is sent again, so those get it twice (Rufino, Veríssimo et al., "Fault-tolerant
    /// broadcasts in CAN", FTCS-28, 1998). If the sender does not live to do it, the first never get it.
    LastButOne(Taps),
}

/// Which frames suffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Those that begin then or later, ns.
    pub from_ns: u64,
    /// Only those with this identifier.
    pub id: Option<Id>,
    /// Only those of this tap.
    pub sender: Option<Tap>,
    /// So many; tries of the same frame count each.
    pub count: u32,
    /// How.
    pub disturbance: Disturbance,
}

/// The faults that are still to come.
#[derive(Clone, Debug, Default)]
pub(super) struct Faults(Vec<Fault>);

impl Faults {
    pub(super) fn push(&mut self, fault: Fault) {
        if fault.count > 0 {
            self.0.push(fault);
        }
    }

    /// What happens to a frame that begins now, if anything; `sends` says who sends it.
    pub(super) fn take(
        &mut self,
        start_ns: u64,
        sends: impl Fn(Tap) -> bool,
        id: Id,
    ) -> Option<Disturbance> {
        let fits = |fault: &Fault| {
            fault.from_ns <= start_ns
                && fault.id.is_none_or(|of| of == id)
                && fault.sender.is_none_or(&sends)
        };
        let place = self.0.iter().position(fits)?;
        let fault = self.0.get_mut(place)?;
        fault.count -= 1;
        let disturbance = fault.disturbance;
        if fault.count == 0 {
            self.0.remove(place);
        }
        Some(disturbance)
    }
}

/// How many see an error at the same time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Seen {
    /// All: their flags coincide.
    AtOnce,
    /// One or some; the others see its flag, and theirs follow. The longest case of the standard.
    OneByOne,
}

/// From the start of a frame of this length to the end of the error frame that ends it, ns.
pub(super) fn destroyed_ns(rates: Rates, length: Bits, bit: u32, seen: Seen) -> u64 {
    let flags = match seen {
        Seen::AtOnce => FLAG,
        Seen::OneByOne => 2 * FLAG,
    };
    rates.duration_ns(first_bits(length, bit.saturating_add(1), flags + DELIMITER))
}

/// From the start of a try that ends at its start bit, which the sender does not see, ns.
pub(super) fn shorted_ns(rates: Rates) -> u64 {
    rates.duration_ns(Bits {
        nominal: 1 + FLAG + DELIMITER,
        data: 0,
    })
}

/// From the start of a frame that nobody acknowledges to the end of its error frame, ns.
pub(super) fn unacknowledged_ns(rates: Rates, length: Bits) -> u64 {
    let sent = (length.nominal + length.data).saturating_sub(TRAILER) + ACKNOWLEDGE;
    rates.duration_ns(first_bits(length, sent, FLAG + DELIMITER))
}

/// From the start of a frame that is rejected in the last-but-one bit of its end, ns.
pub(super) fn doubted_ns(rates: Rates, length: Bits) -> u64 {
    destroyed_ns(rates, length, u32::MAX, Seen::OneByOne)
}

/// The first `bits` of a frame, as far as it can be destroyed, and nominal bits behind them.
fn first_bits(length: Bits, bits: u32, behind: u32) -> Bits {
    let arbitration = length.nominal.saturating_sub(TRAILER);
    let bits = bits.min(arbitration + length.data + DESTRUCTIBLE);
    let before = bits.min(arbitration);
    let data = (bits - before).min(length.data);
    Bits {
        nominal: before + (bits - before - data) + behind,
        data,
    }
}
