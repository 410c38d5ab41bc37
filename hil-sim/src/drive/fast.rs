//! The fast profile on CAN FD ([`protocol::canopen::fast`]): one group for all drives of a bus, one feedback each.

use protocol::canopen::axis::Target;
use protocol::canopen::fast::{Feedback, Group, Layout, Slot};
use protocol::canopen::nmt::State;
use protocol::canopen::node::Function;
use protocol::frame::{Frame, Id};

use super::{SimDrive, slots};

/// What a group may look like; either has an identifier of its own.
const LAYOUTS: [Layout; 2] = [Layout::Targets, Layout::Offsets];

/// The drive's part in it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Fast {
    slot: Option<Slot>,
    /// What waits for SYNC.
    latched: Option<(u16, Target, Option<i16>)>,
}

impl Fast {
    /// The identifiers it listens to, with this SYNC.
    pub(super) fn cobs(&self, sync_cob: u16) -> impl Iterator<Item = u16> {
        let layouts = self.slot.map(|_| LAYOUTS).into_iter().flatten();
        layouts.map(move |layout| layout.cob(sync_cob))
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
        let (Some(slot), State::Operational) = (self.fast.slot, self.nmt) else {
            return;
        };
        let mut layouts = LAYOUTS.into_iter();
        if let Some(layout) = layouts.find(|layout| layout.cob(self.sync_cob) == cob)
            && let Some(group) = Group::decode(layout, frame.data())
            && let Some((target, offset)) = group.target(slot)
        {
            self.fast.latched = Some((group.controlword(), target, offset));
        }
    }

    /// SYNC: what was latched takes effect. Was there anything?
    pub(super) fn latch_group(&mut self) -> bool {
        let Some((controlword, target, offset)) = self.fast.latched.take() else {
            return false;
        };
        self.od.set(slots::CONTROLWORD, u32::from(controlword));
        match target {
            Target::Position(units) => self.od.set_signed(slots::TARGET_POSITION, units),
            Target::Torque(torque) => self.od.set_signed(slots::TARGET_TORQUE, i32::from(torque)),
        }
        if let Some(offset) = offset {
            self.od.set_signed(slots::TORQUE_OFFSET, i32::from(offset));
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
