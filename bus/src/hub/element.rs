//! The text of the protocol: finding `< … >` in a stream, and what stands between.

use super::MAX_ELEMENT;
use protocol::frame::{Frame, Id};
use std::fmt::Write as _;

/// Cuts a stream of bytes into elements; bounded.
#[derive(Debug, Default)]
pub(super) struct Cutter {
    element: Vec<u8>,
    inside: bool,
}

/// The stream is not made of elements of bearable length.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct TooLong;

impl Cutter {
    /// Hands every element that `bytes` completes to `found`, without brackets and outer spaces.
    /// What stands outside of brackets is skipped. Stops early when `found` returns `false`.
    pub(super) fn feed(
        &mut self,
        bytes: &[u8],
        found: &mut impl FnMut(&str) -> bool,
    ) -> Result<(), TooLong> {
        for byte in bytes {
            match byte {
                b'<' => {
                    self.inside = true;
                    self.element.clear();
                }
                b'>' if self.inside => {
                    self.inside = false;
                    let text = String::from_utf8_lossy(&self.element);
                    if !found(text.trim()) {
                        return Ok(());
                    }
                }
                _ if self.inside => {
                    if self.element.len() + 2 >= MAX_ELEMENT {
                        return Err(TooLong);
                    }
                    self.element.push(*byte);
                }
                _ => {}
            }
        }
        Ok(())
    }
}

/// What a client says.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Command {
    Open(String),
    RawMode,
    BcmMode,
    Echo,
    Send(Frame),
    /// Understood as far as to say why not.
    Refused(&'static str),
}

const UNKNOWN: Command = Command::Refused("unknown command");
const SYNTAX: Command = Command::Refused("syntax error: expected send ID LENGTH BYTE...");

/// The command in an element.
pub(super) fn command(element: &str) -> Command {
    let mut words = element.split_ascii_whitespace();
    match (words.next(), words.next()) {
        (Some("open"), Some(name)) if words.next().is_none() => Command::Open(name.to_owned()),
        (Some("rawmode"), None) => Command::RawMode,
        (Some("bcmmode"), None) => Command::BcmMode,
        (Some("echo"), None) => Command::Echo,
        (Some("send"), Some(id)) => send(id, words),
        (Some("fdsend"), _) => Command::Refused("CAN FD is not supported by this hub"),
        (Some("sendrtr"), _) => Command::Refused("remote frames are not supported by this hub"),
        (Some("controlmode" | "isotpmode"), _) => {
            Command::Refused("only rawmode is supported by this hub")
        }
        (Some("add" | "update" | "delete" | "filter" | "muxfilter" | "subscribe"), _) => {
            Command::Refused(
                "broadcast manager commands are not supported by this hub: use rawmode",
            )
        }
        _ => UNKNOWN,
    }
}

fn send<'a>(id: &str, mut words: impl Iterator<Item = &'a str>) -> Command {
    let (Some(id), Some(len)) = (identifier(id), words.next().and_then(|len| hex(len, 2))) else {
        return SYNTAX;
    };
    if len > 8 {
        return Command::Refused("more than 8 bytes: CAN FD is not supported by this hub");
    }
    let bytes: Option<Vec<u8>> = words
        .map(|word| hex(word, 2).and_then(|byte| u8::try_from(byte).ok()))
        .collect();
    match bytes {
        Some(bytes) if usize::try_from(len) == Ok(bytes.len()) => {
            Frame::classic(id, &bytes).map_or(SYNTAX, Command::Send)
        }
        _ => SYNTAX,
    }
}

/// Three digits or eight.
fn identifier(text: &str) -> Option<Id> {
    let number = hex(text, 8)?;
    match text.len() {
        3 => u16::try_from(number)
            .ok()
            .filter(|id| *id <= 0x7FF)
            .map(Id::Standard),
        8 => Some(Id::Extended(number)).filter(|_| number <= 0x1FFF_FFFF),
        _ => None,
    }
}

fn hex(text: &str, longest: usize) -> Option<u32> {
    let fits = (1..=longest).contains(&text.len());
    let only_hex = text.bytes().all(|b| b.is_ascii_hexdigit());
    u32::from_str_radix(text, 16)
        .ok()
        .filter(|_| fits && only_hex)
}

fn write_id(text: &mut String, id: Id) {
    let _ = match id {
        Id::Standard(id) => write!(text, "{id:03X}"),
        Id::Extended(id) => write!(text, "{id:08X}"),
    };
}

/// Appends what the server says of a frame that was sent at so many µs of the Unix epoch.
pub(super) fn write_frame(text: &mut String, frame: &Frame, epoch_us: u64) {
    text.push_str("< frame ");
    write_id(text, frame.id());
    let _ = write!(
        text,
        " {}.{:06} ",
        epoch_us / 1_000_000,
        epoch_us % 1_000_000
    );
    for byte in frame.data() {
        let _ = write!(text, "{byte:02X}");
    }
    text.push_str(" >");
}

/// Appends what a client says to send a frame.
pub(super) fn write_send(text: &mut String, frame: &Frame) {
    text.push_str("< send ");
    write_id(text, frame.id());
    let _ = write!(text, " {}", frame.data().len());
    for byte in frame.data() {
        let _ = write!(text, " {byte:02X}");
    }
    text.push_str(" >");
}

/// What a server says.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Answer {
    Hi,
    Ok,
    Echo,
    Frame(Frame),
    Error(String),
    /// Error frames of the bus, statistics, remote and FD frames: not for us.
    Other,
}

/// The answer in an element.
pub(super) fn answer(element: &str) -> Answer {
    let mut words = element.split_ascii_whitespace();
    match words.next() {
        Some("hi") => Answer::Hi,
        Some("ok") => Answer::Ok,
        Some("echo") => Answer::Echo,
        Some("frame") => frame(words).map_or(Answer::Other, Answer::Frame),
        Some("error") => Answer::Error(words.collect::<Vec<_>>().join(" ")),
        _ => Answer::Other,
    }
}

/// Data with or without spaces: both are found in the wild.
fn frame<'a>(mut words: impl Iterator<Item = &'a str>) -> Option<Frame> {
    let id = identifier(words.next()?)?;
    words.next()?; // the server's wall clock is of no use here
    let mut data = Vec::with_capacity(8);
    for word in words {
        for digits in word.as_bytes().chunks(2) {
            let digits = std::str::from_utf8(digits).ok()?;
            data.push(u8::try_from(hex(digits, 2)?).ok()?);
        }
    }
    Frame::classic(id, &data)
}
