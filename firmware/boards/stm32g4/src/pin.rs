//! A pin as embedded-hal has it.

use board::mcan::Words;
use board_cortex_m::window::Window;
use core::convert::Infallible;
use embedded_hal::digital::{ErrorType, InputPin, OutputPin};

/// A pin of a port.
pub struct Pin {
    port: Window,
    mask: u32,
}

impl Pin {
    /// Pin `number` of the port with its registers at this address: one of GPIOA to GPIOG.
    #[must_use]
    pub fn new(port: usize, number: u32) -> Self {
        // SAFETY: the registers of GPIO: reading IDR and writing BSRR is all that is done to them by this, and what a
        // pin's neighbours are is not touched by either
        let port = unsafe { Window::new(port, 7) };
        Self {
            port,
            mask: 1 << (number & 15),
        }
    }
}

impl ErrorType for Pin {
    type Error = Infallible;
}

impl InputPin for Pin {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        // IDR
        Ok(self.port.read(4) & self.mask != 0)
    }
    fn is_low(&mut self) -> Result<bool, Infallible> {
        self.is_high().map(|high| !high)
    }
}

impl OutputPin for Pin {
    fn set_high(&mut self) -> Result<(), Infallible> {
        // BSRR: sets by its lower half, clears by its upper one
        self.port.write(6, self.mask);
        Ok(())
    }
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.port.write(6, self.mask << 16);
        Ok(())
    }
}
