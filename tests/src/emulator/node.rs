//! The emulated node in the place of one in this process.

use super::machine::{Ending, Machine, Setup};
use board::boot::{BoardNode, Boot};
use board::channel::{self, LONGEST, Reply};
use firmware::ecp::NoPrograms;
use firmware::process::NodeProcess;
use firmware::{ConfigError, DriveAddress, NodeSetup, Port, Received};
use protocol::frame::Frame;
use protocol::message::{Identity, NodeState};
use protocol::time::Micros;
use robots::{Robot, RobotVisitor};
use std::io;
use std::sync::{Arc, Mutex, PoisonError};

/// A node that has failed is never called again; a hundred years.
const NEVER: Micros = Micros(3_000_000_000_000_000);

/// The board's node of this boot in this process, and where its drives are.
///
/// # Errors
/// What is wrong with the configuration.
///
/// # Panics
/// If not every axis has a drive bus.
pub fn in_process(
    boot: &Boot,
) -> Result<(Box<dyn NodeProcess + Send>, Vec<DriveAddress>), ConfigError> {
    struct Make<'a>(&'a Boot);
    impl RobotVisitor for Make<'_> {
        type Output = Result<(Box<dyn NodeProcess + Send>, Vec<DriveAddress>), ConfigError>;
        fn visit<R, const N: usize>(self, robot: R) -> Self::Output
        where
            R: Robot<N> + Copy + core::fmt::Debug + Send + Sync + 'static,
        {
            let boot = self.0;
            let buses: [u8; N] = boot.buses.as_slice().try_into().expect("a bus an axis");
            let config = boot.station.config(buses)?;
            let setup = NodeSetup::new(robot, config)?;
            let node = BoardNode::of(boot.now, setup, NoPrograms);
            Ok((Box::new(node), config.drives.to_vec()))
        }
    }
    boot.kind.visit(boot.station.track, Make(boot))
}

/// What is left of an emulated node when the cell that had it is gone.
#[derive(Clone, Debug)]
pub struct Handle(Arc<Mutex<Link>>);

#[derive(Debug)]
struct Link {
    machine: Option<Machine>,
    cycles: u64,
    steps: u64,
    problem: Option<String>,
}

/// How an emulated node did.
#[derive(Clone, Debug)]
pub struct Life {
    /// Steps made.
    pub steps: u64,
    /// The image's own time at the last of them, clock cycles of 25 MHz.
    pub cycles: u64,
    /// What the image said, and how it ended.
    pub ending: Ending,
}

impl Handle {
    fn link(&self) -> std::sync::MutexGuard<'_, Link> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Ends the emulator.
    ///
    /// # Errors
    /// What went wrong on the way, or how the emulator ended if not well.
    pub fn finish(self) -> Result<Life, String> {
        let mut link = self.link();
        let machine = link.machine.take().ok_or("the emulator has ended before")?;
        let mut end = [0; 16];
        let length = channel::write_end(&mut end).unwrap_or(0);
        let ending = machine.finish(&end[..length]);
        if let Some(problem) = link.problem.take() {
            return Err(format!("{problem}; {}", ending.messages));
        }
        if !ending.good {
            return Err(format!("the emulator failed: {}", ending.messages));
        }
        Ok(Life {
            steps: link.steps,
            cycles: link.cycles,
            ending,
        })
    }
}

/// The emulated node.
#[derive(Debug)]
pub struct EmulatedNode {
    link: Handle,
    next_wake: Micros,
    state: NodeState,
    identity: Identity,
    message: Vec<u8>,
    answer: Vec<u8>,
}

impl EmulatedNode {
    /// Starts an emulator and boots its image.
    ///
    /// # Errors
    /// If there is no emulator, or the image does not answer as one of ours.
    pub fn boot(setup: &Setup, boot: &Boot) -> io::Result<(Self, Handle)> {
        let mut machine = Machine::start(setup)?;
        let mut message = vec![0; LONGEST];
        let mut answer = Vec::new();
        let length = channel::write_boot(boot, &mut message)
            .ok_or_else(|| io::Error::other("no boot message"))?;
        let exchanged = machine.exchange(&message[..length], &mut answer);
        let Some(Reply::Booted(stepped, identity)) = channel::read_reply(&answer) else {
            let ending = machine.finish(&[]);
            return Err(io::Error::other(format!(
                "the image makes no such node ({exchanged:?}): {}",
                ending.messages
            )));
        };
        let link = Handle(Arc::new(Mutex::new(Link {
            machine: Some(machine),
            cycles: stepped.cycles,
            steps: 0,
            problem: None,
        })));
        let node = Self {
            link: link.clone(),
            next_wake: stepped.next_wake,
            state: stepped.state,
            identity,
            message,
            answer,
        };
        Ok((node, link))
    }

    fn exchange(
        &mut self,
        now: Micros,
        rx: &[Received],
        tx: &mut dyn FnMut(Port, Frame),
    ) -> Result<(), String> {
        let mut link = self.link.link();
        let length = channel::write_step(now, rx, &mut self.message)
            .ok_or("more frames in one step than the channel bears")?;
        link.machine
            .as_mut()
            .ok_or("the emulator has ended")?
            .exchange(&self.message[..length], &mut self.answer)
            .map_err(|error| format!("at {} us: {error}", now.0))?;
        let Some(Reply::Stepped(stepped, frames)) = channel::read_reply(&self.answer) else {
            return Err(format!("at {} us: an answer that is none", now.0));
        };
        link.steps += 1;
        link.cycles = stepped.cycles;
        self.next_wake = stepped.next_wake;
        self.state = stepped.state;
        for sent in frames {
            tx(sent.port, sent.frame);
        }
        Ok(())
    }
}

impl NodeProcess for EmulatedNode {
    fn step(&mut self, now: Micros, rx: &[Received], tx: &mut dyn FnMut(Port, Frame)) {
        if let Err(problem) = self.exchange(now, rx, tx) {
            self.next_wake = NEVER;
            self.link.link().problem.get_or_insert(problem);
        }
    }

    fn next_wake(&self) -> Micros {
        self.next_wake
    }

    fn state(&self) -> NodeState {
        self.state
    }

    fn identity(&self) -> Identity {
        self.identity.clone()
    }
}
