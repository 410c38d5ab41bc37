//! The controller node on ST's board NUCLEO-G474RE: FDCAN1 is the MP bus, FDCAN2 and FDCAN3 are drive buses.
//!
//! ```text
//!  4  tick   500 µs: emergency stop, brake, safe torque off, light, watchdog. Above everything, and short
//!  3  can_…  takes what has come: a receive queue has room for 3 frames, 330 µs, so it cannot wait for a step
//!  2  step   the servo steps of the node, whenever one is due
//!  1  work   what they order of the ECP, which has up to 16 ms for it; identity and images
//!  0  idle   the log
//! ```
//! What is no register is in `board`; `README.md` has the pins and what the light says.
#![no_std]
#![no_main]
#![deny(clippy::undocumented_unsafe_blocks, missing_docs)]

mod pins;

/// The tasks and what they share.
#[rtic::app(device = stm32g4::stm32g474, peripherals = true)]
mod app {
    use crate::pins;
    use board::alive::{Alive, LONGEST_WORK, Token};
    use board::guard::Category;
    use board::reset::cause_of_rcc_csr;
    use board::rim::{Call, Rim};
    use board::tick::Tick;
    use board::time_base::{Beat, stamped};
    use board::torque::Delays;
    use board_cortex_m::place::Place;
    use board_cortex_m::{kept, log, report, rtt, stack};
    use board_stm32g4::can::Can;
    use board_stm32g4::clock::{Clock, PERIODS, Watchdog};
    use board_stm32g4::pin::Pin;
    use board_stm32g4::start::{Below, Peripherals, Places, start};
    use embedded_hal::digital::InputPin;
    use firmware::{Port, Received};
    use programs::Linked;
    use protocol::frame::Frame;
    use protocol::message::NodeState;
    use protocol::time::Micros;
    use rtic::Mutex;
    use stm32g4::stm32g474::Interrupt;

    /// Memory of the node: a robot whose node is larger does not link.
    const NODE_BYTES: usize = if SEVEN_AXES { 56 * 1024 } else { 50 * 1024 };
    const SEVEN_AXES: bool = cfg!(any(feature = "irp6-track", feature = "polycrank"));
    /// Frames that wait for the node: those of 3 ms on two busy drive buses.
    const RECEIVED: usize = 24;
    type Inbox = board::inbox::Inbox<RECEIVED>;

    /// What an emergency stop does, and how long brakes take: to be changed with the machine.
    const CATEGORY: Category = Category::One { within: 500_000 };
    const DELAYS: Delays = Delays {
        opens_after: 30_000,
        closes_within: 100_000,
    };
    static PLACE: Place<NODE_BYTES> = Place::new();

    #[shared]
    struct Shared {
        clock: Clock,
        alive: Alive,
        inbox: Inbox,
        /// Towards the MP, and the two drive buses.
        buses: [Can; 3],
        beat: Beat,
        /// From the step to the tick, and back.
        state: Option<NodeState>,
        call: Option<Call>,
        /// Since when there is work.
        at_work: Option<Micros>,
    }

    #[local]
    struct Local {
        tick: Tick<Pin, Pin>,
        watchdog: Watchdog,
        rim: Option<Rim<'static>>,
        below: Option<Below>,
        received: heapless::Vec<Received, RECEIVED>,
    }

    #[init(local = [places: Places = Places::new()])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let p = cx.device;
        let begun = kept::begin(cause_of_rcc_csr(p.RCC.csr().read().bits()));
        p.RCC.csr().modify(|_, w| w.rmvf().set_bit());
        let mut panel = pins::start(&p.RCC, &p.GPIOA, &p.GPIOB, &p.GPIOC);
        let anew = panel.reset.is_high().unwrap_or(false);
        let peripherals = Peripherals(p.RCC, p.PWR, p.FLASH, p.SYSCFG, p.TIM2, p.TIM3);
        let (in_slot, places) = (cfg!(feature = "slot"), cx.local.places);
        // SAFETY: `init` runs once; `build.rs` links the image for a slot, or so that it leaves the last two pages alone
        let mut started =
            unsafe { start::<Linked, _>(peripherals, &begun, anew, in_slot, &PLACE, places) };
        let now = started.clock.now();
        stack::repaint();
        let shared = Shared {
            clock: started.clock,
            alive: Alive::new(now, PERIODS),
            inbox: Inbox::default(),
            buses: started.buses,
            beat: Beat::new(started.period),
            state: None,
            call: None,
            at_work: None,
        };
        let local = Local {
            tick: Tick::new(now, panel, CATEGORY, DELAYS, begun.now),
            watchdog: Watchdog::start(p.IWDG, &p.DBGMCU),
            rim: started.rim,
            below: started.below,
            received: heapless::Vec::new(),
        };
        (shared, local)
    }

    #[task(binds = TIM2, priority = 4, shared = [clock, alive, state, call], local = [tick, watchdog])]
    fn tick(cx: tick::Context) {
        let mut shared = cx.shared;
        let now = shared.clock.lock(Clock::tick);
        let state = shared.state.lock(|state| *state);
        let ticked = shared
            .alive
            .lock(|alive| cx.local.tick.run(now, state, alive));
        if ticked.feed {
            cx.local.watchdog.feed();
        }
        if let Some(words) = ticked.remember {
            kept::write(words);
        }
        shared.call.lock(|call| *call = ticked.call);
        rtic::pend(Interrupt::I2C4_EV);
    }

    /// A controller's interrupt.
    fn serve(
        mut clock: impl Mutex<T = Clock>,
        mut buses: impl Mutex<T = [Can; 3]>,
        mut inbox: impl Mutex<T = Inbox>,
        which: usize,
    ) {
        let now = clock.lock(Clock::now);
        buses.lock(|buses| {
            if let Some(can) = buses.get_mut(which) {
                can.interrupt(now, |received| inbox.lock(|i| i.push(received)));
            }
        });
    }

    #[task(binds = FDCAN1_IT0, priority = 3, shared = [clock, buses, inbox])]
    fn can_mp(cx: can_mp::Context) {
        serve(cx.shared.clock, cx.shared.buses, cx.shared.inbox, 0);
    }

    #[task(binds = FDCAN2_IT0, priority = 3, shared = [clock, buses, inbox])]
    fn can_drives(cx: can_drives::Context) {
        serve(cx.shared.clock, cx.shared.buses, cx.shared.inbox, 1);
    }

    #[task(binds = FDCAN3_IT0, priority = 3, shared = [clock, buses, inbox])]
    fn can_more_drives(cx: can_more_drives::Context) {
        serve(cx.shared.clock, cx.shared.buses, cx.shared.inbox, 2);
    }

    /// Of an interrupt that this board does not use otherwise.
    #[task(binds = I2C4_EV, priority = 2, local = [rim, received],
        shared = [clock, alive, inbox, buses, beat, state, call, at_work])]
    fn step(cx: step::Context) {
        let (mut s, received) = (cx.shared, cx.local.received);
        let now = s.clock.lock(Clock::now);
        s.buses
            .lock(|buses| buses.each_mut().map(|can| can.tend(now)));
        for _ in received.len()..RECEIVED {
            let Some(frame) = s.inbox.lock(Inbox::pop) else {
                break;
            };
            let _ = received.push(frame);
        }
        let call = s.call.lock(|call| *call);
        if let Some(rim) = cx.local.rim {
            rim.step(now, received, call, &mut |port, frame: Frame| {
                s.buses.lock(|[mp, drives, more_drives]| match port {
                    Port::Mp => mp.send(frame),
                    Port::Drives(0) => drives.send(frame),
                    Port::Drives(_) => more_drives.send(frame),
                });
            });
            s.state.lock(|state| *state = Some(rim.node().state()));
        }
        let now = s.clock.lock(Clock::now);
        if let Some(sent) = s.buses.lock(|[_, drives, _]| drives.sent()) {
            s.beat.lock(|beat| beat.heard(stamped(now, sent.stamp)));
        }
        let at_work = s.at_work.lock(|since| *since);
        s.alive.lock(|alive| {
            alive.tell(now, Token::Step);
            // idle cannot say so itself
            if at_work.is_some_and(|since| now.since(since) < LONGEST_WORK) {
                alive.tell(now, Token::Idle);
            }
        });
        rtic::pend(Interrupt::I2C4_ER);
    }

    /// Of another one.
    #[task(binds = I2C4_ER, priority = 1, local = [below], shared = [clock, at_work])]
    fn work(cx: work::Context) {
        let mut s = cx.shared;
        let now = s.clock.lock(Clock::now);
        s.at_work.lock(|since| *since = Some(now));
        if let Some(below) = cx.local.below {
            below.work();
        }
        s.at_work.lock(|since| *since = None);
    }

    #[idle(shared = [clock, alive, inbox, buses, beat])]
    fn idle(cx: idle::Context) -> ! {
        let mut s = cx.shared;
        let mut told = Micros(0);
        loop {
            let now = s.clock.lock(Clock::now);
            s.alive.lock(|alive| alive.tell(now, Token::Idle));
            if now.since(told) >= Micros::from_millis(1000) {
                told = now;
                let buses = s.buses.lock(|buses| buses.each_ref().map(Can::counts));
                let lost = s.inbox.lock(|inbox| inbox.lost());
                s.beat.lock(|beat| report::counts(beat, lost, buses));
            }
            let mut bytes = [0; 64];
            let taken = log::take(&mut bytes);
            if let Some(bytes) = bytes.get(..taken) {
                rtt::write(bytes);
            }
            cortex_m::asm::wfi();
        }
    }
}
