//! A node once more, given the frames that the Master Process and its drives sent it.

use super::comparison::Comparison;
use firmware::{NodeProcess, Port, Received, Station};
use hil_sim::cell::{CellError, Wiring, node};
use hil_sim::plant::robot::SUBSTEP_NS;
use protocol::canopen::node::{NodeId as DriveNode, is_from_master};
use protocol::frame::{Frame, Id};
use protocol::id::{CanId, NodeId};
use protocol::time::Micros;
use robots::RobotKind;

/// A node being replayed.
#[derive(Debug)]
pub(super) struct NodeReplay {
    node: Box<dyn NodeProcess + Send>,
    id: NodeId,
    /// Its node number on the buses of its drives.
    master: DriveNode,
    /// Number of the first of its drive buses.
    first_bus: usize,
    buses: usize,
    heard: Vec<Received>,
    now_ns: u64,
    pub(super) received: u64,
    pub(super) comparison: Comparison,
}

impl NodeReplay {
    /// The node of a robot, begun at time 0, with its first drive bus.
    pub(super) fn new(
        kind: RobotKind,
        station: &Station,
        (id, master): (NodeId, DriveNode),
        (first_bus, wiring): (usize, &Wiring<'_>),
    ) -> Result<Self, CellError> {
        let (node, drives) = node(kind, station, wiring, Micros(0))?;
        let force = wiring.force.map(|force| force.bus);
        let used = drives.iter().map(|drive| drive.bus).chain(force);
        let last = used.map(usize::from).max();
        Ok(Self {
            node,
            id,
            master,
            first_bus,
            buses: last.map_or(0, |last| last + 1),
            heard: Vec::new(),
            now_ns: 0,
            received: 0,
            comparison: Comparison::default(),
        })
    }

    /// How many drive buses it has.
    pub(super) const fn buses(&self) -> usize {
        self.buses
    }

    /// The port of a bus.
    fn port(&self, bus: usize) -> Option<Port> {
        if bus == 0 {
            return Some(Port::Mp);
        }
        let number = bus.checked_sub(self.first_bus)?;
        let number = u8::try_from(number).ok()?;
        (usize::from(number) < self.buses).then_some(Port::Drives(number))
    }

    fn sends(&self, port: Port, id: Id) -> bool {
        match (port, id) {
            (Port::Mp, id) => CanId::parse(id).is_some_and(|id| id.source == self.id),
            (Port::Drives(_), Id::Standard(cob)) => is_from_master(cob, self.master),
            (Port::Drives(_), Id::Extended(_)) => false,
        }
    }

    /// A frame of any bus, in the order of time.
    pub(super) fn frame(&mut self, at_ns: u64, bus: usize, frame: &Frame) {
        let Some(port) = self.port(bus) else {
            return;
        };
        // what ends as a step begins is part of it
        self.advance(at_ns.saturating_sub(1));
        if self.sends(port, frame.id()) {
            self.comparison.recorded(at_ns, bus, frame);
        } else {
            self.received += 1;
            self.heard.push(Received {
                port,
                at: Micros(at_ns / 1000),
                frame: *frame,
            });
        }
    }

    /// Every step that is due until then, inclusive.
    pub(super) fn advance(&mut self, until_ns: u64) {
        loop {
            let due_ns = self.due_ns();
            if due_ns > until_ns {
                return;
            }
            self.now_ns = due_ns;
            let Self {
                node,
                heard,
                comparison,
                first_bus,
                ..
            } = self;
            node.step(Micros(due_ns / 1000), heard, &mut |port, frame| {
                let bus = match port {
                    Port::Mp => 0,
                    Port::Drives(number) => *first_bus + usize::from(number),
                };
                comparison.made(due_ns, bus, frame);
            });
            heard.clear();
        }
    }

    /// When its cell gives it the next step: when it wakes, or if that has passed when mechanics are next
    /// evaluated.
    fn due_ns(&self) -> u64 {
        let wake_ns = self.node.next_wake().0 * 1000;
        if wake_ns > self.now_ns {
            wake_ns
        } else {
            (self.now_ns / SUBSTEP_NS + 1) * SUBSTEP_NS
        }
    }
}
