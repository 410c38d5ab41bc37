//! The controller node on ST's board NUCLEO-G474RE: FDCAN1 is the MP bus, FDCAN2 and FDCAN3 are drive buses.
//!
//! ```text
//!  4  tick   500 µs: emergency stop, brake, safe torque off, light, watchdog. Above everything, and short
//!  3  can_…  takes what has come: a receive queue has room for 3 frames, 330 µs, so it cannot wait for a step
//!  2  step   the node, whenever it is due
//!  0  idle   the log
//! ```
//! What is no register is in `board`; `README.md` has the pins and what the light says.
#![no_std]
#![no_main]
#![deny(clippy::undocumented_unsafe_blocks, missing_docs)]

mod clock;
mod flash;
mod pins;

/// The tasks and what they share.
#[rtic::app(device = stm32g4::stm32g474, peripherals = true)]
mod app {
    use crate::clock::{self, Clock, Watchdog};
    use crate::flash::Pages;
    use crate::pins::{self, Pin};
    use board::alive::{Alive, Periods, Token};
    use board::bit_timing::BitTiming;
    use board::boot::Boot;
    use board::emergency::Emergency;
    use board::guard::{Category, Guard, Panel};
    use board::light::Light;
    use board::mcan::{MCan, MEMORY, Words as _};
    use board::port::CanPort;
    use board::reset::{Record, ResetCause};
    use board::rim::{Call, Rim};
    use board::store::Store;
    use board::time_base::{Beat, stamped};
    use board::torque::Delays;
    use board_cortex_m::place::Place;
    use board_cortex_m::window::Window;
    use board_cortex_m::{kept, log, rtt, stack};
    use embedded_hal::digital::InputPin;
    use firmware::{Port, Received};
    use protocol::budget::Rates;
    use protocol::frame::{Frame, Id};
    use protocol::message::NodeState;
    use protocol::time::Micros;
    use protocol::transfer::Mtu;
    use rtic::Mutex;
    use stm32g4::stm32g474::Interrupt;

    /// Of what the configuration in flash means.
    const VERSION: u16 = 1;
    /// Memory of the node.
    const NODE_BYTES: usize = 100 * 1024;
    /// Frames that wait: for the node, and on each bus.
    const RECEIVED: usize = 24;
    const WAITING: usize = 16;
    /// What an emergency stop does, and how long brakes take: to be changed with the machine.
    const CATEGORY: Category = Category::One { within: 500_000 };
    const DELAYS: Delays = Delays {
        opens_after: 30_000,
        closes_within: 100_000,
    };
    /// The watchdog takes food from 1 ms to 5 ms behind the last, within 5 %.
    const PERIODS: Periods = Periods {
        tokens: [1000, 3000, 4000],
        opens: 1500,
    };
    static PLACE: Place<NODE_BYTES> = Place::new();

    type Can = CanPort<Window, WAITING>;

    /// What has come and waits for the node.
    #[derive(Default)]
    pub struct Inbox {
        frames: heapless::Deque<Received, RECEIVED>,
        lost: u32,
    }

    #[shared]
    struct Shared {
        clock: Clock,
        alive: Alive,
        inbox: Inbox,
        mp: Can,
        drives: Can,
        more_drives: Can,
        beat: Beat,
        /// From the step to the tick, and back.
        state: Option<NodeState>,
        call: Option<Call>,
    }

    #[local]
    struct Local {
        guard: Guard,
        panel: Panel<Pin, Pin>,
        watchdog: Watchdog,
        record: Record,
        rim: Option<Rim<'static>>,
        received: heapless::Vec<Received, RECEIVED>,
    }

    /// Identifier of SYNC on a bus of one's own: of it the controller tells when it was sent.
    const SYNC: Id = Id::Standard(0x80);

    /// FDCAN 1 to 3 by their number from 0, and their parts of the message memory.
    fn can(number: usize, port: Port, timing: &BitTiming) -> Option<Can> {
        // SAFETY: the registers of one FDCAN, and its own part of the message memory; each number is used once
        let (registers, memory) = unsafe {
            (
                Window::new(0x4000_6400 + 0x400 * number, 0x104 / 4),
                Window::new(0x4000_A400 + 4 * MEMORY * number, MEMORY),
            )
        };
        let can = MCan::start(registers, memory, timing, Some(SYNC)).ok()?;
        Some(CanPort::new(port, can))
    }

    /// Of this very processor: the 96 bits that ST wrote into it.
    fn unique_id() -> u64 {
        // SAFETY: constants of the factory (RM0440, 48.1)
        let words = unsafe { Window::new(0x1FFF_7590, 3) };
        let [a, b, c] = [0, 1, 2].map(|k| u64::from(words.read(k)));
        (a ^ c.rotate_left(16)) | b << 32
    }

    /// What flash says, or, without it or with the button held, what this image says, which is then written there.
    fn configuration(flash: Pages, anew: bool) -> Option<Boot> {
        let mut store = Store::new(flash, VERSION);
        let loaded = store.load();
        let twice = loaded.as_ref().is_some_and(|loaded| loaded.twice);
        let found = loaded.and_then(|loaded| Boot::read(&loaded.content));
        let boot = match found.filter(|_| !anew) {
            Some(boot) if twice => return Some(boot),
            Some(boot) => boot,
            None => Boot::unconfigured(Micros(0))?,
        };
        let mut content = [0; Boot::BYTES];
        let _ = boot.write(&mut content)?;
        if store.save(&content).is_err() {
            defmt::error!("the configuration could not be saved");
        }
        Some(boot)
    }

    #[init]
    fn init(cx: init::Context) -> (Shared, Local) {
        let p = cx.device;
        let cause = ResetCause::from_rcc_csr(p.RCC.csr().read().bits());
        p.RCC.csr().modify(|_, w| w.rmvf().set_bit());
        let begun = Record::begin(&kept::read(), cause);
        kept::write(begun.now.write());
        let mut panel = pins::start(&p.RCC, &p.GPIOA, &p.GPIOB, &p.GPIOC);
        if clock::start(&p.RCC, &p.PWR, &p.FLASH).is_none() {
            // no crystal, no CAN: again, without torque
            cortex_m::peripheral::SCB::sys_reset();
        }
        if let Some(before) = begun.before {
            defmt::info!(
                "reset {=u32}, cause {=u8}, watchdog {=u32}; in state {=u8}, missing {=u8}",
                begun.now.resets,
                cause as u8,
                begun.now.watchdog,
                before.state as u8,
                before.missing.map_or(u8::MAX, |token| token as u8)
            );
        }
        let anew = panel.reset.is_high().unwrap_or(false);
        let boot = configuration(Pages::new(p.FLASH), anew);
        let fd = boot.as_ref().is_none_or(|boot| boot.station.mtu == Mtu::Fd);
        let (timing, rates, mtu) = if fd {
            (&clock::MP_FD, Rates::FD_1M_5M, Mtu::Fd)
        } else {
            (&clock::DRIVES, Rates::CLASSIC_1M, Mtu::Classic)
        };
        let cans = (
            can(0, Port::Mp, timing),
            can(1, Port::Drives(0), &clock::DRIVES),
            can(2, Port::Drives(1), &clock::DRIVES),
        );
        let (Some(mp), Some(drives), Some(more_drives)) = cans else {
            cortex_m::peripheral::SCB::sys_reset();
        };
        let mut clock = Clock::new(p.TIM2, &p.TIM3);
        let now = clock.now();
        let made = boot.and_then(|mut boot| {
            boot.now = now;
            boot.station.unique_id = unique_id();
            let effector = boot.station.effector;
            boot.node(&PLACE).ok().map(|node| (node, effector))
        });
        let rim = made.map(|(node, effector)| Rim::new(node, effector, mtu, rates));
        let period = rim
            .as_ref()
            .map_or(0, |rim| rim.node().identity().servo_step_us);
        stack::repaint();
        let shared = Shared {
            clock,
            alive: Alive::new(now, PERIODS),
            inbox: Inbox::default(),
            mp,
            drives,
            more_drives,
            beat: Beat::new(Micros(u64::from(period))),
            state: None,
            call: None,
        };
        let local = Local {
            guard: Guard::new(now, CATEGORY, DELAYS),
            panel,
            watchdog: Watchdog::start(p.IWDG, &p.DBGMCU),
            record: begun.now,
            rim,
            received: heapless::Vec::new(),
        };
        (shared, local)
    }

    #[task(binds = TIM2, priority = 4, shared = [clock, alive, state, call], local = [guard, panel, watchdog, record])]
    fn tick(cx: tick::Context) {
        let tick::SharedResources {
            mut clock,
            mut alive,
            mut state,
            mut call,
            ..
        } = cx.shared;
        let tick::LocalResources {
            guard,
            panel,
            watchdog,
            record,
            ..
        } = cx.local;
        let now = clock.lock(Clock::tick);
        let state = state.lock(|state| *state);
        let is = guard.tick(now, panel.wires(), state);
        let everybody = matches!(is.emergency, Emergency::Pressed | Emergency::Discrepant);
        call.lock(|call| *call = is.stop.map(|kind| Call { kind, everybody }));
        let (fed, missing) = alive.lock(|alive| {
            alive.tell(now, Token::Tick);
            (alive.feed(now), alive.missing())
        });
        if fed {
            watchdog.feed();
        }
        panel.set(now, is.outputs, Light::of(state, missing, is.emergency));
        let remembered = Record {
            state: state.unwrap_or(NodeState::Boot),
            missing,
            ..*record
        };
        if remembered != *record {
            *record = remembered;
            kept::write(record.write());
        }
        rtic::pend(Interrupt::I2C4_EV);
    }

    /// A controller's interrupt.
    fn serve(
        mut clock: impl Mutex<T = Clock>,
        mut can: impl Mutex<T = Can>,
        mut inbox: impl Mutex<T = Inbox>,
    ) {
        let now = clock.lock(Clock::now);
        can.lock(|can| {
            can.interrupt(now, |received| {
                inbox.lock(|inbox| {
                    if inbox.frames.push_back(received).is_err() {
                        inbox.lost = inbox.lost.saturating_add(1);
                    }
                });
            });
        });
    }

    #[task(binds = FDCAN1_IT0, priority = 3, shared = [clock, mp, inbox])]
    fn can_mp(cx: can_mp::Context) {
        serve(cx.shared.clock, cx.shared.mp, cx.shared.inbox);
    }

    #[task(binds = FDCAN2_IT0, priority = 3, shared = [clock, drives, inbox])]
    fn can_drives(cx: can_drives::Context) {
        serve(cx.shared.clock, cx.shared.drives, cx.shared.inbox);
    }

    #[task(binds = FDCAN3_IT0, priority = 3, shared = [clock, more_drives, inbox])]
    fn can_more_drives(cx: can_more_drives::Context) {
        serve(cx.shared.clock, cx.shared.more_drives, cx.shared.inbox);
    }

    #[task(binds = I2C4_EV, priority = 2, shared = [clock, alive, inbox, mp, drives, more_drives, beat, state, call],
        local = [rim, received])]
    fn step(cx: step::Context) {
        let step::SharedResources {
            mut clock,
            mut alive,
            mut inbox,
            mut mp,
            mut drives,
            mut more_drives,
            mut beat,
            mut state,
            mut call,
            ..
        } = cx.shared;
        let received = cx.local.received;
        let now = clock.lock(Clock::now);
        mp.lock(|can| can.tend(now));
        drives.lock(|can| can.tend(now));
        more_drives.lock(|can| can.tend(now));
        for _ in received.len()..RECEIVED {
            let Some(frame) = inbox.lock(|inbox| inbox.frames.pop_front()) else {
                break;
            };
            let _ = received.push(frame);
        }
        let call = call.lock(|call| *call);
        if let Some(rim) = cx.local.rim {
            rim.step(now, received, call, &mut |port, frame: Frame| match port {
                Port::Mp => mp.lock(|can| can.send(frame)),
                Port::Drives(0) => drives.lock(|can| can.send(frame)),
                Port::Drives(_) => more_drives.lock(|can| can.send(frame)),
            });
            let is = rim.node().state();
            state.lock(|state| *state = Some(is));
        }
        let now = clock.lock(Clock::now);
        if let Some(sent) = drives.lock(Can::sent) {
            beat.lock(|beat| beat.heard(stamped(now, sent.stamp)));
        }
        alive.lock(|alive| alive.tell(now, Token::Step));
    }

    #[idle(shared = [clock, alive, inbox, mp, drives, more_drives, beat])]
    fn idle(cx: idle::Context) -> ! {
        let idle::SharedResources {
            mut clock,
            mut alive,
            mut inbox,
            mut mp,
            mut drives,
            mut more_drives,
            mut beat,
            ..
        } = cx.shared;
        let mut told = Micros(0);
        loop {
            let now = clock.lock(Clock::now);
            alive.lock(|alive| alive.tell(now, Token::Idle));
            if now.since(told) >= Micros::from_millis(1000) {
                told = now;
                defmt::info!(
                    "SYNC off by {=u32} us at most; stack {=u32} of {=u32} bytes; frames without room {=u32}",
                    beat.lock(Beat::worst),
                    stack::used(),
                    stack::reserved(),
                    inbox.lock(|inbox| inbox.lost)
                );
                let buses = [
                    mp.lock(|c| c.counts()),
                    drives.lock(|c| c.counts()),
                    more_drives.lock(|c| c.counts()),
                ];
                for (bus, (counts, unsent)) in [1, 2, 3].into_iter().zip(buses) {
                    if counts.overrun != 0 || counts.bus_off != 0 || unsent != 0 {
                        defmt::warn!(
                            "FDCAN{=u8}: {=u32} overruns, {=u32} times off, {=u32} unsent",
                            bus,
                            counts.overrun,
                            counts.bus_off,
                            unsent
                        );
                    }
                }
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
