//! Where bootloader, log and slots are in an STM32G474RE.
//!
//! 512 KiB of flash in two banks (DBANK = 1, the factory's setting) of 128 pages of 2 KiB; 8 bytes are written at a time;
//! erasing a page takes 22 ms, and code in the other bank runs meanwhile (RM0440, 3.3; DS12288, table of flash memory).
//!
//! ```text
//!  page of either bank      0 … 5              6          7                    8          9 … 127
//!                           bootloader         log        configuration        header     image
//!                           (bank 1 only)                 of the node
//!                           12 KiB             2 KiB      2 KiB                2 KiB      119 · 2 KiB = 243 712 bytes
//! ```
//! The chip starts at bank 1. The bootloader shows the bank of the image it starts at 0800 0000 (`FB_MODE` of `SYSCFG_MEMRMP`,
//! cleared by every reset), so that every image is linked for one address, 0800 4800. 4800 = 9 · 800, a multiple of 200: the
//! vector table (118 entries of 4 bytes, aligned to the next power of two, 512) may be there.

use super::slots::Layout;

/// A page, bytes.
pub const PAGE: u32 = 2048;
/// A bank, bytes: 128 pages.
pub const BANK: u32 = 128 * PAGE;
/// What is written at a time, bytes.
pub const WRITE: u32 = 8;
/// The bootloader, bytes, at the beginning of bank 1.
pub const BOOTLOADER: u32 = 6 * PAGE;
/// Where the flash is.
pub const FLASH: u32 = 0x0800_0000;

const LOG: u32 = BOOTLOADER;
const SLOT: u32 = 8 * PAGE;

/// Bytes from the beginning of bank 1, as the banks lie without `FB_MODE`.
pub const LAYOUT: Layout = Layout {
    slot_a: SLOT,
    slot_b: BANK + SLOT,
    slot: BANK - SLOT,
    log: [LOG, BANK + LOG],
};

/// The two pages of the node's configuration, which outlives images.
pub const CONFIGURATION: [u32; 2] = [LOG + PAGE, BANK + LOG + PAGE];

/// The address every image is linked for.
pub const IMAGE: u32 = FLASH + SLOT + PAGE;

/// The longest image, bytes.
pub const CAPACITY: u32 = LAYOUT.slot - PAGE;

const _: () = assert!(CAPACITY == 243_712 && IMAGE == 0x0800_4800 && IMAGE.is_multiple_of(512));
const _: () = assert!(SLOT >= LOG + 2 * PAGE && LAYOUT.slot_b + LAYOUT.slot == 2 * BANK);
