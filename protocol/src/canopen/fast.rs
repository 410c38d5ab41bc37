//! The fast profile, experimental: the same dictionary and state machine on CAN FD, with fewer and longer frames.
//!
//! | frame | COB-ID | bytes |
//! |---|---|---|
//! | group: all drives of a bus latch it at SYNC | 200 | controlword u16, slots u16, then an i32 for each slot up to the last |
//! | feedback: each drive at SYNC, instead of TPDO1 | 180 + node | statusword u16, position i32, torque i16, velocity i32, following error i32 |
//!
//! Everything else stays classical frames on the same wire. A drive has a slot, 1 to 15 (object 2010; 0: it speaks as
//! always). Bit s − 1 of `slots` says that slot s obeys this frame; bit 15 that the numbers are torques (‰), not positions.
//! While drives need different controlwords, a group is sent for each of them. All are little-endian; the data are filled
//! up with zeros to a length that FD has.

use super::axis::Target;
use crate::frame::{Frame, Id};

/// The group's COB-ID: that of RPDO1 of no node.
pub const GROUP_COB: u16 = 0x200;
/// Drives a group can have: 4 + 15 · 4 = 64 bytes.
pub const SLOTS: usize = 15;
/// Bit of the slots: the numbers are torques.
const TORQUE: u16 = 1 << 15;
/// The lengths an FD frame of a group can have, bytes.
const LENGTHS: [usize; 9] = [8, 12, 16, 20, 24, 32, 48, 64, 64];

/// A drive's place in the group, 1 to [`SLOTS`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slot(u8);

impl Slot {
    /// The slot of a number; `None` if it is 0 or beyond [`SLOTS`].
    #[must_use]
    pub const fn new(number: u8) -> Option<Self> {
        if number == 0 || number as usize > SLOTS {
            None
        } else {
            Some(Self(number))
        }
    }

    /// Its number.
    #[must_use]
    pub const fn get(self) -> u8 {
        self.0
    }

    const fn bit(self) -> u16 {
        1 << (self.0 - 1)
    }
}

/// The set-points of drives that get the same controlword.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Group {
    controlword: u16,
    slots: u16,
    values: [i32; SLOTS],
}

impl Group {
    /// Nobody's yet; `torque`: it will carry torques.
    #[must_use]
    pub const fn new(controlword: u16, torque: bool) -> Self {
        Self {
            controlword,
            slots: if torque { TORQUE } else { 0 },
            values: [0; SLOTS],
        }
    }

    /// The controlword.
    #[must_use]
    pub const fn controlword(&self) -> u16 {
        self.controlword
    }

    /// Takes a drive in; `false` if its target is of the other kind.
    pub fn put(&mut self, slot: Slot, target: Target) -> bool {
        let (torque, value) = match target {
            Target::Position(units) => (false, units),
            Target::Torque(per_mille) => (true, i32::from(per_mille)),
        };
        let place = self.values.get_mut(usize::from(slot.0.saturating_sub(1)));
        let (true, Some(place)) = (torque == (self.slots & TORQUE != 0), place) else {
            return false;
        };
        *place = value;
        self.slots |= slot.bit();
        true
    }

    /// The target of a drive that obeys this group.
    #[must_use]
    pub fn target(&self, slot: Slot) -> Option<Target> {
        if self.slots & slot.bit() == 0 {
            return None;
        }
        let value = *self.values.get(usize::from(slot.0.saturating_sub(1)))?;
        if self.slots & TORQUE == 0 {
            return Some(Target::Position(value));
        }
        i16::try_from(value).ok().map(Target::Torque)
    }

    /// The length of its frame's data, bytes, if it carries slots up to this one.
    #[must_use]
    pub fn length(last: Slot) -> usize {
        let wanted = 4_usize.saturating_add(usize::from(last.0) * 4);
        let fits = LENGTHS.into_iter().find(|length| *length >= wanted);
        fits.unwrap_or(64)
    }

    /// The frame.
    #[must_use]
    pub fn frame(&self) -> Option<Frame> {
        let last = 16_u32.saturating_sub((self.slots & !TORQUE).leading_zeros());
        let last = Slot::new(u8::try_from(last).ok()?)?;
        let mut data = [0; 64];
        let head = self
            .controlword
            .to_le_bytes()
            .into_iter()
            .chain(self.slots.to_le_bytes());
        let values = self.values.into_iter().flat_map(i32::to_le_bytes);
        for (to, from) in data.iter_mut().zip(head.chain(values)) {
            *to = from;
        }
        Frame::fd(Id::Standard(GROUP_COB), data.get(..Self::length(last))?)
    }

    /// Reads the data of a group; `None` if they are shorter than their slots, or have none.
    #[must_use]
    pub fn decode(data: &[u8]) -> Option<Self> {
        let (head, rest) = data.split_first_chunk::<4>()?;
        let [a, b, c, d] = *head;
        let mut group = Self::new(u16::from_le_bytes([a, b]), false);
        group.slots = u16::from_le_bytes([c, d]);
        let wanted = 16_u32.saturating_sub((group.slots & !TORQUE).leading_zeros());
        let wanted = usize::try_from(wanted).ok()?;
        if wanted == 0 || rest.len() < wanted * 4 {
            return None;
        }
        for (value, bytes) in group
            .values
            .iter_mut()
            .take(wanted)
            .zip(rest.as_chunks::<4>().0)
        {
            *value = i32::from_le_bytes(*bytes);
        }
        Some(group)
    }
}

/// What a drive tells at SYNC.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Feedback {
    /// Statusword.
    pub statusword: u16,
    /// Position, drive units.
    pub position: i32,
    /// Torque, per mille of the rated torque.
    pub torque: i16,
    /// Velocity, drive units/s.
    pub velocity: i32,
    /// Following error, drive units.
    pub following_error: i32,
}

impl Feedback {
    /// Bytes of its data.
    pub const LENGTH: usize = 16;

    /// The data.
    #[must_use]
    pub fn encode(self) -> [u8; Self::LENGTH] {
        let [a, b] = self.statusword.to_le_bytes();
        let [c, d, e, f] = self.position.to_le_bytes();
        let [g, h] = self.torque.to_le_bytes();
        let [i, j, k, l] = self.velocity.to_le_bytes();
        let [m, n, o, p] = self.following_error.to_le_bytes();
        [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p]
    }

    /// Reads the data; `None` if they are not 16 bytes.
    #[must_use]
    pub fn decode(data: &[u8]) -> Option<Self> {
        let [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p] = <[u8; 16]>::try_from(data).ok()?;
        Some(Self {
            statusword: u16::from_le_bytes([a, b]),
            position: i32::from_le_bytes([c, d, e, f]),
            torque: i16::from_le_bytes([g, h]),
            velocity: i32::from_le_bytes([i, j, k, l]),
            following_error: i32::from_le_bytes([m, n, o, p]),
        })
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn golden_group_and_feedback() {
        let mut group = Group::new(0x000F, false);
        assert!(group.put(Slot::new(1).unwrap(), Target::Position(-2)));
        assert!(group.put(Slot::new(3).unwrap(), Target::Position(0x0102_0304)));
        assert!(!group.put(Slot::new(2).unwrap(), Target::Torque(5)));
        let frame = group.frame().unwrap();
        assert_eq!(frame.id(), Id::Standard(0x200));
        let expected = [
            0x0F, 0, 5, 0, 0xFE, 0xFF, 0xFF, 0xFF, 0, 0, 0, 0, 4, 3, 2, 1,
        ];
        assert_eq!((frame.is_fd(), frame.data()), (true, &expected[..]));
        let feedback = Feedback {
            statusword: 0x1237,
            position: -1,
            torque: 2,
            velocity: 3,
            following_error: -4,
        };
        let bytes = [
            0x37, 0x12, 255, 255, 255, 255, 2, 0, 3, 0, 0, 0, 252, 255, 255, 255,
        ];
        assert_eq!(feedback.encode(), bytes);
    }

    #[test]
    fn what_is_no_group_is_none() {
        assert_eq!(Group::new(15, true).frame(), None, "nobody's");
        for data in [
            &[][..],
            &[15, 0, 1],
            &[15, 0, 0, 0, 1, 2, 3, 4],
            &[15, 0, 2, 0, 1, 2, 3, 4],
        ] {
            assert_eq!(Group::decode(data), None, "{data:?}");
        }
        // a torque that does not fit
        let group = Group::decode(&[15, 0, 1, 0x80, 0, 0, 1, 0]).unwrap();
        assert_eq!(group.target(Slot::new(1).unwrap()), None);
        assert_eq!((Slot::new(0), Slot::new(16)), (None, None));
        assert_eq!(Feedback::decode(&[0; 8]), None);
    }

    proptest! {
        #[test]
        fn every_group_is_read_as_it_was_written(
            word in any::<u16>(), torque in any::<bool>(),
            entries in proptest::collection::vec((1..=15_u8, any::<i16>()), 1..20),
        ) {
            let mut group = Group::new(word, torque);
            for (slot, value) in entries {
                let target = if torque { Target::Torque(value) } else { Target::Position(i32::from(value) << 9) };
                prop_assert!(group.put(Slot::new(slot).unwrap(), target));
            }
            let frame = group.frame().unwrap();
            prop_assert_eq!(Group::decode(frame.data()), Some(group));
            prop_assert!(frame.data().len() <= 64);
        }

        #[test]
        fn every_feedback_is_read_as_it_was_written(data in any::<[u8; 16]>()) {
            prop_assert_eq!(Feedback::decode(&data).unwrap().encode(), data);
        }

        #[test]
        fn no_bytes_break_it(data in proptest::collection::vec(any::<u8>(), 0..64), slot in 1..=15_u8) {
            let _ = Group::decode(&data).and_then(|group| group.target(Slot::new(slot).unwrap()));
        }
    }
}
