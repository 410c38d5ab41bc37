//! A robot whose kind, and so whose number of axes, is known only at run time.
//!
//! `robots` counts axes in types; a cell file names robots in text. [`Arm`] stands between: one
//! object per kind, values as [`PerAxis`] in the robot's axis order.

use core::f64::consts::TAU;
use core::fmt;
use motion::{AxisLimits, Pose};
use protocol::units::{PerAxis, UNITS_PER_INCREMENT};
use robots::{
    AxisDescription, Irp6Postument, Irp6Track, JointMotion, Joints, KinematicError, Motors, Robot,
    RobotKind, VelocityFactor,
};

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
    /// What a plan may ask of each joint such that every motor bears it.
    fn joint_ceilings(&self, factor: VelocityFactor) -> PerAxis<AxisLimits>;
}

/// The object of a kind.
#[must_use]
pub fn arm(kind: RobotKind) -> &'static dyn Arm {
    match kind {
        RobotKind::Irp6Track => &Sized7,
        RobotKind::Irp6Postument => &Sized6,
    }
}

/// Motor angles, rad, of positions in the wire's units.
#[must_use]
pub fn motor_angles(axes: &[AxisDescription], units: &[i32]) -> Option<PerAxis<f64>> {
    if axes.len() != units.len() {
        return None;
    }
    Some(
        units
            .iter()
            .zip(axes)
            .map(|(units, axis)| f64::from(*units) * unit_rad(axis))
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

#[derive(Debug)]
struct Sized7;
#[derive(Debug)]
struct Sized6;

fn sized<const N: usize>(values: &[f64]) -> Result<[f64; N], KinematicError> {
    <[f64; N]>::try_from(values).map_err(|_| KinematicError::NotFinite)
}

fn list<const N: usize>(values: [f64; N]) -> PerAxis<f64> {
    values.into_iter().collect()
}

macro_rules! arm {
    ($object:ident, $robot:expr, $n:literal, $kind:ident) => {
        impl Arm for $object {
            fn kind(&self) -> RobotKind {
                RobotKind::$kind
            }
            fn axes(&self) -> &'static [AxisDescription] {
                &$robot.description().axes
            }
            fn servo_step_us(&self) -> u32 {
                $robot.description().servo_step_us
            }
            fn macrostep(&self) -> u32 {
                $robot.description().macrostep
            }
            fn default_tool(&self) -> Pose {
                $robot.description().default_tool()
            }
            fn joints(&self, motors: &[f64]) -> Result<PerAxis<f64>, KinematicError> {
                Ok(list::<$n>($robot.joints(&Motors(sized(motors)?))?.0))
            }
            fn motors(&self, joints: &[f64]) -> Result<PerAxis<f64>, KinematicError> {
                Ok(list::<$n>($robot.motors(&Joints(sized(joints)?))?.0))
            }
            fn motor_motion(&self, joints: &AxisMotion) -> Result<AxisMotion, KinematicError> {
                let motion = $robot.motor_motion(&JointMotion::<$n> {
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
                Ok($robot.forward(&Joints(sized::<$n>(joints)?)))
            }
            fn inverse(&self, flange: &Pose, near: &[f64]) -> Result<PerAxis<f64>, KinematicError> {
                let found = $robot.inverse(flange, &Joints(sized::<$n>(near)?))?;
                Ok(list(found.nearest().0))
            }
            fn check(&self, joints: &[f64]) -> Result<(), KinematicError> {
                let joints = Joints(sized::<$n>(joints)?);
                $robot.check_joints(&joints)?;
                $robot.check_motors(&$robot.motors(&joints)?)
            }
            fn joint_ceilings(&self, factor: VelocityFactor) -> PerAxis<AxisLimits> {
                $robot
                    .joint_limits_for_planning(factor)
                    .into_iter()
                    .collect()
            }
        }
    };
}
arm!(Sized7, Irp6Track, 7, Irp6Track);
arm!(Sized6, Irp6Postument, 6, Irp6Postument);

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
                assert!((a - b).abs() < 1e-9, "{near:?} {joints:?}");
            }
            assert_eq!(
                arm.joint_ceilings(VelocityFactor::DEFAULT).len(),
                kind.axes()
            );
        }
    }

    #[test]
    fn a_wrong_number_of_axes_is_an_error() {
        let arm = arm(RobotKind::Irp6Track);
        assert_eq!(arm.joints(&[0.0; 6]), Err(KinematicError::NotFinite));
        assert_eq!(motor_angles(arm.axes(), &[0; 6]), None);
    }
}
