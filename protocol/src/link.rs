//! The two ends of the MP wire: typed messages in, frames out, and back.
//!
//! An [`Endpoint`] owns the transfer-ids, the reassembly and the end-to-end protection of one
//! participant. It knows no clock and no bus: times are arguments, frames go to a closure.
//!
//! ```
//! use protocol::id::NodeId;
//! use protocol::link::{Endpoint, Message, Role};
//! use protocol::message::{Request, StopKind};
//! use protocol::time::Micros;
//! use protocol::transfer::Mtu;
//!
//! let robot = NodeId::effector(1).unwrap();
//! let mut mp = Endpoint::<16>::new(NodeId::MP, Role::Coordinator, Mtu::Fd);
//! let mut node = Endpoint::<8>::new(robot, Role::Node, Mtu::Fd);
//!
//! let mut wire = Vec::new();
//! mp.send_request(robot, &Request::Stop { kind: StopKind::Path }, &mut |f| wire.push(f)).unwrap();
//! let heard = wire.iter().find_map(|frame| node.receive(frame, Micros(100))).unwrap();
//! assert_eq!(heard.from, NodeId::MP);
//! assert!(matches!(heard.message, Message::Request { .. }));
//! ```
//!
//! Times given to an endpoint are local and monotonic; they need no relation to bus time.

mod receive;
mod send;

use crate::cyphal::Heartbeat;
use crate::e2e;
use crate::id::{NodeId, Port, Service, Subject};
use crate::maintenance::{MaintenanceReply, MaintenanceRequest};
use crate::message::{Command, DemandTrace, Event, Feedback, Reply, Request, StopAll, TimeSync};
use crate::time::Micros;
use crate::transfer::{self, Mtu, Receiver, TransferId};

/// Which messages an endpoint listens to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// A controller node: commands and requests to itself, stops, time.
    Node,
    /// The coordinating process: what nodes say, replies to itself, stops, time.
    Coordinator,
    /// A monitor: everything, whoever it is for. It should not send.
    Observer,
}

/// A message that arrived, with who sent it and when.
#[derive(Clone, Debug, PartialEq)]
pub struct Incoming {
    /// The sender.
    pub from: NodeId,
    /// When its first frame was received, local time.
    pub received_at: Micros,
    /// Protected messages of this kind from this sender found missing just before this one.
    pub lost: u8,
    /// What it says.
    pub message: Message,
}

/// Everything that can arrive on the MP wire.
#[derive(Clone, Debug, PartialEq)]
pub enum Message {
    /// The cyclic command. Only of the epoch set by [`Endpoint::set_lease`], except to an observer.
    Command(Command),
    /// A node's image.
    Feedback(Feedback),
    /// A servo step's demand.
    DemandTrace(DemandTrace),
    /// Something that happened once.
    Event(Event),
    /// Stop everyone.
    StopAll(StopAll),
    /// Time.
    TimeSync(TimeSync),
    /// A participant is alive.
    Heartbeat(Heartbeat),
    /// A request; answer it with [`Endpoint::send_reply`] and the same transfer-id.
    Request {
        /// To be repeated in the reply.
        transfer_id: TransferId,
        /// What is asked for.
        request: Request,
    },
    /// The answer to the request that [`Endpoint::send_request`] gave this transfer-id.
    Reply {
        /// Of the request.
        transfer_id: TransferId,
        /// The answer.
        reply: Reply,
    },
    /// A request to the maintenance service; answer it with [`Endpoint::send_maintenance_reply`] and the same
    /// transfer-id.
    Maintenance {
        /// To be repeated in the reply.
        transfer_id: TransferId,
        /// What is asked for.
        request: MaintenanceRequest,
    },
    /// The answer to the request that [`Endpoint::send_maintenance`] gave this transfer-id.
    MaintenanceReply {
        /// Of the request.
        transfer_id: TransferId,
        /// The answer.
        reply: MaintenanceReply,
    },
    /// `uavcan.node.GetInfo`; answer it with [`Endpoint::send_node_info`].
    GetInfo {
        /// To be repeated in the answer.
        transfer_id: TransferId,
    },
}

/// The kinds of transfers this system knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Command,
    Feedback,
    DemandTrace,
    Event,
    StopAll,
    TimeSync,
    Heartbeat,
    Request,
    Reply,
    Maintenance,
    MaintenanceReply,
    GetInfo,
}

impl Kind {
    /// The kind of a port, and the node it is for, if it is for one.
    fn of(port: Port) -> Option<(Self, Option<NodeId>)> {
        Some(match port {
            Port::Message(Subject::FEEDBACK) => (Self::Feedback, None),
            Port::Message(Subject::DEMAND_TRACE) => (Self::DemandTrace, None),
            Port::Message(Subject::EVENT) => (Self::Event, None),
            Port::Message(Subject::STOP_ALL) => (Self::StopAll, None),
            Port::Message(Subject::TIME_SYNC) => (Self::TimeSync, None),
            Port::Message(Subject::HEARTBEAT) => (Self::Heartbeat, None),
            Port::Message(subject) => (Self::Command, Some(subject.command_destination()?)),
            Port::Request(Service::REQUEST, to) => (Self::Request, Some(to)),
            Port::Response(Service::REQUEST, to) => (Self::Reply, Some(to)),
            Port::Request(Service::MAINTENANCE, to) => (Self::Maintenance, Some(to)),
            Port::Response(Service::MAINTENANCE, to) => (Self::MaintenanceReply, Some(to)),
            Port::Request(Service::GET_INFO, to) => (Self::GetInfo, Some(to)),
            Port::Request(..) | Port::Response(..) => return None,
        })
    }

    /// Does an endpoint of this role care?
    const fn concerns(self, role: Role) -> bool {
        match role {
            Role::Observer => true,
            Role::Node => matches!(
                self,
                Self::Command
                    | Self::StopAll
                    | Self::TimeSync
                    | Self::Request
                    | Self::Maintenance
                    | Self::GetInfo
            ),
            Role::Coordinator => matches!(
                self,
                Self::Feedback
                    | Self::DemandTrace
                    | Self::Event
                    | Self::StopAll
                    | Self::TimeSync
                    | Self::Heartbeat
                    | Self::Reply
                    | Self::MaintenanceReply
                    | Self::GetInfo
            ),
        }
    }
}

/// What an endpoint noticed since it was made; saturating.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Of the framing.
    pub transfer: transfer::Counters,
    /// Of the end-to-end protection.
    pub e2e: e2e::Counters,
    /// Complete transfers that were no message.
    pub undecodable: u32,
    /// Frames that carry this endpoint's own node id as source: another node has the same id.
    pub own_id: u32,
}

#[derive(Clone, Copy, Debug)]
struct Check {
    from: NodeId,
    port: Port,
    last: Micros,
    checker: e2e::Checker,
}

/// The broadcast sessions an endpoint sends; each counts by itself.
#[derive(Clone, Copy, Debug, Default)]
struct Broadcasts {
    feedback: u8,
    demand_trace: u8,
    event: u8,
    stop_all: u8,
    time_sync: u8,
    heartbeat: u8,
}

const NODES: usize = NodeId::MAX as usize + 1;

/// One participant of the MP wire; `SESSIONS` is how many pairs of sender and kind of message it
/// follows at once (a node: 2 per coordinator, plus 2; a coordinator: 5 per node, plus 2). Beyond
/// that the pair that has been silent longest is forgotten.
#[derive(Clone, Debug)]
pub struct Endpoint<const SESSIONS: usize> {
    node: NodeId,
    role: Role,
    mtu: Mtu,
    lease_epoch: u32,
    receiver: Receiver<SESSIONS>,
    checks: heapless::Vec<Check, SESSIONS>,
    broadcasts: Broadcasts,
    /// By destination. The counter of a session is its E2E counter; its lowest five bits are its
    /// transfer-id.
    commands: [u8; NODES],
    requests: [u8; NODES],
    next_heartbeat: Micros,
    statistics: Statistics,
}

impl<const SESSIONS: usize> Endpoint<SESSIONS> {
    /// A participant that has neither sent nor heard anything.
    #[must_use]
    pub fn new(node: NodeId, role: Role, mtu: Mtu) -> Self {
        Self {
            node,
            role,
            mtu,
            lease_epoch: 0,
            receiver: Receiver::new(),
            checks: heapless::Vec::new(),
            broadcasts: Broadcasts::default(),
            commands: [0; NODES],
            requests: [0; NODES],
            next_heartbeat: Micros(0),
            statistics: Statistics::default(),
        }
    }

    /// Its node id.
    #[must_use]
    pub const fn node(&self) -> NodeId {
        self.node
    }

    /// The size of its frames. Frames of both sizes are received.
    #[must_use]
    pub const fn mtu(&self) -> Mtu {
        self.mtu
    }

    /// Chooses the size of frames sent from now on.
    pub const fn set_mtu(&mut self, mtu: Mtu) {
        self.mtu = mtu;
    }

    /// On a node: the epoch whose commands are heard from now on; 0 = none. All others count as
    /// stale.
    pub fn set_lease(&mut self, epoch: u32) {
        self.lease_epoch = epoch;
        let mut kept = heapless::Vec::new();
        for check in &self.checks {
            if !matches!(Kind::of(check.port), Some((Kind::Command, _))) {
                // as many places as before
                let _ = kept.push(*check);
            }
        }
        self.checks = kept;
    }

    /// What was noticed so far.
    #[must_use]
    pub fn statistics(&self) -> Statistics {
        Statistics {
            transfer: self.receiver.counters(),
            ..self.statistics
        }
    }
}
