//! Block transfer, the client's side.

use heapless::Vec;

use super::block::{self, Incoming, MAX_BLOCK, Outgoing, RETRIES, Taken, head};
use super::{
    ABORT, Abort, Address, ClientError, DEFAULT_TIMEOUT, Outcome, Progress, abort_bytes, tail,
    with_address,
};
use crate::time::Micros;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Idle,
    /// A download is announced.
    Announced,
    /// Segments go out.
    Sending {
        outgoing: Outgoing,
        crc: bool,
    },
    /// The end is out.
    Ending,
    /// An upload is asked for.
    Asked,
    /// Segments come in; `taken` bytes came.
    Receiving {
        announced: Option<usize>,
        crc: bool,
        incoming: Incoming,
        taken: usize,
        retries: u8,
    },
    /// All segments are here; the server's end is awaited.
    Checking {
        announced: Option<usize>,
        crc: bool,
        taken: usize,
    },
}

/// One SDO client channel that transfers in blocks, with a buffer of `N` bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BlockClient<const N: usize> {
    state: State,
    at: Address,
    buffer: Vec<u8, N>,
    timeout: Micros,
    deadline: Micros,
}

impl<const N: usize> Default for BlockClient<N> {
    fn default() -> Self {
        Self::new(DEFAULT_TIMEOUT)
    }
}

impl<const N: usize> BlockClient<N> {
    /// A client that waits `timeout` for each answer.
    #[must_use]
    pub const fn new(timeout: Micros) -> Self {
        Self {
            state: State::Idle,
            at: Address::new(0, 0),
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
        if !self.is_idle() {
            return Err(ClientError::Busy);
        }
        self.buffer = Vec::from_slice(value).map_err(|_| ClientError::TooLong)?;
        self.start(now, at, State::Announced);
        let len = u32::try_from(value.len()).unwrap_or(u32::MAX);
        let first = head::CLIENT_DOWNLOAD << 5 | head::CRC | head::SIZED | head::INITIATE;
        Ok(with_address(first, at, len.to_le_bytes()))
    }

    /// Starts to read the object `at`: the bytes to send.
    ///
    /// # Errors
    /// [`ClientError::Busy`]; nothing was started.
    pub fn upload(&mut self, now: Micros, at: Address) -> Result<[u8; 8], ClientError> {
        if !self.is_idle() {
            return Err(ClientError::Busy);
        }
        self.buffer.clear();
        self.start(now, at, State::Asked);
        let first = head::CLIENT_UPLOAD << 5 | head::CRC | head::INITIATE;
        Ok(with_address(first, at, [MAX_BLOCK, 0, 0, 0]))
    }

    fn start(&mut self, now: Micros, at: Address, state: State) {
        self.at = at;
        self.deadline = now + self.timeout;
        self.state = state;
    }

    /// The next segment of a download: to be asked for after each answer until it is `None`, at most
    /// [`MAX_BLOCK`] times.
    pub fn next_segment(&mut self) -> Option<[u8; 8]> {
        let State::Sending { outgoing, .. } = &mut self.state else {
            return None;
        };
        outgoing.next(&self.buffer)
    }

    /// Looks at the clock: asks for lost segments again, [`RETRIES`] times, then gives up.
    pub fn poll(&mut self, now: Micros) -> Option<Progress> {
        if self.is_idle() || now < self.deadline {
            return None;
        }
        if let State::Receiving {
            incoming, retries, ..
        } = &mut self.state
            && *retries < RETRIES
        {
            *retries = retries.saturating_add(1);
            let sequence = incoming.sequence();
            *incoming = Incoming::new(MAX_BLOCK);
            self.deadline = now + self.timeout;
            let again = block::acknowledge(head::CLIENT_UPLOAD, sequence, MAX_BLOCK);
            return Some(Progress::Send(again));
        }
        self.state = State::Idle;
        let abort = abort_bytes(self.at, Abort::Timeout);
        Some(Progress::End(abort, Outcome::TimedOut(self.at)))
    }

    /// Takes a frame of the server.
    pub fn on_answer(&mut self, now: Micros, data: &[u8]) -> Progress {
        let Ok(answer) = <[u8; 8]>::try_from(data) else {
            return Progress::Ignored;
        };
        let [first, ..] = answer;
        if self.is_idle() {
            return Progress::Ignored;
        }
        if first == ABORT {
            self.state = State::Idle;
            let abort = Abort::from_code(u32::from_le_bytes(tail(answer)));
            return Progress::Done(Outcome::Refused(self.at, abort));
        }
        self.deadline = now + self.timeout;
        self.step(answer).unwrap_or_else(|abort| {
            self.state = State::Idle;
            Progress::End(abort_bytes(self.at, abort), Outcome::Broken(self.at, abort))
        })
    }

    fn step(&mut self, answer: [u8; 8]) -> Result<Progress, Abort> {
        let [first, second, third, _, size, ..] = answer;
        let (specifier, subcommand) = (first >> 5, first & 3);
        match self.state {
            State::Idle => Ok(Progress::Ignored),
            State::Announced => {
                if specifier != head::SERVER_DOWNLOAD || subcommand != head::INITIATE {
                    return Err(Abort::Command);
                }
                if Address::in_frame(answer) != self.at {
                    return Ok(Progress::Ignored);
                }
                if !block::valid(size) {
                    return Err(Abort::BlockSize);
                }
                let crc = first & head::CRC != 0;
                let outgoing = Outgoing::new(size);
                self.state = State::Sending { outgoing, crc };
                Ok(self.segment())
            }
            State::Sending { mut outgoing, crc } => {
                if specifier != head::SERVER_DOWNLOAD {
                    return Err(Abort::Command);
                }
                if subcommand == head::INITIATE {
                    // doubled
                    return Ok(Progress::Ignored);
                }
                if subcommand != head::ACKNOWLEDGE {
                    return Err(Abort::Command);
                }
                if outgoing.acknowledged(second, third, &self.buffer)? {
                    self.state = State::Ending;
                    let end = block::end(head::CLIENT_DOWNLOAD, &self.buffer, crc);
                    return Ok(Progress::Send(end));
                }
                self.state = State::Sending { outgoing, crc };
                Ok(self.segment())
            }
            State::Ending => {
                if specifier != head::SERVER_DOWNLOAD {
                    return Err(Abort::Command);
                }
                if subcommand != head::END {
                    return Ok(Progress::Ignored);
                }
                self.state = State::Idle;
                Ok(Progress::Done(Outcome::Downloaded(self.at)))
            }
            State::Asked => self.promised(answer),
            State::Receiving { .. } => self.receive(answer),
            State::Checking {
                announced,
                crc,
                taken,
            } => {
                if specifier != head::SERVER_UPLOAD || subcommand != head::END {
                    // a segment that was on its way
                    return Ok(Progress::Ignored);
                }
                block::finish(answer, taken, &mut self.buffer, announced, crc)?;
                self.state = State::Idle;
                let end = head::CLIENT_UPLOAD << 5 | head::END;
                let outcome = Outcome::Uploaded(self.at);
                Ok(Progress::End([end, 0, 0, 0, 0, 0, 0, 0], outcome))
            }
        }
    }

    fn segment(&mut self) -> Progress {
        self.next_segment()
            .map_or(Progress::Ignored, Progress::Send)
    }

    fn promised(&mut self, answer: [u8; 8]) -> Result<Progress, Abort> {
        let [first, ..] = answer;
        if first >> 5 != head::SERVER_UPLOAD || first & 1 != head::INITIATE {
            return Err(Abort::Command);
        }
        if Address::in_frame(answer) != self.at {
            return Ok(Progress::Ignored);
        }
        let announced = usize::try_from(u32::from_le_bytes(tail(answer)))
            .ok()
            .filter(|_| first & head::SIZED != 0);
        if announced.is_some_and(|len| len > N) {
            return Err(Abort::Memory);
        }
        self.state = State::Receiving {
            announced,
            crc: first & head::CRC != 0,
            incoming: Incoming::new(MAX_BLOCK),
            taken: 0,
            retries: 0,
        };
        let start = head::CLIENT_UPLOAD << 5 | head::START;
        Ok(Progress::Send([start, 0, 0, 0, 0, 0, 0, 0]))
    }

    fn receive(&mut self, answer: [u8; 8]) -> Result<Progress, Abort> {
        let State::Receiving {
            announced,
            crc,
            mut incoming,
            taken,
            retries,
        } = self.state
        else {
            return Ok(Progress::Ignored);
        };
        let before = incoming.sequence();
        let outcome = incoming.take(answer, &mut self.buffer)?;
        let came = match outcome {
            Taken::More => incoming.sequence() > before,
            Taken::Block(sequence) | Taken::All(sequence) => sequence > before,
        };
        let taken = taken.saturating_add(if came { 7 } else { 0 });
        self.state = if let Taken::All(_) = outcome {
            State::Checking {
                announced,
                crc,
                taken,
            }
        } else {
            State::Receiving {
                announced,
                crc,
                incoming,
                taken,
                retries: if came { 0 } else { retries },
            }
        };
        Ok(match outcome {
            Taken::More => Progress::Ignored,
            Taken::Block(sequence) | Taken::All(sequence) => {
                Progress::Send(block::acknowledge(head::CLIENT_UPLOAD, sequence, MAX_BLOCK))
            }
        })
    }
}
