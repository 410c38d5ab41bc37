//! The fast profile on CAN FD ([`protocol::canopen::fast`]): one group for all drives of a bus, one feedback each.

use protocol::canopen::axis::Target;
use protocol::canopen::fast::{Feedback, GROUP_COB, Group, Slot};
use protocol::canopen::nmt::State;
use protocol::canopen::node::Function;
use protocol::frame::{Frame, Id};

use super::{SimDrive, slots};

/// The drive's part in it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Fast {
    slot: Option<Slot>,
    /// What waits for SYNC.
    latched: Option<(u16, Target)>,
}

impl Fast {
    /// The identifier it listens to.
    pub(super) fn cob(&self) -> Option<u16> {
        self.slot.map(|_| GROUP_COB)
    }

    /// Forgets what waits.
    pub(super) const fn forget(&mut self) {
        self.latched = None;
    }
}

impl SimDrive {
    /// Reads its slot again.
    pub(super) fn configure_fast(&mut self) {
        let number = u8::try_from(self.od.get(slots::FAST_SLOT)).unwrap_or(0);
        let slot = Slot::new(number);
        if slot != self.fast.slot {
            self.fast = Fast {
                slot,
                latched: None,
            };
        }
    }

    /// An FD frame: of several in a cycle the last one counts that has this drive.
    pub(super) fn take_group(&mut self, cob: u16, frame: &Frame) {
        let (Some(slot), State::Operational, GROUP_COB) = (self.fast.slot, self.nmt, cob) else {
            return;
        };
        if let Some(group) = Group::decode(frame.data())
            && let Some(target) = group.target(slot)
        {
            self.fast.latched = Some((group.controlword(), target));
        }
    }

    /// SYNC: what was latched takes effect. Was there anything?
    pub(super) fn latch_group(&mut self) -> bool {
        let Some((controlword, target)) = self.fast.latched.take() else {
            return false;
        };
        self.od.set(slots::CONTROLWORD, u32::from(controlword));
        match target {
            Target::Position(units) => self.od.set_signed(slots::TARGET_POSITION, units),
            Target::Torque(torque) => self.od.set_signed(slots::TARGET_TORQUE, i32::from(torque)),
        }
        true
    }

    /// Sends the feedback instead of TPDO1, if this drive is in the group.
    pub(super) fn send_feedback(&mut self) -> bool {
        if self.fast.slot.is_none() {
            return false;
        }
        let half = |slot| {
            let [a, b, ..] = self.od.get(slot).to_le_bytes();
            [a, b]
        };
        let feedback = Feedback {
            statusword: u16::from_le_bytes(half(slots::STATUSWORD)),
            position: self.od.signed(slots::POSITION_ACTUAL),
            torque: i16::from_le_bytes(half(slots::TORQUE_ACTUAL)),
            velocity: self.od.signed(slots::VELOCITY_ACTUAL),
            following_error: self.od.signed(slots::FOLLOWING_ERROR),
        };
        let id = Id::Standard(self.node.cob(Function::Tpdo1));
        self.outbox.extend(Frame::fd(id, &feedback.encode()));
        true
    }
}
