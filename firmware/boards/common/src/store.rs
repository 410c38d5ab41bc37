//! A configuration in flash: two copies, each in a page of its own, of which one is whole whenever power goes.
//!
//! | bytes | content, little endian |
//! |---|---|
//! | 4 | "mrcf" |
//! | 2 | version of what the content means |
//! | 2 | length of the content, L |
//! | 4 | sequence number, one more at each saving, modulo 2³² |
//! | 4 | CRC-32 of the 12 bytes above and the content |
//! | L | content, then FF up to [`RECORD`] bytes |
//!
//! Saving replaces the worse copy first and the better one behind it. So a saving that is cut anywhere leaves the
//! old content or the new one, and one that came to its end leaves the new one twice.

use crate::bytes::{Reader, Writer};
use embedded_storage::nor_flash::NorFlash;

/// Bytes of a copy.
pub const RECORD: usize = 128;
/// Bytes of content at most.
pub const CONTENT: usize = RECORD - HEADER;
const HEADER: usize = 16;
/// "mrcf"
const MAGIC: u32 = 0x6663_726D;
/// How many copies.
const COPIES: u32 = 2;

/// What is in flash.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Loaded {
    /// The content.
    pub content: heapless::Vec<u8, CONTENT>,
    /// Both copies are whole and the same; if not, [`Store::save`] mends them.
    pub twice: bool,
}

/// Why it could not be saved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SaveError<E> {
    /// More than [`CONTENT`] bytes.
    TooLong,
    /// The flash said so.
    Flash(E),
    /// What was written is not what is read.
    Unread,
}

impl<E: core::fmt::Debug> core::fmt::Display for SaveError<E> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::TooLong => write!(f, "expected a content of at most {CONTENT} bytes"),
            Self::Flash(error) => write!(f, "flash: {error:?}"),
            Self::Unread => write!(f, "flash: what was written is not what is read"),
        }
    }
}

impl<E: core::fmt::Debug> core::error::Error for SaveError<E> {}

/// The first two pages of this flash.
#[derive(Debug)]
pub struct Store<F> {
    pub(crate) flash: F,
    version: u16,
}

/// One copy.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Copy {
    sequence: u32,
    content: heapless::Vec<u8, CONTENT>,
}

impl<F: NorFlash> Store<F> {
    /// Of contents that this version means; copies of another version count as none.
    pub const fn new(flash: F, version: u16) -> Self {
        const {
            assert!(RECORD <= F::ERASE_SIZE);
            assert!(RECORD.is_multiple_of(F::WRITE_SIZE) && RECORD.is_multiple_of(F::READ_SIZE));
        }
        Self { flash, version }
    }

    const fn offset(copy: u32) -> u32 {
        #[expect(clippy::cast_possible_truncation, reason = "a page is far smaller")]
        copy.wrapping_mul(F::ERASE_SIZE as u32)
    }

    /// A copy, if it is whole. One that cannot be read is not.
    fn read(&mut self, copy: u32) -> Option<Copy> {
        let mut record = [0; RECORD];
        self.flash.read(Self::offset(copy), &mut record).ok()?;
        let mut reader = Reader(&record);
        let head = reader.0.get(..12)?;
        let (magic, version, length) = (reader.u32()?, reader.u16()?, reader.u16()?);
        let (sequence, proven) = (reader.u32()?, reader.u32()?);
        if magic != MAGIC || version != self.version {
            return None;
        }
        let content = reader.take(usize::from(length))?;
        (proven == proof(head, content)).then_some(())?;
        Some(Copy {
            sequence,
            content: heapless::Vec::from_slice(content).ok()?,
        })
    }

    /// Both copies, and which of them is the better: the newer of two whole ones.
    fn look(&mut self) -> (Option<Copy>, bool, u32) {
        match (self.read(0), self.read(1)) {
            (Some(a), Some(b)) => {
                let same = a == b;
                // by the difference, since sequence numbers wrap around
                if b.sequence.wrapping_sub(a.sequence).cast_signed() > 0 {
                    (Some(b), same, 1)
                } else {
                    (Some(a), same, 0)
                }
            }
            (None, Some(b)) => (Some(b), false, 1),
            (first, None) => (first, false, 0),
        }
    }

    /// What was saved; nothing if no copy is whole.
    pub fn load(&mut self) -> Option<Loaded> {
        let (best, twice, _) = self.look();
        best.map(|copy| Loaded {
            content: copy.content,
            twice,
        })
    }

    /// Replace what was saved.
    ///
    /// # Errors
    /// [`SaveError`]; unless it was too long, saving again may help, and the old content is lost only if neither
    /// copy could be written.
    pub fn save(&mut self, content: &[u8]) -> Result<(), SaveError<F::Error>> {
        let (best, _, better) = self.look();
        let sequence = best.map_or(0, |copy| copy.sequence.wrapping_add(1));
        let record = record(self.version, sequence, content).ok_or(SaveError::TooLong)?;
        let worse = (COPIES - 1).wrapping_sub(better);
        for copy in [worse, better] {
            let at = Self::offset(copy);
            let end = Self::offset(copy.wrapping_add(1));
            self.flash.erase(at, end).map_err(SaveError::Flash)?;
            self.flash.write(at, &record).map_err(SaveError::Flash)?;
            let back = self.read(copy);
            if back.is_none_or(|b| b.content != content || b.sequence != sequence) {
                return Err(SaveError::Unread);
            }
        }
        Ok(())
    }
}

/// The bytes of a copy; nothing if the content is too long.
#[must_use]
pub fn record(version: u16, sequence: u32, content: &[u8]) -> Option<[u8; RECORD]> {
    if content.len() > CONTENT {
        return None;
    }
    let mut record = [0xFF; RECORD];
    let mut out = Writer::new(&mut record);
    let mut head = [0; 12];
    {
        let mut head = Writer::new(&mut head);
        head.put(&MAGIC.to_le_bytes())?;
        head.put(&version.to_le_bytes())?;
        head.put(&u16::try_from(content.len()).ok()?.to_le_bytes())?;
        head.put(&sequence.to_le_bytes())?;
    }
    out.put(&head)?;
    out.put(&proof(&head, content).to_le_bytes())?;
    out.put(content)?;
    Some(record)
}

fn proof(head: &[u8], content: &[u8]) -> u32 {
    let crc = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);
    let mut digest = crc.digest();
    digest.update(head);
    digest.update(content);
    digest.finalize()
}

#[cfg(test)]
pub(crate) mod test {
    use super::*;
    use embedded_storage::nor_flash::{ErrorType, NorFlashError, NorFlashErrorKind, ReadNorFlash};
    use proptest::prelude::*;
    use std::vec;
    use std::vec::Vec;

    const PAGE: usize = 256;

    /// Flash of two pages that loses power after so many elementary changes, in the middle of one.
    #[derive(Clone, Debug)]
    pub(crate) struct Torn {
        bytes: Vec<u8>,
        /// Changes left until power goes: a double word programmed, or a quarter of a page erased.
        left: u32,
        /// What a change that was cut leaves.
        noise: u8,
        /// Reading this double word fails: what flash with error correction does with one that was cut.
        unreadable: Option<usize>,
    }

    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub(crate) struct NoPower;

    impl NorFlashError for NoPower {
        fn kind(&self) -> NorFlashErrorKind {
            NorFlashErrorKind::Other
        }
    }

    impl Torn {
        pub(crate) fn new() -> Self {
            Self {
                bytes: vec![0x5A; 2 * PAGE],
                left: u32::MAX,
                noise: 0,
                unreadable: None,
            }
        }

        /// Power goes with the change of this number, from 1.
        pub(crate) const fn cut_after(&mut self, changes: u32) {
            self.left = changes;
        }

        /// A bit of this byte.
        pub(crate) fn rot(&mut self, byte: usize) {
            self.bytes[byte] ^= 1;
        }

        /// A change of these bytes: whole, cut, or no more.
        fn change(&mut self, at: usize, new: &[u8]) -> Result<(), NoPower> {
            let noise = self.noise;
            match self.left {
                0 => return Err(NoPower),
                1 => {
                    for (k, byte) in new.iter().enumerate() {
                        // some bits are new, some old, and some are neither
                        let mask = noise.rotate_left(u32::try_from(k).unwrap());
                        self.bytes[at + k] = self.bytes[at + k] & mask | byte & !mask ^ (mask & 1);
                    }
                    self.unreadable = noise.is_multiple_of(3).then_some(at / 8);
                    self.left = 0;
                    return Err(NoPower);
                }
                _ => self.bytes[at..at + new.len()].copy_from_slice(new),
            }
            self.left -= 1;
            Ok(())
        }
    }

    impl ErrorType for Torn {
        type Error = NoPower;
    }

    impl ReadNorFlash for Torn {
        const READ_SIZE: usize = 1;
        fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NoPower> {
            let range = offset as usize..offset as usize + bytes.len();
            if self
                .unreadable
                .is_some_and(|word| range.contains(&(8 * word)))
            {
                return Err(NoPower);
            }
            bytes.copy_from_slice(&self.bytes[range]);
            Ok(())
        }
        fn capacity(&self) -> usize {
            self.bytes.len()
        }
    }

    impl NorFlash for Torn {
        const WRITE_SIZE: usize = 8;
        const ERASE_SIZE: usize = PAGE;
        fn erase(&mut self, from: u32, to: u32) -> Result<(), NoPower> {
            assert!((from as usize).is_multiple_of(PAGE) && (to as usize).is_multiple_of(PAGE));
            for at in (from as usize..to as usize).step_by(PAGE / 4) {
                self.change(at, &[0xFF; PAGE / 4])?;
                if self
                    .unreadable
                    .is_some_and(|word| (at..at + PAGE / 4).contains(&(8 * word)))
                {
                    self.unreadable = None;
                }
            }
            Ok(())
        }
        fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NoPower> {
            let at = offset as usize;
            assert!(at.is_multiple_of(8) && bytes.len().is_multiple_of(8));
            assert!(
                self.bytes[at..at + bytes.len()].iter().all(|b| *b == 0xFF),
                "only what is erased is written"
            );
            for (k, word) in bytes.chunks(8).enumerate() {
                self.change(at + 8 * k, word)?;
            }
            Ok(())
        }
    }

    fn load(flash: &Torn, version: u16) -> Option<Loaded> {
        Store::new(flash.clone(), version).load()
    }

    fn saved(flash: Torn, content: &[u8]) -> (Torn, Result<(), SaveError<NoPower>>) {
        let mut store = Store::new(flash, 3);
        let outcome = store.save(content);
        (store.flash, outcome)
    }

    #[test]
    fn what_was_saved_is_loaded_twice_and_only_with_its_version() {
        assert_eq!(load(&Torn::new(), 3), None);
        let (flash, outcome) = saved(Torn::new(), b"first");
        assert_eq!(outcome, Ok(()));
        let (flash, _) = saved(flash, b"second");
        let loaded = load(&flash, 3).unwrap();
        assert_eq!((&*loaded.content, loaded.twice), (&b"second"[..], true));
        assert_eq!(load(&flash, 4), None);
        for length in [0, CONTENT] {
            let (flash, outcome) = saved(Torn::new(), &vec![7; length]);
            assert_eq!(
                (outcome, load(&flash, 3).unwrap().content.len()),
                (Ok(()), length)
            );
        }
        let (_, outcome) = saved(Torn::new(), &[7; CONTENT + 1]);
        assert_eq!(outcome, Err(SaveError::TooLong));
    }

    #[test]
    fn power_that_goes_anywhere_leaves_the_old_content_or_the_new_one() {
        // two pages, each of 4 parts of an erasure and 16 double words
        let changes = 2 * (4 + 16);
        let mut both = [0; 2];
        for noise in 0..=255 {
            let (whole, _) = saved(Torn::new(), b"the old content");
            for cut in 1..=changes {
                let torn = Torn {
                    left: cut,
                    noise,
                    ..whole.clone()
                };
                let (mut flash, outcome) = saved(torn, b"something that is new");
                assert_eq!(outcome, Err(SaveError::Flash(NoPower)), "{cut}");
                let found = load(&flash, 3).unwrap_or_else(|| panic!("nothing: {cut} {noise}"));
                match &*found.content {
                    b"the old content" => both[0] += 1,
                    b"something that is new" => both[1] += 1,
                    other => panic!("{other:?} after {cut} changes, noise {noise}"),
                }
                // and what follows is as if nothing had happened
                flash.left = u32::MAX;
                let (flash, outcome) = saved(flash, b"the third");
                assert_eq!(outcome, Ok(()));
                let last = load(&flash, 3).unwrap();
                assert_eq!((&*last.content, last.twice), (&b"the third"[..], true));
            }
            let enough = Torn {
                left: changes + 1,
                noise,
                ..whole
            };
            assert_eq!(saved(enough, b"something that is new").1, Ok(()));
        }
        assert!(both.iter().all(|count| *count > 1000), "{both:?}");
    }

    #[test]
    fn a_copy_that_rots_is_told_and_the_other_is_taken() {
        let (whole, _) = saved(Torn::new(), b"content");
        for page in 0..2 {
            for byte in 0..HEADER + 7 {
                for bit in 0..8 {
                    let mut flash = whole.clone();
                    flash.bytes[page * PAGE + byte] ^= 1 << bit;
                    let loaded = load(&flash, 3).unwrap();
                    assert_eq!((&*loaded.content, loaded.twice), (&b"content"[..], false));
                }
            }
        }
    }

    #[test]
    fn the_newer_copy_is_taken_also_where_its_number_wraps_around() {
        for (old, new) in [(7, 8), (u32::MAX, 0), (u32::MAX - 1, u32::MAX)] {
            for page in 0..2 {
                let mut flash = Torn::new();
                let copies = [
                    record(3, old, b"old").unwrap(),
                    record(3, new, b"new").unwrap(),
                ];
                flash.bytes[page * PAGE..][..RECORD].copy_from_slice(&copies[1]);
                flash.bytes[(1 - page) * PAGE..][..RECORD].copy_from_slice(&copies[0]);
                let loaded = load(&flash, 3).unwrap();
                assert_eq!((&*loaded.content, loaded.twice), (&b"new"[..], false));
            }
        }
    }

    proptest! {
        #[test]
        fn no_bytes_are_too_strange(bytes in proptest::collection::vec(any::<u8>(), 2 * PAGE), length in any::<u16>()) {
            let mut flash = Torn { bytes, ..Torn::new() };
            // as good as it can be without being right
            flash.bytes[..4].copy_from_slice(&MAGIC.to_le_bytes());
            flash.bytes[4..6].copy_from_slice(&3_u16.to_le_bytes());
            flash.bytes[6..8].copy_from_slice(&length.to_le_bytes());
            prop_assert_eq!(load(&flash, 3), None);
            prop_assert_eq!(saved(flash, b"content").1, Ok(()));
        }
    }
}
