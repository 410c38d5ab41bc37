//! What one node is told about itself; everything else follows from the robot's description.

use crate::capacity::DRIVE_BUSES;
use protocol::canopen::node::NodeId as DriveId;
use protocol::force_torque::SensorNumber;
use protocol::id::NodeId;
use protocol::message::ServoLaw;
use protocol::transfer::Mtu;

/// Where the drive of an axis is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DriveAddress {
    /// Drive bus, from 0.
    pub bus: u8,
    /// CANopen node id.
    pub id: DriveId,
}

/// Where a force sensor is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ForceAddress {
    /// Drive bus, from 0.
    pub bus: u8,
    /// Its number there.
    pub number: SensorNumber,
}

/// A node's configuration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeConfig<const N: usize> {
    /// Its id on the MP bus.
    pub node: NodeId,
    /// Identifies this hardware, or this process.
    pub unique_id: u64,
    /// Frame size on the MP bus.
    pub mtu: Mtu,
    /// The drive of every axis.
    pub drives: [DriveAddress; N],
    /// COB-ID of SYNC: 080 on a wire of its own; nodes that share a drive bus need different ones.
    pub sync_cob: u16,
    /// CANopen id of the node's own heartbeat on the drive buses.
    pub master: DriveId,
    /// The drives' buses have CAN FD and speak the fast profile ([`protocol::canopen::fast`]).
    pub fast_drives: bool,
    /// How the loops are closed at start.
    pub law: ServoLaw,
    /// Fraction of the motors' hard velocity limit that may be used, (0, 1]; MRROC++'s
    /// `velocity_limit_global_factor`.
    pub velocity_factor: f64,
    /// The force sensor in the wrist, if there is one.
    pub force: Option<ForceAddress>,
}

/// Why a configuration cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConfigError {
    /// The velocity factor is not in (0, 1].
    VelocityFactor,
    /// Within the velocity limit in force there is no room to stop from full acceleration.
    NoRoomToStop {
        /// The axis, from 0.
        axis: u8,
    },
    /// A drive bus beyond [`DRIVE_BUSES`].
    DriveBus {
        /// The axis, from 0.
        axis: u8,
    },
    /// Computed torque for a robot that has no chain.
    ServoLaw,
    /// The fast profile for a drive beyond its slots.
    FastDrive {
        /// The axis, from 0.
        axis: u8,
    },
    /// Two axes have the same drive, or one has the node's own id.
    DuplicateDrive {
        /// The axis, from 0.
        axis: u8,
    },
}

impl core::fmt::Display for ConfigError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::VelocityFactor => write!(f, "velocity factor: expected 0 < factor <= 1"),
            Self::NoRoomToStop { axis } => write!(
                f,
                "axis {axis}: the velocity factor is too small: its acceleration cannot fade within the limit"
            ),
            Self::DriveBus { axis } => {
                write!(f, "axis {axis}: expected a drive bus below {DRIVE_BUSES}")
            }
            Self::ServoLaw => write!(
                f,
                "servo law: expected one that needs no masses of links; this robot has none"
            ),
            Self::FastDrive { axis } => write!(
                f,
                "axis {axis}: the fast profile has 15 drives a bus, 10 with a torque offset"
            ),
            Self::DuplicateDrive { axis } => {
                write!(f, "axis {axis}: its drive's id is taken on this bus")
            }
        }
    }
}

impl core::error::Error for ConfigError {}

impl<const N: usize> NodeConfig<N> {
    /// # Errors
    /// The first thing that is wrong.
    pub fn validate(&self) -> Result<(), ConfigError> {
        if !(self.velocity_factor > 0.0 && self.velocity_factor <= 1.0) {
            return Err(ConfigError::VelocityFactor);
        }
        for (k, drive) in self.drives.iter().enumerate() {
            let axis = u8::try_from(k).unwrap_or(u8::MAX);
            if usize::from(drive.bus) >= DRIVE_BUSES {
                return Err(ConfigError::DriveBus { axis });
            }
            let taken = self.drives.iter().take(k).any(|other| other == drive);
            if taken || drive.id == self.master {
                return Err(ConfigError::DuplicateDrive { axis });
            }
        }
        Ok(())
    }

    /// CRC-32 of everything that decides how the node behaves, for the handshake.
    #[must_use]
    pub fn crc(&self, robot: &str) -> u32 {
        let crc = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);
        let mut digest = crc.digest();
        digest.update(robot.as_bytes());
        digest.update(&self.sync_cob.to_le_bytes());
        digest.update(&[self.node.get(), self.master.get(), law_code(self.law)]);
        digest.update(&self.velocity_factor.to_le_bytes());
        for drive in &self.drives {
            digest.update(&[drive.bus, drive.id.get()]);
        }
        if self.fast_drives {
            digest.update(b"fast");
        }
        if let Some(force) = self.force {
            digest.update(b"force");
            digest.update(&force.number.force_cob().to_le_bytes());
            digest.update(&[force.bus]);
        }
        digest.finalize()
    }
}

const fn law_code(law: ServoLaw) -> u8 {
    match law {
        ServoLaw::DrivePosition => 0,
        ServoLaw::Original => 1,
        ServoLaw::FeedForward => 2,
        ServoLaw::ComputedTorque => 3,
    }
}
