//! `v_0`: the coordinator's bundle of virtual sensors (\[Z1\] (8), (13)).
//!
//! Both shipped ones have the robots' own encoders as receptors: [`ToolPose`] aggregates motor
//! angles into a pose, [`Distance`] two poses into a length. They are as old as the feedback they
//! are made of, and stale with it.

use super::arm::Arm;
use super::robot::Image;
use agent::{Reading, VirtualSensor, Vsp};
use motion::Pose;
use protocol::units::PerAxis;

/// `t_world_tool` of a robot, from its measured motor angles.
#[derive(Clone, Copy, Debug)]
pub struct ToolPose {
    /// The robot's geometry.
    pub arm: &'static dyn Arm,
}

/// Where a robot stands and what it holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mounting {
    /// Its base in the world.
    pub t_world_base: Pose,
    /// Its tool in the flange frame.
    pub t_flange_tool: Pose,
}

impl VirtualSensor for ToolPose {
    type Configuration = Mounting;
    type Effector = ();
    type Receptors = PerAxis<f64>;
    type Own = ();
    type Reading = Pose;

    fn aggregate(&self, (): &mut (), c: &Mounting, (): &(), r: &PerAxis<f64>) -> Option<Pose> {
        let joints = self.arm.joints(r).ok()?;
        let flange = self.arm.forward(&joints).ok()?;
        Some(c.t_world_base * flange * c.t_flange_tool)
    }
}

/// The distance between the origins of two tools, m.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Distance;

impl VirtualSensor for Distance {
    type Configuration = ();
    type Effector = ();
    type Receptors = (Pose, Pose);
    type Own = ();
    type Reading = f64;

    fn aggregate(&self, (): &mut (), (): &(), (): &(), r: &(Pose, Pose)) -> Option<f64> {
        let way = r.1.position - r.0.position;
        Some(libm::sqrt(way.dot(&way)))
    }
}

/// The images of the bundle.
#[derive(Clone, Debug)]
pub struct Sensors {
    poses: Vec<agent::Image<Pose>>,
    distances: Vec<((usize, usize), agent::Image<f64>)>,
    i: u32,
}

impl Sensors {
    /// Nothing read yet; readings last `lifetime` macrosteps. A distance for every pair of robots.
    #[must_use]
    pub fn new(robots: usize, lifetime: u32) -> Self {
        let pairs = (0..robots).flat_map(|a| (a + 1..robots).map(move |b| (a, b)));
        Self {
            poses: vec![agent::Image::lasting(lifetime); robots],
            distances: pairs
                .map(|pair| (pair, agent::Image::lasting(lifetime)))
                .collect(),
            i: 0,
        }
    }

    /// `t_world_tool` of a robot; absent before it is homed.
    #[must_use]
    pub fn tool_pose(&self, robot: usize) -> Reading<Pose> {
        match self.poses.get(robot) {
            Some(image) => image.at(self.i).map(|pose| *pose),
            None => Reading::Absent,
        }
    }

    /// The distance between the tools of two robots, m.
    #[must_use]
    pub fn distance(&self, a: usize, b: usize) -> Reading<f64> {
        let pair = if a < b { (a, b) } else { (b, a) };
        match self.distances.iter().find(|(p, _)| *p == pair) {
            Some((_, image)) => image.at(self.i).map(|distance| *distance),
            None => Reading::Absent,
        }
    }

    pub(super) const fn set_instant(&mut self, i: u32) {
        self.i = i;
    }
}

/// The processes behind the bundle: one per virtual sensor.
#[derive(Debug)]
pub(super) struct Bundle {
    poses: Vec<Vsp<ToolPose>>,
    distance: Vsp<Distance>,
}

impl Bundle {
    pub(super) fn new(robots: &[Image]) -> Self {
        let pose = |image: &Image| {
            let config = image.config();
            Vsp::new(
                ToolPose { arm: config.arm },
                Mounting {
                    t_world_base: config.t_world_base,
                    t_flange_tool: config.t_flange_tool,
                },
            )
        };
        Self {
            poses: robots.iter().map(pose).collect(),
            distance: Vsp::new(Distance, ()),
        }
    }

    /// Reads every sensor whose receptors are fresh, at the instant `i`.
    pub(super) fn read(&mut self, i: u32, robots: &[Image], sensors: &mut Sensors) {
        sensors.i = i;
        let each = robots.iter().zip(&mut self.poses).zip(&mut sensors.poses);
        for ((image, vsp), reading) in each {
            // before homing, motor angles count from anywhere
            if !image.is_homed() {
                continue;
            }
            let age = image.feedback().age().unwrap_or(0);
            if let Some(pose) = image
                .actual_motors()
                .and_then(|motors| vsp.step(&(), &motors))
            {
                reading.receive(i.saturating_sub(age), pose);
            }
        }
        for ((a, b), reading) in &mut sensors.distances {
            let pose = |robot: usize| match sensors.poses.get(robot)?.at(i) {
                Reading::Fresh { value, age } => Some((*value, age)),
                Reading::Stale { .. } | Reading::Absent => None,
            };
            if let (Some((pa, age_a)), Some((pb, age_b))) = (pose(*a), pose(*b))
                && let Some(distance) = self.distance.step(&(), &(pa, pb))
            {
                reading.receive(i.saturating_sub(age_a.max(age_b)), distance);
            }
        }
    }
}
