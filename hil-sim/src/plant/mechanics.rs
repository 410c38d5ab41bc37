//! How the motors of one robot move together.

use motion::Pose;
use nalgebra::Vector3;
use robots::dynamics::Body;

use super::axis::{AxisPlant, Drive};
use super::contact::{Obstacle, Tip};
use super::gear::{Gear, GearError};

/// What there is to know of a robot's wrist.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wrist {
    /// The flange in the base frame.
    pub flange: Pose,
    /// Acceleration of free fall in the base frame, m/s².
    pub gravity: Vector3<f64>,
    /// The force on the tool's tip, N, and where it acts, m, both in the base frame; none where it touches nothing.
    pub touch: Option<(Vector3<f64>, Vector3<f64>)>,
}

/// The mechanics behind the motors of a robot.
pub trait Mechanics: Send {
    /// How many axes it moves; none where any number will do.
    fn axes(&self) -> Option<usize>;

    /// One substep of `dt_s` seconds: every plant moves under its drive's command.
    fn step(&mut self, plants: &mut [AxisPlant], commands: &[Drive], dt_s: f64);

    /// Fixes a body, in the flange's frame, to the flange instead of what was there; `false` where there
    /// is no flange to carry it.
    fn carry(&mut self, body: Option<&Body>) -> bool {
        let _ = body;
        false
    }

    /// Puts a gear that gives between a motor and its links, or takes it out again.
    ///
    /// # Errors
    /// [`GearError`].
    fn set_gear(&mut self, axis: usize, gear: Option<Gear>) -> Result<(), GearError> {
        let _ = (axis, gear);
        Err(GearError::Axis)
    }

    /// The motor angle that belongs to where the links of an axis are, rad, where its gear gives.
    fn links_rad(&self, axis: usize) -> Option<f64> {
        let _ = axis;
        None
    }

    /// Puts bodies around the robot and a tip on its tool, instead of what was there; `false` where there is no
    /// flange to carry it.
    fn surround(&mut self, obstacles: Vec<Obstacle>, tip: Tip) -> bool {
        let _ = (obstacles, tip);
        false
    }

    /// The wrist after the last substep; none where there is none.
    fn wrist(&self, plants: &[AxisPlant]) -> Option<Wrist> {
        let _ = plants;
        None
    }
}

/// Every motor with a load of its own, and no weight: belts and grippers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Apart;

impl Mechanics for Apart {
    fn axes(&self) -> Option<usize> {
        None
    }

    fn step(&mut self, plants: &mut [AxisPlant], commands: &[Drive], _dt_s: f64) {
        for (plant, command) in plants.iter_mut().zip(commands) {
            plant.step(*command, 0.0);
        }
    }
}
