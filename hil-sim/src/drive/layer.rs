//! Layer setting (LSS): the node identifier, and the reset that puts one into force.

use protocol::canopen::lss::{self, Effect};
use protocol::canopen::nmt::State;

use super::SimDrive;
use super::quirk::{Quirk, SLOW_LAYER_NS};

/// What layer setting leaves to be done.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Layer {
    /// Was its node identifier taken by a fault that is still in?
    blank: bool,
    /// A late answer, and when it is due, ns.
    answer: Option<(u64, [u8; 8])>,
}

impl SimDrive {
    /// A request of the LSS master.
    pub(super) fn on_lss(&mut self, data: &[u8]) {
        let before = self.lss;
        let (mut answer, effect) = self.lss.on_request(data);
        if effect == Some(Effect::Store) && self.p.quirks.has(Quirk::ForgetsNode) {
            // nothing is stored: the error code of "not supported"
            self.lss = before;
            answer = answer.map(|[specifier, ..]| [specifier, 1, 0, 0, 0, 0, 0, 0]);
        }
        if self.p.quirks.has(Quirk::SlowLayer) {
            self.layer.answer = answer
                .map(|answer| (self.now_ns + SLOW_LAYER_NS, answer))
                .or(self.layer.answer);
        } else if let Some(answer) = answer {
            self.send(lss::SLAVE_COB, answer);
        }
        match effect {
            // only a device that had no node identifier boots by being let go
            Some(Effect::Released)
                if self.lss.active().is_none() && self.lss.pending().is_some() =>
            {
                self.lss.reset();
                self.nmt = State::Initialising;
                self.restart();
            }
            // a simulated wire has no bit rate, and what is stored is the slave's own affair
            Some(
                Effect::Released
                | Effect::NodeId(_)
                | Effect::BitRate(_)
                | Effect::Activate(_)
                | Effect::Store,
            )
            | None => {}
        }
    }

    /// A late answer to the LSS master, when it is due.
    pub(super) fn answer_late(&mut self) {
        if let Some((due, answer)) = self.layer.answer
            && self.now_ns >= due
        {
            self.layer.answer = None;
            self.send(lss::SLAVE_COB, answer);
        }
    }

    /// When the fault comes it starts anew without a node identifier, as one that was never given any.
    pub(super) fn set_blank(&mut self, blank: bool) {
        if core::mem::replace(&mut self.layer.blank, blank) || !blank {
            return;
        }
        self.lss = lss::Slave::new(super::identity(&self.od), None);
        self.nmt = State::Initialising;
        self.restart();
    }

    /// Reset: everything but the encoder's counter starts again, and the axis is let go. Without a node
    /// identifier it does not boot until LSS gives it one.
    pub(super) fn restart(&mut self) {
        self.boot_at_ns = match self.lss.active() {
            Some(node) => {
                let before = core::mem::replace(&mut self.node, node);
                self.od.set_node(before, node);
                self.now_ns + self.boot_ns()
            }
            None => u64::MAX,
        };
        self.emergencies.reset();
        self.history.clear();
        self.od.reset();
        self.server.reset();
        self.answer = None;
        self.let_go();
        self.configure();
    }
}
