//! What every robot answers.

use motion::{AxisLimits, Pose};
use nalgebra::SMatrix;

use crate::along::{JointsAlong, PoseAlong};
use crate::description::RobotDescription;
use crate::dynamics::{Chain, Transmission};
use crate::error::{KinematicError, Quantity};
use crate::gearing::{self, finite};
use crate::planning::{self, VelocityFactor};
use crate::space::{JointMotion, Joints, MotorMotion, Motors};

/// The most branches an inverse kinematic problem here has: on the IRp-6 2 sides of the column × 2
/// wrists × 4 turns of V.
pub const MAX_BRANCHES: usize = 16;

/// All solutions of an inverse kinematic problem inside the joint limits; at least one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inverse<const N: usize> {
    branches: [Joints<N>; MAX_BRANCHES],
    count: usize,
    nearest: Joints<N>,
}

impl<const N: usize> Inverse<N> {
    /// From at least one branch; further than [`MAX_BRANCHES`] are left out.
    pub(crate) fn new(
        mut found: impl Iterator<Item = Joints<N>>,
        near: &Joints<N>,
    ) -> Option<Self> {
        let first = found.next()?;
        let mut inverse = Self {
            branches: [first; MAX_BRANCHES],
            count: 1,
            nearest: first,
        };
        for (slot, branch) in inverse.branches.iter_mut().skip(1).zip(found) {
            *slot = branch;
            inverse.count = inverse.count.saturating_add(1);
        }
        inverse.nearest = inverse.nearest_where(near, |_| true)?;
        Some(inverse)
    }

    /// Every solution, in the order of its robot: side of the column, wrist, turns of V; plane, bends.
    #[must_use]
    pub fn branches(&self) -> &[Joints<N>] {
        self.branches.get(..self.count).unwrap_or(&[])
    }

    /// The solution nearest to where the robot was, by [`distance`]; of several, the first.
    #[must_use]
    pub fn nearest(&self) -> Joints<N> {
        self.nearest
    }

    /// The nearest to `near` of the solutions that satisfy `keep`, for example those whose motors
    /// are inside their limits.
    pub fn nearest_where(
        &self,
        near: &Joints<N>,
        keep: impl Fn(&Joints<N>) -> bool,
    ) -> Option<Joints<N>> {
        let mut best: Option<(f64, Joints<N>)> = None;
        for branch in self.branches().iter().filter(|q| keep(q)) {
            let d = distance(branch, near);
            if best.is_none_or(|(least, _)| d < least) {
                best = Some((d, *branch));
            }
        }
        best.map(|(_, branch)| branch)
    }
}

/// Distance of two configurations: the square root of Σ (difference of a joint)², rad and m alike.
#[must_use]
pub fn distance<const N: usize>(a: &Joints<N>, b: &Joints<N>) -> f64 {
    libm::sqrt(a.0.iter().zip(b.0).map(|(a, b)| (a - b) * (a - b)).sum())
}

/// A robot: its constants, its transmission and its kinematics.
///
/// A robot of fewer than six axes answers for what its axes can set, and says which that is: the
/// five-axis IRp-6 for the position and the direction of A, so that its [`Robot::forward`] of an
/// answer may differ from the pose by a turn about A; conveyor and grippers for a position on their
/// line, and a pose off it is [`KinematicError::Unreachable`]. One of more than six axes has a rule
/// for what is left free, and says it.
///
/// Frames: poses are those of the flange in the robot's base frame; see
/// [`RobotDescription::base`] and [`RobotDescription::default_tool`] for the rest.
pub trait Robot<const N: usize> {
    /// The robot's constants.
    fn description(&self) -> &'static RobotDescription<N>;

    /// Flange in the base frame. A NaN goes through.
    fn forward(&self, joints: &Joints<N>) -> Pose;

    /// Every configuration inside the joint limits that reaches `flange` (a redundant robot: by its
    /// rule), each verified by [`Robot::forward`], and the one nearest to `near`.
    ///
    /// Motor limits are left to [`Robot::check_motors`]: were they applied here, a path that runs
    /// into one would jump to another branch instead of ending in an error.
    ///
    /// # Errors
    /// [`KinematicError::NotFinite`] and [`KinematicError::NotARotation`] for malformed input;
    /// [`KinematicError::Singular`] where a joint is free, is kept where it is in `near`, and so
    /// leaves no solution inside the limits; [`KinematicError::Limit`] of the solution nearest to
    /// `near` where all are outside; else [`KinematicError::Unreachable`].
    fn inverse(&self, flange: &Pose, near: &Joints<N>) -> Result<Inverse<N>, KinematicError>;

    /// The joints on the branch of `near`: the solution nearest to it, where the way there is plain.
    /// For following a path in small steps; [`Robot::inverse`] looks at every branch.
    ///
    /// # Errors
    /// As [`Robot::inverse`].
    fn inverse_near(&self, flange: &Pose, near: &Joints<N>) -> Result<Joints<N>, KinematicError> {
        self.inverse(flange, near)
            .map(|solution| solution.nearest())
    }

    /// The same on a path, with the derivatives of the joints where the robot knows them in closed form and
    /// is not near a singularity: else who wants them takes differences.
    ///
    /// # Errors
    /// As [`Robot::inverse`].
    fn inverse_along(
        &self,
        flange: &PoseAlong,
        near: &Joints<N>,
    ) -> Result<JointsAlong<N>, KinematicError> {
        self.inverse_near(&flange.pose, near).map(JointsAlong::at)
    }

    /// Geometric Jacobian of the flange in the base frame: rows 0–2 linear velocity, m/s, rows 3–5
    /// angular velocity, rad/s, per rad/s (or m/s) of each joint.
    fn jacobian(&self, joints: &Joints<N>) -> SMatrix<f64, 6, N>;

    /// Its links as rigid bodies, with masses that are ASSUMED; none where no link moves another.
    fn chain(&self) -> Option<Chain<N>> {
        None
    }

    /// How forces and masses of the joints are seen by the motors, at joint positions.
    ///
    /// # Errors
    /// As [`Robot::motors`], or [`KinematicError::Singular`] where motors at rest do not hold the joints.
    fn transmission(&self, joints: &Joints<N>) -> Result<Transmission<N>, KinematicError> {
        Transmission::geared(self.description(), joints)
    }

    /// Joint positions of motor angles. Position limits are not checked.
    ///
    /// # Errors
    /// [`KinematicError::NotFinite`], [`KinematicError::Limit`] where a screw triangle does not close or a
    /// leg is off its screw, or [`KinematicError::Unreachable`] where no platform joins the legs.
    fn joints(&self, motors: &Motors<N>) -> Result<Joints<N>, KinematicError> {
        gearing::joints(self.description(), motors)
    }

    /// Motor angles of joint positions. Position limits are not checked.
    ///
    /// # Errors
    /// [`KinematicError::NotFinite`], or [`KinematicError::Limit`] beyond the dead centre of a
    /// screw triangle, or where a platform is tilted or legs are long beyond what is known of them.
    fn motors(&self, joints: &Joints<N>) -> Result<Motors<N>, KinematicError> {
        gearing::motors(self.description(), joints)
    }

    /// Motion of the motors from the motion of the joints, by the exact chain rule.
    ///
    /// # Errors
    /// As [`Robot::motors`].
    fn motor_motion(&self, motion: &JointMotion<N>) -> Result<MotorMotion<N>, KinematicError> {
        gearing::motor_motion(self.description(), motion)
    }

    /// Motion of the joints from the motion of the motors; the inverse of [`Robot::motor_motion`].
    ///
    /// # Errors
    /// As [`Robot::joints`].
    fn joint_motion(&self, motion: &MotorMotion<N>) -> Result<JointMotion<N>, KinematicError> {
        gearing::joint_motion(self.description(), motion)
    }

    /// The greatest |∂m/∂q| of every axis' own motor by its own joint over its range, rad/rad or
    /// rad/m.
    fn motor_slopes(&self) -> [f64; N] {
        planning::motor_slopes(self.description())
    }

    /// Limits of every joint within which *any* simultaneous motion keeps every motor inside its
    /// limits, rad/s or m/s and its derivatives: for a planner that treats joints one by one.
    /// [`Robot::limits_along`] is much less cautious for a known move.
    ///
    /// Each motor's budget is shared out among the joints that turn it, in proportion to what each
    /// could use alone. With C(k, j) ≥ |∂m/∂q| of motor k by joint j over the whole range and B(k)
    /// the budget of motor k,
    ///
    /// ```text
    ///   alone(j)    = min over k of B(k) / C(k, j)
    ///   together(j) = alone(j) · min over k of 1 and B(k) / Σ over i of C(k, i)·alone(i)
    /// ```
    ///
    /// so that Σ over j of C(k, j)·together(j) ≤ B(k) whatever the signs. On the IRp-6 lower arm,
    /// upper arm, T and V all turn the motor of V: each of them keeps about a third of what it could
    /// do alone, while track, column and N keep all.
    fn joint_limits_for_planning(&self, factor: VelocityFactor) -> [AxisLimits; N] {
        planning::joint_limits(self.description(), factor)
    }

    /// Limits of the path parameter s ∈ \[0, 1\] of the straight line in joint space
    /// q = from + s·(to − from), in 1/s, 1/s² and 1/s³, such that every motor stays inside its
    /// limits. `None` where `from` equals `to`.
    ///
    /// # Errors
    /// [`KinematicError::NotFinite`], or [`KinematicError::Limit`] where an end is beyond the dead
    /// centre of a screw triangle.
    fn limits_along(
        &self,
        from: &Joints<N>,
        to: &Joints<N>,
        factor: VelocityFactor,
    ) -> Result<Option<AxisLimits>, KinematicError> {
        planning::limits_along(self.description(), from, to, factor)
    }

    /// Every joint inside its position limits.
    ///
    /// # Errors
    /// [`KinematicError::Limit`] of the first axis outside, or [`KinematicError::NotFinite`].
    fn check_joints(&self, joints: &Joints<N>) -> Result<(), KinematicError> {
        finite(&joints.0)?;
        for (axis, (value, data)) in (0..N).zip(joints.0.iter().zip(&self.description().axes)) {
            let range = data.joint_position;
            if !range.contains(*value) {
                return Err(KinematicError::Limit {
                    axis,
                    name: data.name,
                    quantity: Quantity::Joint,
                    value: *value,
                    lower: range.lower,
                    upper: range.upper,
                });
            }
        }
        Ok(())
    }

    /// Every motor inside its position limits.
    ///
    /// # Errors
    /// [`KinematicError::Limit`] of the first axis outside, or [`KinematicError::NotFinite`].
    fn check_motors(&self, motors: &Motors<N>) -> Result<(), KinematicError> {
        finite(&motors.0)?;
        for (axis, (value, data)) in (0..N).zip(motors.0.iter().zip(&self.description().axes)) {
            let range = data.motor_position;
            if !range.contains(*value) {
                return Err(KinematicError::Limit {
                    axis,
                    name: data.name,
                    quantity: Quantity::Motor,
                    value: *value,
                    lower: range.lower,
                    upper: range.upper,
                });
            }
        }
        Ok(())
    }
}
