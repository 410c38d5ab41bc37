//! The slave: a device that can be given a node identifier.

use super::{BitRate, Identity, cs, with_number};
use crate::canopen::node::NodeId;

/// The node identifier on the wire of a device that has none.
pub const UNCONFIGURED: u8 = 255;

/// What a request makes the device do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// It was given a node identifier, or lost it: it counts from the next reset of the communication on.
    NodeId(Option<NodeId>),
    /// It was given a bit rate: it counts from [`Effect::Activate`] or the next reset on.
    BitRate(BitRate),
    /// Change to the new bit rate after this delay (ms), and be silent for as long again.
    Activate(u16),
    /// Keep node identifier and bit rate over power cycles.
    Store,
    /// It was let go from configuration: a device that had no node identifier and has one now boots.
    Released,
}

/// Which of several messages in a row came last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Row {
    /// Specifier of the next message in the row.
    next: u8,
}

/// The slave's state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slave {
    identity: Identity,
    /// The node identifier in force.
    active: Option<NodeId>,
    /// The one that counts after a reset of the communication.
    pending: Option<NodeId>,
    /// The one that counts after power-up.
    stored: Option<NodeId>,
    configuration: bool,
    selective: Row,
    identify: Row,
    /// The part of the identity that a fastscan is at.
    part: u8,
}

impl Slave {
    /// A device of this identity; with or without node identifier.
    #[must_use]
    pub const fn new(identity: Identity, node: Option<NodeId>) -> Self {
        Self {
            identity,
            active: node,
            pending: node,
            stored: node,
            configuration: false,
            selective: Row {
                next: cs::SWITCH_SELECTIVE,
            },
            identify: Row { next: cs::IDENTIFY },
            part: 0,
        }
    }

    /// Is it in configuration?
    #[must_use]
    pub const fn is_configuration(&self) -> bool {
        self.configuration
    }

    /// The node identifier in force.
    #[must_use]
    pub const fn active(&self) -> Option<NodeId> {
        self.active
    }

    /// The node identifier that counts after a reset of the communication.
    #[must_use]
    pub const fn pending(&self) -> Option<NodeId> {
        self.pending
    }

    /// The device was switched on or reset: what was stored is in force.
    pub const fn restart(&mut self) {
        self.pending = self.stored;
        self.reset();
    }

    /// The communication was reset: the new node identifier is in force, the slave waits.
    pub const fn reset(&mut self) {
        self.active = self.pending;
        self.configuration = false;
    }

    /// Takes the data of a frame on [`super::MASTER_COB`]: the answer to send on [`super::SLAVE_COB`],
    /// and what is to be done.
    pub fn on_request(&mut self, data: &[u8]) -> (Option<[u8; 8]>, Option<Effect>) {
        let Ok([specifier, a, b, c, d, e, f, g]) = <[u8; 8]>::try_from(data) else {
            return (None, None);
        };
        let number = u32::from_le_bytes([a, b, c, d]);
        match specifier {
            cs::SWITCH_GLOBAL => (None, self.switch(a)),
            cs::SWITCH_SELECTIVE..=cs::SWITCH_SELECTIVE_SERIAL => {
                (self.select(specifier, number), None)
            }
            cs::IDENTIFY..=cs::IDENTIFY_SERIAL_TO => (self.identify(specifier, number), None),
            cs::IDENTIFY_UNCONFIGURED => {
                let alone = self.active.is_none() && self.pending.is_none();
                (alone.then(|| empty(cs::UNCONFIGURED)), None)
            }
            cs::FASTSCAN => (self.scan(number, [e, f, g]), None),
            _ if !self.configuration => (None, None),
            cs::NODE_ID => {
                let node = NodeId::new(a);
                if node.is_none() && a != UNCONFIGURED {
                    return (Some(done(cs::NODE_ID, 1)), None);
                }
                self.pending = node;
                (Some(done(cs::NODE_ID, 0)), Some(Effect::NodeId(node)))
            }
            cs::BIT_TIMING => match BitRate::from_index(b) {
                Some(rate) if a == 0 => {
                    (Some(done(cs::BIT_TIMING, 0)), Some(Effect::BitRate(rate)))
                }
                Some(_) | None => (Some(done(cs::BIT_TIMING, 1)), None),
            },
            cs::ACTIVATE => (None, Some(Effect::Activate(u16::from_le_bytes([a, b])))),
            cs::STORE => {
                self.stored = self.pending;
                (Some(done(cs::STORE, 0)), Some(Effect::Store))
            }
            cs::INQUIRE..=cs::INQUIRE_SERIAL => {
                let part = usize::from(specifier.saturating_sub(cs::INQUIRE));
                let parts = self.identity.parts();
                let part = parts.get(part).copied();
                (part.map(|part| with_number(specifier, part, [0; 3])), None)
            }
            cs::INQUIRE_NODE_ID => {
                let node = self.active.map_or(UNCONFIGURED, NodeId::get);
                (Some(done(cs::INQUIRE_NODE_ID, node)), None)
            }
            _ => (None, None),
        }
    }

    fn switch(&mut self, mode: u8) -> Option<Effect> {
        match mode {
            0 => {
                let was = core::mem::replace(&mut self.configuration, false);
                was.then_some(Effect::Released)
            }
            1 => {
                self.configuration = true;
                None
            }
            _ => None,
        }
    }

    /// One of the four messages of "switch selective": they must come in order and all fit.
    fn select(&mut self, specifier: u8, number: u32) -> Option<[u8; 8]> {
        let part = specifier.saturating_sub(cs::SWITCH_SELECTIVE);
        let fits = self.identity.parts().get(usize::from(part)) == Some(&number);
        if !self.selective.take(specifier, cs::SWITCH_SELECTIVE, fits) || self.configuration {
            return None;
        }
        (specifier == cs::SWITCH_SELECTIVE_SERIAL).then(|| {
            self.configuration = true;
            empty(cs::SWITCHED)
        })
    }

    /// One of the six messages of "identify": they must come in order and all fit.
    fn identify(&mut self, specifier: u8, number: u32) -> Option<[u8; 8]> {
        let own = self.identity;
        let fits = match specifier.saturating_sub(cs::IDENTIFY) {
            0 => number == own.vendor,
            1 => number == own.product,
            2 => number <= own.revision,
            3 => number >= own.revision,
            4 => number <= own.serial,
            _ => number >= own.serial,
        };
        let whole = self.identify.take(specifier, cs::IDENTIFY, fits);
        (whole && specifier == cs::IDENTIFY_SERIAL_TO).then(|| empty(cs::IDENTIFIED))
    }

    /// A fastscan concerns devices without node identifier only.
    fn scan(&mut self, number: u32, [bit, part, next]: [u8; 3]) -> Option<[u8; 8]> {
        if self.active.is_some() || self.pending.is_some() || self.configuration {
            return None;
        }
        if bit == super::fastscan::START {
            self.part = 0;
            return Some(empty(cs::IDENTIFIED));
        }
        let parts = self.identity.parts();
        let own = *parts.get(usize::from(part)).filter(|_| part == self.part)?;
        let mask = u32::MAX.checked_shl(u32::from(bit))?;
        if (own ^ number) & mask != 0 {
            return None;
        }
        if bit == 0 {
            self.part = next;
            self.configuration = part == 3 && next == 0;
        }
        Some(empty(cs::IDENTIFIED))
    }
}

impl Row {
    /// Takes one message of a row that begins with `first`; do all so far fit?
    fn take(&mut self, specifier: u8, first: u8, fits: bool) -> bool {
        let in_order = specifier == first || specifier == self.next;
        self.next = if in_order && fits {
            specifier.saturating_add(1)
        } else {
            first
        };
        in_order && fits
    }
}

const fn empty(specifier: u8) -> [u8; 8] {
    [specifier, 0, 0, 0, 0, 0, 0, 0]
}

const fn done(specifier: u8, result: u8) -> [u8; 8] {
    [specifier, result, 0, 0, 0, 0, 0, 0]
}
