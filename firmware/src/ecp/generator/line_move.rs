//! `f^2(c_j, e_j)`: the tool along a straight line, its orientation by slerp.
//!
//! The way is scanned first, a few points per macrostep, so that no step does unbounded work: at
//! every point the inverse kinematics gives q(s) and, by differences, q', q'', q'''. From the
//! greatest of them follow the speed, acceleration and jerk along the line that every joint can
//! bear. Only then does the arm start.

use crate::ecp::{Demand, EcpOf, refusal};
use agent::args::{E, F};
use agent::{Generator, X};
use motion::Pose;
use motion::line::Line;
use motion::path_profile::{PathError, PathScan, ToolLimits};
use motion::profile::{AxisLimits, Profile};
use protocol::fault::Refusal;
use robots::{JointMotion, Joints, Robot};

/// Points at which the way is scanned.
pub const SCAN_POINTS: u32 = 48;
/// Points per macrostep: seven solutions of the inverse kinematics each.
pub const SCAN_PER_MACROSTEP: u32 = 3;
/// Step of the difference quotients, in units of the whole line: at q'''' of order 1 their error
/// is 1e-7, and rounding (1e-16/δ³) stays below it.
const DELTA: f64 = 1e-3;
/// A joint that would turn faster than this per unit of the line passes a singularity, rad or m.
const SINGULAR_SLOPE: f64 = 200.0;

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

/// What the target pose is relative to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reference {
    /// The robot's base frame.
    Base,
    /// The tool frame at the start.
    Tool,
}

/// Move the tool along a straight line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineMove<R, const N: usize> {
    /// The robot's kinematics.
    pub robot: R,
    /// The tool in the flange frame.
    pub t_flange_tool: Pose,
    /// Where to.
    pub target: Pose,
    /// In which frame.
    pub reference: Reference,
    /// What every joint can bear.
    pub joint_limits: [AxisLimits; N],
    /// What is asked for along the line.
    pub speeds: PathSpeeds,
    /// Macrostep, s.
    pub macrostep_s: f64,
}

/// The way, being scanned or being run.
#[derive(Clone, Debug, PartialEq)]
pub struct Way<const N: usize> {
    line: Line,
    near: Joints<N>,
    phase: Phase<N>,
}

#[derive(Clone, Debug, PartialEq)]
enum Phase<const N: usize> {
    Scanning {
        points: u32,
        scan: PathScan<N>,
        start: Joints<N>,
    },
    Running {
        profile: Profile,
        i: u32,
    },
    Refused(Refusal),
}

/// q and its first derivatives by s, at one s.
struct Local<const N: usize> {
    q: Joints<N>,
    d1: [f64; N],
    d2: [f64; N],
}

impl<R: Robot<N>, const N: usize> LineMove<R, N> {
    fn joints(&self, line: &Line, s: f64, near: &Joints<N>) -> Result<Joints<N>, Refusal> {
        let t_base_flange = line.extended(s) * self.t_flange_tool.inverse();
        self.robot
            .inverse_near(&t_base_flange, near)
            .map_err(|e| refusal::from_kinematics(&e))
    }

    fn local(&self, line: &Line, s: f64, near: &Joints<N>) -> Result<Local<N>, Refusal> {
        let q = self.joints(line, s, near)?;
        let before = self.joints(line, s - DELTA, &q)?;
        let after = self.joints(line, s + DELTA, &q)?;
        let (mut d1, mut d2) = ([0.0; N], [0.0; N]);
        for ((((d1, d2), q), b), a) in d1
            .iter_mut()
            .zip(&mut d2)
            .zip(&q.0)
            .zip(&before.0)
            .zip(&after.0)
        {
            *d1 = (a - b) / (2.0 * DELTA);
            *d2 = (a - 2.0 * q + b) / (DELTA * DELTA);
        }
        Ok(Local { q, d1, d2 })
    }

    fn third(&self, line: &Line, s: f64, near: &Joints<N>) -> Result<[f64; N], Refusal> {
        let a2 = self.joints(line, s + 2.0 * DELTA, near)?;
        let a1 = self.joints(line, s + DELTA, near)?;
        let b1 = self.joints(line, s - DELTA, near)?;
        let b2 = self.joints(line, s - 2.0 * DELTA, near)?;
        let mut d3 = [0.0; N];
        for ((((d3, a2), a1), b1), b2) in d3.iter_mut().zip(&a2.0).zip(&a1.0).zip(&b1.0).zip(&b2.0)
        {
            *d3 = (a2 - 2.0 * a1 + 2.0 * b1 - b2) / (2.0 * DELTA * DELTA * DELTA);
        }
        Ok(d3)
    }

    fn begin(&self, from: Option<Joints<N>>) -> Way<N> {
        let Some(from) = from else {
            return Way {
                line: Line::new(self.target, self.target),
                near: Joints([0.0; N]),
                phase: Phase::Refused(Refusal::NotSynchronised),
            };
        };
        let t_base_start = self.robot.forward(&from) * self.t_flange_tool;
        let t_base_goal = match self.reference {
            Reference::Base => self.target,
            Reference::Tool => t_base_start * self.target,
        };
        Way {
            line: Line::new(t_base_start, t_base_goal),
            near: from,
            phase: Phase::Scanning {
                points: 0,
                scan: PathScan::new(),
                start: from,
            },
        }
    }

    /// Scan some points of the way.
    fn scan(&self, way: &mut Way<N>) -> Result<(), Refusal> {
        let Phase::Scanning {
            points,
            scan,
            start,
        } = &mut way.phase
        else {
            return Ok(());
        };
        if *points > SCAN_POINTS {
            // the search for the speed has a step of its own
            let profile = self.profile(&way.line, scan)?;
            way.near = *start;
            way.phase = Phase::Running { profile, i: 0 };
            return Ok(());
        }
        for _ in 0..SCAN_PER_MACROSTEP {
            if *points > SCAN_POINTS {
                break;
            }
            let s = f64::from(*points) / f64::from(SCAN_POINTS);
            let local = self.local(&way.line, s, &way.near)?;
            let d3 = self.third(&way.line, s, &local.q)?;
            if local.d1.iter().any(|d| libm::fabs(*d) > SINGULAR_SLOPE) {
                return Err(Refusal::Singular);
            }
            scan.add(&local.d1, &local.d2, &d3);
            way.near = local.q;
            *points += 1;
        }
        Ok(())
    }

    /// The speed along the line that every joint can bear and that was asked for.
    fn profile(&self, line: &Line, scan: &mut PathScan<N>) -> Result<Profile, Refusal> {
        scan.add_twist(&line.twist());
        let tool = ToolLimits {
            linear_m_s: self.speeds.velocity_m_s,
            angular_rad_s: self.speeds.angular_velocity_rad_s,
        };
        let mut limits = match scan.quick_limits(&self.joint_limits, Some(tool), 1.0) {
            Ok(limits) => limits,
            // a line of no length: there already
            Err(PathError::Still) => AxisLimits {
                v: 1.0,
                a: 1.0,
                j: 1.0,
            },
            Err(PathError::NotFinite | PathError::NotPositive | PathError::NotRepresentable) => {
                return Err(Refusal::Singular);
            }
        };
        for (asked, extent) in [
            (self.speeds.acceleration_m_s2, line.length_m()),
            (self.speeds.angular_acceleration_rad_s2, line.angle_rad()),
        ] {
            if limits.a * extent > asked {
                limits.a = asked / extent;
            }
        }
        let distance = if line.length_m() > 0.0 || line.angle_rad() > 0.0 {
            1.0
        } else {
            0.0
        };
        Profile::new(distance, &limits).map_err(refusal::from_plan)
    }

    fn demand(&self, way: &mut Way<N>) -> Demand<N> {
        let result = match &mut way.phase {
            Phase::Scanning { .. } => self.scan(way).map(|()| Demand::Stay),
            Phase::Running { profile, i } => {
                *i = i.saturating_add(1);
                let state = profile.at(f64::from(*i) * self.macrostep_s);
                self.local(&way.line, state.p, &way.near)
                    .map(|Local { q, d1, d2 }| {
                        let (mut velocity, mut acceleration) = ([0.0; N], [0.0; N]);
                        for (((v, a), d1), d2) in
                            velocity.iter_mut().zip(&mut acceleration).zip(&d1).zip(&d2)
                        {
                            *v = d1 * state.v;
                            *a = d2 * state.v * state.v + d1 * state.a;
                        }
                        way.near = q;
                        Demand::Joints(JointMotion {
                            position: q,
                            velocity,
                            acceleration,
                        })
                    })
            }
            Phase::Refused(refusal) => Err(*refusal),
        };
        result.unwrap_or_else(|refusal| {
            way.phase = Phase::Refused(refusal);
            Demand::Refuse(refusal)
        })
    }
}

impl<R: Robot<N>, const N: usize> Generator<EcpOf<N>> for LineMove<R, N> {
    type Own = Way<N>;
    type Args = F<(), E, ()>;

    fn first(&self, x: X<'_, EcpOf<N>, Self::Args>) -> (Way<N>, Demand<N>) {
        let mut way = self.begin(x.e().demanded_joints);
        let y = self.demand(&mut way);
        (way, y)
    }

    fn next(&self, way: &mut Way<N>, _: X<'_, EcpOf<N>, Self::Args>) -> Demand<N> {
        self.demand(way)
    }

    fn terminal(&self, way: &Way<N>, _: X<'_, EcpOf<N>, Self::Args>) -> bool {
        match &way.phase {
            Phase::Scanning { .. } => false,
            Phase::Running { profile, i } => f64::from(*i) * self.macrostep_s >= profile.duration(),
            Phase::Refused(_) => true,
        }
    }
}
