//! What a run tells while it runs.

use crate::mp::event::Event;
use crate::path::Streamed;
use crate::task::Tight;
use motion::Pose;
use protocol::units::PerAxis;
use std::sync::Arc;

/// Something worth a line. Steps and nodes count from 1, robots are indices in the cell.
#[derive(Clone, Debug, PartialEq)]
pub enum Progress {
    /// Something happened to a robot.
    Robot(Event),
    /// Every node is known, leased and under torque.
    Ready,
    /// A step of the task begins.
    StepBegan {
        /// Which.
        step: usize,
        /// Of how many.
        of: usize,
        /// Its name.
        name: String,
    },
    /// A robot was sent to its next node.
    Node {
        /// In which step.
        step: usize,
        /// Which robot.
        robot: usize,
        /// Which node.
        node: usize,
        /// Of how many.
        of: usize,
    },
    /// A robot has come so far on its path.
    Path {
        /// Which robot.
        robot: usize,
        /// Tenths of the length that are behind it.
        tenths: u32,
        /// The length, m.
        length_m: f64,
    },
    /// A step has ended as it should.
    StepEnded {
        /// Which.
        step: usize,
    },
    /// The robots are at rest.
    AtRest,
    /// The leases are given back.
    Released,
}

/// What a robot is executing: the way its set-points must lie on, for an independent observer.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Segment {
    /// Nothing, or nothing with a known way.
    #[default]
    None,
    /// Homing: axes move one by one to their switches.
    Homing,
    /// Straight in motor space, rad.
    Motors {
        /// From.
        from: PerAxis<f64>,
        /// To.
        to: PerAxis<f64>,
    },
    /// Straight in joint space, rad or m.
    Joints {
        /// From.
        from: PerAxis<f64>,
        /// To.
        to: PerAxis<f64>,
    },
    /// A straight line of the tool, its orientation on the shortest arc: `t_base_tool`.
    Line {
        /// From.
        from: Pose,
        /// To.
        to: Pose,
    },
    /// A path that is streamed: `t_base_tool` is on its course.
    Path(Followed),
    /// Carried: at the share s of the way the tool is at `tight.displacement(s) * start` in the
    /// world.
    Carry {
        /// `t_world_tool` at the beginning.
        start: Pose,
        /// The way of the object.
        tight: Tight,
    },
}

/// A path that a robot follows. Two are equal if they are the same one: segments are compared in
/// every macrostep, and paths are long.
#[derive(Clone, Debug)]
pub struct Followed(pub Arc<Streamed>);

impl PartialEq for Followed {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}
