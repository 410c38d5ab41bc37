//! A virtual bus segment: arbitration, frame lengths, errors and their confinement.
//!
//! A [`Wire`] is a discrete-event model of one CAN segment. Participants are *taps*, numbered from
//! 0. Each tap has a transmit queue that offers its most urgent frame first (as a controller with
//! priority-ordered mailboxes; frames of equal identifier keep their order). Whenever the bus is
//! idle, the tap whose offer has the lowest identifier wins; the frame then occupies the bus for
//! exactly its length ([`protocol::budget::exact`]), and all *other* taps receive it at its end.
//!
//! Time is an argument, in nanoseconds from any origin; nothing here reads a clock. The same calls
//! give the same deliveries, to the nanosecond.
//!
//! ```
//! use bus::wire::{Delivery, Kind, Wire};
//! use protocol::frame::{Frame, Id};
//!
//! let mut wire = Wire::new(Kind::Classic, 2);
//! wire.post(0, 0, Frame::classic(Id::Standard(0x80), &[]).unwrap()).unwrap();
//! let mut heard = Vec::new();
//! wire.advance(1_000_000, &mut |delivery: Delivery<'_>, _| heard.push(delivery.at_ns));
//! assert_eq!(heard, [51_000]); // 51 bits at 1 Mbit/s
//! ```
//!
//! A frame that nobody acknowledges, or that a [`Fault`] hits, ends in an error frame and is sent again;
//! error counters, error-passive and bus-off are those of [`confinement`]. Whoever is detached or bus-off
//! hears nothing ([`Delivery::reaches`]). A [`BusFault`] is wrong with the wire as a whole.
//!
//! Taps that offer the same identifier at the same time all win the arbitration and disturb each other, unless their
//! frames are equal; [`Statistics::collisions`] counts it.
//!
//! Not modelled: propagation delay, overload frames but those that follow a doubted end.

mod attempt;
mod bits;
mod bus_fault;
mod collision;
pub mod confinement;
mod controller;
mod dominance;
mod fault;
mod load;
mod post;
mod queue;
mod sending;

pub use bus_fault::{BusFault, UnknownBusFault};
pub use fault::{Disturbance, Fault, Taps};
pub use post::{DEFAULT_CAPACITY, Outbox, PostError};

use confinement::{Counters, State};
use controller::Controller;
use dominance::Dominance;
use fault::Faults;
use load::Load;
use post::Queues;
use protocol::budget::Rates;
use protocol::frame::Frame;
use queue::Queue;
use sending::Transmission;

/// A participant's number.
pub type Tap = usize;

/// What a wire carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Classical frames only.
    Classic,
    /// Classical and FD frames.
    Fd,
}

impl Kind {
    /// The bit rates used unless others are asked for: 1 Mbit/s, and 5 Mbit/s for FD data.
    #[must_use]
    pub const fn default_rates(self) -> Rates {
        match self {
            Self::Classic => Rates::CLASSIC_1M,
            Self::Fd => Rates::FD_1M_5M,
        }
    }
}

/// A frame at its end: every tap but `from` receives it now, unless it is among those who missed it.
#[derive(Clone, Copy, Debug)]
pub struct Delivery<'a> {
    /// When the frame's last bit (of the interframe space) was sent.
    pub at_ns: u64,
    /// When it was posted.
    pub posted_ns: u64,
    /// Who sent it.
    pub from: Tap,
    /// The frame.
    pub frame: &'a Frame,
    /// Taps that are detached or bus-off, or rejected the frame.
    pub missed: Taps,
}

impl Delivery<'_> {
    /// Does this tap receive the frame?
    #[must_use]
    pub const fn reaches(&self, tap: Tap) -> bool {
        tap != self.from && !self.missed.contains(tap)
    }
}

/// What a wire has carried since it was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Frames sent to their end.
    pub frames: u64,
    /// Time the bus was occupied, ns.
    pub busy_ns: u64,
    /// The greatest busy time within any [`LOAD_WINDOW_NS`] (windows begin at multiples of a tenth
    /// of it), ns.
    pub busiest_window_ns: u64,
    /// The longest time from posting to the end of the frame, ns.
    pub worst_latency_ns: u64,
    /// Frames refused because a queue was full or the frame was FD on a classical wire.
    pub refused: u64,
    /// Tries in which several taps sent the same identifier at once: an error of configuration.
    pub collisions: u64,
    /// Error frames: tries that came to nothing, or a frame that some had already accepted.
    pub errors: u64,
    /// How often a tap went bus-off.
    pub bus_off: u64,
}

impl Statistics {
    /// The greatest load over a window, 0 to 1.
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "nanoseconds far below 2^53")]
    pub fn load_max(&self) -> f64 {
        self.busiest_window_ns as f64 / LOAD_WINDOW_NS as f64
    }

    /// The load over `span_ns`, 0 to 1.
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "nanoseconds far below 2^53")]
    pub fn load_mean(&self, span_ns: u64) -> f64 {
        if span_ns == 0 {
            0.0
        } else {
            self.busy_ns as f64 / span_ns as f64
        }
    }
}

/// The window over which [`Statistics::load_max`] is taken.
pub const LOAD_WINDOW_NS: u64 = 10_000_000;

/// One segment.
#[derive(Clone, Debug)]
pub struct Wire {
    rates: Rates,
    queues: Queues,
    /// The bus is free from here on.
    idle_from_ns: u64,
    /// Up to here everything has happened.
    now_ns: u64,
    on_bus: Option<Transmission>,
    load: Load,
    statistics: Statistics,
    controllers: Vec<Controller>,
    faults: Faults,
    bus_fault: Option<BusFault>,
    /// While a dominant level is stuck on the wire.
    dominance: Option<Dominance>,
    /// No controller has to do with errors: the common case, which costs nothing.
    plain: bool,
}

impl Wire {
    /// An idle segment with so many taps, at the default rates and queue capacity.
    #[must_use]
    pub fn new(kind: Kind, taps: usize) -> Self {
        Self {
            rates: kind.default_rates(),
            queues: Queues::new(kind, taps),
            idle_from_ns: 0,
            now_ns: 0,
            on_bus: None,
            load: Load::default(),
            statistics: Statistics::default(),
            controllers: vec![Controller::default(); taps],
            faults: Faults::default(),
            bus_fault: None,
            dominance: None,
            plain: true,
        }
    }

    /// Lets every tap's queue hold so many frames.
    #[must_use]
    pub const fn with_capacity(mut self, frames: usize) -> Self {
        self.queues.capacity = frames;
        self
    }

    /// One more tap.
    pub fn add_tap(&mut self) -> Tap {
        self.controllers.push(Controller::default());
        self.queues.taps.push(Queue::default());
        self.queues.taps.len() - 1
    }

    /// What it carries.
    #[must_use]
    pub const fn kind(&self) -> Kind {
        self.queues.kind
    }

    /// Its bit rates.
    #[must_use]
    pub const fn rates(&self) -> Rates {
        self.rates
    }

    /// Other bit rates, from the next frame on.
    pub const fn set_rates(&mut self, rates: Rates) {
        self.rates = rates;
    }

    /// Queues a frame that `tap` wants to send from `at_ns` on. Times before the end of the last
    /// [`Self::advance`] count as that end.
    ///
    /// # Errors
    /// When the wire cannot carry the frame, or the queue is full; the frame is then lost.
    pub fn post(&mut self, tap: Tap, at_ns: u64, frame: Frame) -> Result<(), PostError> {
        self.queues.post(tap, at_ns.max(self.now_ns), frame)
    }

    /// Forgets everything `tap` has not yet sent (it was switched off), except a frame that is on
    /// the bus; if that is destroyed, it is not sent again.
    pub fn clear(&mut self, tap: Tap) {
        let sending = self.on_bus.iter_mut().flat_map(Transmission::all_mut);
        for sending in sending.filter(|sending| sending.tap == tap) {
            sending.again = false;
        }
        if let Some(queue) = self.queues.taps.get_mut(tap) {
            queue.clear();
        }
    }

    /// Frames that wait in the queue of `tap`.
    #[must_use]
    pub fn pending(&self, tap: Tap) -> usize {
        self.queues.taps.get(tap).map_or(0, Queue::len)
    }

    /// When the next delivery will happen if nothing else is posted; `None` while nothing waits. With
    /// faults to come it is when the next try ends.
    #[must_use]
    pub fn next_event_ns(&self) -> Option<u64> {
        if let Some(transmission) = &self.on_bus {
            return Some(transmission.ends_ns);
        }
        let start = self.next_start_ns()?;
        let attempt = self.attempt(start, &mut self.faults.clone())?;
        Some(start + attempt.length_ns)
    }

    /// Lets time pass until `until_ns`, inclusive: every frame that ends by then is delivered, in
    /// order of time. The callback may post answers through its [`Outbox`]; they take part in the
    /// arbitration from the moment of the delivery on.
    pub fn advance(
        &mut self,
        until_ns: u64,
        deliver: &mut impl FnMut(Delivery<'_>, &mut Outbox<'_>),
    ) {
        loop {
            if self.on_bus.is_none() && !self.start(until_ns) {
                break;
            }
            match self
                .on_bus
                .take_if(|transmission| transmission.ends_ns <= until_ns)
            {
                Some(transmission) => self.finish(transmission, deliver),
                None => break,
            }
        }
        self.now_ns = self.now_ns.max(until_ns);
        self.dominate();
        if self.on_bus.is_none() && self.dominance.is_none() && !self.plain {
            let bit_ns = self.bit_ns();
            for controller in &mut self.controllers {
                controller.idle_until(self.now_ns, bit_ns);
            }
        }
    }

    /// Lets a tap have so many transmit mailboxes, at least one, which its oldest frames fill; without
    /// this it has as many as frames. With one it sends in the order in which it was given frames.
    pub fn set_mailboxes(&mut self, tap: Tap, mailboxes: usize) {
        if let Some(queue) = self.queues.taps.get_mut(tap) {
            queue.set_mailboxes(mailboxes);
        }
    }

    /// Something will go wrong.
    pub fn disturb(&mut self, fault: Fault) {
        self.faults.push(fault);
    }

    /// Takes a tap off the wire, or puts it back, from the next frame on. Its queue and its error counters
    /// stay.
    pub fn set_attached(&mut self, tap: Tap, attached: bool) {
        if let Some(controller) = self.controllers.get_mut(tap) {
            controller.detached = !attached;
        }
        self.refresh();
    }

    /// Whether what costs nothing is enough.
    fn refresh(&mut self) {
        self.plain = self.bus_fault.is_none() && self.controllers.iter().all(Controller::is_plain);
    }

    /// Has nobody on it to do with errors?
    #[must_use]
    pub const fn is_plain(&self) -> bool {
        self.plain
    }

    /// Tells the controller of a tap to recover from bus-off: after 128 times eleven recessive bits it
    /// takes part again, and sends what waits. Without effect in other states.
    pub fn recover(&mut self, tap: Tap) {
        if let Some(controller) = self.controllers.get_mut(tap) {
            controller.recover(self.now_ns.max(self.idle_from_ns));
        }
    }

    /// The error counters of a tap; zero if there is no such tap.
    #[must_use]
    pub fn counters(&self, tap: Tap) -> Counters {
        let controller = self.controllers.get(tap);
        controller.map_or_else(Counters::default, |controller| controller.counters)
    }

    /// What the controller of a tap may do.
    #[must_use]
    pub fn state(&self, tap: Tap) -> State {
        self.counters(tap).state()
    }

    /// The counters.
    #[must_use]
    pub fn statistics(&self) -> Statistics {
        Statistics {
            refused: self.queues.refused,
            busiest_window_ns: self.load.busiest_ns(),
            ..self.statistics
        }
    }
}

#[cfg(test)]
mod tests;
