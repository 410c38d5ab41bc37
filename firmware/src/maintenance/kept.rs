//! A node and its keeper as one process: for hosts, where memory is not slow.

use super::black_box::{BlackBox, Memory, Signals};
use super::{Asked, Librarian, Recorder, Start};
use crate::ecp::Programs;
use crate::io::{Port, Received};
use crate::node::Node;
use crate::process::NodeProcess;
use crate::update::Updater;
use core::fmt::Debug;
use embedded_storage::nor_flash::NorFlash;
use protocol::frame::Frame;
use protocol::maintenance::MaintenanceReply;
use protocol::message::{Identity, NodeState};
use protocol::time::Micros;
use robots::Robot;

/// What a keeper asks of a node.
pub trait Maintainable: NodeProcess {
    /// [`Node::servo_step`]
    fn servo_step(&self) -> u32;
    /// [`Node::signals`]
    fn signals(&self) -> Signals;
    /// [`Node::take_asked`]
    fn take_asked(&mut self) -> Option<Asked>;
    /// [`Node::answer`]
    fn answer(&mut self, asked: &Asked, reply: &MaintenanceReply, tx: &mut dyn FnMut(Port, Frame));
}

impl<R, const N: usize, P, const W: usize> Maintainable for Node<R, N, P, W>
where
    R: Robot<N> + Copy + Debug,
    P: Programs<N> + Debug,
{
    fn servo_step(&self) -> u32 {
        Self::servo_step(self)
    }
    fn signals(&self) -> Signals {
        Self::signals(self)
    }
    fn take_asked(&mut self) -> Option<Asked> {
        Self::take_asked(self)
    }
    fn answer(
        &mut self,
        asked: &Asked,
        reply: &MaintenanceReply,
        mut tx: &mut dyn FnMut(Port, Frame),
    ) {
        Self::answer(self, asked, reply, &mut tx);
    }
}

/// Recorder and librarian in one: for hosts.
#[derive(Debug)]
pub struct Keeper<M, F> {
    recorder: Recorder<M>,
    librarian: Librarian<F>,
}

impl<M: Memory, F: NorFlash> Keeper<M, F> {
    /// Without an updater the node cannot be updated by the bus.
    pub fn new(start: Start, black_box: BlackBox<M>, updater: Option<Updater<F>>) -> Self {
        Self {
            librarian: Librarian::new(start.target.clone(), updater),
            recorder: Recorder::new(start, black_box),
        }
    }
}

/// A node that is kept: after every step its signals are recorded, and what was asked is answered.
#[derive(Debug)]
pub struct Kept<T, M, F> {
    node: T,
    keeper: Keeper<M, F>,
}

impl<T, M, F> Kept<T, M, F> {
    /// A node and its keeper.
    pub const fn new(node: T, keeper: Keeper<M, F>) -> Self {
        Self { node, keeper }
    }
}

impl<T, M, F> NodeProcess for Kept<T, M, F>
where
    T: Maintainable,
    M: Memory + Debug,
    F: NorFlash + Debug,
{
    fn step(&mut self, now: Micros, rx: &[Received], tx: &mut dyn FnMut(Port, Frame)) {
        let Self { node, keeper } = self;
        let before = node.servo_step();
        node.step(now, rx, tx);
        if node.servo_step() != before {
            let recorder = &mut keeper.recorder;
            recorder.record(&node.signals(), node.identity().servo_step_us);
            recorder.seal();
        }
        if let Some(asked) = node.take_asked() {
            let Keeper {
                recorder,
                librarian,
            } = keeper;
            let identity = node.identity();
            let reply = recorder.answer(&asked, &identity, node.servo_step());
            let reply = reply.unwrap_or_else(|| librarian.answer(&asked, &identity));
            node.answer(&asked, &reply, tx);
        }
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
    fn restarts(&self) -> bool {
        self.keeper.librarian.restarts()
    }
}
