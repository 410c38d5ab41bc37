//! The black box: the signals before the first fault, in memory that survives a reset.
//!
//! Memory for six axes, bytes: a sample is 8 + 6 · 8 = 56; [`FINE`] + [`COARSE`] = 145 of them and the header of 64 are 8184.
//! At a servo step of 1 ms that is every step of the last 50 ms and every tenth of the 950 ms before; at 2 ms twice as long.
//!
//! ```text
//!  0         64                          64 + 50·s                      64 + 145·s
//!  │ header  │ ring of the last 50 steps │ ring of every tenth before   │
//! ```
//! | byte of the header | |
//! |---|---|
//! | 0 | `MRBX`; erased while recording |
//! | 4 | format, 1; axes; samples in the fine and in the coarse ring |
//! | 8 | where the next sample would go, fine and coarse; zeros |
//! | 12 | fault: cause u16, axis (255 = none), state; 16: step u32 |
//! | 20 | instruction u32, boot u32, servo step in µs u32 |
//! | 32 | zeros |
//! | 56 | CRC-32 of all that is not these last 8 bytes |
//! | 60 | later faults u16, and its complement |
//!
//! Whatever is in the memory at the start, it is a whole record or none: any bytes are allowed.

use crate::update::image::CRC;
use protocol::fault::{Cause, Fault};
use protocol::maintenance::{AxisSample, FaultRecord, SAMPLE_BATCH, Sample};
use protocol::message::NodeState;
use protocol::units::{MAX_AXES, PerAxis};

/// Steps of which every one is kept.
pub const FINE: usize = 50;
/// Samples kept of the time before, one of [`EVERY`] steps.
pub const COARSE: usize = 95;
/// How many steps of the time before make one sample.
pub const EVERY: u32 = 10;

const HEADER: usize = 64;
const MAGIC: [u8; 4] = *b"MRBX";
const FORMAT: u8 = 1;
const STEP: usize = 8;
const AXIS: usize = 8;
const CRC_AT: usize = 56;
const LATER_AT: usize = 60;

/// The memory a black box of so many axes needs, bytes.
#[must_use]
pub const fn bytes(axes: usize) -> usize {
    HEADER.saturating_add((FINE + COARSE).saturating_mul(sample_bytes(axes)))
}

/// Bytes of a sample.
const fn sample_bytes(axes: usize) -> usize {
    STEP.saturating_add(AXIS.saturating_mul(axes))
}

const _: () = assert!(bytes(6) == 8184 && bytes(MAX_AXES) == 10504);

/// Memory of a black box: not cleared at a reset.
pub trait Memory {
    /// The memory.
    fn bytes(&self) -> &[u8];
    /// The memory, to write.
    fn bytes_mut(&mut self) -> &mut [u8];
    /// A record is complete, or is no more: a memory that is kept elsewhere is kept now.
    fn keep(&mut self) {}
}

impl Memory for &mut [u8] {
    fn bytes(&self) -> &[u8] {
        self
    }
    fn bytes_mut(&mut self) -> &mut [u8] {
        self
    }
}

/// The signals of a node in one servo step.
#[derive(Clone, Debug, PartialEq)]
pub struct Signals {
    /// The servo step.
    pub step: u32,
    /// The state of the node.
    pub state: NodeState,
    /// The first latched fault.
    pub fault: Option<Fault>,
    /// Id of the latest instruction.
    pub instruction: u32,
    /// One per axis.
    pub axes: PerAxis<AxisSample>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Recording,
    /// The first fault came: nothing is written any more; the CRC is not computed yet.
    Frozen,
    /// A record, complete; of this boot or of one before.
    Sealed {
        acknowledged: bool,
    },
}

/// Records until the first fault, and keeps that.
#[derive(Debug)]
pub struct BlackBox<M> {
    memory: M,
    axes: usize,
    state: State,
    rings: [Ring; 2],
    last_step: Option<u32>,
    last_fault: Option<Fault>,
}

/// A ring of samples: how many there are, where the next goes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Ring {
    count: usize,
    next: usize,
}

impl Ring {
    /// The place of the next sample; was it taken by the oldest one?
    const fn push(&mut self, capacity: usize) -> usize {
        let at = self.next;
        self.next = match at.saturating_add(1) {
            next if next < capacity => next,
            _ => 0,
        };
        if self.count < capacity {
            self.count = self.count.saturating_add(1);
        }
        at
    }

    /// The place of the k-th sample, the oldest is 0.
    const fn place(self, k: usize, capacity: usize) -> usize {
        let first = if self.count < capacity { 0 } else { self.next };
        match first.saturating_add(k).checked_rem(capacity) {
            Some(place) => place,
            None => 0,
        }
    }
}

const CAPACITY: [usize; 2] = [FINE, COARSE];

impl<M: Memory> BlackBox<M> {
    /// A black box in this memory, for a robot of so many axes: with the record that is in it, or empty. `None` if the
    /// memory is shorter than [`bytes`].
    #[must_use]
    pub fn open(memory: M, axes: usize) -> Option<Self> {
        if memory.bytes().len() < bytes(axes) || axes > MAX_AXES {
            return None;
        }
        let mut black_box = Self {
            memory,
            axes,
            state: State::Recording,
            rings: [Ring::default(); 2],
            last_step: None,
            last_fault: None,
        };
        if let Some(rings) = black_box.sealed() {
            black_box.rings = rings;
            black_box.state = State::Sealed {
                acknowledged: false,
            };
        }
        Some(black_box)
    }

    /// The memory, to look at.
    pub const fn memory(&self) -> &M {
        &self.memory
    }

    /// The rings of a whole record in the memory.
    fn sealed(&self) -> Option<[Ring; 2]> {
        let [format, axes, fine, coarse, next_fine, next_coarse] = self.get(4)?;
        let rings = [(fine, next_fine), (coarse, next_coarse)].map(|(count, next)| Ring {
            count: usize::from(count),
            next: usize::from(next),
        });
        let sound = self.get::<4>(0)? == MAGIC
            && format == FORMAT
            && usize::from(axes) == self.axes
            && (rings.iter().zip(CAPACITY))
                .all(|(ring, room)| ring.count <= room && ring.next < room);
        let whole = sound && u32::from_le_bytes(self.get(CRC_AT)?) == self.crc();
        (whole && self.fault().is_some()).then_some(rings)
    }

    fn crc(&self) -> u32 {
        let mut digest = CRC.digest();
        let memory = self.memory.bytes();
        digest.update(memory.get(..CRC_AT).unwrap_or(&[]));
        digest.update(memory.get(HEADER..bytes(self.axes)).unwrap_or(&[]));
        digest.finalize()
    }

    fn get<const N: usize>(&self, at: usize) -> Option<[u8; N]> {
        let rest = self.memory.bytes().get(at..)?;
        rest.first_chunk::<N>().copied()
    }

    fn put(&mut self, at: usize, what: &[u8]) {
        let places = self.memory.bytes_mut().iter_mut().skip(at);
        for (place, byte) in places.zip(what) {
            *place = *byte;
        }
    }

    const fn at(&self, ring: usize, place: usize) -> usize {
        let before = if ring == 0 { 0 } else { FINE };
        let samples = place.saturating_add(before);
        HEADER.saturating_add(samples.saturating_mul(sample_bytes(self.axes)))
    }

    /// The signals of one servo step. Bounded and short: for the step itself.
    pub fn record(&mut self, signals: &Signals, boot: u32, servo_step_us: u32) {
        if self.last_step == Some(signals.step) {
            return;
        }
        self.last_step = Some(signals.step);
        let before = core::mem::replace(&mut self.last_fault, signals.fault);
        let new = signals.fault.filter(|_| before.is_none());
        match self.state {
            State::Recording => {
                self.push(signals);
                if let Some(fault) = new {
                    self.freeze(fault, signals.instruction, boot, servo_step_us);
                }
            }
            State::Frozen
            | State::Sealed {
                acknowledged: false,
            } => {
                if new.is_some() {
                    let later = self.later().saturating_add(1);
                    self.put_later(later);
                }
                let acknowledged = before.is_some() && signals.fault.is_none();
                if acknowledged && self.state != State::Frozen && self.last_is_ours(before) {
                    self.state = State::Sealed { acknowledged };
                }
            }
            State::Sealed { acknowledged: true } => {
                // it can be read until the robot moves again
                if matches!(signals.state, NodeState::Moving | NodeState::Synchronising)
                    || new.is_some()
                {
                    self.forget();
                    self.push(signals);
                    if let Some(fault) = new {
                        self.freeze(fault, signals.instruction, boot, servo_step_us);
                    }
                }
            }
        }
    }

    /// Is the fault that was acknowledged the one of the record? A record of a boot before stays until it is cleared.
    fn last_is_ours(&self, acknowledged: Option<Fault>) -> bool {
        acknowledged.is_some() && acknowledged == self.fault()
    }

    fn push(&mut self, signals: &Signals) {
        let [fine, _] = self.rings;
        if fine.count == FINE {
            // the oldest of the fine ring makes room: every tenth goes on into the coarse one
            let oldest = self.at(0, fine.next);
            let step = u32::from_le_bytes(self.get(oldest).unwrap_or_default());
            if step.is_multiple_of(EVERY) {
                let [_, coarse] = &mut self.rings;
                let place = coarse.push(COARSE);
                let to = self.at(1, place);
                for k in 0..sample_bytes(self.axes) {
                    let byte: [u8; 1] = self.get(oldest.saturating_add(k)).unwrap_or_default();
                    self.put(to.saturating_add(k), &byte);
                }
            }
        }
        let [fine, _] = &mut self.rings;
        let place = fine.push(FINE);
        let at = self.at(0, place);
        let code = signals.fault.map_or(0, |fault| fault.cause.code());
        self.put(at, &signals.step.to_le_bytes());
        self.put(at.saturating_add(4), &code.to_le_bytes());
        let state = [state_number(signals.state), 0];
        self.put(at.saturating_add(6), &state);
        for k in 0..self.axes {
            let axis = signals.axes.get(k).copied().unwrap_or_default();
            let at = at.saturating_add(sample_bytes(k));
            self.put(at, &axis.actual.to_le_bytes());
            self.put(at.saturating_add(4), &axis.error.to_le_bytes());
            self.put(at.saturating_add(6), &axis.current_ma.to_le_bytes());
        }
    }

    fn freeze(&mut self, fault: Fault, instruction: u32, boot: u32, servo_step_us: u32) {
        let byte = |number: usize| u8::try_from(number).unwrap_or(u8::MAX);
        let [fine, coarse] = self.rings;
        let axes = byte(self.axes);
        self.put(0, &[0; HEADER]);
        self.put(4, &[FORMAT, axes, byte(fine.count), byte(coarse.count)]);
        self.put(8, &[byte(fine.next), byte(coarse.next)]);
        self.put(12, &fault.cause.code().to_le_bytes());
        let axis = fault.axis.unwrap_or(NO_AXIS);
        self.put(14, &[axis, state_number(fault.during)]);
        self.put(16, &fault.step.to_le_bytes());
        self.put(20, &instruction.to_le_bytes());
        self.put(24, &boot.to_le_bytes());
        self.put(28, &servo_step_us.to_le_bytes());
        self.put_later(0);
        self.state = State::Frozen;
    }

    /// Completes a frozen record with its CRC, over all of the memory: not for the servo step. Did it?
    pub fn seal(&mut self) -> bool {
        if self.state != State::Frozen {
            return false;
        }
        self.put(0, &MAGIC);
        let crc = self.crc();
        self.put(CRC_AT, &crc.to_le_bytes());
        self.state = State::Sealed {
            acknowledged: false,
        };
        self.memory.keep();
        true
    }

    /// Forget the record; recording goes on. `false` if there is none of this number.
    pub fn clear(&mut self, record: u32) -> bool {
        let known = self
            .first_fault()
            .is_some_and(|found| found.record == record);
        if known {
            self.forget();
        }
        known
    }

    fn forget(&mut self) {
        self.put(0, &[0; HEADER]);
        self.rings = [Ring::default(); 2];
        self.state = State::Recording;
        self.memory.keep();
    }

    fn fault(&self) -> Option<Fault> {
        let [low, high, axis, during] = self.get(12)?;
        Some(Fault {
            cause: Cause::from_code(u16::from_le_bytes([low, high]))?,
            axis: (axis != NO_AXIS).then_some(axis),
            step: u32::from_le_bytes(self.get(16)?),
            during: state_of(during)?,
        })
    }

    /// Not under the CRC, since it counts on: with a complement of its own.
    fn later(&self) -> u16 {
        let [a, b, c, d] = self.get(LATER_AT).unwrap_or_default();
        let (later, check) = (u16::from_le_bytes([a, b]), u16::from_le_bytes([c, d]));
        if later == !check { later } else { 0 }
    }

    fn put_later(&mut self, later: u16) {
        self.put(LATER_AT, &later.to_le_bytes());
        self.put(LATER_AT + 2, &(!later).to_le_bytes());
    }

    /// The record, if there is a complete one.
    pub fn first_fault(&self) -> Option<FaultRecord> {
        let State::Sealed { .. } = self.state else {
            return None;
        };
        let [fine, coarse] = self.rings;
        let number = |at| self.get(at).map(u32::from_le_bytes);
        Some(FaultRecord {
            record: number(CRC_AT)?,
            fault: self.fault()?,
            instruction: number(20)?,
            boot: number(24)?,
            later: self.later(),
            samples: u16::try_from(fine.count.saturating_add(coarse.count)).ok()?,
            servo_step_us: number(28)?,
        })
    }

    /// Samples of a record from a number on, the oldest is 0; empty beyond the last. `None` if there is no such record.
    pub fn samples(&self, record: u32, first: u16) -> Option<heapless::Vec<Sample, SAMPLE_BATCH>> {
        self.first_fault().filter(|found| found.record == record)?;
        let numbers = (0..SAMPLE_BATCH).map(|k| usize::from(first).saturating_add(k));
        let mut samples = heapless::Vec::new();
        for sample in numbers.map_while(|k| self.sample(k)) {
            // no more than a batch
            let _ = samples.push(sample);
        }
        Some(samples)
    }

    fn sample(&self, k: usize) -> Option<Sample> {
        let [fine, coarse] = self.rings;
        let at = if k < coarse.count {
            self.at(1, coarse.place(k, COARSE))
        } else {
            let k = k.saturating_sub(coarse.count);
            if k >= fine.count {
                return None;
            }
            self.at(0, fine.place(k, FINE))
        };
        let [low, high, state] = self.get(at.saturating_add(4))?;
        let mut axes = PerAxis::new();
        for axis in 0..self.axes {
            let at = at.saturating_add(sample_bytes(axis));
            // no more than MAX_AXES: checked by `open`
            let _ = axes.push(AxisSample {
                actual: i32::from_le_bytes(self.get(at)?),
                error: i16::from_le_bytes(self.get(at.saturating_add(4))?),
                current_ma: i16::from_le_bytes(self.get(at.saturating_add(6))?),
            });
        }
        Some(Sample {
            step: u32::from_le_bytes(self.get(at)?),
            state: state_of(state)?,
            fault: u16::from_le_bytes([low, high]),
            axes,
        })
    }
}

/// In the place of an axis: no axis is at fault.
const NO_AXIS: u8 = 255;

const fn state_number(state: NodeState) -> u8 {
    state as u8
}

fn state_of(number: u8) -> Option<NodeState> {
    NodeState::ALL.get(usize::from(number)).copied()
}

#[cfg(test)]
mod test;
