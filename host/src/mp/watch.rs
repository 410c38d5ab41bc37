//! `f_E` of the Master Process: what ends a job in error, checked before anything else.

use super::failure::{Asked, Failure};
use super::robot::{Image, Link, Request};
use super::subsystem::MpSubsystem;
use agent::{ErrorCondition, Reading};
use protocol::message::{NodeState, Progress};
use protocol::time::Micros;

/// The health of `C_0` itself, its interoceptors.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Interoceptors {
    /// Now, bus time.
    pub now: Micros,
    /// What the operator or the running behaviour said in this macrostep.
    pub failure: Option<Failure>,
}

/// The disjunction of the error situations of a list of robots.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Watch {
    robots: Vec<usize>,
    level: Level,
    silence_ms: u32,
}

/// How much is already expected to be in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Level {
    /// While getting ready: requests must not be refused.
    Requests,
    /// In work: the lease is held, no fault is latched, instructions complete.
    Work,
}

impl Watch {
    /// For the handshake and for clearing up: only refusals and unanswered requests are errors.
    #[must_use]
    pub const fn requests(robots: Vec<usize>) -> Self {
        Self {
            robots,
            level: Level::Requests,
            silence_ms: 0,
        }
    }

    /// For motion: also faults, lost links, lost leases and failed instructions.
    #[must_use]
    pub const fn work(robots: Vec<usize>, silence_ms: u32) -> Self {
        Self {
            robots,
            level: Level::Work,
            silence_ms,
        }
    }

    /// The robots of the job: those that are stopped when it fails.
    #[must_use]
    pub fn robots(&self) -> &[usize] {
        &self.robots
    }

    fn check_one(&self, now: Micros, image: &Image) -> Result<(), Failure> {
        let who = || image.who();
        if self.level == Level::Work {
            // the cause first: a fault also fails the instruction and may cost the link
            if let Some(fault) = image.last().and_then(|f| f.fault) {
                let axis = fault.axis.and_then(|axis| image.axis_name(axis));
                return Err(Failure::Fault {
                    who: who(),
                    fault,
                    axis,
                });
            }
            if let Some(epoch) = image.lease_lost {
                return Err(Failure::LeaseLost { who: who(), epoch });
            }
            match image.link {
                Link::Leased { .. } => {}
                Link::Silent | Link::Identified { .. } => {
                    let span = image.heard_at.map_or(self.silence_ms, |at| {
                        u32::try_from(now.since(at).0 / 1000).unwrap_or(u32::MAX)
                    });
                    return Err(Failure::Lost {
                        who: who(),
                        span_ms: span,
                    });
                }
            }
        }
        match image.request {
            Request::Refused { asked, refusal } => {
                return Err(Failure::Refused {
                    who: who(),
                    asked,
                    refusal,
                });
            }
            // a silent node is judged by the handshake, which asks again until its time is up
            Request::Unanswered { asked, tries }
                if asked != Asked::Identify || self.level == Level::Work =>
            {
                return Err(Failure::Unanswered {
                    who: who(),
                    asked,
                    tries,
                });
            }
            Request::Idle
            | Request::Pending { .. }
            | Request::Accepted { .. }
            | Request::Unanswered { .. } => {}
        }
        if self.level == Level::Work {
            if let Some(Progress::Failed(refusal)) = image.progress() {
                return Err(Failure::Instruction {
                    who: who(),
                    refusal,
                });
            }
            // torque that is lost without a fault: somebody stopped the robot or took its torque
            if let Reading::Fresh { value, .. } = image.feedback()
                && matches!(value.state, NodeState::Boot | NodeState::Configuring)
            {
                return Err(Failure::LeaseLost {
                    who: who(),
                    epoch: value.epoch,
                });
            }
        }
        Ok(())
    }
}

impl ErrorCondition<MpSubsystem, Interoceptors, ()> for Watch {
    type Fault = Failure;

    fn check(&self, c: &Interoceptors, e: &Vec<Image>, (): &()) -> Result<(), Failure> {
        if let Some(failure) = &c.failure {
            return Err(failure.clone());
        }
        let images = self.robots.iter().filter_map(|robot| e.get(*robot));
        // a fault anywhere tells more than what followed from it elsewhere
        let mut first = None;
        for image in images {
            match self.check_one(c.now, image) {
                Err(fault @ Failure::Fault { .. }) => return Err(fault),
                Err(failure) => first = first.or(Some(failure)),
                Ok(()) => {}
            }
        }
        first.map_or(Ok(()), Err)
    }
}
