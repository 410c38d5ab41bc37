//! A PDO received: held back until SYNC if it is synchronous.

use super::{Communication, Mapping, Payload};
use crate::time::Micros;

/// What became of a received PDO.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Received {
    /// It waits for SYNC; a PDO that waited before is replaced.
    Latched,
    /// It takes effect now.
    Now(Payload),
    /// It is shorter than the mapping: ignored, the device must say so (EMCY 8210).
    WrongLength,
    /// The PDO is disabled.
    Disabled,
}

/// The receiving end of one PDO.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rpdo {
    communication: Communication,
    mapping: Mapping,
    waiting: Option<Payload>,
    deadline: Option<Micros>,
}

impl Rpdo {
    /// The receiving end with these parameters.
    #[must_use]
    pub const fn new(communication: Communication, mapping: Mapping) -> Self {
        Self {
            communication,
            mapping,
            waiting: None,
            deadline: None,
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

    /// Takes the data of a frame with this PDO's identifier.
    pub fn on_data(&mut self, now: Micros, data: &[u8]) -> Received {
        if !self.communication.enabled {
            return Received::Disabled;
        }
        let payload = Payload::new(data).filter(|_| data.len() >= self.mapping.len());
        let Some(payload) = payload else {
            return Received::WrongLength;
        };
        self.deadline = self.communication.event_time().map(|time| now + time);
        if self.communication.transmission.is_synchronous() {
            self.waiting = Some(payload);
            return Received::Latched;
        }
        Received::Now(payload)
    }

    /// At SYNC: the payload that waited, if one did.
    pub fn on_sync(&mut self) -> Option<Payload> {
        self.waiting.take()
    }

    /// Forgets what waits and stops the event timer (the device left Operational).
    pub fn reset(&mut self) {
        self.waiting = None;
        self.deadline = None;
    }

    /// Did the event timer run out? Tells it once; the timer starts with the first PDO.
    pub fn timed_out(&mut self, now: Micros) -> bool {
        match self.deadline {
            Some(deadline) if now > deadline => {
                self.deadline = None;
                true
            }
            Some(_) | None => false,
        }
    }
}
