//! The process data this system exchanges with one axis: fixed, and small enough for six axes on
//! one classical 1 Mbit/s bus at 500 Hz.
//!
//! | PDO | when | carries | bytes |
//! |---|---|---|---|
//! | RPDO1 (csp) | latched at SYNC | controlword, target position, torque offset if mapped | 6 or 8 |
//! | RPDO2 (cst) | latched at SYNC | controlword, target torque, torque offset if mapped | 4 or 6 |
//! | TPDO1 | every SYNC | statusword, actual position, actual torque | 8 |
//! | TPDO2 | on change, at most once a millisecond | digital inputs, touch-probe status | 6 |
//!
//! With worst-case stuffing six axes need 6·(115 + 135) + 55 = 1555 bit of the 2000 a 500 Hz cycle
//! has: 78 %.
//!
//! Drives without a gear feel the whole arm: they get the torque their set-point takes as an offset (60B2). It is
//! mapped in both RPDOs, so that none is left behind when the mode changes. Four such axes take 57 %.

use super::node::{Function, NodeId};
use super::objects::index;
use super::pdo::{Communication, Entry, Mapping, Transmission};

/// Controlword and target position.
pub const RPDO1_CSP: [Entry; 2] = [
    Entry::new(index::CONTROLWORD, 0, 16),
    Entry::new(index::TARGET_POSITION, 0, 32),
];

/// The same and the torque offset.
pub const RPDO1_CSP_OFFSET: [Entry; 3] = [
    Entry::new(index::CONTROLWORD, 0, 16),
    Entry::new(index::TARGET_POSITION, 0, 32),
    Entry::new(index::TORQUE_OFFSET, 0, 16),
];

/// Controlword and target torque.
pub const RPDO2_CST: [Entry; 2] = [
    Entry::new(index::CONTROLWORD, 0, 16),
    Entry::new(index::TARGET_TORQUE, 0, 16),
];

/// The same and the torque offset.
pub const RPDO2_CST_OFFSET: [Entry; 3] = [
    Entry::new(index::CONTROLWORD, 0, 16),
    Entry::new(index::TARGET_TORQUE, 0, 16),
    Entry::new(index::TORQUE_OFFSET, 0, 16),
];

/// Statusword, actual position, actual torque.
pub const TPDO1: [Entry; 3] = [
    Entry::new(index::STATUSWORD, 0, 16),
    Entry::new(index::POSITION_ACTUAL, 0, 32),
    Entry::new(index::TORQUE_ACTUAL, 0, 16),
];

/// Digital inputs and touch-probe status.
pub const TPDO2: [Entry; 2] = [
    Entry::new(index::DIGITAL_INPUTS, 0, 32),
    Entry::new(index::TOUCH_PROBE_STATUS, 0, 16),
];

/// Communication parameters of RPDO1: latched at every SYNC.
#[must_use]
pub const fn rpdo1(node: NodeId) -> Communication {
    Communication::new(node.cob(Function::Rpdo1), Transmission::SyncCyclic(1))
}

/// Communication parameters of RPDO2: latched at every SYNC. Both RPDOs stay mapped; the node sends
/// the one that the mode of operation uses, so changing the mode needs no remapping under torque.
#[must_use]
pub const fn rpdo2(node: NodeId) -> Communication {
    Communication::new(node.cob(Function::Rpdo2), Transmission::SyncCyclic(1))
}

/// Communication parameters of TPDO1: at every SYNC.
#[must_use]
pub const fn tpdo1(node: NodeId) -> Communication {
    Communication::new(node.cob(Function::Tpdo1), Transmission::SyncCyclic(1))
}

/// Communication parameters of TPDO2: on change, inhibited for 1 ms.
#[must_use]
pub const fn tpdo2(node: NodeId) -> Communication {
    Communication::new(node.cob(Function::Tpdo2), Transmission::EventProfile).inhibit(10)
}

/// The target, and with it which RPDO carries it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// csp: position in drive units ([`crate::units::UNITS_PER_INCREMENT`] per increment).
    Position(i32),
    /// cst: torque in per mille of the rated torque (object 6076).
    Torque(i16),
}

/// The frame of RPDO1 (csp) or RPDO2 (cst); `offset` is the torque offset, per mille of the rated torque, where
/// that is mapped.
#[must_use]
pub fn command(
    node: NodeId,
    controlword: u16,
    target: Target,
    offset: Option<i16>,
) -> crate::frame::Frame {
    let [low, high] = controlword.to_le_bytes();
    match (target, offset.map(i16::to_le_bytes)) {
        (Target::Position(position), offset) => {
            let [a, b, c, d] = position.to_le_bytes();
            let cob = node.cob(Function::Rpdo1);
            match offset {
                None => super::node::frame(cob, [low, high, a, b, c, d]),
                Some([e, f]) => super::node::frame(cob, [low, high, a, b, c, d, e, f]),
            }
        }
        (Target::Torque(torque), offset) => {
            let [a, b] = torque.to_le_bytes();
            let cob = node.cob(Function::Rpdo2);
            match offset {
                None => super::node::frame(cob, [low, high, a, b]),
                Some([c, d]) => super::node::frame(cob, [low, high, a, b, c, d]),
            }
        }
    }
}

/// What TPDO1 says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Actual {
    /// Statusword.
    pub statusword: u16,
    /// Position in drive units.
    pub position: i32,
    /// Torque in per mille of the rated torque.
    pub torque: i16,
}

impl Actual {
    /// Reads the data of TPDO1; `None` if it has not 8 bytes.
    #[must_use]
    pub fn decode(data: &[u8]) -> Option<Self> {
        let [a, b, c, d, e, f, g, h] = <[u8; 8]>::try_from(data).ok()?;
        Some(Self {
            statusword: u16::from_le_bytes([a, b]),
            position: i32::from_le_bytes([c, d, e, f]),
            torque: i16::from_le_bytes([g, h]),
        })
    }

    /// The data of TPDO1.
    #[must_use]
    pub fn encode(self) -> [u8; 8] {
        let [a, b] = self.statusword.to_le_bytes();
        let [c, d, e, f] = self.position.to_le_bytes();
        let [g, h] = self.torque.to_le_bytes();
        [a, b, c, d, e, f, g, h]
    }
}

/// What TPDO2 says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Inputs {
    /// Digital inputs, object 60FD.
    pub inputs: u32,
    /// Touch-probe status, object 60B9.
    pub touch_probe: u16,
}

impl Inputs {
    /// Reads the data of TPDO2; `None` if it has not 6 bytes.
    #[must_use]
    pub fn decode(data: &[u8]) -> Option<Self> {
        let [a, b, c, d, e, f] = <[u8; 6]>::try_from(data).ok()?;
        Some(Self {
            inputs: u32::from_le_bytes([a, b, c, d]),
            touch_probe: u16::from_le_bytes([e, f]),
        })
    }
}

/// A mapping of this module; the entries are known to fit.
#[must_use]
pub fn mapping(entries: &[Entry]) -> Mapping {
    Mapping::new(entries).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mappings_have_the_lengths_of_the_bus_arithmetic() {
        let lengths = [
            mapping(&RPDO1_CSP).len(),
            mapping(&RPDO2_CST).len(),
            mapping(&RPDO1_CSP_OFFSET).len(),
            mapping(&RPDO2_CST_OFFSET).len(),
            mapping(&TPDO1).len(),
            mapping(&TPDO2).len(),
        ];
        assert_eq!(lengths, [6, 4, 8, 6, 8, 6]);
    }

    #[test]
    fn golden_frames() {
        let node = NodeId::new(4).unwrap();
        let csp = command(node, 0x000F, Target::Position(-2), None);
        assert_eq!(csp.id(), crate::frame::Id::Standard(0x204));
        assert_eq!(csp.data(), [0x0F, 0, 0xFE, 0xFF, 0xFF, 0xFF]);
        assert_eq!(
            command(node, 0x000F, Target::Torque(-1), None).data(),
            [0x0F, 0, 0xFF, 0xFF]
        );
        let with_offset = |target| command(node, 0x000F, target, Some(0x0102));
        let csp = with_offset(Target::Position(-2));
        assert_eq!(csp.id(), crate::frame::Id::Standard(0x204));
        assert_eq!(csp.data(), [0x0F, 0, 0xFE, 0xFF, 0xFF, 0xFF, 2, 1]);
        let cst = with_offset(Target::Torque(-1));
        assert_eq!(cst.id(), crate::frame::Id::Standard(0x304));
        assert_eq!(cst.data(), [0x0F, 0, 0xFF, 0xFF, 2, 1]);
        let actual = Actual {
            statusword: 0x1637,
            position: 0x0102_0304,
            torque: -3,
        };
        assert_eq!(actual.encode(), [0x37, 0x16, 4, 3, 2, 1, 0xFD, 0xFF]);
        assert_eq!(Actual::decode(&actual.encode()), Some(actual));
        let inputs = Inputs {
            inputs: 4,
            touch_probe: 3,
        };
        assert_eq!(Inputs::decode(&[4, 0, 0, 0, 3, 0]), Some(inputs));
        assert_eq!(Actual::decode(&[0; 7]), None);
        assert_eq!(Inputs::decode(&[0; 8]), None);
    }

    #[test]
    fn the_frame_and_the_mapping_agree() {
        let node = NodeId::new(4).unwrap();
        let frame = command(node, 0x1F, Target::Position(123_456), None);
        let mut values = [0; 2];
        let mut at = values.iter_mut();
        mapping(&RPDO1_CSP)
            .unpack(frame.data(), |_, value| *at.next().unwrap() = value)
            .unwrap();
        assert_eq!(values, [0x1F, 123_456]);
        let mut parts = [0x1637_u64, 77, 5].into_iter();
        let packed = mapping(&TPDO1).pack(|_| parts.next().unwrap());
        let actual = Actual {
            statusword: 0x1637,
            position: 77,
            torque: 5,
        };
        assert_eq!(packed.data(), actual.encode());
    }
}
