//! The lock-step channel: the host sends one message, the image makes one step of its node and answers
//! with one. Time stands still for the image while it waits, so the host may take as long as it likes.
//!
//! | to the image | bytes |
//! |---|---|
//! | 4 | length of what follows |
//! | 1 | 0: boot, 1: step, 2: end |
//! | | boot: [`Boot::write`]. Step: now (8 bytes, µs), then the frames received ([`crate::frames`]) |
//!
//! | from the image | bytes |
//! |---|---|
//! | 4 | length of what follows |
//! | 1 | 0: there is no node; 1: booted; 2: stepped |
//! | 8 | when the next step is due, µs |
//! | 1 | state of the node, its place in the enumeration |
//! | 8 | the image's own time since its start, in clock cycles |
//! | | booted: the identity, by postcard. Stepped: the frames sent |

use crate::boot::Boot;
use crate::bytes::{Reader, Writer};
use crate::frames;
use firmware::{NodeProcess, Port, Received};
use protocol::frame::Frame;
use protocol::message::{Identity, NodeState};
use protocol::time::Micros;

/// Frames that a node is handed in one step at most: 1 ms of two classical buses at 1 Mbit/s (9 a
/// bus) and of the MP's at 5 Mbit/s (8), twice.
pub const MAX_FRAMES: usize = 52;
/// Bytes of the length in front of a message.
pub const LENGTH: usize = 4;
/// The longest message, its length included.
pub const LONGEST: usize = LENGTH + 18 + MAX_FRAMES * frames::LONGEST;

/// To the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Order {
    Boot = 0,
    Step = 1,
    End = 2,
}

/// From the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Answer {
    None = 0,
    Booted = 1,
    Stepped = 2,
}

/// What the image is to do.
#[derive(Clone, Debug, PartialEq)]
pub enum Request<'a> {
    /// Make a node.
    Boot(Boot),
    /// Make a step at this time, with these frames.
    Step(Micros, FramesIn<'a>),
    /// End.
    End,
}

/// Frames as bytes, one after the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FramesIn<'a>(&'a [u8]);

impl Iterator for FramesIn<'_> {
    type Item = Received;

    fn next(&mut self) -> Option<Received> {
        let (received, len) = frames::read(self.0)?;
        self.0 = self.0.get(len..).unwrap_or(&[]);
        Some(received)
    }
}

/// What the image answers, besides frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stepped {
    /// When the next step is due.
    pub next_wake: Micros,
    /// The state of the node.
    pub state: NodeState,
    /// The image's own time, clock cycles since its start.
    pub cycles: u64,
}

impl Stepped {
    /// Of a node.
    pub fn of(node: &dyn NodeProcess, cycles: u64) -> Self {
        Self {
            next_wake: node.next_wake(),
            state: node.state(),
            cycles,
        }
    }
}

/// What an image answered.
#[derive(Clone, Debug, PartialEq)]
pub enum Reply<'a> {
    /// It has no node, for a reason that its log tells.
    None,
    /// It has a node now.
    Booted(Stepped, Identity),
    /// The node has made a step, and sent these frames (received at 0).
    Stepped(Stepped, FramesIn<'a>),
}

/// How long the message is that begins with these bytes, without them.
#[must_use]
pub fn length(bytes: [u8; LENGTH]) -> Option<usize> {
    let length = usize::try_from(u32::from_le_bytes(bytes)).ok()?;
    (length <= LONGEST - LENGTH).then_some(length)
}

/// Fill in the length; the whole message.
fn finished(buffer: &mut [u8], len: usize) -> Option<usize> {
    let length = u32::try_from(len.checked_sub(LENGTH)?).ok()?;
    buffer
        .get_mut(..LENGTH)?
        .copy_from_slice(&length.to_le_bytes());
    Some(len)
}

fn started<'a>(buffer: &'a mut [u8], first: u8) -> Option<Writer<'a>> {
    let mut out = Writer::new(buffer);
    out.put(&[0; LENGTH])?;
    out.put(&[first])?;
    Some(out)
}

/// Host: a boot message; its length, or nothing if the buffer is too short.
#[must_use]
pub fn write_boot(boot: &Boot, buffer: &mut [u8]) -> Option<usize> {
    let mut body = [0; Boot::BYTES];
    boot.write(&mut body)?;
    let mut out = started(buffer, Order::Boot as u8)?;
    out.put(&body)?;
    let len = out.len();
    finished(buffer, len)
}

/// Host: a step; its length, or nothing if the buffer is too short or the frames are more than
/// [`MAX_FRAMES`].
#[must_use]
pub fn write_step(now: Micros, received: &[Received], buffer: &mut [u8]) -> Option<usize> {
    if received.len() > MAX_FRAMES {
        return None;
    }
    let mut out = started(buffer, Order::Step as u8)?;
    out.put(&now.0.to_le_bytes())?;
    for received in received {
        frames::put(received, &mut out)?;
    }
    let len = out.len();
    finished(buffer, len)
}

/// Host: the end.
#[must_use]
pub fn write_end(buffer: &mut [u8]) -> Option<usize> {
    let len = started(buffer, Order::End as u8)?.len();
    finished(buffer, len)
}

/// Image: what a message without its length says; nothing if it says nothing.
#[must_use]
pub fn read_request(body: &[u8]) -> Option<Request<'_>> {
    let mut bytes = Reader(body);
    let order = bytes.u8()?;
    if order == Order::Boot as u8 {
        Some(Request::Boot(Boot::read(bytes.0)?))
    } else if order == Order::Step as u8 {
        let now = Micros(bytes.u64()?);
        Some(Request::Step(now, FramesIn(bytes.0)))
    } else if order == Order::End as u8 && bytes.0.is_empty() {
        Some(Request::End)
    } else {
        None
    }
}

/// Image: an answer under way, to which frames are added as the node sends them.
#[derive(Debug)]
pub struct Answering<'a> {
    out: Writer<'a>,
    lost: bool,
}

/// Where an answer has its frames, after length, kind, time, state and cycles.
const BODY: usize = LENGTH + 1 + 8 + 1 + 8;

impl<'a> Answering<'a> {
    /// Nothing sent yet; nothing at all if the buffer is too short.
    #[must_use]
    pub fn new(buffer: &'a mut [u8]) -> Option<Self> {
        let mut out = Writer::new(buffer);
        out.put(&[0; BODY])?;
        Some(Self { out, lost: false })
    }

    /// The node sent a frame.
    pub fn sent(&mut self, port: Port, frame: Frame) {
        let at = Micros(0);
        self.lost |= frames::put(&Received { port, at, frame }, &mut self.out).is_none();
    }

    /// The length of the answer in the buffer; nothing if a frame found no room in it.
    #[must_use]
    pub fn finish(self) -> Option<usize> {
        (!self.lost).then_some(self.out.len())
    }
}

/// Image: the head of an answer of `len` bytes ([`Answering::finish`]).
#[must_use]
pub fn answer_stepped(stepped: &Stepped, len: usize, buffer: &mut [u8]) -> Option<usize> {
    head(Answer::Stepped, Some(stepped), len, buffer)
}

/// Image: an answer to a boot that succeeded.
#[must_use]
pub fn answer_booted(stepped: &Stepped, identity: &Identity, buffer: &mut [u8]) -> Option<usize> {
    let body = buffer.get_mut(BODY..)?;
    let written = postcard::to_slice(identity, body).ok()?.len();
    head(
        Answer::Booted,
        Some(stepped),
        BODY.checked_add(written)?,
        buffer,
    )
}

/// Image: an answer to what could not be done.
#[must_use]
pub fn answer_none(buffer: &mut [u8]) -> Option<usize> {
    head(Answer::None, None, BODY, buffer)
}

fn head(answer: Answer, stepped: Option<&Stepped>, len: usize, buffer: &mut [u8]) -> Option<usize> {
    let mut out = started(buffer, answer as u8)?;
    let (wake, state, cycles) =
        stepped.map_or((0, 0, 0), |s| (s.next_wake.0, s.state as u8, s.cycles));
    out.put(&wake.to_le_bytes())?;
    out.put(&[state])?;
    out.put(&cycles.to_le_bytes())?;
    finished(buffer, len)
}

/// Host: what a message without its length says; nothing if it says nothing.
#[must_use]
pub fn read_reply(body: &[u8]) -> Option<Reply<'_>> {
    let mut bytes = Reader(body);
    let answer = bytes.u8()?;
    let next_wake = Micros(bytes.u64()?);
    let state = postcard::from_bytes(&[bytes.u8()?]).ok()?;
    let stepped = Stepped {
        next_wake,
        state,
        cycles: bytes.u64()?,
    };
    if answer == Answer::Booted as u8 {
        Some(Reply::Booted(stepped, postcard::from_bytes(bytes.0).ok()?))
    } else if answer == Answer::Stepped as u8 {
        Some(Reply::Stepped(stepped, FramesIn(bytes.0)))
    } else if answer == Answer::None as u8 {
        Some(Reply::None)
    } else {
        None
    }
}
