//! A PDO sent: at SYNC, or on a change and within the inhibit and event times.

use super::super::sync::Sync;
use super::{Communication, Mapping, Payload, Transmission};
use crate::time::Micros;

/// The sending end of one PDO.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tpdo {
    communication: Communication,
    mapping: Mapping,
    /// SYNCs since the last transmission.
    syncs: u8,
    /// Has the SYNC come with which it begins?
    begun: bool,
    last: Option<(Micros, Payload)>,
}

impl Tpdo {
    /// The sending end with these parameters.
    #[must_use]
    pub const fn new(communication: Communication, mapping: Mapping) -> Self {
        Self {
            communication,
            mapping,
            syncs: 0,
            begun: communication.sync_start == 0,
            last: None,
        }
    }

    /// The communication parameters.
    #[must_use]
    pub const fn communication(&self) -> Communication {
        self.communication
    }

    /// The mapping.
    #[must_use]
    pub const fn mapping(&self) -> &Mapping {
        &self.mapping
    }

    /// Starts afresh: an event-driven PDO is sent once at the next poll.
    pub fn reset(&mut self) {
        self.syncs = 0;
        self.begun = self.communication.sync_start == 0;
        self.last = None;
    }

    /// Does [`Self::poll`] ever send this PDO?
    #[must_use]
    pub const fn is_event_driven(&self) -> bool {
        self.communication.enabled && !self.communication.transmission.is_synchronous()
    }

    /// At SYNC: is the PDO to be sent? `payload` is what it would carry, sampled at this SYNC.
    ///
    /// A start value counts only where SYNC is counted; the PDO goes out with that SYNC and every n-th
    /// after it.
    pub fn on_sync(&mut self, now: Micros, sync: Sync, payload: Payload) -> bool {
        if !self.communication.enabled {
            return false;
        }
        if let (Transmission::SyncCyclic(n), false) = (self.communication.transmission, self.begun)
        {
            if let Sync::Counted(counter) = sync
                && counter != self.communication.sync_start
            {
                return false;
            }
            self.begun = true;
            self.syncs = n.saturating_sub(1);
        }
        let due = match self.communication.transmission {
            Transmission::SyncAcyclic => self.last.is_none_or(|(_, last)| last != payload),
            Transmission::SyncCyclic(n) => {
                self.syncs = self.syncs.saturating_add(1);
                self.syncs >= n
            }
            Transmission::EventMaker | Transmission::EventProfile => false,
        };
        if due {
            self.syncs = 0;
            self.last = Some((now, payload));
        }
        due
    }

    /// Is an event-driven PDO to be sent: first time, changed, or event timer run out, but not
    /// within the inhibit time?
    pub fn poll(&mut self, now: Micros, payload: Payload) -> bool {
        if !self.is_event_driven() {
            return false;
        }
        let due = self.last.is_none_or(|(at, last)| {
            let age = now.since(at);
            let changed = last != payload && age >= self.communication.inhibit_time();
            changed
                || self
                    .communication
                    .event_time()
                    .is_some_and(|time| age >= time)
        });
        if due {
            self.last = Some((now, payload));
        }
        due
    }
}
