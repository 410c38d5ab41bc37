//! The bits of a frame as a sender gives them to the wire, up to its data.

use protocol::frame::{Frame, Id};

/// After so many equal bits a sender puts in their complement.
const EQUAL_BITS: u32 = 5;

/// A bit; dominant wins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Level {
    Dominant,
    Recessive,
}

impl Level {
    const fn of(bit: bool) -> Self {
        if bit { Self::Recessive } else { Self::Dominant }
    }

    const fn complement(self) -> Self {
        match self {
            Self::Dominant => Self::Recessive,
            Self::Recessive => Self::Dominant,
        }
    }
}

/// A bit on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Bit {
    pub(super) level: Level,
    /// It was put in to break a run of equal bits.
    pub(super) stuffed: bool,
    /// It belongs to the arbitration: the identifier with its format, up to the remote request.
    pub(super) arbitrates: bool,
}

/// Its bits from the start of frame to the last of its data, stuffed (ISO 11898-1:2015, 10.4 and 10.5). `passive`: who
/// sends it is error-passive, which an FD frame tells.
///
/// What comes behind (CRC, and the count of stuff bits) follows from these: frames that are equal up to here are equal.
pub(super) fn of(frame: &Frame, passive: bool) -> Vec<Bit> {
    let (header, arbitration) = header(frame, passive);
    let length = dlc(frame.data().len());
    let length = (0..4).rev().map(|place| length >> place & 1 == 1);
    let data = frame.data().iter();
    let data = data.flat_map(|byte| (0..8).rev().map(move |place| byte >> place & 1 == 1));
    let all = header.into_iter().chain(length).chain(data);
    let mut bits = Vec::with_capacity(640);
    let (mut last, mut run) = (Level::Recessive, 0);
    for (place, bit) in all.enumerate() {
        let arbitrates = place < arbitration;
        if run == EQUAL_BITS {
            last = last.complement();
            run = 1;
            bits.push(Bit {
                level: last,
                stuffed: true,
                arbitrates,
            });
        }
        let level = Level::of(bit);
        run = if level == last { run + 1 } else { 1 };
        last = level;
        bits.push(Bit {
            level,
            stuffed: false,
            arbitrates,
        });
    }
    bits
}

/// The bits in front of the length, and how many of them arbitrate.
fn header(frame: &Frame, passive: bool) -> (Vec<bool>, usize) {
    let number = |value: u32, bits: u32| (0..bits).rev().map(move |place| value >> place & 1 == 1);
    let mut bits = vec![false]; // start of frame
    match frame.id() {
        Id::Standard(id) => {
            bits.extend(number(u32::from(id), 11));
            bits.extend([false, false]); // no remote request; 11 bits
        }
        Id::Extended(id) => {
            bits.extend(number(id >> 18, 11));
            bits.extend([true, true]); // substitute; 29 bits
            bits.extend(number(id, 18));
            bits.push(false); // no remote request
        }
    }
    let arbitration = bits.len();
    match (frame.is_fd(), frame.id()) {
        (false, Id::Standard(_)) => bits.push(false), // FDF
        (false, Id::Extended(_)) => bits.extend([false, false]), // FDF, reserved
        (true, _) => bits.extend([true, false, true, passive]), // FDF, reserved, BRS, ESI
    }
    (bits, arbitration)
}

/// The code of a length of data.
fn dlc(length: usize) -> u32 {
    match length {
        0..=8 => u32::try_from(length).unwrap_or(8),
        9..=12 => 9,
        13..=16 => 10,
        17..=20 => 11,
        21..=24 => 12,
        25..=32 => 13,
        33..=48 => 14,
        _ => 15,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use protocol::budget;

    fn text(bits: &[Bit]) -> String {
        let digit = |bit: &Bit| match bit.level {
            Level::Dominant => '0',
            Level::Recessive => '1',
        };
        bits.iter().map(digit).collect()
    }

    #[test]
    fn the_bits_of_a_short_frame_are_those_written_by_hand() {
        // SOF, 000 0101 0000, no request, IDE, FDF; 0001; 1000 0000. A one behind each five zeros: the SOF with the first
        // four of the identifier; its last four with the request; IDE, FDF and three of the length; five of the data
        let frame = Frame::classic(Id::Standard(0x050), &[0x80]).unwrap();
        let bits = of(&frame, false);
        assert_eq!(text(&bits), "0000011010000010000011100000100".to_owned());
        let stuffed: Vec<usize> = (0..bits.len()).filter(|k| bits[*k].stuffed).collect();
        assert_eq!(stuffed, [5, 14, 20, 28]);
        // 14 of the frame and two put in
        assert_eq!(bits.iter().filter(|bit| bit.arbitrates).count(), 14 + 2);
    }

    fn any_frame() -> impl Strategy<Value = Frame> {
        let id = prop_oneof![
            (0..0x800_u16).prop_map(Id::Standard),
            (0..0x2000_0000_u32).prop_map(Id::Extended),
        ];
        let data =
            proptest::collection::vec(prop_oneof![Just(0_u8), Just(0xFF), any::<u8>()], 0..=8);
        (id, data, any::<bool>()).prop_map(|(id, data, fd)| {
            let frame = if fd {
                Frame::fd(id, &data)
            } else {
                Frame::classic(id, &data)
            };
            frame.unwrap()
        })
    }

    proptest! {
        /// Six equal bits never follow each other; without what was put in it is as long as the format says, and
        /// with it as the exact length says: an FD frame has no dynamic stuff bits behind its data, a classical one
        /// at most three (15 bits of CRC and a run from before).
        #[test]
        fn bits_are_stuffed_as_their_number_says(frame in any_frame(), passive in any::<bool>()) {
            let bits = of(&frame, passive);
            let run = |six: &[Bit]| six.iter().all(|bit| bit.level == six[0].level);
            prop_assert!(!bits.windows(6).any(run));
            let plain = bits.iter().filter(|bit| !bit.stuffed).count();
            let overhead = match (frame.id(), frame.is_fd()) {
                (Id::Standard(_), false) => 19,
                (Id::Extended(_), false) => 39,
                (Id::Standard(_), true) => 22,
                (Id::Extended(_), true) => 41,
            };
            prop_assert_eq!(plain, overhead + 8 * frame.data().len());
            let budget::Bits { nominal, data } = budget::exact(&frame);
            let length = usize::try_from(nominal + data).unwrap();
            if frame.is_fd() {
                if !passive {
                    // stuff count, CRC-17, their fixed stuff bits; the rest of the frame
                    prop_assert_eq!(bits.len(), length - (4 + 17 + 6) - 13);
                }
            } else {
                prop_assert!((0..=3).contains(&(length - 15 - 13 - bits.len())));
            }
        }
    }
}
