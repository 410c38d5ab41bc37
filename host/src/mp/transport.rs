//! One robot's side of the wire: requests with their repetitions, the cyclic command, the lease.

use super::command::RobotCommand;
use super::config::{Timing, ms};
use super::failure::Asked;
use super::robot::{Image, Link, PathWanted, Request as State};
use protocol::fault::Refusal;
use protocol::frame::Frame;
use protocol::id::NodeId;
use protocol::link::Endpoint;
use protocol::message::{
    Command, Coordination, Decision, Instruction, KnotMessage, NodeState, PoseMessage, Reply,
    Request, StopKind,
};
use protocol::time::Micros;
use protocol::transfer::TransferId;
use std::collections::VecDeque;

/// Sessions of the link: five kinds of messages from each of 12 robots, and two more.
pub(super) const SESSIONS: usize = 64;

/// What is to be sent to one robot.
#[derive(Debug)]
pub(super) struct Transport {
    node: NodeId,
    pending: Option<Pending>,
    queue: VecDeque<Request>,
    sequence: u16,
    decision: Option<Decision>,
    knots: VecDeque<KnotMessage>,
    repeated: VecDeque<KnotMessage>,
}

#[derive(Debug)]
struct Pending {
    request: Request,
    sent: Vec<TransferId>,
    sent_at: Option<Micros>,
}

/// The kind of a request.
const fn asked(request: &Request) -> Asked {
    match request {
        Request::Identify => Asked::Identify,
        Request::Acquire { .. } => Asked::Acquire,
        Request::Release { .. } => Asked::Release,
        Request::Enable { .. } => Asked::Enable,
        Request::Disable { .. } => Asked::Disable,
        Request::Synchronise { .. } => Asked::Synchronise,
        Request::Execute { .. } => Asked::Execute,
        Request::EndMotion { .. } => Asked::EndMotion,
        Request::Stop { .. } => Asked::Stop,
        Request::Acknowledge { .. } => Asked::Acknowledge,
        Request::SelectServo { .. } => Asked::SelectServo,
        Request::SetTool { .. } => Asked::SetTool,
        Request::Trace { .. } => Asked::Trace,
        Request::Path { .. } => Asked::Path,
        Request::FeedOverride { .. } => Asked::FeedOverride,
        Request::Outputs { .. } => Asked::Outputs,
    }
}

/// Does this refusal of a *repeated* request only say that an earlier try arrived and its answer
/// was lost?
fn arrived_before(request: &Request, refusal: &Refusal) -> bool {
    match (request, refusal) {
        (Request::Execute { id, .. }, Refusal::Stale { last }) => id == last,
        // it waits for its start or runs already; the feedback tells whether it is ours
        (Request::Execute { .. }, Refusal::WrongState { state }) => *state == NodeState::Moving,
        (Request::Release { .. }, Refusal::NoLease { epoch }) => *epoch == 0,
        (Request::Enable { .. }, Refusal::WrongState { state }) => matches!(
            state,
            NodeState::Enabling | NodeState::Unsynchronised | NodeState::Holding
        ),
        (Request::Disable { .. }, Refusal::WrongState { state }) => *state == NodeState::Disabled,
        (Request::Synchronise { .. }, Refusal::WrongState { state }) => {
            matches!(state, NodeState::Synchronising | NodeState::Holding)
        }
        (Request::Acknowledge { .. }, Refusal::WrongState { state }) => {
            *state != NodeState::Faulted
        }
        // the last elements arrived, and the path has ended since; the feedback tells how
        (Request::Path { .. } | Request::FeedOverride { .. }, Refusal::WrongState { state }) => {
            *state == NodeState::Holding
        }
        _ => false,
    }
}

impl Transport {
    pub(super) fn new(node: NodeId) -> Self {
        Self {
            node,
            pending: None,
            queue: VecDeque::new(),
            sequence: 0,
            decision: None,
            knots: VecDeque::new(),
            repeated: VecDeque::new(),
        }
    }

    /// Takes what a behaviour commands; the image shows at once that something was asked for.
    pub(super) fn take(&mut self, image: &mut Image, command: RobotCommand, config: &Lease) {
        let epoch = image.epoch().unwrap_or(0);
        let request = match command {
            RobotCommand::Loose(decision) => {
                self.decision = Some(decision);
                return;
            }
            RobotCommand::Tight(knots) => {
                self.knots.extend(knots);
                return;
            }
            RobotCommand::Identify => Request::Identify,
            RobotCommand::Acquire => Request::Acquire {
                nonce: config.nonce,
                lease_ms: u16::try_from(config.term_ms).unwrap_or(u16::MAX),
                takeover: config.takeover,
            },
            RobotCommand::Release => Request::Release { epoch },
            RobotCommand::Enable => Request::Enable { epoch },
            RobotCommand::Disable => Request::Disable { epoch },
            RobotCommand::Synchronise => Request::Synchronise { epoch },
            RobotCommand::Start { program, argument } => {
                let instruction = Instruction::Program { program, argument };
                Self::execute(image, epoch, instruction, Micros(0))
            }
            RobotCommand::Execute {
                instruction,
                start_at,
            } => Self::execute(image, epoch, instruction, start_at),
            RobotCommand::EndMotion => Request::EndMotion { epoch },
            RobotCommand::Stop(kind) => {
                self.stop(image, kind);
                return;
            }
            RobotCommand::Acknowledge => Request::Acknowledge { epoch },
            RobotCommand::SelectServo(law) => Request::SelectServo { epoch, law },
            RobotCommand::SetTool(pose) => Request::SetTool {
                epoch,
                t_flange_tool: PoseMessage {
                    position_m: pose.position.into(),
                    rotation_rad: pose.rotation_vector().into(),
                },
            },
            RobotCommand::Trace(every) => Request::Trace { epoch, every },
            RobotCommand::Path { first, elements } => Request::Path {
                epoch,
                first,
                elements,
            },
            RobotCommand::FeedOverride(share) => Request::FeedOverride { epoch, share },
            RobotCommand::Outputs { mask, on } => Request::Outputs { epoch, mask, on },
        };
        image.request = State::Pending {
            asked: asked(&request),
        };
        self.queue.push_back(request);
    }

    fn execute(
        image: &mut Image,
        epoch: u32,
        instruction: Instruction,
        start_at: Micros,
    ) -> Request {
        image.issued = image.issued.saturating_add(1);
        image.path = None;
        Request::Execute {
            epoch,
            id: image.issued,
            start_at,
            instruction,
        }
    }

    /// A stop goes before everything else and ends it.
    pub(super) fn stop(&mut self, image: &mut Image, kind: StopKind) {
        self.clear();
        image.request = State::Pending { asked: Asked::Stop };
        self.queue.push_back(Request::Stop { kind });
    }

    /// Forget what has not been sent.
    pub(super) fn clear(&mut self) {
        self.pending = None;
        self.queue.clear();
        self.knots.clear();
        self.repeated.clear();
        self.decision = None;
    }

    /// An answer: of the request on its way, whichever try it answers.
    pub(super) fn reply(
        &mut self,
        image: &mut Image,
        now: Micros,
        transfer_id: TransferId,
        reply: Reply,
    ) {
        let Some(pending) = &self.pending else { return };
        let latest = pending.sent.last() == Some(&transfer_id);
        let any = pending.sent.contains(&transfer_id);
        // every Acquire gives another epoch: only the last one counts
        let counts = if asked(&pending.request) == Asked::Acquire {
            latest
        } else {
            any
        };
        if !counts {
            return;
        }
        let asked = asked(&pending.request);
        let state = match reply {
            Reply::Refused(refusal)
                if pending.sent.len() > 1 && arrived_before(&pending.request, &refusal) =>
            {
                State::Accepted { asked }
            }
            Reply::Refused(refusal) => State::Refused { asked, refusal },
            Reply::Identity(identity) => {
                if matches!(image.link, Link::Silent | Link::Identified { .. }) {
                    image.link = Link::Identified { identity };
                    image.heard_at = Some(now);
                }
                State::Accepted { asked }
            }
            Reply::Lease { epoch } => {
                image.lease(epoch, now);
                self.sequence = 0;
                State::Accepted { asked }
            }
            Reply::Path { next, room } => {
                image.path = Some(PathWanted { next, room });
                State::Accepted { asked }
            }
            Reply::Accepted => {
                if let (Request::Release { .. }, Some(identity)) =
                    (&pending.request, image.identity().cloned())
                {
                    image.link = Link::Identified { identity };
                }
                State::Accepted { asked }
            }
        };
        self.pending = None;
        image.request = match (self.queue.front(), state) {
            // with more to ask, a success is not the end of asking
            (Some(next), State::Accepted { .. }) => State::Pending {
                asked: self::asked(next),
            },
            (_, state) => state,
        };
    }

    /// Sends the request that is due: the next one, or the pending one again.
    pub(super) fn send_requests(
        &mut self,
        image: &mut Image,
        now: Micros,
        timing: &Timing,
        endpoint: &mut Endpoint<SESSIONS>,
        tx: &mut impl FnMut(Frame),
    ) {
        if self.pending.is_none() {
            self.pending = self.queue.pop_front().map(|request| Pending {
                request,
                sent: Vec::new(),
                sent_at: None,
            });
        }
        let Some(pending) = &mut self.pending else {
            return;
        };
        if pending
            .sent_at
            .is_some_and(|at| now.since(at) < ms(timing.retry_ms))
        {
            return;
        }
        let tries = u32::try_from(pending.sent.len()).unwrap_or(u32::MAX);
        if tries >= timing.tries {
            image.request = State::Unanswered {
                asked: asked(&pending.request),
                tries,
            };
            self.pending = None;
            self.queue.clear();
            return;
        }
        // a message that is too long cannot be built from these types; it would count as unanswered
        if let Ok(transfer_id) = endpoint.send_request(self.node, &pending.request, tx) {
            pending.sent.push(transfer_id);
        }
        pending.sent_at = Some(now);
    }

    /// Sends the cyclic commands of one macrostep: the knots there are, or what else there is to
    /// say; always at least one while the lease is held, because that is what renews it.
    pub(super) fn send_commands(
        &mut self,
        image: &Image,
        now: Micros,
        timing: &Timing,
        endpoint: &mut Endpoint<SESSIONS>,
        tx: &mut impl FnMut(Frame),
    ) {
        let Some(epoch) = image.epoch() else { return };
        let valid_until = now + ms(timing.command_ttl_ms);
        let mut send = |coordination: Coordination| {
            let command = Command {
                epoch,
                sequence: self.sequence,
                valid_until,
                coordination,
            };
            self.sequence = self.sequence.wrapping_add(1);
            // cannot fail: no message of these types is longer than a transfer
            let _sent = endpoint.send_command(self.node, &command, tx);
        };
        if self.knots.is_empty() && self.repeated.is_empty() {
            send(
                self.decision
                    .map_or(Coordination::None, Coordination::Loose),
            );
            return;
        }
        for knot in self.repeated.iter().chain(&self.knots) {
            send(Coordination::Tight(knot.clone()));
        }
        let keep = usize::try_from(timing.knot_repeats).unwrap_or(usize::MAX);
        if self.knots.is_empty() {
            // said once more than enough: the stream has ended
            self.repeated.pop_front();
        }
        self.repeated.extend(self.knots.drain(..));
        while self.repeated.len() > keep {
            self.repeated.pop_front();
        }
    }

    /// Is everything said?
    pub(super) fn is_idle(&self) -> bool {
        self.pending.is_none() && self.queue.is_empty()
    }
}

/// What an Acquire asks for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lease {
    pub(super) nonce: u32,
    pub(super) term_ms: u32,
    pub(super) takeover: bool,
}
