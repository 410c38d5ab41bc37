//! Objects 2000 to 67FF: one of the maker, and the drive profile CiA 402.
//!
//! Defaults that depend on the motor (rated current and torque, scaling, decelerations) are those
//! of a 4000-increment axis; the drive replaces them by its own at power-up.

use super::super::cia402::{HomingMethod, SUPPORTED_MODES};
use super::Access::{Constant, Read, Write};
use super::DataType::{I8, I16, I32, U8, U16, U32};
use super::Mappable::{Both, No, Transmit};
use super::Object;

pub(super) const COUNT: usize = 99;

const METHODS: i64 = 9;
const _: () = assert!(HomingMethod::ALL.len() == 9);

pub(super) const TABLE: [Object; COUNT] = [
    Object::note(0x2000, "Commissioning note"),
    Object::number(0x2010, 0, "Slot in the fast profile", U8, Write, No, 0).within(0, 15),
    Object::number(0x6007, 0, "Abort connection option code", I16, Write, No, 3).within(0, 3),
    Object::number(0x603F, 0, "Error code", U16, Read, Transmit, 0),
    Object::number(0x6040, 0, "Controlword", U16, Write, Both, 0),
    Object::number(0x6041, 0, "Statusword", U16, Read, Transmit, 0),
    Object::number(0x605A, 0, "Quick stop option code", I16, Write, No, 2).within(0, 8),
    Object::number(0x605B, 0, "Shutdown option code", I16, Write, No, 0).within(0, 1),
    Object::number(
        0x605C,
        0,
        "Disable operation option code",
        I16,
        Write,
        No,
        1,
    )
    .within(0, 1),
    Object::number(0x605D, 0, "Halt option code", I16, Write, No, 1).within(1, 4),
    Object::number(0x605E, 0, "Fault reaction option code", I16, Write, No, 2).within(0, 4),
    Object::number(0x6060, 0, "Modes of operation", I8, Write, Both, 0).within(0, 10),
    Object::number(
        0x6061,
        0,
        "Modes of operation display",
        I8,
        Read,
        Transmit,
        0,
    ),
    Object::number(0x6062, 0, "Position demand value", I32, Read, Transmit, 0),
    Object::number(0x6064, 0, "Position actual value", I32, Read, Transmit, 0),
    // 1000 increments: the position-error trip of the robots' 2017 launch files.
    Object::number(
        0x6065,
        0,
        "Following error window",
        U32,
        Write,
        No,
        1_000_000,
    ),
    Object::number(0x6066, 0, "Following error time out", U16, Write, No, 10),
    // ASSUMED: 10 increments for 5 ms.
    Object::number(0x6067, 0, "Position window", U32, Write, No, 10_000),
    Object::number(0x6068, 0, "Position window time", U16, Write, No, 5),
    Object::number(0x606B, 0, "Velocity demand value", I32, Read, Transmit, 0),
    Object::number(0x606C, 0, "Velocity actual value", I32, Read, Transmit, 0),
    // ASSUMED: all that 16 bits hold, 0.1 rad/s; for 5 ms, and at once.
    Object::number(0x606D, 0, "Velocity window", U16, Write, No, 65_535),
    Object::number(0x606E, 0, "Velocity window time", U16, Write, No, 5),
    Object::number(0x606F, 0, "Velocity threshold", U16, Write, No, 65_535),
    Object::number(0x6070, 0, "Velocity threshold time", U16, Write, No, 0),
    Object::number(0x6071, 0, "Target torque", I16, Write, Both, 0),
    Object::number(0x6072, 0, "Max torque", U16, Write, Both, 4000),
    Object::number(0x6075, 0, "Motor rated current", U32, Read, No, 5000),
    Object::number(0x6076, 0, "Motor rated torque", U32, Read, No, 525),
    Object::number(0x6077, 0, "Torque actual value", I16, Read, Transmit, 0),
    Object::number(0x6078, 0, "Current actual value", I16, Read, Transmit, 0),
    Object::number(
        0x6079,
        0,
        "DC link circuit voltage",
        U32,
        Read,
        Transmit,
        48_000,
    ),
    Object::number(0x607A, 0, "Target position", I32, Write, Both, 0),
    Object::number(0x607C, 0, "Home offset", I32, Write, No, 0),
    Object::count(0x607D, 2),
    // Both zero: no software limits in the drive; the node has them.
    Object::number(0x607D, 1, "Min position limit", I32, Write, No, 0),
    Object::number(0x607D, 2, "Max position limit", I32, Write, No, 0),
    // 250 rad/s.
    Object::number(
        0x607F,
        0,
        "Max profile velocity",
        U32,
        Write,
        No,
        159_154_943,
    ),
    // 250 rad/s, MRROC++'s greatest motor velocity (0.5 rad in 2 ms).
    Object::number(0x6080, 0, "Max motor speed", U32, Write, No, 2387),
    // ASSUMED: 50 rad/s, reached at 200 rad/s².
    Object::number(0x6081, 0, "Profile velocity", U32, Write, Both, 31_830_989)
        .within(1, 0xFFFF_FFFF),
    Object::number(
        0x6083,
        0,
        "Profile acceleration",
        U32,
        Write,
        No,
        127_323_954,
    )
    .within(1, 0xFFFF_FFFF),
    Object::number(
        0x6084,
        0,
        "Profile deceleration",
        U32,
        Write,
        No,
        127_323_954,
    )
    .within(1, 0xFFFF_FFFF),
    Object::number(
        0x6085,
        0,
        "Quick stop deceleration",
        U32,
        Write,
        No,
        318_309_886,
    )
    .within(1, 0xFFFF_FFFF),
    Object::number(0x6086, 0, "Motion profile type", I16, Write, No, 0).within(0, 0),
    Object::count(0x608F, 2),
    Object::number(0x608F, 1, "Encoder increments", U32, Write, No, 4000).within(1, 0xFFFF_FFFF),
    Object::number(0x608F, 2, "Motor revolutions", U32, Write, No, 1).within(1, 0xFFFF_FFFF),
    Object::count(0x6091, 2),
    Object::number(0x6091, 1, "Motor revolutions", U32, Write, No, 1).within(1, 0xFFFF_FFFF),
    Object::number(0x6091, 2, "Shaft revolutions", U32, Write, No, 1).within(1, 0xFFFF_FFFF),
    Object::count(0x6092, 2),
    Object::number(0x6092, 1, "Feed", U32, Write, No, 4_000_000).within(1, 0xFFFF_FFFF),
    Object::number(0x6092, 2, "Shaft revolutions", U32, Write, No, 1).within(1, 0xFFFF_FFFF),
    Object::number(0x6098, 0, "Homing method", I8, Write, No, 37),
    Object::count(0x6099, 2),
    // 15 and 3.5 rad/s: MRROC++'s coarse and fine synchronisation speeds.
    Object::number(
        0x6099,
        1,
        "Speed during search for switch",
        U32,
        Write,
        No,
        9_549_297,
    )
    .within(1, 0xFFFF_FFFF),
    Object::number(
        0x6099,
        2,
        "Speed during search for zero",
        U32,
        Write,
        No,
        2_228_169,
    )
    .within(1, 0xFFFF_FFFF),
    Object::number(0x609A, 0, "Homing acceleration", U32, Write, No, 63_661_977)
        .within(1, 0xFFFF_FFFF),
    Object::number(0x60B0, 0, "Position offset", I32, Write, Both, 0),
    Object::number(0x60B1, 0, "Velocity offset", I32, Write, Both, 0),
    Object::number(0x60B2, 0, "Torque offset", I16, Write, Both, 0),
    Object::number(0x60B8, 0, "Touch probe function", U16, Write, Both, 0),
    Object::number(0x60B9, 0, "Touch probe status", U16, Read, Transmit, 0),
    Object::number(
        0x60BA,
        0,
        "Touch probe 1 positive edge",
        I32,
        Read,
        Transmit,
        0,
    ),
    Object::number(
        0x60BB,
        0,
        "Touch probe 1 negative edge",
        I32,
        Read,
        Transmit,
        0,
    ),
    Object::number(
        0x60BC,
        0,
        "Touch probe 2 positive edge",
        I32,
        Read,
        Transmit,
        0,
    ),
    Object::number(
        0x60BD,
        0,
        "Touch probe 2 negative edge",
        I32,
        Read,
        Transmit,
        0,
    ),
    Object::count(0x60C2, 2),
    Object::number(
        0x60C2,
        1,
        "Interpolation time period value",
        U8,
        Write,
        No,
        2,
    )
    .within(1, 255),
    Object::number(0x60C2, 2, "Interpolation time index", I8, Write, No, -3).within(-6, 0),
    Object::count(0x60D0, 2),
    // 1, 2: probe inputs; 5: zero impulse; -1: home switch; -2, -3: limit switches.
    Object::number(0x60D0, 1, "Touch probe 1 source", I16, Write, No, 1).within(-3, 5),
    Object::number(0x60D0, 2, "Touch probe 2 source", I16, Write, No, 2).within(-3, 5),
    // ns of the drive's own clock, modulo 2^32
    Object::number(
        0x60D1,
        0,
        "Touch probe 1 positive edge time stamp",
        U32,
        Read,
        Transmit,
        0,
    ),
    Object::number(
        0x60D2,
        0,
        "Touch probe 1 negative edge time stamp",
        U32,
        Read,
        Transmit,
        0,
    ),
    Object::number(
        0x60D3,
        0,
        "Touch probe 2 positive edge time stamp",
        U32,
        Read,
        Transmit,
        0,
    ),
    Object::number(
        0x60D4,
        0,
        "Touch probe 2 negative edge time stamp",
        U32,
        Read,
        Transmit,
        0,
    ),
    Object::number(
        0x60D5,
        0,
        "Touch probe 1 positive edge counter",
        U16,
        Read,
        Transmit,
        0,
    ),
    Object::number(
        0x60D6,
        0,
        "Touch probe 1 negative edge counter",
        U16,
        Read,
        Transmit,
        0,
    ),
    Object::number(
        0x60D7,
        0,
        "Touch probe 2 positive edge counter",
        U16,
        Read,
        Transmit,
        0,
    ),
    Object::number(
        0x60D8,
        0,
        "Touch probe 2 negative edge counter",
        U16,
        Read,
        Transmit,
        0,
    ),
    Object::count(0x60E3, METHODS),
    method(1),
    method(2),
    method(3),
    method(4),
    method(5),
    method(6),
    method(7),
    method(8),
    method(9),
    Object::number(
        0x60F4,
        0,
        "Following error actual value",
        I32,
        Read,
        Transmit,
        0,
    ),
    Object::number(
        0x60FC,
        0,
        "Position demand internal value",
        I32,
        Read,
        Transmit,
        0,
    ),
    Object::number(0x60FD, 0, "Digital inputs", U32, Read, Transmit, 0),
    Object::count(0x60FE, 2),
    Object::number(0x60FE, 1, "Digital outputs: levels", U32, Write, Both, 0),
    Object::number(
        0x60FE,
        2,
        "Digital outputs: bit mask",
        U32,
        Write,
        No,
        0xFFFF_0000,
    ),
    Object::number(0x60FF, 0, "Target velocity", I32, Write, Both, 0),
    Object::number(
        0x6502,
        0,
        "Supported drive modes",
        U32,
        Constant,
        No,
        SUPPORTED_MODES as i64,
    ),
];

#[expect(
    clippy::indexing_slicing,
    reason = "evaluated at compile time, where it is an error"
)]
const fn method(sub: u8) -> Object {
    let name = "Supported homing method";
    let method = HomingMethod::ALL[sub as usize - 1];
    Object::number(0x60E3, sub, name, I8, Constant, No, method.code() as i64)
}
