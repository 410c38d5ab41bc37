//! The last two pages of flash, and what its error correction says of a page that lost its power.

use board::mcan::Words;
use board_cortex_m::window::Window;
use cortex_m_rt::exception;
use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use stm32g4::stm32g474::FLASH;

/// Where they are: behind what `memory.x` gives to the image, in the second bank, so that the image runs on from
/// the first meanwhile (RM0440, 3.3.8; option bit DBANK as delivered).
const ADDRESS: usize = 0x0807_F000;
const PAGE: usize = 2048;
/// The number of the first in its bank.
const FIRST: u8 = 126;
/// SR: everything that can have gone wrong.
const WRONG: u32 = 0x0000_C3FA;
/// So often the flash is asked whether it is ready: 100 ms at least; it erases in 25 ms.
const PATIENCE: u32 = 5_000_000;

/// The two pages.
pub struct Pages {
    control: FLASH,
    words: Window,
}

/// The flash refused, or was never ready.
#[derive(Debug)]
pub struct Refused;

impl NorFlashError for Refused {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

impl Pages {
    /// With the right to change them.
    pub fn new(control: FLASH) -> Self {
        for key in [0x4567_0123, 0xCDEF_89AB] {
            // SAFETY: the two keys, in their order (RM0440, 3.3.5)
            control.keyr().write(|w| unsafe { w.keyr().bits(key) });
        }
        Self {
            control,
            // SAFETY: flash that `memory.x` leaves out; written only where it is erased and the control register says so
            words: unsafe { Window::new(ADDRESS, 2 * PAGE / 4) },
        }
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
}

impl ErrorType for Pages {
    type Error = Refused;
}

impl ReadNorFlash for Pages {
    const READ_SIZE: usize = 4;
    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Refused> {
        for (k, to) in bytes.chunks_exact_mut(4).enumerate() {
            let word = (offset as usize / 4).wrapping_add(k);
            to.copy_from_slice(&self.words.read(word).to_le_bytes());
        }
        Ok(())
    }
    fn capacity(&self) -> usize {
        2 * PAGE
    }
}

impl NorFlash for Pages {
    const WRITE_SIZE: usize = 8;
    const ERASE_SIZE: usize = PAGE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Refused> {
        for page in (from as usize / PAGE..to as usize / PAGE).take(2) {
            self.forget_errors();
            let number = FIRST.wrapping_add(page as u8);
            // SAFETY: one of the two pages, of the second bank
            let cr = self.control.cr();
            cr.modify(|_, w| unsafe { w.per().set_bit().bker().set_bit().pnb().bits(number) });
            cr.modify(|_, w| w.strt().set_bit());
            let done = self.wait();
            cr.modify(|_, w| w.per().clear_bit());
            done?;
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Refused> {
        for (k, double) in bytes.chunks_exact(8).enumerate() {
            self.forget_errors();
            let word = (offset as usize / 4).wrapping_add(k.wrapping_mul(2));
            self.control.cr().modify(|_, w| w.pg().set_bit());
            // a double word at once: the second half begins the programming
            for (half, four) in double.chunks_exact(4).enumerate() {
                let value = four.try_into().map_or(u32::MAX, u32::from_le_bytes);
                self.words.write(word.wrapping_add(half), value);
            }
            let done = self.wait();
            self.control.cr().modify(|_, w| w.pg().clear_bit());
            done?;
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
