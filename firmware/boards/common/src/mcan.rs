//! Bosch's CAN controller `M_CAN` as ST builds it into the STM32 G0, G4, H5, L5 and U5 as FDCAN: a message memory that
//! nobody can divide otherwise, two receive queues of 3 frames, 3 transmit buffers (RM0440, chapter 44).
//!
//! A board gives it two windows of words ([`Words`]); what is in them is known here and nowhere else.
//!
//! | first word | elements | of words |
//! |---|---|---|
//! | 0 | 28 filters of 11 bits | 1 |
//! | 28 | 8 filters of 29 bits | 2 |
//! | 44 | receive queue 0: 3 | 18 |
//! | 98 | receive queue 1: 3 | 18 |
//! | 152 | what was sent: 3 | 2 |
//! | 158 | transmit buffers: 3 | 18 |

pub mod element;

use crate::bit_timing::{BitTiming, Segments};
use crate::outbox::Outbox;
use protocol::frame::{Frame, Id};

/// A window of 32-bit words: registers, or message memory.
pub trait Words {
    /// The word of this number.
    fn read(&self, word: usize) -> u32;
    /// Replace it.
    fn write(&mut self, word: usize, value: u32);
}

/// Words of the message memory of one controller.
pub const MEMORY: usize = 212;
/// Its transmit buffers, and the frames of a receive queue.
pub const BUFFERS: usize = 3;

const RECEIVED: [usize; 2] = [44, 98];
const SENT: usize = 152;
const TO_SEND: usize = 158;

/// Registers, as numbers of words.
mod register {
    pub(super) const DBTP: usize = 0x0C / 4;
    pub(super) const CCCR: usize = 0x18 / 4;
    pub(super) const NBTP: usize = 0x1C / 4;
    pub(super) const TSCC: usize = 0x20 / 4;
    pub(super) const PSR: usize = 0x44 / 4;
    pub(super) const TDCR: usize = 0x48 / 4;
    pub(super) const IR: usize = 0x50 / 4;
    pub(super) const IE: usize = 0x54 / 4;
    pub(super) const ILE: usize = 0x5C / 4;
    pub(super) const RXGFC: usize = 0x80 / 4;
    /// Status and acknowledgement of both receive queues.
    pub(super) const RXFS: [usize; 2] = [0x90 / 4, 0x98 / 4];
    pub(super) const RXFA: [usize; 2] = [0x94 / 4, 0x9C / 4];
    pub(super) const TXBC: usize = 0xC0 / 4;
    pub(super) const TXBRP: usize = 0xC8 / 4;
    pub(super) const TXBAR: usize = 0xCC / 4;
    pub(super) const TXBCR: usize = 0xD0 / 4;
    pub(super) const TXBTIE: usize = 0xDC / 4;
    pub(super) const TXEFS: usize = 0xE4 / 4;
    pub(super) const TXEFA: usize = 0xE8 / 4;
}
use register::{
    CCCR, DBTP, IE, ILE, IR, NBTP, PSR, RXFA, RXFS, RXGFC, TDCR, TSCC, TXBAR, TXBC, TXBCR, TXBRP,
    TXBTIE, TXEFA, TXEFS,
};

/// CCCR: initialisation, and the right to change the configuration.
const INIT: u32 = 1;
const CHANGE: u32 = 1 << 1;
const FD_ON: u32 = 1 << 8;
const SWITCH_ON: u32 = 1 << 9;
/// DBTP: the transmitter's delay is compensated.
const COMPENSATED: u32 = 1 << 23;
/// TSCC: the stamp is an external counter of 16 bits (on STM32 that of TIM3).
const EXTERNAL_STAMP: u32 = 2;
/// TXBC: the lowest identifier goes first, not the oldest frame.
const BY_IDENTIFIER: u32 = 1 << 24;
/// PSR: bus-off.
const BUS_OFF: u32 = 1 << 7;
/// IR and IE: a frame in a receive queue, one lost, one sent, bus-off.
const NEW: u32 = 1 | 1 << 3;
const LOST: [u32; 2] = [1 << 2, 1 << 5];
const TRANSMITTED: u32 = 1 << 7;
const TOLD: u32 = 1 << 10;
const BUS_OFF_CHANGED: u32 = 1 << 19;
/// A filter of 11 bits: a frame of which all bits in the mask are those of the filter goes to queue 1.
const ODD_TO_QUEUE_1: u32 = 2 << 30 | 2 << 27 | 1 << 16 | 1;
/// RXGFC: remote frames are dropped, one filter of 11 bits, whatever it does not match goes to queue 0.
const FILTERS: u32 = 0b11 | 1 << 16;
/// RXFS and TXEFS: how many elements wait.
const FILLED: u32 = 0xF;
const FILLED_SENT: u32 = 7;
/// So often a controller is asked whether it has begun to initialise itself: a few cycles of its clock.
const PATIENCE: u32 = 10_000;

/// It does not answer: no clock, or nothing at these addresses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Silent;

impl core::fmt::Display for Silent {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("the CAN controller does not answer: has it a clock?")
    }
}

impl core::error::Error for Silent {}

/// A frame that was sent and of which that is to be told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sent {
    /// Its identifier.
    pub id: Id,
    /// When it began, by the counter of 16 bits.
    pub stamp: u16,
}

/// What was counted, saturating.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Frames that found a receive queue full: at least so many.
    pub overrun: u32,
    /// How often the controller left the bus.
    pub bus_off: u32,
}

/// One controller.
#[derive(Debug)]
pub struct MCan<W> {
    registers: W,
    memory: W,
    /// The identifiers in the transmit buffers; what of it is still there the controller says.
    held: [u64; BUFFERS],
    /// Of which the time is told: SYNC.
    told: Option<Id>,
    counts: Counts,
}

const fn bit_time(segments: Segments) -> [u32; 4] {
    // the registers count from 0
    [
        segments.prescaler.saturating_sub(1) as u32,
        segments.before.saturating_sub(1) as u32,
        segments.after.saturating_sub(1) as u32,
        segments.jump.saturating_sub(1) as u32,
    ]
}

impl<W: Words> MCan<W> {
    /// A controller that joins its bus; `told`: the identifier of which it is told when it was sent.
    ///
    /// # Errors
    /// [`Silent`]
    pub fn start(
        registers: W,
        memory: W,
        timing: &BitTiming,
        told: Option<Id>,
    ) -> Result<Self, Silent> {
        let mut own = Self {
            registers,
            memory,
            held: [0; BUFFERS],
            told,
            counts: Counts::default(),
        };
        own.registers.write(CCCR, INIT);
        let answered = (0..PATIENCE).any(|_| own.registers.read(CCCR) & INIT != 0);
        if !answered {
            return Err(Silent);
        }
        let fd = if timing.data.is_some() {
            FD_ON | SWITCH_ON
        } else {
            0
        };
        own.registers.write(CCCR, INIT | CHANGE | fd);
        for word in 0..MEMORY {
            own.memory.write(word, 0);
        }
        own.set_bit_times(timing);
        own.registers.write(TSCC, EXTERNAL_STAMP);
        own.memory.write(0, ODD_TO_QUEUE_1);
        own.registers.write(RXGFC, FILTERS);
        own.registers.write(TXBC, BY_IDENTIFIER);
        own.registers.write(TXBTIE, (1 << BUFFERS) - 1);
        let [lost0, lost1] = LOST;
        own.registers.write(
            IE,
            NEW | lost0 | lost1 | TRANSMITTED | TOLD | BUS_OFF_CHANGED,
        );
        own.registers.write(ILE, 1);
        // this also gives the right to change back
        own.registers.write(CCCR, fd);
        Ok(own)
    }

    fn set_bit_times(&mut self, timing: &BitTiming) {
        let [prescaler, before, after, jump] = bit_time(timing.nominal);
        self.registers
            .write(NBTP, jump << 25 | prescaler << 16 | before << 8 | after);
        if let Some(data) = &timing.data {
            let [prescaler, before, after, jump] = bit_time(data.segments);
            let compensated = data.delay_offset.map_or(0, |_| COMPENSATED);
            self.registers.write(
                DBTP,
                compensated | prescaler << 16 | before << 8 | after << 4 | jump,
            );
            let offset = data.delay_offset.map_or(0, u32::from);
            self.registers.write(TDCR, offset << 8);
        }
    }

    /// What the interrupt says, and says no more.
    pub fn acknowledge(&mut self) {
        let flags = self.registers.read(IR);
        self.registers.write(IR, flags);
        for lost in LOST {
            let one = u32::from(flags & lost != 0);
            self.counts.overrun = self.counts.overrun.saturating_add(one);
        }
        if flags & BUS_OFF_CHANGED != 0 && self.is_bus_off() {
            self.counts.bus_off = self.counts.bus_off.saturating_add(1);
        }
    }

    /// A received frame and the count at its start; the queues in turn, so at most [`BUFFERS`] of each at a time.
    pub fn receive(&mut self) -> Option<(Frame, u16)> {
        for ((status, acknowledge), first) in RXFS.into_iter().zip(RXFA).zip(RECEIVED) {
            // a remote frame is dropped, and the next is taken
            for _ in 0..BUFFERS {
                let status = self.registers.read(status);
                if status & FILLED == 0 {
                    break;
                }
                let at = status >> 8 & 3;
                let words = self.element(first, at);
                self.registers.write(acknowledge, at);
                if let Some(received) = element::read(&words) {
                    return Some(received);
                }
            }
        }
        None
    }

    fn element(&self, first: usize, at: u32) -> [u32; element::WORDS] {
        let from = offset(first, at, element::WORDS);
        let mut words = [0; element::WORDS];
        let second = self.memory.read(from.saturating_add(1));
        for (k, word) in words.iter_mut().enumerate().take(element::used(second)) {
            *word = self.memory.read(from.saturating_add(k));
        }
        words
    }

    /// Fill the transmit buffers.
    pub fn transmit<const N: usize>(&mut self, outbox: &mut Outbox<N>) {
        for at in 0..BUFFERS {
            let pending = self.registers.read(TXBRP);
            if pending & (1 << at) != 0 {
                continue;
            }
            let mut held = heapless::Vec::<u64, BUFFERS>::new();
            for (k, id) in self.held.iter().enumerate() {
                if pending & (1 << k) != 0 {
                    // as many as there are buffers
                    let _ = held.push(*id);
                }
            }
            let Some(frame) = outbox.take(&held) else {
                return;
            };
            if let Some(place) = self.held.get_mut(at) {
                *place = frame.id().arbitration();
            }
            let (words, used) = element::write(&frame, self.told == Some(frame.id()));
            let first = TO_SEND.saturating_add(at.saturating_mul(element::WORDS));
            for (k, word) in words.iter().enumerate().take(used) {
                self.memory.write(first.saturating_add(k), *word);
            }
            self.registers.write(TXBAR, 1 << at);
        }
    }

    /// What was sent of which that is told.
    pub fn sent(&mut self) -> Option<Sent> {
        let status = self.registers.read(TXEFS);
        if status & FILLED_SENT == 0 {
            return None;
        }
        let at = status >> 8 & 3;
        let from = offset(SENT, at, 2);
        let (first, second) = (
            self.memory.read(from),
            self.memory.read(from.saturating_add(1)),
        );
        self.registers.write(TXEFA, at);
        #[expect(
            clippy::cast_possible_truncation,
            reason = "the lowest 16 bits are the stamp"
        )]
        Some(Sent {
            id: element::id(first),
            stamp: second as u16,
        })
    }

    /// Has it left the bus?
    #[must_use]
    pub fn is_bus_off(&self) -> bool {
        self.registers.read(PSR) & BUS_OFF != 0
    }

    /// Join the bus again, with nothing to send: it waits for 128 times 11 recessive bits by itself. What is told
    /// to the drives after that is for the node to decide; it has stopped meanwhile.
    pub fn rejoin(&mut self) {
        self.registers.write(TXBCR, (1 << BUFFERS) - 1);
        let control = self.registers.read(CCCR);
        self.registers.write(CCCR, control & !INIT);
    }

    /// What was counted.
    #[must_use]
    pub const fn counts(&self) -> Counts {
        self.counts
    }
}

/// The first word of element `at`.
fn offset(first: usize, at: u32, words: usize) -> usize {
    let at = usize::try_from(at).unwrap_or(0);
    first.saturating_add(at.saturating_mul(words))
}

#[cfg(test)]
pub(crate) mod test;
