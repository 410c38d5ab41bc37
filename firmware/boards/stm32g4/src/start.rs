//! From reset to a node: clocks, buses, the configuration, the node and those who keep it.

use crate::can::{self, Can};
use crate::clock::{self, Clock};
use crate::flash::{Flash, bank_2_is_first};
use crate::unique_id;
use board::boot::{Boot, Linked};
use board::config;
use board::reset::Begun;
use board::rim::Rim;
use board::tandem::{Background, Halves};
use board::upkeep::{Clerk, Desk, Recorded};
use board_cortex_m::kept;
use board_cortex_m::place::Place;
use cortex_m::peripheral::SCB;
use firmware::maintenance::black_box::BlackBox;
use firmware::maintenance::{Librarian, Recorder, Start};
use firmware::update::Updater;
use firmware::update::slots::Slots;
use firmware::update::stm32g474::LAYOUT;
use protocol::budget::Rates;
use protocol::maintenance::{Slot, target};
use protocol::time::Micros;
use protocol::transfer::Mtu;
use stm32g4::stm32g474::{FLASH, PWR, RCC, SYSCFG, TIM2, TIM3};

/// What images are made for.
const TARGET: &str = "stm32g474";
/// An answer that was made has left the controller after so long, cycles: 20 ms.
const FAREWELL: u32 = clock::HZ / 50;

/// What of the processor the node needs: clocks, power, flash with its banks, and the two timers of its time.
pub struct Peripherals(pub RCC, pub PWR, pub FLASH, pub SYSCFG, pub TIM2, pub TIM3);

/// Where things are that have to stay for ever.
pub struct Places {
    desk: Desk,
    recorded: Option<Recorded<'static, &'static mut [u8]>>,
}

impl Places {
    /// Empty.
    #[expect(clippy::new_without_default, reason = "a static")]
    pub const fn new() -> Self {
        Self {
            desk: Desk::new(),
            recorded: None,
        }
    }
}

/// A processor that runs, and its node if there can be one.
pub struct Started {
    /// The time.
    pub clock: Clock,
    /// Towards the MP, and two drive buses.
    pub buses: [Can; 3],
    /// The servo steps.
    pub rim: Option<Rim<'static>>,
    /// What is done below them.
    pub below: Option<Below>,
    /// The servo period.
    pub period: Micros,
}

/// The work of the ECP and the librarian's.
pub struct Below {
    background: &'static mut dyn Background,
    clerk: Clerk<'static, Flash>,
}

impl Below {
    /// Whatever there is to do; a wish to restart is granted here, once its answer is sent.
    pub fn work(&mut self) {
        if self.background.take_order() {
            self.background.work();
        }
        if self.clerk.attend() {
            // servo steps go on meanwhile, and with them the answer
            cortex_m::asm::delay(FAREWELL);
            SCB::sys_reset();
        }
    }
}

/// Starts the processor, and the node of its configuration, or with `anew` that of the image; `in_slot`: the image is in a slot
/// of the bootloader's.
///
/// # Safety
/// To be called once. The image is in the slot that is shown, or `in_slot` is false and it leaves the last two pages alone.
pub unsafe fn start<L: Linked, const BYTES: usize>(
    Peripherals(rcc, pwr, flash, syscfg, tim2, tim3): Peripherals,
    begun: &Begun,
    anew: bool,
    in_slot: bool,
    place: &'static Place<BYTES>,
    places: &'static mut Places,
) -> Started {
    if clock::start(&rcc, &pwr, &flash).is_none() {
        // no crystal, no CAN: again, without torque
        SCB::sys_reset();
    }
    let bank_2_first = bank_2_is_first(&rcc, &syscfg);
    // SAFETY: what is written are the two pages of the configuration and, in a slot, the log and the other slot
    let mut flash = unsafe { Flash::new(flash, bank_2_first) };
    let found = config::load(flash.configuration(in_slot), anew);
    if !found.stored {
        defmt::error!("the configuration could not be saved");
    }
    let mtu = found.boot.as_ref().map_or(Mtu::Fd, |b| b.station.mtu);
    let (timing, rates) = match mtu {
        Mtu::Fd => (&can::FD, Rates::FD_1M_5M),
        Mtu::Classic => (&can::CLASSIC, Rates::CLASSIC_1M),
    };
    // SAFETY: once, as was promised
    let Ok(buses) = (unsafe { can::start(timing) }) else {
        SCB::sys_reset();
    };
    let mut clock = Clock::new(tim2, &tim3);
    let boot = found.boot.map(|mut boot| {
        (boot.now, boot.station.unique_id) = (clock.now(), unique_id());
        boot
    });
    let updater = if in_slot {
        let running = if bank_2_first { Slot::B } else { Slot::A };
        let slots = Slots::new(flash, LAYOUT).ok();
        slots.map(|slots| Updater::resume(slots, running))
    } else {
        flash.lock();
        None
    };
    let node = boot.and_then(|boot| node::<L, BYTES>(&boot, rates, begun, updater, place, places));
    let (rim, below) = node.unzip();
    let period = rim
        .as_ref()
        .map_or(0, |rim| rim.node().identity().servo_step_us);
    Started {
        clock,
        buses,
        rim,
        below,
        period: Micros(u64::from(period)),
    }
}

/// The node of a configuration, with its keepers.
fn node<L: Linked, const BYTES: usize>(
    boot: &Boot,
    rates: Rates,
    begun: &Begun,
    updater: Option<Updater<Flash>>,
    place: &'static Place<BYTES>,
    places: &'static mut Places,
) -> Option<(Rim<'static>, Below)> {
    let Halves { node, background } = boot.node_with::<L>(place).ok()?;
    let start = Start {
        target: target(TARGET)?,
        cause: begun.now.cause,
        boots: begun.now.resets.saturating_add(1),
    };
    let axes = usize::from(node.identity().axes);
    let black_box = BlackBox::open(kept::black_box()?, axes)?;
    let librarian = Librarian::new(start.target.clone(), updater);
    let Places { desk, recorded } = places;
    let desk = &*desk;
    let recorded = recorded.insert(Recorded::new(node, Recorder::new(start, black_box), desk));
    let (effector, mtu) = (boot.station.effector, boot.station.mtu);
    let below = Below {
        background,
        clerk: Clerk::new(librarian, desk),
    };
    Some((Rim::new(recorded, effector, mtu, rates), below))
}
