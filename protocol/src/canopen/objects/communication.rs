//! Objects 1000 to 1FFF: communication.

use super::super::axis;
use super::super::node::Function;
use super::super::pdo::Entry;
use super::Access::{Constant, Read, Write};
use super::DataType::{U8, U16, U32};
use super::Mappable::{No, Transmit};
use super::{Object, index};

/// PDOs in each direction.
const PDOS: usize = 4;
/// Rows of one TPDO: count, identifier, type, inhibit time, event timer, SYNC start value; count and 8
/// entries. Those of an RPDO have neither inhibit time nor start value.
const ROWS: usize = 15;
const RPDO_ROWS: usize = PDOS * (ROWS - 2);
const TPDO_ROWS: usize = PDOS * ROWS;
const FIXED: usize = HEAD.len();
pub(super) const COUNT: usize = FIXED + RPDO_ROWS + TPDO_ROWS + TAIL.len();

const HEAD: [Object; 36] = [
    // Servo drive (0002) of profile 402 (0192).
    Object::number(0x1000, 0, "Device type", U32, Constant, No, 0x0002_0192),
    Object::number(0x1001, 0, "Error register", U8, Read, Transmit, 0),
    Object::number(0x1003, 0, "Number of errors", U8, Write, No, 0),
    Object::number(0x1003, 1, "Error, newest", U32, Read, No, 0),
    Object::number(0x1003, 2, "Error", U32, Read, No, 0),
    Object::number(0x1003, 3, "Error", U32, Read, No, 0),
    Object::number(0x1003, 4, "Error, oldest", U32, Read, No, 0),
    Object::number(0x1005, 0, "COB-ID SYNC message", U32, Write, No, 0x80),
    Object::number(
        0x1006,
        0,
        "Communication cycle period",
        U32,
        Write,
        No,
        2000,
    ),
    // 0: a set-point counts whenever it comes before the next SYNC.
    Object::number(0x1007, 0, "Synchronous window length", U32, Write, No, 0),
    Object::text(
        0x1008,
        "Manufacturer device name",
        "mrroc simulated servo drive",
    ),
    Object::text(0x1009, "Manufacturer hardware version", "simulated"),
    Object::text(
        0x100A,
        "Manufacturer software version",
        env!("CARGO_PKG_VERSION"),
    ),
    Object::count(0x1010, 1),
    Object::number(0x1010, 1, "Save all parameters", U32, Write, No, 1),
    Object::count(0x1011, 1),
    Object::number(
        0x1011,
        1,
        "Restore all default parameters",
        U32,
        Write,
        No,
        1,
    ),
    Object::plus_node(0x1014, 0, "COB-ID EMCY", Function::Emergency as u32, Write),
    Object::number(0x1015, 0, "Inhibit time EMCY", U16, Write, No, 0),
    Object::count(0x1016, 1),
    Object::number(0x1016, 1, "Consumer heartbeat time", U32, Write, No, 0),
    Object::number(0x1017, 0, "Producer heartbeat time", U16, Write, No, 100),
    Object::count(0x1018, 4),
    // No vendor number is assigned to this project: 0 says so.
    Object::number(0x1018, 1, "Vendor-ID", U32, Constant, No, 0),
    Object::number(0x1018, 2, "Product code", U32, Constant, No, 402),
    Object::number(0x1018, 3, "Revision number", U32, Constant, No, 0x0001_0000),
    Object::number(0x1018, 4, "Serial number", U32, Read, No, 0),
    Object::number(
        0x1019,
        0,
        "Synchronous counter overflow value",
        U8,
        Write,
        No,
        0,
    )
    .within(0, 240),
    Object::count(0x1020, 2),
    Object::number(0x1020, 1, "Configuration date", U32, Write, No, 0),
    Object::number(0x1020, 2, "Configuration time", U32, Write, No, 0),
    Object::count(0x1029, 1),
    // 1: keep the NMT state, so that the drive's answers to its own quick stop stay visible.
    Object::number(0x1029, 1, "Communication error", U8, Write, No, 1).within(0, 2),
    Object::count(0x1200, 2),
    Object::plus_node(
        0x1200,
        1,
        "COB-ID client to server",
        Function::SdoRequest as u32,
        Constant,
    ),
    Object::plus_node(
        0x1200,
        2,
        "COB-ID server to client",
        Function::SdoAnswer as u32,
        Constant,
    ),
];

/// Program download, CiA 302-3: after the PDOs.
const TAIL: [Object; 8] = [
    Object::count(0x1F50, 1),
    Object::domain(0x1F50, 1, "Program data"),
    Object::count(0x1F51, 1),
    // 1: the drive's own program runs.
    Object::number(0x1F51, 1, "Program control", U8, Write, No, 1).within(0, 3),
    Object::count(0x1F56, 1),
    Object::number(
        0x1F56,
        1,
        "Program software identification",
        U32,
        Read,
        No,
        0,
    ),
    Object::count(0x1F57, 1),
    Object::number(0x1F57, 1, "Flash status identification", U32, Read, No, 0),
];

/// The default identifiers of the PDOs; bit 30: no remote frames, bit 31: off.
const NO_REMOTE: u32 = 1 << 30;
const OFF: u32 = NO_REMOTE | 1 << 31;
const RPDO_COBS: [u32; PDOS] = [
    Function::Rpdo1 as u32 | NO_REMOTE,
    Function::Rpdo2 as u32 | NO_REMOTE,
    Function::Rpdo3 as u32 | OFF,
    Function::Rpdo4 as u32 | OFF,
];
const TPDO_COBS: [u32; PDOS] = [
    Function::Tpdo1 as u32 | NO_REMOTE,
    Function::Tpdo2 as u32 | NO_REMOTE,
    Function::Tpdo3 as u32 | OFF,
    Function::Tpdo4 as u32 | OFF,
];

pub(super) const TABLE: [Object; COUNT] = build();

#[expect(
    clippy::indexing_slicing,
    clippy::cast_possible_truncation,
    reason = "evaluated at compile time, with counts up to 4"
)]
const fn build() -> [Object; COUNT] {
    let mut table = [HEAD[0]; COUNT];
    let mut at = 0;
    while at < FIXED {
        table[at] = HEAD[at];
        at += 1;
    }
    let mut n = 0;
    while n < PDOS {
        let i = index::RPDO_COMMUNICATION + n as u16;
        table[at] = Object::count(i, 5);
        table[at + 1] = Object::plus_node(i, 1, "COB-ID used by RPDO", RPDO_COBS[n], Write);
        table[at + 2] = Object::number(i, 2, "Transmission type", U8, Write, No, 1);
        table[at + 3] = Object::number(i, 5, "Event timer", U16, Write, No, 0);
        at += 4;
        n += 1;
    }
    n = 0;
    while n < PDOS {
        let entries: &[Entry] = match n {
            0 => &axis::RPDO1_CSP,
            1 => &axis::RPDO2_CST,
            _ => &[],
        };
        at = mapping(&mut table, at, index::RPDO_MAPPING + n as u16, entries);
        n += 1;
    }
    n = 0;
    while n < PDOS {
        let i = index::TPDO_COMMUNICATION + n as u16;
        let (kind, inhibit) = if n == 1 { (255, 10) } else { (1, 0) };
        table[at] = Object::count(i, 6);
        table[at + 1] = Object::plus_node(i, 1, "COB-ID used by TPDO", TPDO_COBS[n], Write);
        table[at + 2] = Object::number(i, 2, "Transmission type", U8, Write, No, kind);
        table[at + 3] = Object::number(i, 3, "Inhibit time", U16, Write, No, inhibit);
        table[at + 4] = Object::number(i, 5, "Event timer", U16, Write, No, 0);
        table[at + 5] = Object::number(i, 6, "SYNC start value", U8, Write, No, 0).within(0, 240);
        at += 6;
        n += 1;
    }
    n = 0;
    while n < PDOS {
        let entries: &[Entry] = match n {
            0 => &axis::TPDO1,
            1 => &axis::TPDO2,
            _ => &[],
        };
        at = mapping(&mut table, at, index::TPDO_MAPPING + n as u16, entries);
        n += 1;
    }
    n = 0;
    while n < TAIL.len() {
        table[at + n] = TAIL[n];
        n += 1;
    }
    table
}

/// Writes the rows of one mapping object; the place after them.
#[expect(
    clippy::indexing_slicing,
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    reason = "evaluated at compile time, with counts up to 8"
)]
const fn mapping(
    table: &mut [Object; COUNT],
    mut at: usize,
    index: u16,
    entries: &[Entry],
) -> usize {
    let count = entries.len() as i64;
    table[at] =
        Object::number(index, 0, "Number of mapped objects", U8, Write, No, count).within(0, 8);
    at += 1;
    let mut n = 0;
    while n < 8 {
        let entry = if n < entries.len() {
            entries[n].0 as i64
        } else {
            0
        };
        let sub = n as u8 + 1;
        table[at] = Object::number(index, sub, "Mapped object", U32, Write, No, entry);
        at += 1;
        n += 1;
    }
    at
}
