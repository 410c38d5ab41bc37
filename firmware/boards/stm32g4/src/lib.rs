//! What every board with an STM32G474 has in common: registers, and nothing that could be tested without them.
//!
//! | module | one line |
//! |---|---|
//! | [`clock`] | 170 MHz from a crystal of 24 MHz, the counters of microseconds, the watchdog |
//! | [`can`] | the three FDCAN and their bit rates |
//! | [`flash`] | both banks, and the two pages of the configuration |
//! | [`pin`] | a pin as embedded-hal has it |
//! | [`start`] | from reset to a node |
//!
//! Its registers are those of `stm32g4`, which is made from ST's description of the processor. No HAL: the images of
//! this project must link without a reachable panic, and one with stm32g4xx-hal 0.1 and fdcan 0.2 did not.
#![no_std]
#![deny(clippy::undocumented_unsafe_blocks, missing_docs)]

pub mod can;
pub mod clock;
pub mod flash;
pub mod pin;
pub mod start;

use board::mcan::Words as _;
use board_cortex_m::window::Window;

/// Of this very processor: the 96 bits that ST wrote into it, as 64.
#[must_use]
pub fn unique_id() -> u64 {
    // SAFETY: constants of the factory (RM0440, 48.1)
    let words = unsafe { Window::new(0x1FFF_7590, 3) };
    let [a, b, c] = [0, 1, 2].map(|k| u64::from(words.read(k)));
    (a ^ c.rotate_left(16)) | b << 32
}
