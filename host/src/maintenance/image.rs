//! Sending an image: part after part, as the node asks for them.

use super::{Client, Wire};
use crate::error::Error;
use protocol::maintenance::{
    IMAGE_CHUNK, ImageHeader, ImagePhase, ImageStatus, MaintenanceRefusal, MaintenanceReply,
    MaintenanceRequest,
};

/// Parts that are sent in all, over the number of parts of the image: a node that asks for the same again and again
/// is broken.
pub const SENT: usize = 3;

/// What to tell while an image is sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sending {
    /// Another image was under way; it is forgotten.
    Dropped {
        /// Its CRC.
        image: u32,
    },
    /// The node has so many bytes.
    Bytes {
        /// So many.
        done: u32,
        /// Of so many.
        of: u32,
    },
    /// Every byte is there and the CRC fits.
    Verified,
    /// It starts at the next reset.
    Activated,
}

impl<W: Wire + ?Sized> Client<'_, W> {
    fn image(&mut self, request: &MaintenanceRequest) -> Result<ImageStatus, Error> {
        match self.ask(request)?.is {
            MaintenanceReply::Image(status) => Ok(status),
            other => Err(self.unexpected(&other)),
        }
    }

    /// How the transfer of an image stands.
    ///
    /// # Errors
    /// [`Error::Maintenance`]; [`Error::Silent`]; the bus has gone.
    pub fn image_status(&mut self) -> Result<ImageStatus, Error> {
        self.image(&MaintenanceRequest::Image)
    }

    /// Forgets the image under way. Needs the lease.
    ///
    /// # Errors
    /// [`Error::Maintenance`]; [`Error::Silent`]; the bus has gone.
    pub fn abort_image(&mut self) -> Result<ImageStatus, Error> {
        let epoch = self.epoch();
        self.image(&MaintenanceRequest::AbortImage { epoch })
    }

    /// Sends an image, verifies and activates it; goes on where an earlier attempt ended. Needs the lease.
    ///
    /// # Errors
    /// [`Error::Maintenance`]; [`Error::Silent`]; [`Error::Stopped`] by the operator; the bus has gone.
    pub fn send_image(
        &mut self,
        header: &ImageHeader,
        bytes: &[u8],
        mut tell: impl FnMut(Sending),
    ) -> Result<ImageStatus, Error> {
        let (epoch, image) = (self.epoch(), header.crc);
        let begin = MaintenanceRequest::BeginImage {
            epoch,
            header: header.clone(),
        };
        let mut status = match self.image(&begin) {
            Err(Error::Maintenance {
                refusal: MaintenanceRefusal::OtherImage { image },
                ..
            }) => {
                // its sender does not hold the lease any more
                self.abort_image()?;
                tell(Sending::Dropped { image });
                self.image(&begin)?
            }
            status => status?,
        };
        let most = SENT * bytes.len().div_ceil(IMAGE_CHUNK);
        for _ in 0..=most {
            tell(Sending::Bytes {
                done: status.next,
                of: header.length,
            });
            let offset = status.next;
            let rest = usize::try_from(offset).ok().and_then(|at| bytes.get(at..));
            let part = rest.and_then(|rest| rest.chunks(IMAGE_CHUNK).next());
            let Some(part) = part.filter(|_| status.phase == ImagePhase::Receiving) else {
                break;
            };
            status = self.image(&MaintenanceRequest::WriteImage {
                epoch,
                image,
                offset,
                bytes: part.iter().copied().collect(),
            })?;
        }
        self.image(&MaintenanceRequest::VerifyImage { epoch, image })?;
        tell(Sending::Verified);
        let status = self.image(&MaintenanceRequest::ActivateImage { epoch, image })?;
        tell(Sending::Activated);
        Ok(status)
    }
}
