//! A dominant level that does not end: what every controller makes of it.

use super::bits::{self, Bit, Level};
use super::confinement::State;
use super::controller::Controller;
use super::sending::{Sending, Transmission};
use super::{Tap, Wire};
use protocol::budget::{self, Bits, Rates};
use protocol::frame::Frame;

/// Dominant bits in a row that break the rule of stuffing: who only listens knows it at the end of the last.
const STUFF_ERROR: usize = 6;
/// The same, of a level that begins while nobody sends.
const IDLE_STUFF_ERROR: u64 = 6;
/// The last bits of a frame are interframe space: it is over, and a dominant bit in it asks for an overload flag.
const INTERFRAME_BITS: u64 = 3;
/// The first bit behind an error flag of a receiver: dominant, it means that the receiver saw the error first.
const BEHIND_FLAG: u64 = 7;
/// Dominant bits from the start of a flag on after which the counters go up, and …
const DOMINANT_FIRST: u64 = 14;
/// … again after so many more.
const DOMINANT_NEXT: u64 = 8;
/// Delimiters, acknowledge slot, end of frame and interframe space: the nominal bits after the CRC.
const TRAILER: u32 = 13;
const NOMINAL_BIT: Bits = Bits {
    nominal: 1,
    data: 0,
};
const DATA_BIT: Bits = Bits {
    nominal: 0,
    data: 1,
};
/// After so many counts no counter changes any more: 32 make bus-off.
const COUNTS: u64 = 33;

/// What a controller was doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Part {
    /// It sends: its counts lead to bus-off.
    Transmitter,
    /// It listens, and its flag tells of an error.
    Receiver,
    /// It listens, and its flag is one of overload, which counts nothing by itself.
    Overloaded,
}

/// One controller and the level.
#[derive(Clone, Copy, Debug)]
struct Held {
    tap: Tap,
    part: Part,
    /// When its flag began, ns.
    since_ns: u64,
    /// How often its counter went up since.
    counted: u64,
}

impl Held {
    /// After how many bits of its flag the counter goes up for the time that is due.
    const fn next_count(&self) -> u64 {
        match (self.part, self.counted) {
            (Part::Receiver, 0) => BEHIND_FLAG,
            (Part::Receiver, before) => DOMINANT_FIRST + (before - 1) * DOMINANT_NEXT,
            (Part::Transmitter | Part::Overloaded, before) => {
                DOMINANT_FIRST + before * DOMINANT_NEXT
            }
        }
    }
}

/// A dominant level that does not end.
#[derive(Clone, Debug)]
pub(super) struct Dominance(Vec<Held>);

/// What the level does to one who sends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Struck {
    /// The next recessive bit is one of its arbitration: it has lost, and listens.
    Lost,
    /// Its flag begins so many ns later. Its counter goes up, unless what it saw is a stuff bit in its arbitration
    /// (ISO 11898-1:2015, 12.1.4.2 c, exception B).
    Error { after_ns: u64, counts: bool },
}

/// A frame in its course when the level begins.
struct Course {
    rates: Rates,
    bits: Vec<Bit>,
    /// Of them, and of what follows them, so many are at the nominal rate.
    nominal: usize,
    /// The first bit that is dominant whatever is sent.
    from: usize,
}

impl Course {
    fn new(rates: Rates, frame: &Frame, passive: bool, elapsed_ns: u64) -> Self {
        let nominal = budget::exact(frame).nominal.saturating_sub(TRAILER);
        let arbitration_ns = rates.duration_ns(Bits { nominal, data: 0 });
        let whole = |time_ns: u64, bits| time_ns.div_ceil(rates.duration_ns(bits).max(1));
        let from = whole(elapsed_ns.min(arbitration_ns), NOMINAL_BIT)
            + whole(elapsed_ns.saturating_sub(arbitration_ns), DATA_BIT);
        Self {
            rates,
            bits: bits::of(frame, passive),
            nominal: usize::try_from(nominal).unwrap_or(usize::MAX),
            from: usize::try_from(from).unwrap_or(usize::MAX),
        }
    }

    /// From the level's begin to the end of the bit that lies so many behind it, ns.
    fn until_ns(&self, behind: usize) -> u64 {
        let number = |bits: usize| u32::try_from(bits).unwrap_or(u32::MAX);
        let end = self.from.saturating_add(behind).saturating_add(1);
        let nominal = end.min(self.nominal).saturating_sub(self.from);
        let data = end.saturating_sub(self.from).saturating_sub(nominal);
        self.rates.duration_ns(Bits {
            nominal: number(nominal),
            data: number(data),
        })
    }

    /// Who sends sees it at the next recessive bit; behind the data that is not looked for, and the next bit is taken.
    fn sender(&self) -> Struck {
        let behind = self.bits.get(self.from..).unwrap_or_default();
        let recessive = behind.iter().position(|bit| bit.level == Level::Recessive);
        let bit = recessive.and_then(|place| behind.get(place));
        let arbitrates = bit.is_some_and(|bit| bit.arbitrates);
        if arbitrates && bit.is_some_and(|bit| !bit.stuffed) {
            return Struck::Lost;
        }
        Struck::Error {
            after_ns: self.until_ns(recessive.unwrap_or(0)),
            counts: !arbitrates,
        }
    }

    /// Who listens sees the sixth dominant bit in a row.
    fn receiver_ns(&self) -> u64 {
        let before = self.bits.get(..self.from).unwrap_or_default();
        let dominant = |bit: &&Bit| bit.level == Level::Dominant;
        let run = before.iter().rev().take_while(dominant).count();
        self.until_ns(STUFF_ERROR.saturating_sub(run + 1))
    }
}

impl Wire {
    /// The level begins now. What is on the wire is destroyed by it, unless it is over but for its interframe space.
    pub(super) fn become_dominant(&mut self) {
        let bit_ns = self.bit_ns();
        for controller in &mut self.controllers {
            controller.begun(self.now_ns, bit_ns);
        }
        let between_ns = self.now_ns + INTERFRAME_BITS * bit_ns;
        if let Some(transmission) = self.on_bus.take_if(|sent| sent.ends_ns > between_ns) {
            self.strike(transmission);
        } else {
            let senders = self.on_bus.as_ref().map(Transmission::senders);
            let held = self.participants().map(|tap| {
                let (part, bits) = match senders {
                    Some(senders) if senders.contains(tap) => (Part::Transmitter, 1),
                    Some(_) => (Part::Overloaded, 1),
                    None => (Part::Receiver, IDLE_STUFF_ERROR),
                };
                (tap, part, bits * bit_ns)
            });
            let held = held.collect();
            self.hold(held);
        }
        self.statistics.errors += 1;
    }

    fn participants(&self) -> impl Iterator<Item = Tap> {
        let all = self.controllers.iter().enumerate();
        all.filter(|(_, controller)| controller.takes_part())
            .map(|(tap, _)| tap)
    }

    /// A frame is struck in its course.
    fn strike(&mut self, transmission: Transmission) {
        let elapsed_ns = self.now_ns.saturating_sub(transmission.begun_ns());
        let senders = transmission.senders();
        let course = |sending: &Sending| {
            let passive = self.state(sending.tap) != State::Active;
            Course::new(self.rates, &sending.waiting.frame, passive, elapsed_ns)
        };
        let (listens_ns, struck) = if transmission.is_sound() {
            let course = course(&transmission.first);
            (course.receiver_ns(), course.sender())
        } else {
            // its errors are there, or would have come
            let after_ns = self.bit_ns();
            let counts = true;
            (after_ns, Struck::Error { after_ns, counts })
        };
        let held = self.participants().map(|tap| match struck {
            Struck::Error { after_ns, .. } if senders.contains(tap) => {
                (tap, Part::Transmitter, after_ns)
            }
            Struck::Error { .. } | Struck::Lost => (tap, Part::Receiver, listens_ns),
        });
        let held: Vec<_> = held.collect();
        for (tap, part, _) in &held {
            if *part == Part::Transmitter && matches!(struck, Struck::Error { counts: true, .. }) {
                self.held_sender(*tap);
            }
        }
        self.hold(held);
        for sending in transmission.into_all().filter(|sending| sending.again) {
            self.put_back(sending);
        }
    }

    /// These see a dominant level, and their flags begin so many ns from now.
    fn hold(&mut self, all: Vec<(Tap, Part, u64)>) {
        let begins = |(tap, part, after_ns)| Held {
            tap,
            part,
            since_ns: self.now_ns + after_ns,
            counted: 0,
        };
        let held: Vec<Held> = all.into_iter().map(begins).collect();
        for held in held.iter().filter(|held| held.part == Part::Receiver) {
            if let Some(controller) = self.controllers.get_mut(held.tap) {
                controller.counters.receive_failed(false);
            }
        }
        self.dominance = Some(Dominance(held));
    }

    /// A transmitter counts.
    fn held_sender(&mut self, tap: Tap) {
        if let Some(controller) = self.controllers.get_mut(tap) {
            controller.counters.send_failed();
            if controller.counters.state() == State::BusOff {
                self.statistics.bus_off += 1;
            }
        }
    }

    /// Counts the errors of a level that is dominant still.
    pub(super) fn dominate(&mut self) {
        let Some(Dominance(mut all)) = self.dominance.take() else {
            return;
        };
        let bit_ns = self.bit_ns().max(1);
        for held in &mut all {
            let bits = self.now_ns.saturating_sub(held.since_ns) / bit_ns;
            while held.counted < COUNTS && held.next_count() <= bits {
                held.counted += 1;
                let takes_part = |controller: &&mut Controller| controller.takes_part();
                let Some(controller) = self.controllers.get_mut(held.tap).filter(takes_part) else {
                    continue;
                };
                match held.part {
                    Part::Transmitter => self.held_sender(held.tap),
                    Part::Receiver | Part::Overloaded => controller.counters.held_dominant(),
                }
            }
        }
        self.dominance = Some(Dominance(all));
    }
}
