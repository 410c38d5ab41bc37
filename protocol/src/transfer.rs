//! Cyphal/CAN framing: a payload as one or several frames, and back.
//!
//! After the Cyphal Specification v1.0, section 4.2.2. Every frame ends in a tail byte:
//!
//! ```text
//!  7               6             5       4..0
//!  start of transfer  end of transfer  toggle  transfer-id (counts modulo 32 per session)
//! ```
//!
//! A payload that does not fit one frame is followed by its CRC-16/CCITT-FALSE, big endian. The
//! toggle bit is 1 in the first frame and alternates. On CAN FD, zero bytes fill the last frame
//! up to a valid length; they stand before the CRC and are covered by it, so a receiver sees them
//! as part of the payload.
//!
//! Not here: what the payload means ([`crate::codec`]), and the protection of motion-relevant
//! messages ([`crate::e2e`]).

mod receive;

pub use receive::{Counters, Receiver, Transfer};

use crate::frame::{Frame, fd_length};
use crate::id::CanId;

/// The longest payload of one transfer, padding included, bytes.
///
/// The longest message is [`crate::message::Feedback`] at 302, plus 3 bytes of protection, plus at
/// most 15 bytes of padding (see the assertions in [`crate::codec`]).
pub const MAX_TRANSFER: usize = 384;

/// The most padding that CAN FD can need, bytes: from 33 to 48 or from 49 to 64.
pub const MAX_PADDING: usize = 15;

/// Transfer CRC and end-to-end CRC: polynomial 0x1021, initial value 0xFFFF (CRC-16/CCITT-FALSE,
/// catalogued as IBM-3740).
pub(crate) const CRC: crc::Crc<u16> = crc::Crc::<u16>::new(&crc::CRC_16_IBM_3740);

const CRC_LEN: usize = 2;

/// The greatest frame length: the only difference between the two kinds of wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Mtu {
    /// 8 bytes a frame.
    Classic,
    /// 64 bytes a frame.
    Fd,
}

impl Mtu {
    /// Bytes a frame, tail byte included.
    #[must_use]
    pub const fn bytes(self) -> usize {
        match self {
            Self::Classic => 8,
            Self::Fd => 64,
        }
    }

    /// Payload bytes a frame.
    const fn capacity(self) -> usize {
        self.bytes() - 1
    }

    /// The chunk that `len` payload bytes become in the last frame.
    const fn padded_chunk(self, len: usize) -> usize {
        match self {
            Self::Classic => len,
            Self::Fd => match fd_length(len.saturating_add(1)) {
                Some(padded) => padded.saturating_sub(1),
                None => len,
            },
        }
    }
}

/// Counts the transfers of one session, modulo 32.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct TransferId(u8);

impl TransferId {
    /// From any counter; only its lowest five bits count.
    #[must_use]
    pub const fn new(counter: u8) -> Self {
        Self(counter & 31)
    }

    /// The number, 0 to 31.
    #[must_use]
    pub const fn get(self) -> u8 {
        self.0
    }

    /// The following id.
    #[must_use]
    pub const fn next(self) -> Self {
        Self::new(self.0.wrapping_add(1))
    }

    /// How many steps lead from `other` to `self`, 0 to 31.
    const fn steps_since(self, other: Self) -> u8 {
        self.0.wrapping_sub(other.0) & 31
    }
}

/// The last byte of every frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Tail {
    start: bool,
    end: bool,
    toggle: bool,
    transfer_id: TransferId,
}

impl Tail {
    const fn emit(self) -> u8 {
        (self.start as u8) << 7
            | (self.end as u8) << 6
            | (self.toggle as u8) << 5
            | self.transfer_id.0
    }

    const fn parse(byte: u8) -> Self {
        Self {
            start: byte & 0x80 != 0,
            end: byte & 0x40 != 0,
            toggle: byte & 0x20 != 0,
            transfer_id: TransferId::new(byte),
        }
    }
}

/// The length a receiver sees when `len` payload bytes are sent: with the padding of CAN FD.
#[must_use]
pub const fn padded_length(len: usize, mtu: Mtu) -> usize {
    let capacity = mtu.capacity();
    if len <= capacity {
        mtu.padded_chunk(len)
    } else {
        let total = len.saturating_add(CRC_LEN);
        // all frames but the last are full, and the last is not empty
        let last = match total.checked_rem(capacity) {
            Some(0) | None => capacity,
            Some(last) => last,
        };
        total
            .saturating_sub(last)
            .saturating_add(mtu.padded_chunk(last))
            .saturating_sub(CRC_LEN)
    }
}

/// Splits a payload into frames: an iterator.
///
/// ```
/// use protocol::id::{CanId, NodeId, Port, Priority, Subject};
/// use protocol::transfer::{Mtu, Transmitter, TransferId};
/// let id = CanId {
///     priority: Priority::Low,
///     source: NodeId::MP,
///     port: Port::Message(Subject::EVENT),
/// };
/// let frames = Transmitter::new(id, TransferId::new(3), Mtu::Classic, &[1, 2, 3, 4, 5, 6, 7, 8]);
/// assert_eq!(frames.count(), 2); // 8 bytes + CRC 2 bytes, 7 a frame
/// ```
#[derive(Clone, Debug)]
pub struct Transmitter<'a> {
    id: CanId,
    transfer_id: TransferId,
    mtu: Mtu,
    payload: &'a [u8],
    /// Bytes of payload and padding.
    padded: usize,
    /// Bytes of payload, padding and CRC.
    total: usize,
    crc: [u8; CRC_LEN],
    sent: usize,
    toggle: bool,
    done: bool,
}

impl<'a> Transmitter<'a> {
    /// A transfer of `payload` over frames of the given size.
    #[must_use]
    pub fn new(id: CanId, transfer_id: TransferId, mtu: Mtu, payload: &'a [u8]) -> Self {
        let padded = padded_length(payload.len(), mtu);
        let single = payload.len() <= mtu.capacity();
        let crc = if single {
            [0; CRC_LEN]
        } else {
            let mut digest = CRC.digest();
            digest.update(payload);
            for _ in payload.len()..padded {
                digest.update(&[0]);
            }
            digest.finalize().to_be_bytes()
        };
        let total = if single {
            padded
        } else {
            padded.saturating_add(CRC_LEN)
        };
        Self {
            id,
            transfer_id,
            mtu,
            payload,
            padded,
            total,
            crc,
            sent: 0,
            toggle: true,
            done: false,
        }
    }

    fn byte(&self, index: usize) -> u8 {
        if index < self.padded {
            self.payload.get(index).copied().unwrap_or(0)
        } else {
            let index = index.saturating_sub(self.padded);
            self.crc.get(index).copied().unwrap_or(0)
        }
    }
}

impl Iterator for Transmitter<'_> {
    type Item = Frame;

    fn next(&mut self) -> Option<Frame> {
        if self.done {
            return None;
        }
        let chunk = self
            .total
            .saturating_sub(self.sent)
            .min(self.mtu.capacity());
        let end = self.sent.saturating_add(chunk) >= self.total;
        let tail = Tail {
            start: self.sent == 0,
            end,
            toggle: self.toggle,
            transfer_id: self.transfer_id,
        };
        let mut data = [0u8; crate::frame::MAX_DATA];
        for (index, byte) in (0..chunk).zip(&mut data) {
            *byte = self.byte(self.sent.saturating_add(index));
        }
        if let Some(last) = data.get_mut(chunk) {
            *last = tail.emit();
        }
        self.sent = self.sent.saturating_add(chunk);
        self.toggle = !self.toggle;
        self.done = end;
        let data = data.get(..=chunk)?;
        match self.mtu {
            Mtu::Classic => Frame::classic(self.id.emit(), data),
            Mtu::Fd => Frame::fd(self.id.emit(), data),
        }
    }
}

#[cfg(test)]
mod tests;
