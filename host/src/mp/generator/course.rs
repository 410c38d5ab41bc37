//! The way of an object that several robots hold, and of their joints with it.

use crate::mp::arm::{Arm, AxisMotion};
use crate::mp::config::{Grid, RobotConfig};
use crate::mp::failure::{Failure, Who};
use crate::task::Tight;
use motion::Pose;
use motion::profile::{AxisLimits, Profile};
use protocol::units::PerAxis;
use robots::{AxisDescription, KinematicError, VelocityFactor};

/// The shape of a carry in time: shares of its duration T that the acceleration takes to build up,
/// and that it lasts. With the distance 1: v = 1/(T − accelerating − building), a = v/accelerating,
/// j = a/building.
pub const REST_SHAPE: (f64, f64) = (0.125, 0.25);

/// Step of the differences along the way, as a share of it. Fourth-order differences of a function
/// of order 1 are off by h⁴ ≈ 2·10⁻¹¹, and by rounding 10⁻¹⁶/h² ≈ 3·10⁻¹¹.
const H: f64 = 2e-3;

/// A robot that takes part.
#[derive(Clone, Debug)]
pub struct Carried {
    /// Its index.
    pub robot: usize,
    /// For messages.
    pub who: Who,
    arm: &'static dyn Arm,
    velocity_factor: VelocityFactor,
    t_base_world: Pose,
    t_tool_flange: Pose,
    /// `t_world_tool` at the beginning.
    start: Pose,
    joints: PerAxis<f64>,
}

impl Carried {
    /// A robot at rest in a joint position.
    ///
    /// # Errors
    /// [`KinematicError::NotFinite`] for a wrong number of joints.
    pub fn new(
        robot: usize,
        config: &RobotConfig,
        joints: PerAxis<f64>,
    ) -> Result<Self, KinematicError> {
        let flange = config.arm.forward(&joints)?;
        Ok(Self {
            robot,
            who: Who {
                robot,
                name: config.name.clone(),
                node: config.node,
            },
            arm: config.arm,
            velocity_factor: config.velocity_factor,
            t_base_world: config.t_world_base.inverse(),
            t_tool_flange: config.t_flange_tool.inverse(),
            start: config.t_world_base * flange * config.t_flange_tool,
            joints,
        })
    }

    /// `t_world_tool` at the beginning.
    #[must_use]
    pub const fn start(&self) -> &Pose {
        &self.start
    }

    /// Its joints at the beginning.
    #[must_use]
    pub fn joints(&self) -> &[f64] {
        &self.joints
    }

    /// The joints that hold the object after the share s of the way.
    fn at(&self, tight: &Tight, s: f64, near: &[f64]) -> Result<PerAxis<f64>, KinematicError> {
        let t_world_tool = tight.displacement(s) * self.start;
        let flange = self.t_base_world * t_world_tool * self.t_tool_flange;
        let joints = self.arm.inverse(&flange, near)?;
        // another branch of the inverse is another arm posture, not the next point of the way
        if joints
            .iter()
            .zip(near)
            .any(|(a, b)| (a - b).abs() > BRANCH_RAD)
        {
            return Err(KinematicError::Singular);
        }
        self.arm.check(&joints)?;
        Ok(joints)
    }
}

/// Two neighbouring points of a way are never so far apart; another branch always is. rad or m.
const BRANCH_RAD: f64 = 0.5;

/// A motion of joints with respect to the share s: dq/ds and d²q/ds².
struct Slopes {
    q: PerAxis<f64>,
    first: PerAxis<f64>,
    second: PerAxis<f64>,
}

impl Slopes {
    /// The motion at this ds/dt and d²s/dt², by the chain rule.
    fn motion(&self, velocity: f64, acceleration: f64) -> AxisMotion {
        AxisMotion {
            position: self.q.clone(),
            velocity: self.first.iter().map(|d| d * velocity).collect(),
            acceleration: self
                .first
                .iter()
                .zip(&self.second)
                .map(|(d, dd)| dd * velocity * velocity + d * acceleration)
                .collect(),
        }
    }
}

/// The most points at which a course is checked.
const CHECK_POINTS: f64 = 1000.0;

/// A rate of progress along the way: ds/dt and d²s/dt², and where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Advance {
    /// Share of the way.
    pub s: f64,
    /// 1/s
    pub velocity: f64,
    /// 1/s²
    pub acceleration: f64,
}

/// A carry: the object's way, its timing, and the robots that hold it.
#[derive(Clone, Debug)]
pub struct Course {
    tight: Tight,
    profile: Profile,
    robots: Vec<Carried>,
}

impl Course {
    /// The way of `tight`, begun at rest where the robots are.
    ///
    /// # Errors
    /// [`Failure::Kinematics`] where the timing cannot be represented.
    pub fn new(tight: Tight, robots: Vec<Carried>) -> Result<Self, KinematicError> {
        let (building, accelerating) = REST_SHAPE;
        let t = tight.duration_s;
        let v = 1.0 / (t * (1.0 - building - accelerating));
        let a = v / (t * accelerating);
        let limits = AxisLimits {
            v,
            a,
            j: a / (t * building),
        };
        let profile = Profile::new(1.0, &limits).map_err(|_| KinematicError::NotFinite)?;
        Ok(Self {
            tight,
            profile,
            robots,
        })
    }

    /// The robots.
    #[must_use]
    pub fn robots(&self) -> &[Carried] {
        &self.robots
    }

    /// The way.
    #[must_use]
    pub const fn tight(&self) -> &Tight {
        &self.tight
    }

    /// How long it takes at the planned pace, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.profile.duration()
    }

    /// The progress after `tau` seconds of path time, which passes at `rate` (1 = as planned), and
    /// whose rate changes by `change` per second.
    #[must_use]
    pub fn advance(&self, tau: f64, rate: f64, change: f64) -> Advance {
        let state = self.profile.at(tau);
        Advance {
            s: state.p,
            velocity: state.v * rate,
            acceleration: state.a * rate * rate + state.v * change,
        }
    }

    /// The joint motion of a robot at a point of the way; `near` is where it was before.
    ///
    /// # Errors
    /// No configuration, a singular one, or one outside the limits.
    pub fn joint_motion(
        &self,
        carried: &Carried,
        advance: Advance,
        near: &[f64],
    ) -> Result<AxisMotion, KinematicError> {
        let slopes = self.slopes(carried, advance.s, near)?;
        Ok(slopes.motion(advance.velocity, advance.acceleration))
    }

    /// Fourth-order central differences; the way goes on beyond its ends, so that they are the same
    /// everywhere.
    fn slopes(&self, carried: &Carried, s: f64, near: &[f64]) -> Result<Slopes, KinematicError> {
        let q = carried.at(&self.tight, s, near)?;
        let at = |steps: f64| carried.at(&self.tight, s + steps * H, &q);
        let (m2, m1, p1, p2) = (at(-2.0)?, at(-1.0)?, at(1.0)?, at(2.0)?);
        let mut slopes = Slopes {
            q: q.clone(),
            first: PerAxis::new(),
            second: PerAxis::new(),
        };
        let around = m2.iter().zip(&m1).zip(&q).zip(&p1).zip(&p2);
        for ((((m2, m1), q), p1), p2) in around {
            let first = (8.0 * (p1 - m1) - (p2 - m2)) / (12.0 * H);
            let second = (16.0 * (p1 + m1) - 30.0 * q - (p2 + m2)) / (12.0 * H * H);
            // as many as there are axes
            let _ = slopes.first.push(first);
            let _ = slopes.second.push(second);
        }
        Ok(slopes)
    }

    /// Every instant of the motion at the planned pace, within what joints and motors may do; a
    /// pace that changes by up to `most_change` per second is allowed for. Gives the joints of every
    /// robot at the end.
    ///
    /// # Errors
    /// [`Failure::Kinematics`] or [`Failure::TooFast`] of the first robot that cannot.
    pub fn check(&self, grid: Grid, most_change: f64) -> Result<Vec<PerAxis<f64>>, Failure> {
        let step = grid.macrostep_s();
        // a slow motion needs no closer look than its length asks for
        let stride = libm::ceil(self.duration_s() / (step * CHECK_POINTS));
        let step = step * if stride > 1.0 { stride } else { 1.0 };
        let mut ends = Vec::new();
        for carried in &self.robots {
            let mut near = carried.joints.clone();
            let mut before: Option<AxisMotion> = None;
            let mut k = 0.0;
            while k * step <= self.duration_s() + step {
                let state = self.profile.at(k * step);
                let failed = |error| Failure::Kinematics {
                    who: carried.who.clone(),
                    at: format!("{:.0} % of the way", 100.0 * state.p),
                    error,
                };
                let slopes = self.slopes(carried, state.p, &near).map_err(failed)?;
                let motors = |joints: &AxisMotion| carried.arm.motor_motion(joints).map_err(failed);
                let change = state.v * most_change;
                for acceleration in [state.a + change, state.a - change] {
                    let joints = slopes.motion(state.v, acceleration);
                    carried.bears(&joints, &motors(&joints)?)?;
                }
                let now = motors(&slopes.motion(state.v, state.a))?;
                if let Some(before) = &before {
                    carried.bears_jerk(before, &now, step)?;
                }
                before = Some(now);
                near = slopes.q;
                k += 1.0;
            }
            ends.push(near);
        }
        Ok(ends)
    }
}

/// The greatest value over its ceiling, with the axis, or nothing while all are within.
fn excess(
    values: impl Iterator<Item = f64>,
    ceilings: impl Iterator<Item = f64>,
    axes: &[AxisDescription],
) -> Option<(&AxisDescription, f64)> {
    let mut worst: Option<(&AxisDescription, f64)> = None;
    for ((value, ceiling), axis) in values.zip(ceilings).zip(axes) {
        let times = value.abs() / ceiling;
        let worse = worst.is_none_or(|(_, most)| times > most);
        if worse && (times > 1.0 || times.is_nan()) {
            worst = Some((axis, times));
        }
    }
    worst
}

/// ASSUMED: shares of a motor's hard limits that a carry may use; the rest is for a stop on the path.
const VELOCITY_SHARE: f64 = 0.95;
const ACCELERATION_SHARE: f64 = 2.0 / 3.0;
const JERK_SHARE: f64 = 0.5;

impl Carried {
    fn bears(&self, joints: &AxisMotion, motors: &AxisMotion) -> Result<(), Failure> {
        let axes = self.arm.axes();
        let factor = self.velocity_factor.value();
        let hard = |share: f64| axes.iter().map(move |a| a.hard_limits.velocity * share);
        self.within(
            "velocity",
            excess(
                motors.velocity.iter().copied(),
                hard(factor * VELOCITY_SHARE),
                axes,
            ),
        )?;
        let hard = axes
            .iter()
            .map(|a| a.hard_limits.acceleration * ACCELERATION_SHARE);
        self.within(
            "acceleration",
            excess(motors.acceleration.iter().copied(), hard, axes),
        )?;
        let ceiling = axes.iter().map(|a| a.joint_velocity);
        self.within(
            "velocity",
            excess(joints.velocity.iter().copied(), ceiling, axes),
        )?;
        let ceiling = axes.iter().map(|a| a.joint_acceleration);
        self.within(
            "acceleration",
            excess(joints.acceleration.iter().copied(), ceiling, axes),
        )
    }

    fn bears_jerk(&self, before: &AxisMotion, now: &AxisMotion, step: f64) -> Result<(), Failure> {
        let axes = self.arm.axes();
        let jerk = now
            .acceleration
            .iter()
            .zip(&before.acceleration)
            .map(|(b, a)| (b - a) / step);
        let hard = axes.iter().map(|a| a.hard_limits.jerk * JERK_SHARE);
        self.within("jerk", excess(jerk, hard, axes))
    }

    fn within(
        &self,
        quantity: &'static str,
        excess: Option<(&AxisDescription, f64)>,
    ) -> Result<(), Failure> {
        match excess {
            None => Ok(()),
            Some((axis, times)) => {
                let (who, axis) = (self.who.clone(), axis.name);
                Err(Failure::TooFast {
                    who,
                    axis,
                    times,
                    quantity,
                })
            }
        }
    }
}
