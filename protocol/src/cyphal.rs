//! The two standard Cyphal messages a node must know, so that third-party monitors see it:
//! `uavcan.node.Heartbeat.1.0` and `uavcan.node.GetInfo.1.0`, in their DSDL layout (little endian).

use crate::message::{Identity, NodeState};

/// `uavcan.node.Health.1.0`
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Health {
    /// Functioning.
    Nominal = 0,
    /// Something deserves attention.
    Advisory = 1,
    /// A fault is latched.
    Caution = 2,
    /// Out of order.
    Warning = 3,
}

/// `uavcan.node.Mode.1.0`
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Mode {
    /// In service.
    Operational = 0,
    /// Starting.
    Initialization = 1,
    /// Being serviced.
    Maintenance = 2,
    /// Being updated.
    SoftwareUpdate = 3,
}

/// `uavcan.node.Heartbeat.1.0`: subject 7509, 7 bytes, once a second.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Heartbeat {
    /// Seconds since boot.
    pub uptime_s: u32,
    /// Health.
    pub health: Health,
    /// Mode.
    pub mode: Mode,
    /// Ours: the number of the [`NodeState`] variant; 255 for the MP.
    pub status: u8,
}

impl Heartbeat {
    /// Bytes on the wire.
    pub const LEN: usize = 7;
    /// The status of a coordinator, which has no [`NodeState`].
    pub const STATUS_MP: u8 = 255;

    /// Of a node in `state`.
    #[must_use]
    pub const fn of_node(uptime_s: u32, state: NodeState) -> Self {
        let (health, mode) = match state {
            NodeState::Boot | NodeState::Configuring => (Health::Nominal, Mode::Initialization),
            NodeState::Faulted => (Health::Caution, Mode::Operational),
            NodeState::Disabled
            | NodeState::Enabling
            | NodeState::Unsynchronised
            | NodeState::Synchronising
            | NodeState::Holding
            | NodeState::Moving
            | NodeState::Stopping => (Health::Nominal, Mode::Operational),
        };
        Self {
            uptime_s,
            health,
            mode,
            status: state as u8,
        }
    }

    /// Of a coordinator.
    #[must_use]
    pub const fn of_mp(uptime_s: u32) -> Self {
        Self {
            uptime_s,
            health: Health::Nominal,
            mode: Mode::Operational,
            status: Self::STATUS_MP,
        }
    }

    /// The bytes.
    #[must_use]
    pub const fn emit(self) -> [u8; Self::LEN] {
        let [a, b, c, d] = self.uptime_s.to_le_bytes();
        [a, b, c, d, self.health as u8, self.mode as u8, self.status]
    }

    /// The meaning of the bytes. As the standard demands, longer payloads are cut and shorter ones
    /// are read as if zeros followed; unknown modes are read as maintenance.
    #[must_use]
    pub fn parse(payload: &[u8]) -> Self {
        let at = |k: usize| payload.get(k).copied().unwrap_or(0);
        Self {
            uptime_s: u32::from_le_bytes([at(0), at(1), at(2), at(3)]),
            health: match at(4) & 3 {
                0 => Health::Nominal,
                1 => Health::Advisory,
                2 => Health::Caution,
                _ => Health::Warning,
            },
            mode: match at(5) & 7 {
                0 => Mode::Operational,
                1 => Mode::Initialization,
                3 => Mode::SoftwareUpdate,
                _ => Mode::Maintenance,
            },
            status: at(6),
        }
    }
}

/// The longest name of `uavcan.node.GetInfo.1.0`, bytes.
const MAX_INFO_NAME: usize = 50;

/// The longest [`NodeInfo`] on the wire, bytes (no image CRC and no certificate are sent).
pub const MAX_INFO: usize = 6 + 8 + 16 + 1 + MAX_INFO_NAME + 1 + 1;

/// What `uavcan.node.GetInfo.1.0` answers: version, unique id and name of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NodeInfo<'a> {
    /// Hardware version: major, minor.
    pub hardware: (u8, u8),
    /// Software version: major, minor.
    pub software: (u8, u8),
    /// Revision in the version control system, e.g. the first 64 bits of the commit; 0 = unknown.
    pub vcs_revision: u64,
    /// Unique id, 128 bits.
    pub unique_id: [u8; 16],
    /// Name, reversed domain style by convention; cut at 50 bytes.
    pub name: &'a str,
}

impl<'a> NodeInfo<'a> {
    /// Of a node's [`Identity`]: the 64-bit unique id stands in the low half, the name is the
    /// robot's.
    #[must_use]
    pub fn of(identity: &'a Identity) -> Self {
        let mut unique_id = [0; 16];
        for (place, byte) in unique_id.iter_mut().zip(identity.unique_id.to_le_bytes()) {
            *place = byte;
        }
        let (major, minor, _) = identity.firmware;
        Self {
            hardware: (0, 0),
            software: (major, minor),
            vcs_revision: 0,
            unique_id,
            name: &identity.robot,
        }
    }

    /// The bytes, in `buffer`.
    pub fn emit<'b>(&self, buffer: &'b mut [u8; MAX_INFO]) -> &'b [u8] {
        const CYPHAL_VERSION: [u8; 2] = [1, 0];
        let name = self.name.as_bytes();
        let name = name.get(..MAX_INFO_NAME).unwrap_or(name);
        let name_len = u8::try_from(name.len()).unwrap_or(0);
        let bytes = CYPHAL_VERSION
            .into_iter()
            .chain([
                self.hardware.0,
                self.hardware.1,
                self.software.0,
                self.software.1,
            ])
            .chain(self.vcs_revision.to_le_bytes())
            .chain(self.unique_id)
            .chain([name_len])
            .chain(name.iter().copied())
            .chain([0, 0]); // image CRC: none; certificate: empty
        let mut len = 0usize;
        for (place, byte) in buffer.iter_mut().zip(bytes) {
            *place = byte;
            len = len.saturating_add(1);
        }
        buffer.get(..len).unwrap_or(&[])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn heartbeat_bytes() {
        let heartbeat = Heartbeat::of_node(0x0102_0304, NodeState::Faulted);
        assert_eq!(heartbeat.emit(), [4, 3, 2, 1, 2, 0, 9]);
        assert_eq!(Heartbeat::of_mp(1).emit(), [1, 0, 0, 0, 0, 0, 255]);
        assert_eq!(
            Heartbeat::of_node(0, NodeState::Boot).mode,
            Mode::Initialization
        );
    }

    #[test]
    fn info_bytes() {
        let info = NodeInfo {
            hardware: (1, 2),
            software: (3, 4),
            vcs_revision: 0x0807_0605_0403_0201,
            unique_id: [0xAA; 16],
            name: "irp6",
        };
        let mut buffer = [0; MAX_INFO];
        let mut expected = [1, 0, 1, 2, 3, 4, 1, 2, 3, 4, 5, 6, 7, 8].to_vec();
        expected.extend([0xAA; 16]);
        expected.extend(*b"\x04irp6\0\0");
        assert_eq!(info.emit(&mut buffer), expected);
        let long = "n".repeat(70);
        let info = NodeInfo {
            name: &long,
            ..info
        };
        assert_eq!(info.emit(&mut buffer).len(), MAX_INFO);
    }

    proptest! {
        #[test]
        fn heartbeats_survive(uptime_s: u32, health in 0u8..4, mode in 0u8..4, status: u8) {
            let bytes = {
                let [a, b, c, d] = uptime_s.to_le_bytes();
                [a, b, c, d, health, mode, status]
            };
            prop_assert_eq!(Heartbeat::parse(&bytes).emit(), bytes);
        }

        #[test]
        fn any_heartbeat_is_read(bytes in proptest::collection::vec(any::<u8>(), 0..20)) {
            let _ = Heartbeat::parse(&bytes);
        }
    }
}
