//! What one node is told about itself; everything else follows from the robot's description.

use crate::capacity::DRIVE_BUSES;
use protocol::canopen::lss::Identity;
use protocol::canopen::node::NodeId as DriveId;
use protocol::canopen::sync::DEFAULT_COB;
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

/// What is known of the drives of a robot beyond where they are; by default nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct KnownDrives<'a> {
    /// The device that the drive of an axis must be: the axis, from 0, and object 1018. One that has no node id is given
    /// that of its axis, by the layer setting services.
    pub identities: &'a [(u8, Identity)],
    /// A drive without node id that no axis names is looked for, and told, if an axis' drive does not boot.
    pub find: bool,
    /// The drives store their set-up, and when the node starts they are given it only if object 1020 tells of another.
    pub stored: bool,
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
    /// [`KnownDrives::identities`], by axis.
    pub identities: [Option<Identity>; N],
    /// [`KnownDrives::find`]
    pub find_drives: bool,
    /// [`KnownDrives::stored`]
    pub stored_setup: bool,
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
    /// Identities of drives are named for an axis that is none, twice, or on a bus that is not the node's own: two
    /// masters of layer setting on one bus would answer for each other.
    Identity {
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
            Self::Identity { axis } => write!(
                f,
                "axis {axis}: an identity is for one axis of the robot, on buses of its own"
            ),
            Self::DuplicateDrive { axis } => {
                write!(f, "axis {axis}: its drive's id is taken on this bus")
            }
        }
    }
}

impl core::error::Error for ConfigError {}

impl<const N: usize> NodeConfig<N> {
    /// The same with what is known of the drives.
    ///
    /// # Errors
    /// [`ConfigError::Identity`]
    pub fn with_drives(mut self, known: &KnownDrives<'_>) -> Result<Self, ConfigError> {
        for (axis, identity) in known.identities {
            let twice = self.identities.contains(&Some(*identity));
            match self.identities.get_mut(usize::from(*axis)) {
                Some(place) if place.is_none() && !twice => *place = Some(*identity),
                Some(_) | None => return Err(ConfigError::Identity { axis: *axis }),
            }
        }
        self.find_drives = known.find;
        self.stored_setup = known.stored;
        self.validate()?;
        Ok(self)
    }

    /// # Errors
    /// The first thing that is wrong.
    pub fn validate(&self) -> Result<(), ConfigError> {
        if !(self.velocity_factor > 0.0 && self.velocity_factor <= 1.0) {
            return Err(ConfigError::VelocityFactor);
        }
        let named = self.identities.iter().any(Option::is_some);
        if (named || self.find_drives) && self.sync_cob != DEFAULT_COB {
            return Err(ConfigError::Identity { axis: 0 });
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
        for (axis, identity) in (0_u8..8).zip(&self.identities) {
            let parts = identity.map(Identity::parts);
            for part in parts.iter().flatten() {
                digest.update(&[axis]);
                digest.update(&part.to_le_bytes());
            }
        }
        if self.find_drives {
            digest.update(b"find");
        }
        if self.stored_setup {
            digest.update(b"stored");
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
