//! Where the robots are: in this process on a virtual clock, or at the other end of a bus.

use crate::observe::Observers;
use crate::run::MACROSTEP;
use bus::hub::HubClient;
use bus::spec::Place;
use bus::wire::{Kind, Statistics};
use bus::{Bus, BusError, Hears, open_can};
use firmware::config::ForceAddress;
use firmware::{KnownDrives, Station};
use hil_sim::cell::{Cell as SimCell, CellError, Observer, Wiring};
use hil_sim::fault::FaultSpec;
use hil_sim::plant::contact::{Obstacle, Plate, Tip};
use host::error::Error;
use host::task::{self, BusKind, Cell, RobotSpec};
use nalgebra::Vector3;
use process::Lateness;
use protocol::force_torque::SensorNumber;
use protocol::frame::Frame;
use protocol::id::NodeId;
use protocol::time::Micros;
use protocol::transfer::Mtu;
use std::io::Write as _;
use std::time::{Duration, Instant};

/// How long a hub may take to appear: its simulator may be starting in the same second.
const HUB_PATIENCE: Micros = Micros::from_millis(5000);

/// Robots that can be reached by frames.
pub(crate) trait World {
    /// How long the frames to the nodes may be.
    fn mtu(&self) -> Mtu;
    /// Bus time.
    fn now(&self) -> Micros;
    /// Send a frame to the nodes, now.
    fn send(&mut self, frame: &Frame) -> Result<(), Error>;
    /// Let time pass and append what arrived meanwhile.
    fn pass(
        &mut self,
        until: Micros,
        observers: &mut Observers,
        rx: &mut Vec<(Micros, Frame)>,
    ) -> Result<(), Error>;
    /// How late [`World::pass`] returned; of a world that does not wait for its master.
    fn lateness(&self) -> Option<&Lateness> {
        None
    }
    /// Names and statistics of the buses, as far as they are known here.
    fn buses(&self) -> Vec<(String, Statistics)>;
    /// Are the true motor angles known (and the path error of the mechanics with them)?
    fn knows_mechanics(&self) -> bool;
    /// Is everything that goes over the buses seen, with its timing?
    fn sees_whole_buses(&self) -> bool;
}

/// The embedded default: nodes, drives and mechanics in this process.
pub(crate) struct Virtual {
    cell: SimCell,
    mtu: Mtu,
    names: Vec<String>,
    pace: Option<Instant>,
}

impl Virtual {
    /// The cell of a task, simulated; `realtime` paces it by the wall clock.
    ///
    /// The nodes have the numbers by which the MP knows them.
    pub(crate) fn new(
        cell: &Cell,
        nodes: &[NodeId],
        seed: u64,
        realtime: bool,
    ) -> Result<Self, Error> {
        let mp = mp_bus(cell)?;
        let (kind, mtu) = match mp.kind {
            BusKind::Classic => (Kind::Classic, Mtu::Classic),
            BusKind::Fd { .. } => (Kind::Fd, Mtu::Fd),
        };
        let mut sim = SimCell::new(kind);
        // in the order of the simulated buses
        let mut buses = vec![mp];
        for (robot, (station, bus_of_axis)) in
            cell.robots.iter().zip(stations(cell, nodes, seed, mtu))
        {
            for group in &robot.drives {
                buses.push(bus_of(cell, group.bus)?);
            }
            let force = force_address(robot);
            if let (Some(bus), Some(address)) = (robot.force_bus, force)
                && usize::from(address.bus) == robot.drives.len()
            {
                buses.push(bus_of(cell, bus)?);
            }
            let wiring = Wiring {
                buses: &bus_of_axis,
                fast: robot.fast_drives,
                force,
                drives: known_drives(robot),
            };
            let added = sim.add(robot.kind, &station, &wiring, seed);
            added.map_err(|e: CellError| internal(&e))?;
        }
        surround(&mut sim, cell);
        for (number, bus) in buses.iter().enumerate() {
            if !sim.set_rates(number, bus.rates()) {
                return Err(internal(&format!("bus {} is not simulated", bus.name)));
            }
        }
        Ok(Self {
            cell: sim,
            mtu,
            names: buses.iter().map(|bus| bus.name.clone()).collect(),
            pace: realtime.then(Instant::now),
        })
    }

    /// These break when they are due.
    pub(crate) fn plan_faults(&mut self, cell: &Cell, specs: &[FaultSpec]) -> Result<(), Error> {
        let names: Vec<&str> = cell
            .robots
            .iter()
            .map(|robot| robot.name.as_str())
            .collect();
        let planned = self.cell.plan_faults(specs, &names);
        planned.map_err(|misplaced| Error::Usage {
            what: format!("--fault {}", misplaced.spec),
            expected: misplaced.expected,
            got: "something else".into(),
        })
    }
}

/// The nodes of a simulated cell, and on which of its drive buses each axis hangs.
pub(crate) fn stations(
    cell: &Cell,
    nodes: &[NodeId],
    seed: u64,
    mtu: Mtu,
) -> impl Iterator<Item = (Station, Vec<u8>)> {
    nodes.iter().zip(&cell.robots).map(move |(node, robot)| {
        let effector = node.get().saturating_sub(NodeId::EFFECTOR_BASE);
        let station = Station {
            effector,
            unique_id: seed.wrapping_mul(1000).wrapping_add(u64::from(effector)),
            mtu,
            law: robot.servo,
            velocity_factor: robot.velocity_factor,
            one_wire: false,
            track: robot.track,
        };
        let mut bus_of_axis = vec![0_u8; robot.axes()];
        for (number, group) in (0..).zip(&robot.drives) {
            for axis in &group.axes {
                if let Some(bus) = bus_of_axis.get_mut(*axis) {
                    *bus = number;
                }
            }
        }
        (station, bus_of_axis)
    })
}

/// What the node of a robot is told of its drives.
pub(crate) fn known_drives(robot: &RobotSpec) -> KnownDrives<'_> {
    KnownDrives {
        identities: &robot.identities,
        find: robot.find_drives,
        stored: robot.stored_setup,
    }
}

/// The force sensor of a robot: the first of its bus, which is one of the drives' or the next.
pub(crate) fn force_address(robot: &RobotSpec) -> Option<ForceAddress> {
    let bus = robot.force_bus?;
    let drives = robot.drives.iter().position(|group| group.bus == bus);
    Some(ForceAddress {
        bus: u8::try_from(drives.unwrap_or(robot.drives.len())).ok()?,
        number: SensorNumber::new(0)?,
    })
}

/// Puts what stands in the way of tools around the robots; their tools touch it with a point.
fn surround(sim: &mut SimCell, cell: &Cell) {
    for (number, robot) in cell.robots.iter().enumerate() {
        let own = cell
            .surfaces
            .iter()
            .filter(|surface| surface.robot == number);
        let obstacles: Vec<Obstacle> = own
            .map(|surface| {
                let plate = Plate {
                    point_m: Vector3::from(surface.point_m),
                    normal: Vector3::from(surface.normal),
                    edge_m: surface.edge_m,
                    stiffness_n_m: surface.stiffness_n_m,
                };
                plate.obstacle()
            })
            .collect();
        if obstacles.is_empty() {
            continue;
        }
        let tip = Tip::of(robot.kind);
        if let Some(robot) = sim.robot_mut(number) {
            let _ = robot.surround(obstacles, tip);
        }
    }
}

/// The bus of a number in a cell.
fn bus_of(cell: &Cell, number: usize) -> Result<&task::BusSpec, Error> {
    let bus = cell.buses.get(number);
    bus.ok_or_else(|| internal(&format!("the cell has no bus number {number}")))
}

/// The one bus between the MP and the nodes.
fn mp_bus(cell: &Cell) -> Result<&task::BusSpec, Error> {
    let mut numbers = cell.robots.iter().map(|robot| robot.mp_bus);
    let first = numbers
        .next()
        .ok_or_else(|| internal(&"a cell without robots"))?;
    if numbers.any(|other| other != first) {
        return Err(internal(&"the simulated cell has one bus towards the MP"));
    }
    bus_of(cell, first)
}

fn internal(what: &impl ToString) -> Error {
    Error::Internal(what.to_string())
}

impl World for Virtual {
    fn mtu(&self) -> Mtu {
        self.mtu
    }

    fn now(&self) -> Micros {
        self.cell.now()
    }

    fn send(&mut self, frame: &Frame) -> Result<(), Error> {
        self.cell.send(*frame);
        Ok(())
    }

    fn pass(
        &mut self,
        until: Micros,
        observers: &mut Observers,
        rx: &mut Vec<(Micros, Frame)>,
    ) -> Result<(), Error> {
        self.cell.advance(until, observers);
        while let Some(change) = self.cell.take_change() {
            // a closed stderr is no reason to stop a robot
            let _ = writeln!(std::io::stderr(), "mrroc: {change}");
        }
        observers.passed();
        rx.extend(self.cell.receive());
        if let Some(start) = self.pace {
            let due = start + Duration::from_micros(until.0);
            let now = Instant::now();
            if due > now {
                std::thread::sleep(due - now);
            }
        }
        match self.cell.refused().first() {
            Some(error) => Err(Error::Bus {
                bus: "virtual".into(),
                reason: error.to_string(),
            }),
            None => Ok(()),
        }
    }

    fn buses(&self) -> Vec<(String, Statistics)> {
        self.names
            .iter()
            .cloned()
            .zip(self.cell.statistics())
            .collect()
    }

    fn knows_mechanics(&self) -> bool {
        true
    }

    fn sees_whole_buses(&self) -> bool {
        true
    }
}

/// Nodes at the other end of a real bus, in real time.
pub(crate) struct Remote {
    bus: Box<dyn Bus>,
    mtu: Mtu,
    name: String,
    frames: u64,
    /// Sent since time last passed: a transport does not return one's own frames.
    sent: Vec<(Micros, Frame)>,
    lateness: Lateness,
}

impl Remote {
    /// Connect to the MP's bus.
    pub(crate) fn connect(place: &Place) -> Result<Self, Error> {
        let (bus, mtu) = open_bus(place)?;
        Ok(Self {
            bus,
            mtu,
            name: place.to_string(),
            frames: 0,
            sent: Vec::new(),
            lateness: Lateness::new(MACROSTEP.into()),
        })
    }
}

/// The MP's bus of a cell that is not in this process, and how long its frames may be.
pub(crate) fn open_bus(place: &Place) -> Result<(Box<dyn Bus>, Mtu), Error> {
    match place {
        Place::Hub { host, port } => {
            let deadline = bus::now() + HUB_PATIENCE;
            let client =
                HubClient::connect(host, *port, "mp", deadline).map_err(|e| bus_error(&e))?;
            // its protocol has no FD frames
            Ok((Box::new(client), Mtu::Classic))
        }
        Place::Slcan(adapter) => {
            let line = adapter.open().map_err(|e| bus_error(&e))?;
            Ok((Box::new(line), Mtu::Classic))
        }
        Place::Can { interface } => {
            let (bus, mtu) = open_can(interface, Hears::Extended).map_err(|e| bus_error(&e))?;
            Ok((bus, mtu))
        }
    }
}

pub(crate) fn bus_error(error: &BusError) -> Error {
    let text = error.to_string();
    let (bus, reason) = text.split_once(": ").unwrap_or(("bus", &text));
    Error::Bus {
        bus: bus.into(),
        reason: reason.into(),
    }
}

impl World for Remote {
    fn mtu(&self) -> Mtu {
        self.mtu
    }

    fn now(&self) -> Micros {
        bus::now()
    }

    fn send(&mut self, frame: &Frame) -> Result<(), Error> {
        self.frames += 1;
        self.bus.send(frame).map_err(|e| bus_error(&e))?;
        self.sent.push((bus::now(), *frame));
        Ok(())
    }

    fn pass(
        &mut self,
        until: Micros,
        observers: &mut Observers,
        rx: &mut Vec<(Micros, Frame)>,
    ) -> Result<(), Error> {
        for (at, frame) in self.sent.drain(..) {
            observers.record(0, at.0 * 1000, &frame);
        }
        loop {
            while let Some(received) = self.bus.receive().map_err(|e| bus_error(&e))? {
                self.frames += 1;
                observers.frame(0, received.at.0 * 1000, &received.frame);
                rx.push((received.at, received.frame));
            }
            while let Some(change) = self.bus.take_change() {
                // a closed stderr is no reason to stop a robot
                let _ = writeln!(std::io::stderr(), "mrroc: {change}");
            }
            let now = bus::now();
            if now >= until {
                self.lateness.record(now.since(until).into());
                observers.passed();
                return Ok(());
            }
            self.bus.wait(until).map_err(|e| bus_error(&e))?;
        }
    }

    fn lateness(&self) -> Option<&Lateness> {
        Some(&self.lateness)
    }

    fn buses(&self) -> Vec<(String, Statistics)> {
        let statistics = Statistics {
            frames: self.frames,
            ..Statistics::default()
        };
        vec![(self.name.clone(), statistics)]
    }

    fn knows_mechanics(&self) -> bool {
        false
    }

    fn sees_whole_buses(&self) -> bool {
        false
    }
}

#[cfg(test)]
mod test;
