//! A node in two halves: servo steps, which preempt everything, and the ECP's work, which is preempted.
//!
//! The ECP goes from one to the other as a reference that lies in one of two places, so nobody ever has it twice and
//! nobody waits. Interrupts are held off while the reference is put there or taken, a few instructions.

use core::cell::Cell;
use core::mem::MaybeUninit;
use critical_section::Mutex;
use firmware::ecp::Programs;
use firmware::maintenance::black_box::Signals;
use firmware::maintenance::{Asked, Maintainable};
use firmware::{Ecp, Foreground, NodeProcess, NodeSetup, Port, Received};
use protocol::frame::Frame;
use protocol::maintenance::MaintenanceReply;
use protocol::message::{Identity, NodeState};
use protocol::time::Micros;
use robots::Robot;

/// A place for one thing, between two priorities.
pub(crate) struct Tray<T>(Mutex<Cell<Option<T>>>);

impl<T> core::fmt::Debug for Tray<T> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("tray")
    }
}

impl<T> Tray<T> {
    pub(crate) const fn new() -> Self {
        Self(Mutex::new(Cell::new(None)))
    }

    pub(crate) fn put(&self, thing: T) {
        critical_section::with(|cs| self.0.borrow(cs).set(Some(thing)));
    }

    pub(crate) fn take(&self) -> Option<T> {
        critical_section::with(|cs| self.0.borrow(cs).take())
    }
}

/// What of a node is done below the servo steps.
pub trait Background: Send {
    /// Is work ordered? It is taken then.
    fn take_order(&mut self) -> bool;
    /// The work that was taken. Eight of the ten servo steps of a macrostep must be enough for it, else the node stops with a fault.
    fn work(&mut self);
}

/// Both halves of a node.
#[derive(Debug)]
pub struct Halves {
    /// Servo steps.
    pub node: &'static mut (dyn Maintainable + Send),
    /// The rest.
    pub background: &'static mut dyn Background,
}

impl core::fmt::Debug for dyn Background {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("background")
    }
}

/// The place of a node and of what its halves need, each of which is made where it stays.
pub(crate) struct Tandem<R: 'static, const N: usize, P: 'static, const W: usize> {
    foreground: MaybeUninit<Foreground<R, N>>,
    ecp: MaybeUninit<Ecp<R, N, P, W>>,
    ordered: Tray<&'static mut Ecp<R, N, P, W>>,
    planned: Tray<&'static mut Ecp<R, N, P, W>>,
    fore: Option<Fore<R, N, P, W>>,
    back: Option<Back<R, N, P, W>>,
}

/// What the servo steps have. The ECP is `ecp` when it is at hand.
struct Fore<R: 'static, const N: usize, P: 'static, const W: usize> {
    foreground: &'static mut Foreground<R, N>,
    ecp: Option<&'static mut Ecp<R, N, P, W>>,
    ordered: &'static Tray<&'static mut Ecp<R, N, P, W>>,
    planned: &'static Tray<&'static mut Ecp<R, N, P, W>>,
}

/// What the rest has.
struct Back<R: 'static, const N: usize, P: 'static, const W: usize> {
    ecp: Option<&'static mut Ecp<R, N, P, W>>,
    ordered: &'static Tray<&'static mut Ecp<R, N, P, W>>,
    planned: &'static Tray<&'static mut Ecp<R, N, P, W>>,
}

impl<R, const N: usize, P, const W: usize> Tandem<R, N, P, W>
where
    R: Robot<N> + Copy + Send + 'static,
    P: Programs<N> + Send + 'static,
{
    /// Nothing in it yet.
    pub(crate) const fn new() -> Self {
        Self {
            foreground: MaybeUninit::uninit(),
            ecp: MaybeUninit::uninit(),
            ordered: Tray::new(),
            planned: Tray::new(),
            fore: None,
            back: None,
        }
    }

    /// The halves of the node of a setup, begun at `now`.
    pub(crate) fn begin(
        &'static mut self,
        now: Micros,
        setup: NodeSetup<R, N>,
        programs: P,
    ) -> Halves {
        let Self {
            foreground,
            ecp,
            ordered,
            planned,
            fore,
            back,
        } = self;
        let ecp = make_ecp(ecp, &setup, programs);
        let foreground = make_foreground(foreground, now, setup);
        Halves {
            node: fore.insert(Fore {
                foreground,
                ecp: Some(ecp),
                ordered,
                planned,
            }),
            background: back.insert(Back {
                ecp: None,
                ordered,
                planned,
            }),
        }
    }
}

// a frame of its own each: the compiler makes them on the stack first, but not both at once
#[inline(never)]
fn make_ecp<'a, R: Robot<N> + Copy, const N: usize, P: Programs<N>, const W: usize>(
    place: &'a mut MaybeUninit<Ecp<R, N, P, W>>,
    setup: &NodeSetup<R, N>,
    programs: P,
) -> &'a mut Ecp<R, N, P, W> {
    place.write(setup.ecp(programs))
}

#[inline(never)]
fn make_foreground<R: Robot<N> + Copy, const N: usize>(
    place: &mut MaybeUninit<Foreground<R, N>>,
    now: Micros,
    setup: NodeSetup<R, N>,
) -> &mut Foreground<R, N> {
    place.write(setup.foreground(now))
}

impl<R, const N: usize, P, const W: usize> NodeProcess for Fore<R, N, P, W>
where
    R: Robot<N> + Copy,
    P: Programs<N>,
{
    fn step(&mut self, now: Micros, rx: &[Received], mut tx: &mut dyn FnMut(Port, Frame)) {
        self.collect();
        let ecp = self.ecp.as_deref_mut();
        self.foreground.step(now, rx, ecp, &mut tx);
        if self.foreground.take_order()
            && let Some(ecp) = self.ecp.take()
        {
            self.ordered.put(ecp);
        }
    }

    fn next_wake(&self) -> Micros {
        self.foreground.next_wake()
    }

    fn state(&self) -> NodeState {
        self.foreground.state()
    }

    fn identity(&self) -> Identity {
        self.foreground.identity()
    }

    fn wants_time(&mut self) -> bool {
        self.collect();
        self.ecp.is_none() && self.foreground.takes_next()
    }
}

impl<R, const N: usize, P, const W: usize> Maintainable for Fore<R, N, P, W>
where
    R: Robot<N> + Copy,
    P: Programs<N>,
{
    fn servo_step(&self) -> u32 {
        self.foreground.servo_step()
    }

    fn signals(&self) -> Signals {
        self.foreground.signals()
    }

    fn take_asked(&mut self) -> Option<Asked> {
        self.foreground.take_asked()
    }

    fn answer(
        &mut self,
        asked: &Asked,
        reply: &MaintenanceReply,
        mut tx: &mut dyn FnMut(Port, Frame),
    ) {
        self.foreground.answer(asked, reply, &mut tx);
    }
}

impl<R, const N: usize, P, const W: usize> Fore<R, N, P, W> {
    /// The ECP, if it has come back.
    fn collect(&mut self) {
        if self.ecp.is_none() {
            self.ecp = self.planned.take();
        }
    }
}

/// It does not tell what is inside it: the code that would is half as large as the node's.
impl<R, const N: usize, P, const W: usize> core::fmt::Debug for Fore<R, N, P, W> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("node")
    }
}

impl<R, const N: usize, P, const W: usize> Background for Back<R, N, P, W>
where
    R: Robot<N> + Copy + Send,
    P: Programs<N> + Send,
{
    fn take_order(&mut self) -> bool {
        self.ecp = self.ordered.take();
        self.ecp.is_some()
    }

    fn work(&mut self) {
        if let Some(ecp) = self.ecp.take() {
            ecp.work();
            self.planned.put(ecp);
        }
    }
}
