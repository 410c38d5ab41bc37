//! Everything that went into a node and came out of it, step by step; and its replay into an image,
//! whose every answer must be the same, bit for bit.

use super::machine::Setup;
use super::node::{EmulatedNode, Life};
use board::boot::Boot;
use firmware::process::NodeProcess;
use firmware::{Port, Received};
use protocol::frame::Frame;
use protocol::message::{Identity, NodeState};
use protocol::time::Micros;
use std::sync::{Arc, Mutex, PoisonError};

/// One step.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// When.
    pub now: Micros,
    /// What was received.
    pub received: Vec<Received>,
    /// What was sent.
    pub sent: Vec<(Port, Frame)>,
    /// When the next step was due then.
    pub next_wake: Micros,
    /// The state then.
    pub state: NodeState,
}

/// A node's life.
#[derive(Clone, Debug)]
pub struct Tape {
    /// How it began.
    pub boot: Boot,
    /// Who it is.
    pub identity: Identity,
    /// Its steps.
    pub steps: Vec<Step>,
}

/// Where a tape is being written.
#[derive(Clone, Debug)]
pub struct Recording(Arc<Mutex<Tape>>);

impl Recording {
    /// The tape so far.
    #[must_use]
    pub fn tape(&self) -> Tape {
        self.0
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone()
    }
}

/// A node whose life is recorded.
#[derive(Debug)]
pub struct Recorder {
    node: Box<dyn NodeProcess + Send>,
    tape: Recording,
}

impl Recorder {
    /// Nothing recorded yet.
    #[must_use]
    pub fn new(node: Box<dyn NodeProcess + Send>, boot: Boot) -> (Self, Recording) {
        let tape = Recording(Arc::new(Mutex::new(Tape {
            boot,
            identity: node.identity(),
            steps: Vec::new(),
        })));
        let recorder = Self {
            node,
            tape: tape.clone(),
        };
        (recorder, tape)
    }
}

impl NodeProcess for Recorder {
    fn step(&mut self, now: Micros, rx: &[Received], tx: &mut dyn FnMut(Port, Frame)) {
        let mut sent = Vec::new();
        self.node.step(now, rx, &mut |port, frame| {
            sent.push((port, frame));
            tx(port, frame);
        });
        let step = Step {
            now,
            received: rx.to_vec(),
            sent,
            next_wake: self.node.next_wake(),
            state: self.node.state(),
        };
        let mut tape = self.tape.0.lock().unwrap_or_else(PoisonError::into_inner);
        tape.steps.push(step);
    }

    fn next_wake(&self) -> Micros {
        self.node.next_wake()
    }

    fn state(&self) -> NodeState {
        self.node.state()
    }

    fn identity(&self) -> Identity {
        self.node.identity()
    }
}

/// Plays a tape into a new image.
///
/// # Errors
/// The first answer that differs, or what else went wrong.
pub fn replay(tape: &Tape, setup: &Setup) -> Result<Life, String> {
    let (mut node, handle) =
        EmulatedNode::boot(setup, &tape.boot).map_err(|error| error.to_string())?;
    if node.identity() != tape.identity {
        return Err(format!(
            "identity: {:?}, not {:?}",
            node.identity(),
            tape.identity
        ));
    }
    for (number, step) in tape.steps.iter().enumerate() {
        let mut sent = Vec::new();
        node.step(step.now, &step.received, &mut |port, frame| {
            sent.push((port, frame));
        });
        let answer = (&sent, node.next_wake(), node.state());
        let wanted = (&step.sent, step.next_wake, step.state);
        if answer != wanted {
            let problem = handle.finish().err().unwrap_or_default();
            return Err(format!(
                "step {number} at {} us: {answer:?}, not {wanted:?} {problem}",
                step.now.0
            ));
        }
    }
    handle.finish()
}
