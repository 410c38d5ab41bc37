//! For tests: pins that are wires on the table.

use core::cell::Cell;
use core::convert::Infallible;
use embedded_hal::digital::{ErrorType, InputPin, OutputPin};

/// A wire that may be cut off.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pin<'a>(pub(crate) &'a Cell<bool>);

impl ErrorType for Pin<'_> {
    type Error = Infallible;
}
impl InputPin for Pin<'_> {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        Ok(self.0.get())
    }
    fn is_low(&mut self) -> Result<bool, Infallible> {
        Ok(!self.0.get())
    }
}
impl OutputPin for Pin<'_> {
    fn set_high(&mut self) -> Result<(), Infallible> {
        self.0.set(true);
        Ok(())
    }
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.0.set(false);
        Ok(())
    }
}
