//! Which pin is what.

use board::guard::Panel;
use board::mcan::Words;
use board_cortex_m::window::Window;
use core::convert::Infallible;
use embedded_hal::digital::{ErrorType, InputPin, OutputPin};
use stm32g4::stm32g474::{GPIOA, GPIOB, GPIOC, RCC};

/// A pin of a port.
pub struct Pin {
    port: Window,
    mask: u32,
}

impl Pin {
    fn new(port: usize, number: u32) -> Self {
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

/// All pins of this board: `README.md` has the table.
pub fn start(rcc: &RCC, a: &GPIOA, b: &GPIOB, c: &GPIOC) -> Panel<Pin, Pin> {
    rcc.ahb2enr().modify(|_, w| {
        w.gpioaen()
            .enabled()
            .gpioben()
            .enabled()
            .gpiocen()
            .enabled()
    });
    // outputs are low from the start: no torque, brake closed. Contacts pull up against a resistor to ground
    c.moder()
        .modify(|_, w| w.moder0().output().moder1().output().moder13().input());
    a.moder()
        .modify(|_, w| w.moder0().input().moder1().input().moder5().output());
    a.pupdr()
        .modify(|_, w| w.pupdr0().pull_down().pupdr1().pull_down());
    // FDCAN1: PA11, PA12. FDCAN2: PB12, PB13. FDCAN3: PA8, PA15
    a.afrh().modify(|_, w| {
        w.afrh11()
            .af9()
            .afrh12()
            .af9()
            .afrh8()
            .af11()
            .afrh15()
            .af11()
    });
    b.afrh().modify(|_, w| w.afrh12().af9().afrh13().af9());
    a.moder().modify(|_, w| {
        w.moder11()
            .alternate()
            .moder12()
            .alternate()
            .moder8()
            .alternate()
            .moder15()
            .alternate()
    });
    b.moder()
        .modify(|_, w| w.moder12().alternate().moder13().alternate());
    let (a, c) = (GPIOA::ptr() as usize, GPIOC::ptr() as usize);
    Panel {
        first: Pin::new(a, 0),
        second: Pin::new(a, 1),
        reset: Pin::new(c, 13),
        torque: Pin::new(c, 0),
        brake: Pin::new(c, 1),
        light: Pin::new(a, 5),
    }
}
