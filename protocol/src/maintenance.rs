//! The second service of a node: who it is, why it started, what its first fault looked like, and its next image.
//!
//! These types are part of message set v0: they stay as they are within a major version of the protocol, so that a
//! node whose other messages differ can still be asked and updated. Variants are added at the end only.

use crate::fault::Fault;
use crate::message::{MAX_NAME, NodeState};
use crate::units::PerAxis;
use serde::{Deserialize, Serialize};

// schema: begin

/// The longest name of a target, bytes.
pub const MAX_TARGET: usize = 24;

/// Bytes of an image in one [`MaintenanceRequest::WriteImage`]; a multiple of every flash's write size.
pub const IMAGE_CHUNK: usize = 256;

/// Samples in one [`MaintenanceReply::Samples`].
pub const SAMPLE_BATCH: usize = 3;

/// A request to the maintenance service; every one is answered by one [`MaintenanceReply`].
///
/// Anyone may read. What carries an epoch is for the holder of the lease, and only while torque is off.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum MaintenanceRequest {
    /// Who are you?
    Identify,
    /// Why did you start?
    ResetCause,
    /// What was the first fault?
    FirstFault,
    /// Samples of the record of the first fault, from a number on; the oldest is 0.
    Samples {
        /// [`FaultRecord::record`]
        record: u32,
        /// Number of the first sample.
        first: u16,
    },
    /// Forget the record of the first fault; recording goes on.
    ClearFault {
        /// The epoch of the lease.
        epoch: u32,
        /// [`FaultRecord::record`]
        record: u32,
    },
    /// How far is the next image?
    Image,
    /// An image follows; answered by [`MaintenanceReply::Image`]. The image that is under way already goes on
    /// where it was.
    BeginImage {
        /// The epoch of the lease.
        epoch: u32,
        /// What it is.
        header: ImageHeader,
    },
    /// A part of the image; answered by [`MaintenanceReply::Image`], whose `next` says which is wanted.
    WriteImage {
        /// The epoch of the lease.
        epoch: u32,
        /// The image: [`ImageHeader::crc`].
        image: u32,
        /// Where the part begins, bytes.
        offset: u32,
        /// The part: [`IMAGE_CHUNK`] bytes, but for the last.
        bytes: heapless::Vec<u8, IMAGE_CHUNK>,
    },
    /// Everything was sent: read it back, compare the CRC, make the slot valid.
    VerifyImage {
        /// The epoch of the lease.
        epoch: u32,
        /// The image: [`ImageHeader::crc`].
        image: u32,
    },
    /// Start the verified image on trial at the next reset.
    ActivateImage {
        /// The epoch of the lease.
        epoch: u32,
        /// The image: [`ImageHeader::crc`].
        image: u32,
    },
    /// The image that runs on trial is good: keep it.
    ConfirmImage {
        /// The epoch of the lease.
        epoch: u32,
    },
    /// Forget the image that is under way.
    AbortImage {
        /// The epoch of the lease.
        epoch: u32,
    },
    /// Start anew once this is answered: what an activated image waits for. The lease and everything that was
    /// not kept are forgotten.
    Restart {
        /// The epoch of the lease.
        epoch: u32,
    },
}

/// The answer to a [`MaintenanceRequest`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum MaintenanceReply {
    /// Done.
    Done,
    /// To [`MaintenanceRequest::Identify`].
    Identity(NodeIdentity),
    /// To [`MaintenanceRequest::ResetCause`].
    Reset(ResetReport),
    /// There is no record of a fault.
    NoFault,
    /// To [`MaintenanceRequest::FirstFault`].
    FirstFault(FaultRecord),
    /// To [`MaintenanceRequest::Samples`]; empty beyond the last.
    Samples {
        /// The record they are of.
        record: u32,
        /// Number of the first.
        first: u16,
        /// The samples.
        samples: heapless::Vec<Sample, SAMPLE_BATCH>,
    },
    /// How the transfer of an image stands.
    Image(ImageStatus),
    /// Refused; nothing changed.
    Refused(MaintenanceRefusal),
}

/// Who a node is, down to the image it runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NodeIdentity {
    /// The robot, e.g. `irp6-track`.
    pub robot: heapless::String<MAX_NAME>,
    /// What images must be made for, e.g. `stm32g474`.
    pub target: heapless::String<MAX_TARGET>,
    /// Unique id of the hardware, or of the process on a host.
    pub unique_id: u64,
    /// Protocol version: major, minor.
    pub protocol: (u8, u8),
    /// Hash of every message type.
    pub schema_hash: u64,
    /// CRC of the configuration the node runs with.
    pub config_crc: u32,
    /// Version of the program that runs: major, minor, patch.
    pub firmware: (u8, u8, u8),
    /// The slot it was started from; a node without slots cannot be updated by the bus.
    pub image: Option<RunningImage>,
}

/// One of the two places an image can be in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Slot {
    /// The first.
    A,
    /// The second.
    B,
}

/// How the image that runs was chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Standing {
    /// It is kept: it starts until another is activated.
    Confirmed,
    /// It was started on trial: if it is not confirmed the other starts at the next reset.
    Trial,
    /// The other was on trial and not confirmed, or is damaged.
    RolledBack,
}

/// The image a node was started from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RunningImage {
    /// Where it is.
    pub slot: Slot,
    /// Its version, as its header says.
    pub version: (u8, u8, u8),
    /// CRC-32 of its bytes.
    pub crc: u32,
    /// How it was chosen.
    pub standing: Standing,
}

/// Why a node started.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ResetCause {
    /// Nothing tells.
    Unknown,
    /// Power came on; on a host: it started for the first time.
    PowerOn,
    /// The reset pin.
    Pin,
    /// The supply sagged.
    BrownOut,
    /// The program asked for it; on a host: the process before ended as it should.
    Software,
    /// A watchdog; the program before no longer did what it should.
    Watchdog,
    /// The option bytes were loaded anew, or a forbidden low-power mode was entered.
    Option,
    /// On a host: the process before vanished without ending.
    Vanished,
}

/// Why and when a node started.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ResetReport {
    /// Why.
    pub cause: ResetCause,
    /// Starts since the memory of it was new, this one included.
    pub boots: u32,
    /// Servo steps since this start.
    pub steps: u32,
    /// Servo step, µs.
    pub servo_step_us: u32,
}

/// The first fault since the last one was acknowledged or cleared, and how much was recorded before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FaultRecord {
    /// Names this record: another has another number.
    pub record: u32,
    /// Who, what, when, and what it interrupted.
    pub fault: Fault,
    /// Id of the instruction it interrupted, 0 = none.
    pub instruction: u32,
    /// The start (counted as [`ResetReport::boots`]) in which it happened.
    pub boot: u32,
    /// Faults after it, which are not recorded.
    pub later: u16,
    /// Samples that can be read.
    pub samples: u16,
    /// Servo step, µs.
    pub servo_step_us: u32,
}

/// The signals of one servo step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// The servo step.
    pub step: u32,
    /// The state of the node.
    pub state: NodeState,
    /// Code of the latched fault; 0 = none.
    pub fault: u16,
    /// One per axis.
    pub axes: PerAxis<AxisSample>,
}

/// The signals of one axis. What does not fit a number is the number's end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct AxisSample {
    /// Actual motor position from zero, increments.
    pub actual: i32,
    /// Demand less actual position, tenths of an increment.
    pub error: i16,
    /// Motor current, mA: the torque by the torque constant.
    pub current_ma: i16,
}

/// What an image is, before its first byte.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ImageHeader {
    /// The robot it controls.
    pub robot: heapless::String<MAX_NAME>,
    /// What it is made for.
    pub target: heapless::String<MAX_TARGET>,
    /// Its version.
    pub version: (u8, u8, u8),
    /// Hash of its message types.
    pub schema_hash: u64,
    /// Its length, bytes.
    pub length: u32,
    /// CRC-32 (ISO-HDLC) of its bytes: names it.
    pub crc: u32,
}

/// How far an image is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ImagePhase {
    /// Nothing is under way.
    None,
    /// Parts are missing.
    Receiving,
    /// Every byte is there and the CRC fits.
    Verified,
    /// It will start on trial at the next reset.
    Activated,
}

/// How the transfer of an image stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ImageStatus {
    /// The slot that is written: the one that does not run.
    pub slot: Slot,
    /// How far it is.
    pub phase: ImagePhase,
    /// The image under way; 0 = none.
    pub image: u32,
    /// The byte that is wanted next.
    pub next: u32,
    /// The longest image, bytes.
    pub capacity: u32,
}

/// Why a maintenance request was refused. Nothing changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum MaintenanceRefusal {
    /// The sender does not hold the lease, or speaks of an old epoch.
    NoLease {
        /// The epoch now valid.
        epoch: u32,
    },
    /// Torque is on: switch it off first.
    TorqueOn {
        /// The state the node is in.
        state: NodeState,
    },
    /// This node has no slots.
    NoSlots,
    /// The image is for another robot.
    WrongRobot,
    /// The image is for other hardware.
    WrongTarget,
    /// The image is empty or too long.
    WrongLength {
        /// The longest image, bytes.
        capacity: u32,
    },
    /// No image is under way.
    NoTransfer,
    /// Another image is under way.
    OtherImage {
        /// Its CRC.
        image: u32,
    },
    /// The part reaches beyond the end, is empty, or is not a whole part.
    WrongPart {
        /// The byte that is wanted next.
        next: u32,
    },
    /// The part differs from what was written there before.
    Differs {
        /// Where it begins.
        offset: u32,
    },
    /// Parts are missing.
    Incomplete {
        /// The byte that is wanted next.
        next: u32,
    },
    /// The bytes do not have the CRC that was announced.
    WrongCrc {
        /// What they have.
        got: u32,
    },
    /// Verify it first.
    NotVerified,
    /// The image that runs is not on trial.
    NotOnTrial,
    /// There is no such record.
    NoRecord,
    /// The memory does not do what it should.
    Storage,
    /// The image that runs is on trial, and the other slot has what it falls back to: confirm it first.
    Unconfirmed,
}

// schema: end

/// What images are made for, by its name; `None` if that is longer than [`MAX_TARGET`].
#[must_use]
pub fn target(name: &str) -> Option<heapless::String<MAX_TARGET>> {
    name.try_into().ok()
}

impl MaintenanceRequest {
    /// The epoch of the lease that it claims, if it changes something.
    #[must_use]
    pub const fn epoch(&self) -> Option<u32> {
        match self {
            Self::Identify
            | Self::ResetCause
            | Self::FirstFault
            | Self::Samples { .. }
            | Self::Image => None,
            Self::ClearFault { epoch, .. }
            | Self::BeginImage { epoch, .. }
            | Self::WriteImage { epoch, .. }
            | Self::VerifyImage { epoch, .. }
            | Self::ActivateImage { epoch, .. }
            | Self::ConfirmImage { epoch }
            | Self::AbortImage { epoch }
            | Self::Restart { epoch } => Some(*epoch),
        }
    }
}

impl core::fmt::Display for MaintenanceRefusal {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::NoLease { epoch } => {
                write!(f, "the command lease is not ours (epoch {epoch} is valid)")
            }
            Self::TorqueOn { state } => {
                write!(
                    f,
                    "torque is on (the node is {state:?}); switch it off first"
                )
            }
            Self::NoSlots => f.write_str("the node has no slots for images"),
            Self::WrongRobot => f.write_str("the image is for another robot"),
            Self::WrongTarget => f.write_str("the image is for other hardware"),
            Self::WrongLength { capacity } => {
                write!(
                    f,
                    "wrong length of the image (expected 1 to {capacity} bytes)"
                )
            }
            Self::NoTransfer => f.write_str("no image is under way"),
            Self::OtherImage { image } => write!(f, "another image is under way, {image:08x}"),
            Self::WrongPart { next } => {
                write!(
                    f,
                    "a part of the image that cannot be (expected the one at byte {next})"
                )
            }
            Self::Differs { offset } => {
                write!(
                    f,
                    "the part at byte {offset} differs from what was written there before"
                )
            }
            Self::Incomplete { next } => {
                write!(f, "parts of the image are missing, from byte {next} on")
            }
            Self::WrongCrc { got } => {
                write!(
                    f,
                    "the bytes are not those that were announced (they have the CRC {got:08x})"
                )
            }
            Self::NotVerified => f.write_str("the image is not verified"),
            Self::NotOnTrial => f.write_str("the image that runs is not on trial"),
            Self::NoRecord => f.write_str("there is no such record of a fault (any more)"),
            Self::Storage => f.write_str("the node's memory failed"),
            Self::Unconfirmed => f.write_str("the image that runs is on trial; confirm it first"),
        }
    }
}

impl core::error::Error for MaintenanceRefusal {}
