//! Starts the one of two images of an STM32G474RE that is to run: [`firmware::update`] decides, here is the jump.
//!
//! With the clock of 16 MHz as after every reset, no interrupt, no watchdog, no pin. If no image is whole it waits for a
//! debugger: it has nothing else to start. `cargo xtask boards` runs it on an emulated Cortex-M4F.
#![no_std]
#![no_main]
#![deny(clippy::undocumented_unsafe_blocks, missing_docs)]

use board_cortex_m as _;
use board_stm32g4::flash::{Flash, bank_2_is_first};
use core::arch::asm;
use cortex_m_rt::entry;
use firmware::update::slots::Slots;
use firmware::update::stm32g474::{IMAGE, LAYOUT};
use protocol::maintenance::Slot;
use stm32g4::stm32g474::{FLASH, Peripherals, SYSCFG};

#[entry]
fn main() -> ! {
    if let Some(slot) = Peripherals::take().and_then(choose) {
        // SAFETY: the slot's image is whole, so it begins with its vector table; nothing of this program is needed any more
        unsafe { start(slot == Slot::B) }
    }
    loop {
        cortex_m::asm::wfi();
    }
}

/// What is to start, if anything can be.
fn choose(p: Peripherals) -> Option<Slot> {
    let bank_2_first = bank_2_is_first(&p.RCC, &p.SYSCFG);
    // SAFETY: what is written is the log, which no program is in
    let flash = unsafe { Flash::new(p.FLASH, bank_2_first) };
    let mut slots = Slots::new(flash, LAYOUT).ok()?;
    let choice = slots.start();
    slots.into_flash().lock();
    // a trial that cannot be written down is none: it would be tried for ever
    choice.ok()?.slot
}

/// Shows the bank of the image at the beginning and goes there.
///
/// # Safety
/// There is an image with its vector table, and whatever this program had is given up.
// in RAM: from the moment in which the other bank is shown, what is fetched from flash is another program's
#[unsafe(link_section = ".data.start")]
#[inline(never)]
unsafe fn start(bank_2: bool) -> ! {
    // SAFETY: nothing else runs; `SYSCFG` has its clock since `bank_2_is_first`
    let (flash, syscfg) = unsafe { (&*FLASH::ptr(), &*SYSCFG::ptr()) };
    syscfg.memrmp().modify(|_, w| w.fb_mode().bit(bank_2));
    let acr = flash.acr();
    acr.modify(|_, w| w.icen().clear_bit().dcen().clear_bit());
    acr.modify(|_, w| w.icrst().set_bit().dcrst().set_bit());
    acr.modify(|_, w| w.icrst().clear_bit().dcrst().clear_bit());
    acr.modify(|_, w| w.icen().set_bit().dcen().set_bit());
    // SAFETY: the image's own first stack pointer and entry; VTOR (E000 ED08) is where they are
    unsafe {
        asm!(
            "str r0, [r1]",
            "dsb",
            "isb",
            "ldr r2, [r0]",
            "ldr r3, [r0, #4]",
            "msr msp, r2",
            "bx r3",
            in("r0") IMAGE,
            in("r1") 0xE000_ED08_u32,
            options(noreturn),
        )
    }
}
