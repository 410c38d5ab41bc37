//! The master: one dialogue at a time with the slaves of one bus.
//!
//! ```text
//! ask    who has no id? ─▶ Nobody, Somebody
//! give   all wait ▶ switch selective ▶ serial number? ▶ node id? ▶ node id ▶ store ▶ all wait ─▶ Given
//! scan   all wait ▶ fastscan ▶ all wait ─▶ Found
//! ```
//! Whatever ends a dialogue early, it ends with all slaves in waiting. Questions that several slaves may answer are
//! waited for to the end of their window, so two devices of one identity are noticed: on a real bus unless their
//! answers begin in the same bit. An answer that comes after its window may fall into the next one; so the device that
//! was switched is asked for its serial number before it is given anything.

use super::{ANSWER_WINDOW, Answer, Fastscan, Identity, Request, Scan, cs, switch_selective};
use crate::canopen::node::NodeId;
use crate::frame::Frame;
use crate::time::Micros;

/// How long a slave may take to store its node identifier: a few pages of a flash.
pub const STORE_WINDOW: Micros = Micros::from_millis(500);

/// Every slave into waiting.
const ALL_WAIT: Request = Request::SwitchAll {
    configuration: false,
};

/// What the master is to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Task {
    /// Ask whether there are slaves without node identifier.
    Ask,
    /// Give the slave of an identity a node identifier, if it has none, and make it store it.
    Give {
        /// Who is to get it.
        identity: Identity,
        /// The node identifier.
        node: NodeId,
    },
    /// Find out who has the least identity of those without node identifier; it gets none.
    Scan,
}

/// How a dialogue ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// No slave answered to that.
    Nobody,
    /// [`Task::Ask`]: there is at least one.
    Somebody,
    /// The slave has the node identifier and boots.
    Given {
        /// It keeps it over power cycles.
        stored: bool,
    },
    /// The slave had a node identifier, which was left as it was.
    Configured(NodeId),
    /// Several slaves have this identity; none was given anything.
    Collision,
    /// The slave refused the node identifier with this error code.
    Refused(u8),
    /// [`Task::Scan`]: who was found.
    Found(Identity),
}

/// What the master wants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// Nothing: no dialogue is under way.
    Idle,
    /// Send this, and ask again.
    Send(Frame),
    /// Wait: for an answer, or for its window to pass.
    Wait,
    /// The dialogue ended.
    Done(Outcome),
}

/// What is sent next, or was and is being answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Idle,
    Ask,
    /// All wait, before the rest of the task.
    Clear,
    /// Switch selective, part 0 to 3.
    Select(u8),
    Serial,
    Number,
    Give,
    Store,
    Scan(Fastscan),
    /// All wait, at the end.
    Release(Outcome),
    Ended(Outcome),
}

/// The LSS master of one bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Master {
    task: Task,
    stage: Stage,
    /// Until when answers to the question that is out count.
    until: Option<Micros>,
    /// The last answer in the window, and how many there were.
    answer: Option<Answer>,
    answers: u8,
}

impl Default for Master {
    fn default() -> Self {
        Self::new()
    }
}

impl Master {
    /// A master without a task.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            task: Task::Ask,
            stage: Stage::Idle,
            until: None,
            answer: None,
            answers: 0,
        }
    }

    /// Begins a dialogue; `false` while another is under way.
    pub fn begin(&mut self, task: Task) -> bool {
        if self.stage != Stage::Idle {
            return false;
        }
        self.task = task;
        self.stage = match task {
            Task::Ask => Stage::Ask,
            Task::Give { .. } | Task::Scan => Stage::Clear,
        };
        true
    }

    /// Takes the data of a frame on [`super::SLAVE_COB`]. What does not answer the question that is out is ignored.
    pub fn on_answer(&mut self, data: &[u8]) {
        if let Stage::Scan(scan) = &mut self.stage {
            scan.on_answer(data);
            return;
        }
        let (Some(answer), Some(_)) = (Answer::decode(data), self.until) else {
            return;
        };
        let request = match answer {
            Answer::Unconfigured => self.stage == Stage::Ask,
            Answer::Switched => matches!(self.stage, Stage::Select(_)),
            Answer::Part(part, _) => part == 3 && self.stage == Stage::Serial,
            Answer::NodeId(_) => self.stage == Stage::Number,
            Answer::Done { request, .. } => {
                request == cs::NODE_ID && self.stage == Stage::Give
                    || request == cs::STORE && self.stage == Stage::Store
            }
            Answer::Identified => false,
        };
        if request {
            self.answer = Some(answer);
            self.answers = self.answers.saturating_add(1);
        }
    }

    /// Looks at the clock: at most one frame a call.
    pub fn poll(&mut self, now: Micros) -> Progress {
        if let Some(until) = self.until {
            // only storing takes so long that the end of its window is not waited for
            let early = self.stage == Stage::Store && self.answer.is_some();
            if now < until && !early {
                return Progress::Wait;
            }
            self.until = None;
            self.stage = self.conclude();
        }
        self.next(now)
    }

    fn next(&mut self, now: Micros) -> Progress {
        let (frame, window) = match &mut self.stage {
            Stage::Idle => return Progress::Idle,
            Stage::Ended(outcome) => {
                let outcome = *outcome;
                self.stage = Stage::Idle;
                return Progress::Done(outcome);
            }
            Stage::Ask => (Request::IdentifyUnconfigured.frame(), Some(ANSWER_WINDOW)),
            Stage::Clear => {
                self.stage = match self.task {
                    Task::Scan => Stage::Scan(Fastscan::new()),
                    Task::Give { .. } | Task::Ask => Stage::Select(0),
                };
                (ALL_WAIT.frame(), None)
            }
            Stage::Select(part) => {
                let Task::Give { identity, .. } = self.task else {
                    return self.end(Outcome::Nobody);
                };
                let (frame, window) = match (switch_selective(identity), *part) {
                    ([frame, ..], 0) | ([_, frame, ..], 1) | ([.., frame, _], 2) => (frame, None),
                    ([.., frame], _) => (frame, Some(ANSWER_WINDOW)),
                };
                if window.is_none() {
                    *part = part.saturating_add(1);
                }
                (frame, window)
            }
            Stage::Serial => (Request::InquireIdentity(3).frame(), Some(ANSWER_WINDOW)),
            Stage::Number => (Request::InquireNodeId.frame(), Some(ANSWER_WINDOW)),
            Stage::Give => {
                let Task::Give { node, .. } = self.task else {
                    return self.end(Outcome::Nobody);
                };
                (Request::NodeId(Some(node)).frame(), Some(ANSWER_WINDOW))
            }
            Stage::Store => (Request::Store.frame(), Some(STORE_WINDOW)),
            Stage::Scan(scan) => match scan.poll(now) {
                Scan::Send(frame) => (frame, None),
                Scan::Wait => return Progress::Wait,
                Scan::Found(identity) => return self.end(Outcome::Found(identity)),
                Scan::Nobody => return self.end(Outcome::Nobody),
            },
            Stage::Release(outcome) => {
                let outcome = *outcome;
                return self.end(outcome);
            }
        };
        self.answer = None;
        self.answers = 0;
        self.until = window.map(|window| now + window);
        Progress::Send(frame)
    }

    /// Lets all slaves wait; what was found out is told with the next call.
    fn end(&mut self, outcome: Outcome) -> Progress {
        self.stage = Stage::Ended(outcome);
        Progress::Send(ALL_WAIT.frame())
    }

    /// What the answers in the window say, or their absence.
    fn conclude(&self) -> Stage {
        let nobody = Stage::Release(Outcome::Nobody);
        if self.answers > 1 && self.stage != Stage::Ask {
            return Stage::Release(Outcome::Collision);
        }
        match (self.stage, self.answer) {
            (Stage::Ask, Some(_)) => Stage::Ended(Outcome::Somebody),
            (Stage::Ask, None) => Stage::Ended(Outcome::Nobody),
            (Stage::Select(_), Some(_)) => Stage::Serial,
            (Stage::Serial, Some(Answer::Part(_, serial))) => match self.task {
                Task::Give { identity, .. } if identity.serial == serial => Stage::Number,
                Task::Give { .. } | Task::Ask | Task::Scan => nobody,
            },
            (Stage::Number, Some(Answer::NodeId(Some(node)))) => {
                Stage::Release(Outcome::Configured(node))
            }
            (Stage::Number, Some(_)) => Stage::Give,
            (Stage::Give, Some(Answer::Done { error: 0, .. })) => Stage::Store,
            (Stage::Give, Some(Answer::Done { error, .. })) => {
                Stage::Release(Outcome::Refused(error))
            }
            (Stage::Store, answer) => Stage::Release(Outcome::Given {
                stored: matches!(answer, Some(Answer::Done { error: 0, .. })),
            }),
            // no answer
            (
                Stage::Idle
                | Stage::Clear
                | Stage::Select(_)
                | Stage::Serial
                | Stage::Number
                | Stage::Give
                | Stage::Scan(_)
                | Stage::Release(_)
                | Stage::Ended(_),
                _,
            ) => nobody,
        }
    }
}
