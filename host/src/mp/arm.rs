//! A robot whose kind, and so whose number of axes, is known only at run time.
//!
//! `robots` counts axes in types; a cell file names robots in text. [`Arm`] stands between: one
//! object per kind, values as [`PerAxis`] in the robot's axis order.

use core::f64::consts::TAU;
use core::fmt;
use motion::{AxisLimits, Pose};
use protocol::units::{PerAxis, UNITS_PER_INCREMENT};
use robots::{
    AxisDescription, JointMotion, Joints, KinematicError, Motors, Robot, RobotKind, RobotVisitor,
    TrackRule, VelocityFactor,
};
use std::sync::LazyLock;

/// Position, velocity and acceleration of every axis at one instant, in one space.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AxisMotion {
    /// rad (motors), rad or m (joints).
    pub position: PerAxis<f64>,
    /// Per second.
    pub velocity: PerAxis<f64>,
    /// Per second².
    pub acceleration: PerAxis<f64>,
}

/// A kind of robot as the coordinator uses it. All poses are of the flange in the base frame, rad
/// and m throughout.
///
/// A slice of the wrong length is [`KinematicError::NotFinite`]: a missing value is no number.
pub trait Arm: fmt::Debug + Send + Sync {
    /// Which robot.
    fn kind(&self) -> RobotKind;
    /// Its axes, base first.
    fn axes(&self) -> &'static [AxisDescription];
    /// Its base frame in the world, where nothing else is said.
    fn base(&self) -> Pose;
    /// Servo step, µs.
    fn servo_step_us(&self) -> u32;
    /// Servo steps in a macrostep.
    fn macrostep(&self) -> u32;
    /// `t_flange_tool` of the default tool.
    fn default_tool(&self) -> Pose;
    /// Joint positions of motor angles.
    ///
    /// # Errors
    /// As [`Robot::joints`].
    fn joints(&self, motors: &[f64]) -> Result<PerAxis<f64>, KinematicError>;
    /// Motor angles of joint positions.
    ///
    /// # Errors
    /// As [`Robot::motors`].
    fn motors(&self, joints: &[f64]) -> Result<PerAxis<f64>, KinematicError>;
    /// Motor motion of a joint motion, by the chain rule.
    ///
    /// # Errors
    /// As [`Robot::motor_motion`].
    fn motor_motion(&self, joints: &AxisMotion) -> Result<AxisMotion, KinematicError>;
    /// The flange.
    ///
    /// # Errors
    /// [`KinematicError::NotFinite`] for a wrong number of joints.
    fn forward(&self, joints: &[f64]) -> Result<Pose, KinematicError>;
    /// The joints nearest to `near` that reach the flange pose.
    ///
    /// # Errors
    /// As [`Robot::inverse`].
    fn inverse(&self, flange: &Pose, near: &[f64]) -> Result<PerAxis<f64>, KinematicError>;
    /// Every joint and every motor inside its position limits.
    ///
    /// # Errors
    /// [`KinematicError::Limit`] of the first axis outside.
    fn check(&self, joints: &[f64]) -> Result<(), KinematicError>;
    /// Greatest velocity and acceleration of the tool that its node takes: m/s and rad/s, m/s² and rad/s².
    fn tool_ceilings(&self) -> [f64; 2];
    /// What a plan may ask of each joint such that every motor bears it.
    fn joint_ceilings(&self, factor: VelocityFactor) -> PerAxis<AxisLimits>;
}

/// The object of a kind; a robot on a track keeps its track where it is.
#[must_use]
pub fn arm(kind: RobotKind) -> &'static dyn Arm {
    arm_with(kind, TrackRule::Keep)
}

/// The object of a kind whose track, if it has one, goes where the rule says.
#[must_use]
pub fn arm_with(kind: RobotKind, track: TrackRule) -> &'static dyn Arm {
    static ARMS: LazyLock<[[Box<dyn Arm>; KINDS]; TrackRule::ALL.len()]> = LazyLock::new(|| {
        TrackRule::ALL.map(|track| RobotKind::ALL.map(|kind| kind.visit(track, Make(kind))))
    });
    // the lists are in the order of the enums: a test looks
    &*ARMS[track as usize][kind as usize]
}

/// Motor angles, rad, of positions in the wire's units.
#[must_use]
pub fn motor_angles(axes: &[AxisDescription], units: &[i64]) -> Option<PerAxis<f64>> {
    if axes.len() != units.len() {
        return None;
    }
    Some(
        units
            .iter()
            .zip(axes)
            .map(|(units, axis)| {
                #[expect(
                    clippy::cast_precision_loss,
                    reason = "2^53 units are years of turning"
                )]
                let units = *units as f64;
                units * unit_rad(axis)
            })
            .collect(),
    )
}

/// rad of the motor shaft in one position unit.
#[must_use]
pub fn unit_rad(axis: &AxisDescription) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "a thousand")]
    let units_per_increment = UNITS_PER_INCREMENT as f64;
    TAU / (f64::from(axis.increments_per_turn) * units_per_increment)
}

const KINDS: usize = RobotKind::ALL.len();

/// Makes the object of a robot.
struct Make(RobotKind);

impl RobotVisitor for Make {
    type Output = Box<dyn Arm>;

    fn visit<R, const N: usize>(self, robot: R) -> Box<dyn Arm>
    where
        R: Robot<N> + Copy + fmt::Debug + Send + Sync + 'static,
    {
        Box::new(OfKind {
            kind: self.0,
            robot,
        })
    }
}

/// A robot of N axes with its kind.
#[derive(Debug)]
struct OfKind<R, const N: usize> {
    kind: RobotKind,
    robot: R,
}

fn sized<const N: usize>(values: &[f64]) -> Result<[f64; N], KinematicError> {
    <[f64; N]>::try_from(values).map_err(|_| KinematicError::NotFinite)
}

fn list<const N: usize>(values: [f64; N]) -> PerAxis<f64> {
    values.into_iter().collect()
}

impl<R, const N: usize> Arm for OfKind<R, N>
where
    R: Robot<N> + fmt::Debug + Send + Sync,
{
    fn kind(&self) -> RobotKind {
        self.kind
    }
    fn axes(&self) -> &'static [AxisDescription] {
        &self.robot.description().axes
    }
    fn base(&self) -> Pose {
        self.robot.description().base()
    }
    fn servo_step_us(&self) -> u32 {
        self.robot.description().servo_step_us
    }
    fn macrostep(&self) -> u32 {
        self.robot.description().macrostep
    }
    fn default_tool(&self) -> Pose {
        self.robot.description().default_tool()
    }
    fn joints(&self, motors: &[f64]) -> Result<PerAxis<f64>, KinematicError> {
        Ok(list::<N>(self.robot.joints(&Motors(sized(motors)?))?.0))
    }
    fn motors(&self, joints: &[f64]) -> Result<PerAxis<f64>, KinematicError> {
        Ok(list::<N>(self.robot.motors(&Joints(sized(joints)?))?.0))
    }
    fn motor_motion(&self, joints: &AxisMotion) -> Result<AxisMotion, KinematicError> {
        let motion = self.robot.motor_motion(&JointMotion::<N> {
            position: Joints(sized(&joints.position)?),
            velocity: sized(&joints.velocity)?,
            acceleration: sized(&joints.acceleration)?,
        })?;
        Ok(AxisMotion {
            position: list(motion.position.0),
            velocity: list(motion.velocity),
            acceleration: list(motion.acceleration),
        })
    }
    fn forward(&self, joints: &[f64]) -> Result<Pose, KinematicError> {
        Ok(self.robot.forward(&Joints(sized::<N>(joints)?)))
    }
    fn inverse(&self, flange: &Pose, near: &[f64]) -> Result<PerAxis<f64>, KinematicError> {
        let found = self.robot.inverse(flange, &Joints(sized::<N>(near)?))?;
        Ok(list(found.nearest().0))
    }
    fn check(&self, joints: &[f64]) -> Result<(), KinematicError> {
        let joints = Joints(sized::<N>(joints)?);
        self.robot.check_joints(&joints)?;
        self.robot.check_motors(&self.robot.motors(&joints)?)
    }
    fn tool_ceilings(&self) -> [f64; 2] {
        let robot = self.robot.description();
        [robot.cartesian_velocity, robot.cartesian_acceleration]
    }
    fn joint_ceilings(&self, factor: VelocityFactor) -> PerAxis<AxisLimits> {
        self.robot
            .joint_limits_for_planning(factor)
            .into_iter()
            .collect()
    }
}

#[cfg(test)]
mod test {
    use super::*;

    #[test]
    fn every_kind_answers_with_its_own_number_of_axes() {
        for kind in RobotKind::ALL {
            let arm = arm(kind);
            assert_eq!(arm.kind(), kind);
            assert_eq!(arm.axes().len(), kind.axes());
            let zero: PerAxis<f64> = arm.axes().iter().map(|_| 0.0).collect();
            let joints = arm.joints(&zero).unwrap();
            let back = arm.motors(&joints).unwrap();
            // a round trip through the screws: rounding of values of some 100 rad
            assert!(back.iter().all(|m| m.abs() < 1e-9), "{back:?}");
            let near = arm
                .inverse(&arm.forward(&joints).unwrap(), &joints)
                .unwrap();
            for (a, b) in near.iter().zip(&joints) {
                // Polycrank's zero has its second pair stretched: the root of the rounding
                assert!((a - b).abs() < 1e-6, "{near:?} {joints:?}");
            }
            assert_eq!(
                arm.joint_ceilings(VelocityFactor::DEFAULT).len(),
                kind.axes()
            );
        }
    }

    #[test]
    fn the_rule_for_the_track_is_that_of_the_object() {
        let front = [0.2, 0.3, -1.57, 0.0, 1.56, 1.57, -1.57];
        for (rule, along) in [(TrackRule::Keep, 0.2), (TrackRule::InFront, f64::NAN)] {
            for kind in RobotKind::ALL {
                assert_eq!(arm_with(kind, rule).kind(), kind);
            }
            let arm = arm_with(RobotKind::Irp6Track, rule);
            let flange = arm.forward(&front).unwrap();
            let along = if along.is_nan() {
                flange.position.y
            } else {
                along
            };
            let found = arm.inverse(&flange, &front).unwrap();
            assert!((found[0] - along).abs() < 1e-12, "{rule:?} {found:?}");
        }
    }

    #[test]
    fn a_wrong_number_of_axes_is_an_error() {
        let arm = arm(RobotKind::Irp6Track);
        assert_eq!(arm.joints(&[0.0; 6]), Err(KinematicError::NotFinite));
        assert_eq!(motor_angles(arm.axes(), &[0; 6]), None);
    }
}
