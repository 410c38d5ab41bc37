//! Log lines as `candump -L` and `log2asc` of can-utils write and read them.
//!
//! ```text
//! (1436509052.249713) vcan0 044#2A366C2BBA          classical, 11 bits
//! (1436509052.249713) vcan0 18EF0102#               classical, 29 bits, no data
//! (1436509052.249713) vcan0 044##1112233            CAN FD: flags (1 = BRS, 2 = ESI), data
//! ```
//!
//! ```
//! use bus::candump::{Entry, Reader};
//! let text = "(0.000051) mp 00B#01FF\n";
//! let entries: Result<Vec<Entry>, _> = Reader::new(text.as_bytes()).collect();
//! assert_eq!(entries.unwrap()[0].to_string(), "(0.000051) mp 00B#01FF");
//! ```

use protocol::frame::{Frame, Id};
use protocol::time::Micros;
use std::fmt;
use std::io::{self, BufRead, Write};

/// The longest line, bytes: a CAN FD frame of 64 bytes needs less than 200.
pub const MAX_LINE: usize = 256;

/// The longest channel name, bytes: that of an interface in Linux. `canplayer` refuses a log with a longer one.
pub const MAX_CHANNEL: usize = 15;

/// One line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// When, µs from the log's origin (candump: the Unix epoch; a simulation: its beginning).
    pub at: Micros,
    /// Where.
    pub channel: String,
    /// What.
    pub frame: Frame,
}

impl fmt::Display for Entry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        line(f, self.at, &self.channel, &self.frame)
    }
}

fn line(f: &mut impl fmt::Write, at: Micros, channel: &str, frame: &Frame) -> fmt::Result {
    write!(
        f,
        "({}.{:06}) {channel} ",
        at.0 / 1_000_000,
        at.0 % 1_000_000
    )?;
    match frame.id() {
        Id::Standard(id) => write!(f, "{id:03X}#")?,
        Id::Extended(id) => write!(f, "{id:08X}#")?,
    }
    if frame.is_fd() {
        f.write_str("#1")?; // our FD frames switch the bit rate and are error active
    }
    frame
        .data()
        .iter()
        .try_for_each(|byte| write!(f, "{byte:02X}"))
}

/// Writes lines to anything; buffered by its owner.
#[derive(Debug)]
pub struct Writer<W> {
    out: W,
    text: String,
}

impl<W: Write> Writer<W> {
    /// Writes to `out`.
    pub const fn new(out: W) -> Self {
        Self {
            out,
            text: String::new(),
        }
    }

    /// One line.
    ///
    /// # Errors
    /// Those of the output.
    pub fn write(&mut self, at: Micros, channel: &str, frame: &Frame) -> io::Result<()> {
        self.text.clear();
        line(&mut self.text, at, channel, frame).map_err(io::Error::other)?;
        self.text.push('\n');
        self.out.write_all(self.text.as_bytes())
    }

    /// Hands everything to the operating system.
    ///
    /// # Errors
    /// Those of the output.
    pub fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// What is wrong with a line.
#[derive(Debug, thiserror::Error)]
pub enum LineError {
    /// Too long, or the file is no text.
    #[error("longer than {MAX_LINE} bytes")]
    TooLong,
    /// Not ASCII text.
    #[error("not text")]
    NotText,
    /// Not three fields.
    #[error("expected \"(seconds.micros) channel id#data\"")]
    Shape,
    /// Not a time.
    #[error("{0:?} is not a time, expected (seconds.micros) with six digits of micros")]
    Time(String),
    /// Earlier than the line before.
    #[error("time goes backwards, from {before} µs to {now} µs")]
    Backwards {
        /// Of the line before.
        before: u64,
        /// Of this line.
        now: u64,
    },
    /// Not a channel name.
    #[error("{0:?} is not a channel name (at most {MAX_CHANNEL} characters)")]
    Channel(String),
    /// Not an identifier.
    #[error("{0:?} is not an identifier: three hex digits to 7FF, or eight to 1FFFFFFF")]
    Identifier(String),
    /// A remote or error frame.
    #[error("remote and error frames are not supported")]
    NotData,
    /// Not data bytes.
    #[error("{0:?} is not data: pairs of hex digits")]
    Data(String),
    /// A length that no frame has.
    #[error("{len} data bytes: {kind} frames have {lengths}")]
    Length {
        /// How many.
        len: usize,
        /// classical or CAN FD
        kind: &'static str,
        /// What is possible.
        lengths: &'static str,
    },
    /// The file could not be read.
    #[error(transparent)]
    Io(#[from] io::Error),
}

/// What is wrong, and in which line.
#[derive(Debug, thiserror::Error)]
#[error("line {line}: {error}")]
pub struct ReadError {
    /// Counted from 1.
    pub line: u64,
    /// What.
    pub error: LineError,
}

/// Reads lines: an iterator that ends after the first error. Empty lines are skipped. Memory is
/// bounded whatever the input.
#[derive(Debug)]
pub struct Reader<R> {
    input: R,
    line: u64,
    before: Micros,
    failed: bool,
}

impl<R: BufRead> Reader<R> {
    /// Reads from `input`.
    pub const fn new(input: R) -> Self {
        Self {
            input,
            line: 0,
            before: Micros(0),
            failed: false,
        }
    }

    /// The next line without its end; `None` at the end of the input.
    fn next_line(&mut self) -> Result<Option<String>, LineError> {
        let mut bytes = Vec::with_capacity(128);
        // One byte more than allowed tells a line that is too long, and one its end.
        let limit = MAX_LINE as u64 + 2;
        let read = io::Read::take(&mut self.input, limit).read_until(b'\n', &mut bytes)?;
        if read == 0 {
            return Ok(None);
        }
        if bytes.last() == Some(&b'\n') {
            bytes.pop();
            if bytes.last() == Some(&b'\r') {
                bytes.pop();
            }
        }
        if bytes.len() > MAX_LINE {
            return Err(LineError::TooLong);
        }
        match String::from_utf8(bytes) {
            Ok(text) if text.bytes().all(|b| b == b' ' || b.is_ascii_graphic()) => Ok(Some(text)),
            _ => Err(LineError::NotText),
        }
    }

    fn next_entry(&mut self) -> Result<Option<Entry>, LineError> {
        loop {
            self.line += 1;
            let Some(text) = self.next_line()? else {
                return Ok(None);
            };
            if text.trim().is_empty() {
                continue;
            }
            let entry = parse(&text)?;
            if entry.at < self.before {
                return Err(LineError::Backwards {
                    before: self.before.0,
                    now: entry.at.0,
                });
            }
            self.before = entry.at;
            return Ok(Some(entry));
        }
    }
}

impl<R: BufRead> Iterator for Reader<R> {
    type Item = Result<Entry, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.failed {
            return None;
        }
        let line = self.next_entry().transpose()?;
        self.failed = line.is_err();
        Some(line.map_err(|error| ReadError {
            line: self.line,
            error,
        }))
    }
}

/// One line, without its end.
///
/// # Errors
/// When it is not exactly a log line.
pub fn parse(text: &str) -> Result<Entry, LineError> {
    let mut fields = text.split_ascii_whitespace();
    let (Some(time), Some(channel), Some(frame)) = (fields.next(), fields.next(), fields.next())
    else {
        return Err(LineError::Shape);
    };
    // candump -L -x adds R or T, the direction.
    if !matches!(
        (fields.next(), fields.next()),
        (None | Some("R" | "T"), None)
    ) {
        return Err(LineError::Shape);
    }
    let at = parse_time(time).ok_or_else(|| LineError::Time(time.to_owned()))?;
    if channel.len() > MAX_CHANNEL {
        return Err(LineError::Channel(channel.to_owned()));
    }
    Ok(Entry {
        at,
        channel: channel.to_owned(),
        frame: parse_frame(frame)?,
    })
}

fn digits(text: &str) -> Option<u64> {
    let only_digits = !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    text.parse().ok().filter(|_| only_digits)
}

fn parse_time(text: &str) -> Option<Micros> {
    let (seconds, micros) = text.strip_prefix('(')?.strip_suffix(')')?.split_once('.')?;
    if micros.len() != 6 {
        return None;
    }
    let seconds = digits(seconds)?.checked_mul(1_000_000)?;
    seconds.checked_add(digits(micros)?).map(Micros)
}

fn parse_frame(text: &str) -> Result<Frame, LineError> {
    let (id, rest) = text.split_once('#').ok_or(LineError::Shape)?;
    let id = parse_id(id)?;
    match rest.strip_prefix('#') {
        Some(fd) => {
            // One digit of flags; their meaning does not matter here.
            let flags = fd.get(..1).filter(|flags| hex(flags).is_some());
            let (Some(_), Some(data)) = (flags, fd.get(1..)) else {
                return Err(LineError::Shape);
            };
            let data = parse_data(data)?;
            Frame::fd(id, &data).ok_or(LineError::Length {
                len: data.len(),
                kind: "CAN FD",
                lengths: "0 to 8, 12, 16, 20, 24, 32, 48 or 64",
            })
        }
        None if rest.starts_with('R') => Err(LineError::NotData),
        None => {
            let data = parse_data(rest)?;
            Frame::classic(id, &data).ok_or(LineError::Length {
                len: data.len(),
                kind: "classical",
                lengths: "0 to 8",
            })
        }
    }
}

fn hex(text: &str) -> Option<u32> {
    let only_hex = !text.is_empty() && text.bytes().all(|b| b.is_ascii_hexdigit());
    u32::from_str_radix(text, 16).ok().filter(|_| only_hex)
}

fn parse_id(text: &str) -> Result<Id, LineError> {
    let wrong = || LineError::Identifier(text.to_owned());
    let number = hex(text).ok_or_else(wrong)?;
    match text.len() {
        3 => u16::try_from(number)
            .ok()
            .filter(|id| *id <= 0x7FF)
            .map(Id::Standard),
        8 if number >> 29 == 0 => Some(Id::Extended(number)),
        // Bit 29 marks error frames.
        8 if number >> 29 == 1 => return Err(LineError::NotData),
        _ => None,
    }
    .ok_or_else(wrong)
}

fn parse_data(text: &str) -> Result<Vec<u8>, LineError> {
    let wrong = || LineError::Data(text.chars().take(40).collect());
    if !text.len().is_multiple_of(2) {
        return Err(wrong());
    }
    let byte = |k: usize| {
        text.get(2 * k..2 * k + 2)
            .and_then(hex)
            .and_then(|n| u8::try_from(n).ok())
    };
    (0..text.len() / 2)
        .map(|k| byte(k).ok_or_else(wrong))
        .collect()
}

#[cfg(test)]
mod tests;
