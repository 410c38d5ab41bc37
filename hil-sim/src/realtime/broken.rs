//! Drive buses between processes of which something is wrong.
//!
//! Who is cut off neither hears the node nor is heard. What the CAN controllers make of that is not simulated here: a
//! hub has none. Lock step has ([`crate::cell`]).

use crate::fault::Broken;
use crate::plant::robot::{Sender, Sent, SimRobot};
use bus::wire::{BusFault, Tap};

/// The tap of the node on every bus.
const NODE_TAP: Tap = 0;

/// The buses of one robot.
#[derive(Clone, Debug)]
pub(super) struct BrokenBuses {
    faults: Vec<Option<BusFault>>,
    /// The bus and the tap of each axis' drive.
    places: Vec<(u8, Tap)>,
}

impl BrokenBuses {
    /// Nothing is wrong yet.
    pub(super) fn new(robot: &SimRobot, buses: usize) -> Self {
        let on = (0..robot.motor_rad().len()).map_while(|axis| robot.bus_of(axis));
        let mut used = vec![NODE_TAP; usize::from(u8::MAX) + 1];
        let places = on.map(|bus| {
            let mut tap = NODE_TAP;
            if let Some(used) = used.get_mut(usize::from(bus)) {
                *used += 1;
                tap = *used;
            }
            (bus, tap)
        });
        let places = places.collect();
        Self {
            faults: vec![None; buses],
            places,
        }
    }

    /// Something breaks, or is mended.
    pub(super) fn apply(&mut self, broken: Broken, robot: &mut SimRobot) {
        match broken {
            Broken::Axis(axis, fault) => {
                let _ = robot.inject(axis, fault);
            }
            Broken::Force(fault) => {
                let _ = robot.break_force_sensor(fault);
            }
            Broken::Bus(bus, fault) => {
                if let Some(now) = self.faults.get_mut(usize::from(bus)) {
                    *now = fault;
                }
            }
        }
    }

    /// Does what `from` sends get to `to`?
    fn connects(&self, bus: u8, from: Tap, to: Tap) -> bool {
        match self.faults.get(usize::from(bus)).copied().flatten() {
            None => true,
            Some(BusFault::StuckDominant | BusFault::Short) => false,
            Some(BusFault::Cut(last)) => (from > last) == (to > last),
            Some(BusFault::Wrecked(tap)) => from != tap,
        }
    }

    fn tap_of(&self, axis: usize) -> Tap {
        self.places.get(axis).map_or(NODE_TAP, |(_, tap)| *tap)
    }

    /// Does the drive of this axis hear the node?
    pub(super) fn hears(&self, bus: u8, axis: usize) -> bool {
        self.connects(bus, NODE_TAP, self.tap_of(axis))
    }

    /// Does the node hear this?
    pub(super) fn passes(&self, sent: &Sent) -> bool {
        let from = match sent.from {
            Sender::Drive(axis) => self.tap_of(axis),
            // behind all drives of its bus
            Sender::ForceSensor => {
                let on_bus = self.places.iter().filter(|(bus, _)| *bus == sent.bus);
                on_bus.count() + 1
            }
        };
        self.connects(sent.bus, from, NODE_TAP)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cell::setup;
    use crate::drive::quirk::Quirks;
    use firmware::DriveAddress;
    use firmware::process::drive_buses;
    use protocol::canopen::node::NodeId;
    use protocol::frame::{Frame, Id};
    use robots::RobotKind;

    fn track() -> (SimRobot, BrokenBuses) {
        let addresses = (1..).zip(drive_buses(RobotKind::Irp6Track));
        let addresses: Vec<DriveAddress> = addresses
            .map(|(id, bus)| DriveAddress {
                bus,
                id: NodeId::new(id).unwrap(),
            })
            .collect();
        let setup = setup(RobotKind::Irp6Track, &addresses, 1, Quirks::default());
        let robot = SimRobot::new(setup, 1).unwrap();
        let buses = BrokenBuses::new(&robot, 2);
        (robot, buses)
    }

    /// Which axes hear the node, and are heard by it, when that is wrong with the first bus.
    fn left(fault: BusFault) -> (Vec<usize>, Vec<usize>) {
        let (mut robot, mut buses) = track();
        buses.apply(Broken::Bus(0, Some(fault)), &mut robot);
        let bus = |axis: usize| robot.bus_of(axis).unwrap();
        let sent = |axis: usize| Sent {
            at_ns: 0,
            bus: bus(axis),
            from: Sender::Drive(axis),
            frame: Frame::short(Id::Standard(0x181), [0; 8], 8),
        };
        (
            (0..7)
                .filter(|axis| buses.hears(bus(*axis), *axis))
                .collect(),
            (0..7).filter(|axis| buses.passes(&sent(*axis))).collect(),
        )
    }

    #[test]
    fn a_fault_of_a_bus_parts_those_it_parts_and_no_others() {
        // four drives on the first bus, three on the second
        let other = vec![4, 5, 6];
        for fault in [BusFault::StuckDominant, BusFault::Short, BusFault::Cut(0)] {
            assert_eq!(left(fault), (other.clone(), other.clone()), "{fault}");
        }
        let near = vec![0, 1, 4, 5, 6];
        assert_eq!(left(BusFault::Cut(2)), (near.clone(), near));
        let all: Vec<usize> = (0..7).collect();
        assert_eq!(
            left(BusFault::Wrecked(2)),
            (all.clone(), vec![0, 2, 3, 4, 5, 6])
        );
        assert_eq!(left(BusFault::Wrecked(0)), (other, all));
    }
}
