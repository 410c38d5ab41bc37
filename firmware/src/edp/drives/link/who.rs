//! Who a drive is: what it is asked after its boot-up message, and what layer setting does for it before.

use super::{DriveLink, Phase};
use crate::edp::drives::script::{AxisSetup, Script};
use protocol::canopen::lss::Identity;
use protocol::canopen::lss::master::{Outcome as Layered, Task as LayerTask};
use protocol::canopen::objects::index;
use protocol::canopen::sdo::Address;
use protocol::fault::Cause;
use protocol::message::{DriveFinding, Event};
use protocol::time::Micros;

/// A drive is given its node id so often before it must boot.
const GIVES: u8 = 2;

/// The object that says what a device is.
const DEVICE_TYPE_INDEX: u16 = 0x1000;
/// CiA 402 servo drive.
const DEVICE_TYPE: u32 = 0x0002_0192;

/// Values that every drive is asked for: (index, sub).
const IDENTIFY: [(u16, u8); 3] = [
    (DEVICE_TYPE_INDEX, 0),
    (index::RATED_TORQUE, 0),
    (index::DIGITAL_INPUTS, 0),
];

/// What is asked in a step of identifying: the identity only of a drive that is named, its set-up of one that stores it.
pub(super) fn question(setup: &AxisSetup, step: u8) -> Option<Address> {
    let plain = IDENTIFY.iter().map(|(index, sub)| (true, *index, *sub));
    let identity = (1..=4).map(|sub| (setup.identity.is_some(), index::IDENTITY, sub));
    let verify = (1..=2).map(|sub| (setup.stored, index::VERIFY_CONFIGURATION, sub));
    let asked = plain.chain(identity).chain(verify);
    let mut asked = asked.filter_map(|(ask, index, sub)| ask.then_some(Address::new(index, sub)));
    asked.nth(usize::from(step))
}

/// What layer setting has found out about a drive.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Search {
    /// How often it was given its node id.
    gives: u8,
    /// How the last search for it ended.
    last: Option<Layered>,
    /// What is still to be told.
    pub(super) news: Option<DriveFinding>,
    /// The identity that it has.
    got: Identity,
}

impl DriveLink {
    /// The device that it must be, if it is named.
    pub(in crate::edp::drives) const fn identity(&self) -> Option<Identity> {
        self.setup.identity
    }

    /// Since when layer setting looks for it: it was reset and has not booted.
    pub(in crate::edp::drives) const fn waits(&self) -> Option<Micros> {
        match self.phase {
            Phase::Booting { reset_at } if self.setup.find || self.setup.identity.is_some() => {
                reset_at
            }
            Phase::Booting { .. }
            | Phase::Identifying { .. }
            | Phase::Configuring { .. }
            | Phase::Ready
            | Phase::Failed(_) => None,
        }
    }

    /// What the LSS master of `bus` is to do for it.
    pub(in crate::edp::drives) fn wanted(&self, bus: u8) -> Option<LayerTask> {
        let here = self.address.bus == bus && self.waits().is_some() && self.search.gives < GIVES;
        let identity = self.setup.identity.filter(|_| here)?;
        let node = self.address.id;
        Some(LayerTask::Give { identity, node })
    }

    /// Has layer setting looked for it?
    pub(in crate::edp::drives) const fn was_looked_for(&self) -> bool {
        self.search.last.is_some()
    }

    /// A search for it has ended.
    pub(in crate::edp::drives) fn on_layer(&mut self, now: Micros, outcome: Layered) {
        self.search.last = Some(outcome);
        if let Layered::Given { stored } = outcome {
            self.search.gives = self.search.gives.saturating_add(1);
            self.search.news = Some(if stored {
                DriveFinding::Given
            } else {
                DriveFinding::NotStored
            });
            if let Phase::Booting { reset_at } = &mut self.phase {
                // it boots by itself
                *reset_at = Some(now);
            }
        }
    }

    /// It has not booted, and layer setting has not found it.
    pub(in crate::edp::drives) fn give_up(&mut self) {
        self.phase = Phase::Failed(Cause::DriveHeartbeat);
        if self.setup.identity.is_none() {
            return;
        }
        self.search.news = match self.search.last {
            Some(Layered::Collision) => Some(DriveFinding::Collision),
            Some(Layered::Refused(error)) => Some(DriveFinding::Refused { error }),
            Some(Layered::Configured(node)) if node != self.address.id => {
                Some(DriveFinding::Elsewhere { node: node.get() })
            }
            Some(Layered::Nobody) => Some(DriveFinding::Missing),
            // it has its node id, and yet it does not boot
            Some(
                Layered::Configured(_)
                | Layered::Given { .. }
                | Layered::Somebody
                | Layered::Found(_),
            )
            | None => None,
        };
    }

    /// What was found out about who it is, once.
    pub(in crate::edp::drives) fn take_news(&mut self, axis: u8) -> Option<Event> {
        let finding = self.search.news.take()?;
        Some(Event::DriveFound {
            bus: self.address.bus,
            axis: Some(axis),
            finding,
            expected: self.setup.identity.map(Into::into),
            got: (finding == DriveFinding::Other).then_some(self.search.got.into()),
        })
    }

    /// A question of identifying was answered.
    #[inline(never)]
    pub(super) fn identified(&mut self, step: u8, ok: bool) {
        let Some(at) = question(&self.setup, step) else {
            return;
        };
        let number = self.sdo.number().unwrap_or(0);
        let part = usize::from(at.sub.saturating_sub(1));
        let accepted = match at.index {
            DEVICE_TYPE_INDEX => ok && number == DEVICE_TYPE,
            index::RATED_TORQUE => {
                self.rated_torque_mnm = number;
                ok && number > 0
            }
            index::DIGITAL_INPUTS => {
                self.inputs = number;
                ok
            }
            index::IDENTITY => {
                let mut parts = self.search.got.parts();
                if let Some(part) = parts.get_mut(part) {
                    *part = number;
                }
                self.search.got = Identity::from_parts(parts);
                ok
            }
            // a drive that does not have it is configured
            _ => {
                let expected = Script::fingerprint(self.address.id, &self.setup);
                let same = ok && expected.get(part) == Some(&number);
                self.unchanged = self.unchanged && same;
                true
            }
        };
        let next = step.saturating_add(1);
        let named = self.setup.identity;
        self.phase = if !accepted {
            Phase::Failed(Cause::DriveConfiguration)
        } else if question(&self.setup, next).is_some() {
            Phase::Identifying { step: next }
        } else if named.is_some_and(|named| named != self.search.got) {
            self.search.news = Some(DriveFinding::Other);
            Phase::Failed(Cause::DriveConfiguration)
        } else {
            Phase::Configuring {
                script: if self.unchanged {
                    Script::of_stored()
                } else {
                    Script::new()
                },
            }
        };
    }
}
