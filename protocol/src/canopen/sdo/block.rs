//! Block transfer: what client and server share. Up to 127 segments go out before one answer.
//!
//! ```text
//! sender                                       receiver
//!   (initiate, either way: object, length, CRC or not, segments per block)
//!   1, 2, 3, …, n (bit 7: the last of all) ──▶
//!                                          ◀── last in order, size of the next block
//!   end, unused bytes, CRC                 ──▶
//!                                          ◀── end
//! ```
//! A segment out of order is thrown away; the answer at the block's end names the last in order, and the
//! sender goes on behind it.

use heapless::Vec;

use super::Abort;

/// The most segments in a block (CiA 301, 7.2.4.3.9).
pub const MAX_BLOCK: u8 = 127;

/// Answers in a row that confirm nothing before the sender gives up.
pub const RETRIES: u8 = 3;

/// CRC-16 of CiA 301, 7.2.4.3.16: polynomial 1021, start value 0.
const CRC: crc::Crc<u16> = crc::Crc::<u16>::new(&crc::CRC_16_XMODEM);

/// Bit 7 of a segment: nothing comes behind it.
const LAST: u8 = 0x80;

/// Client command specifiers 5 (upload) and 6 (download), server 5 (download) and 6 (upload); with the
/// subcommand in bits 0–1.
pub(super) mod head {
    pub(in super::super) const CLIENT_DOWNLOAD: u8 = 6;
    pub(in super::super) const CLIENT_UPLOAD: u8 = 5;
    pub(in super::super) const SERVER_DOWNLOAD: u8 = 5;
    pub(in super::super) const SERVER_UPLOAD: u8 = 6;
    /// Subcommands.
    pub(in super::super) const INITIATE: u8 = 0;
    pub(in super::super) const END: u8 = 1;
    pub(in super::super) const ACKNOWLEDGE: u8 = 2;
    pub(in super::super) const START: u8 = 3;
    /// In an initiate: "I can do CRC".
    pub(in super::super) const CRC: u8 = 1 << 2;
    /// In an initiate: "the length is in bytes 4 to 7".
    pub(in super::super) const SIZED: u8 = 1 << 1;
}

/// The CRC of a whole value.
pub(super) const fn crc(data: &[u8]) -> u16 {
    CRC.checksum(data)
}

/// Is this number of segments allowed?
pub(super) const fn valid(size: u8) -> bool {
    1 <= size && size <= MAX_BLOCK
}

/// "`sequence` was the last in order; `size` segments are welcome next".
pub(super) const fn acknowledge(specifier: u8, sequence: u8, size: u8) -> [u8; 8] {
    [
        specifier << 5 | head::ACKNOWLEDGE,
        sequence,
        size,
        0,
        0,
        0,
        0,
        0,
    ]
}

/// The end of a transfer of `data`; without CRC the field is 0.
pub(super) fn end(specifier: u8, data: &[u8], with_crc: bool) -> [u8; 8] {
    let [low, high] = if with_crc { crc(data) } else { 0 }.to_le_bytes();
    let unused = match u8::try_from(data.len() % 7) {
        // an empty value is one segment of which nothing counts
        Ok(0) if data.is_empty() => 7,
        Ok(0) | Err(_) => 0,
        Ok(used) => 7_u8.saturating_sub(used),
    };
    [
        specifier << 5 | unused << 2 | head::END,
        low,
        high,
        0,
        0,
        0,
        0,
        0,
    ]
}

/// The sender's place in a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Outgoing {
    /// Where the block begins, bytes.
    from: usize,
    /// Segments of the block that are out.
    sent: u8,
    /// Segments of the block.
    size: u8,
    /// Answers in a row that confirmed nothing.
    stuck: u8,
}

impl Outgoing {
    /// At the start, in blocks of `size`.
    pub(super) const fn new(size: u8) -> Self {
        Self {
            from: 0,
            sent: 0,
            size,
            stuck: 0,
        }
    }

    /// The next segment of the block, `None` when an answer is due.
    pub(super) fn next(&mut self, data: &[u8]) -> Option<[u8; 8]> {
        let before = self.from.saturating_add(usize::from(self.sent) * 7);
        // a value of no bytes is still one segment
        let ended = before >= data.len() && (self.sent > 0 || self.from > 0);
        if self.sent >= self.size || ended {
            return None;
        }
        let rest = data.get(before..).unwrap_or_default();
        self.sent = self.sent.saturating_add(1);
        let last = rest.len() <= 7;
        let mut bytes = [0; 8];
        for (to, from) in bytes.iter_mut().skip(1).zip(rest) {
            *to = *from;
        }
        if let Some(head) = bytes.first_mut() {
            *head = self.sent | if last { LAST } else { 0 };
        }
        Some(bytes)
    }

    /// Takes the answer to a block; was it the last?
    ///
    /// # Errors
    /// [`Abort::Sequence`] for a segment that never went out, or after [`RETRIES`] answers that
    /// confirm nothing; [`Abort::BlockSize`].
    pub(super) fn acknowledged(
        &mut self,
        sequence: u8,
        size: u8,
        data: &[u8],
    ) -> Result<bool, Abort> {
        if sequence > self.sent {
            return Err(Abort::Sequence);
        }
        if !valid(size) {
            return Err(Abort::BlockSize);
        }
        if sequence == 0 {
            self.stuck = self.stuck.saturating_add(1);
            if self.stuck > RETRIES {
                return Err(Abort::Sequence);
            }
        } else {
            self.stuck = 0;
        }
        self.from = self.from.saturating_add(usize::from(sequence) * 7);
        self.sent = 0;
        self.size = size;
        Ok(sequence > 0 && self.from >= data.len())
    }
}

/// What became of a segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Taken {
    /// Nothing to say yet.
    More,
    /// The block ended: this segment was the last in order.
    Block(u8),
    /// All segments are here; this was the last.
    All(u8),
}

/// The receiver's place in a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Incoming {
    /// The last segment in order.
    sequence: u8,
    /// Segments of the block.
    size: u8,
}

impl Incoming {
    /// At the start of a block of `size`.
    pub(super) const fn new(size: u8) -> Self {
        Self { sequence: 0, size }
    }

    /// The last segment in order.
    pub(super) const fn sequence(self) -> u8 {
        self.sequence
    }

    /// Takes a segment; those out of order are thrown away.
    ///
    /// # Errors
    /// [`Abort::Memory`] when the buffer is full.
    pub(super) fn take<const N: usize>(
        &mut self,
        segment: [u8; 8],
        buffer: &mut Vec<u8, N>,
    ) -> Result<Taken, Abort> {
        let [head, bytes @ ..] = segment;
        let (number, last) = (head & !LAST, head & LAST != 0);
        let in_order = number == self.sequence.saturating_add(1);
        if in_order {
            // The last segment may be filled up beyond the buffer; `finish` knows how far it counts.
            let room = N.saturating_sub(buffer.len()).min(bytes.len());
            let (fits, beyond) = bytes.split_at_checked(room).ok_or(Abort::Memory)?;
            if !last && !beyond.is_empty() {
                return Err(Abort::Memory);
            }
            buffer.extend_from_slice(fits).map_err(|_| Abort::Memory)?;
            self.sequence = number;
            if last {
                return Ok(Taken::All(number));
            }
        }
        if last || number >= self.size {
            let sequence = self.sequence;
            self.sequence = 0;
            return Ok(Taken::Block(sequence));
        }
        Ok(Taken::More)
    }
}

/// Cuts the unused bytes off and checks length and CRC.
///
/// `taken` is how many bytes came in segments: a multiple of 7.
///
/// # Errors
/// [`Abort::Memory`], [`Abort::TooLong`], [`Abort::TooShort`], [`Abort::Crc`].
pub(super) fn finish<const N: usize>(
    end: [u8; 8],
    taken: usize,
    buffer: &mut Vec<u8, N>,
    announced: Option<usize>,
    with_crc: bool,
) -> Result<(), Abort> {
    let [head, low, high, ..] = end;
    let len = taken.saturating_sub(usize::from(head >> 2 & 7));
    if len > buffer.len() {
        return Err(Abort::Memory);
    }
    buffer.truncate(len);
    match announced {
        Some(announced) if len > announced => return Err(Abort::TooLong),
        Some(announced) if len < announced => return Err(Abort::TooShort),
        Some(_) | None => {}
    }
    if with_crc && crc(buffer) != u16::from_le_bytes([low, high]) {
        return Err(Abort::Crc);
    }
    Ok(())
}
