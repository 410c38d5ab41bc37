//! Which pin is what.

use board::guard::Panel;
use board_stm32g4::pin::Pin;
use stm32g4::stm32g474::{GPIOA, GPIOB, GPIOC, RCC};

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
    // outputs are low from the start: no torque, brake closed. Contacts and button pull up against a resistor to ground
    c.moder()
        .modify(|_, w| w.moder0().output().moder1().output().moder13().input());
    c.pupdr().modify(|_, w| w.pupdr13().pull_down());
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
