//! The next image of a node: two slots behind the flash, a log of what was decided, and the transfer into the slot that
//! does not run.
//!
//! | module | one line |
//! |---|---|
//! | [`image`] | the header of an image |
//! | [`boot`] | which image starts: a pure function, and its records |
//! | [`slots`] | slots and log on a `NorFlash`; [`slots::Slots::start`] is all a bootloader decides |
//! | [`stm32g474`] | where they are in an STM32G474 |
//!
//! A slot is valid when its header is, and the header is written last: a transfer that ends anywhere leaves the slot
//! invalid and everything else as it was. Work is bounded by one page or, to verify, by one slot; it is for the time between
//! servo steps, never for a step.

pub mod boot;
pub mod image;
pub mod slots;
pub mod stm32g474;

use boot::{Choice, Phase, Record, TRIALS};
use embedded_storage::nor_flash::NorFlash;
use protocol::maintenance::{
    IMAGE_CHUNK, ImageHeader, ImagePhase, ImageStatus, MaintenanceRefusal, RunningImage, Slot,
    Standing,
};
use slots::Slots;

/// What is under way.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Transfer {
    header: ImageHeader,
    phase: ImagePhase,
    next: u32,
}

/// Takes images into the slot that does not run.
#[derive(Debug)]
pub struct Updater<F> {
    slots: Slots<F>,
    running: Slot,
    standing: Standing,
    transfer: Option<Transfer>,
}

type Answer = Result<ImageStatus, MaintenanceRefusal>;

impl<F: NorFlash> Updater<F> {
    /// After [`Slots::start`] has chosen; `None` if it chose nothing, for then nobody asks.
    #[must_use]
    pub fn new(slots: Slots<F>, choice: Choice) -> Option<Self> {
        Some(Self {
            slots,
            running: choice.slot?,
            standing: choice.standing,
            transfer: None,
        })
    }

    /// In an image that has been started from this slot: how it was chosen is what the bootloader wrote down last.
    pub fn resume(mut slots: Slots<F>, running: Slot) -> Self {
        let record = slots.last().map(|last| last.record);
        let standing = match record.filter(|record| record.slot == running) {
            Some(Record { phase, .. }) => match phase {
                Phase::Confirmed => Standing::Confirmed,
                Phase::RolledBack => Standing::RolledBack,
                Phase::Trial { .. } => Standing::Trial,
            },
            None => Standing::Confirmed,
        };
        Self {
            slots,
            running,
            standing,
            transfer: None,
        }
    }

    /// The flash, to look at.
    pub const fn slots(&mut self) -> &mut Slots<F> {
        &mut self.slots
    }

    /// The image that runs.
    pub fn running(&mut self) -> Option<RunningImage> {
        let header = self.slots.header(self.running)?;
        Some(RunningImage {
            slot: self.running,
            version: header.version,
            crc: header.crc,
            standing: self.standing,
        })
    }

    const fn slot(&self) -> Slot {
        boot::other(self.running)
    }

    /// How the transfer stands.
    pub fn status(&self) -> ImageStatus {
        let transfer = self.transfer.as_ref();
        ImageStatus {
            slot: self.slot(),
            phase: transfer.map_or(ImagePhase::None, |transfer| transfer.phase),
            image: transfer.map_or(0, |transfer| transfer.header.crc),
            next: transfer.map_or(0, |transfer| transfer.next),
            capacity: self.slots.capacity(),
        }
    }

    /// An image for this robot on this target follows.
    ///
    /// # Errors
    /// Why it is not wanted.
    pub fn begin(&mut self, robot: &str, target: &str, header: &ImageHeader) -> Answer {
        let capacity = self.slots.capacity();
        if header.robot != robot {
            return Err(MaintenanceRefusal::WrongRobot);
        }
        if header.target != target {
            return Err(MaintenanceRefusal::WrongTarget);
        }
        if header.length == 0 || header.length > capacity {
            return Err(MaintenanceRefusal::WrongLength { capacity });
        }
        match &self.transfer {
            Some(transfer) if transfer.header == *header => return Ok(self.status()),
            Some(transfer) => {
                return Err(MaintenanceRefusal::OtherImage {
                    image: transfer.header.crc,
                });
            }
            None => {}
        }
        if self.standing == Standing::Trial {
            return Err(MaintenanceRefusal::Unconfirmed);
        }
        self.slots.invalidate(self.slot())?;
        self.transfer = Some(Transfer {
            header: header.clone(),
            phase: ImagePhase::Receiving,
            next: 0,
        });
        Ok(self.status())
    }

    fn under_way(&self, image: u32) -> Result<&Transfer, MaintenanceRefusal> {
        match &self.transfer {
            None => Err(MaintenanceRefusal::NoTransfer),
            Some(transfer) if transfer.header.crc != image => Err(MaintenanceRefusal::OtherImage {
                image: transfer.header.crc,
            }),
            Some(transfer) => Ok(transfer),
        }
    }

    fn set(&mut self, phase: ImagePhase, next: u32) {
        if let Some(transfer) = &mut self.transfer {
            transfer.phase = phase;
            transfer.next = next;
        }
    }

    /// A part of the image. One that is there is compared, one beyond a gap is left.
    ///
    /// # Errors
    /// Why it cannot be a part of the image; after [`MaintenanceRefusal::Storage`] the page is wanted again.
    pub fn write(&mut self, image: u32, offset: u32, bytes: &[u8]) -> Answer {
        let slot = self.slot();
        let Transfer {
            header,
            phase,
            next,
        } = self.under_way(image)?;
        let (phase, next, length) = (*phase, *next, header.length);
        let whole = bytes.len() == IMAGE_CHUNK;
        let count = u32::try_from(bytes.len()).unwrap_or(u32::MAX);
        let end = offset.saturating_add(count);
        let aligned = offset.is_multiple_of(CHUNK);
        if bytes.is_empty() || end > length || !aligned || !(whole || end == length) {
            return Err(MaintenanceRefusal::WrongPart { next });
        }
        if offset < next {
            return if self.slots.holds(slot, offset, bytes)? {
                Ok(self.status())
            } else {
                Err(MaintenanceRefusal::Differs { offset })
            };
        }
        if offset == next && phase == ImagePhase::Receiving {
            if let Err(error) = self.slots.write(slot, offset, bytes) {
                // what a write leaves behind cannot be written over: the page is erased when it is sent again
                self.set(phase, self.slots.page_start(offset));
                return Err(error);
            }
            self.set(phase, end);
        }
        Ok(self.status())
    }

    /// Everything is there: compare the CRC, make the slot valid.
    ///
    /// # Errors
    /// [`MaintenanceRefusal::Incomplete`], or [`MaintenanceRefusal::WrongCrc`]: then the image is forgotten.
    pub fn verify(&mut self, image: u32) -> Answer {
        let slot = self.slot();
        let Transfer {
            header,
            phase,
            next,
        } = self.under_way(image)?.clone();
        if phase != ImagePhase::Receiving {
            return Ok(self.status());
        }
        if next < header.length {
            return Err(MaintenanceRefusal::Incomplete { next });
        }
        let got = self.slots.crc(slot, header.length)?;
        if got != header.crc {
            self.transfer = None;
            return Err(MaintenanceRefusal::WrongCrc { got });
        }
        self.slots.validate(slot, &header)?;
        self.set(ImagePhase::Verified, next);
        Ok(self.status())
    }

    /// The verified image starts on trial at the next reset.
    ///
    /// # Errors
    /// [`MaintenanceRefusal::NotVerified`]
    pub fn activate(&mut self, image: u32) -> Answer {
        let slot = self.slot();
        let transfer = self.under_way(image)?;
        let (phase, next) = (transfer.phase, transfer.next);
        match phase {
            ImagePhase::Activated => {}
            ImagePhase::Verified => {
                let phase = Phase::Trial { left: TRIALS };
                self.slots.append(Record { slot, phase })?;
                self.set(ImagePhase::Activated, next);
            }
            ImagePhase::None | ImagePhase::Receiving => {
                return Err(MaintenanceRefusal::NotVerified);
            }
        }
        Ok(self.status())
    }

    /// The image that runs on trial is kept.
    ///
    /// # Errors
    /// [`MaintenanceRefusal::NotOnTrial`]
    pub fn confirm(&mut self) -> Result<(), MaintenanceRefusal> {
        if self.standing != Standing::Trial {
            return Err(MaintenanceRefusal::NotOnTrial);
        }
        self.keep(Phase::Confirmed)?;
        self.standing = Standing::Confirmed;
        Ok(())
    }

    fn keep(&mut self, phase: Phase) -> Result<(), MaintenanceRefusal> {
        let slot = self.running;
        self.slots.append(Record { slot, phase })
    }

    /// Forget what is under way; what was activated is not started any more.
    ///
    /// # Errors
    /// Only [`MaintenanceRefusal::Storage`].
    pub fn abort(&mut self) -> Answer {
        if let Some(transfer) = &self.transfer {
            if transfer.phase == ImagePhase::Activated {
                self.keep(Phase::Confirmed)?;
            }
            self.transfer = None;
        }
        Ok(self.status())
    }
}

/// [`IMAGE_CHUNK`] as offsets count.
#[expect(clippy::cast_possible_truncation, reason = "256")]
const CHUNK: u32 = IMAGE_CHUNK as u32;
