//! 170 MHz from the crystal, the counters of microseconds, and the watchdog.

use board::alive::Periods;
use board::time_base::TimeBase;
use protocol::time::Micros;
use stm32g4::stm32g474::{DBGMCU, FLASH, IWDG, PWR, RCC, TIM2, TIM3};

/// Of the processor, the timers and the CAN controllers.
pub const HZ: u32 = 170_000_000;
/// Of the tick.
pub const TICK_US: u32 = 500;
/// So often a clock is asked whether it runs: some 10 ms at 16 MHz, several times what a crystal takes.
const PATIENCE: u32 = 50_000;

/// From the internal 16 MHz to 170 MHz out of the crystal of 24 MHz; `None`: it does not swing.
pub fn start(rcc: &RCC, pwr: &PWR, flash: &FLASH) -> Option<()> {
    rcc.apb1enr1().modify(|_, w| w.pwren().enabled());
    // above 150 MHz the core needs more voltage (RM0440, 6.1.5), and flash 4 cycles of waiting
    pwr.cr5().modify(|_, w| w.r1mode().clear_bit());
    flash
        .acr()
        .modify(|_, w| w.latency().wait4().prften().set_bit());
    rcc.cr().modify(|_, w| w.hseon().set_bit());
    (0..PATIENCE).find(|_| rcc.cr().read().hserdy().bit_is_set())?;
    // 24 MHz / 6 * 85 / 2
    rcc.pllcfgr().write(|w| {
        w.pllsrc()
            .hse()
            .pllm()
            .div6()
            .plln()
            .div85()
            .pllr()
            .div2()
            .pllren()
            .set_bit()
    });
    rcc.cr().modify(|_, w| w.pllon().set_bit());
    (0..PATIENCE).find(|_| rcc.cr().read().pllrdy().bit_is_set())?;
    // by way of half of it, for 1 µs at least (RM0440, 7.2.7)
    rcc.cfgr().modify(|_, w| w.hpre().div2().sw().pll());
    (0..PATIENCE).find(|_| rcc.cfgr().read().sws().is_pll())?;
    cortex_m::asm::delay(HZ / 500_000);
    rcc.cfgr().modify(|_, w| w.hpre().div1());
    rcc.ccipr().modify(|_, w| w.fdcansel().pclk());
    rcc.apb1enr1()
        .modify(|_, w| w.fdcanen().enabled().tim2en().enabled().tim3en().enabled());
    Some(())
}

/// Microseconds, by TIM2; TIM3 has their lowest 16 bits and stamps the frames.
pub struct Clock {
    base: TimeBase,
    timer: TIM2,
}

impl Clock {
    /// Both timers, from 0, and the first tick.
    pub fn new(timer: TIM2, stamps: &TIM3) -> Self {
        const PRESCALER: u16 = (HZ / 1_000_000 - 1) as u16;
        timer.psc().write(|w| w.psc().set(PRESCALER));
        stamps.psc().write(|w| w.psc().set(PRESCALER));
        timer.ccr1().write(|w| w.ccr().set(TICK_US));
        timer.dier().write(|w| w.cc1ie().set_bit());
        // takes over the prescalers, and begins at 0: one behind the other, some cycles apart
        timer.egr().write(|w| w.ug().set_bit());
        stamps.egr().write(|w| w.ug().set_bit());
        timer.cr1().write(|w| w.cen().set_bit());
        stamps.cr1().write(|w| w.cen().set_bit());
        Self {
            base: TimeBase::default(),
            timer,
        }
    }

    /// Now.
    pub fn now(&mut self) -> Micros {
        self.base.at(self.timer.cnt().read().bits())
    }

    /// The tick's interrupt: the next is one period behind this one, whenever this one was served.
    pub fn tick(&mut self) -> Micros {
        self.timer.sr().modify(|_, w| w.cc1if().clear_bit());
        let next = self.timer.ccr1().read().bits().wrapping_add(TICK_US);
        self.timer.ccr1().write(|w| w.ccr().set(next));
        self.now()
    }
}

/// Within what the [`Watchdog`] takes.
pub const PERIODS: Periods = Periods {
    tokens: [1000, 3000, 4000],
    opens: 1500,
};

/// The independent watchdog, by its own oscillator of 32 kHz within 5 %: it takes food from 1 ms to 5 ms behind the last.
pub struct Watchdog(IWDG);

impl Watchdog {
    /// From now on; nothing stops it but a debugger.
    pub fn start(own: IWDG, debug: &DBGMCU) -> Self {
        debug.apb1l_fz().modify(|_, w| w.dbg_iwdg_stop().set_bit());
        own.kr().write(|w| w.key().start());
        own.kr().write(|w| w.key().unlock());
        // 8 kHz: 40 counts, of which the first 8 are too early
        own.pr().write(|w| w.pr().divide_by4());
        own.rlr().write(|w| w.rl().set(40));
        own.winr().write(|w| w.win().set(32));
        Self(own)
    }

    /// Feed it.
    pub fn feed(&mut self) {
        self.0.kr().write(|w| w.key().feed());
    }
}
