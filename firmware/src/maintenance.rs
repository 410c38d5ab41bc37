//! What a node does for those who keep it: it says who it is and why it started, keeps the signals before its first
//! fault, and takes its next image.
//!
//! The node itself only collects: the signals of a step, and one request. The [`Keeper`] beside it answers, since it touches
//! memory that is slow: on a microcontroller between servo steps, on a host right after them ([`Kept`]).

pub mod black_box;
mod kept;

pub use kept::{Kept, Maintainable};

use crate::update::Updater;
use black_box::{BlackBox, Memory, Signals};
use embedded_storage::nor_flash::NorFlash;
use protocol::id::NodeId;
use protocol::maintenance::{
    MAX_TARGET, MaintenanceRefusal, MaintenanceReply, MaintenanceRequest, NodeIdentity, ResetCause,
    ResetReport,
};
use protocol::message::Identity;
use protocol::transfer::TransferId;

/// A request that waits for its answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Asked {
    /// Who asks.
    pub from: NodeId,
    /// To be repeated in the answer.
    pub transfer_id: TransferId,
    /// May the sender write now?
    pub allowed: Result<(), MaintenanceRefusal>,
    /// What is asked for.
    pub request: MaintenanceRequest,
}

/// What the rim knows of its node's start.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Start {
    /// What images must be made for.
    pub target: heapless::String<MAX_TARGET>,
    /// Why it started.
    pub cause: ResetCause,
    /// Starts so far, this one included.
    pub boots: u32,
}

/// Answers maintenance requests: `M` is the memory of the black box, `F` the flash of the slots.
#[derive(Debug)]
pub struct Keeper<M, F> {
    start: Start,
    black_box: BlackBox<M>,
    updater: Option<Updater<F>>,
    restart: bool,
}

impl<M: Memory, F: NorFlash> Keeper<M, F> {
    /// Without an updater the node cannot be updated by the bus.
    pub const fn new(start: Start, black_box: BlackBox<M>, updater: Option<Updater<F>>) -> Self {
        Self {
            start,
            black_box,
            updater,
            restart: false,
        }
    }

    /// Was a restart asked for and granted? The answer is to be on the wire before it.
    pub const fn restarts(&self) -> bool {
        self.restart
    }

    /// The signals of a servo step; short, for the step itself.
    pub fn record(&mut self, signals: &Signals, servo_step_us: u32) {
        self.black_box
            .record(signals, self.start.boots, servo_step_us);
    }

    /// What takes longer than a servo step has: for the time between them.
    pub fn seal(&mut self) {
        self.black_box.seal();
    }

    /// The answer to a request. Bounded by one page of flash or, to verify, by one slot: for the time between servo steps.
    pub fn answer(&mut self, asked: &Asked, identity: &Identity, step: u32) -> MaintenanceReply {
        self.reply(asked, identity, step)
            .unwrap_or_else(MaintenanceReply::Refused)
    }

    fn reply(
        &mut self,
        asked: &Asked,
        identity: &Identity,
        step: u32,
    ) -> Result<MaintenanceReply, MaintenanceRefusal> {
        if asked.request.epoch().is_some() {
            asked.allowed?;
        }
        let image = match &asked.request {
            MaintenanceRequest::Identify => {
                return Ok(MaintenanceReply::Identity(self.identity(identity)));
            }
            MaintenanceRequest::ResetCause => {
                return Ok(MaintenanceReply::Reset(ResetReport {
                    cause: self.start.cause,
                    boots: self.start.boots,
                    steps: step,
                    servo_step_us: identity.servo_step_us,
                }));
            }
            MaintenanceRequest::FirstFault => {
                let record = self.black_box.first_fault();
                return Ok(record.map_or(MaintenanceReply::NoFault, MaintenanceReply::FirstFault));
            }
            MaintenanceRequest::Samples { record, first } => {
                let (record, first) = (*record, *first);
                let samples = self.black_box.samples(record, first);
                return Ok(MaintenanceReply::Samples {
                    record,
                    first,
                    samples: samples.ok_or(MaintenanceRefusal::NoRecord)?,
                });
            }
            MaintenanceRequest::ClearFault { record, .. } => {
                return if self.black_box.clear(*record) {
                    Ok(MaintenanceReply::Done)
                } else {
                    Err(MaintenanceRefusal::NoRecord)
                };
            }
            MaintenanceRequest::Image => self.updater()?.status(),
            MaintenanceRequest::BeginImage { header, .. } => {
                let target = self.start.target.clone();
                self.updater()?.begin(&identity.robot, &target, header)?
            }
            MaintenanceRequest::WriteImage {
                image,
                offset,
                bytes,
                ..
            } => self.updater()?.write(*image, *offset, bytes)?,
            MaintenanceRequest::VerifyImage { image, .. } => self.updater()?.verify(*image)?,
            MaintenanceRequest::ActivateImage { image, .. } => self.updater()?.activate(*image)?,
            MaintenanceRequest::ConfirmImage { .. } => {
                self.updater()?.confirm()?;
                return Ok(MaintenanceReply::Done);
            }
            MaintenanceRequest::AbortImage { .. } => self.updater()?.abort()?,
            MaintenanceRequest::Restart { .. } => {
                self.restart = true;
                return Ok(MaintenanceReply::Done);
            }
        };
        Ok(MaintenanceReply::Image(image))
    }

    fn updater(&mut self) -> Result<&mut Updater<F>, MaintenanceRefusal> {
        self.updater.as_mut().ok_or(MaintenanceRefusal::NoSlots)
    }

    fn identity(&mut self, identity: &Identity) -> NodeIdentity {
        NodeIdentity {
            robot: identity.robot.clone(),
            target: self.start.target.clone(),
            unique_id: identity.unique_id,
            protocol: identity.protocol,
            schema_hash: identity.schema_hash,
            config_crc: identity.config_crc,
            firmware: identity.firmware,
            image: self.updater.as_mut().and_then(Updater::running),
        }
    }
}
