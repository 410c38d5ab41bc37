//! The real-time mailbox: memory that the image and its host share, with a ring of frames each way, the
//! boot message, and two clocks. A full ring is a lost frame, which is counted.
//!
//! The image goes by its own timer and the cell follows it. Where neither is a machine in real time, one of them
//! stands still at times for reasons that are not the robot's; so that a stalled cell is not taken for silent drives,
//! the image's time is held while the cell is more than [`AHEAD`] behind it, and for how long is counted.
//!
//! | offset | bytes | content |
//! |---|---|---|
//! | 0 | 4 | [`HOST_READY`] once the boot message is there; [`HOST_GONE`] at the end |
//! | 4 | 4 | [`IMAGE_READY`] once there is a node, [`IMAGE_FAILED`] if there is none |
//! | 8 | 4 | half milliseconds since the image's node began, modulo 2³² |
//! | 12 | 4 | frames lost by the image |
//! | 16 | 48 | boot message ([`crate::boot::Boot`]) |
//! | 64 | 4 + 4 | ring to the image: frames written, frames read, modulo 2³² |
//! | 72 | 4 + 4 | ring from the image: the same |
//! | 80 | 4 | half milliseconds that the cell has come since then |
//! | 84 | 4 | half milliseconds for which the image's time was held |
//! | 128 | 64 · 96 | slots to the image: length (4), frame ([`crate::frames`]) |
//! | 6272 | 64 · 96 | slots from the image |
//!
//! Each word has one writer. A slot is filled before it is counted, and read before it is given back.

use crate::boot::Boot;
use crate::frames;
use firmware::Received;

/// Bytes of the mailbox.
pub const BYTES: usize = 6272 + SLOTS as usize * SLOT as usize;
/// The boot message is there: "boot".
pub const HOST_READY: u32 = 0x746F_6F62;
/// The host has gone: "gone".
pub const HOST_GONE: u32 = 0x656E_6F67;
/// The node is there: "node".
pub const IMAGE_READY: u32 = 0x6564_6F6E;
/// There is no node: "none".
pub const IMAGE_FAILED: u32 = 0x656E_6F6E;

const HOST: u32 = 0;
const IMAGE: u32 = 4;
const TICKS: u32 = 8;
const LOST: u32 = 12;
const BOOT: u32 = 16;
const WORLD: u32 = 80;
const HELD: u32 = 84;
/// So many half milliseconds the image may be ahead of the cell: in its next period the cell answers.
pub const AHEAD: i32 = 1;
/// Slots of a ring.
const SLOTS: u32 = 64;
/// Bytes of a slot.
const SLOT: u32 = 96;

/// Shared memory. What is written is seen by the other side in the order in which it was written.
pub trait Memory {
    /// Read from an offset.
    fn read(&mut self, at: u32, bytes: &mut [u8]);
    /// Write to an offset.
    fn write(&mut self, at: u32, bytes: &[u8]);
}

/// One ring.
#[derive(Clone, Copy, Debug)]
pub struct Ring {
    counts: u32,
    slots: u32,
}

/// To the image.
pub const TO_IMAGE: Ring = Ring {
    counts: 64,
    slots: 128,
};
/// From the image.
pub const FROM_IMAGE: Ring = Ring {
    counts: 72,
    slots: 6272,
};

fn word(memory: &mut impl Memory, at: u32) -> u32 {
    let mut bytes = [0; 4];
    memory.read(at, &mut bytes);
    u32::from_le_bytes(bytes)
}

fn set_word(memory: &mut impl Memory, at: u32, value: u32) {
    memory.write(at, &value.to_le_bytes());
}

impl Ring {
    const fn slot(self, count: u32) -> u32 {
        self.slots.wrapping_add((count % SLOTS).wrapping_mul(SLOT))
    }

    /// A frame for the other side; `false` if the ring is full.
    #[must_use]
    pub fn push(self, memory: &mut impl Memory, frame: &Received) -> bool {
        let written = word(memory, self.counts);
        let read = word(memory, self.counts.wrapping_add(4));
        let mut slot = [0; SLOT as usize];
        let room = slot.get_mut(4..).unwrap_or_default();
        let (true, Some(length)) = (
            written.wrapping_sub(read) < SLOTS,
            frames::write(frame, room),
        ) else {
            return false;
        };
        let length = u32::try_from(length).unwrap_or(0);
        for (to, from) in slot.iter_mut().zip(length.to_le_bytes()) {
            *to = from;
        }
        memory.write(self.slot(written), &slot);
        set_word(memory, self.counts, written.wrapping_add(1));
        true
    }

    /// The oldest frame of the other side. One that is none is left out.
    pub fn pop(self, memory: &mut impl Memory) -> Option<Received> {
        for _ in 0..SLOTS {
            let written = word(memory, self.counts);
            let at = self.counts.wrapping_add(4);
            let read = word(memory, at);
            if written == read {
                return None;
            }
            let mut slot = [0; SLOT as usize];
            memory.read(self.slot(read), &mut slot);
            set_word(memory, at, read.wrapping_add(1));
            let [a, b, c, d, rest @ ..] = &slot;
            let length = usize::try_from(u32::from_le_bytes([*a, *b, *c, *d])).unwrap_or(0);
            let frame = rest.get(..length).and_then(frames::read);
            if let Some((frame, _)) = frame {
                return Some(frame);
            }
        }
        None
    }
}

/// Host: this is the node to be made.
#[must_use]
pub fn offer(memory: &mut impl Memory, boot: &Boot) -> bool {
    let mut bytes = [0; Boot::BYTES];
    if boot.write(&mut bytes).is_none() {
        return false;
    }
    memory.write(BOOT, &bytes);
    set_word(memory, HOST, HOST_READY);
    true
}

/// Host: no more.
pub fn leave(memory: &mut impl Memory) {
    set_word(memory, HOST, HOST_GONE);
}

/// Image: the node to be made, once the host has said which.
pub fn offered(memory: &mut impl Memory) -> Option<Boot> {
    if word(memory, HOST) != HOST_READY {
        return None;
    }
    let mut bytes = [0; Boot::BYTES];
    memory.read(BOOT, &mut bytes);
    Boot::read(&bytes)
}

/// Image: has the host gone?
pub fn left(memory: &mut impl Memory) -> bool {
    word(memory, HOST) == HOST_GONE
}

/// Image: is there a node?
pub fn accept(memory: &mut impl Memory, made: bool) {
    set_word(memory, IMAGE, if made { IMAGE_READY } else { IMAGE_FAILED });
}

/// Host: is there a node? Nothing while the image has not said it.
pub fn accepted(memory: &mut impl Memory) -> Option<bool> {
    match word(memory, IMAGE) {
        IMAGE_READY => Some(true),
        IMAGE_FAILED => Some(false),
        _ => None,
    }
}

/// What the image tells of itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Told {
    /// Its clock, half milliseconds.
    pub ticks: u32,
    /// Frames it has lost.
    pub lost: u32,
    /// Half milliseconds for which its time was held.
    pub held: u32,
}

/// Image: how it does.
pub fn tell(memory: &mut impl Memory, told: Told) {
    set_word(memory, LOST, told.lost);
    set_word(memory, HELD, told.held);
    set_word(memory, TICKS, told.ticks);
}

/// Host: how the image does.
pub fn told(memory: &mut impl Memory) -> Told {
    Told {
        ticks: word(memory, TICKS),
        lost: word(memory, LOST),
        held: word(memory, HELD),
    }
}

/// Host: the cell has come so far, half milliseconds, and what it had to send until then is in the ring.
pub fn reached(memory: &mut impl Memory, ticks: u32) {
    set_word(memory, WORLD, ticks);
}

/// Image: would it be more than [`AHEAD`] of the cell at `ticks`?
pub fn too_early(memory: &mut impl Memory, ticks: u32) -> bool {
    ticks.wrapping_sub(word(memory, WORLD)).cast_signed() > AHEAD
}

#[cfg(test)]
mod test {
    use super::*;
    use firmware::Port;
    use protocol::frame::{Frame, Id};
    use protocol::time::Micros;

    struct Bytes([u8; BYTES]);

    impl Memory for Bytes {
        fn read(&mut self, at: u32, bytes: &mut [u8]) {
            let at = at as usize;
            bytes.copy_from_slice(&self.0[at..at + bytes.len()]);
        }
        fn write(&mut self, at: u32, bytes: &[u8]) {
            let at = at as usize;
            self.0[at..at + bytes.len()].copy_from_slice(bytes);
        }
    }

    fn frame(k: u8) -> Received {
        Received {
            port: Port::Drives(1),
            at: Micros(u64::from(k)),
            frame: Frame::fd(Id::Extended(u32::from(k)), &[k; 64]).unwrap(),
        }
    }

    #[test]
    fn frames_come_in_order_and_a_full_ring_refuses_them() {
        let mut memory = Bytes([0; BYTES]);
        // beyond the end of the ring, and of what 32 bits count
        for count in [64_u32, 68] {
            memory.write(count, &(u32::MAX - 70).to_le_bytes());
        }
        for turn in 0..5 {
            for k in 0..64 {
                assert!(TO_IMAGE.push(&mut memory, &frame(k)), "{turn} {k}");
            }
            assert!(!TO_IMAGE.push(&mut memory, &frame(64)));
            assert_eq!(FROM_IMAGE.pop(&mut memory), None);
            for k in 0..64 {
                assert_eq!(TO_IMAGE.pop(&mut memory), Some(frame(k)));
            }
            assert_eq!(TO_IMAGE.pop(&mut memory), None);
        }
    }

    #[test]
    fn both_rings_and_the_words_are_apart() {
        let mut memory = Bytes([0; BYTES]);
        let how = Told {
            ticks: 0x0102_0304,
            lost: 7,
            held: 9,
        };
        tell(&mut memory, how);
        reached(&mut memory, 0x0506_0708);
        for k in 0..64 {
            assert!(FROM_IMAGE.push(&mut memory, &frame(k)));
            assert!(TO_IMAGE.push(&mut memory, &frame(200 - k)));
        }
        assert_eq!(told(&mut memory), how);
        assert!(!too_early(&mut memory, 0x0506_0709));
        assert_eq!(accepted(&mut memory), None);
        for k in 0..64 {
            assert_eq!(TO_IMAGE.pop(&mut memory), Some(frame(200 - k)));
            assert_eq!(FROM_IMAGE.pop(&mut memory), Some(frame(k)));
        }
        accept(&mut memory, false);
        assert_eq!(accepted(&mut memory), Some(false));
        assert_eq!(offered(&mut memory), None);
        leave(&mut memory);
        assert!(left(&mut memory));
    }

    #[test]
    fn the_image_is_a_tick_ahead_of_the_cell_and_no_more() {
        let mut memory = Bytes([0; BYTES]);
        for world in [0, 1, u32::MAX - 1, u32::MAX] {
            reached(&mut memory, world);
            for (ticks, early) in [(-1, false), (0, false), (1, false), (2, true), (9, true)] {
                let ticks = world.wrapping_add_signed(ticks);
                assert_eq!(too_early(&mut memory, ticks), early, "{world} {ticks}");
            }
        }
    }

    #[test]
    fn a_slot_of_nonsense_is_left_out() {
        let mut memory = Bytes([0; BYTES]);
        assert!(TO_IMAGE.push(&mut memory, &frame(1)));
        assert!(TO_IMAGE.push(&mut memory, &frame(2)));
        memory.write(128, &[0xFF; 96]);
        assert_eq!(TO_IMAGE.pop(&mut memory), Some(frame(2)));
    }
}
