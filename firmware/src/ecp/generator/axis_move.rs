//! `f^2(c_j, e_j)`: straight from here to there, in the space of the motors or of the joints.
//!
//! Jerk-limited and phase-synchronised: all axes start and end together and the way is a straight
//! line in that space.

use crate::ecp::{Demand, EcpOf, refusal};
use agent::args::{E, F};
use agent::{Generator, X};
use motion::profile::{AxisLimits, PhaseSynchronised, State};
use protocol::fault::Refusal;
use robots::{JointMotion, Joints, MotorMotion, Motors, Robot, VelocityFactor};

/// Move the motors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorMove<const N: usize> {
    /// Motor angles, rad.
    pub target: [f64; N],
    /// Is the target an increment?
    pub relative: bool,
    /// Velocity, acceleration and jerk per axis.
    pub limits: [AxisLimits; N],
    /// Macrostep, s.
    pub macrostep_s: f64,
}

/// Move the joints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointMove<R, const N: usize> {
    /// The robot: what its motors can bear limits the joints along the way.
    pub robot: R,
    /// Joint positions, rad or m.
    pub target: [f64; N],
    /// Is the target an increment?
    pub relative: bool,
    /// Velocity, acceleration and jerk per joint that are asked for.
    pub limits: [AxisLimits; N],
    /// How far the motors may be used.
    pub motor_share: MotorShare,
    /// Macrostep, s.
    pub macrostep_s: f64,
}

/// How much of the motors' limits a plan in joint space may use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorShare {
    /// The velocity factor in force.
    pub factor: VelocityFactor,
    /// Of the velocity that the robot's planning limits allow.
    pub velocity: f64,
}

/// The planned way and how far it has been demanded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Course<const N: usize> {
    plan: Result<PhaseSynchronised<N>, Refusal>,
    i: u32,
}

impl<const N: usize> Course<N> {
    /// Straight in joint space from here to there, as fast as joints and motors bear.
    pub(crate) fn joints<R: Robot<N>>(
        robot: &R,
        from: &Joints<N>,
        to: &Joints<N>,
        limits: &[AxisLimits; N],
        share: MotorShare,
    ) -> Self {
        let plan = || {
            robot.check_joints(to)?;
            robot.limits_along(from, to, share.factor)
        };
        let along = match plan() {
            Ok(along) => along,
            Err(e) => return Self::refused(refusal::from_kinematics(&e)),
        };
        let mut limits = *limits;
        if let Some(along) = along {
            // limits of s in [0, 1] become limits of each joint on this line
            for ((l, a), b) in limits.iter_mut().zip(&from.0).zip(&to.0) {
                let distance = libm::fabs(b - a);
                l.v = least(l.v, along.v * share.velocity * distance);
                l.a = least(l.a, along.a * distance);
                l.j = least(l.j, along.j * distance);
                if distance <= 0.0 {
                    *l = AxisLimits {
                        v: 1.0,
                        a: 1.0,
                        j: 1.0,
                    };
                }
            }
        }
        Self::plan(&from.0, &to.0, false, &limits)
    }
}

fn least(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

impl<const N: usize> Course<N> {
    pub(crate) fn plan(
        from: &[f64; N],
        target: &[f64; N],
        relative: bool,
        limits: &[AxisLimits; N],
    ) -> Self {
        let mut to = *target;
        if relative {
            for (to, from) in to.iter_mut().zip(from) {
                *to += *from;
            }
        }
        let plan = PhaseSynchronised::new(*from, to, limits).map_err(refusal::from_plan);
        Self { plan, i: 0 }
    }

    /// A course that cannot be taken.
    pub(crate) const fn refused(refusal: Refusal) -> Self {
        Self {
            plan: Err(refusal),
            i: 0,
        }
    }

    /// The state at the end of the next macrostep.
    pub(crate) fn advance(&mut self, macrostep_s: f64) -> Result<[State; N], Refusal> {
        self.i = self.i.saturating_add(1);
        match &self.plan {
            Ok(plan) => Ok(plan.at(f64::from(self.i) * macrostep_s)),
            Err(refusal) => Err(*refusal),
        }
    }

    pub(crate) fn ended(&self, macrostep_s: f64) -> bool {
        match &self.plan {
            Ok(plan) => f64::from(self.i) * macrostep_s >= plan.duration(),
            Err(_) => true,
        }
    }
}

/// The next state of the motors, or the refusal.
fn motor_demand<const N: usize>(c: &mut Course<N>, macrostep_s: f64) -> Demand<N> {
    c.advance(macrostep_s).map_or_else(Demand::Refuse, |state| {
        Demand::Motors(MotorMotion {
            position: Motors(state.map(|s| s.p)),
            velocity: state.map(|s| s.v),
            acceleration: state.map(|s| s.a),
        })
    })
}

/// The next state of the joints, or the refusal.
pub(crate) fn joint_demand<const N: usize>(c: &mut Course<N>, macrostep_s: f64) -> Demand<N> {
    c.advance(macrostep_s).map_or_else(Demand::Refuse, |state| {
        Demand::Joints(JointMotion {
            position: Joints(state.map(|s| s.p)),
            velocity: state.map(|s| s.v),
            acceleration: state.map(|s| s.a),
        })
    })
}

impl<const N: usize> Generator<EcpOf<N>> for MotorMove<N> {
    type Own = Course<N>;
    type Args = F<(), E, ()>;

    fn first(&self, x: X<'_, EcpOf<N>, Self::Args>) -> (Course<N>, Demand<N>) {
        let Motors(from) = &x.e().demanded_motors;
        let mut c = Course::plan(from, &self.target, self.relative, &self.limits);
        let y = motor_demand(&mut c, self.macrostep_s);
        (c, y)
    }

    fn next(&self, c: &mut Course<N>, _: X<'_, EcpOf<N>, Self::Args>) -> Demand<N> {
        motor_demand(c, self.macrostep_s)
    }

    fn terminal(&self, c: &Course<N>, _: X<'_, EcpOf<N>, Self::Args>) -> bool {
        c.ended(self.macrostep_s)
    }
}

impl<R: Robot<N>, const N: usize> Generator<EcpOf<N>> for JointMove<R, N> {
    type Own = Course<N>;
    type Args = F<(), E, ()>;

    fn first(&self, x: X<'_, EcpOf<N>, Self::Args>) -> (Course<N>, Demand<N>) {
        let mut c = match &x.e().demanded_joints {
            Some(from) => {
                let mut to = self.target;
                if self.relative {
                    for (to, from) in to.iter_mut().zip(&from.0) {
                        *to += *from;
                    }
                }
                Course::joints(
                    &self.robot,
                    from,
                    &Joints(to),
                    &self.limits,
                    self.motor_share,
                )
            }
            None => Course::refused(Refusal::NotSynchronised),
        };
        let y = joint_demand(&mut c, self.macrostep_s);
        (c, y)
    }

    fn next(&self, c: &mut Course<N>, _: X<'_, EcpOf<N>, Self::Args>) -> Demand<N> {
        joint_demand(c, self.macrostep_s)
    }

    fn terminal(&self, c: &Course<N>, _: X<'_, EcpOf<N>, Self::Args>) -> bool {
        c.ended(self.macrostep_s)
    }
}
