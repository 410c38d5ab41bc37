//! A flash that loses power: writes only clear bits, erasing sets whole pages, and after so many bytes nothing works.

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};

/// As an STM32G474, with fewer pages.
pub(super) const PAGE: usize = 2048;

#[derive(Clone, Debug)]
pub(super) struct Flash {
    pub(super) bytes: Vec<u8>,
    /// Bytes that can still be changed before the power goes.
    pub(super) power: Option<usize>,
    /// Bytes changed so far.
    pub(super) changed: usize,
    /// What an erasure that is cut off leaves in the rest of the page.
    pub(super) torn: u8,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FlashError {
    Power,
    Misuse,
}

impl NorFlashError for FlashError {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

impl Flash {
    pub(super) fn new(pages: usize) -> Self {
        Self {
            bytes: vec![0xFF; pages * PAGE],
            power: None,
            changed: 0,
            torn: 0,
        }
    }

    fn spend(&mut self) -> Result<(), FlashError> {
        if let Some(power) = &mut self.power {
            *power = power.checked_sub(1).ok_or(FlashError::Power)?;
        }
        self.changed += 1;
        Ok(())
    }
}

impl ErrorType for Flash {
    type Error = FlashError;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        if self.power == Some(0) {
            return Err(FlashError::Power);
        }
        let from = offset as usize;
        let source = self.bytes.get(from..from + bytes.len());
        bytes.copy_from_slice(source.ok_or(FlashError::Misuse)?);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = 8;
    const ERASE_SIZE: usize = PAGE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        let (from, to) = (from as usize, to as usize);
        assert!(from.is_multiple_of(PAGE) && to.is_multiple_of(PAGE) && to <= self.bytes.len());
        for at in from..to {
            if let Err(error) = self.spend() {
                // neither what it was nor erased
                for byte in &mut self.bytes[at..to] {
                    *byte ^= self.torn;
                }
                return Err(error);
            }
            self.bytes[at] = 0xFF;
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        let from = offset as usize;
        assert!(from.is_multiple_of(8) && bytes.len().is_multiple_of(8));
        assert!(from + bytes.len() <= self.bytes.len());
        // eight bytes at a time, and only into erased ones: an STM32 refuses anything else
        for (k, part) in bytes.chunks(8).enumerate() {
            let at = from + 8 * k;
            if self.bytes[at..at + 8] != [0xFF; 8] {
                return Err(FlashError::Misuse);
            }
            for (k, byte) in part.iter().enumerate() {
                self.spend()?;
                self.bytes[at + k] = *byte;
            }
        }
        Ok(())
    }
}
