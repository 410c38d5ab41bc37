//! Frames as the words of an `M_CAN`'s message memory.
//!
//! | word | bits |
//! |---|---|
//! | 0 | 30: 29-bit identifier; 29: remote frame; 28..0: identifier, an 11-bit one in 28..18 |
//! | 1 | 23: tell when it was sent; 21: CAN FD; 20: bit-rate switch; 19..16: DLC; of a received frame 15..0: time stamp |
//! | 2 to 17 | payload, the first byte in the lowest bits |

use protocol::frame::{Frame, Id, MAX_DATA};

/// Words of an element.
pub const WORDS: usize = 18;

const EXTENDED: u32 = 1 << 30;
const REMOTE: u32 = 1 << 29;
const TELL: u32 = 1 << 23;
const FD: u32 = 1 << 21;
const SWITCH: u32 = 1 << 20;

/// Lengths of DLC 9 to 15.
const LONG: [u8; 7] = [12, 16, 20, 24, 32, 48, 64];

/// The DLC of a payload of this length, if there is one.
fn code(length: usize) -> Option<u32> {
    if length <= 8 {
        return u32::try_from(length).ok();
    }
    let at = LONG.iter().position(|long| usize::from(*long) == length)?;
    u32::try_from(at.checked_add(9)?).ok()
}

/// Bytes of the payload of a frame with this DLC; of classical frames at most 8.
fn length(code: u32, fd: bool) -> usize {
    let Some(beyond) = code.checked_sub(9) else {
        return usize::try_from(code).unwrap_or(0);
    };
    let long = usize::try_from(beyond).ok().and_then(|at| LONG.get(at));
    match long {
        Some(long) if fd => usize::from(*long),
        _ => 8,
    }
}

/// The words of a frame to be sent, and how many of them mean something. `tell`: its time is wanted.
#[must_use]
pub fn write(frame: &Frame, tell: bool) -> ([u32; WORDS], usize) {
    let mut words = [0; WORDS];
    let data = frame.data();
    let first = match frame.id() {
        Id::Standard(id) => (u32::from(id) & 0x7FF) << 18,
        Id::Extended(id) => EXTENDED | id & 0x1FFF_FFFF,
    };
    // every frame has a length that exists
    let mut second = code(data.len()).unwrap_or(0) << 16;
    if frame.is_fd() {
        second |= FD | SWITCH;
    }
    if tell {
        second |= TELL;
    }
    let [w0, w1, payload @ ..] = &mut words;
    (*w0, *w1) = (first, second);
    let mut used = 2_usize;
    for (word, bytes) in payload.iter_mut().zip(data.chunks(4)) {
        let mut whole = [0; 4];
        for (to, from) in whole.iter_mut().zip(bytes) {
            *to = *from;
        }
        *word = u32::from_le_bytes(whole);
        used = used.saturating_add(1);
    }
    (words, used)
}

/// How many words of an element mean something, by its second one.
#[must_use]
pub fn used(second: u32) -> usize {
    length(second >> 16 & 0xF, second & FD != 0)
        .div_ceil(4)
        .saturating_add(2)
}

/// The identifier in a first word.
#[must_use]
pub const fn id(first: u32) -> Id {
    if first & EXTENDED == 0 {
        Id::Standard((first >> 18 & 0x7FF) as u16)
    } else {
        Id::Extended(first & 0x1FFF_FFFF)
    }
}

/// A received frame and its time stamp; nothing of a remote frame, of which this system has none.
#[must_use]
pub fn read(words: &[u32; WORDS]) -> Option<(Frame, u16)> {
    let [first, second, payload @ ..] = words;
    if first & REMOTE != 0 {
        return None;
    }
    let fd = second & FD != 0;
    let mut data = [0; MAX_DATA];
    for (to, word) in data.chunks_mut(4).zip(payload) {
        to.copy_from_slice(&word.to_le_bytes());
    }
    let data = data.get(..length(second >> 16 & 0xF, fd))?;
    let id = id(*first);
    let frame = if fd {
        Frame::fd(id, data)
    } else {
        Frame::classic(id, data)
    };
    #[expect(
        clippy::cast_possible_truncation,
        reason = "the lowest 16 bits are the stamp"
    )]
    Some((frame?, *second as u16))
}

#[cfg(test)]
mod test {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_frame_is_these_words() {
        let frame = Frame::classic(Id::Standard(0x181), &[1, 2, 3, 4, 5]).unwrap();
        let (words, used) = write(&frame, false);
        assert_eq!(&words[..used], [0x181 << 18, 5 << 16, 0x0403_0201, 0x05]);
        let frame = Frame::fd(Id::Extended(0x1234_5678), &[0xAB; 12]).unwrap();
        let (words, used) = write(&frame, true);
        let second = 1 << 23 | 1 << 21 | 1 << 20 | 9 << 16;
        assert_eq!(words[..2], [0x4000_0000 | 0x1234_5678, second]);
        assert_eq!((words[2], used), (0xABAB_ABAB, 5));
    }

    #[test]
    fn a_classical_frame_has_8_bytes_at_most_whatever_its_code_says() {
        let mut words = [0; WORDS];
        for code in 9..16 {
            words[1] = code << 16;
            assert_eq!(read(&words).unwrap().0.data().len(), 8);
            assert_eq!(used(words[1]), 4);
        }
        words[0] = 1 << 29;
        assert_eq!(read(&words), None, "a remote frame");
    }

    proptest! {
        #[test]
        fn what_is_written_is_read(extended in any::<bool>(), id in any::<u32>(), code in 0_usize..16, fd in any::<bool>(),
            data in any::<[u8; 32]>(), stamp in any::<u16>(), tell in any::<bool>()) {
            let data = [data, data].concat();
            let id = if extended { Id::Extended(id & 0x1FFF_FFFF) } else { Id::Standard((id & 0x7FF) as u16) };
            let length = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64][if fd { code } else { code.min(8) }];
            let data = &data[..length];
            let frame = if fd { Frame::fd(id, data) } else { Frame::classic(id, data) }.unwrap();
            let (mut words, count) = write(&frame, tell);
            prop_assert_eq!(used(words[1]), count);
            words[1] |= u32::from(stamp);
            prop_assert_eq!(read(&words), Some((frame, stamp)));
        }

        #[test]
        fn no_words_are_too_strange(words in any::<[u32; WORDS]>()) {
            let _ = read(&words);
            prop_assert!(used(words[1]) <= WORDS);
        }
    }
}
