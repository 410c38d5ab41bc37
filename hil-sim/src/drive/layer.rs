//! Layer setting (LSS): the node identifier, and the reset that puts one into force.

use protocol::canopen::lss::{self, Effect};
use protocol::canopen::nmt::State;

use super::SimDrive;

impl SimDrive {
    /// A request of the LSS master.
    pub(super) fn on_lss(&mut self, data: &[u8]) {
        let (answer, effect) = self.lss.on_request(data);
        if let Some(answer) = answer {
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
