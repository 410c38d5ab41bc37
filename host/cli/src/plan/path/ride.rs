//! A path as the robot's node runs it, step by step, without the node.

use firmware::capacity::PATH_SAMPLES;
use firmware::ecp::Demand;
use firmware::ecp::tool_motion::{PathSpeeds, ToolMotion};
use firmware::ecp::tool_path::ToolPath;
use firmware::edp::EdpSetup;
use host::error::refusal_text;
use host::path::Streamed;
use host::task::PathStep;
use host::task::cell::DEFAULT_VELOCITY_FACTOR;
use motion::path::PathPoint;
use motion::profile::State;
use robots::{JointMotion, Joints, Motors, Robot};

/// Macrostep of the robots there are, s.
pub(super) const MACROSTEP_S: f64 = 0.02;
/// The longest ride, macrosteps: five hours and a half.
const MOST_STEPS: u32 = 1_000_000;
/// The longest rest on the way, macrosteps: many times what it takes to fill the window of samples.
const LONGEST_REST: u32 = 250;

/// What is asked for, and what the node makes of it.
#[derive(Debug)]
pub(super) struct Ride {
    /// Joints at the beginning, rad or m.
    pub(super) from: Vec<f64>,
    pub(super) streamed: Streamed,
    /// At the end of every macrostep; the first is the beginning, at rest.
    pub(super) moments: Vec<Moment>,
    /// Loads of every joint.
    pub(super) joints: Vec<Load>,
}

/// The tool at the end of a macrostep.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moment {
    pub(super) t_s: f64,
    /// The path's parameter: m, see [`motion::path::METRES_PER_RADIAN`].
    pub(super) s_m: f64,
    /// Speed of the tool's origin.
    pub(super) v_m_s: f64,
    /// Its acceleration along the path.
    pub(super) a_m_s2: f64,
    /// Curvature of its way, 1/m.
    pub(super) curvature_1_m: f64,
}

/// Shares of a joint's limits, one per moment; 1 is the limit.
#[derive(Debug)]
pub(super) struct Load {
    pub(super) name: &'static str,
    pub(super) velocity: Vec<f64>,
    pub(super) acceleration: Vec<f64>,
}

/// Runs a path of a robot from `from`, or from where homing ends.
///
/// # Errors
/// What does not fit the robot, or why its node would refuse the path: one line.
pub(super) fn ride<R: Robot<N> + Copy, const N: usize>(
    robot: R,
    step: &PathStep,
    from: Option<Joints<N>>,
) -> Result<Ride, String> {
    let from = match from {
        Some(joints) => robot.motors(&joints).map(|_| joints),
        None => robot.joints(&Motors([0.0; N])),
    }
    .map_err(|error| format!("where the path begins: {error}"))?;
    let speeds = &step.speeds;
    let motion = ToolMotion {
        robot,
        t_flange_tool: robot.description().default_tool(),
        joint_limits: EdpSetup::<N>::generator_limits(&robot, DEFAULT_VELOCITY_FACTOR)
            .joints_anywhere,
        speeds: PathSpeeds {
            velocity_m_s: speeds.velocity_m_s.into(),
            angular_velocity_rad_s: speeds.angular_velocity_rad_s.into(),
            acceleration_m_s2: speeds.acceleration_m_s2.into(),
            angular_acceleration_rad_s2: speeds.angular_acceleration_rad_s2.into(),
        },
        macrostep_s: MACROSTEP_S,
    };
    let start = robot.forward(&from) * motion.t_flange_tool;
    let streamed = step.path.from(&start, step.reference).map_err(|fault| {
        let point = fault.mark + 1;
        format!("point {point} of the path: {fault}")
    })?;
    let names = robot.description().axes.each_ref().map(|axis| axis.name);
    let joints = names.map(|name| Load {
        name,
        velocity: Vec::new(),
        acceleration: Vec::new(),
    });
    let mut ride = Ride {
        from: from.0.into(),
        streamed,
        moments: Vec::new(),
        joints: joints.into(),
    };
    ride.run(&motion, &from)?;
    Ok(ride)
}

impl Ride {
    /// Every element is there as soon as the node has room for it.
    fn run<R: Robot<N>, const N: usize>(
        &mut self,
        motion: &ToolMotion<R, N>,
        from: &Joints<N>,
    ) -> Result<(), String> {
        let mut path = ToolPath::<N, PATH_SAMPLES>::new();
        path.begin(motion, from).map_err(|r| refusal_text(&r))?;
        let all = self.streamed.elements.clone();
        let mut elements = (0..).zip(all.iter());
        self.note(
            motion,
            &State::default(),
            &JointMotion {
                position: *from,
                velocity: [0.0; N],
                acceleration: [0.0; N],
            },
        );
        let (mut rest, mut last) = (0, 0.0);
        for _ in 0..MOST_STEPS {
            for (number, element) in elements.by_ref().take(path.room()) {
                path.take(number, element);
            }
            match path.step(motion, 1.0) {
                Demand::Joints(joints) | Demand::JointsTwice([_, joints]) => {
                    self.note(motion, path.along(), &joints);
                }
                Demand::Refuse(refusal) => {
                    let why = refusal_text(&refusal);
                    return Err(format!("{}: {why}", self.place(path.along().p)));
                }
                // the first samples are taken
                _ => {}
            }
            let s = path.along().p;
            rest = if s > last { 0 } else { rest + 1 };
            last = s;
            if path.done() {
                return Ok(());
            }
            if rest > LONGEST_REST {
                return Err(format!("{}: it does not go on", self.place(s)));
            }
        }
        let longest = f64::from(MOST_STEPS) * MACROSTEP_S;
        Err(format!("the path takes more than {longest:.0} s"))
    }

    fn place(&self, s: f64) -> String {
        let element = self.streamed.course.element(s);
        let point = self.streamed.marks.get(element).map_or(0, |mark| mark + 1);
        format!("the tool stops {s:.4} m along the path, on the way to point {point}")
    }

    fn note<R: Robot<N>, const N: usize>(
        &mut self,
        motion: &ToolMotion<R, N>,
        along: &State,
        joints: &JointMotion<N>,
    ) {
        let steps = u32::try_from(self.moments.len()).unwrap_or(u32::MAX);
        let t_s = f64::from(steps) * MACROSTEP_S;
        if let Some(point) = self.streamed.course.at(along.p) {
            self.moments.push(moment(t_s, along, &point));
            let rates = joints.velocity.iter().zip(&joints.acceleration);
            let limits = motion.joint_limits.iter();
            for ((load, (v, a)), limit) in self.joints.iter_mut().zip(rates).zip(limits) {
                load.velocity.push(v.abs() / limit.v);
                load.acceleration.push(a.abs() / limit.a);
            }
        }
    }
}

/// With p(s): the speed is |p'|·ṡ, its derivative |p'|·s̈ + (p'·p''/|p'|)·ṡ².
fn moment(t_s: f64, along: &State, point: &PathPoint) -> Moment {
    let (first, second) = (&point.first.linear, &point.second.linear);
    let norm = point.first.linear_norm();
    let stretch = if norm > 0.0 {
        first.dot(second) / norm
    } else {
        0.0
    };
    Moment {
        t_s,
        s_m: along.p,
        v_m_s: norm * along.v,
        a_m_s2: norm * along.a + stretch * along.v * along.v,
        curvature_1_m: point.curvature(),
    }
}
