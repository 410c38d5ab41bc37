//! The text of slcan: lines out of a stream, frames out of lines, and back.

use protocol::frame::{Frame, Id};

/// The longest line: T, eight digits, a length, eight bytes, a time stamp of four digits.
const MAX_LINE: usize = 1 + 8 + 1 + 16 + 4;

/// What the adapter says when it refuses.
const BELL: u8 = 7;

/// What was heard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Heard {
    /// A frame.
    Frame(Frame),
    /// A bell.
    Refusal,
    /// An empty line, z or Z: agreement.
    Nothing,
    /// Something else, or a line that is too long.
    Unknown,
}

/// Cuts a stream into lines; bounded.
#[derive(Debug, Default)]
pub(super) struct Cutter {
    line: Vec<u8>,
    too_long: bool,
}

impl Cutter {
    /// Hands over everything that `bytes` completes.
    pub(super) fn feed(&mut self, bytes: &[u8], heard: &mut impl FnMut(Heard)) {
        for byte in bytes {
            match *byte {
                b'\r' if self.too_long => {
                    self.too_long = false;
                    heard(Heard::Unknown);
                }
                b'\r' => {
                    heard(understand(&self.line));
                    self.line.clear();
                }
                BELL => {
                    heard(Heard::Refusal);
                    self.line.clear();
                    self.too_long = false;
                }
                _ if self.too_long => {}
                byte if self.line.len() < MAX_LINE => self.line.push(byte),
                _ => {
                    self.line.clear();
                    self.too_long = true;
                }
            }
        }
    }
}

fn understand(line: &[u8]) -> Heard {
    match line {
        [] | [b'z' | b'Z'] => Heard::Nothing,
        // some adapters agree and go on in the same line
        [b'z' | b'Z', rest @ ..] => understand_frame(rest),
        line => understand_frame(line),
    }
}

fn understand_frame(line: &[u8]) -> Heard {
    parse(line).map_or(Heard::Unknown, Heard::Frame)
}

fn parse(line: &[u8]) -> Option<Frame> {
    let (kind, rest) = line.split_first()?;
    let digits = match kind {
        b't' => 3,
        b'T' => 8,
        _ => return None,
    };
    let (id, rest) = rest.split_at_checked(digits)?;
    let id = number(id)?;
    let id = match digits {
        3 => Id::Standard(u16::try_from(id).ok().filter(|id| *id <= 0x7FF)?),
        _ => Id::Extended(Some(id).filter(|id| id >> 29 == 0)?),
    };
    let (len, rest) = rest.split_first()?;
    let len = usize::from(len.checked_sub(b'0').filter(|len| *len <= 8)?);
    let (data, stamp) = rest.split_at_checked(2 * len)?;
    if !(stamp.is_empty() || stamp.len() == 4 && number(stamp).is_some()) {
        return None;
    }
    let mut bytes = [0; 8];
    for (byte, digits) in bytes.iter_mut().zip(data.chunks(2)) {
        *byte = u8::try_from(number(digits)?).ok()?;
    }
    Frame::classic(id, bytes.get(..len)?)
}

/// Up to eight hexadecimal digits.
fn number(digits: &[u8]) -> Option<u32> {
    digits.iter().try_fold(0, |number: u32, digit| {
        let digit = char::from(*digit).to_digit(16)?;
        Some(number << 4 | digit)
    })
}

/// Appends a classical frame's line.
pub(super) fn write(line: &mut Vec<u8>, frame: &Frame) {
    let start = match frame.id() {
        Id::Standard(id) => format!("t{id:03X}"),
        Id::Extended(id) => format!("T{id:08X}"),
    };
    line.extend_from_slice(start.as_bytes());
    line.extend_from_slice(frame.data().len().to_string().as_bytes());
    for byte in frame.data() {
        line.extend_from_slice(format!("{byte:02X}").as_bytes());
    }
    line.push(b'\r');
}
