//! The SDO client: the node's side.

use heapless::Vec;

use super::{
    Abort, Address, CAPACITY, DEFAULT_TIMEOUT, abort_bytes, ccs, scs, segment, segment_tail, tail,
    with_address,
};
use crate::time::Micros;

#[derive(Clone, Debug, PartialEq, Eq)]
enum State {
    Idle,
    /// Download announced; the buffer goes out next.
    DownloadInitiated {
        at: Address,
    },
    /// `sent` bytes of the buffer are out, `toggle` was the toggle of the last segment.
    DownloadSegment {
        at: Address,
        sent: usize,
        toggle: bool,
    },
    UploadInitiated {
        at: Address,
    },
    /// `announced` is the length the server promised.
    UploadSegment {
        at: Address,
        announced: Option<usize>,
        toggle: bool,
    },
}

/// How a transfer ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The value was written.
    Downloaded(Address),
    /// The value was read: see [`Client::data`].
    Uploaded(Address),
    /// The server refused.
    Refused(Address, Abort),
    /// We gave up: the answer broke the protocol.
    Broken(Address, Abort),
    /// We gave up: no answer in time.
    TimedOut(Address),
}

/// What to do next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// The frame was not for the transfer in progress.
    Ignored,
    /// Send these bytes.
    Send([u8; 8]),
    /// The transfer ended.
    Done(Outcome),
    /// The transfer ended; send these bytes: an abort, or the end of an upload in blocks.
    End([u8; 8], Outcome),
}

/// Why a transfer did not start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClientError {
    /// A transfer is in progress.
    Busy,
    /// The value is longer than `N` bytes.
    TooLong,
}

/// One SDO client channel with a buffer of `N` bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Client<const N: usize = CAPACITY> {
    state: State,
    buffer: Vec<u8, N>,
    timeout: Micros,
    deadline: Micros,
}

impl<const N: usize> Default for Client<N> {
    fn default() -> Self {
        Self::new(DEFAULT_TIMEOUT)
    }
}

impl<const N: usize> Client<N> {
    /// A client that waits `timeout` for each answer.
    #[must_use]
    pub const fn new(timeout: Micros) -> Self {
        Self {
            state: State::Idle,
            buffer: Vec::new(),
            timeout,
            deadline: Micros(0),
        }
    }

    /// Is no transfer in progress?
    #[must_use]
    pub fn is_idle(&self) -> bool {
        self.state == State::Idle
    }

    /// The value of the last upload.
    #[must_use]
    pub fn data(&self) -> &[u8] {
        &self.buffer
    }

    /// The value of the last upload as a number, if it has at most 4 bytes.
    #[must_use]
    pub fn number(&self) -> Option<u32> {
        let mut bytes = [0; 4];
        bytes
            .get_mut(..self.buffer.len())?
            .copy_from_slice(&self.buffer);
        Some(u32::from_le_bytes(bytes))
    }

    /// Starts to write `value` to the object `at`: the bytes to send.
    ///
    /// # Errors
    /// [`ClientError::Busy`] or [`ClientError::TooLong`]; nothing was started.
    pub fn download(
        &mut self,
        now: Micros,
        at: Address,
        value: &[u8],
    ) -> Result<[u8; 8], ClientError> {
        self.ready()?;
        // byte by byte: what `Vec` adds lengths with in one go can overflow, for all the compiler knows
        let mut buffer = Vec::new();
        for byte in value {
            buffer.push(*byte).map_err(|_| ClientError::TooLong)?;
        }
        self.buffer = buffer;
        self.deadline = now + self.timeout;
        self.state = State::DownloadInitiated { at };
        let head = ccs::DOWNLOAD << 5;
        let mut rest = [0; 4];
        if let (1..=4, Ok(size)) = (value.len(), u8::try_from(value.len())) {
            for (to, from) in rest.iter_mut().zip(value) {
                *to = *from;
            }
            return Ok(with_address(
                head | 4_u8.saturating_sub(size) << 2 | 0b11,
                at,
                rest,
            ));
        }
        rest = u32::try_from(value.len()).unwrap_or(u32::MAX).to_le_bytes();
        Ok(with_address(head | 1, at, rest))
    }

    /// Starts to read the object `at`: the bytes to send.
    ///
    /// # Errors
    /// [`ClientError::Busy`]; nothing was started.
    pub fn upload(&mut self, now: Micros, at: Address) -> Result<[u8; 8], ClientError> {
        self.ready()?;
        self.buffer.clear();
        self.deadline = now + self.timeout;
        self.state = State::UploadInitiated { at };
        Ok(with_address(ccs::UPLOAD << 5, at, [0; 4]))
    }

    fn ready(&self) -> Result<(), ClientError> {
        if self.is_idle() {
            Ok(())
        } else {
            Err(ClientError::Busy)
        }
    }

    /// Gives up when the answer is overdue: [`Progress::End`], else `None`.
    pub fn poll(&mut self, now: Micros) -> Option<Progress> {
        let at = self.address()?;
        (now >= self.deadline).then(|| {
            self.state = State::Idle;
            Progress::End(abort_bytes(at, Abort::Timeout), Outcome::TimedOut(at))
        })
    }

    fn address(&self) -> Option<Address> {
        match self.state {
            State::Idle => None,
            State::DownloadInitiated { at }
            | State::DownloadSegment { at, .. }
            | State::UploadInitiated { at }
            | State::UploadSegment { at, .. } => Some(at),
        }
    }

    /// Takes an answer of the server.
    pub fn on_answer(&mut self, now: Micros, data: &[u8]) -> Progress {
        let (Ok(answer), Some(at)) = (<[u8; 8]>::try_from(data), self.address()) else {
            return Progress::Ignored;
        };
        let [head, ..] = answer;
        if head >> 5 == scs::ABORT {
            self.state = State::Idle;
            let abort = Abort::from_code(u32::from_le_bytes(tail(answer)));
            return Progress::Done(Outcome::Refused(at, abort));
        }
        self.deadline = now + self.timeout;
        let next = match self.state {
            State::Idle => return Progress::Ignored,
            State::DownloadInitiated { at } => self.announced(at, answer),
            State::DownloadSegment { at, sent, toggle } => self.taken(at, sent, toggle, answer),
            State::UploadInitiated { at } => self.promised(at, answer),
            State::UploadSegment {
                at,
                announced,
                toggle,
            } => self.got(at, announced, toggle, answer),
        };
        next.unwrap_or_else(|abort| {
            self.state = State::Idle;
            Progress::End(abort_bytes(at, abort), Outcome::Broken(at, abort))
        })
    }

    /// The answer to a download initiate.
    fn announced(&mut self, at: Address, answer: [u8; 8]) -> Result<Progress, Abort> {
        let [head, ..] = answer;
        if head >> 5 != scs::DOWNLOAD {
            return Err(Abort::Command);
        }
        if Address::in_frame(answer) != at {
            return Ok(Progress::Ignored);
        }
        if (1..=4).contains(&self.buffer.len()) {
            return Ok(self.done(Outcome::Downloaded(at)));
        }
        Ok(self.next_segment(at, 0, false))
    }

    fn next_segment(&mut self, at: Address, from: usize, toggle: bool) -> Progress {
        let rest = self.buffer.get(from..).unwrap_or_default();
        let chunk = rest.get(..7).unwrap_or(rest);
        let last = chunk.len() == rest.len();
        let sent = from.saturating_add(chunk.len());
        let bytes = segment(ccs::DOWNLOAD_SEGMENT << 5, toggle, chunk, last);
        self.state = State::DownloadSegment { at, sent, toggle };
        Progress::Send(bytes)
    }

    /// The answer to a download segment.
    fn taken(
        &mut self,
        at: Address,
        sent: usize,
        toggle: bool,
        answer: [u8; 8],
    ) -> Result<Progress, Abort> {
        let [head, ..] = answer;
        if head >> 5 != scs::DOWNLOAD_SEGMENT {
            return Err(Abort::Command);
        }
        if (head & 0x10 != 0) != toggle {
            return Err(Abort::Toggle);
        }
        if sent >= self.buffer.len() {
            return Ok(self.done(Outcome::Downloaded(at)));
        }
        Ok(self.next_segment(at, sent, !toggle))
    }

    /// The answer to an upload initiate.
    fn promised(&mut self, at: Address, answer: [u8; 8]) -> Result<Progress, Abort> {
        let [head, ..] = answer;
        if head >> 5 != scs::UPLOAD {
            return Err(Abort::Command);
        }
        if Address::in_frame(answer) != at {
            return Ok(Progress::Ignored);
        }
        let (expedited, sized) = (head & 2 != 0, head & 1 != 0);
        if expedited {
            let unused = if sized { usize::from(head >> 2 & 3) } else { 0 };
            let value = tail(answer);
            let value = value
                .get(..4_usize.saturating_sub(unused))
                .unwrap_or_default();
            for byte in value {
                self.buffer.push(*byte).map_err(|_| Abort::Memory)?;
            }
            return Ok(self.done(Outcome::Uploaded(at)));
        }
        let announced = usize::try_from(u32::from_le_bytes(tail(answer)))
            .ok()
            .filter(|_| sized);
        if announced.is_some_and(|len| len > N) {
            return Err(Abort::Memory);
        }
        self.state = State::UploadSegment {
            at,
            announced,
            toggle: false,
        };
        Ok(Progress::Send([
            ccs::UPLOAD_SEGMENT << 5,
            0,
            0,
            0,
            0,
            0,
            0,
            0,
        ]))
    }

    /// The answer to an upload segment request.
    fn got(
        &mut self,
        at: Address,
        announced: Option<usize>,
        toggle: bool,
        answer: [u8; 8],
    ) -> Result<Progress, Abort> {
        let [head, ..] = answer;
        if head >> 5 != scs::UPLOAD_SEGMENT {
            return Err(Abort::Command);
        }
        if (head & 0x10 != 0) != toggle {
            return Err(Abort::Toggle);
        }
        let len = 7_usize.saturating_sub(usize::from(head >> 1 & 7));
        let chunk = segment_tail(answer);
        let chunk = chunk.get(..len).unwrap_or_default();
        for byte in chunk {
            self.buffer.push(*byte).map_err(|_| Abort::Memory)?;
        }
        if announced.is_some_and(|announced| self.buffer.len() > announced) {
            return Err(Abort::TooLong);
        }
        if head & 1 != 0 {
            if announced.is_some_and(|announced| self.buffer.len() != announced) {
                return Err(Abort::TooShort);
            }
            return Ok(self.done(Outcome::Uploaded(at)));
        }
        self.state = State::UploadSegment {
            at,
            announced,
            toggle: !toggle,
        };
        let head = ccs::UPLOAD_SEGMENT << 5 | u8::from(!toggle) << 4;
        Ok(Progress::Send([head, 0, 0, 0, 0, 0, 0, 0]))
    }

    fn done(&mut self, outcome: Outcome) -> Progress {
        self.state = State::Idle;
        Progress::Done(outcome)
    }
}
