//! A virtual bus segment: arbitration, frame lengths, nothing else.
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
//! Not modelled: errors, retransmission, propagation delay. Two taps that offer the same identifier
//! at the same time would collide on a real bus; here the lower tap wins and
//! [`Statistics::collisions`] counts it.

mod load;
mod post;
mod queue;

pub use post::{DEFAULT_CAPACITY, Outbox, PostError};

use load::Load;
use post::Queues;
use protocol::budget::{self, Rates};
use protocol::frame::Frame;
use queue::Queue;

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

/// A frame at its end: every tap but `from` receives it now.
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
    /// Arbitrations with the same identifier offered by two taps: an error of configuration.
    pub collisions: u64,
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

/// The frame on the bus.
#[derive(Clone, Debug)]
struct Transmission {
    ends_ns: u64,
    posted_ns: u64,
    from: Tap,
    frame: Frame,
}

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
    /// the bus.
    pub fn clear(&mut self, tap: Tap) {
        if let Some(queue) = self.queues.taps.get_mut(tap) {
            queue.clear();
        }
    }

    /// Frames that wait in the queue of `tap`.
    #[must_use]
    pub fn pending(&self, tap: Tap) -> usize {
        self.queues.taps.get(tap).map_or(0, Queue::len)
    }

    /// When the next delivery will happen if nothing else is posted; `None` while nothing waits.
    #[must_use]
    pub fn next_event_ns(&self) -> Option<u64> {
        if let Some(transmission) = &self.on_bus {
            return Some(transmission.ends_ns);
        }
        let start = self.next_start_ns()?;
        let tap = self.arbitrate(start)?;
        let queue = self.queues.taps.get(tap)?;
        let frame = queue.offer(start)?;
        Some(start + self.rates.duration_ns(budget::exact(frame)))
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
                Some(transmission) => self.finish(&transmission, deliver),
                None => break,
            }
        }
        self.now_ns = self.now_ns.max(until_ns);
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

    /// When the bus will next be idle and have an offer.
    fn next_start_ns(&self) -> Option<u64> {
        let earliest = self
            .queues
            .taps
            .iter()
            .filter_map(Queue::earliest_ns)
            .min()?;
        Some(earliest.max(self.idle_from_ns))
    }

    /// The tap with the most urgent offer at `at_ns`.
    fn arbitrate(&self, at_ns: u64) -> Option<Tap> {
        let mut best: Option<(u64, Tap)> = None;
        for (tap, queue) in self.queues.taps.iter().enumerate() {
            if let Some(urgency) = queue.urgency(at_ns)
                && best.is_none_or(|(lowest, _)| urgency < lowest)
            {
                best = Some((urgency, tap));
            }
        }
        best.map(|(_, tap)| tap)
    }

    /// Begins the next transmission if one can begin before `until_ns`; what is posted for that
    /// very moment may still take part in the arbitration.
    fn start(&mut self, until_ns: u64) -> bool {
        let Some(start) = self.next_start_ns().filter(|start| *start < until_ns) else {
            return false;
        };
        let Some(from) = self.arbitrate(start) else {
            return false;
        };
        let Some(queue) = self.queues.taps.get_mut(from) else {
            return false;
        };
        let Some(waiting) = queue.take(start) else {
            return false;
        };
        let urgency = waiting.frame.id().arbitration();
        let rivals = self.queues.taps.iter().skip(from + 1);
        if rivals
            .filter_map(|queue| queue.urgency(start))
            .any(|other| other == urgency)
        {
            self.statistics.collisions += 1;
        }
        let length = self.rates.duration_ns(budget::exact(&waiting.frame));
        self.load.occupy(start, start + length);
        self.statistics.busy_ns += length;
        self.on_bus = Some(Transmission {
            ends_ns: start + length,
            posted_ns: waiting.posted_ns,
            from,
            frame: waiting.frame,
        });
        true
    }

    fn finish(
        &mut self,
        transmission: &Transmission,
        deliver: &mut impl FnMut(Delivery<'_>, &mut Outbox<'_>),
    ) {
        let at_ns = transmission.ends_ns;
        self.idle_from_ns = at_ns;
        self.now_ns = self.now_ns.max(at_ns);
        let latency = at_ns.saturating_sub(transmission.posted_ns);
        let statistics = &mut self.statistics;
        statistics.frames += 1;
        statistics.worst_latency_ns = statistics.worst_latency_ns.max(latency);
        deliver(
            Delivery {
                at_ns,
                posted_ns: transmission.posted_ns,
                from: transmission.from,
                frame: &transmission.frame,
            },
            &mut Outbox {
                at_ns,
                queues: &mut self.queues,
            },
        );
    }
}

#[cfg(test)]
mod tests;
