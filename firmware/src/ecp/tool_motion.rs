//! An arm that carries a tool along a path: what a point of the path is in joints.

use crate::ecp::refusal;
use motion::Pose;
use motion::feed::{FeedLimits, NormLimits, Sample, ToolSample};
use motion::path::{METRES_PER_RADIAN, PathPoint};
use motion::profile::{AxisLimits, State};
use nalgebra::Vector3;
use protocol::fault::Refusal;
use robots::{JointMotion, Joints, JointsAlong, PoseAlong, Robot};

/// Greatest step of the difference quotients, m: of q''' the error is δ² times the fifth derivative, and rounding
/// (1e-16/δ³) a part in 1e5 of what a millimetre's radius makes of it.
const DELTA: f64 = 2.5e-4;
/// Over a step the direction of the path changes by no more than this, rad, so that where it bends sharply the
/// quotients are still of the path and not of its continuation far beyond.
const BEND: f64 = 0.1;
/// Greatest and least distance of samples, m.
const COARSEST: f64 = 1.5e-3;
const FINEST: f64 = 2e-4;
/// The motion is smoothed over this times acceleration by jerk: see [`motion::feed`].
const SMOOTHING: f64 = 2.0 / 0.65;
/// Farther apart, rad or m, the joints where a path begins are not those where the robot is.
const BESIDE: f64 = 1e-4;
/// Share of the samples that lies ahead of the tool, and must hold the way to a stop.
const AHEAD: f64 = 0.7;

/// What is asked for along a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathSpeeds {
    /// m/s
    pub velocity_m_s: f64,
    /// rad/s
    pub angular_velocity_rad_s: f64,
    /// m/s²
    pub acceleration_m_s2: f64,
    /// rad/s²
    pub angular_acceleration_rad_s2: f64,
}

/// An arm with its tool, and how it may move along a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolMotion<R, const N: usize> {
    /// The robot's kinematics.
    pub robot: R,
    /// The tool in the flange frame.
    pub t_flange_tool: Pose,
    /// What every joint can bear.
    pub joint_limits: [AxisLimits; N],
    /// What is asked for along the path.
    pub speeds: PathSpeeds,
    /// Macrostep, s.
    pub macrostep_s: f64,
}

/// q and its derivatives by s.
struct Local<const N: usize> {
    q: Joints<N>,
    first: [f64; N],
    second: [f64; N],
    third: [f64; N],
}

impl<R: Robot<N>, const N: usize> ToolMotion<R, N> {
    /// Where the tool is at the beginning of a path: `t_base_tool`.
    ///
    /// # Errors
    /// [`Refusal::OutOfRange`] if the robot's rule for its redundancy has it elsewhere than it stands: a path
    /// cannot begin with a jump.
    pub(super) fn begin(&self, from: &Joints<N>) -> Result<Pose, Refusal> {
        let pose = self.robot.forward(from) * self.t_flange_tool;
        if let Ok(begin) = self.joints(&pose, from) {
            beside(&begin, from)?;
        }
        Ok(pose)
    }

    /// What joints and tool can bear. The jerk of the tool is limited such that it is smoothed as long as the
    /// joints are.
    pub(super) fn feed_limits(&self) -> FeedLimits<N> {
        let jerk = SMOOTHING / self.smoothing();
        let norm = |v: f64, a: f64| NormLimits {
            v: Some(v),
            a: Some(a),
            j: Some(jerk * a),
        };
        let speeds = &self.speeds;
        FeedLimits {
            joints: self.joint_limits,
            linear: norm(speeds.velocity_m_s, speeds.acceleration_m_s2),
            angular: norm(
                speeds.angular_velocity_rad_s,
                speeds.angular_acceleration_rad_s2,
            ),
        }
    }

    /// The joints at a point, where the feed moves as `along` says.
    pub(super) fn knot(
        &self,
        point: &PathPoint,
        near: &Joints<N>,
        along: &State,
    ) -> Result<JointMotion<N>, Refusal> {
        let local = self.local(point, near)?;
        let (v, a) = (along.v, along.a);
        let (mut velocity, mut acceleration) = ([0.0; N], [0.0; N]);
        let out = velocity.iter_mut().zip(&mut acceleration);
        for ((qv, qa), (first, second)) in out.zip(local.first.iter().zip(&local.second)) {
            *qv = first * v;
            *qa = second * v * v + first * a;
        }
        Ok(JointMotion {
            position: local.q,
            velocity,
            acceleration,
        })
    }

    fn joints(&self, t_base_tool: &Pose, near: &Joints<N>) -> Result<Joints<N>, Refusal> {
        let t_base_flange = *t_base_tool * self.t_flange_tool.inverse();
        self.robot
            .inverse_near(&t_base_flange, near)
            .map_err(|e| refusal::from_kinematics(&e))
    }

    /// q and its derivatives: those that the robot knows, else differences.
    fn local(&self, point: &PathPoint, near: &Joints<N>) -> Result<Local<N>, Refusal> {
        let flange = PoseAlong::of_flange(point, &self.t_flange_tool.inverse());
        let JointsAlong { position, rates } = self
            .robot
            .inverse_along(&flange, near)
            .map_err(|e| refusal::from_kinematics(&e))?;
        match rates {
            Some(rates) => {
                let [first, second, third] = rates.map(|row| row.map(f64::from));
                Ok(Local {
                    q: position,
                    first,
                    second,
                    third,
                })
            }
            None => self.differences(point, position),
        }
    }

    /// Central differences of the fourth order for q' and q'', of the second for q'''.
    // a frame of its own: a robot that knows its derivatives seldom needs it
    #[inline(never)]
    fn differences(&self, point: &PathPoint, q: Joints<N>) -> Result<Local<N>, Refusal> {
        let delta = step(point);
        let at = |steps: f64| self.joints(&point.continued(steps * delta), &q);
        let (b2, b1, a1, a2) = (at(-2.0)?, at(-1.0)?, at(1.0)?, at(2.0)?);
        let mut local = Local {
            q,
            first: [0.0; N],
            second: [0.0; N],
            third: [0.0; N],
        };
        let outer = b2.0.iter().zip(&a2.0);
        let inner = b1.0.iter().zip(&a1.0);
        let out = local
            .first
            .iter_mut()
            .zip(&mut local.second)
            .zip(&mut local.third);
        for ((((first, second), third), q), ((b2, a2), (b1, a1))) in
            out.zip(&q.0).zip(outer.zip(inner))
        {
            *first = (8.0 * (a1 - b1) - (a2 - b2)) / (12.0 * delta);
            *second = (16.0 * (a1 + b1) - (a2 + b2) - 30.0 * q) / (12.0 * delta * delta);
            *third = ((a2 - b2) - 2.0 * (a1 - b1)) / (2.0 * delta * delta * delta);
        }
        Ok(local)
    }

    pub(super) fn sample(
        &self,
        point: &PathPoint,
        feed: f64,
        near: &mut Joints<N>,
    ) -> Result<Sample<N>, Refusal> {
        let local = self.local(point, near)?;
        *near = local.q;
        let rows = |a: &Vector3<f64>, b: &Vector3<f64>, c: &Vector3<f64>| {
            [(*a).into(), (*b).into(), (*c).into()]
        };
        let PathPoint {
            first,
            second,
            third,
            ..
        } = point;
        Ok(Sample {
            first: local.first,
            second: local.second,
            third: local.third,
            tool: ToolSample {
                linear: rows(&first.linear, &second.linear, &third.linear),
                angular: rows(&first.angular, &second.angular, &third.angular),
            },
            feed,
        })
    }

    /// Over how long a motion is smoothed, s.
    fn smoothing(&self) -> f64 {
        self.joint_limits.iter().fold(0.0, |longest, joint| {
            let tau = SMOOTHING * joint.a / joint.j;
            if tau > longest { tau } else { longest }
        })
    }

    /// Samples as far apart as it takes for the window of W to hold the way to a stop from the speed asked for, and
    /// for a quarter of it to hold what one step must look at: the way during the smoothing and two macrosteps.
    pub(super) fn grid<const W: usize>(&self) -> f64 {
        let (v, a) = (self.speeds.velocity_m_s, self.speeds.acceleration_m_s2);
        let step = v * (self.smoothing() + 3.0 * self.macrostep_s);
        let stop = 0.5 * v * v / a + step;
        #[expect(clippy::cast_precision_loss, reason = "some hundred samples")]
        let window = W as f64;
        let (ahead, quarter) = (2.0 * stop / (AHEAD * window), 4.0 * step / window);
        let grid = if ahead > quarter { ahead } else { quarter };
        if grid > COARSEST {
            COARSEST
        } else if grid > FINEST {
            grid
        } else {
            FINEST
        }
    }
}

/// How sharply the path bends, 1/m: its curvature, and that of its turning.
pub(super) fn bend(point: &PathPoint) -> f64 {
    point.second.linear.norm() + METRES_PER_RADIAN * point.second.angular.norm()
}

/// The step of the difference quotients, m.
fn step(point: &PathPoint) -> f64 {
    let third = point.third.linear.norm() + METRES_PER_RADIAN * point.third.angular.norm();
    let by = |limit: f64, at_most: f64| if limit < at_most { limit } else { at_most };
    // a division by zero is infinity, which limits nothing
    by(BEND / bend(point), by(libm::sqrt(BEND / third), DELTA))
}

/// Are these the same joints?
#[expect(clippy::cast_possible_truncation, reason = "a report")]
fn beside<const N: usize>(begin: &Joints<N>, here: &Joints<N>) -> Result<(), Refusal> {
    for (axis, (begin, here)) in (0..N).zip(begin.0.iter().zip(&here.0)) {
        if libm::fabs(begin - here) > BESIDE {
            return Err(Refusal::OutOfRange {
                index: u8::try_from(axis).unwrap_or(u8::MAX),
                value: *here as f32,
                lower: (begin - BESIDE) as f32,
                upper: (begin + BESIDE) as f32,
            });
        }
    }
    Ok(())
}
