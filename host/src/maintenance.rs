//! Asking one node who it is, why it started and what its first fault looked like, and sending it an image.
//!
//! A [`Client`] is no MP: it commands no motion. To write it takes the lease and renews it with commands that ask for
//! nothing. Every request is repeated until it is answered; a node takes a repetition for what it is.

mod image;

pub use image::{SENT, Sending};

use crate::error::Error;
use core::fmt;
use protocol::codec::EncodeError;
use protocol::fault::Refusal;
use protocol::frame::Frame;
use protocol::id::NodeId;
use protocol::link::{Endpoint, Incoming, Message, Role};
use protocol::maintenance::{
    FaultRecord, MaintenanceRefusal, MaintenanceReply, MaintenanceRequest, NodeIdentity,
    ResetReport, Sample, Standing,
};
use protocol::message::{Command, Coordination, Identity, Reply, Request};
use protocol::time::Micros;
use protocol::transfer::{Mtu, TransferId};

/// The number of whoever keeps nodes, by default: not the MP's, and not that of `mrroc stop`.
pub const KEEPER: u8 = 3;

/// How long an answer is awaited before the request is repeated.
const ANSWER: Micros = Micros::from_millis(300);
/// How often a request is sent.
const TRIES: u32 = 6;
/// The lease, ms, and how often it is renewed meanwhile.
const LEASE_MS: u16 = 1000;
const RENEW: Micros = Micros::from_millis(100);
/// How long a node may take to be there again: a bootloader compares the CRC of two images.
const RESTARTED: Micros = Micros::from_millis(10_000);
/// Time passes in pieces of this length.
const SLICE: Micros = Micros::from_millis(5);
/// No record has more samples.
const MOST_SAMPLES: u16 = 1000;

/// The way to the nodes.
pub trait Wire {
    /// How long the frames may be.
    fn mtu(&self) -> Mtu;
    /// The time.
    fn now(&self) -> Micros;
    /// Send a frame, now.
    ///
    /// # Errors
    /// The bus has gone.
    fn send(&mut self, frame: &Frame) -> Result<(), Error>;
    /// Let time pass, at most until then, and append what arrived meanwhile.
    ///
    /// # Errors
    /// The bus has gone.
    fn pass(&mut self, until: Micros, rx: &mut Vec<(Micros, Frame)>) -> Result<(), Error>;
    /// Does the operator want it to end?
    fn ends(&self) -> bool {
        false
    }
}

#[derive(Clone, Copy, Debug)]
struct Lease {
    epoch: u32,
    sequence: u16,
    next: Micros,
}

/// A conversation with one node.
pub struct Client<'a, W: ?Sized> {
    wire: &'a mut W,
    link: Endpoint<8>,
    node: NodeId,
    name: String,
    rx: Vec<(Micros, Frame)>,
    lease: Option<Lease>,
}

impl<W: ?Sized> fmt::Debug for Client<'_, W> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Client")
            .field("node", &self.node)
            .field("lease", &self.lease)
            .finish_non_exhaustive()
    }
}

/// An answer, and after how many repetitions it came.
struct Answer<T> {
    is: T,
    repeated: u32,
}

fn internal(error: EncodeError) -> Error {
    Error::Internal(error.to_string())
}

impl<'a, W: Wire + ?Sized> Client<'a, W> {
    /// To talk to `node`, which messages call `name`, as number `me`.
    pub fn new(wire: &'a mut W, me: NodeId, node: NodeId, name: String) -> Self {
        let mtu = wire.mtu();
        Self {
            wire,
            link: Endpoint::new(me, Role::Coordinator, mtu),
            node,
            name,
            rx: Vec::new(),
            lease: None,
        }
    }

    /// What messages call the node.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    fn post(
        &mut self,
        send: impl FnOnce(&mut Endpoint<8>, &mut Vec<Frame>) -> Result<(), EncodeError>,
    ) -> Result<(), Error> {
        let mut frames = Vec::new();
        send(&mut self.link, &mut frames).map_err(internal)?;
        for frame in frames {
            self.wire.send(&frame)?;
        }
        Ok(())
    }

    /// Renews the lease if it is time to.
    fn renew(&mut self) -> Result<(), Error> {
        let now = self.wire.now();
        let Some(lease) = self.lease.as_mut().filter(|lease| lease.next <= now) else {
            return Ok(());
        };
        lease.sequence = lease.sequence.wrapping_add(1);
        lease.next = now + RENEW;
        let command = Command {
            epoch: lease.epoch,
            sequence: lease.sequence,
            // it asks for nothing, so it cannot be too late
            valid_until: Micros(u64::MAX),
            coordination: Coordination::None,
        };
        let node = self.node;
        self.post(|link, frames| link.send_command(node, &command, &mut |f| frames.push(f)))
    }

    /// Sends until `is` finds its answer; how often it was sent more than once.
    fn ask_until<T>(
        &mut self,
        mut send: impl FnMut(&mut Endpoint<8>, &mut Vec<Frame>) -> Result<TransferId, EncodeError>,
        mut is: impl FnMut(TransferId, &Incoming) -> Option<T>,
    ) -> Result<Answer<T>, Error> {
        for repeated in 0..TRIES {
            let mut id = TransferId::default();
            self.post(|link, frames| send(link, frames).map(|sent| id = sent))?;
            let end = self.wire.now() + ANSWER;
            while self.wire.now() < end {
                if self.wire.ends() {
                    return Err(Error::Stopped { step: None });
                }
                self.renew()?;
                let mut rx = core::mem::take(&mut self.rx);
                let until = (self.wire.now() + SLICE).min(end);
                self.wire.pass(until, &mut rx)?;
                let mut found = None;
                for (at, frame) in rx.drain(..) {
                    let heard = self.link.receive(&frame, at);
                    let heard = heard.filter(|incoming| incoming.from == self.node);
                    found = found.or_else(|| heard.and_then(|incoming| is(id, &incoming)));
                }
                self.rx = rx;
                if let Some(is) = found {
                    return Ok(Answer { is, repeated });
                }
            }
        }
        let waited_ms = ANSWER.0 / 1000 * u64::from(TRIES);
        Err(Error::Silent {
            robot: self.name.clone(),
            waited_ms: u32::try_from(waited_ms).unwrap_or(u32::MAX),
        })
    }

    fn ask(&mut self, request: &MaintenanceRequest) -> Result<Answer<MaintenanceReply>, Error> {
        let node = self.node;
        self.ask_until(
            |link, frames| link.send_maintenance(node, request, &mut |f| frames.push(f)),
            |id, incoming| match &incoming.message {
                Message::MaintenanceReply { transfer_id, reply } if *transfer_id == id => {
                    Some(reply.clone())
                }
                _ => None,
            },
        )
    }

    fn request(&mut self, request: &Request) -> Result<Reply, Error> {
        let node = self.node;
        let answer = self.ask_until(
            |link, frames| link.send_request(node, request, &mut |f| frames.push(f)),
            |id, incoming| match &incoming.message {
                Message::Reply { transfer_id, reply } if *transfer_id == id => Some(reply.clone()),
                _ => None,
            },
        )?;
        Ok(answer.is)
    }

    fn refused(&self, refusal: MaintenanceRefusal) -> Error {
        Error::Maintenance {
            robot: self.name.clone(),
            refusal,
        }
    }

    /// Not an answer to what was asked.
    fn unexpected(&self, reply: &MaintenanceReply) -> Error {
        match reply {
            MaintenanceReply::Refused(refusal) => self.refused(*refusal),
            _ => Error::Protocol {
                robot: self.name.clone(),
                what: "answer",
                expected: "one to the request".into(),
                got: format!("{reply:?}").chars().take(80).collect(),
            },
        }
    }

    /// Who the node is, as the maintenance service tells it.
    ///
    /// # Errors
    /// [`Error::Silent`], or the bus has gone.
    pub fn identify(&mut self) -> Result<NodeIdentity, Error> {
        match self.ask(&MaintenanceRequest::Identify)?.is {
            MaintenanceReply::Identity(identity) => Ok(identity),
            other => Err(self.unexpected(&other)),
        }
    }

    /// Who the node is, as every node tells it, also one without the maintenance service.
    ///
    /// # Errors
    /// [`Error::Silent`], or the bus has gone.
    pub fn identify_plainly(&mut self) -> Result<Identity, Error> {
        match self.request(&Request::Identify)? {
            Reply::Identity(identity) => Ok(identity),
            other => Err(Error::Internal(format!("{other:?} to Identify"))),
        }
    }

    /// Why the node started.
    ///
    /// # Errors
    /// [`Error::Silent`], or the bus has gone.
    pub fn reset_cause(&mut self) -> Result<ResetReport, Error> {
        match self.ask(&MaintenanceRequest::ResetCause)?.is {
            MaintenanceReply::Reset(report) => Ok(report),
            other => Err(self.unexpected(&other)),
        }
    }

    /// The record of the first fault, if there is one.
    ///
    /// # Errors
    /// [`Error::Silent`], or the bus has gone.
    pub fn first_fault(&mut self) -> Result<Option<FaultRecord>, Error> {
        match self.ask(&MaintenanceRequest::FirstFault)?.is {
            MaintenanceReply::NoFault => Ok(None),
            MaintenanceReply::FirstFault(record) => Ok(Some(record)),
            other => Err(self.unexpected(&other)),
        }
    }

    /// The samples of a record, the oldest first.
    ///
    /// # Errors
    /// [`Error::Maintenance`] if the node forgot the record meanwhile; [`Error::Silent`]; the bus has gone.
    pub fn samples(&mut self, record: &FaultRecord) -> Result<Vec<Sample>, Error> {
        let mut all = Vec::new();
        let number = record.record;
        while let Some(first) = u16::try_from(all.len()).ok().filter(|n| *n < MOST_SAMPLES) {
            let request = MaintenanceRequest::Samples {
                record: number,
                first,
            };
            match self.ask(&request)?.is {
                MaintenanceReply::Samples {
                    record,
                    first: begin,
                    samples,
                } if record == number && begin == first => {
                    if samples.is_empty() {
                        break;
                    }
                    all.extend(samples);
                }
                other => return Err(self.unexpected(&other)),
            }
        }
        Ok(all)
    }

    /// Takes the lease, to write; gives the new epoch.
    ///
    /// # Errors
    /// [`Error::LeaseHeld`]; [`Error::Silent`]; the bus has gone.
    pub fn acquire(&mut self) -> Result<u32, Error> {
        let request = Request::Acquire {
            nonce: u32::from(self.link.node().get()),
            lease_ms: LEASE_MS,
            takeover: false,
        };
        match self.request(&request)? {
            Reply::Lease { epoch } => {
                self.lease = Some(Lease {
                    epoch,
                    sequence: 0,
                    next: self.wire.now(),
                });
                Ok(epoch)
            }
            Reply::Refused(Refusal::LeaseHeld { holder }) => Err(Error::LeaseHeld {
                robot: self.name.clone(),
                holder,
            }),
            Reply::Refused(refusal) => Err(Error::Refused {
                robot: self.name.clone(),
                step: None,
                refusal,
            }),
            other => Err(Error::Internal(format!("{other:?} to Acquire"))),
        }
    }

    /// Gives the lease back. One that is lost already is given back as well.
    ///
    /// # Errors
    /// [`Error::Silent`], or the bus has gone.
    pub fn release(&mut self) -> Result<(), Error> {
        match self.lease.take() {
            Some(Lease { epoch, .. }) => self.request(&Request::Release { epoch }).map(|_| ()),
            None => Ok(()),
        }
    }

    fn epoch(&self) -> u32 {
        self.lease.map_or(0, |lease| lease.epoch)
    }

    /// Forgets a record. Needs the lease.
    ///
    /// # Errors
    /// [`Error::Maintenance`]; [`Error::Silent`]; the bus has gone.
    pub fn clear(&mut self, record: &FaultRecord) -> Result<(), Error> {
        let request = MaintenanceRequest::ClearFault {
            epoch: self.epoch(),
            record: record.record,
        };
        let Answer { is, repeated } = self.ask(&request)?;
        match is {
            MaintenanceReply::Done => Ok(()),
            // the answer that was lost said that it is forgotten
            MaintenanceReply::Refused(MaintenanceRefusal::NoRecord) if repeated > 0 => Ok(()),
            other => Err(self.unexpected(&other)),
        }
    }

    /// Lets the node start anew, and waits until it has. Needs the lease, which is lost with it.
    ///
    /// # Errors
    /// [`Error::Maintenance`]; [`Error::Silent`], also if it does not come back; the bus has gone.
    pub fn restart(&mut self) -> Result<ResetReport, Error> {
        let before = self.reset_cause()?;
        let request = MaintenanceRequest::Restart {
            epoch: self.epoch(),
        };
        let anew = |now: &ResetReport| now.boots != before.boots || now.steps < before.steps;
        let Answer { is, repeated } = self.ask(&request)?;
        match is {
            MaintenanceReply::Done => {}
            // it restarted, the answer was lost, and it no longer knows of our lease
            MaintenanceReply::Refused(MaintenanceRefusal::NoLease { .. }) if repeated > 0 => {}
            other => return Err(self.unexpected(&other)),
        }
        self.lease = None;
        let until = self.wire.now() + RESTARTED;
        loop {
            match self.reset_cause() {
                Ok(now) if anew(&now) => return Ok(now),
                Ok(_) | Err(Error::Silent { .. }) if self.wire.now() < until => {}
                Ok(_) => {
                    return Err(Error::Silent {
                        robot: self.name.clone(),
                        waited_ms: u32::try_from(RESTARTED.0 / 1000).unwrap_or(u32::MAX),
                    });
                }
                Err(error) => return Err(error),
            }
        }
    }

    /// Keeps the image that runs on trial. Needs the lease.
    ///
    /// # Errors
    /// [`Error::Maintenance`]; [`Error::Silent`]; the bus has gone.
    pub fn confirm(&mut self) -> Result<(), Error> {
        let request = MaintenanceRequest::ConfirmImage {
            epoch: self.epoch(),
        };
        let Answer { is, repeated } = self.ask(&request)?;
        match is {
            MaintenanceReply::Done => Ok(()),
            // the answer that was lost said that it is kept, if it is
            MaintenanceReply::Refused(MaintenanceRefusal::NotOnTrial) if repeated > 0 => {
                match self.identify()?.image.map(|image| image.standing) {
                    Some(Standing::Confirmed) => Ok(()),
                    _ => Err(self.refused(MaintenanceRefusal::NotOnTrial)),
                }
            }
            other => Err(self.unexpected(&other)),
        }
    }
}
