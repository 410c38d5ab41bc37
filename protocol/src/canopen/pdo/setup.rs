//! The writes that configure one PDO, in the order CiA 301 demands.

use super::super::sdo::Address;
use super::{Communication, Entry, MAX_ENTRIES};

/// Seen from the drive: does it receive or transmit the PDO?
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// RPDO: objects 1400 and 1600.
    Receive,
    /// TPDO: objects 1800 and 1A00.
    Transmit,
}

/// A little-endian value of 1, 2 or 4 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Value {
    bytes: [u8; 4],
    len: u8,
}

impl Value {
    /// One byte.
    #[must_use]
    pub const fn byte(value: u8) -> Self {
        Self {
            bytes: [value, 0, 0, 0],
            len: 1,
        }
    }

    /// Two bytes.
    #[must_use]
    pub const fn half(value: u16) -> Self {
        let [a, b] = value.to_le_bytes();
        Self {
            bytes: [a, b, 0, 0],
            len: 2,
        }
    }

    /// Four bytes.
    #[must_use]
    pub const fn word(value: u32) -> Self {
        Self {
            bytes: value.to_le_bytes(),
            len: 4,
        }
    }

    /// The bytes, little-endian.
    #[must_use]
    pub fn data(&self) -> &[u8] {
        self.bytes.get(..usize::from(self.len)).unwrap_or_default()
    }
}

/// One write over SDO.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SetupWrite {
    /// Where.
    pub at: Address,
    /// What.
    pub value: Value,
}

/// The writes that configure one PDO: disable, count 0, entries, count, timing, enable.
#[derive(Clone, Debug)]
pub struct Setup<'a> {
    direction: Direction,
    number: u8,
    communication: Communication,
    entries: &'a [Entry],
    step: usize,
}

impl<'a> Setup<'a> {
    /// The writes for PDO `number` (1 to 4). At most [`MAX_ENTRIES`] entries count.
    #[must_use]
    pub fn new(
        direction: Direction,
        number: u8,
        communication: Communication,
        entries: &'a [Entry],
    ) -> Self {
        let entries = entries.get(..MAX_ENTRIES).unwrap_or(entries);
        Self {
            direction,
            number,
            communication,
            entries,
            step: 0,
        }
    }

    fn communication(&self, sub: u8, value: Value) -> SetupWrite {
        let base = match self.direction {
            Direction::Receive => 0x1400_u16,
            Direction::Transmit => 0x1800,
        };
        SetupWrite {
            at: Address::new(base.saturating_add(self.offset()), sub),
            value,
        }
    }

    fn mapping(&self, sub: usize, value: Value) -> SetupWrite {
        let base = match self.direction {
            Direction::Receive => 0x1600_u16,
            Direction::Transmit => 0x1A00,
        };
        let sub = u8::try_from(sub).unwrap_or(u8::MAX);
        SetupWrite {
            at: Address::new(base.saturating_add(self.offset()), sub),
            value,
        }
    }

    fn offset(&self) -> u16 {
        u16::from(self.number.saturating_sub(1))
    }
}

impl Iterator for Setup<'_> {
    type Item = SetupWrite;

    fn next(&mut self) -> Option<SetupWrite> {
        let step = self.step;
        self.step = step.saturating_add(1);
        let wanted = self.communication;
        let off = Communication {
            enabled: false,
            ..wanted
        };
        match step {
            0 => return Some(self.communication(1, Value::word(off.cob_entry()))),
            1 => return Some(self.mapping(0, Value::byte(0))),
            _ => {}
        }
        let step = step.saturating_sub(2);
        if let Some(entry) = self.entries.get(step) {
            return Some(self.mapping(step.saturating_add(1), Value::word(entry.0)));
        }
        let count = u8::try_from(self.entries.len()).unwrap_or(8);
        let transmit = self.direction == Direction::Transmit;
        match (step.saturating_sub(self.entries.len()), transmit) {
            (0, _) => Some(self.mapping(0, Value::byte(count))),
            (1, _) => Some(self.communication(2, Value::byte(wanted.transmission.code()))),
            (2, true) => Some(self.communication(3, Value::half(wanted.inhibit_100us))),
            (3, true) | (2, false) => Some(self.communication(5, Value::half(wanted.event_ms))),
            (4, true) | (3, false) => Some(self.communication(1, Value::word(wanted.cob_entry()))),
            (_, _) => None,
        }
    }
}
