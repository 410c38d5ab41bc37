//! Mapping: which objects a PDO carries, in which order.

use heapless::Vec;

use super::super::sdo::Address;

/// The most objects one PDO carries: eight bytes of one byte each.
pub const MAX_ENTRIES: usize = 8;

/// One mapped object: index, sub-index, length in bits, as in objects 1600 and 1A00.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry(pub u32);

impl Entry {
    /// The object `index`, sub-index `sub`, `bits` long.
    #[must_use]
    pub const fn new(index: u16, sub: u8, bits: u8) -> Self {
        Self((index as u32) << 16 | (sub as u32) << 8 | bits as u32)
    }

    /// The object.
    #[must_use]
    pub const fn address(self) -> Address {
        let [_, sub, low, high] = self.0.to_le_bytes();
        Address::new(u16::from_le_bytes([low, high]), sub)
    }

    /// Length in bits.
    #[must_use]
    pub const fn bits(self) -> u8 {
        let [bits, ..] = self.0.to_le_bytes();
        bits
    }

    /// Is it a gap: one of the data-type objects 0001 to 0007, whose value is thrown away?
    #[must_use]
    pub const fn is_dummy(self) -> bool {
        matches!(self.address().index, 1..=7)
    }
}

/// Why a mapping is invalid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MappingError {
    /// More than [`MAX_ENTRIES`] objects.
    TooMany,
    /// An entry of no bits, or of more than 64.
    Bits,
    /// Together longer than 8 bytes.
    TooLong,
}

/// The bytes of a PDO.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Payload {
    bytes: [u8; 8],
    len: u8,
}

impl Payload {
    /// The first 8 of `data`; `None` if there are more.
    #[must_use]
    pub fn new(data: &[u8]) -> Option<Self> {
        let mut bytes = [0; 8];
        bytes.get_mut(..data.len())?.copy_from_slice(data);
        Some(Self {
            bytes,
            len: u8::try_from(data.len()).ok()?,
        })
    }

    /// The bytes.
    #[must_use]
    pub fn data(&self) -> &[u8] {
        self.bytes.get(..usize::from(self.len)).unwrap_or_default()
    }

    /// The same without its last byte: what a drive with a wrong mapping would send.
    #[must_use]
    pub const fn shortened(self) -> Self {
        Self {
            len: self.len.saturating_sub(1),
            ..self
        }
    }

    /// The frame on identifier `cob`.
    #[must_use]
    pub fn frame(&self, cob: u16) -> crate::frame::Frame {
        let id = crate::frame::Id::Standard(cob & 0x7FF);
        crate::frame::Frame::short(id, self.bytes, self.len)
    }
}

/// The mapping of one PDO: at most [`MAX_ENTRIES`] objects, at most 8 bytes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Mapping {
    entries: Vec<Entry, MAX_ENTRIES>,
    len: u8,
}

impl Mapping {
    /// Checks and keeps `entries`.
    ///
    /// # Errors
    /// [`MappingError`].
    pub fn new(entries: &[Entry]) -> Result<Self, MappingError> {
        let mut bits = 0_u32;
        for entry in entries {
            if !(1..=64).contains(&entry.bits()) {
                return Err(MappingError::Bits);
            }
            bits = bits.saturating_add(u32::from(entry.bits()));
        }
        if bits > 64 {
            return Err(MappingError::TooLong);
        }
        let entries = Vec::from_slice(entries).map_err(|_| MappingError::TooMany)?;
        let len = u8::try_from(bits.div_ceil(8)).unwrap_or(8);
        Ok(Self { entries, len })
    }

    /// The mapped objects.
    #[must_use]
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// Length of the PDO in bytes.
    #[must_use]
    pub fn len(&self) -> usize {
        usize::from(self.len)
    }

    /// Is nothing mapped?
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Packs the values `read` gives, in mapping order, lowest bit first. Bits of a value beyond
    /// the entry's length are cut off; gaps are zero.
    #[must_use]
    pub fn pack(&self, mut read: impl FnMut(Entry) -> u64) -> Payload {
        let (mut word, mut at) = (0_u64, 0_u32);
        for entry in &self.entries {
            let value = if entry.is_dummy() { 0 } else { read(*entry) };
            let value = value & mask(entry.bits());
            word |= value.checked_shl(at).unwrap_or(0);
            at = at.saturating_add(u32::from(entry.bits()));
        }
        Payload {
            bytes: word.to_le_bytes(),
            len: self.len,
        }
    }

    /// Hands the values of `data` to `write`, in mapping order; gaps are left out. Bytes beyond
    /// the mapping are ignored.
    ///
    /// # Errors
    /// [`MappingError::TooLong`] if `data` is shorter than the mapping or no PDO; nothing was
    /// written.
    pub fn unpack(
        &self,
        data: &[u8],
        mut write: impl FnMut(Entry, u64),
    ) -> Result<(), MappingError> {
        if data.len() < self.len() {
            return Err(MappingError::TooLong);
        }
        let payload = Payload::new(data).ok_or(MappingError::TooLong)?;
        let word = u64::from_le_bytes(payload.bytes);
        let mut at = 0_u32;
        for entry in &self.entries {
            let value = word.checked_shr(at).unwrap_or(0) & mask(entry.bits());
            if !entry.is_dummy() {
                write(*entry, value);
            }
            at = at.saturating_add(u32::from(entry.bits()));
        }
        Ok(())
    }
}

const fn mask(bits: u8) -> u64 {
    if bits >= 64 {
        u64::MAX
    } else {
        (1 << bits) - 1
    }
}
