//! CAN adapters on a serial line or a TCP port that speak slcan (Lawicel's text protocol).
//!
//! ```text
//! C S8 O                 close, 1 Mbit/s, open: what this side says first, each with a carriage return
//! t1232AABB              a frame, 11 bits: identifier, length, data; T with eight digits for 29 bits
//! z  Z                   the adapter has taken a t or T; a bell (07) says that it refused something
//! ```
//!
//! Classical frames only: adapters differ in how they say FD. Remote frames and what is no frame are
//! counted and left out. Input is not trusted: lines and queues are bounded, and nothing in it ends the
//! connection but its end.

mod line;
mod text;

pub use line::Line;

use crate::{Bus, BusError, Received, now, until};
use protocol::frame::Frame;
use protocol::time::Micros;
use std::collections::VecDeque;
use std::io::{self, ErrorKind};
use text::{Cutter, Heard};

/// What this side says first. A bell in answer to C is none: the adapter was closed.
const OPEN: &[u8] = b"\rC\rS8\rO\r";

/// Frames that wait to be taken; later ones are lost and counted.
pub const QUEUE: usize = 4096;

/// Bytes that the line has not yet taken; more is [`BusError::Full`].
const MAX_UNSENT: usize = 16 * 1024;

/// What came that was no frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Bells: what the adapter refused.
    pub refused: u64,
    /// Lines that are nothing known, or too long; and remote frames.
    pub ignored: u64,
    /// Frames lost because nobody took them.
    pub dropped: u64,
}

/// An adapter.
pub struct Slcan {
    label: String,
    line: Box<dyn Line>,
    cutter: Cutter,
    received: VecDeque<Received>,
    unsent: Vec<u8>,
    statistics: Statistics,
}

impl std::fmt::Debug for Slcan {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Slcan")
            .field("label", &self.label)
            .field("statistics", &self.statistics)
            .finish_non_exhaustive()
    }
}

impl Slcan {
    /// The adapter behind a serial device, opened at 1 Mbit/s. (Its own rate is that of USB.)
    ///
    /// # Errors
    /// One line that says why there is none.
    pub fn device(path: &str) -> Result<Self, BusError> {
        Self::begin(format!("slcan:{path}"), line::device(path))
    }

    /// The adapter behind a TCP port, opened at 1 Mbit/s.
    ///
    /// # Errors
    /// One line that says why there is none.
    pub fn tcp(host: &str, port: u16) -> Result<Self, BusError> {
        Self::begin(format!("slcan:{host}:{port}"), line::tcp(host, port))
    }

    fn begin(label: String, line: io::Result<Box<dyn Line>>) -> Result<Self, BusError> {
        let line = line.map_err(|error| BusError::Open {
            bus: label.clone(),
            reason: error.to_string(),
        })?;
        let mut adapter = Self {
            label,
            line,
            cutter: Cutter::default(),
            received: VecDeque::new(),
            unsent: OPEN.to_vec(),
            statistics: Statistics::default(),
        };
        adapter.flush()?;
        Ok(adapter)
    }

    /// What came that was no frame.
    #[must_use]
    pub const fn statistics(&self) -> Statistics {
        self.statistics
    }

    fn lost(&self, error: &io::Error) -> BusError {
        BusError::Lost {
            bus: self.label.clone(),
            reason: error.to_string(),
        }
    }

    /// Writes what is left, as far as the line takes it.
    fn flush(&mut self) -> Result<(), BusError> {
        while !self.unsent.is_empty() {
            match self.line.give(&self.unsent) {
                Ok(0) => break,
                Ok(written) => {
                    self.unsent.drain(..written);
                }
                Err(error) => return Err(self.lost(&error)),
            }
        }
        Ok(())
    }

    /// Reads once; `false` if nothing was there.
    fn fill(&mut self, patience: std::time::Duration) -> Result<bool, BusError> {
        let mut bytes = [0; 4096];
        let read = match self.line.take(&mut bytes, patience) {
            Ok(read) => read,
            Err(error) => return Err(self.lost(&error)),
        };
        let at = now();
        let (received, statistics) = (&mut self.received, &mut self.statistics);
        let bytes = bytes.get(..read).unwrap_or(&[]);
        self.cutter.feed(bytes, &mut |heard| match heard {
            Heard::Frame(frame) if received.len() < QUEUE => {
                received.push_back(Received { frame, at });
            }
            Heard::Frame(_) => statistics.dropped += 1,
            Heard::Refusal => statistics.refused += 1,
            Heard::Nothing => {}
            Heard::Unknown => statistics.ignored += 1,
        });
        Ok(read > 0)
    }
}

/// Is there merely nothing to read, or no room to write?
fn is_not_ready(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted
    )
}

impl Bus for Slcan {
    fn send(&mut self, frame: &Frame) -> Result<(), BusError> {
        let bus = || self.label.clone();
        if frame.is_fd() {
            return Err(BusError::FdUnsupported { bus: bus() });
        }
        if self.unsent.len() >= MAX_UNSENT {
            self.flush()?;
            if self.unsent.len() >= MAX_UNSENT {
                return Err(BusError::Full {
                    bus: self.label.clone(),
                });
            }
        }
        text::write(&mut self.unsent, frame);
        self.flush()
    }

    fn receive(&mut self) -> Result<Option<Received>, BusError> {
        if self.received.is_empty() {
            self.flush()?;
            self.fill(std::time::Duration::ZERO)?;
        }
        Ok(self.received.pop_front())
    }

    fn wait(&mut self, deadline: Micros) -> Result<(), BusError> {
        while self.received.is_empty() {
            self.flush()?;
            let left = until(deadline);
            if left.is_zero() {
                break;
            }
            self.fill(left)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
