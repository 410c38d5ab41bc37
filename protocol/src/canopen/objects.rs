//! The object dictionary of the drive: indices, types, access, defaults.

mod communication;
pub mod eds;
mod group;
pub mod index;
pub mod markdown;
mod profile;

pub use group::{GROUPS, Group, Kind, group};

use super::sdo::Address;

/// The number of objects in [`TABLE`].
pub const COUNT: usize = communication::COUNT + profile::COUNT;

/// Every object of the drive, ascending by index and sub-index.
pub static TABLE: [Object; COUNT] = join(&communication::TABLE, &profile::TABLE);

/// How an object is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DataType {
    /// INTEGER8.
    I8,
    /// INTEGER16.
    I16,
    /// INTEGER32.
    I32,
    /// UNSIGNED8.
    U8,
    /// UNSIGNED16.
    U16,
    /// UNSIGNED32.
    U32,
    /// `VISIBLE_STRING`.
    Text,
    /// `DOMAIN`: any number of bytes.
    Domain,
}

impl DataType {
    /// The type's number in the object dictionary and in EDS files.
    #[must_use]
    pub const fn code(self) -> u16 {
        match self {
            Self::I8 => 2,
            Self::I16 => 3,
            Self::I32 => 4,
            Self::U8 => 5,
            Self::U16 => 6,
            Self::U32 => 7,
            Self::Text => 9,
            Self::Domain => 15,
        }
    }

    /// Length in bytes, `None` for text and domains.
    #[must_use]
    pub const fn size(self) -> Option<usize> {
        Some(match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 => 4,
            Self::Text | Self::Domain => return None,
        })
    }

    /// Are negative numbers stored in two's complement?
    #[must_use]
    pub const fn is_signed(self) -> bool {
        matches!(self, Self::I8 | Self::I16 | Self::I32)
    }
}

/// Who may do what.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Access {
    /// Never changes.
    Constant,
    /// Read only.
    Read,
    /// Read and written.
    Write,
}

/// Into which PDO an object can be mapped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Mappable {
    /// None.
    No,
    /// TPDO.
    Transmit,
    /// RPDO and TPDO.
    Both,
}

/// The value after a reset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Initial {
    /// A number.
    Number(i64),
    /// A number plus the node identifier (`$NODEID` in an EDS file).
    PlusNode(u32),
    /// A text.
    Text(&'static str),
}

/// One object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Object {
    /// Where.
    pub at: Address,
    /// Its name, as in an EDS file.
    pub name: &'static str,
    /// How it is stored.
    pub data_type: DataType,
    /// Who may do what.
    pub access: Access,
    /// Into which PDO it can be mapped.
    pub mappable: Mappable,
    /// The value after a reset.
    pub initial: Initial,
    /// The least and the greatest value, where the type alone does not say it.
    pub limits: Option<(i32, u32)>,
}

impl Object {
    /// The same with a least and a greatest value.
    const fn within(mut self, low: i32, high: u32) -> Self {
        self.limits = Some((low, high));
        self
    }

    const fn number(
        index: u16,
        sub: u8,
        name: &'static str,
        data_type: DataType,
        access: Access,
        mappable: Mappable,
        initial: i64,
    ) -> Self {
        let initial = Initial::Number(initial);
        Self {
            at: Address::new(index, sub),
            name,
            data_type,
            access,
            mappable,
            initial,
            limits: None,
        }
    }

    const fn count(index: u16, highest: i64) -> Self {
        let name = "Highest sub-index supported";
        Self::number(
            index,
            0,
            name,
            DataType::U8,
            Access::Constant,
            Mappable::No,
            highest,
        )
    }

    const fn text(index: u16, name: &'static str, text: &'static str) -> Self {
        Self {
            at: Address::new(index, 0),
            name,
            data_type: DataType::Text,
            access: Access::Constant,
            mappable: Mappable::No,
            initial: Initial::Text(text),
            limits: None,
        }
    }

    const fn note(index: u16, name: &'static str) -> Self {
        Self {
            access: Access::Write,
            ..Self::text(index, name, "")
        }
    }

    const fn domain(index: u16, sub: u8, name: &'static str) -> Self {
        Self {
            at: Address::new(index, sub),
            data_type: DataType::Domain,
            ..Self::note(index, name)
        }
    }

    const fn plus_node(index: u16, sub: u8, name: &'static str, base: u32, access: Access) -> Self {
        Self {
            at: Address::new(index, sub),
            name,
            data_type: DataType::U32,
            access,
            mappable: Mappable::No,
            initial: Initial::PlusNode(base),
            limits: None,
        }
    }
}

/// The place of an object in [`TABLE`].
#[must_use]
pub fn find(at: Address) -> Option<usize> {
    let mut probe = hash(at);
    // The table of places is never full: the walk ends at an empty slot at the latest.
    loop {
        let place = usize::from(*PLACES.get(probe)?);
        match TABLE.get(place) {
            Some(object) if object.at.index == at.index && object.at.sub == at.sub => {
                return Some(place);
            }
            Some(_) => probe = (probe + 1) % SLOTS,
            None => return None,
        }
    }
}

/// Slots of [`PLACES`]: at least two for each object, so that walks are short.
const SLOTS: usize = 1024;
/// No object's place.
const EMPTY: u16 = u16::MAX;
const _: () = assert!(COUNT * 2 < SLOTS && COUNT < EMPTY as usize);

/// Where the walk for an object begins: Fibonacci hashing of index and sub-index.
const fn hash(at: Address) -> usize {
    let key = (at.index as u32) << 8 | at.sub as u32;
    (key.wrapping_mul(0x9E37_79B9) >> 22) as usize % SLOTS
}

/// The places of the objects by the hash of their address, with linear probing: every process data
/// object is looked up every cycle, and a binary search through the whole table was a tenth of the
/// simulation's time.
#[expect(
    clippy::indexing_slicing,
    clippy::cast_possible_truncation,
    reason = "evaluated at compile time, where both are checked"
)]
static PLACES: [u16; SLOTS] = {
    let mut places = [EMPTY; SLOTS];
    let mut place = 0;
    while place < COUNT {
        let mut probe = hash(TABLE[place].at);
        while places[probe] != EMPTY {
            probe = (probe + 1) % SLOTS;
        }
        places[probe] = place as u16;
        place += 1;
    }
    places
};

/// Does any object have this index?
#[must_use]
pub fn has_index(index: u16) -> bool {
    let at = TABLE.partition_point(|object| object.at.index < index);
    TABLE.get(at).is_some_and(|object| object.at.index == index)
}

/// The place of an object that must be in [`TABLE`]: for constants, where a missing object is a
/// compile error.
///
/// # Panics
/// If there is no such object.
#[must_use]
#[expect(
    clippy::indexing_slicing,
    clippy::panic,
    reason = "evaluated at compile time, where both are errors"
)]
pub const fn slot(index: u16, sub: u8) -> usize {
    let mut at = 0;
    while at < COUNT {
        if TABLE[at].at.index == index && TABLE[at].at.sub == sub {
            return at;
        }
        at += 1;
    }
    panic!("no such object")
}

#[expect(
    clippy::indexing_slicing,
    reason = "evaluated at compile time, where it is an error"
)]
const fn join<const A: usize, const B: usize>(a: &[Object; A], b: &[Object; B]) -> [Object; COUNT] {
    let mut table = [a[0]; COUNT];
    let mut at = 0;
    while at < A + B {
        table[at] = if at < A { a[at] } else { b[at - A] };
        at += 1;
    }
    table
}

#[cfg(test)]
mod tests;
