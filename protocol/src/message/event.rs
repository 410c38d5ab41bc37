//! What a node tells of itself, once, when it happens.

use super::Identity;
use crate::fault::Fault;
use core::fmt;
use serde::{Deserialize, Serialize};

// schema: begin

/// The phases of homing one axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum HomingPhase {
    /// Moving towards the switch.
    Coarse,
    /// Stopping and settling on the switch.
    Settle,
    /// Moving off the switch slowly.
    BackOff,
    /// Looking for the encoder index.
    Index,
    /// Homed.
    Done,
}

/// Something that happened once; class B, broadcast.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Event {
    /// The node has booted.
    Announce(Identity),
    /// Homing made progress.
    Homing {
        /// The axis, from 0.
        axis: u8,
        /// The phase it entered.
        phase: HomingPhase,
    },
    /// A fault latched.
    Fault(Fault),
    /// A drive is configured and identified.
    DriveReady {
        /// The axis, from 0.
        axis: u8,
    },
    /// Something was found out about who a drive is.
    DriveFound {
        /// The drive bus, from 0.
        bus: u8,
        /// The axis, from 0; none of a drive that no axis names.
        axis: Option<u8>,
        /// What.
        finding: DriveFinding,
        /// The identity that is named for the axis.
        expected: Option<DriveIdentity>,
        /// The identity that was read.
        got: Option<DriveIdentity>,
    },
}

/// Who a drive is: object 1018, sub-indices 1 to 4.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct DriveIdentity {
    /// Vendor.
    pub vendor: u32,
    /// Product code.
    pub product: u32,
    /// Revision.
    pub revision: u32,
    /// Serial number.
    pub serial: u32,
}

/// What a node found out about a drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum DriveFinding {
    /// It had no node id, was given that of its axis, and has stored it.
    Given,
    /// The same, but it does not store: without power it forgets it.
    NotStored,
    /// No drive answered to the identity.
    Missing,
    /// Several drives answered to the identity; none was given a node id.
    Collision,
    /// It refused the node id, with the error code of the layer setting services.
    Refused {
        /// 1 out of range, 255 of the maker.
        error: u8,
    },
    /// It has another node id, which it keeps.
    Elsewhere {
        /// Its node id.
        node: u8,
    },
    /// It has no node id, and no axis names it.
    Unnamed,
    /// The drive with the axis' node id is another one.
    Other,
    /// It did not store its set-up; it is in operation all the same.
    SetupNotStored,
}

// schema: end

impl fmt::Display for DriveIdentity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            vendor,
            product,
            revision,
            serial,
        } = self;
        write!(
            f,
            "vendor {vendor:#x}, product {product:#x}, revision {revision:#x}, serial {serial}"
        )
    }
}

impl fmt::Display for DriveFinding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Given => "its drive had no node id and was given one",
            Self::NotStored => "its drive was given a node id, but does not store it",
            Self::Missing => "no drive without node id has the identity named",
            Self::Collision => "several drives have the identity named",
            Self::Refused { error } => {
                return write!(f, "its drive refused the node id (error {error})");
            }
            Self::Elsewhere { node } => {
                return write!(f, "the drive of the identity named has node id {node}");
            }
            Self::Unnamed => "a drive without node id that no axis names",
            Self::Other => "another drive than the one named has its node id",
            Self::SetupNotStored => "its drive does not store its set-up",
        })
    }
}
