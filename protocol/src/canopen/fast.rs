//! The fast profile, experimental: the same dictionary and state machine on CAN FD, with fewer and longer frames.
//!
//! | frame | COB-ID | bytes |
//! |---|---|---|
//! | group: all drives of a node and bus latch it at SYNC | SYNC's + 180 | controlword u16, slots u16, then for each slot up to the last an i32 |
//! | group with offsets, the same | SYNC's + 280 | the same, and behind each i32 an i16: the torque offset, ‰ |
//! | feedback: each drive at SYNC, instead of TPDO1 | 180 + node | statusword u16, position i32, torque i16, velocity i32, following error i32 |
//!
//! Everything else stays classical frames on the same wire. A drive has a slot, 1 to 15, or to 10 with an offset (object
//! 2010; 0: it speaks as always). Bit s − 1 of `slots` says that slot s obeys this frame; bit 15 that the numbers are torques
//! (‰), not positions. While drives need different controlwords, a group is sent for each of them. All are little-endian;
//! the data are filled up with zeros to a length that FD has.
//!
//! With the usual SYNC, 080, the groups have 200 and 300; a second node on the wire has another SYNC, and so groups of its
//! own. These identifiers are RPDO1 and RPDO2 of no drive: SYNC would be the emergency message of the same.

use super::axis::Target;
use super::sync::DEFAULT_COB;
use crate::frame::{Frame, Id};

/// Drives a group can have: 4 + 15 · 4 = 64 bytes.
pub const SLOTS: usize = 15;
/// The same with offsets: 4 + 10 · 6 = 64 bytes.
pub const SLOTS_WITH_OFFSETS: usize = 10;
/// Bit of the slots: the numbers are torques.
const TORQUE: u16 = 1 << 15;
/// The lengths an FD frame of a group can have, bytes.
const LENGTHS: [usize; 8] = [8, 12, 16, 20, 24, 32, 48, 64];

/// What a group has for a slot; its identifier says it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// A target.
    Targets,
    /// A target and a torque offset.
    Offsets,
}

impl Layout {
    /// The identifier of a group on a wire whose drives obey this SYNC.
    #[must_use]
    pub const fn cob(self, sync_cob: u16) -> u16 {
        let base = match self {
            Self::Targets => 0x200,
            Self::Offsets => 0x300,
        };
        sync_cob.wrapping_sub(DEFAULT_COB).wrapping_add(base) & 0x7FF
    }

    /// Slots a group can have.
    #[must_use]
    pub const fn slots(self) -> usize {
        match self {
            Self::Targets => SLOTS,
            Self::Offsets => SLOTS_WITH_OFFSETS,
        }
    }

    /// Bytes of a slot.
    const fn width(self) -> usize {
        match self {
            Self::Targets => 4,
            Self::Offsets => 6,
        }
    }

    /// The length of a frame's data, bytes, if it carries slots up to this one.
    #[must_use]
    pub fn length(self, last: Slot) -> usize {
        let wanted = 4_usize.saturating_add(usize::from(last.0).saturating_mul(self.width()));
        let fits = LENGTHS.into_iter().find(|length| *length >= wanted);
        fits.unwrap_or(64)
    }
}

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
    layout: Layout,
    values: [(i32, i16); SLOTS],
}

impl Group {
    /// Nobody's yet; it will carry targets like this one, and offsets if there is one.
    #[must_use]
    pub const fn new(controlword: u16, target: Target, offset: Option<i16>) -> Self {
        let layout = match offset {
            None => Layout::Targets,
            Some(_) => Layout::Offsets,
        };
        let slots = match target {
            Target::Position(_) => 0,
            Target::Torque(_) => TORQUE,
        };
        Self {
            controlword,
            slots,
            layout,
            values: [(0, 0); SLOTS],
        }
    }

    /// The controlword.
    #[must_use]
    pub const fn controlword(&self) -> u16 {
        self.controlword
    }

    /// Takes a drive in; `false` if its target is of the other kind, the group has offsets and it none or the other way
    /// round, or the group has no such slot.
    pub fn put(&mut self, slot: Slot, target: Target, offset: Option<i16>) -> bool {
        let (torque, value) = match target {
            Target::Position(units) => (false, units),
            Target::Torque(per_mille) => (true, i32::from(per_mille)),
        };
        let alike = torque == (self.slots & TORQUE != 0)
            && offset.is_some() == (self.layout == Layout::Offsets)
            && usize::from(slot.0) <= self.layout.slots();
        let place = self.values.get_mut(usize::from(slot.0.saturating_sub(1)));
        let (true, Some(place)) = (alike, place) else {
            return false;
        };
        *place = (value, offset.unwrap_or(0));
        self.slots |= slot.bit();
        true
    }

    /// The target of a drive that obeys this group, and the torque offset if the group has one.
    #[must_use]
    pub fn target(&self, slot: Slot) -> Option<(Target, Option<i16>)> {
        if self.slots & slot.bit() == 0 {
            return None;
        }
        let (value, offset) = *self.values.get(usize::from(slot.0.saturating_sub(1)))?;
        let target = if self.slots & TORQUE == 0 {
            Target::Position(value)
        } else {
            Target::Torque(i16::try_from(value).ok()?)
        };
        Some((target, (self.layout == Layout::Offsets).then_some(offset)))
    }

    /// The last slot that obeys it.
    fn last(&self) -> Option<Slot> {
        let last = 16_u32.saturating_sub((self.slots & !TORQUE).leading_zeros());
        Slot::new(u8::try_from(last).ok()?)
    }

    /// The frame, on a wire whose drives obey this SYNC.
    #[must_use]
    pub fn frame(&self, sync_cob: u16) -> Option<Frame> {
        let mut data = [0; 64];
        let (head, rest) = data.split_first_chunk_mut::<4>()?;
        let [a, b] = self.controlword.to_le_bytes();
        let [c, d] = self.slots.to_le_bytes();
        *head = [a, b, c, d];
        let places = rest.chunks_exact_mut(self.layout.width());
        for (place, (value, offset)) in places.zip(self.values) {
            let [a, b, c, d] = value.to_le_bytes();
            let [e, f] = offset.to_le_bytes();
            for (to, from) in place.iter_mut().zip([a, b, c, d, e, f]) {
                *to = from;
            }
        }
        let id = Id::Standard(self.layout.cob(sync_cob));
        Frame::fd(id, data.get(..self.layout.length(self.last()?))?)
    }

    /// Reads the data of a group; `None` if they are shorter than their slots, have none, or have more than there can be.
    #[must_use]
    pub fn decode(layout: Layout, data: &[u8]) -> Option<Self> {
        let (head, rest) = data.split_first_chunk::<4>()?;
        let [a, b, c, d] = *head;
        let mut group = Self {
            controlword: u16::from_le_bytes([a, b]),
            slots: u16::from_le_bytes([c, d]),
            layout,
            values: [(0, 0); SLOTS],
        };
        let wanted = usize::from(group.last()?.get());
        if wanted > layout.slots() || rest.len() < wanted.saturating_mul(layout.width()) {
            return None;
        }
        let places = rest.chunks_exact(layout.width());
        for ((value, offset), place) in group.values.iter_mut().take(wanted).zip(places) {
            let (target, behind) = place.split_first_chunk::<4>()?;
            *value = i32::from_le_bytes(*target);
            *offset = behind
                .first_chunk::<2>()
                .map_or(0, |bytes| i16::from_le_bytes(*bytes));
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

    fn slot(number: u8) -> Slot {
        Slot::new(number).unwrap()
    }

    #[test]
    fn golden_groups_and_feedback() {
        let mut group = Group::new(0x000F, Target::Position(0), None);
        assert!(group.put(slot(1), Target::Position(-2), None));
        assert!(group.put(slot(3), Target::Position(0x0102_0304), None));
        assert!(!group.put(slot(2), Target::Torque(5), None));
        assert!(!group.put(slot(2), Target::Position(5), Some(0)));
        let frame = group.frame(0x080).unwrap();
        assert_eq!(frame.id(), Id::Standard(0x200));
        let expected = [
            0x0F, 0, 5, 0, 0xFE, 0xFF, 0xFF, 0xFF, 0, 0, 0, 0, 4, 3, 2, 1,
        ];
        assert_eq!((frame.is_fd(), frame.data()), (true, &expected[..]));

        let mut group = Group::new(0x000F, Target::Position(0), Some(0));
        assert!(group.put(slot(1), Target::Position(-2), Some(0x0506)));
        assert!(group.put(slot(3), Target::Position(0x0102_0304), Some(-3)));
        assert!(!group.put(slot(2), Target::Position(5), None));
        assert!(!group.put(slot(11), Target::Position(5), Some(1)));
        let frame = group.frame(0x0E2).unwrap();
        assert_eq!(frame.id(), Id::Standard(0x362));
        // 4 + 3 · 6 = 22 bytes, which FD has not
        let expected = [
            0x0F, 0, 5, 0, 0xFE, 0xFF, 0xFF, 0xFF, 6, 5, 0, 0, 0, 0, 0, 0, 4, 3, 2, 1, 0xFD, 0xFF,
            0, 0,
        ];
        assert_eq!((frame.is_fd(), frame.data()), (true, &expected[..]));

        let mut group = Group::new(0x0006, Target::Torque(0), Some(0));
        assert!(group.put(slot(2), Target::Torque(-1000), Some(7)));
        let frame = group.frame(0x080).unwrap();
        let expected = [
            6, 0, 2, 0x80, 0, 0, 0, 0, 0, 0, 0x18, 0xFC, 0xFF, 0xFF, 7, 0,
        ];
        assert_eq!(
            (frame.id(), frame.data()),
            (Id::Standard(0x300), &expected[..])
        );

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
        let (targets, offsets) = (Layout::Targets, Layout::Offsets);
        let nobodys = Group::new(15, Target::Torque(0), None);
        assert_eq!(nobodys.frame(0x080), None);
        for data in [
            &[][..],
            &[15, 0, 1],
            &[15, 0, 0, 0, 1, 2, 3, 4],
            &[15, 0, 2, 0, 1, 2, 3, 4],
        ] {
            assert_eq!(Group::decode(targets, data), None, "{data:?}");
            assert_eq!(Group::decode(offsets, data), None, "{data:?}");
        }
        // the layout is not in the data, only the room that they take
        let two = [15, 0, 2, 0, 1, 2, 3, 4, 5, 6, 7, 8];
        assert!(Group::decode(targets, &two).is_some());
        assert_eq!(Group::decode(offsets, &two), None);
        // the eleventh slot
        let mut long = [0; 64];
        (long[2], long[3]) = (0, 4);
        assert!(Group::decode(targets, &long).is_some());
        assert_eq!(Group::decode(offsets, &long), None);
        // a torque that does not fit
        let group = Group::decode(targets, &[15, 0, 1, 0x80, 0, 0, 1, 0]).unwrap();
        assert_eq!(group.target(slot(1)), None);
        assert_eq!((Slot::new(0), Slot::new(16)), (None, None));
        assert_eq!(Feedback::decode(&[0; 8]), None);
    }

    #[test]
    fn no_two_nodes_have_an_identifier_in_common() {
        let mut all: std::vec::Vec<u16> = [0x080, 0x0E2, 0x0E3, 0x0E9]
            .into_iter()
            .flat_map(|sync| [Layout::Targets.cob(sync), Layout::Offsets.cob(sync)])
            .collect();
        assert_eq!(all[..4], [0x200, 0x300, 0x262, 0x362]);
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), 8);
    }

    proptest! {
        #[test]
        fn every_group_is_read_as_it_was_written(
            word in any::<u16>(), torque in any::<bool>(), offsets in any::<bool>(),
            entries in proptest::collection::vec((1..=15_u8, any::<i16>(), any::<i16>()), 1..20),
        ) {
            let layout = if offsets { Layout::Offsets } else { Layout::Targets };
            let target = |value: i16| if torque { Target::Torque(value) } else { Target::Position(i32::from(value) << 9) };
            let mut group = Group::new(word, target(0), offsets.then_some(0));
            for (number, value, offset) in entries {
                let offset = offsets.then_some(offset);
                let fits = group.put(slot(number), target(value), offset);
                prop_assert_eq!(fits, usize::from(number) <= layout.slots());
                prop_assert!(!fits || group.target(slot(number)) == Some((target(value), offset)));
            }
            if let Some(frame) = group.frame(0x080) {
                prop_assert_eq!(Group::decode(layout, frame.data()), Some(group));
                prop_assert!(frame.data().len() <= 64);
            } else {
                prop_assert!((1..=15).all(|number| group.target(slot(number)).is_none()));
            }
        }

        #[test]
        fn every_feedback_is_read_as_it_was_written(data in any::<[u8; 16]>()) {
            prop_assert_eq!(Feedback::decode(&data).unwrap().encode(), data);
        }

        #[test]
        fn no_bytes_break_it(data in proptest::collection::vec(any::<u8>(), 0..=64), number in 1..=15_u8) {
            for layout in [Layout::Targets, Layout::Offsets] {
                let group = Group::decode(layout, &data);
                let _ = group.and_then(|group| group.target(slot(number)));
            }
        }
    }
}
