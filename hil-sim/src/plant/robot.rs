//! The drives and plants of one robot on its drive buses.

use protocol::canopen::node::NodeId;
use protocol::frame::Frame;

use super::axis::{AxisPlant, Broken};
use super::gravity::GravityModel;
use super::parameters::{AxisSetup, RobotSetup};
use super::random::SplitMix64;
use crate::drive::{DriveFault, SimDrive};

/// The substep of drives and plants: 0.25 ms.
pub const SUBSTEP_NS: u64 = 250_000;
/// The weight is computed anew every so many substeps: every 2 ms with the default substep.
const GRAVITY_SUBSTEPS: u32 = 8;

/// A frame a drive sends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sent {
    /// When, ns.
    pub at_ns: u64,
    /// On which of the robot's drive buses, from 0.
    pub bus: u8,
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
}

struct Axis {
    bus: u8,
    drive: SimDrive,
    plant: AxisPlant,
}

/// One robot: its drives, motors and weight.
pub struct SimRobot {
    axes: Vec<Axis>,
    gravity: Box<dyn GravityModel + Send>,
    motor_rad: Vec<f64>,
    load_nm: Vec<f64>,
    substep_ns: u64,
    now_ns: u64,
    to_gravity: u32,
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
        let mut axes: Vec<Axis> = Vec::with_capacity(setup.axes.len());
        for (number, axis) in setup.axes.iter().enumerate() {
            let AxisSetup { bus, node, .. } = *axis;
            let id = NodeId::new(node).ok_or(SetupError::Node { axis: number, node })?;
            if axes
                .iter()
                .any(|other| other.bus == bus && other.drive.node() == id)
            {
                return Err(SetupError::Double { bus, node });
            }
            let random = SplitMix64::stream(seed, "home switch bounce", u64::from(node));
            axes.push(Axis {
                bus,
                drive: SimDrive::new(id, axis.drive, 0, dt_s),
                plant: AxisPlant::new(axis.plant, axis.start_rad, dt_s, random),
            });
        }
        let motor_rad = axes.iter().map(|axis| axis.plant.angle_rad()).collect();
        let load_nm = vec![0.0; axes.len()];
        let gravity = setup.gravity;
        Ok(Self {
            axes,
            gravity,
            motor_rad,
            load_nm,
            substep_ns,
            now_ns: 0,
            to_gravity: 0,
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
        self.axes.get(axis).map(|axis| &axis.drive)
    }

    /// The plant of an axis.
    #[must_use]
    pub fn plant(&self, axis: usize) -> Option<&AxisPlant> {
        self.axes.get(axis).map(|axis| &axis.plant)
    }

    /// The levels of the tool's outputs: those of the last axis' drive.
    #[must_use]
    pub fn outputs(&self) -> u16 {
        self.axes.last().map_or(0, |axis| axis.drive.outputs())
    }

    /// Puts a fault into an axis, or takes its faults out. `false` if there is no such axis.
    pub fn inject(&mut self, axis: usize, fault: Option<DriveFault>) -> bool {
        let Some(axis) = self.axes.get_mut(axis) else {
            return false;
        };
        let mut broken = Broken::default();
        match fault {
            Some(DriveFault::EncoderStuck) => broken.encoder = true,
            Some(DriveFault::SwitchStuck(level)) => broken.switch = Some(level),
            Some(DriveFault::IndexMissing) => broken.index = true,
            Some(DriveFault::Trip(_) | DriveFault::Silent) | None => {}
        }
        axis.plant.set_broken(broken);
        axis.drive.set_fault(fault);
        true
    }

    /// Runs drives and plants up to `now_ns`; `out` gets what the drives send, in order of time.
    pub fn advance(&mut self, now_ns: u64, out: &mut impl FnMut(Sent)) {
        while self.now_ns + self.substep_ns <= now_ns {
            if self.to_gravity == 0 {
                self.to_gravity = GRAVITY_SUBSTEPS;
                self.gravity
                    .load_torque_nm(&self.motor_rad, &mut self.load_nm);
            }
            self.to_gravity -= 1;
            self.now_ns += self.substep_ns;
            self.substep(out);
        }
    }

    #[inline]
    fn substep(&mut self, out: &mut impl FnMut(Sent)) {
        let at_ns = self.now_ns;
        let others = self.load_nm.iter().zip(&mut self.motor_rad);
        for (axis, (load_nm, motor_rad)) in self.axes.iter_mut().zip(others) {
            let command = axis.drive.torque_command(at_ns, axis.plant.sensed());
            axis.plant.step(command, *load_nm);
            *motor_rad = axis.plant.angle_rad();
            let bus = axis.bus;
            axis.drive
                .poll(at_ns, &mut |frame| out(Sent { at_ns, bus, frame }));
        }
    }

    /// Takes a frame from drive bus `bus`, after running up to `now_ns`.
    pub fn on_frame(&mut self, bus: u8, now_ns: u64, frame: &Frame, out: &mut impl FnMut(Sent)) {
        self.advance(now_ns, out);
        for axis in &mut self.axes {
            if axis.bus == bus {
                let mut send = |frame| {
                    out(Sent {
                        at_ns: now_ns,
                        bus,
                        frame,
                    });
                };
                axis.drive.on_frame(now_ns, frame, &mut send);
            }
        }
    }
}

#[cfg(test)]
mod tests;
