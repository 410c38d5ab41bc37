//! Two slots and the log of decisions on one flash.
//!
//! ```text
//!  slot    │ header page │ image … │          the header is written when the image is whole
//!  log     │ page │ page │                    records one behind the other; a full page is followed by the other,
//!                                             erased before: the last record is never in the page that is erased
//! ```

use super::boot::{self, Choice, RECORD, Record};
use super::image::{self, CRC, HEADER};
use embedded_storage::nor_flash::NorFlash;
use protocol::maintenance::{IMAGE_CHUNK, ImageHeader, MaintenanceRefusal, Slot};

/// Where everything is, bytes from the beginning of the flash; every number is a multiple of its page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Slot A.
    pub slot_a: u32,
    /// Slot B.
    pub slot_b: u32,
    /// The length of either, header page included.
    pub slot: u32,
    /// The two pages of the log.
    pub log: [u32; 2],
}

/// The flash does not go with the layout, or with this module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LayoutError {
    /// Something is not at the beginning of a page, or a slot is no whole number of pages of at least two.
    Alignment,
    /// Something reaches beyond the flash.
    Capacity,
    /// Two parts have a page in common.
    Overlap,
    /// A page is no multiple of a chunk, or a record or chunk no multiple of what can be written.
    Geometry,
}

impl core::fmt::Display for LayoutError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Alignment => "a part of the layout is no whole number of pages",
            Self::Capacity => "a part of the layout is beyond the flash",
            Self::Overlap => "two parts of the layout have a page in common",
            Self::Geometry => "the pages or the write size of this flash are not supported",
        })
    }
}

impl core::error::Error for LayoutError {}

/// Bytes read at a time.
const WINDOW: usize = IMAGE_CHUNK;

/// Slots and log on a flash.
#[derive(Debug)]
pub struct Slots<F> {
    flash: F,
    layout: Layout,
}

/// Whatever the flash says.
fn storage<E>(_: E) -> MaintenanceRefusal {
    MaintenanceRefusal::Storage
}

fn size(bytes: usize) -> u32 {
    u32::try_from(bytes).unwrap_or(u32::MAX)
}

impl<F: NorFlash> Slots<F> {
    /// # Errors
    /// [`LayoutError`]
    pub fn new(flash: F, layout: Layout) -> Result<Self, LayoutError> {
        let page = F::ERASE_SIZE;
        let fits = |part: usize| F::WRITE_SIZE > 0 && part.is_multiple_of(F::WRITE_SIZE);
        let whole =
            page > 0 && page.is_multiple_of(IMAGE_CHUNK) && WINDOW.is_multiple_of(F::READ_SIZE);
        if !whole
            || !fits(RECORD)
            || !fits(IMAGE_CHUNK)
            || !fits(HEADER)
            || !RECORD.is_multiple_of(F::READ_SIZE)
        {
            return Err(LayoutError::Geometry);
        }
        let page = size(page);
        let Layout {
            slot_a,
            slot_b,
            slot,
            log: [first, second],
        } = layout;
        if slot < page.saturating_mul(2)
            || ![slot_a, slot_b, slot, first, second]
                .iter()
                .all(|number| number.is_multiple_of(page))
        {
            return Err(LayoutError::Alignment);
        }
        let parts = [
            (slot_a, slot),
            (slot_b, slot),
            (first, page),
            (second, page),
        ];
        let capacity = size(flash.capacity());
        for (k, (begin, length)) in parts.iter().enumerate() {
            let end = begin.checked_add(*length).filter(|end| *end <= capacity);
            let end = end.ok_or(LayoutError::Capacity)?;
            for (other, other_length) in parts.iter().skip(k.saturating_add(1)) {
                if *other < end && *begin < other.saturating_add(*other_length) {
                    return Err(LayoutError::Overlap);
                }
            }
        }
        Ok(Self { flash, layout })
    }

    /// The flash back.
    #[must_use]
    pub fn into_flash(self) -> F {
        self.flash
    }

    /// The longest image, bytes.
    #[must_use]
    pub const fn capacity(&self) -> u32 {
        self.layout.slot.saturating_sub(page::<F>())
    }

    const fn begin(&self, slot: Slot) -> u32 {
        match slot {
            Slot::A => self.layout.slot_a,
            Slot::B => self.layout.slot_b,
        }
    }

    const fn payload(&self, slot: Slot) -> u32 {
        self.begin(slot).saturating_add(page::<F>())
    }

    /// Where the page of a part of an image begins, bytes in the image.
    pub const fn page_start(&self, offset: u32) -> u32 {
        match offset.checked_rem(page::<F>()) {
            Some(within) => offset.saturating_sub(within),
            None => offset,
        }
    }

    /// The header of a slot, if it has one. Says nothing of the image behind it.
    pub fn header(&mut self, slot: Slot) -> Option<ImageHeader> {
        let mut bytes = [0; HEADER];
        self.flash.read(self.begin(slot), &mut bytes).ok()?;
        let header = image::read(&bytes).ok()?;
        (header.length <= self.capacity()).then_some(header)
    }

    /// CRC-32 of the first `length` bytes of a slot's image.
    ///
    /// # Errors
    /// The flash cannot be read.
    pub fn crc(&mut self, slot: Slot, length: u32) -> Result<u32, MaintenanceRefusal> {
        let mut digest = CRC.digest();
        let mut window = [0; WINDOW];
        // at most as many times as a slot has windows
        for at in (0..length).step_by(WINDOW) {
            let from = self.payload(slot).saturating_add(at);
            self.flash.read(from, &mut window).map_err(storage)?;
            let left = usize::try_from(length.saturating_sub(at)).unwrap_or(0);
            digest.update(window.get(..left).unwrap_or(&window));
        }
        Ok(digest.finalize())
    }

    /// Is the image of this slot as its header says?
    pub fn whole(&mut self, slot: Slot) -> bool {
        match self.header(slot) {
            Some(header) => self.crc(slot, header.length) == Ok(header.crc),
            None => false,
        }
    }

    /// Decides what starts, and writes down that it was decided: all that a bootloader must do before it jumps.
    ///
    /// # Errors
    /// What was decided could not be written; then a trial must not be started.
    pub fn start(&mut self) -> Result<Choice, MaintenanceRefusal> {
        let record = self.last().map(|last| last.record);
        let whole = [self.whole(Slot::A), self.whole(Slot::B)];
        let choice = boot::choose(record, whole);
        if let Some(record) = choice.write {
            self.append(record)?;
        }
        Ok(choice)
    }

    /// The slot has no image any more.
    ///
    /// # Errors
    /// The flash cannot be erased.
    pub fn invalidate(&mut self, slot: Slot) -> Result<(), MaintenanceRefusal> {
        self.erase(self.begin(slot))
    }

    fn erase(&mut self, from: u32) -> Result<(), MaintenanceRefusal> {
        let to = from.saturating_add(page::<F>());
        self.flash.erase(from, to).map_err(storage)
    }

    /// Writes a chunk of an image, or its last part; the first of a page erases the page.
    ///
    /// # Errors
    /// The flash does not hold what was written.
    pub fn write(
        &mut self,
        slot: Slot,
        offset: u32,
        bytes: &[u8],
    ) -> Result<(), MaintenanceRefusal> {
        let at = self.payload(slot).saturating_add(offset);
        if self.page_start(offset) == offset {
            self.erase(at)?;
        }
        let mut chunk = [0xFF; IMAGE_CHUNK];
        image::put(&mut chunk, 0, bytes);
        let writable = bytes.len().checked_next_multiple_of(F::WRITE_SIZE);
        let chunk = writable.and_then(|length| chunk.get(..length));
        let chunk = chunk.ok_or(MaintenanceRefusal::Storage)?;
        self.flash.write(at, chunk).map_err(storage)?;
        if self.holds(slot, offset, bytes)? {
            Ok(())
        } else {
            Err(MaintenanceRefusal::Storage)
        }
    }

    /// Does the slot hold these bytes there?
    ///
    /// # Errors
    /// The flash cannot be read.
    pub fn holds(
        &mut self,
        slot: Slot,
        offset: u32,
        bytes: &[u8],
    ) -> Result<bool, MaintenanceRefusal> {
        let mut window = [0; WINDOW];
        let at = self.payload(slot).saturating_add(offset);
        self.flash.read(at, &mut window).map_err(storage)?;
        Ok(window.get(..bytes.len()) == Some(bytes))
    }

    /// Writes the header: from now on the slot is valid.
    ///
    /// # Errors
    /// The flash does not hold what was written.
    pub fn validate(&mut self, slot: Slot, header: &ImageHeader) -> Result<(), MaintenanceRefusal> {
        self.invalidate(slot)?;
        let bytes = image::write(header);
        self.flash
            .write(self.begin(slot), &bytes)
            .map_err(storage)?;
        if self.header(slot).as_ref() == Some(header) {
            Ok(())
        } else {
            Err(MaintenanceRefusal::Storage)
        }
    }

    fn record(&mut self, at: u32) -> Option<[u8; RECORD]> {
        let mut bytes = [0; RECORD];
        self.flash.read(at, &mut bytes).ok()?;
        Some(bytes)
    }

    /// The last record of the log.
    pub fn last(&mut self) -> Option<Last> {
        let mut last: Option<Last> = None;
        for (page_number, begin) in self.layout.log.into_iter().enumerate() {
            for at in places::<F>(begin) {
                let read = self.record(at).and_then(|bytes| boot::read(&bytes));
                let Some((number, record)) = read else {
                    continue;
                };
                if last.is_none_or(|last| last.number < number) {
                    last = Some(Last {
                        number,
                        record,
                        page: page_number,
                    });
                }
            }
        }
        last
    }

    /// Writes a record behind the last one.
    ///
    /// # Errors
    /// The flash does not hold it.
    pub fn append(&mut self, record: Record) -> Result<(), MaintenanceRefusal> {
        let last = self.last();
        let number = last.map_or(1, |last| last.number.saturating_add(1));
        let page_number = last.map_or(0, |last| last.page);
        let [first, second] = self.layout.log;
        let (this, that) = if page_number == 0 {
            (first, second)
        } else {
            (second, first)
        };
        // behind everything that is not erased, whatever it is: a record that was torn is in the way for good
        let mut free = None;
        for at in places::<F>(this) {
            match self.record(at) {
                Some(bytes) if bytes == [0xFF; RECORD] => {
                    free.get_or_insert(at);
                }
                _ => free = None,
            }
        }
        let at = if let Some(at) = free {
            at
        } else {
            self.erase(that)?;
            that
        };
        let bytes = boot::write(number, record);
        self.flash.write(at, &bytes).map_err(storage)?;
        if self.record(at) == Some(bytes) {
            Ok(())
        } else {
            Err(MaintenanceRefusal::Storage)
        }
    }
}

/// The last record, and where it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Last {
    /// Its number, counted from 1.
    pub number: u32,
    /// What it says.
    pub record: Record,
    /// The page of the log it is in.
    pub page: usize,
}

/// A page, as addresses count.
#[expect(
    clippy::cast_possible_truncation,
    reason = "addresses of a flash have 32 bits"
)]
const fn page<F: NorFlash>() -> u32 {
    F::ERASE_SIZE as u32
}

/// Where records can be in a page of the log.
fn places<F: NorFlash>(begin: u32) -> impl Iterator<Item = u32> {
    (begin..begin.saturating_add(page::<F>())).step_by(RECORD)
}
