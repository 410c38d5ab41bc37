//! Reassembly of transfers, bounded in memory and total on any input.

use super::{CRC, CRC_LEN, MAX_TRANSFER, Tail, TransferId};
use crate::id::{CanId, NodeId, Port};
use crate::time::Micros;

/// After this silence a session accepts any transfer-id as new (the standard's default: 2 s).
const TRANSFER_ID_TIMEOUT: Micros = Micros::from_millis(2000);

/// The least payload of a frame that is not the last: full classical frames.
const MIN_NON_LAST: usize = 7;

const BUFFER: usize = MAX_TRANSFER + CRC_LEN;

/// A complete transfer; the payload may end in zero bytes of padding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Transfer<'a> {
    /// Who sent what.
    pub id: CanId,
    /// Its transfer-id.
    pub transfer_id: TransferId,
    /// When its first frame was received, local time.
    pub received_at: Micros,
    /// What it carries.
    pub payload: &'a [u8],
}

/// What a [`Receiver`] noticed since it was made; saturating.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Complete transfers handed on.
    pub transfers: u32,
    /// Frames that break a rule of the framing by themselves.
    pub malformed: u32,
    /// Frames that repeat an earlier one, or arrive without their start.
    pub unexpected: u32,
    /// Transfers given up: a frame was missing, or they were longer than [`MAX_TRANSFER`].
    pub aborted: u32,
    /// Transfers with a wrong CRC.
    pub crc: u32,
    /// Transfers missing between two that were received, by their transfer-ids.
    pub lost: u32,
    /// Sessions given up to make room for others.
    pub evicted: u32,
}

#[derive(Clone, Debug)]
struct Session {
    source: NodeId,
    port: Port,
    /// The transfer-id now being received, or the one expected next.
    expected: TransferId,
    /// The toggle bit expected next.
    toggle: bool,
    /// Between the first and the last frame of a transfer.
    receiving: bool,
    len: usize,
    started: Micros,
    last: Micros,
    buffer: [u8; BUFFER],
}

impl Session {
    const fn new(source: NodeId, port: Port, tail: Tail, now: Micros) -> Self {
        Self {
            source,
            port,
            expected: tail.transfer_id,
            toggle: true,
            receiving: false,
            len: 0,
            started: now,
            last: now,
            buffer: [0; BUFFER],
        }
    }

    /// Gives up the transfer in progress; frames of `expected` are then no longer accepted.
    fn give_up(&mut self) {
        self.receiving = false;
        self.expected = self.expected.next();
        self.toggle = true;
    }

    /// `false` if the chunk does not fit.
    fn push(&mut self, chunk: &[u8]) -> bool {
        let rest = self.buffer.get_mut(self.len..).unwrap_or_default();
        match rest.get_mut(..chunk.len()) {
            Some(room) => {
                room.copy_from_slice(chunk);
                self.len = self.len.saturating_add(chunk.len());
                true
            }
            None => false,
        }
    }
}

/// Reassembles the transfers of up to `SESSIONS` pairs of source and port.
///
/// When a new pair needs room, the session that has been silent longest is given up. Memory is
/// `SESSIONS` times about 300 bytes; no input makes it grow, panic or loop.
#[derive(Clone, Debug, Default)]
pub struct Receiver<const SESSIONS: usize> {
    sessions: heapless::Vec<Session, SESSIONS>,
    counters: Counters,
}

fn count(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}

impl<const SESSIONS: usize> Receiver<SESSIONS> {
    /// Empty.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            sessions: heapless::Vec::new(),
            counters: Counters {
                transfers: 0,
                malformed: 0,
                unexpected: 0,
                aborted: 0,
                crc: 0,
                lost: 0,
                evicted: 0,
            },
        }
    }

    /// What was noticed so far.
    #[must_use]
    pub const fn counters(&self) -> Counters {
        self.counters
    }

    /// Takes the data of one frame received at `now` (local, monotonic); returns the transfer it
    /// completes. The caller decides by `id` what it wants to receive at all.
    pub fn accept(&mut self, id: CanId, data: &[u8], now: Micros) -> Option<Transfer<'_>> {
        let Some((&tail, chunk)) = data.split_last() else {
            count(&mut self.counters.malformed);
            return None;
        };
        let tail = Tail::parse(tail);
        let single = tail.start && tail.end;
        if (tail.start && !tail.toggle)
            || (!tail.end && chunk.len() < MIN_NON_LAST)
            || (!single && chunk.is_empty())
        {
            count(&mut self.counters.malformed);
            return None;
        }
        let index = self.session(id, tail, now)?;
        let counters = &mut self.counters;
        let session = self.sessions.get_mut(index)?;

        let silent = now.since(session.last) > TRANSFER_ID_TIMEOUT;
        if tail.start {
            // A transfer-id other than the expected one and the one just received starts anew.
            let ahead = tail.transfer_id.steps_since(session.expected);
            let other = ahead != 0 && ahead != 31;
            if silent || other {
                if session.receiving {
                    count(&mut counters.aborted);
                }
                if !silent {
                    let lost = if session.receiving { ahead - 1 } else { ahead };
                    counters.lost = counters.lost.saturating_add(u32::from(lost));
                }
                session.expected = tail.transfer_id;
                session.receiving = false;
                session.toggle = true;
            }
        }
        let in_sequence = tail.transfer_id == session.expected
            && tail.toggle == session.toggle
            && tail.start != session.receiving;
        if !in_sequence {
            count(&mut counters.unexpected);
            return None;
        }

        session.last = now;
        if tail.start {
            session.started = now;
            session.len = 0;
            session.receiving = true;
        }
        if !session.push(chunk) {
            session.give_up();
            count(&mut counters.aborted);
            return None;
        }
        session.toggle = !session.toggle;
        if !tail.end {
            return None;
        }
        session.give_up(); // complete: the next transfer-id is expected
        let received = session.buffer.get(..session.len)?;
        let payload = if single {
            received
        } else {
            // A CRC over data and its own CRC leaves nothing.
            if CRC.checksum(received) != 0 {
                count(&mut counters.crc);
                return None;
            }
            received.get(..received.len().checked_sub(CRC_LEN)?)?
        };
        count(&mut counters.transfers);
        Some(Transfer {
            id,
            transfer_id: tail.transfer_id,
            received_at: session.started,
            payload,
        })
    }

    /// The session of this source and port; a new one only for the first frame of a transfer.
    fn session(&mut self, id: CanId, tail: Tail, now: Micros) -> Option<usize> {
        let found = self
            .sessions
            .iter()
            .position(|session| session.source == id.source && session.port == id.port);
        if found.is_some() {
            return found;
        }
        if !tail.start {
            count(&mut self.counters.unexpected);
            return None;
        }
        let fresh = Session::new(id.source, id.port, tail, now);
        if self.sessions.len() < SESSIONS {
            self.sessions.push(fresh).ok()?;
            return self.sessions.len().checked_sub(1);
        }
        count(&mut self.counters.evicted);
        let (oldest, slot) = (0..SESSIONS)
            .zip(&mut self.sessions)
            .min_by_key(|(_, session)| session.last)?;
        *slot = fresh;
        Some(oldest)
    }
}
