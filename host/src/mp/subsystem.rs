//! The Master Process as the formalism sees it: `C_0` with the images of all effectors and its
//! bundle of virtual sensors.

use super::command::Commands;
use super::robot::Image;
use super::sensor::Sensors;
use agent::{Subsystem, args};

/// `C_0`. Its state evolves as \[Z1\] (10): by its own state, by what each `C_j` tells of itself and
/// of its effector (the [`Image`]s), and by `v_0`, the bundle of [`Sensors`].
#[derive(Clone, Copy, Debug)]
pub enum MpSubsystem {}

impl Subsystem for MpSubsystem {
    type Level = args::Coordinator;
    /// Nobody coordinates the coordinator.
    type Coordination = ();
    /// `e_c`: the list of images, one per robot, in the order of the configuration.
    type Effector = Vec<Image>;
    type Sensors = Sensors;
    type Transmissions = ();
    type Command = Commands;
}

/// What a behaviour of the Master Process is, behind a pointer.
pub type BoxedBehaviour = Box<dyn agent::Behaviour<MpSubsystem> + Send>;
