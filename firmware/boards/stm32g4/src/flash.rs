//! The flash of both banks, two pages of it for the configuration, and what its error correction says of a page that
//! lost its power.
//!
//! Offsets count from the beginning of bank 1, however the banks are shown: with `FB_MODE` bank 2 is at 0800 0000 and bank 1
//! behind it, while the erase bit `BKER` goes on meaning the bank itself (RM0440, 3.3; AN4767).

use board::mcan::Words;
use board_cortex_m::window::Window;
use cortex_m_rt::exception;
use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use firmware::update::stm32g474::{BANK, CONFIGURATION, FLASH as ADDRESS, PAGE, WRITE};
use stm32g4::stm32g474::{FLASH, RCC, SYSCFG};

/// Bytes of both banks.
const BYTES: u32 = 2 * BANK;
/// SR: everything that can have gone wrong.
const WRONG: u32 = 0x0000_C3FA;
/// So often the flash is asked whether it is ready: 100 ms at least; it erases in 25 ms.
const PATIENCE: u32 = 5_000_000;

/// Is bank 2 shown at the beginning?
pub fn bank_2_is_first(rcc: &RCC, syscfg: &SYSCFG) -> bool {
    rcc.apb2enr().modify(|_, w| w.syscfgen().set_bit());
    syscfg.memrmp().read().fb_mode().bit_is_set()
}

/// Both banks.
pub struct Flash {
    control: FLASH,
    words: Window,
    bank_2_first: bool,
}

/// The flash refused, or was never ready.
#[derive(Debug)]
pub struct Refused;

impl NorFlashError for Refused {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

impl core::fmt::Debug for Flash {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("Flash")
    }
}

impl Flash {
    /// With the right to change it, as the banks are shown now: see [`bank_2_is_first`].
    ///
    /// # Safety
    /// Whoever writes leaves the program that runs alone: its pages are no part of what it writes.
    pub unsafe fn new(control: FLASH, bank_2_first: bool) -> Self {
        for key in [0x4567_0123, 0xCDEF_89AB] {
            // SAFETY: the two keys, in their order (RM0440, 3.3.5)
            control.keyr().write(|w| unsafe { w.keyr().bits(key) });
        }
        Self {
            control,
            // SAFETY: flash; written only where it is erased and the control register says so, and, as the caller has
            // promised, where no program is
            words: unsafe { Window::new(ADDRESS as usize, BYTES as usize / 4) },
            bank_2_first,
        }
    }

    /// The two pages of the configuration: in front of the slots, if the image is in one, else the last two, behind an image
    /// that has the whole flash.
    pub const fn configuration(&mut self, in_slot: bool) -> Pages<'_> {
        let at = if in_slot {
            CONFIGURATION
        } else {
            [BYTES - 2 * PAGE, BYTES - PAGE]
        };
        Pages { flash: self, at }
    }

    /// Gives the right to change it back, until the next reset.
    pub fn lock(self) {
        self.control.cr().modify(|_, w| w.lock().set_bit());
    }

    /// The number of the word at an offset, as the banks are shown.
    fn word(&self, offset: u32) -> usize {
        let shown = if self.bank_2_first {
            offset ^ BANK
        } else {
            offset
        };
        shown as usize / 4
    }

    fn wait(&self) -> Result<(), Refused> {
        let ready = (0..PATIENCE).any(|_| self.control.sr().read().bsy().bit_is_clear());
        if ready && self.control.sr().read().bits() & WRONG == 0 {
            Ok(())
        } else {
            Err(Refused)
        }
    }

    fn forget_errors(&self) {
        // SAFETY: SR: bits are cleared by writing them
        self.control.sr().write(|w| unsafe { w.bits(WRONG) });
    }

    /// What was cached is not what is there any more (RM0440, 3.3.4).
    fn forget_cached(&self) {
        let acr = self.control.acr();
        acr.modify(|_, w| w.icen().clear_bit().dcen().clear_bit());
        acr.modify(|_, w| w.icrst().set_bit().dcrst().set_bit());
        acr.modify(|_, w| w.icrst().clear_bit().dcrst().clear_bit());
        acr.modify(|_, w| w.icen().set_bit().dcen().set_bit());
    }

    fn erase_page(&self, offset: u32) -> Result<(), Refused> {
        self.forget_errors();
        let cr = self.control.cr();
        let second = offset >= BANK;
        let number = (offset % BANK / PAGE) as u8;
        // SAFETY: 0 to 127, which is what the bits are for
        cr.modify(|_, w| unsafe { w.per().set_bit().bker().bit(second).pnb().bits(number) });
        cr.modify(|_, w| w.strt().set_bit());
        let done = self.wait();
        cr.modify(|_, w| w.per().clear_bit());
        done
    }

    fn write_double_word(&mut self, offset: u32, double: &[u8]) -> Result<(), Refused> {
        self.forget_errors();
        self.control.cr().modify(|_, w| w.pg().set_bit());
        // the second half begins the programming
        for (half, four) in double.chunks_exact(4).enumerate() {
            let value = four.try_into().map_or(u32::MAX, u32::from_le_bytes);
            let word = self.word(offset).wrapping_add(half);
            self.words.write(word, value);
        }
        let done = self.wait();
        self.control.cr().modify(|_, w| w.pg().clear_bit());
        done
    }
}

impl ErrorType for Flash {
    type Error = Refused;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 4;
    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Refused> {
        for (from, to) in (offset..BYTES).step_by(4).zip(bytes.chunks_exact_mut(4)) {
            to.copy_from_slice(&self.words.read(self.word(from)).to_le_bytes());
        }
        Ok(())
    }
    fn capacity(&self) -> usize {
        BYTES as usize
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = WRITE as usize;
    const ERASE_SIZE: usize = PAGE as usize;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Refused> {
        let pages = (from..to.min(BYTES)).step_by(PAGE as usize);
        let done = pages
            .map(|page| self.erase_page(page))
            .find(Result::is_err)
            .unwrap_or(Ok(()));
        self.forget_cached();
        done
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Refused> {
        let places = (offset..BYTES).step_by(WRITE as usize);
        let done = places
            .zip(bytes.chunks_exact(WRITE as usize))
            .map(|(place, double)| self.write_double_word(place, double))
            .find(Result::is_err)
            .unwrap_or(Ok(()));
        self.forget_cached();
        done
    }
}

/// Two pages of it as if they were a flash of their own: those of the configuration.
pub struct Pages<'a> {
    flash: &'a mut Flash,
    at: [u32; 2],
}

impl Pages<'_> {
    /// Where an offset of theirs is in the flash.
    fn place(&self, offset: u32) -> Result<u32, Refused> {
        let page = self.at.get((offset / PAGE) as usize).ok_or(Refused)?;
        Ok(page.wrapping_add(offset % PAGE))
    }
}

impl ErrorType for Pages<'_> {
    type Error = Refused;
}

impl ReadNorFlash for Pages<'_> {
    const READ_SIZE: usize = Flash::READ_SIZE;
    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Refused> {
        for (from, four) in (offset..).step_by(4).zip(bytes.chunks_exact_mut(4)) {
            let place = self.place(from)?;
            self.flash.read(place, four)?;
        }
        Ok(())
    }
    fn capacity(&self) -> usize {
        2 * PAGE as usize
    }
}

impl NorFlash for Pages<'_> {
    const WRITE_SIZE: usize = Flash::WRITE_SIZE;
    const ERASE_SIZE: usize = Flash::ERASE_SIZE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Refused> {
        for page in (from..to).step_by(PAGE as usize).take(2) {
            let place = self.place(page)?;
            self.flash.erase(place, place.wrapping_add(PAGE))?;
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Refused> {
        let doubles = bytes.chunks_exact(WRITE as usize);
        for (from, double) in (offset..).step_by(WRITE as usize).zip(doubles) {
            let place = self.place(from)?;
            self.flash.write(place, double)?;
        }
        Ok(())
    }
}

/// A double word whose programming was cut has two wrong bits: reading it is this exception, and what is read is left
/// to its CRC. Anything else that comes here would come again at once, which is the watchdog's affair.
#[exception]
unsafe fn NonMaskableInt() {
    // SAFETY: only ECCD is written, which is cleared by writing it
    unsafe { (*FLASH::ptr()).eccr().modify(|_, w| w.eccd().set_bit()) };
}
