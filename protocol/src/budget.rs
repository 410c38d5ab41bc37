//! How long a frame occupies the wire: exactly, and at worst.
//!
//! Bits are counted from start of frame to the end of the 3-bit interframe space, so consecutive
//! frames follow each other without a gap. Layouts after ISO 11898-1:2015; `S` = fields under bit
//! stuffing (a complement after five equal bits).
//!
//! ```text
//! classical  S[SOF 1, ID 11|32, RTR/IDE/r0 3, DLC 4, data 8n, CRC 15]  delimiters/ACK/EOF/IFS 13
//! CAN FD     S[SOF 1, ID 11|30, flags up to BRS 5] | S[ESI 1, DLC 4, data 8n]
//!            stuff count 4, CRC 17|21, fixed stuff bits 6|7 |  delimiters/ACK/EOF/IFS 13
//!            '------- nominal rate ------'           '-- data rate --'     '- nominal -'
//! ```
//!
//! (32 = 11 + SRR + IDE + 18 + 1 more reserved bit; FD uses CRC-17 up to 16 data bytes.) The FD CRC
//! carries fixed stuff bits, so its value does not matter for the length; the classical CRC-15 is
//! computed.
//!
//! Worst-case stuffing after Davis, Burns, Bril & Lukkien, "Controller Area Network (CAN)
//! schedulability analysis: Refuted, revisited and revised", Real-Time Systems 35 (2007), (1).

mod stuffing;

use crate::frame::{Frame, Id};
use stuffing::Stuffing;

/// CRC delimiter, acknowledge, its delimiter, end of frame, interframe space.
const TRAILER: u32 = 1 + 1 + 1 + 7 + 3;
/// Bits of the CRC of a classical frame.
const CRC: u32 = 15;

/// The format of the identifier.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum IdFormat {
    /// 11 bits.
    Standard,
    /// 29 bits.
    Extended,
}

impl IdFormat {
    /// The format of this identifier.
    #[must_use]
    pub const fn of(id: Id) -> Self {
        match id {
            Id::Standard(_) => Self::Standard,
            Id::Extended(_) => Self::Extended,
        }
    }

    /// Stuffed bits of a classical frame besides its data: SOF to DLC, and CRC.
    const fn classic_overhead(self) -> u32 {
        match self {
            Self::Standard => 34,
            Self::Extended => 54,
        }
    }

    /// Bits of an FD frame from SOF to BRS.
    const fn fd_arbitration(self) -> u32 {
        match self {
            Self::Standard => 17,
            Self::Extended => 36,
        }
    }
}

/// A length in bit times of the two rates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Bits {
    /// At the nominal (arbitration) rate.
    pub nominal: u32,
    /// At the data rate of CAN FD; 0 for classical frames.
    pub data: u32,
}

/// The bit rates of a wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Rates {
    /// Nominal (arbitration) rate, bit/s.
    pub nominal: u32,
    /// Data rate of CAN FD, bit/s.
    pub data: u32,
}

impl Rates {
    /// Classical CAN at 1 Mbit/s.
    pub const CLASSIC_1M: Self = Self {
        nominal: 1_000_000,
        data: 1_000_000,
    };
    /// CAN FD at 1 and 5 Mbit/s.
    pub const FD_1M_5M: Self = Self {
        nominal: 1_000_000,
        data: 5_000_000,
    };
    /// CAN FD at 1 and 8 Mbit/s.
    pub const FD_1M_8M: Self = Self {
        nominal: 1_000_000,
        data: 8_000_000,
    };

    /// The duration of these bits, ns, rounded up; a rate of 0 counts as 1 bit/s.
    #[must_use]
    pub const fn duration_ns(self, bits: Bits) -> u64 {
        const NS: u64 = 1_000_000_000;
        const fn part(bits: u32, rate: u32) -> u64 {
            let rate = if rate == 0 { 1 } else { rate as u64 };
            (bits as u64 * NS).div_ceil(rate)
        }
        part(bits.nominal, self.nominal).saturating_add(part(bits.data, self.data))
    }
}

/// The most bits a classical frame of `len` (at most 8) data bytes can have.
///
/// ```
/// use protocol::budget::{IdFormat, worst_classic};
/// assert_eq!(worst_classic(IdFormat::Standard, 8).nominal, 135);
/// ```
#[must_use]
pub const fn worst_classic(format: IdFormat, len: u8) -> Bits {
    let len = if len > 8 { 8 } else { len };
    let stuffed = format.classic_overhead() + 8 * len as u32;
    Bits {
        nominal: stuffed + (stuffed - 1) / 4 + TRAILER,
        data: 0,
    }
}

/// The most bits a CAN FD frame with bit-rate switch can have; `len` is rounded up to a length that
/// exists, at most 64.
#[must_use]
pub const fn worst_fd(format: IdFormat, len: u8) -> Bits {
    let len = fd_len(len as usize);
    let arbitration = format.fd_arbitration();
    let in_arbitration = (arbitration - 1) / 4;
    let all = (arbitration + 5 + 8 * len - 1) / 4;
    Bits {
        nominal: arbitration + in_arbitration + TRAILER,
        data: 5 + 8 * len + (all - in_arbitration) + fd_check(len),
    }
}

/// The most bits a frame of this kind and length can have.
#[must_use]
pub fn worst(frame: &Frame) -> Bits {
    let format = IdFormat::of(frame.id());
    let len = u8::try_from(frame.data().len()).unwrap_or(u8::MAX);
    if frame.is_fd() {
        worst_fd(format, len)
    } else {
        worst_classic(format, len)
    }
}

/// The bits this very frame has.
#[must_use]
pub fn exact(frame: &Frame) -> Bits {
    if frame.is_fd() {
        exact_fd(frame)
    } else {
        exact_classic(frame)
    }
}

const fn fd_len(len: usize) -> u32 {
    match crate::frame::fd_length(len) {
        #[expect(clippy::cast_possible_truncation, reason = "at most 64")]
        Some(len) => len as u32,
        None => 64,
    }
}

/// Stuff count, CRC, and their fixed stuff bits: one in front and one after every fourth bit.
const fn fd_check(len: u32) -> u32 {
    let bits = if len <= 16 { 4 + 17 } else { 4 + 21 };
    bits + 1 + bits / 4
}

/// The DLC code of a payload length.
fn dlc(len: usize) -> u32 {
    match len {
        0..=8 => u32::try_from(len).unwrap_or(8),
        9..=12 => 9,
        13..=16 => 10,
        17..=20 => 11,
        21..=24 => 12,
        25..=32 => 13,
        33..=48 => 14,
        _ => 15,
    }
}

/// SOF to the flag before the DLC, as the lowest bits of a number, and how many they are.
fn header(id: Id, fd: bool) -> (u64, u32) {
    match (id, fd) {
        // SOF, ID, RTR = 0, IDE = 0, r0 = 0
        (Id::Standard(id), false) => ((u64::from(id) & 0x7FF) << 3, 15),
        // SOF, ID, SRR = 1, IDE = 1, ID, RTR = 0, r1 = 0, r0 = 0
        (Id::Extended(id), false) => (extended(id) << 3, 35),
        // SOF, ID, RRS = 0, IDE = 0, FDF = 1, res = 0, BRS = 1
        (Id::Standard(id), true) => ((u64::from(id) & 0x7FF) << 5 | 0b00101, 17),
        // SOF, ID, SRR = 1, IDE = 1, ID, RRS = 0, FDF = 1, res = 0, BRS = 1
        (Id::Extended(id), true) => (extended(id) << 4 | 0b0101, 36),
    }
}

/// SOF, 11 bits, SRR, IDE, 18 bits.
fn extended(id: u32) -> u64 {
    let id = u64::from(id) & 0x1FFF_FFFF;
    (id >> 18) << 20 | 0b11 << 18 | (id & 0x3_FFFF)
}

fn exact_classic(frame: &Frame) -> Bits {
    let (header, len) = header(frame.id(), false);
    let data = frame.data();
    // SOF to data, right aligned: at most 39 + 64 bits.
    let mut payload = [0; 8];
    payload
        .iter_mut()
        .zip(data)
        .for_each(|(to, byte)| *to = *byte);
    let length = dlc(data.len());
    let unused = 64 - 8 * length;
    let head = u128::from(header << 4 | u64::from(length));
    let stream = (head << 64 | u128::from(u64::from_be_bytes(payload))) >> unused;
    let bits = len + 4 + 8 * length;
    Bits {
        nominal: bits + CRC + stuffing::classic(stream, bits) + TRAILER,
        data: 0,
    }
}

fn exact_fd(frame: &Frame) -> Bits {
    let (header, arbitration) = header(frame.id(), true);
    let data = frame.data();
    // ESI = 0 (error active) and DLC belong to the data phase.
    let control = dlc(data.len());
    let in_arbitration = Stuffing::of(u128::from(header), arbitration);
    // The stuff bit that five equal bits up to BRS demand is sent after BRS, at the data rate.
    let nominal_stuff = in_arbitration.count_before_last();
    let mut stuffing = in_arbitration.bits(control, 5);
    for byte in data {
        stuffing = stuffing.byte(*byte);
    }
    let len = fd_len(data.len());
    // After the last data bit comes a fixed stuff bit, never a dynamic one.
    let data_stuff = stuffing.count_before_last() - nominal_stuff;
    Bits {
        nominal: arbitration + nominal_stuff + TRAILER,
        data: 5 + 8 * len + data_stuff + fd_check(len),
    }
}

#[cfg(test)]
mod tests;
