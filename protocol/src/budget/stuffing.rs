//! Bit stuffing and CRC-15, a byte at a time.

/// A run of equal bits at the end of the stream so far: the last bit, and how many are equal.
///
/// Encoded as `2 · length + bit`, length 1 to 5; five equal bits are followed by a complement.
type Run = u8;

/// Runs are below this number, rounded up so that four bits are always in bounds.
const RUNS: usize = 16;

/// One bit further: the run, and whether a stuff bit was put in *before* this bit.
const fn step(run: Run, bit: u8) -> (Run, bool) {
    let last = run & 1;
    let len = run >> 1;
    if len >= 5 {
        // The complement of `last` is put in and begins a new run of one.
        let stuff = last ^ 1;
        let len = if bit == stuff { 2 } else { 1 };
        (len << 1 | bit, true)
    } else if bit == last {
        ((len + 1) << 1 | bit, false)
    } else {
        (2 | bit, false)
    }
}

/// The table's index as what it stands for.
#[expect(clippy::cast_possible_truncation, reason = "indices are below 256")]
const fn low_byte(index: usize) -> u8 {
    index as u8
}

/// For a run and a byte: `stuff bits << 4 | run afterwards`.
#[cfg_attr(
    not(test),
    expect(
        clippy::indexing_slicing,
        reason = "evaluated by the compiler, in bounds"
    )
)]
const TABLE: [[u8; 256]; RUNS] = {
    let mut table = [[0; 256]; RUNS];
    let mut run = 0;
    while run < RUNS {
        let mut byte = 0;
        while byte < 256 {
            let mut now = low_byte(run);
            let mut count = 0;
            let mut bit = 8;
            while bit > 0 {
                bit -= 1;
                let (next, stuffed) = step(now, low_byte(byte >> bit) & 1);
                now = next;
                count += stuffed as u8;
            }
            table[run][byte] = count << 4 | now;
            byte += 1;
        }
        run += 1;
    }
    table
};

/// CRC-15 of CAN, polynomial 0x4599, register left aligned in 16 bits.
#[cfg_attr(
    not(test),
    expect(
        clippy::indexing_slicing,
        reason = "evaluated by the compiler, in bounds"
    )
)]
const CRC_TABLE: [u16; 256] = {
    let mut table = [0; 256];
    let mut byte = 0;
    while byte < 256 {
        let mut register = (low_byte(byte) as u16) << 8;
        let mut bit = 0;
        while bit < 8 {
            let carry = register & 0x8000 != 0;
            register <<= 1;
            if carry {
                register ^= 0x4599 << 1;
            }
            bit += 1;
        }
        table[byte] = register;
        byte += 1;
    }
    table
};

/// The CRC register one byte further.
fn crc_byte(register: u16, byte: u8) -> u16 {
    let [high, low] = register.to_be_bytes();
    let entry = CRC_TABLE
        .get(usize::from(high ^ byte))
        .copied()
        .unwrap_or(0);
    u16::from(low) << 8 ^ entry
}

/// The stuff bits of a classical frame: the lowest `bits` bits of `stream`, from the start of frame
/// (a 0) to the last data bit, and the CRC-15 that follows them. The other bits must be 0.
pub(super) fn classic(stream: u128, bits: u32) -> u32 {
    // One walk for both: neither waits for the other. The CRC register begins at zero, so zeros in
    // front change nothing and whole bytes can be taken.
    let filled = (front(bits) | stream).to_be_bytes();
    let stream = stream.to_be_bytes();
    let used = usize::try_from(bits.div_ceil(8)).unwrap_or(stream.len());
    let skip = stream.len().saturating_sub(used);
    let mut register = 0;
    let mut stuffing = Stuffing::START;
    let stream = stream.get(skip..).unwrap_or_default();
    let filled = filled.get(skip..).unwrap_or_default();
    for (byte, filled) in stream.iter().zip(filled) {
        register = crc_byte(register, *byte);
        stuffing = stuffing.byte(*filled);
    }
    // The register holds the CRC in its upper fifteen bits. One bit unlike the last follows: it is
    // stuffed exactly if five equal bits end the CRC.
    let last = register >> 1 & 1;
    let [high, low] = (register & !1 | last ^ 1).to_be_bytes();
    stuffing.byte(high).byte(low).count_before_last()
}

/// In front of the start of frame, alternating bits ending in 1 fill the first byte: they need no
/// stuffing and leave a run that the start of frame ends.
const fn front(bits: u32) -> u128 {
    let ones = 0x5555_5555_5555_5555_5555_5555_5555_5555_u128;
    match ones.checked_shl(bits) {
        Some(front) => front,
        None => 0,
    }
}

/// Counts stuff bits along a stream.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stuffing {
    run: Run,
    count: u32,
}

impl Stuffing {
    /// In front of the stream: see [`front`].
    const START: Self = Self {
        run: 2 | 1,
        count: 0,
    };

    /// Along the lowest `bits` bits of `stream`, the first of which is 0 (start of frame).
    pub(super) fn of(stream: u128, bits: u32) -> Self {
        let bytes = (front(bits) | stream).to_be_bytes();
        let used = usize::try_from(bits.div_ceil(8)).unwrap_or(bytes.len());
        let skip = bytes.len().saturating_sub(used);
        bytes
            .iter()
            .skip(skip)
            .fold(Self::START, |stuffing, byte| stuffing.byte(*byte))
    }

    /// Eight bits further.
    pub(super) fn byte(self, byte: u8) -> Self {
        let row = TABLE.get(usize::from(self.run & 0xF));
        let entry = row
            .and_then(|row| row.get(usize::from(byte)))
            .copied()
            .unwrap_or(0);
        Self {
            run: entry & 0xF,
            count: self.count + u32::from(entry >> 4),
        }
    }

    /// The lowest `len` bits of `bits` further.
    pub(super) fn bits(mut self, bits: u32, len: u32) -> Self {
        for k in (0..len).rev() {
            let (run, stuffed) = step(self.run, u8::from(bits >> k & 1 != 0));
            self.run = run;
            self.count += u32::from(stuffed);
        }
        self
    }

    /// Stuff bits so far, without one after the last bit.
    pub(super) const fn count_before_last(self) -> u32 {
        self.count
    }
}
