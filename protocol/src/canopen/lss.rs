//! Layer setting services (CiA 305): node identifiers and bit timing of devices that have none yet.
//!
//! ```text
//!   waiting ──switch global, switch selective (identity), fastscan──▶ configuration
//!           ◀───────────────────── switch global ────────────────────
//! ```
//! The master finds an unconfigured device by [`Fastscan`]: it asks for each of the 128 bits of the identity
//! whether a device is there that has it clear, and so ends with the least identity; that device is in
//! configuration then. All messages have 8 bytes; the master's are on [`MASTER_COB`], the slaves' on
//! [`SLAVE_COB`].

mod fastscan;
pub mod master;
mod slave;

pub use fastscan::{ANSWER_WINDOW, Fastscan, Scan};
pub use slave::{Effect, Slave, UNCONFIGURED};

use super::node::{NodeId, frame};
use crate::frame::Frame;

/// The identifier of the master's requests.
pub const MASTER_COB: u16 = 0x7E5;
/// The identifier of the slaves' answers.
pub const SLAVE_COB: u16 = 0x7E4;

/// Command specifiers.
mod cs {
    pub(super) const SWITCH_GLOBAL: u8 = 0x04;
    pub(super) const NODE_ID: u8 = 0x11;
    pub(super) const BIT_TIMING: u8 = 0x13;
    pub(super) const ACTIVATE: u8 = 0x15;
    pub(super) const STORE: u8 = 0x17;
    /// Vendor; product, revision and serial number follow.
    pub(super) const SWITCH_SELECTIVE: u8 = 0x40;
    pub(super) const SWITCH_SELECTIVE_SERIAL: u8 = 0x43;
    pub(super) const SWITCHED: u8 = 0x44;
    /// Vendor; product, revision from and to, serial number from and to follow.
    pub(super) const IDENTIFY: u8 = 0x46;
    pub(super) const IDENTIFY_SERIAL_TO: u8 = 0x4B;
    pub(super) const IDENTIFY_UNCONFIGURED: u8 = 0x4C;
    pub(super) const IDENTIFIED: u8 = 0x4F;
    pub(super) const UNCONFIGURED: u8 = 0x50;
    pub(super) const FASTSCAN: u8 = 0x51;
    /// Vendor; product, revision and serial number follow.
    pub(super) const INQUIRE: u8 = 0x5A;
    pub(super) const INQUIRE_SERIAL: u8 = 0x5D;
    pub(super) const INQUIRE_NODE_ID: u8 = 0x5E;
}

/// Who a device is: object 1018, sub-indices 1 to 4.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Identity {
    /// Vendor.
    pub vendor: u32,
    /// Product code.
    pub product: u32,
    /// Revision.
    pub revision: u32,
    /// Serial number.
    pub serial: u32,
}

impl Identity {
    /// The four numbers in the order of object 1018.
    #[must_use]
    pub const fn parts(self) -> [u32; 4] {
        [self.vendor, self.product, self.revision, self.serial]
    }

    /// The identity of four numbers.
    #[must_use]
    pub const fn from_parts([vendor, product, revision, serial]: [u32; 4]) -> Self {
        Self {
            vendor,
            product,
            revision,
            serial,
        }
    }
}

impl From<Identity> for crate::message::DriveIdentity {
    fn from(identity: Identity) -> Self {
        Self {
            vendor: identity.vendor,
            product: identity.product,
            revision: identity.revision,
            serial: identity.serial,
        }
    }
}

/// Bit rates of table 0 (CiA 305), by index; 5 is reserved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum BitRate {
    /// 1 Mbit/s.
    M1 = 0,
    /// 800 kbit/s.
    K800 = 1,
    /// 500 kbit/s.
    K500 = 2,
    /// 250 kbit/s.
    K250 = 3,
    /// 125 kbit/s.
    K125 = 4,
    /// 50 kbit/s.
    K50 = 6,
    /// 20 kbit/s.
    K20 = 7,
    /// 10 kbit/s.
    K10 = 8,
}

impl BitRate {
    /// The bit rate of an index of table 0.
    #[must_use]
    pub const fn from_index(index: u8) -> Option<Self> {
        Some(match index {
            0 => Self::M1,
            1 => Self::K800,
            2 => Self::K500,
            3 => Self::K250,
            4 => Self::K125,
            6 => Self::K50,
            7 => Self::K20,
            8 => Self::K10,
            _ => return None,
        })
    }
}

/// What the master asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request {
    /// All slaves into configuration, or back to waiting. Not answered.
    SwitchAll {
        /// Into configuration?
        configuration: bool,
    },
    /// A node identifier for the slave in configuration; `None` takes it away.
    NodeId(Option<NodeId>),
    /// A bit rate for the slave in configuration.
    BitRate(BitRate),
    /// Change to the new bit rate, silent for the delay (ms) before and after. Not answered.
    ActivateBitRate(u16),
    /// Keep node identifier and bit rate.
    Store,
    /// Part 0 to 3 of the identity of the slave in configuration; more is part 3.
    InquireIdentity(u8),
    /// Its node identifier.
    InquireNodeId,
    /// Are there slaves without node identifier?
    IdentifyUnconfigured,
}

impl Request {
    /// The frame.
    #[must_use]
    pub fn frame(self) -> Frame {
        let [a, b, c] = match self {
            Self::SwitchAll { configuration } => [cs::SWITCH_GLOBAL, configuration.into(), 0],
            Self::NodeId(node) => [cs::NODE_ID, node.map_or(UNCONFIGURED, NodeId::get), 0],
            Self::BitRate(rate) => [cs::BIT_TIMING, 0, rate as u8],
            Self::ActivateBitRate(delay_ms) => {
                let [low, high] = delay_ms.to_le_bytes();
                [cs::ACTIVATE, low, high]
            }
            Self::Store => [cs::STORE, 0, 0],
            Self::InquireIdentity(part) => [cs::INQUIRE.saturating_add(part.min(3)), 0, 0],
            Self::InquireNodeId => [cs::INQUIRE_NODE_ID, 0, 0],
            Self::IdentifyUnconfigured => [cs::IDENTIFY_UNCONFIGURED, 0, 0],
        };
        frame(MASTER_COB, [a, b, c, 0, 0, 0, 0, 0])
    }
}

/// The four frames that put the slave of this identity into configuration; it answers the last.
#[must_use]
pub fn switch_selective(identity: Identity) -> [Frame; 4] {
    let mut specifier = cs::SWITCH_SELECTIVE;
    identity.parts().map(|part| {
        let bytes = with_number(specifier, part, [0; 3]);
        specifier = specifier.saturating_add(1);
        frame(MASTER_COB, bytes)
    })
}

/// The six frames that ask whether slaves are there from identity `low` to `high`: vendor and product are
/// those of `low`. Slaves answer the last.
#[must_use]
pub fn identify(low: Identity, high: Identity) -> [Frame; 6] {
    let mut specifier = cs::IDENTIFY;
    let parts = [
        low.vendor,
        low.product,
        low.revision,
        high.revision,
        low.serial,
        high.serial,
    ];
    parts.map(|part| {
        let bytes = with_number(specifier, part, [0; 3]);
        specifier = specifier.saturating_add(1);
        frame(MASTER_COB, bytes)
    })
}

/// What a slave answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// The slave addressed by [`switch_selective`] is in configuration.
    Switched,
    /// A slave is in the range of [`identify`], or has the bits of a fastscan.
    Identified,
    /// A slave has no node identifier.
    Unconfigured,
    /// The node identifier, the bit rate or the storing was refused with this error code; 0 is success.
    Done {
        /// The command specifier of the request.
        request: u8,
        /// 0, 1 (out of range, not supported), 2 (access), 255 (of the maker).
        error: u8,
    },
    /// A part of the identity: 0 to 3, value.
    Part(u8, u32),
    /// The node identifier, `None` if it has none.
    NodeId(Option<NodeId>),
}

impl Answer {
    /// Reads the data of a frame on [`SLAVE_COB`].
    #[must_use]
    pub fn decode(data: &[u8]) -> Option<Self> {
        let [specifier, a, b, c, d, _, _, _] = <[u8; 8]>::try_from(data).ok()?;
        Some(match specifier {
            cs::SWITCHED => Self::Switched,
            cs::IDENTIFIED => Self::Identified,
            cs::UNCONFIGURED => Self::Unconfigured,
            cs::NODE_ID | cs::BIT_TIMING | cs::STORE => Self::Done {
                request: specifier,
                error: a,
            },
            cs::INQUIRE..=cs::INQUIRE_SERIAL => Self::Part(
                specifier.saturating_sub(cs::INQUIRE),
                u32::from_le_bytes([a, b, c, d]),
            ),
            cs::INQUIRE_NODE_ID => Self::NodeId(NodeId::new(a)),
            _ => return None,
        })
    }
}

/// Specifier, number, rest.
const fn with_number(specifier: u8, number: u32, rest: [u8; 3]) -> [u8; 8] {
    let [a, b, c, d] = number.to_le_bytes();
    let [x, y, z] = rest;
    [specifier, a, b, c, d, x, y, z]
}

#[cfg(test)]
mod master_tests;
#[cfg(test)]
mod tests;
