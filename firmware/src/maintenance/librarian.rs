//! Which image runs and which comes next: memory that takes its time.

use super::Asked;
use crate::update::Updater;
use embedded_storage::nor_flash::NorFlash;
use protocol::maintenance::{
    MAX_TARGET, MaintenanceRefusal, MaintenanceReply, MaintenanceRequest, NodeIdentity,
};
use protocol::message::Identity;

/// Says who the node is and takes its next image; `F` is the flash of the slots.
#[derive(Debug)]
pub struct Librarian<F> {
    target: heapless::String<MAX_TARGET>,
    updater: Option<Updater<F>>,
    restart: bool,
}

impl<F: NorFlash> Librarian<F> {
    /// Of images for this target. Without an updater the node cannot be updated by the bus.
    pub const fn new(target: heapless::String<MAX_TARGET>, updater: Option<Updater<F>>) -> Self {
        Self {
            target,
            updater,
            restart: false,
        }
    }

    /// Was a restart asked for and granted? The answer is to be on the wire before it.
    pub const fn restarts(&self) -> bool {
        self.restart
    }

    /// The answer to a request. Bounded by one page of flash or, to verify, by one slot: for the time between servo steps.
    pub fn answer(&mut self, asked: &Asked, identity: &Identity) -> MaintenanceReply {
        self.reply(asked, identity)
            .unwrap_or_else(MaintenanceReply::Refused)
    }

    fn reply(
        &mut self,
        asked: &Asked,
        identity: &Identity,
    ) -> Result<MaintenanceReply, MaintenanceRefusal> {
        asked.permitted()?;
        let image = match &asked.request {
            MaintenanceRequest::Identify => {
                return Ok(MaintenanceReply::Identity(self.identity(identity)));
            }
            MaintenanceRequest::Image => self.updater()?.status(),
            MaintenanceRequest::BeginImage { header, .. } => {
                let target = self.target.clone();
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
            // the recorder's, of which there is none here
            MaintenanceRequest::ResetCause
            | MaintenanceRequest::FirstFault
            | MaintenanceRequest::Samples { .. }
            | MaintenanceRequest::ClearFault { .. } => return Err(MaintenanceRefusal::NoRecord),
        };
        Ok(MaintenanceReply::Image(image))
    }

    fn updater(&mut self) -> Result<&mut Updater<F>, MaintenanceRefusal> {
        self.updater.as_mut().ok_or(MaintenanceRefusal::NoSlots)
    }

    fn identity(&mut self, identity: &Identity) -> NodeIdentity {
        NodeIdentity {
            robot: identity.robot.clone(),
            target: self.target.clone(),
            unique_id: identity.unique_id,
            protocol: identity.protocol,
            schema_hash: identity.schema_hash,
            config_crc: identity.config_crc,
            firmware: identity.firmware,
            image: self.updater.as_mut().and_then(Updater::running),
        }
    }
}
