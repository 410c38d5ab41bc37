//! Two-step time synchronisation: everyone's local clock against the master's bus time.
//!
//! Message k + 1 of [`TimeSync`] carries when message k was sent; each receiver knows when message
//! k arrived. CAN delivers a frame to all at once, so the pair (arrival of k here, departure of k
//! there) is free of arbitration delays: M. Gergeleit & H. Streich, "Implementing a distributed
//! high-resolution real-time clock using the CAN-bus", 1st iCC, 1994. A message of several frames
//! counts from the end of its first frame on both sides.
//!
//! [`Clock`] fits a line through the last [`WINDOW`] pairs (least squares), refuses pairs that are
//! far from it, and *slews*: bus time never steps and never runs backwards after the first pair.
//!
//! ```
//! use protocol::clock::{Clock, Master};
//! use protocol::time::Micros;
//! let (mut master, mut clock) = (Master::default(), Clock::default());
//! for k in 0..10 {
//!     let bus = Micros(1_000_000 + k * 20_000);
//!     clock.receive(Micros(bus.0 - 400_000), &master.message());
//!     master.sent(bus);
//! }
//! assert_eq!(clock.to_bus(Micros(700_000)), Micros(1_100_000));
//! assert_eq!(clock.to_local(Micros(1_100_000)), Micros(700_000));
//! ```

use crate::message::TimeSync;
use crate::time::Micros;

/// Pairs the line is fitted to: 0.64 s at one message every 20 ms.
pub const WINDOW: usize = 32;

/// Pairs needed before others are judged by them.
const ENOUGH: usize = 4;

/// A pair closer than this to the line is never refused, µs. A host without time-stamping hardware
/// jitters by about this much.
const GATE_FLOOR_US: f64 = 50.0;

/// Beyond the floor, this many standard deviations are allowed.
const GATE_SIGMAS: f64 = 5.0;

/// How far the line may be off per µs since the last pair.
const GATE_DRIFT: f64 = 100e-6;

/// So many refused pairs in a row mean that the master's time has changed.
const DISAGREES: u8 = 8;

/// Errors are slewed away in this time, µs, …
const SLEW_SPAN_US: f64 = 100_000.0;

/// … but no faster than this many µs per µs.
const SLEW_MAX: f64 = 500e-6;

/// Quartz clocks are within 100 ppm; a fit beyond this is noise.
const RATE_MAX: f64 = 1000e-6;

/// Without a pair for so long, the line is only extrapolated.
const HOLDOVER: Micros = Micros::from_millis(500);

/// Pairs are at most so old: 67 s.
const MEMORY: u64 = 1 << 26;

/// No bus time is later, µs: 73 000 years.
const LATEST: u64 = 1 << 61;

/// The sending side: numbers the messages and remembers when they left.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Master {
    sequence: u8,
    sent: Option<Micros>,
}

impl Master {
    /// The message to be sent now. If it was never told when the last one left, it skips a number,
    /// so that no receiver makes a pair of it.
    pub fn message(&mut self) -> TimeSync {
        let step = if self.sent.is_some() { 1 } else { 2 };
        self.sequence = self.sequence.wrapping_add(step);
        TimeSync {
            sequence: self.sequence,
            previous_sent_at: self.sent.take().unwrap_or_default(),
        }
    }

    /// The last message left at this bus time (the end of its first frame).
    pub const fn sent(&mut self, at: Micros) {
        self.sent = Some(at);
    }
}

/// How far a [`Clock`] can be trusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quality {
    /// No pair yet: bus time is unknown, and local time is returned in its place.
    Unsynchronised,
    /// Pairs agree.
    Synchronised {
        /// Standard deviation of the pairs from the line, µs.
        residual_us: u32,
    },
    /// No pair for 0.5 s; the line is extrapolated.
    Holdover,
    /// The master's time has changed. Only [`Clock::reset`] follows it, since that is a step.
    Disagrees,
}

#[derive(Clone, Copy, Debug)]
struct Pair {
    local: u64,
    bus: u64,
}

/// Bus time as a line over local time: bus = `bus` + `fraction` + `rate` · (local − `local`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    local: u64,
    bus: u64,
    /// µs, 0 to 1 where the line is a segment of bus time.
    fraction: f64,
    rate: f64,
}

impl Line {
    /// Bus time is local time.
    pub const IDENTITY: Self = Self {
        local: 0,
        bus: 0,
        fraction: 0.0,
        rate: 1.0,
    };

    /// Whole µs and the rest, 0 to 1.
    fn at(&self, local: u64) -> (u64, f64) {
        // The whole span and the small correction are kept apart, so that nothing is rounded.
        let span = difference(local, self.local);
        let correction = self.fraction + (self.rate - 1.0) * span;
        let whole = floor(correction);
        let base = self.bus.wrapping_add(local.wrapping_sub(self.local));
        (base.saturating_add_signed(whole), correction - float(whole))
    }

    /// The first local time whose bus time is not before `bus`.
    #[must_use]
    pub fn to_local(&self, bus: Micros) -> Micros {
        let span = (difference(bus.0, self.bus) - self.fraction) / self.rate;
        let guess = self.local.saturating_add_signed(floor(span));
        let reached = self.at(guess).0 >= bus.0;
        Micros(if reached {
            guess
        } else {
            guess.saturating_add(1)
        })
    }

    /// `bus` minus the line at `local`, µs.
    fn error(&self, local: u64, bus: u64) -> f64 {
        let (whole, rest) = self.at(local);
        difference(bus, whole) - rest
    }
}

#[expect(
    clippy::cast_precision_loss,
    reason = "spans of microseconds far below 2^53"
)]
const fn float(value: i64) -> f64 {
    value as f64
}

/// `later − earlier`, µs.
const fn difference(later: u64, earlier: u64) -> f64 {
    float(later.wrapping_sub(earlier).cast_signed())
}

/// The greatest whole number not above `value`; saturating.
#[expect(clippy::cast_possible_truncation, reason = "saturates, which is meant")]
const fn floor(value: f64) -> i64 {
    let towards_zero = value as i64;
    if float(towards_zero) > value {
        towards_zero.saturating_sub(1)
    } else {
        towards_zero
    }
}

/// Within ±[`MEMORY`].
fn within(us: i64) -> i64 {
    let bound = MEMORY.cast_signed();
    us.clamp(-bound, bound)
}

fn clamp(value: f64, bound: f64) -> f64 {
    if value > bound {
        bound
    } else if value < -bound {
        -bound
    } else {
        value
    }
}

/// The receiving side: bus time as a function of local time.
#[derive(Clone, Debug)]
pub struct Clock {
    last: Option<(u8, u64)>,
    pairs: heapless::Deque<Pair, WINDOW>,
    /// What [`Self::to_bus`] returns.
    segment: Line,
    /// The fit, and the mean square of the pairs' distances from it, µs².
    fit: Line,
    mean_square: f64,
    refused_in_row: u8,
    refused: u32,
}

impl Default for Clock {
    fn default() -> Self {
        Self {
            last: None,
            pairs: heapless::Deque::new(),
            segment: Line::IDENTITY,
            fit: Line::IDENTITY,
            mean_square: 0.0,
            refused_in_row: 0,
            refused: 0,
        }
    }
}

impl Clock {
    /// Takes a message whose first frame arrived at `local`.
    pub fn receive(&mut self, local: Micros, sync: &TimeSync) {
        let previous = self.last.replace((sync.sequence, local.0));
        if let Some((sequence, arrived)) = previous
            && sync.sequence == sequence.wrapping_add(1)
        {
            let pair = Pair {
                local: arrived,
                bus: sync.previous_sent_at.0,
            };
            self.pair(pair, local.0);
        }
    }

    /// Forgets everything: the next pair may step the time. For use at rest only.
    pub fn reset(&mut self) {
        *self = Self::default();
    }

    /// Bus time at a local time. Never decreases with increasing arguments, whatever was received
    /// in between, as long as the arguments are not before the last message.
    #[must_use]
    pub fn to_bus(&self, local: Micros) -> Micros {
        Micros(self.segment.at(local.0).0)
    }

    /// The first local time whose bus time is not before `bus`, as far as is known now.
    #[must_use]
    pub fn to_local(&self, bus: Micros) -> Micros {
        self.segment.to_local(bus)
    }

    /// Bus time over local time, as far as is known now.
    #[must_use]
    pub const fn line(&self) -> Line {
        self.segment
    }

    /// How far [`Self::to_bus`] can be trusted at a local time.
    #[must_use]
    pub fn quality(&self, local: Micros) -> Quality {
        match self.pairs.back() {
            None => Quality::Unsynchronised,
            Some(_) if self.refused_in_row >= DISAGREES => Quality::Disagrees,
            Some(pair) if local.since(Micros(pair.local)) > HOLDOVER => Quality::Holdover,
            Some(_) => {
                let mean_square = u64::try_from(floor(self.mean_square)).unwrap_or(0);
                let residual_us = u32::try_from(mean_square.isqrt()).unwrap_or(u32::MAX);
                Quality::Synchronised { residual_us }
            }
        }
    }

    /// Pairs refused so far.
    #[must_use]
    pub const fn refused(&self) -> u32 {
        self.refused
    }

    /// Bus time per local time, minus 1, by the fit.
    #[must_use]
    pub const fn drift(&self) -> f64 {
        self.fit.rate - 1.0
    }

    fn pair(&mut self, pair: Pair, now: u64) {
        let first = self.pairs.is_empty();
        if pair.bus > LATEST || (!first && !self.plausible(pair)) {
            self.refused = self.refused.saturating_add(1);
            self.refused_in_row = self.refused_in_row.saturating_add(1);
            return;
        }
        self.refused_in_row = 0;
        if self.pairs.is_full() {
            self.pairs.pop_front();
        }
        // in time, so the old ones come first
        for _ in 0..WINDOW {
            let oldest = self.pairs.front();
            if oldest.is_none_or(|old| pair.local.wrapping_sub(old.local) < MEMORY) {
                break;
            }
            self.pairs.pop_front();
        }
        // Never full here.
        let _ = self.pairs.push_back(pair);
        self.refit(pair);
        self.segment = if first { self.fit } else { self.slewed(now) };
    }

    fn plausible(&self, pair: Pair) -> bool {
        let Some(newest) = self.pairs.back() else {
            return true;
        };
        let gap = difference(pair.local, newest.local);
        if gap <= 0.0 {
            return false;
        }
        let allowed = GATE_FLOOR_US + (GATE_DRIFT + SLEW_MAX) * gap;
        if self.pairs.len() < ENOUGH {
            // Too few for a deviation: as far apart as quartz clocks and host jitter can be.
            let error = self.fit.error(pair.local, pair.bus);
            return error * error <= 16.0 * allowed * allowed;
        }
        let allowed = GATE_FLOOR_US + GATE_DRIFT * gap;
        let error = self.fit.error(pair.local, pair.bus);
        error * error <= allowed * allowed
            || error * error <= GATE_SIGMAS * GATE_SIGMAS * self.mean_square
    }

    /// Least squares of y = (bus − local) over x = local, both relative to the newest pair.
    ///
    /// Sums are of integers, so exact: pairs are [`MEMORY`] apart at most, 2²⁶ µs, and there are 2⁵ of them.
    fn refit(&mut self, newest: Pair) {
        let (mut n, mut sum_x, mut sum_y) = (0_i64, 0_i64, 0_i64);
        let (mut sum_xx, mut sum_xy, mut sum_yy) = (0_i64, 0_i64, 0_i64);
        for pair in &self.pairs {
            let x = within(pair.local.wrapping_sub(newest.local).cast_signed());
            let bus = within(pair.bus.wrapping_sub(newest.bus).cast_signed());
            let y = within(bus.wrapping_sub(x));
            n = n.wrapping_add(1);
            sum_x = sum_x.wrapping_add(x);
            sum_y = sum_y.wrapping_add(y);
            sum_xx = sum_xx.wrapping_add(x.wrapping_mul(x));
            sum_xy = sum_xy.wrapping_add(x.wrapping_mul(y));
            sum_yy = sum_yy.wrapping_add(y.wrapping_mul(y));
        }
        // n times the sums of products of distances from the means
        let about =
            |sum: i64, a: i64, b: i64| float(n.wrapping_mul(sum).wrapping_sub(a.wrapping_mul(b)));
        let xx = about(sum_xx, sum_x, sum_x);
        let xy = about(sum_xy, sum_x, sum_y);
        let yy = about(sum_yy, sum_y, sum_y);
        // Two or three pairs say more about jitter than about drift.
        let known = self.pairs.len() >= ENOUGH && xx > 0.0;
        let slope = if known { clamp(xy / xx, RATE_MAX) } else { 0.0 };
        let count = float(n);
        let offset = (float(sum_y) - slope * float(sum_x)) / count;
        let squares = yy + slope * (slope * xx - 2.0 * xy);
        self.mean_square = if squares > 0.0 {
            squares / (count * count)
        } else {
            0.0
        };
        let whole = floor(offset);
        self.fit = Line {
            local: newest.local,
            bus: newest.bus.saturating_add_signed(whole),
            fraction: offset - float(whole),
            rate: 1.0 + slope,
        };
    }

    /// From where bus time is at `now`, towards the fit.
    fn slewed(&self, now: u64) -> Line {
        let (bus, fraction) = self.segment.at(now);
        let (target, rest) = self.fit.at(now);
        let error = difference(target, bus) + rest - fraction;
        let slew = clamp(error / SLEW_SPAN_US, SLEW_MAX);
        Line {
            local: now,
            bus,
            fraction,
            rate: self.fit.rate + slew,
        }
    }
}

#[cfg(test)]
mod tests;
