//! Which image starts: a pure function of what is in the slots and of the last record.
//!
//! ```text
//!             activate              reset: one try                confirm
//!  Confirmed ──────────▶ Trial {1} ───────────────▶ Trial {0} ───────────────▶ Confirmed
//!      ▲                     │ damaged                  │ reset without confirm, or damaged
//!      └─────────────────────┴──────────────────────────┘ the other image, as RolledBack
//! ```
//! The record of a try is written before the image starts, so an image that hangs or resets is never tried twice.

use super::image::{CRC, put, take};
use protocol::maintenance::{Slot, Standing};

/// How often an image is tried.
pub const TRIALS: u8 = 1;

/// Bytes of a record: a multiple of every flash's write size.
pub const RECORD: usize = 16;

/// How the image of a slot is to be taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// It is good.
    Confirmed,
    /// It is good, and the other was not.
    RolledBack,
    /// It may be started so many times more; after that the other is.
    Trial {
        /// Tries left.
        left: u8,
    },
}

/// What was decided last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Record {
    /// The slot it is about.
    pub slot: Slot,
    /// How it is to be taken.
    pub phase: Phase,
}

/// What is to be started.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Choice {
    /// The slot; `None`: there is nothing to start.
    pub slot: Option<Slot>,
    /// What the image is told.
    pub standing: Standing,
    /// To be written before it starts.
    pub write: Option<Record>,
}

/// The other slot.
#[must_use]
pub const fn other(slot: Slot) -> Slot {
    match slot {
        Slot::A => Slot::B,
        Slot::B => Slot::A,
    }
}

/// What starts, when the images of slots A and B are whole or not.
#[must_use]
pub const fn choose(record: Option<Record>, whole: [bool; 2]) -> Choice {
    let Some(Record { slot, phase }) = record else {
        // never written: as it came from the factory
        let slot = match whole {
            [true, _] => Some(Slot::A),
            [false, true] => Some(Slot::B),
            [false, false] => None,
        };
        return plain(slot, Standing::Confirmed);
    };
    let (this, that) = match (slot, whole) {
        (Slot::A, [a, b]) => (a, b),
        (Slot::B, [a, b]) => (b, a),
    };
    match phase {
        Phase::Confirmed if this => plain(Some(slot), Standing::Confirmed),
        Phase::RolledBack if this => plain(Some(slot), Standing::RolledBack),
        Phase::Trial { left } if this && left > 0 => Choice {
            slot: Some(slot),
            standing: Standing::Trial,
            write: Some(Record {
                slot,
                phase: Phase::Trial {
                    left: left.saturating_sub(1),
                },
            }),
        },
        _ if that => {
            let slot = other(slot);
            let phase = Phase::RolledBack;
            Choice {
                slot: Some(slot),
                standing: Standing::RolledBack,
                write: Some(Record { slot, phase }),
            }
        }
        // an image that has had its tries is still better than none
        Phase::Trial { .. } if this => plain(Some(slot), Standing::Trial),
        _ => plain(None, Standing::RolledBack),
    }
}

const fn plain(slot: Option<Slot>, standing: Standing) -> Choice {
    Choice {
        slot,
        standing,
        write: None,
    }
}

/// A record as bytes: number u32, slot, phase, tries left, five zeros, CRC-32 of these.
#[must_use]
pub fn write(number: u32, record: Record) -> [u8; RECORD] {
    let slot = match record.slot {
        Slot::A => 0,
        Slot::B => 1,
    };
    let (phase, left) = match record.phase {
        Phase::Confirmed => (0, 0),
        Phase::RolledBack => (1, 0),
        Phase::Trial { left } => (2, left),
    };
    let mut bytes = [0; RECORD];
    put(&mut bytes, 0, &number.to_le_bytes());
    put(&mut bytes, 4, &[slot, phase, left]);
    let crc = CRC.checksum(bytes.get(..12).unwrap_or(&[]));
    put(&mut bytes, 12, &crc.to_le_bytes());
    bytes
}

/// The record these bytes are, and its number; `None` if they are none.
#[must_use]
pub fn read(bytes: &[u8; RECORD]) -> Option<(u32, Record)> {
    let crc = CRC.checksum(bytes.get(..12)?);
    if u32::from_le_bytes(take(bytes, 12).ok()?) != crc {
        return None;
    }
    let number = u32::from_le_bytes(take(bytes, 0).ok()?);
    let [slot, phase, left] = take(bytes, 4).ok()?;
    let slot = match slot {
        0 => Slot::A,
        1 => Slot::B,
        _ => return None,
    };
    let phase = match (phase, left) {
        (0, 0) => Phase::Confirmed,
        (1, 0) => Phase::RolledBack,
        (2, left) => Phase::Trial { left },
        _ => return None,
    };
    Some((number, Record { slot, phase }))
}

#[cfg(test)]
mod test {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    fn records() -> Vec<Option<Record>> {
        let phases = [Phase::Confirmed, Phase::RolledBack]
            .into_iter()
            .chain((0..=255).map(|left| Phase::Trial { left }));
        let of = |slot| move |phase| Some(Record { slot, phase });
        let all = phases
            .clone()
            .map(of(Slot::A))
            .chain(phases.map(of(Slot::B)));
        all.chain([None]).collect()
    }

    const WHOLE: [[bool; 2]; 4] = [[false, false], [false, true], [true, false], [true, true]];

    fn is_whole(whole: [bool; 2], slot: Slot) -> bool {
        whole[usize::from(slot == Slot::B)]
    }

    #[test]
    fn a_damaged_image_never_starts_and_a_whole_one_always_does() {
        for record in records() {
            for whole in WHOLE {
                let choice = choose(record, whole);
                match choice.slot {
                    Some(slot) => assert!(is_whole(whole, slot), "{record:?} {whole:?}"),
                    None => assert_eq!(whole, [false, false], "{record:?}"),
                }
            }
        }
    }

    #[test]
    fn what_was_decided_starts_as_long_as_it_can() {
        for record in records().into_iter().flatten() {
            for whole in WHOLE {
                if !is_whole(whole, record.slot) {
                    continue;
                }
                let choice = choose(Some(record), whole);
                let alone = !is_whole(whole, other(record.slot));
                let tries = match record.phase {
                    Phase::Trial { left } => left > 0,
                    Phase::Confirmed | Phase::RolledBack => true,
                };
                let stays = choice.slot == Some(record.slot);
                assert_eq!(stays, tries || alone, "{record:?} {whole:?}");
            }
        }
    }

    /// From any record and any damage, resets alone lead to an image that starts for ever, and a trial is never
    /// among those after at most 256 tries, if there is another image.
    #[test]
    fn resets_alone_come_to_an_image_that_stays() {
        for first in records() {
            for whole in WHOLE {
                let mut record = first;
                let mut last = choose(record, whole);
                for _ in 0..300 {
                    record = last.write.or(record);
                    last = choose(record, whole);
                }
                assert_eq!(last.write, None, "{first:?} {whole:?}");
                if whole == [true, true] {
                    assert_ne!(last.standing, Standing::Trial, "{first:?}");
                }
            }
        }
    }

    #[test]
    fn an_image_is_tried_once_and_then_the_other_starts() {
        let activated = Record {
            slot: Slot::B,
            phase: Phase::Trial { left: TRIALS },
        };
        let tried = choose(Some(activated), [true, true]);
        assert_eq!(
            (tried.slot, tried.standing),
            (Some(Slot::B), Standing::Trial)
        );
        let back = choose(tried.write, [true, true]);
        assert_eq!(
            (back.slot, back.standing),
            (Some(Slot::A), Standing::RolledBack)
        );
        let again = choose(back.write, [true, true]);
        assert_eq!((again.slot, again.write), (Some(Slot::A), None));
    }

    #[test]
    fn records_survive_and_damage_of_two_bits_does_not_pass() {
        for record in records().into_iter().flatten() {
            for number in [0, 1, 255, u32::MAX - 1] {
                let good = write(number, record);
                assert_eq!(read(&good), Some((number, record)));
                for first in 0..RECORD * 8 {
                    for second in first..RECORD * 8 {
                        let mut bytes = good;
                        bytes[first / 8] ^= 1 << (first % 8);
                        if second != first {
                            bytes[second / 8] ^= 1 << (second % 8);
                        }
                        assert_eq!(read(&bytes), None, "{record:?} {first} {second}");
                    }
                }
                if record.phase != Phase::Confirmed {
                    break; // the bytes differ too little to be worth the time
                }
            }
            if matches!(record.phase, Phase::Trial { left } if left > 2) {
                break;
            }
        }
        assert_eq!(read(&[0xFF; RECORD]), None, "an erased place");
        assert_eq!(read(&[0; RECORD]), None);
    }
}
