//! The controller node on an emulated Cortex-M4F: QEMU's machine `mps2-an386`.
//!
//! The timer's interrupt, at the highest priority and on a stack of its own, is the servo tick: it makes every step
//! of the node that is due. What is left of the time is for the work of the ECP, and then for the log. What the hardware of a real board does, CAN
//! controllers above all, this machine has not: frames come and go by [`lock_step`] or [`real_time`].
//! `firmware/boards/README.md` tells how it is run.
#![no_std]
#![no_main]
#![deny(clippy::undocumented_unsafe_blocks, missing_docs)]

mod lock_step;
mod real_time;
mod semihosting;

use board::channel::{LONGEST, MAX_FRAMES};
use board::tandem::{Background, Halves};
use board_cortex_m::marks::{
    mrroc_tick_begins, mrroc_tick_ends, mrroc_work_begins, mrroc_work_ends,
};
use board_cortex_m::place::Place;
use board_cortex_m::{log, stack};
use core::cell::Cell;
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_rt::{entry, exception};
use cortex_m_semihosting::debug;
use critical_section::Mutex;
use firmware::{NodeProcess, Received};
use lock_step::{Channel, Ended};
use protocol::message::NodeState;
use protocol::time::Micros;
use real_time::Mailbox;

/// The machine's clock.
const CLOCK_HZ: u32 = 25_000_000;
/// The shortest time between two steps of a node: half of the shortest servo step, 1 ms.
const TICK_US: u64 = 500;
/// The same in clock cycles.
const TICK_CYCLES: u32 = CLOCK_HZ / 1_000_000 * TICK_US as u32;
/// Memory of the node: with six axes 50 kB; the 10 kB of rim are messages and the log.
const NODE_BYTES: usize = if SEVEN_AXES { 56 * 1024 } else { 50 * 1024 };
/// Those that have seven.
const SEVEN_AXES: bool = cfg!(any(feature = "irp6-track", feature = "polycrank"));

static PLACE: Place<NODE_BYTES> = Place::new();

/// Where frames come from and go to.
enum Rim {
    LockStep(Channel),
    RealTime(Mailbox),
}

/// What the servo tick works with.
struct Servo {
    node: &'static mut (dyn NodeProcess + Send),
    rim: Rim,
    /// When the image started, by the clock of the cell.
    origin: Micros,
    state: NodeState,
    /// Ticks for which the cell's time stood still, since the ECP was at work for too long.
    stood: u32,
}

/// From the start to the tick.
static SERVO: Mutex<Cell<Option<Servo>>> = Mutex::new(Cell::new(None));
/// From the start to the rest.
static BACKGROUND: Mutex<Cell<Option<&'static mut dyn Background>>> = Mutex::new(Cell::new(None));
/// From the tick to the rest: what is to be done when all is over.
static ENDED: Mutex<Cell<Option<Ended>>> = Mutex::new(Cell::new(None));

#[entry]
fn main() -> ! {
    // a message of the channel: what is handed over to the tick only points to it
    static mut MESSAGE: [u8; LONGEST] = [0; LONGEST];
    if let Some((servo, background)) = start(MESSAGE) {
        critical_section::with(|cs| {
            SERVO.borrow(cs).set(Some(servo));
            BACKGROUND.borrow(cs).set(Some(background));
        });
        stack::divide(rest);
    }
    debug::exit(debug::EXIT_FAILURE);
    halt()
}

/// All below the tick.
extern "C" fn rest() -> ! {
    let background = critical_section::with(|cs| BACKGROUND.borrow(cs).take());
    if let (Some(peripherals), Some(background)) = (cortex_m::Peripherals::take(), background) {
        stack::paint_interrupts();
        begin_ticks(peripherals.SYST);
        work(background);
    }
    debug::exit(debug::EXIT_FAILURE);
    halt()
}

/// In lock step if the host has made the files for it, else in real time.
fn start(message: &'static mut [u8; LONGEST]) -> Option<(Servo, &'static mut dyn Background)> {
    let (Halves { node, background }, rim, origin) =
        if let Some(mut channel) = Channel::open(message) {
            let (halves, boot) = channel.boot(&PLACE)?;
            (halves, Rim::LockStep(channel), boot.now)
        } else {
            let (mailbox, halves, origin) = Mailbox::boot(&PLACE)?;
            (halves, Rim::RealTime(mailbox), origin)
        };
    let identity = node.identity();
    defmt::info!(
        "{=str}: a node of {=u8} axes",
        identity.robot.as_str(),
        identity.axes
    );
    let servo = Servo {
        state: node.state(),
        node,
        rim,
        origin,
        stood: 0,
    };
    Some((servo, background))
}

fn begin_ticks(mut timer: SYST) {
    timer.set_clock_source(SystClkSource::Core);
    timer.set_reload(TICK_CYCLES - 1);
    timer.clear_current();
    timer.enable_counter();
    timer.enable_interrupt();
}

/// The servo tick.
#[exception]
fn SysTick() {
    static mut TICKS: u64 = 0;
    static mut OWN: Option<Servo> = None;
    static mut RECEIVED: heapless::Vec<Received, MAX_FRAMES> = heapless::Vec::new();
    mrroc_tick_begins();
    if OWN.is_none() {
        *OWN = critical_section::with(|cs| SERVO.borrow(cs).take());
    }
    let ticks = *TICKS;
    let stands = OWN.as_mut().is_some_and(|servo| servo.stands(ticks));
    if !stands {
        *TICKS = ticks.wrapping_add(1);
    }
    if let Some(servo) = OWN
        && !stands
    {
        let now = Micros(servo.origin.0.wrapping_add(ticks.wrapping_mul(TICK_US)));
        match servo.tick(ticks, now, RECEIVED) {
            Ok(Some(state)) if state != servo.state => {
                servo.state = state;
                defmt::info!("at {=u64} us: state {=u8}", now.0, state as u8);
            }
            Ok(_) => {}
            Err(ended) => {
                defmt::info!("time stood still for {=u32} ticks", servo.stood);
                *OWN = None;
                critical_section::with(|cs| ENDED.borrow(cs).set(Some(ended)));
            }
        }
    }
    mrroc_tick_ends();
}

impl Servo {
    /// The time of the cell stands still while the ECP is at work for longer than it may: this processor has no time
    /// of its own that would mean anything. How often is told in the end, and it is a figure. In real time it does so
    /// as well while the cell is behind.
    fn stands(&mut self, ticks: u64) -> bool {
        if let Rim::RealTime(mailbox) = &mut self.rim
            && mailbox.holds(ticks)
        {
            return true;
        }
        let stands = self.node.wants_time();
        self.stood = self.stood.wrapping_add(u32::from(stands));
        stands
    }

    /// Whatever is due now; the state after it, if anything was.
    fn tick(
        &mut self,
        ticks: u64,
        now: Micros,
        received: &mut heapless::Vec<Received, MAX_FRAMES>,
    ) -> Result<Option<NodeState>, Ended> {
        let stepped = match &mut self.rim {
            Rim::LockStep(_) if now < self.node.next_wake() => return Ok(None),
            Rim::LockStep(channel) => {
                let into_tick = TICK_CYCLES.wrapping_sub(SYST::get_current());
                let cycles = ticks
                    .wrapping_mul(u64::from(TICK_CYCLES))
                    .wrapping_add(u64::from(into_tick));
                channel.step(self.node, cycles, received)?
            }
            Rim::RealTime(mailbox) => mailbox
                .tick(self.node, ticks, now, received)
                .ok_or(Ended::Done)?,
        };
        Ok(Some(stepped.state))
    }
}

/// The ECP's work, and all that has no deadline.
fn work(background: &mut dyn Background) {
    let Some(console) = semihosting::File::console() else {
        return;
    };
    // ends when the host does
    loop {
        if background.take_order() {
            mrroc_work_begins();
            background.work();
            mrroc_work_ends();
        }
        let ended = critical_section::with(|cs| ENDED.borrow(cs).take());
        if let Some(ended) = ended {
            defmt::info!(
                "stacks: {=u32} bytes for servo steps, {=u32} for the rest",
                stack::used_by_interrupts(),
                stack::used_by_rest()
            );
            drain(console);
            if ended == Ended::Done {
                debug::exit(debug::EXIT_SUCCESS);
            }
            return;
        }
        drain(console);
        cortex_m::asm::wfi();
    }
}

fn drain(console: semihosting::File) {
    let mut bytes = [0; 128];
    // each turn takes a byte at least, of a ring that nobody fills meanwhile
    loop {
        let taken = log::take(&mut bytes);
        match bytes.get(..taken) {
            Some(some) if !some.is_empty() => {
                console.write(some);
            }
            _ => return,
        }
    }
}

fn halt() -> ! {
    loop {
        cortex_m::asm::wfi();
    }
}
