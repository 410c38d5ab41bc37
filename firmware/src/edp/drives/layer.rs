//! Layer setting (CiA 305): the node as LSS master of one of its drive buses.
//!
//! While a drive that is named, or any where the configuration asks for strangers, has not booted, it asks who has no
//! node id; if somebody answers, it looks for the drives named, one after the other. A drive that still has not booted
//! when its time is over is looked for once more, then a fastscan finds a stranger, to be told, and then it is given
//! up. So nothing is sent once all drives have booted, and all of them must have before torque can be switched on.

use super::BOOT_TIMEOUT;
use super::link::DriveLink;
use crate::io::Port;
use protocol::canopen::lss::Identity;
use protocol::canopen::lss::master::{Master, Outcome, Progress, Task};
use protocol::frame::Frame;
use protocol::message::{DriveFinding, Event};
use protocol::time::Micros;
use protocol::units::MAX_AXES;

/// Whether there are drives without node id is asked so often while some have not booted.
const ASK_PERIOD: Micros = Micros::from_millis(100);

/// The LSS master of one bus.
#[derive(Debug)]
pub(super) struct Layer {
    bus: u8,
    master: Master,
    /// The axis for whose drive the present dialogue looks.
    axis: Option<usize>,
    /// From this axis on drives are still to be looked for.
    turn: Option<usize>,
    next_ask: Micros,
    /// When it was last asked, there was a drive without node id.
    blank: bool,
    /// There was a fastscan since the drives were last restarted.
    scanned: bool,
    stranger: Option<Identity>,
}

impl Layer {
    pub(super) const fn new(bus: u8) -> Self {
        Self {
            bus,
            master: Master::new(),
            axis: None,
            turn: None,
            next_ask: Micros(0),
            blank: false,
            scanned: false,
            stranger: None,
        }
    }

    /// A slave's answer.
    pub(super) fn on_answer(&mut self, data: &[u8]) {
        self.master.on_answer(data);
    }

    /// A drive without node id that no axis names, once.
    pub(super) fn take_stranger(&mut self) -> Option<Event> {
        self.stranger.take().map(|identity| Event::DriveFound {
            bus: self.bus,
            axis: None,
            finding: DriveFinding::Unnamed,
            expected: None,
            got: Some(identity.into()),
        })
    }

    /// What is due: at most one frame.
    // once for all robots: it is not small
    #[inline(never)]
    pub(super) fn poll(&mut self, now: Micros, links: &mut [DriveLink]) -> Option<(Port, Frame)> {
        match self.master.poll(now) {
            Progress::Send(frame) => return Some((Port::Drives(self.bus), frame)),
            Progress::Wait => {}
            Progress::Done(outcome) => self.conclude(now, outcome, links),
            Progress::Idle => self.begin(now, links),
        }
        None
    }

    fn begin(&mut self, now: Micros, links: &mut [DriveLink]) {
        let bus = self.bus;
        let here = |link: &&mut DriveLink| link.address().bus == bus;
        if links.iter().any(DriveLink::has_torque) {
            return;
        }
        if let Some(from) = self.turn {
            let mut rest = (0..MAX_AXES).zip(&*links).filter(|(axis, _)| *axis >= from);
            let found = rest.find_map(|(axis, link)| Some((axis, link.wanted(bus)?)));
            self.turn = found.map(|(axis, _)| axis.saturating_add(1));
            if let Some((axis, task)) = found {
                self.look(axis, task);
                return;
            }
        }
        let mut overdue = None;
        let mut waiting = false;
        for (axis, link) in (0..MAX_AXES).zip(links.iter_mut()).filter(|(_, l)| here(l)) {
            let Some(since) = link.waits() else {
                continue;
            };
            waiting = true;
            if now.since(since) > BOOT_TIMEOUT {
                overdue = Some((axis, link));
                break;
            }
        }
        if let Some((axis, link)) = overdue {
            if let Some(task) = link.wanted(bus).filter(|_| !link.was_looked_for()) {
                self.look(axis, task);
            } else if self.blank && !self.scanned {
                self.scanned = self.master.begin(Task::Scan);
            } else {
                link.give_up();
            }
        } else if waiting && now >= self.next_ask {
            self.next_ask = now + ASK_PERIOD;
            self.master.begin(Task::Ask);
        }
    }

    fn look(&mut self, axis: usize, task: Task) {
        if self.master.begin(task) {
            self.axis = Some(axis);
        }
    }

    fn conclude(&mut self, now: Micros, outcome: Outcome, links: &mut [DriveLink]) {
        if let Some(axis) = self.axis.take() {
            if let Some(link) = links.get_mut(axis) {
                link.on_layer(now, outcome);
            }
            return;
        }
        match outcome {
            Outcome::Somebody => {
                self.blank = true;
                self.turn = Some(0);
            }
            // of one that is named what was found out is told with its axis
            Outcome::Found(found) => {
                let named = links.iter().any(|link| link.identity() == Some(found));
                self.stranger = (!named).then_some(found);
            }
            Outcome::Nobody => self.blank = false,
            Outcome::Given { .. }
            | Outcome::Configured(_)
            | Outcome::Collision
            | Outcome::Refused(_) => {}
        }
    }
}
