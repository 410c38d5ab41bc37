//! How the motors of one robot move together.

use super::axis::{AxisPlant, Drive};
use robots::dynamics::Body;

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
