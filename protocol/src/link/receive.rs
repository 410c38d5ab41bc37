//! Frames to typed messages.

use super::{Check, Endpoint, Incoming, Kind, Message, Role};
use crate::codec::{Payload, decode_padded, stated_epoch};
use crate::cyphal::Heartbeat;
use crate::e2e::{self, Checker, Outcome};
use crate::frame::Frame;
use crate::id::CanId;
use crate::message::Command;
use crate::time::Micros;
use crate::transfer::{Transfer, TransferId};

/// Why a transfer is no message: counted, never fatal.
enum Dropped {
    Undecodable,
    Unsafe,
}

/// What is needed to judge one transfer, apart from the transfer itself.
struct Judge<'a, const SESSIONS: usize> {
    checks: &'a mut heapless::Vec<Check, SESSIONS>,
    counters: &'a mut e2e::Counters,
    now: Micros,
}

impl<const SESSIONS: usize> Judge<'_, SESSIONS> {
    /// The checker of this sender and kind; the one silent longest makes room.
    fn checker(&mut self, id: CanId) -> Option<&mut Checker> {
        let found = self
            .checks
            .iter()
            .position(|check| check.from == id.source && check.port == id.port);
        let index = match found {
            Some(index) => index,
            None => self.slot(id)?,
        };
        let check = self.checks.get_mut(index)?;
        check.last = self.now;
        Some(&mut check.checker)
    }

    /// A fresh checker for this sender and kind.
    fn slot(&mut self, id: CanId) -> Option<usize> {
        let fresh = Check {
            from: id.source,
            port: id.port,
            last: self.now,
            checker: Checker::default(),
        };
        if self.checks.push(fresh).is_ok() {
            return self.checks.len().checked_sub(1);
        }
        let (oldest, place) = self
            .checks
            .iter_mut()
            .enumerate()
            .min_by_key(|(_, check)| check.last)?;
        *place = fresh;
        Some(oldest)
    }

    fn protected<M: Payload>(
        &mut self,
        transfer: &Transfer<'_>,
        epoch: u32,
    ) -> Result<(M, u8), Dropped> {
        let id = transfer.id;
        let data_id = e2e::data_id(id, epoch);
        if e2e::verify(data_id, transfer.payload).is_none() {
            return Err(self.refuse(Outcome::WrongCrc));
        }
        let now = self.now;
        let outcome = match self.checker(id) {
            Some(checker) => checker.check(data_id, transfer.payload, now),
            None => Outcome::Ok, // no sessions at all: nothing to compare with
        };
        if !outcome.is_valid() {
            return Err(self.refuse(outcome));
        }
        self.counters.record(outcome);
        let message = transfer.payload.get(e2e::HEADER..).unwrap_or(&[]);
        Ok((plain(message)?, outcome.lost()))
    }

    /// A command counts only under the epoch of the lease; an observer believes the one it states.
    fn command(
        &mut self,
        transfer: &Transfer<'_>,
        lease: Option<u32>,
    ) -> Result<(Command, u8), Dropped> {
        let stated = transfer.payload.get(e2e::HEADER..).and_then(stated_epoch);
        match (lease, stated) {
            (Some(lease), Some(stated)) if lease != stated => {
                // Whole, but of another lease? Then it is stale, not damaged.
                let data_id = e2e::data_id(transfer.id, stated);
                let whole = e2e::verify(data_id, transfer.payload).is_some();
                Err(self.refuse(if whole {
                    Outcome::Stale
                } else {
                    Outcome::WrongCrc
                }))
            }
            (lease, stated) => self.protected(transfer, lease.or(stated).unwrap_or(0)),
        }
    }

    /// Requests and replies: the counter is the transfer-id, and no sequence is kept.
    fn service<M: Payload>(&mut self, transfer: &Transfer<'_>) -> Result<M, Dropped> {
        let data_id = e2e::data_id(transfer.id, 0);
        match e2e::verify(data_id, transfer.payload) {
            Some((counter, message)) if counter == transfer.transfer_id.get() => {
                self.counters.record(Outcome::Ok);
                plain(message)
            }
            Some(_) => Err(self.refuse(Outcome::Stale)),
            None => Err(self.refuse(Outcome::WrongCrc)),
        }
    }

    fn refuse(&mut self, outcome: Outcome) -> Dropped {
        self.counters.record(outcome);
        Dropped::Unsafe
    }
}

fn plain<M: Payload>(payload: &[u8]) -> Result<M, Dropped> {
    decode_padded(payload).map_err(|_| Dropped::Undecodable)
}

impl<const SESSIONS: usize> Endpoint<SESSIONS> {
    /// Takes one frame received at `now`; returns the message it completes, if it is valid and
    /// concerns this endpoint. Whatever else arrives is dropped and counted in
    /// [`Endpoint::statistics`].
    pub fn receive(&mut self, frame: &Frame, now: Micros) -> Option<Incoming> {
        self.receive_by(frame, now, read)
    }

    /// The same for a node: an image that only calls this has none of what others hear, 8 kB of decoders.
    // a frame of its own: what its caller does with the message must not lie below it on the stack
    #[inline(never)]
    pub fn receive_at_node(&mut self, frame: &Frame, now: Micros) -> Option<Incoming> {
        self.receive_by(frame, now, read_at_node)
    }

    #[inline]
    fn receive_by(
        &mut self,
        frame: &Frame,
        now: Micros,
        read: impl FnOnce(
            Kind,
            &Transfer<'_>,
            Option<u32>,
            &mut Judge<'_, SESSIONS>,
        ) -> Result<(Message, u8), Dropped>,
    ) -> Option<Incoming> {
        let id = CanId::parse(frame.id())?;
        let (kind, to) = Kind::of(id.port)?;
        if id.source == self.node && self.role != Role::Observer {
            self.statistics.own_id = self.statistics.own_id.saturating_add(1);
            return None;
        }
        let for_me = self.role == Role::Observer || to.is_none_or(|to| to == self.node);
        if !for_me || !kind.concerns(self.role) {
            return None;
        }
        let transfer = self.receiver.accept(id, frame.data(), now)?;
        let lease = (self.role != Role::Observer).then_some(self.lease_epoch);
        let mut judge = Judge {
            checks: &mut self.checks,
            counters: &mut self.statistics.e2e,
            now,
        };
        match read(kind, &transfer, lease, &mut judge) {
            Ok((message, lost)) => Some(Incoming {
                from: id.source,
                received_at: transfer.received_at,
                lost,
                message,
            }),
            Err(Dropped::Undecodable) => {
                self.statistics.undecodable = self.statistics.undecodable.saturating_add(1);
                None
            }
            Err(Dropped::Unsafe) => None,
        }
    }
}

/// What a node hears.
fn read_at_node<const SESSIONS: usize>(
    kind: Kind,
    transfer: &Transfer<'_>,
    lease: Option<u32>,
    judge: &mut Judge<'_, SESSIONS>,
) -> Result<(Message, u8), Dropped> {
    match kind {
        Kind::Command => command(judge, transfer, lease),
        Kind::StopAll => protected(judge, transfer, Message::StopAll),
        Kind::TimeSync => protected(judge, transfer, Message::TimeSync),
        Kind::Request => service(judge, transfer, |transfer_id, request| Message::Request {
            transfer_id,
            request,
        }),
        Kind::Maintenance => service(judge, transfer, |transfer_id, request| {
            Message::Maintenance {
                transfer_id,
                request,
            }
        }),
        Kind::GetInfo => {
            let transfer_id = transfer.transfer_id;
            Ok((Message::GetInfo { transfer_id }, 0))
        }
        Kind::Feedback
        | Kind::DemandTrace
        | Kind::Event
        | Kind::Heartbeat
        | Kind::Reply
        | Kind::MaintenanceReply => Err(Dropped::Undecodable),
    }
}

/// What anybody may hear.
fn read<const SESSIONS: usize>(
    kind: Kind,
    transfer: &Transfer<'_>,
    lease: Option<u32>,
    judge: &mut Judge<'_, SESSIONS>,
) -> Result<(Message, u8), Dropped> {
    match kind {
        Kind::Feedback => protected(judge, transfer, Message::Feedback),
        Kind::DemandTrace => open(transfer, Message::DemandTrace),
        Kind::Event => open(transfer, Message::Event),
        Kind::Heartbeat => Ok((Message::Heartbeat(Heartbeat::parse(transfer.payload)), 0)),
        Kind::Reply => service(judge, transfer, |transfer_id, reply| Message::Reply {
            transfer_id,
            reply,
        }),
        Kind::MaintenanceReply => service(judge, transfer, |transfer_id, reply| {
            Message::MaintenanceReply { transfer_id, reply }
        }),
        Kind::Command
        | Kind::StopAll
        | Kind::TimeSync
        | Kind::Request
        | Kind::Maintenance
        | Kind::GetInfo => read_at_node(kind, transfer, lease, judge),
    }
}

// Frames of their own: messages of several types, one beside the other, would make one of 2 kB.

#[inline(never)]
fn command<const SESSIONS: usize>(
    judge: &mut Judge<'_, SESSIONS>,
    transfer: &Transfer<'_>,
    lease: Option<u32>,
) -> Result<(Message, u8), Dropped> {
    let (command, lost) = judge.command(transfer, lease)?;
    Ok((Message::Command(command), lost))
}

#[inline(never)]
fn protected<M: Payload, const SESSIONS: usize>(
    judge: &mut Judge<'_, SESSIONS>,
    transfer: &Transfer<'_>,
    message: fn(M) -> Message,
) -> Result<(Message, u8), Dropped> {
    let (content, lost) = judge.protected(transfer, 0)?;
    Ok((message(content), lost))
}

#[inline(never)]
fn service<M: Payload, const SESSIONS: usize>(
    judge: &mut Judge<'_, SESSIONS>,
    transfer: &Transfer<'_>,
    message: fn(TransferId, M) -> Message,
) -> Result<(Message, u8), Dropped> {
    let content = judge.service(transfer)?;
    Ok((message(transfer.transfer_id, content), 0))
}

#[inline(never)]
fn open<M: Payload>(
    transfer: &Transfer<'_>,
    message: fn(M) -> Message,
) -> Result<(Message, u8), Dropped> {
    Ok((message(plain(transfer.payload)?), 0))
}
