//! Cyphal/CAN identifiers: who says what, how urgently, and the table of our ports.
//!
//! Bit fields after the Cyphal Specification v1.0, section 4.2.1 (CAN ID). Towards the MP only
//! 29-bit identifiers are used, so one wire can also carry the drives' 11-bit CANopen traffic.
//!
//! ```text
//!            28..26    25    24      23   22..21  20..8        7   6..0
//! message    priority  0     anon.   0    11      subject      0   source
//! service    priority  1     req.    0    service(22..14)  destination(13..7)  source
//! ```
//!
//! ```
//! use protocol::id::{CanId, NodeId, Port, Priority, Subject};
//! let id = CanId {
//!     priority: Priority::High,
//!     source: NodeId::effector(1).unwrap(),
//!     port: Port::Message(Subject::FEEDBACK),
//! };
//! assert_eq!(CanId::parse(id.emit()), Some(id));
//! ```

use crate::frame::Id;

/// A node's number on the MP wire, 0 to 127.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NodeId(u8);

impl NodeId {
    /// The greatest node id.
    pub const MAX: u8 = 127;
    /// The coordinating process, by default.
    pub const MP: Self = Self(1);
    /// Effector j has node id `EFFECTOR_BASE + j`, j counted from 1.
    pub const EFFECTOR_BASE: u8 = 10;

    /// `None` above 127.
    #[must_use]
    pub const fn new(id: u8) -> Option<Self> {
        if id <= Self::MAX {
            Some(Self(id))
        } else {
            None
        }
    }

    /// The node of effector `E_j` by default; `None` when it would exceed 127.
    #[must_use]
    pub const fn effector(j: u8) -> Option<Self> {
        match Self::EFFECTOR_BASE.checked_add(j) {
            Some(id) => Self::new(id),
            None => None,
        }
    }

    /// The number.
    #[must_use]
    pub const fn get(self) -> u8 {
        self.0
    }

    const fn masked(bits: u32) -> Self {
        Self((bits & 0x7F) as u8)
    }
}

impl core::fmt::Display for NodeId {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{}", self.0)
    }
}

/// The eight levels of urgency; a lower number wins the arbitration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum Priority {
    /// Stop everyone.
    Exceptional = 0,
    /// Time.
    Immediate = 1,
    /// Commands.
    Fast = 2,
    /// Feedback.
    High = 3,
    /// Requests and replies.
    Nominal = 4,
    /// Heartbeats and events.
    Low = 5,
    /// Maintenance.
    Slow = 6,
    /// Traces.
    Optional = 7,
}

impl Priority {
    const fn from_bits(bits: u32) -> Self {
        match bits & 7 {
            0 => Self::Exceptional,
            1 => Self::Immediate,
            2 => Self::Fast,
            3 => Self::High,
            4 => Self::Nominal,
            5 => Self::Low,
            6 => Self::Slow,
            _ => Self::Optional,
        }
    }
}

// schema: begin

/// What a broadcast message is about, 0 to 8191; ours are in the unregulated range 0 to 6143.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Subject(u16);

impl Subject {
    /// [`crate::message::Command`] to node n has subject `COMMAND_BASE + n`.
    pub const COMMAND_BASE: u16 = 4096;
    /// [`crate::message::Feedback`]
    pub const FEEDBACK: Self = Self(4300);
    /// [`crate::message::DemandTrace`]
    pub const DEMAND_TRACE: Self = Self(4301);
    /// [`crate::message::Event`]
    pub const EVENT: Self = Self(4302);
    /// [`crate::message::StopAll`]
    pub const STOP_ALL: Self = Self(4303);
    /// [`crate::message::TimeSync`]
    pub const TIME_SYNC: Self = Self(4304);
    /// `uavcan.node.Heartbeat.1.0`: a fixed id of the standard.
    pub const HEARTBEAT: Self = Self(7509);
}

/// Which service, 0 to 511; ours are in the unregulated range 0 to 255.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Service(u16);

impl Service {
    /// [`crate::message::Request`] and [`crate::message::Reply`].
    pub const REQUEST: Self = Self(100);
    /// [`crate::maintenance::MaintenanceRequest`] and [`crate::maintenance::MaintenanceReply`].
    pub const MAINTENANCE: Self = Self(101);
    /// `uavcan.node.GetInfo.1.0`: a fixed id of the standard.
    pub const GET_INFO: Self = Self(430);
}

// schema: end

impl Subject {
    /// `None` above 8191.
    #[must_use]
    pub const fn new(id: u16) -> Option<Self> {
        if id <= 8191 { Some(Self(id)) } else { None }
    }

    /// The subject of commands to `node`.
    #[must_use]
    pub const fn command(node: NodeId) -> Self {
        Self(Self::COMMAND_BASE | node.0 as u16)
    }

    /// The number.
    #[must_use]
    pub const fn get(self) -> u16 {
        self.0
    }

    /// The node a command of this subject is for.
    #[must_use]
    pub const fn command_destination(self) -> Option<NodeId> {
        match self.0.checked_sub(Self::COMMAND_BASE) {
            Some(n) if n <= NodeId::MAX as u16 => Some(NodeId::masked(n as u32)),
            _ => None,
        }
    }
}

impl Service {
    /// `None` above 511.
    #[must_use]
    pub const fn new(id: u16) -> Option<Self> {
        if id <= 511 { Some(Self(id)) } else { None }
    }

    /// The number.
    #[must_use]
    pub const fn get(self) -> u16 {
        self.0
    }
}

/// Where a transfer goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Port {
    /// To everyone who listens to the subject.
    Message(Subject),
    /// A request to one node.
    Request(Service, NodeId),
    /// The answer to one node's request.
    Response(Service, NodeId),
}

/// A parsed 29-bit identifier.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct CanId {
    /// How urgent.
    pub priority: Priority,
    /// Who sends.
    pub source: NodeId,
    /// What, and to whom.
    pub port: Port,
}

const SERVICE: u32 = 1 << 25;
const ANONYMOUS_OR_REQUEST: u32 = 1 << 24;
const RESERVED_23: u32 = 1 << 23;
const RESERVED_7: u32 = 1 << 7;
/// Bits 22 and 21 of a message: sent as ones, ignored by receivers.
const RESERVED_ONES: u32 = 0b11 << 21;

impl CanId {
    /// The identifier on the wire.
    #[must_use]
    pub const fn emit(self) -> Id {
        Id::Extended(self.bits())
    }

    /// The 29 bits of the identifier.
    #[must_use]
    pub const fn bits(self) -> u32 {
        let common = (self.priority as u32) << 26 | self.source.0 as u32;
        let specific = match self.port {
            Port::Message(Subject(subject)) => RESERVED_ONES | (subject as u32) << 8,
            Port::Request(Service(service), to) => {
                SERVICE | ANONYMOUS_OR_REQUEST | (service as u32) << 14 | (to.0 as u32) << 7
            }
            Port::Response(Service(service), to) => {
                SERVICE | (service as u32) << 14 | (to.0 as u32) << 7
            }
        };
        common | specific
    }

    /// The meaning of an identifier; `None` for what is not Cyphal/CAN v1: standard frames,
    /// reserved bits set, anonymous messages (which this system does not use), and service
    /// transfers addressed to their own source.
    #[must_use]
    pub const fn parse(id: Id) -> Option<Self> {
        let Id::Extended(bits) = id else { return None };
        if bits & RESERVED_23 != 0 || bits > 0x1FFF_FFFF {
            return None;
        }
        let source = NodeId::masked(bits);
        let port = if bits & SERVICE == 0 {
            if bits & (ANONYMOUS_OR_REQUEST | RESERVED_7) != 0 {
                return None;
            }
            Port::Message(Subject(((bits >> 8) & 0x1FFF) as u16))
        } else {
            let service = Service(((bits >> 14) & 0x1FF) as u16);
            let to = NodeId::masked(bits >> 7);
            if to.0 == source.0 {
                return None;
            }
            if bits & ANONYMOUS_OR_REQUEST == 0 {
                Port::Response(service, to)
            } else {
                Port::Request(service, to)
            }
        };
        Some(Self {
            priority: Priority::from_bits(bits >> 26),
            source,
            port,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn known_identifiers() {
        // Heartbeat of node 42, nominal priority: the standard's example value 0x107D552A.
        let heartbeat = CanId {
            priority: Priority::Nominal,
            source: NodeId::new(42).unwrap(),
            port: Port::Message(Subject::HEARTBEAT),
        };
        assert_eq!(heartbeat.emit(), Id::Extended(0x107D_552A));
        // GetInfo request 123 -> 42, nominal, and its response.
        let (a, b) = (NodeId::new(123).unwrap(), NodeId::new(42).unwrap());
        let request = CanId {
            priority: Priority::Nominal,
            source: a,
            port: Port::Request(Service::GET_INFO, b),
        };
        assert_eq!(request.emit(), Id::Extended(0x136B_957B));
        let response = CanId {
            priority: Priority::Nominal,
            source: b,
            port: Port::Response(Service::GET_INFO, a),
        };
        assert_eq!(response.emit(), Id::Extended(0x126B_BDAA));
    }

    #[test]
    fn command_subjects_are_directed_and_unregulated() {
        for n in 0..=NodeId::MAX {
            let node = NodeId::new(n).unwrap();
            let subject = Subject::command(node);
            assert_eq!(subject.get(), Subject::COMMAND_BASE + u16::from(n));
            assert_eq!(subject.command_destination(), Some(node));
            assert!(subject.get() <= 6143);
        }
        assert_eq!(Subject::FEEDBACK.command_destination(), None);
        assert_eq!(NodeId::effector(118), None);
        assert_eq!(NodeId::effector(250), None);
    }

    proptest! {
        #[test]
        fn what_parses_is_emitted_again(bits in 0u32..=0x1FFF_FFFF) {
            if let Some(id) = CanId::parse(Id::Extended(bits)) {
                let ignored = if bits & SERVICE == 0 { RESERVED_ONES } else { 0 };
                prop_assert_eq!(id.emit(), Id::Extended(bits | ignored));
            }
        }
    }
}
