//! How the peer answers requests.

use super::{Doing, Peer};
use protocol::fault::Refusal;
use protocol::message::{Instruction, NodeState, Progress, Reply, Request, StopKind};
use protocol::time::Micros;

impl Peer {
    pub(super) fn authorise(&self, from: u8, epoch: u32) -> Result<(), Refusal> {
        match self.lease {
            Some((holder, ours, ..)) if holder == from && ours == epoch => Ok(()),
            Some((_, epoch, ..)) => Err(Refusal::NoLease { epoch }),
            None => Err(Refusal::NoLease { epoch: 0 }),
        }
    }

    pub(super) fn request(
        &mut self,
        now: Micros,
        from: u8,
        request: Request,
    ) -> Result<Reply, Refusal> {
        let wrong = Refusal::WrongState { state: self.state };
        match request {
            Request::Identify => return Ok(Reply::Identity(self.identity())),
            Request::Acquire { lease_ms, .. } => {
                if let Some(holder) = self.script.held_by {
                    return Err(Refusal::LeaseHeld { holder });
                }
                self.epoch += 1;
                let term = Micros::from_millis(u64::from(lease_ms));
                self.lease = Some((from, self.epoch, term, now + term));
                self.link.set_lease(self.epoch);
                self.last_sequence = None;
                self.instruction = 0;
                self.progress = Progress::Idle;
                return Ok(Reply::Lease { epoch: self.epoch });
            }
            Request::Stop { kind } => self.stop(now, kind),
            Request::Release { epoch } => {
                self.authorise(from, epoch)?;
                self.stop(now, StopKind::Path);
                self.lease = None;
            }
            Request::Enable { epoch } => {
                self.authorise(from, epoch)?;
                if self.state != NodeState::Disabled {
                    return Err(wrong);
                }
                self.state = NodeState::Enabling;
                self.doing = Doing::Enabling {
                    until: now + Micros::from_millis(60),
                };
            }
            Request::Disable { epoch } => {
                self.authorise(from, epoch)?;
                self.state = NodeState::Disabled;
            }
            Request::Synchronise { epoch } => {
                self.authorise(from, epoch)?;
                if self.state != NodeState::Unsynchronised {
                    return Err(wrong);
                }
                self.state = NodeState::Synchronising;
                self.doing = Doing::Homing {
                    until: now + Micros::from_millis(400),
                };
            }
            Request::Execute {
                epoch,
                id,
                start_at,
                instruction,
            } => {
                self.authorise(from, epoch)?;
                self.execute(now, id, start_at, instruction)?;
            }
            Request::EndMotion { epoch } => {
                self.authorise(from, epoch)?;
                if let Doing::Following { end } = &mut self.doing {
                    *end = true;
                }
            }
            Request::Acknowledge { epoch } => {
                self.authorise(from, epoch)?;
                if self.state != NodeState::Faulted {
                    return Err(wrong);
                }
                self.fault = None;
                self.state = self.rest();
            }
            request @ (Request::Path { .. } | Request::FeedOverride { .. }) => {
                return self.path_request(now, from, &request);
            }
            Request::SelectServo { epoch, .. }
            | Request::SetTool { epoch, .. }
            | Request::Outputs { epoch, .. }
            | Request::Trace { epoch, .. } => self.authorise(from, epoch)?,
        }
        Ok(Reply::Accepted)
    }

    fn execute(
        &mut self,
        now: Micros,
        id: u32,
        start_at: Micros,
        instruction: Instruction,
    ) -> Result<(), Refusal> {
        if let Some(refusal) = self.script.refuse {
            return Err(refusal);
        }
        if self.state != self.rest() || self.doing != Doing::Nothing {
            return Err(Refusal::WrongState {
                state: NodeState::Moving,
            });
        }
        if id <= self.instruction {
            return Err(Refusal::Stale {
                last: self.instruction,
            });
        }
        if start_at.0 != 0 && start_at < self.clock.to_bus(now) {
            return Err(Refusal::Late);
        }
        self.instruction = id;
        self.progress = Progress::Pending;
        self.doing = Doing::Waiting {
            start: start_at,
            instruction,
        };
        Ok(())
    }
}
