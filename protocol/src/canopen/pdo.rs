//! Process data: what a PDO carries, when it is sent, when it takes effect.
//!
//! A PDO has *communication parameters* (identifier, transmission type, inhibit time, event timer)
//! and a *mapping* (which objects, in which order). Both are written over SDO in one order only:
//! disable, count 0, entries, count, enable ([`Setup`]).

mod mapping;
mod receive;
mod setup;
mod transmit;

pub use mapping::{Entry, MAX_ENTRIES, Mapping, MappingError, Payload};
pub use receive::{Received, Rpdo};
pub use setup::{Direction, Setup, SetupWrite, Value};
pub use transmit::Tpdo;

use crate::time::Micros;

/// When a PDO is sent, or takes effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transmission {
    /// 0: at the next SYNC after a change.
    SyncAcyclic,
    /// 1 to 240: at every n-th SYNC. A received PDO takes effect at the next SYNC.
    SyncCyclic(u8),
    /// 254: on a change the maker defines.
    EventMaker,
    /// 255: on a change the profile defines. A received PDO takes effect at once.
    EventProfile,
}

impl Transmission {
    /// The transmission of a code; the remote-frame types 252, 253 and the reserved ones are none.
    #[must_use]
    pub const fn from_code(code: u8) -> Option<Self> {
        Some(match code {
            0 => Self::SyncAcyclic,
            1..=240 => Self::SyncCyclic(code),
            254 => Self::EventMaker,
            255 => Self::EventProfile,
            241..=253 => return None,
        })
    }

    /// The code of sub-index 2.
    #[must_use]
    pub const fn code(self) -> u8 {
        match self {
            Self::SyncAcyclic => 0,
            Self::SyncCyclic(n) => n,
            Self::EventMaker => 254,
            Self::EventProfile => 255,
        }
    }

    /// Does SYNC decide?
    #[must_use]
    pub const fn is_synchronous(self) -> bool {
        match self {
            Self::SyncAcyclic | Self::SyncCyclic(_) => true,
            Self::EventMaker | Self::EventProfile => false,
        }
    }
}

/// The communication parameters of one PDO.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Communication {
    /// The 11-bit identifier.
    pub cob: u16,
    /// Does the PDO exist (bit 31 of sub-index 1 clear)?
    pub enabled: bool,
    /// When.
    pub transmission: Transmission,
    /// Least time between two transmissions of an event-driven PDO, in 100 µs.
    pub inhibit_100us: u16,
    /// Transmit: greatest time between two transmissions. Receive: greatest time to wait for one.
    /// In milliseconds; 0 is off.
    pub event_ms: u16,
    /// The value of the SYNC counter with which a cyclic synchronous TPDO begins; 0: with any SYNC.
    pub sync_start: u8,
}

impl Communication {
    /// The parameters with neither inhibit time nor event timer.
    #[must_use]
    pub const fn new(cob: u16, transmission: Transmission) -> Self {
        Self {
            cob: cob & 0x7FF,
            enabled: true,
            transmission,
            inhibit_100us: 0,
            event_ms: 0,
            sync_start: 0,
        }
    }

    /// The same with an inhibit time, in multiples of 100 µs.
    #[must_use]
    pub const fn inhibit(mut self, hundred_us: u16) -> Self {
        self.inhibit_100us = hundred_us;
        self
    }

    /// The same with an event timer, in milliseconds.
    #[must_use]
    pub const fn event(mut self, ms: u16) -> Self {
        self.event_ms = ms;
        self
    }

    /// Sub-index 1: the identifier, with bit 31 set if the PDO does not exist and bit 30 set
    /// (no remote frames).
    #[must_use]
    pub const fn cob_entry(self) -> u32 {
        let disabled = if self.enabled { 0 } else { 1 << 31 };
        self.cob as u32 | 1 << 30 | disabled
    }

    const fn inhibit_time(self) -> Micros {
        Micros(self.inhibit_100us as u64 * 100)
    }

    const fn event_time(self) -> Option<Micros> {
        if self.event_ms == 0 {
            None
        } else {
            Some(Micros::from_millis(self.event_ms as u64))
        }
    }
}

#[cfg(test)]
mod tests;
