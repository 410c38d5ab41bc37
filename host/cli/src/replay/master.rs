//! The Master Process once more, given the frames that others sent it.

use super::comparison::Comparison;
use host::program::Run;
use host::record::MasterStep;
use protocol::frame::Frame;
use protocol::id::{CanId, NodeId};
use protocol::message::StopKind;
use protocol::time::Micros;
use std::collections::VecDeque;

/// The number of its bus.
const BUS: usize = 0;

/// A Master Process being replayed.
#[derive(Debug)]
pub(super) struct MasterReplay {
    run: Run,
    /// What others sent and it has not yet been given.
    heard: VecDeque<(Micros, Frame)>,
    pub(super) received: u64,
    pub(super) comparison: Comparison,
}

impl MasterReplay {
    pub(super) fn new(run: Run) -> Self {
        Self {
            run,
            heard: VecDeque::new(),
            received: 0,
            comparison: Comparison::default(),
        }
    }

    /// A frame of any bus.
    pub(super) fn frame(&mut self, at_ns: u64, bus: usize, frame: &Frame) {
        if bus != BUS {
            return;
        }
        if CanId::parse(frame.id()).is_some_and(|id| id.source == NodeId::MP) {
            self.comparison.recorded(at_ns, bus, frame);
        } else {
            self.heard.push_back((Micros(at_ns / 1000), *frame));
        }
    }

    /// A step; `None` if the record lacks frames that it was given.
    pub(super) fn step(&mut self, at_ns: u64, step: MasterStep) -> Option<()> {
        let now = Micros(at_ns / 1000);
        let count = usize::try_from(step.received).ok()?;
        if count > self.heard.len() {
            return None;
        }
        self.received += u64::from(step.received);
        let Self {
            run,
            heard,
            comparison,
            ..
        } = self;
        let mut send = |frame| comparison.made(at_ns, BUS, frame);
        if step.stop {
            run.stop(StopKind::Path, now, &mut send);
        }
        run.step(now, heard.drain(..count), &mut send);
        // progress is for those who look on
        drop(run.progress());
        Some(())
    }
}
