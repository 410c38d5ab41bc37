//! Names of the indices that have sub-indices, and what kind of object they are.

/// What kind of object an index with sub-indices is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// All sub-indices are of one kind.
    Array,
    /// Every sub-index is its own.
    Record,
}

impl Kind {
    /// The object code of CiA 301.
    #[must_use]
    pub const fn code(self) -> u8 {
        match self {
            Self::Array => 8,
            Self::Record => 9,
        }
    }
}

/// Indices `first` to `last` with sub-indices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Group {
    /// The first index.
    pub first: u16,
    /// The last index.
    pub last: u16,
    /// What kind.
    pub kind: Kind,
    /// Its name.
    pub name: &'static str,
}

const fn of(first: u16, last: u16, kind: Kind, name: &'static str) -> Group {
    Group {
        first,
        last,
        kind,
        name,
    }
}

/// Every index with sub-indices.
pub const GROUPS: [Group; 25] = [
    of(0x1003, 0x1003, Kind::Array, "Pre-defined error field"),
    of(0x1010, 0x1010, Kind::Array, "Store parameters"),
    of(0x1011, 0x1011, Kind::Array, "Restore default parameters"),
    of(0x1016, 0x1016, Kind::Array, "Consumer heartbeat time"),
    of(0x1018, 0x1018, Kind::Record, "Identity object"),
    of(0x1020, 0x1020, Kind::Array, "Verify configuration"),
    of(0x1029, 0x1029, Kind::Array, "Error behaviour"),
    of(0x1200, 0x1200, Kind::Record, "SDO server parameter"),
    of(0x1400, 0x1403, Kind::Record, "RPDO communication parameter"),
    of(0x1600, 0x1603, Kind::Record, "RPDO mapping parameter"),
    of(0x1800, 0x1803, Kind::Record, "TPDO communication parameter"),
    of(0x1A00, 0x1A03, Kind::Record, "TPDO mapping parameter"),
    of(0x1F50, 0x1F50, Kind::Array, "Program data"),
    of(0x1F51, 0x1F51, Kind::Array, "Program control"),
    of(
        0x1F56,
        0x1F56,
        Kind::Array,
        "Program software identification",
    ),
    of(0x1F57, 0x1F57, Kind::Array, "Flash status identification"),
    of(0x607D, 0x607D, Kind::Array, "Software position limit"),
    of(0x608F, 0x608F, Kind::Array, "Position encoder resolution"),
    of(0x6091, 0x6091, Kind::Array, "Gear ratio"),
    of(0x6092, 0x6092, Kind::Array, "Feed constant"),
    of(0x6099, 0x6099, Kind::Array, "Homing speeds"),
    of(0x60C2, 0x60C2, Kind::Record, "Interpolation time period"),
    of(0x60D0, 0x60D0, Kind::Array, "Touch probe source"),
    of(0x60E3, 0x60E3, Kind::Array, "Supported homing methods"),
    of(0x60FE, 0x60FE, Kind::Array, "Digital outputs"),
];

/// The group of an index, if it has sub-indices.
#[must_use]
pub fn group(index: u16) -> Option<&'static Group> {
    GROUPS
        .iter()
        .find(|group| (group.first..=group.last).contains(&index))
}
