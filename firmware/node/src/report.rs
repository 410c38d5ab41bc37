//! What the node says, in words and as JSON.
//!
//! Everything is taken from the node's own messages, as any monitor on the bus could.

use crate::printer::Printer;
use bus::StateChange;
use protocol::fault::{Fault, Reaction};
use protocol::frame::Frame;
use protocol::id::NodeId;
use protocol::link::{Endpoint, Message, Role};
use protocol::message::{DriveIdentity, Event, Feedback, HomingPhase, NodeState};
use protocol::time::Micros;
use protocol::transfer::Mtu;
use robots::RobotKind;
use serde_json::json;

/// Follows one node.
#[derive(Debug)]
pub(crate) struct Report {
    robot: RobotKind,
    link: Endpoint<8>,
    state: Option<NodeState>,
    fault: Option<Fault>,
    epoch: u32,
    faults: u64,
    last: Option<Feedback>,
}

impl Report {
    /// Nothing seen yet.
    pub(crate) fn new(robot: RobotKind) -> Self {
        let observer = NodeId::new(NodeId::MAX).unwrap_or(NodeId::MP);
        Self {
            robot,
            link: Endpoint::new(observer, Role::Observer, Mtu::Fd),
            state: None,
            fault: None,
            epoch: 0,
            faults: 0,
            last: None,
        }
    }

    /// Faults so far.
    pub(crate) const fn faults(&self) -> u64 {
        self.faults
    }

    /// The node's latest image.
    pub(crate) const fn last(&self) -> Option<&Feedback> {
        self.last.as_ref()
    }

    /// The node is in this state.
    pub(crate) fn state(&mut self, now: Micros, state: NodeState, printer: &Printer) {
        if self.state.replace(state) != Some(state) {
            self.tell(now, &format!("{state:?}"), printer);
            let state = format!("{state:?}");
            printer.json(&json!({
                "event": "state", "t_s": now.as_secs_f64(), "robot": self.robot.name(),
                "state": state,
            }));
        }
    }

    /// The CAN controller of one of its buses has changed its state. What follows is the node's own to find: drives and
    /// master fall silent.
    pub(crate) fn bus(&self, now: Micros, change: &StateChange, printer: &Printer) {
        self.tell(now, &change.to_string(), printer);
        let state = format!("{:?}", change.state);
        printer.json(&json!({
            "event": "bus", "t_s": now.as_secs_f64(), "robot": self.robot.name(),
            "bus": change.bus, "state": state,
        }));
    }

    /// The node sent a frame to the MP's bus.
    pub(crate) fn frame(&mut self, now: Micros, frame: &Frame, printer: &Printer) {
        match self
            .link
            .receive(frame, now)
            .map(|incoming| incoming.message)
        {
            Some(Message::Feedback(feedback)) => {
                self.lease(now, feedback.epoch, printer);
                match feedback.fault {
                    Some(fault) => self.fault(now, fault, printer),
                    None => self.fault = None,
                }
                self.last = Some(feedback);
            }
            Some(Message::Event(Event::Fault(fault))) => self.fault(now, fault, printer),
            Some(Message::Event(Event::Homing { axis, phase })) => {
                let what = match phase {
                    HomingPhase::Coarse => "moving towards the switch",
                    HomingPhase::Settle => "settling on the switch",
                    HomingPhase::BackOff => "backing off the switch",
                    HomingPhase::Index => "looking for the encoder index",
                    HomingPhase::Done => "homed",
                };
                let axis = u16::from(axis) + 1;
                self.tell(now, &format!("axis {axis}: {what}"), printer);
                let phase = format!("{phase:?}");
                printer.json(&json!({
                    "event": "homing", "t_s": now.as_secs_f64(), "robot": self.robot.name(),
                    "axis": axis, "phase": phase,
                }));
            }
            Some(Message::Event(Event::DriveFound {
                bus,
                axis,
                finding,
                expected,
                got,
            })) => {
                let axis = axis.map(|axis| u16::from(axis) + 1);
                let place = axis.map_or(String::new(), |axis| format!(", axis {axis}"));
                let who = |word, identity: Option<DriveIdentity>| {
                    identity.map_or(String::new(), |identity| format!("; {word} {identity}"))
                };
                let who = who("expected", expected) + &who("got", got);
                self.tell(
                    now,
                    &format!("drive bus {bus}{place}: {finding}{who}"),
                    printer,
                );
                let numbers = |identity: Option<DriveIdentity>| {
                    identity.map(|i| json!([i.vendor, i.product, i.revision, i.serial]))
                };
                printer.json(&json!({
                    "event": "drive-found", "t_s": now.as_secs_f64(), "robot": self.robot.name(),
                    "bus": bus, "axis": axis, "finding": format!("{finding:?}"),
                    "expected": numbers(expected), "got": numbers(got),
                }));
            }
            Some(Message::Event(Event::DriveReady { axis })) => {
                let axis = u16::from(axis) + 1;
                self.tell(now, &format!("axis {axis}: drive configured"), printer);
                printer.json(&json!({
                    "event": "drive-ready", "t_s": now.as_secs_f64(), "robot": self.robot.name(),
                    "axis": axis,
                }));
            }
            _ => {}
        }
    }

    fn lease(&mut self, now: Micros, epoch: u32, printer: &Printer) {
        if std::mem::replace(&mut self.epoch, epoch) == epoch {
            return;
        }
        if epoch == 0 {
            self.tell(now, "the command lease has ended", printer);
        } else {
            self.tell(now, &format!("command lease taken, epoch {epoch}"), printer);
        }
        printer.json(&json!({
            "event": "lease", "t_s": now.as_secs_f64(), "robot": self.robot.name(),
            "epoch": epoch,
        }));
    }

    fn fault(&mut self, now: Micros, fault: Fault, printer: &Printer) {
        if self.fault.replace(fault) == Some(fault) {
            return;
        }
        self.faults += 1;
        self.tell(now, &fault_text(&fault), printer);
        let cause = fault.cause;
        let name = format!("{cause:?}");
        let (during, reaction) = (
            format!("{:?}", fault.during),
            format!("{:?}", cause.reaction()),
        );
        printer.json(&json!({
            "event": "fault", "t_s": now.as_secs_f64(), "robot": self.robot.name(),
            "code": cause.code(), "name": name, "axis": fault.axis.map(|axis| u16::from(axis) + 1),
            "step": fault.step, "during": during, "text": cause.text(), "reaction": reaction,
            "page": page(&fault),
        }));
    }

    fn tell(&self, now: Micros, what: &str, printer: &Printer) {
        printer.tell(format!(
            "[{:10.3} s] {}: {what}",
            now.as_secs_f64(),
            self.robot
        ));
    }
}

fn page(fault: &Fault) -> String {
    format!("docs/faults/{}.md", fault.cause.code())
}

/// A fault in one line; axes are counted from 1 for people.
fn fault_text(fault: &Fault) -> String {
    let axis = fault.axis.map_or_else(String::new, |axis| {
        format!(" on axis {}", u16::from(axis) + 1)
    });
    let cause = fault.cause;
    let reaction = match cause.reaction() {
        Reaction::PathStop => "path stop, then holding with torque on",
        Reaction::QuickStop => "quick stop, then torque off",
        Reaction::TorqueOff => "torque off",
    };
    format!(
        "fault {} {cause:?}{axis} while {:?}, servo step {}: {}; {reaction}; see {}",
        cause.code(),
        fault.during,
        fault.step,
        cause.text(),
        page(fault)
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use protocol::fault::Cause;

    #[test]
    fn every_fault_is_one_line_with_its_page() {
        for &cause in Cause::ALL {
            let fault = Fault {
                cause,
                axis: Some(2),
                step: 9,
                during: NodeState::Moving,
            };
            let text = fault_text(&fault);
            let page = format!("../../docs/faults/{}.md", cause.code());
            assert!(
                text.contains(" on axis 3 while Moving, servo step 9: "),
                "{text}"
            );
            assert!(text.ends_with(page.trim_start_matches("../../")), "{text}");
            assert!(std::path::Path::new(&page).exists(), "{page}");
        }
    }
}
