//! Node identifiers and the predefined connection set: who uses which identifier by default.

use crate::frame::{Frame, Id};

/// The identifier of a CANopen device, 1 to 127.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NodeId(u8);

impl NodeId {
    /// The least identifier.
    pub const FIRST: Self = Self(1);

    /// `None` outside 1 to 127.
    #[must_use]
    pub const fn new(id: u8) -> Option<Self> {
        if id >= 1 && id <= 127 {
            Some(Self(id))
        } else {
            None
        }
    }

    /// The number.
    #[must_use]
    pub const fn get(self) -> u8 {
        self.0
    }

    /// The 11-bit identifier of `function` for this node.
    #[must_use]
    pub const fn cob(self, function: Function) -> u16 {
        function as u16 + self.0 as u16
    }
}

/// A function of the predefined connection set; its value is the identifier of "node 0".
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u16)]
pub enum Function {
    /// EMCY, drive to node.
    Emergency = 0x080,
    /// First transmit PDO, drive to node.
    Tpdo1 = 0x180,
    /// First receive PDO, node to drive.
    Rpdo1 = 0x200,
    /// Second transmit PDO.
    Tpdo2 = 0x280,
    /// Second receive PDO.
    Rpdo2 = 0x300,
    /// Third transmit PDO.
    Tpdo3 = 0x380,
    /// Third receive PDO.
    Rpdo3 = 0x400,
    /// Fourth transmit PDO.
    Tpdo4 = 0x480,
    /// Fourth receive PDO.
    Rpdo4 = 0x500,
    /// SDO answer, server to client.
    SdoAnswer = 0x580,
    /// SDO request, client to server.
    SdoRequest = 0x600,
    /// Boot-up and heartbeat.
    Heartbeat = 0x700,
}

/// Does the network's master send this identifier, by the predefined connection set and if it is node `master`: NMT,
/// SYNC, TIME, LSS, RPDOs and their group ([`super::fast`]), SDO requests, its heartbeat.
#[must_use]
pub const fn is_from_master(cob: u16, master: NodeId) -> bool {
    const NUMBER: u16 = 0x7F;
    const LSS: u16 = 0x7E5;
    match cob & !NUMBER {
        0x000 | 0x100 => cob & NUMBER == 0,
        0x080 => cob == 0x080,
        // without a number: the group of the fast profile
        0x200 => true,
        0x300 | 0x400 | 0x500 | 0x600 => cob & NUMBER != 0,
        0x700 => cob & NUMBER == master.0 as u16,
        _ => cob == LSS,
    }
}

/// A classical frame with an 11-bit identifier and `N` bytes, of which at most 8 count.
#[must_use]
pub fn frame<const N: usize>(cob: u16, data: [u8; N]) -> Frame {
    let mut bytes = [0; 8];
    for (to, from) in bytes.iter_mut().zip(data) {
        *to = from;
    }
    Frame::short(
        Id::Standard(cob & 0x7FF),
        bytes,
        u8::try_from(N).unwrap_or(8),
    )
}

/// The 11-bit identifier of a classical frame, `None` for 29-bit or FD frames.
#[must_use]
pub const fn standard(frame: &Frame) -> Option<u16> {
    match frame.id() {
        Id::Standard(id) if !frame.is_fd() => Some(id),
        Id::Standard(_) | Id::Extended(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_master_sends_and_what_drives_send_is_told_apart() {
        let (master, drive) = (NodeId(127), NodeId(3));
        let masters = [
            Function::Rpdo1,
            Function::Rpdo2,
            Function::Rpdo3,
            Function::Rpdo4,
        ];
        for function in masters.into_iter().chain([Function::SdoRequest]) {
            assert!(is_from_master(drive.cob(function), master), "{function:?}");
        }
        for cob in [0x000, 0x080, 0x100, 0x200, 0x7E5, 0x77F] {
            assert!(is_from_master(cob, master), "{cob:03X}");
        }
        let drives = [
            Function::Tpdo1,
            Function::Tpdo2,
            Function::Tpdo3,
            Function::Tpdo4,
        ];
        let others = [
            Function::Emergency,
            Function::SdoAnswer,
            Function::Heartbeat,
        ];
        for function in drives.into_iter().chain(others) {
            assert!(!is_from_master(drive.cob(function), master), "{function:?}");
        }
        for cob in [0x001, 0x101, 0x600, 0x680, 0x7E4, 0x7FF] {
            assert!(!is_from_master(cob, master), "{cob:03X}");
        }
    }
}
