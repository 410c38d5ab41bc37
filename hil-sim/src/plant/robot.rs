//! The drives and plants of one robot on its drive buses.

use bus::wire::confinement::State;
use protocol::canopen::emcy::ErrorCode;
use protocol::canopen::node::NodeId;
use protocol::frame::Frame;

use super::axis::{AxisPlant, Broken, Drive};
use super::contact::{Obstacle, Tip};
use super::force_sensor::{self, ForceFault, ForceNode};
use super::gear::{Gear, GearError};
use super::mechanics::{Mechanics, Wrist};
use super::parameters::{AxisSetup, RobotSetup};
use super::random::SplitMix64;
use crate::drive::{DriveFault, SimDrive};
use robots::dynamics::Body;

/// The substep of drives and plants: 0.25 ms.
pub const SUBSTEP_NS: u64 = 250_000;

/// Who sends on a drive bus of a robot: each is a node of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sender {
    /// The drive of this axis.
    Drive(usize),
    /// The force sensor in the wrist.
    ForceSensor,
}

/// A frame a drive or the force sensor sends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sent {
    /// When, ns.
    pub at_ns: u64,
    /// On which of the robot's drive buses, from 0.
    pub bus: u8,
    /// Who.
    pub from: Sender,
    /// What.
    pub frame: Frame,
}

/// Why a robot could not be built.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SetupError {
    /// A node identifier is outside 1 to 127.
    #[error("node identifier {node} of axis {axis} is outside 1 to 127")]
    Node {
        /// The axis, from 0.
        axis: usize,
        /// The identifier.
        node: u8,
    },
    /// Two drives on one bus have the same node identifier.
    #[error("two drives on bus {bus} have the node identifier {node}")]
    Double {
        /// The bus.
        bus: u8,
        /// The identifier.
        node: u8,
    },
    /// The substep is 0.
    #[error("the substep is 0")]
    Substep,
    /// The mechanics moves another number of axes.
    #[error("the mechanics moves {expected} axes, got {got}")]
    Axes {
        /// Axes it moves.
        expected: usize,
        /// Axes of the setup.
        got: usize,
    },
}

/// A drive on its bus.
struct OnBus {
    bus: u8,
    drive: SimDrive,
    /// What was put into it from outside.
    injected: Option<DriveFault>,
    /// Has its motor's thermal switch opened?
    hot: bool,
}

impl OnBus {
    /// The thermal switch is an input of the drive: while it is open the drive trips, unless something else
    /// was put into it.
    fn heed(&mut self, hot: bool) {
        self.hot = hot;
        let tripped = hot.then_some(DriveFault::Trip(ErrorCode::OVER_TEMPERATURE));
        self.drive.set_fault(self.injected.or(tripped));
    }
}

/// One robot: its drives, motors and links.
pub struct SimRobot {
    drives: Vec<OnBus>,
    plants: Vec<AxisPlant>,
    mechanics: Box<dyn Mechanics>,
    force: Option<ForceNode>,
    /// What the drives command in this substep.
    commands: Vec<Drive>,
    motor_rad: Vec<f64>,
    links_rad: Vec<f64>,
    substep_ns: u64,
    substep_s: f64,
    now_ns: u64,
}

impl core::fmt::Debug for SimRobot {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("SimRobot")
            .field("now_ns", &self.now_ns)
            .field("motor_rad", &self.motor_rad)
            .finish_non_exhaustive()
    }
}

impl SimRobot {
    /// A robot that is switched on at time 0, with the default substep.
    ///
    /// # Errors
    /// [`SetupError`].
    pub fn new(setup: RobotSetup, seed: u64) -> Result<Self, SetupError> {
        Self::with_substep(setup, seed, SUBSTEP_NS)
    }

    /// A robot that is switched on at time 0, integrated in substeps of `substep_ns`.
    ///
    /// # Errors
    /// [`SetupError`].
    pub fn with_substep(setup: RobotSetup, seed: u64, substep_ns: u64) -> Result<Self, SetupError> {
        if substep_ns == 0 {
            return Err(SetupError::Substep);
        }
        #[expect(clippy::cast_precision_loss, reason = "a substep is far below 2^53 ns")]
        let dt_s = substep_ns as f64 * 1e-9;
        let RobotSetup { axes, mechanics } = setup;
        if let Some(expected) = mechanics.axes().filter(|expected| *expected != axes.len()) {
            let got = axes.len();
            return Err(SetupError::Axes { expected, got });
        }
        let mut drives: Vec<OnBus> = Vec::with_capacity(axes.len());
        let mut plants = Vec::with_capacity(axes.len());
        for (number, axis) in axes.iter().enumerate() {
            let AxisSetup { bus, node, .. } = *axis;
            let id = NodeId::new(node).ok_or(SetupError::Node { axis: number, node })?;
            if drives
                .iter()
                .any(|other| other.bus == bus && other.drive.node() == id)
            {
                return Err(SetupError::Double { bus, node });
            }
            let random = SplitMix64::stream(seed, "home switch bounce", u64::from(node));
            drives.push(OnBus {
                bus,
                drive: SimDrive::new(id, axis.drive, 0, dt_s),
                injected: None,
                hot: false,
            });
            plants.push(AxisPlant::new(axis.plant, axis.start_rad, dt_s, random));
        }
        Ok(Self {
            commands: vec![Drive::default(); drives.len()],
            motor_rad: plants.iter().map(AxisPlant::angle_rad).collect(),
            links_rad: plants.iter().map(AxisPlant::angle_rad).collect(),
            drives,
            plants,
            mechanics,
            force: None,
            substep_ns,
            substep_s: dt_s,
            now_ns: 0,
        })
    }

    /// True motor angles, rad, in axis order: 0 where homing ends. For observers; no node sees it.
    #[must_use]
    pub fn motor_rad(&self) -> &[f64] {
        &self.motor_rad
    }

    /// The time the simulation has reached, ns: a whole number of substeps.
    #[must_use]
    pub const fn now_ns(&self) -> u64 {
        self.now_ns
    }

    /// The drive of an axis.
    #[must_use]
    pub fn drive(&self, axis: usize) -> Option<&SimDrive> {
        self.drives.get(axis).map(|axis| &axis.drive)
    }

    /// The drive bus of an axis.
    #[must_use]
    pub fn bus_of(&self, axis: usize) -> Option<u8> {
        self.drives.get(axis).map(|axis| axis.bus)
    }

    /// The plant of an axis.
    #[must_use]
    pub fn plant(&self, axis: usize) -> Option<&AxisPlant> {
        self.plants.get(axis)
    }

    /// The levels of the tool's outputs: those of the last axis' drive.
    #[must_use]
    pub fn outputs(&self) -> u16 {
        self.drives.last().map_or(0, |axis| axis.drive.outputs())
    }

    /// Puts a fault into an axis, or takes its faults out. `false` if there is no such axis.
    pub fn inject(&mut self, axis: usize, fault: Option<DriveFault>) -> bool {
        let (Some(on_bus), Some(plant)) = (self.drives.get_mut(axis), self.plants.get_mut(axis))
        else {
            return false;
        };
        let mut broken = Broken::default();
        match fault {
            Some(DriveFault::Encoder(wrong)) => broken.encoder = Some(wrong),
            Some(DriveFault::SwitchStuck(level)) => broken.switch = Some(level),
            Some(DriveFault::IndexMissing) => broken.index = true,
            Some(DriveFault::Trip(_) | DriveFault::Silent | DriveFault::Blank) | None => {}
        }
        plant.set_broken(broken);
        on_bus.injected = fault;
        on_bus.heed(on_bus.hot);
        true
    }

    /// Sets the 16 free digital inputs of an axis' drive, the first two of which are its probe inputs. `false` if there
    /// is no such axis.
    pub fn set_inputs(&mut self, axis: usize, levels: u16) -> bool {
        let drive = self.drives.get_mut(axis).map(|axis| &mut axis.drive);
        drive.map(|drive| drive.set_inputs(levels)).is_some()
    }

    /// Breaks or mends the receptors of an axis, in more ways than [`DriveFault`] has. `false` if there is no
    /// such axis.
    pub fn set_broken(&mut self, axis: usize, broken: Broken) -> bool {
        let plant = self.plants.get_mut(axis);
        plant.map(|plant| plant.set_broken(broken)).is_some()
    }

    /// Fixes a body, in the flange's frame, to the flange instead of what was there; `false` if the robot
    /// has none.
    pub fn carry(&mut self, body: Option<&Body>) -> bool {
        self.mechanics.carry(body)
    }

    /// Puts a gear that gives between a motor and its links, or takes it out again. None has one from the start:
    /// nobody published the stiffness of any of the robots.
    ///
    /// # Errors
    /// [`GearError`].
    pub fn set_gear(&mut self, axis: usize, gear: Option<Gear>) -> Result<(), GearError> {
        self.mechanics.set_gear(axis, gear)
    }

    /// The motor angles that belong to where the links are, rad, in axis order: those of the motors unless a gear
    /// gives. For observers; no node sees it.
    #[must_use]
    pub fn links_rad(&self) -> &[f64] {
        &self.links_rad
    }

    /// Puts stiff bodies around the robot, in its base frame, and a tip on its tool; `false` if it has no flange.
    pub fn surround(&mut self, obstacles: Vec<Obstacle>, tip: Tip) -> bool {
        self.mechanics.surround(obstacles, tip)
    }

    /// Puts a force sensor into the wrist, with its own node on a bus, instead of what was there; takes it out.
    /// It is silent on a robot without a flange.
    pub fn set_force_node(&mut self, node: Option<ForceNode>) {
        self.force = node;
    }

    /// Has it a force sensor on a bus?
    #[must_use]
    pub const fn has_force_sensor(&self) -> bool {
        self.force.is_some()
    }

    /// Breaks or mends the force sensor. `false` if there is none.
    pub fn break_force_sensor(&mut self, fault: Option<ForceFault>) -> bool {
        self.force
            .as_mut()
            .map(|node| node.set_fault(fault))
            .is_some()
    }

    /// The wrist after the last substep; none where there is none.
    #[must_use]
    pub fn wrist(&self) -> Option<Wrist> {
        self.mechanics.wrist(&self.plants)
    }

    /// Runs drives and plants up to `now_ns`; `out` gets what the drives send, in order of time.
    pub fn advance(&mut self, now_ns: u64, out: &mut impl FnMut(Sent)) {
        while self.now_ns + self.substep_ns <= now_ns {
            self.now_ns += self.substep_ns;
            self.substep(out);
        }
    }

    #[inline]
    fn substep(&mut self, out: &mut impl FnMut(Sent)) {
        let at_ns = self.now_ns;
        let sensed = self.plants.iter().map(AxisPlant::sensed);
        for ((axis, sensed), command) in self.drives.iter_mut().zip(sensed).zip(&mut self.commands)
        {
            *command = axis.drive.torque_command(at_ns, sensed);
        }
        self.mechanics
            .step(&mut self.plants, &self.commands, self.substep_s);
        let axes = self.drives.iter_mut().zip(&self.plants);
        let angles = self.motor_rad.iter_mut().zip(&mut self.links_rad);
        for (axis, ((on_bus, plant), (motor_rad, links_rad))) in axes.zip(angles).enumerate() {
            *motor_rad = plant.angle_rad();
            *links_rad = self.mechanics.links_rad(axis).unwrap_or(*motor_rad);
            if plant.is_hot() != on_bus.hot {
                on_bus.heed(plant.is_hot());
            }
        }
        for (axis, OnBus { bus, drive, .. }) in self.drives.iter_mut().enumerate() {
            drive.poll(at_ns, &mut sends(at_ns, *bus, Sender::Drive(axis), out));
        }
        if let Some(node) = &mut self.force
            && at_ns % force_sensor::PERIOD_NS < self.substep_ns
            && let Some(wrist) = self.mechanics.wrist(&self.plants)
        {
            let bus = node.bus();
            for frame in node.publish(&wrist).into_iter().flatten() {
                let from = Sender::ForceSensor;
                out(Sent {
                    at_ns,
                    bus,
                    from,
                    frame,
                });
            }
        }
    }

    /// Takes a frame from drive bus `bus`, after running up to `now_ns`; every drive there hears it.
    pub fn on_frame(&mut self, bus: u8, now_ns: u64, frame: &Frame, out: &mut impl FnMut(Sent)) {
        self.deliver(bus, now_ns, frame, &|_| true, out);
    }

    /// Takes a frame from drive bus `bus`, after running up to `now_ns`; the drives there hear it whose axis `hears`.
    pub fn deliver(
        &mut self,
        bus: u8,
        now_ns: u64,
        frame: &Frame,
        hears: &impl Fn(usize) -> bool,
        out: &mut impl FnMut(Sent),
    ) {
        self.advance(now_ns, out);
        for (axis, on_bus) in self.drives.iter_mut().enumerate() {
            if on_bus.bus == bus && hears(axis) {
                let mut send = sends(now_ns, bus, Sender::Drive(axis), out);
                on_bus.drive.on_frame(now_ns, frame, &mut send);
            }
        }
    }

    /// The CAN controller of an axis' drive is in this state at `now_ns`. `true`: the drive tells it to recover.
    pub fn on_bus_state(
        &mut self,
        axis: usize,
        now_ns: u64,
        state: State,
        out: &mut impl FnMut(Sent),
    ) -> bool {
        let Some(OnBus { bus, drive, .. }) = self.drives.get_mut(axis) else {
            return false;
        };
        let mut send = sends(now_ns, *bus, Sender::Drive(axis), out);
        drive.on_bus_state(now_ns, state, &mut send)
    }
}

/// Takes the frames of one sender.
fn sends(at_ns: u64, bus: u8, from: Sender, out: &mut impl FnMut(Sent)) -> impl FnMut(Frame) {
    move |frame| {
        out(Sent {
            at_ns,
            bus,
            from,
            frame,
        });
    }
}

#[cfg(test)]
mod tests;
