//! A whole cell in lock step: nodes, drives, mechanics and buses on one virtual clock.
//!
//! Everything the nodes and the drives know of each other travels as frames on virtual wires. The
//! MP is not here: it is one more tap of the MP wire, and whoever runs it calls [`Cell::advance`].
//! Nothing reads a clock, so the same inputs give the same bytes.

mod build;

pub use build::{Wiring, node, setup};

use crate::drive::SimDrive;
use crate::drive::quirk::Quirks;
use crate::fault::{Breakable, Broken, FaultSpec, Misplaced, Schedule};
use crate::plant::force_sensor::ForceNode;
use crate::plant::robot::{SUBSTEP_NS, Sender, Sent, SetupError, SimRobot};
use bus::StateChange;
use bus::wire::confinement::State;
use bus::wire::{BusFault, Kind, PostError, Statistics, Tap, Wire};
use firmware::config::ForceAddress;
use firmware::{ConfigError, DriveAddress, NodeProcess, Port, Received, Station};
use protocol::budget::Rates;
use protocol::frame::Frame;
use protocol::time::Micros;
use robots::RobotKind;

/// The tap of the MP on the MP wire.
const MP_TAP: Tap = 0;
/// The tap of the node on its drive wires.
const NODE_TAP: Tap = 0;

/// Looks on without taking part: records, measures, draws.
pub trait Observer {
    /// A frame has been transmitted completely on bus `bus` (its number in [`Cell::bus_names`]).
    fn frame(&mut self, bus: usize, at_ns: u64, frame: &Frame) {
        let _ = (bus, at_ns, frame);
    }
    /// The levels of the outputs at a robot's tool at a SYNC of its node, before [`Observer::motors`].
    fn outputs(&mut self, station: usize, at_ns: u64, levels: u16) {
        let _ = (station, at_ns, levels);
    }
    /// The motor angles (rad) that belong to where a robot's links are, at a SYNC of its node, after
    /// [`Observer::motors`]: the same unless a gear gives.
    fn links(&mut self, station: usize, at_ns: u64, motor_rad: &[f64]) {
        let _ = (station, at_ns, motor_rad);
    }
    /// The true motor angles (rad) of a robot at a SYNC of its node.
    fn motors(&mut self, station: usize, at_ns: u64, motor_rad: &[f64]) {
        let _ = (station, at_ns, motor_rad);
    }
}

/// Nobody looks on.
impl Observer for () {}

/// Why a cell cannot be built.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CellError {
    /// A node's configuration is wrong.
    #[error("{robot}: {source}")]
    Config {
        /// The robot.
        robot: RobotKind,
        /// What is wrong.
        source: ConfigError,
    },
    /// Not every axis was given a drive bus.
    #[error("{robot}: expected a drive bus for each of {expected} axes, got {got}")]
    Axes {
        /// The robot.
        robot: RobotKind,
        /// Its axes.
        expected: usize,
        /// Drive buses given.
        got: usize,
    },
    /// The simulated robot cannot be built.
    #[error("{robot}: {source}")]
    Robot {
        /// The robot.
        robot: RobotKind,
        /// What is wrong.
        source: SetupError,
    },
}

/// A robot with its node and drive wires.
#[derive(Debug)]
struct Place {
    kind: RobotKind,
    node: Box<dyn NodeProcess + Send>,
    robot: SimRobot,
    wires: Vec<Wire>,
    /// The tap of each axis' drive on its wire.
    taps: Vec<Tap>,
    /// The bus and the tap of the force sensor, once it has sent.
    force_tap: Option<(usize, Tap)>,
    /// Has no CAN controller on the drives' buses to do with errors?
    calm: bool,
    /// The states of the node's controllers on them, and those that have changed.
    controllers: Vec<State>,
    changed: Vec<(usize, State)>,
    /// For the node's next step, with the ns of their ends.
    rx: Vec<(u64, Received)>,
    spill: Vec<Sent>,
    first_bus: usize,
}

/// Nodes, drives, mechanics and wires.
#[derive(Debug)]
pub struct Cell {
    mp_wire: Wire,
    places: Vec<Place>,
    now_ns: u64,
    names: Vec<String>,
    mp_rx: Vec<(Micros, Frame)>,
    refused: Vec<PostError>,
    quirks: Quirks,
    faults: Schedule,
}

impl Cell {
    /// An empty cell whose MP wire is of this kind.
    #[must_use]
    pub fn new(mp_wire: Kind) -> Self {
        Self {
            mp_wire: Wire::new(mp_wire, 1),
            places: Vec::new(),
            now_ns: 0,
            names: vec!["mp".into()],
            mp_rx: Vec::new(),
            refused: Vec::new(),
            quirks: Quirks::default(),
            faults: Schedule::default(),
        }
    }

    /// The drives of robots that are added from now on do this otherwise than the book.
    #[must_use]
    pub const fn with_quirks(mut self, quirks: Quirks) -> Self {
        self.quirks = quirks;
        self
    }

    /// Add a robot with the node that every one of its kind has.
    ///
    /// # Errors
    /// [`CellError`], also for a robot whose drives need a torque offset and are to speak the fast profile.
    pub fn add(
        &mut self,
        kind: RobotKind,
        station: &Station,
        wiring: &Wiring<'_>,
        seed: u64,
    ) -> Result<(), CellError> {
        let (node, drives) = node(kind, station, wiring, self.now())?;
        let wire = if wiring.fast { Kind::Fd } else { Kind::Classic };
        self.place(kind, node, (&drives, wiring.force), seed, wire)
    }

    /// Add a robot with a node of one's own, for instance one with programs linked in.
    ///
    /// # Errors
    /// [`CellError`]
    pub fn add_node(
        &mut self,
        kind: RobotKind,
        node: Box<dyn NodeProcess + Send>,
        drives: &[DriveAddress],
        seed: u64,
    ) -> Result<(), CellError> {
        self.place(kind, node, (drives, None), seed, Kind::Classic)
    }

    fn place(
        &mut self,
        kind: RobotKind,
        node: Box<dyn NodeProcess + Send>,
        (drives, force): (&[DriveAddress], Option<ForceAddress>),
        seed: u64,
        wire: Kind,
    ) -> Result<(), CellError> {
        let mut setup = setup(kind, drives, seed, self.quirks);
        for axis in &mut setup.axes {
            axis.drive.fd = wire == Kind::Fd;
        }
        let buses = drives
            .iter()
            .map(|d| d.bus)
            .chain(force.map(|force| force.bus))
            .map(|bus| usize::from(bus) + 1)
            .max()
            .unwrap_or(0);
        let mut robot = SimRobot::new(setup, seed).map_err(|source| CellError::Robot {
            robot: kind,
            source,
        })?;
        robot.set_force_node(force.map(|address| ForceNode::of(kind, address, seed)));
        let first_bus = self.names.len();
        for bus in 0..buses {
            self.names.push(format!("{kind}.{bus}"));
        }
        self.mp_wire.add_tap();
        let mut wires: Vec<Wire> = (0..buses).map(|_| Wire::new(wire, 1)).collect();
        let mut taps = Vec::with_capacity(drives.len());
        for (axis, drive) in drives.iter().enumerate() {
            let Some(wire) = wires.get_mut(usize::from(drive.bus)) else {
                continue;
            };
            let tap = wire.add_tap();
            wire.set_mailboxes(
                tap,
                robot.drive(axis).map_or(usize::MAX, SimDrive::mailboxes),
            );
            taps.push(tap);
        }
        self.places.push(Place {
            kind,
            node,
            robot,
            wires,
            taps,
            force_tap: None,
            calm: true,
            controllers: vec![State::Active; buses],
            changed: Vec::new(),
            rx: Vec::new(),
            spill: Vec::new(),
            first_bus,
        });
        Ok(())
    }

    /// Other bit rates than 1 Mbit/s (FD data 5 Mbit/s) for a bus, from its next frame on; `bus` is
    /// its number in [`Self::bus_names`]. `false` if there is no such bus.
    #[must_use]
    pub fn set_rates(&mut self, bus: usize, rates: Rates) -> bool {
        self.wire_mut(bus)
            .map(|wire| wire.set_rates(rates))
            .is_some()
    }

    /// A bus, to disturb it; `bus` is its number in [`Self::bus_names`]. On the MP's wire tap 0 is the MP and
    /// tap j the node of the j-th robot, on a drive wire tap 0 the node, tap k the k-th of its drives in the order
    /// of the axes, and the last the force sensor, once it has sent.
    pub fn wire_mut(&mut self, bus: usize) -> Option<&mut Wire> {
        let drives = self.places.iter_mut().flat_map(|place| &mut place.wires);
        std::iter::once(&mut self.mp_wire).chain(drives).nth(bus)
    }

    /// Something is wrong with a bus from now on, or nothing any more; `bus` is its number in [`Self::bus_names`],
    /// taps are numbered as for [`Self::wire_mut`]. `false` if there is no such bus.
    #[must_use]
    pub fn set_bus_fault(&mut self, bus: usize, fault: Option<BusFault>) -> bool {
        self.wire_mut(bus)
            .map(|wire| wire.set_bus_fault(fault))
            .is_some()
    }

    /// These break when they are due, and no others any more. Robots are called by these names, in the order in which
    /// they were added.
    ///
    /// # Errors
    /// [`Misplaced`]; nothing is changed then.
    pub fn plan_faults(&mut self, specs: &[FaultSpec], names: &[&str]) -> Result<(), Misplaced> {
        let robots = self.places.iter().zip(names);
        let robots: Vec<Breakable<'_>> = robots
            .map(|(place, name)| Breakable {
                name,
                axes: place.taps.len(),
                buses: u8::try_from(place.wires.len()).unwrap_or(u8::MAX),
                force: place.robot.has_force_sensor(),
            })
            .collect();
        self.faults = Schedule::new(specs, &robots)?;
        Ok(())
    }

    /// Breaks what is due now.
    fn break_due(&mut self) {
        while let Some((station, broken)) = self.faults.take(self.now_ns) {
            let Some(place) = self.places.get_mut(station) else {
                continue;
            };
            match broken {
                Broken::Axis(axis, fault) => {
                    let _ = place.robot.inject(axis, fault);
                }
                Broken::Force(fault) => {
                    let _ = place.robot.break_force_sensor(fault);
                }
                Broken::Bus(bus, fault) => {
                    if let Some(wire) = place.wires.get_mut(usize::from(bus)) {
                        wire.set_bus_fault(fault);
                    }
                }
            }
        }
    }

    /// The names of the buses, in their order: `mp`, then each robot's drive buses.
    #[must_use]
    pub fn bus_names(&self) -> &[String] {
        &self.names
    }

    /// What went over each bus.
    #[must_use]
    pub fn statistics(&self) -> Vec<Statistics> {
        let drives = self.places.iter().flat_map(|place| &place.wires);
        std::iter::once(&self.mp_wire)
            .chain(drives)
            .map(Wire::statistics)
            .collect()
    }

    /// Frames that did not fit a transmit queue; none in a cell within its bus budget.
    #[must_use]
    pub fn refused(&self) -> &[PostError] {
        &self.refused
    }

    /// A CAN controller of a node on one of its drive buses whose state has changed: each change is told once, as the rim of
    /// a node tells it that is a process.
    pub fn take_change(&mut self) -> Option<StateChange> {
        let place = self
            .places
            .iter_mut()
            .find(|place| !place.changed.is_empty())?;
        let (bus, state) = place.changed.remove(0);
        let bus = self.names.get(place.first_bus + bus)?.clone();
        Some(StateChange { bus, state })
    }

    /// Virtual time, ns.
    #[must_use]
    pub const fn now_ns(&self) -> u64 {
        self.now_ns
    }

    /// Virtual time.
    #[must_use]
    pub const fn now(&self) -> Micros {
        Micros(self.now_ns / 1000)
    }

    /// The robots, in the order in which they were added.
    pub fn robots(&self) -> impl Iterator<Item = (RobotKind, &SimRobot)> {
        self.places.iter().map(|place| (place.kind, &place.robot))
    }

    /// A robot's mechanics and drives, to break something.
    pub fn robot_mut(&mut self, station: usize) -> Option<&mut SimRobot> {
        self.places.get_mut(station).map(|place| &mut place.robot)
    }

    /// A node, to look at.
    #[must_use]
    pub fn node(&self, station: usize) -> Option<&dyn NodeProcess> {
        self.places
            .get(station)
            .map(|place| &*place.node as &dyn NodeProcess)
    }

    /// The MP sends a frame now.
    pub fn send(&mut self, frame: Frame) {
        if let Err(error) = self.mp_wire.post(MP_TAP, self.now_ns, frame) {
            self.refused.push(error);
        }
    }

    /// What the MP has received since it was last asked.
    pub fn receive(&mut self) -> std::vec::Drain<'_, (Micros, Frame)> {
        self.mp_rx.drain(..)
    }

    /// Let time pass.
    pub fn advance(&mut self, until: Micros, observer: &mut impl Observer) {
        let until_ns = until.0 * 1000;
        while self.now_ns < until_ns {
            self.break_due();
            let wake = self
                .places
                .iter()
                .map(|p| p.node.next_wake().0 * 1000)
                .min();
            let slice = (self.now_ns / SUBSTEP_NS + 1) * SUBSTEP_NS;
            let next = [
                wake.filter(|at| *at > self.now_ns),
                self.faults.next_ns(),
                Some(slice),
                Some(until_ns),
            ];
            let next = next.into_iter().flatten().min().unwrap_or(until_ns);
            self.advance_wires(next, observer);
            self.now_ns = next;
            self.step_nodes(observer);
        }
    }

    fn advance_wires(&mut self, until_ns: u64, observer: &mut impl Observer) {
        let Self {
            mp_wire,
            places,
            mp_rx,
            ..
        } = self;
        mp_wire.advance(until_ns, &mut |delivery, _| {
            let at = Micros(delivery.at_ns / 1000);
            observer.frame(0, delivery.at_ns, delivery.frame);
            if delivery.reaches(MP_TAP) {
                mp_rx.push((at, *delivery.frame));
            }
            for (k, place) in places.iter_mut().enumerate() {
                if delivery.reaches(k + 1) {
                    let received = Received {
                        port: Port::Mp,
                        at,
                        frame: *delivery.frame,
                    };
                    place.rx.push((delivery.at_ns, received));
                }
            }
        });
        for place in places {
            place.advance(until_ns, observer);
        }
    }

    fn step_nodes(&mut self, observer: &mut impl Observer) {
        let now = Micros(self.now_ns / 1000);
        let Self {
            mp_wire,
            places,
            now_ns,
            refused,
            ..
        } = self;
        for (k, place) in places.iter_mut().enumerate() {
            if place.node.next_wake() > now {
                continue;
            }
            let mut synced = false;
            // buses advance one after the other; of what ends at once the MP's comes first
            place.rx.sort_by_key(|(at_ns, _)| *at_ns);
            let rx: Vec<Received> = place.rx.drain(..).map(|(_, received)| received).collect();
            let wires = &mut place.wires;
            place.node.step(now, &rx, &mut |port, frame| {
                let mut broken = false;
                let posted = match port {
                    Port::Mp => mp_wire.post(k + 1, *now_ns, frame),
                    Port::Drives(bus) => {
                        // of all frames to the drives only SYNC carries nothing
                        synced |= frame.data().is_empty();
                        wires.get_mut(usize::from(bus)).map_or(Ok(()), |wire| {
                            broken = wire.bus_fault().is_some();
                            wire.post(NODE_TAP, *now_ns, frame)
                        })
                    }
                };
                // what cannot go while a bus is broken waits until there is no room, and that is no fault of the cell's
                if let Err(error) = posted
                    && !broken
                {
                    refused.push(error);
                }
            });
            if synced {
                observer.outputs(k, *now_ns, place.robot.outputs());
                observer.motors(k, *now_ns, place.robot.motor_rad());
                observer.links(k, *now_ns, place.robot.links_rad());
            }
        }
    }
}

impl Place {
    fn advance(&mut self, until_ns: u64, observer: &mut impl Observer) {
        let Self {
            robot,
            wires,
            rx,
            spill,
            first_bus,
            taps,
            ..
        } = self;
        let tap_of = |axis: usize| taps.get(axis).copied().unwrap_or(NODE_TAP);
        for (bus, wire) in wires.iter_mut().enumerate() {
            wire.advance(until_ns, &mut |delivery, outbox| {
                observer.frame(*first_bus + bus, delivery.at_ns, delivery.frame);
                let number = u8::try_from(bus).unwrap_or(u8::MAX);
                if delivery.reaches(NODE_TAP) {
                    let received = Received {
                        port: Port::Drives(number),
                        at: Micros(delivery.at_ns / 1000),
                        frame: *delivery.frame,
                    };
                    rx.push((delivery.at_ns, received));
                }
                let hears = |axis: usize| delivery.reaches(tap_of(axis));
                let mut out = |sent: Sent| match sent.from {
                    Sender::Drive(axis) if sent.bus == number => {
                        // a full queue of a drive shows as a silent drive
                        let _ = outbox.post_at(tap_of(axis), sent.at_ns, sent.frame);
                    }
                    Sender::Drive(_) | Sender::ForceSensor => spill.push(sent),
                };
                robot.deliver(number, delivery.at_ns, delivery.frame, &hears, &mut out);
            });
        }
        robot.advance(until_ns, &mut |sent| spill.push(sent));
        self.watch_controllers(until_ns);
        self.post_spilt();
    }

    /// Drives learn how their CAN controllers are, and tell those that are bus-off to recover. What the node's do is told.
    fn watch_controllers(&mut self, now_ns: u64) {
        let plain = self.wires.iter().all(Wire::is_plain);
        if plain && self.calm {
            return;
        }
        self.calm = plain;
        let node = self.wires.iter().map(|wire| wire.state(NODE_TAP));
        for (bus, (before, state)) in self.controllers.iter_mut().zip(node).enumerate() {
            if core::mem::replace(before, state) != state {
                self.changed.push((bus, state));
            }
        }
        for (axis, tap) in self.taps.iter().copied().enumerate() {
            let bus = self.robot.bus_of(axis).map(usize::from);
            let Some(wire) = bus.and_then(|bus| self.wires.get_mut(bus)) else {
                continue;
            };
            let spill = &mut self.spill;
            let mut out = |sent| spill.push(sent);
            if self
                .robot
                .on_bus_state(axis, now_ns, wire.state(tap), &mut out)
            {
                wire.clear(tap);
                wire.recover(tap);
            }
        }
    }

    /// Posts what was not sent in answer to a frame of the same bus.
    fn post_spilt(&mut self) {
        for sent in self.spill.drain(..) {
            let bus = usize::from(sent.bus);
            let Some(wire) = self.wires.get_mut(bus) else {
                continue;
            };
            let tap = match (sent.from, self.force_tap) {
                (Sender::Drive(axis), _) => self.taps.get(axis).copied().unwrap_or(NODE_TAP),
                (Sender::ForceSensor, Some((at, tap))) if at == bus => tap,
                (Sender::ForceSensor, _) => {
                    let tap = wire.add_tap();
                    self.force_tap = Some((bus, tap));
                    tap
                }
            };
            let _ = wire.post(tap, sent.at_ns, sent.frame);
        }
    }
}
