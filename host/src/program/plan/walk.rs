//! One motion from one place, point by point.

use super::{Place, Why};
use crate::mp::arm::Arm;
use crate::mp::config::RobotConfig;
use crate::path::{Streamed, pose};
use crate::program::progress::Segment;
use crate::task::PathStep;
use motion::{Line, Pose};
use protocol::message::{Instruction, PosePath, PoseReference, PoseSpeeds};
use protocol::units::PerAxis;
use robots::KinematicError;

/// How many points of a straight way in axes are looked at.
const AXIS_POINTS: u32 = 32;
/// A line is looked at every so many m and rad.
const LINE_STEP: f64 = 0.01;
/// Two neighbouring points of a line are nearer than this, rad or m; another branch is not.
const BRANCH: f64 = 0.5;

/// The whole way of a motion that may end sooner: all of it must be possible.
pub(super) const fn whole(instruction: &Instruction) -> Option<Instruction> {
    let Instruction::MoveUntilForce {
        target,
        reference,
        speeds,
        ..
    } = instruction
    else {
        return None;
    };
    Some(Instruction::MovePose {
        target: *target,
        reference: *reference,
        path: PosePath::Line,
        speeds: *speeds,
    })
}

/// One instruction from a place: its way, all of it inside the limits; the place moves on.
pub(super) fn walk(
    config: &RobotConfig,
    place: &mut Place,
    instruction: &Instruction,
) -> Result<Segment, Why> {
    let arm = config.arm;
    let sum = |from: &PerAxis<f64>, by: &PerAxis<f64>, relative: bool| -> PerAxis<f64> {
        if relative {
            from.iter().zip(by).map(|(a, b)| a + b).collect()
        } else {
            by.clone()
        }
    };
    match instruction {
        Instruction::MoveMotors {
            target, relative, ..
        } => {
            let (from, to) = (place.motors.clone(), sum(&place.motors, target, *relative));
            if place.homed {
                straight(&from, &to, |motors| arm.check(&arm.joints(motors)?))?;
            } else if !relative {
                return Err(Why::NotHomed);
            }
            place.motors.clone_from(&to);
            Ok(Segment::Motors { from, to })
        }
        Instruction::MoveJoints {
            target, relative, ..
        } => {
            let from = joints(arm, place)?;
            let to = sum(&from, target, *relative);
            straight(&from, &to, |joints| arm.check(joints))?;
            place.motors = arm.motors(&to).map_err(goal)?;
            Ok(Segment::Joints { from, to })
        }
        Instruction::MovePose {
            target,
            reference,
            path,
            speeds,
        } => {
            bearable(arm, speeds)?;
            let from = joints(arm, place)?;
            let t_base_tool = arm.forward(&from).map_err(goal)? * config.t_flange_tool;
            let to = match reference {
                PoseReference::Base => pose(target),
                PoseReference::Tool => t_base_tool * pose(target),
            };
            let (segment, end) = match path {
                PosePath::Line => {
                    let line = Line::new(t_base_tool, to);
                    let end = along(config, &line, from)?;
                    (
                        Segment::Line {
                            from: t_base_tool,
                            to,
                        },
                        end,
                    )
                }
                PosePath::Joint => {
                    let flange = to * config.t_flange_tool.inverse();
                    let end = arm.inverse(&flange, &from).map_err(goal)?;
                    straight(&from, &end, |joints| arm.check(joints))?;
                    (
                        Segment::Joints {
                            from,
                            to: end.clone(),
                        },
                        end,
                    )
                }
            };
            place.motors = arm.motors(&end).map_err(goal)?;
            Ok(segment)
        }
        Instruction::Hold { .. }
        | Instruction::Follow
        | Instruction::FollowPath { .. }
        | Instruction::MoveUntilForce { .. }
        | Instruction::Wait { .. }
        | Instruction::Program { .. } => Ok(Segment::None),
    }
}

/// A path from a place: all of its curve inside the limits; the place moves on to its end.
pub(super) fn follow(
    config: &RobotConfig,
    place: &mut Place,
    step: &PathStep,
) -> Result<Streamed, Why> {
    let arm = config.arm;
    bearable(arm, &step.speeds)?;
    let mut near = joints(arm, place)?;
    let start = arm
        .forward(&near)
        .map_err(|error| Why::Kinematics { share: 0.0, error })?
        * config.t_flange_tool;
    let streamed = step
        .path
        .from(&start, step.reference)
        .map_err(|fault| Why::Element {
            number: fault.mark + 1,
            fault,
        })?;
    let course = &streamed.course;
    for s in course.samples(LINE_STEP) {
        let failed = |error| Why::Point {
            number: streamed.marks.get(course.element(s)).map_or(0, |k| k + 1),
            error,
        };
        let Some(point) = course.at(s) else { break };
        near = beside(config, &point.pose, &near).map_err(failed)?;
    }
    place.motors = arm.motors(&near).map_err(goal)?;
    Ok(streamed)
}

/// The joints at a pose of the tool, on the branch of their neighbours and inside the limits.
fn beside(
    config: &RobotConfig,
    tool: &Pose,
    near: &PerAxis<f64>,
) -> Result<PerAxis<f64>, KinematicError> {
    let flange = *tool * config.t_flange_tool.inverse();
    let next = config.arm.inverse(&flange, near)?;
    if next.iter().zip(near).any(|(a, b)| (a - b).abs() > BRANCH) {
        return Err(KinematicError::Singular);
    }
    config.arm.check(&next)?;
    Ok(next)
}

const fn goal(error: KinematicError) -> Why {
    Why::Kinematics { share: 1.0, error }
}

fn joints(arm: &dyn Arm, place: &Place) -> Result<PerAxis<f64>, Why> {
    if place.homed {
        arm.joints(&place.motors)
            .map_err(|error| Why::Kinematics { share: 0.0, error })
    } else {
        Err(Why::NotHomed)
    }
}

/// What the tool is asked for is what the robot's node takes.
fn bearable(arm: &dyn Arm, speeds: &PoseSpeeds) -> Result<(), Why> {
    let [v, a] = arm.tool_ceilings();
    let asked = [
        ("velocity in m/s", speeds.velocity_m_s, v),
        ("velocity in rad/s", speeds.angular_velocity_rad_s, v),
        ("acceleration in m/s²", speeds.acceleration_m_s2, a),
        (
            "acceleration in rad/s²",
            speeds.angular_acceleration_rad_s2,
            a,
        ),
    ];
    for (what, asked, most) in asked {
        let asked = f64::from(asked);
        // they travel as f32
        if asked > most * (1.0 + f64::from(f32::EPSILON)) {
            return Err(Why::Speed { what, asked, most });
        }
    }
    Ok(())
}

/// The goal first, because it says most; then what lies before it.
fn straight(
    from: &PerAxis<f64>,
    to: &PerAxis<f64>,
    check: impl Fn(&[f64]) -> Result<(), KinematicError>,
) -> Result<(), Why> {
    if from.len() != to.len() {
        return Err(goal(KinematicError::NotFinite));
    }
    check(to).map_err(goal)?;
    for k in 1..AXIS_POINTS {
        let share = f64::from(k) / f64::from(AXIS_POINTS);
        let between: PerAxis<f64> = from
            .iter()
            .zip(to)
            .map(|(a, b)| a + share * (b - a))
            .collect();
        check(&between).map_err(|error| Why::Kinematics { share, error })?;
    }
    Ok(())
}

fn along(config: &RobotConfig, line: &Line, from: PerAxis<f64>) -> Result<PerAxis<f64>, Why> {
    let length = if line.length_m() > line.angle_rad() {
        line.length_m()
    } else {
        line.angle_rad()
    };
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "between 1 and 1000; the conversion saturates"
    )]
    let points = (libm::ceil(length / LINE_STEP) as u32).clamp(1, 1000);
    let mut near = from;
    for k in 1..=points {
        let share = f64::from(k) / f64::from(points);
        let failed = |error| Why::Kinematics { share, error };
        near = beside(config, &line.at(share), &near).map_err(failed)?;
    }
    Ok(near)
}
