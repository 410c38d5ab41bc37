//! The switch beside the node: ends its work in order, over the node's own protocol.
//!
//! ```text
//!  moving ──stop on the path──▶ at rest ──take the lease, disable──▶ torque off ──▶ done
//!                               faulted ──quick stop at rest───────▶ torque off ──▶ done
//! ```
//! Its frames go straight into the node and its answers are taken out again: none is on the wire.

use firmware::{Port, Received};
use protocol::frame::Frame;
use protocol::id::{CanId, NodeId, Port as WirePort};
use protocol::link::{Endpoint, Message, Role};
use protocol::message::{NodeState, Reply, Request, StopAll, StopKind};
use protocol::time::Micros;
use protocol::transfer::Mtu;

/// Its id: below every effector's, and not the MP's.
const PANEL: NodeId = match NodeId::new(NodeId::EFFECTOR_BASE - 1) {
    Some(id) => id,
    None => NodeId::MP,
};
/// Between two attempts.
const REPEAT: Micros = Micros::from_millis(100);
/// Torque is off and the drives are told so: this long before the process may end.
const LINGER: Micros = Micros::from_millis(150);
/// An orderly end takes no longer; after that torque is cut.
const PATIENCE: Micros = Micros::from_millis(5000);

/// How the end came about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ended {
    /// At rest first, then torque off.
    InOrder,
    /// Torque was cut.
    Cut,
}

/// Ends the work of a node.
#[derive(Debug)]
pub(crate) struct Panel {
    node: NodeId,
    link: Endpoint<4>,
    began: Micros,
    next: Micros,
    epoch: Option<u32>,
    cut: bool,
    off_since: Option<Micros>,
}

impl Panel {
    /// A switch that was thrown `now`.
    pub(crate) fn new(node: NodeId, now: Micros) -> Self {
        Self {
            node,
            link: Endpoint::new(PANEL, Role::Coordinator, Mtu::Fd),
            began: now,
            next: now,
            epoch: None,
            cut: false,
            off_since: None,
        }
    }

    /// Cut the torque at once.
    pub(crate) fn cut(&mut self, now: Micros) {
        if !self.cut {
            self.cut = true;
            self.next = now;
        }
    }

    /// Takes an outgoing frame of the node if it is for the panel.
    pub(crate) fn takes(&mut self, frame: &Frame, now: Micros) -> bool {
        let Some(CanId {
            port: WirePort::Response(_, PANEL),
            ..
        }) = CanId::parse(frame.id())
        else {
            return false;
        };
        if let Some(incoming) = self.link.receive(frame, now)
            && let Message::Reply {
                reply: Reply::Lease { epoch },
                ..
            } = incoming.message
        {
            self.epoch = Some(epoch);
            self.next = now;
        }
        true
    }

    /// What the node must hear now; `Some` when the end has come.
    pub(crate) fn step(
        &mut self,
        now: Micros,
        state: NodeState,
        rx: &mut Vec<Received>,
    ) -> Option<Ended> {
        if now.since(self.began) > PATIENCE {
            self.cut(now);
        }
        let off = match state {
            NodeState::Boot | NodeState::Configuring | NodeState::Disabled => true,
            // with torque still on after a path stop, until told otherwise
            NodeState::Faulted => self.off_since.is_some(),
            NodeState::Enabling
            | NodeState::Unsynchronised
            | NodeState::Synchronising
            | NodeState::Holding
            | NodeState::Moving
            | NodeState::Stopping => false,
        };
        let ended = if self.cut { Ended::Cut } else { Ended::InOrder };
        if off {
            let since = *self.off_since.get_or_insert(now);
            return (now.since(since) >= LINGER).then_some(ended);
        }
        if now.since(self.began) > PATIENCE + LINGER {
            return Some(ended);
        }
        if now < self.next {
            return None;
        }
        self.next = now + REPEAT;
        let mut put = |frame| {
            rx.push(Received {
                port: Port::Mp,
                at: now,
                frame,
            });
        };
        // what does not fit a transfer cannot be: the types exclude it
        let _ = match (state, self.epoch) {
            _ if self.cut => self.link.send_stop_all(
                &StopAll {
                    kind: StopKind::TorqueOff,
                },
                &mut put,
            ),
            (NodeState::Faulted, _) => {
                self.off_since = Some(now);
                self.link.send_stop_all(
                    &StopAll {
                        kind: StopKind::Quick,
                    },
                    &mut put,
                )
            }
            (NodeState::Holding | NodeState::Unsynchronised, None) => {
                let nonce = u32::from(PANEL.get());
                let request = Request::Acquire {
                    nonce,
                    lease_ms: 1000,
                    takeover: true,
                };
                self.link
                    .send_request(self.node, &request, &mut put)
                    .map(|_| ())
            }
            (NodeState::Holding | NodeState::Unsynchronised, Some(epoch)) => {
                // if it has been taken away since, it is asked for again
                self.epoch = None;
                let request = Request::Disable { epoch };
                self.link
                    .send_request(self.node, &request, &mut put)
                    .map(|_| ())
            }
            _ => self.link.send_stop_all(
                &StopAll {
                    kind: StopKind::Path,
                },
                &mut put,
            ),
        };
        None
    }
}
