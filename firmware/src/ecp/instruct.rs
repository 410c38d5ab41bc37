//! Instructions: refused or accepted at once, and made a behaviour where there is time for it.
//!
//! [`Ecp::accept`] belongs to the servo step and is cheap: counts, signs and ranges. What it lets pass is made the running
//! instruction by the work for the next order.

use super::condition::FromWire;
use super::generator::line_move::Reference;
use super::generator::{Follow, Hold, JointMove, LineMove, MotorMove, PathMove, PoseMove};
use super::tool_motion::{PathSpeeds, ToolMotion};
use super::{Ecp, Programs, Running};
use crate::edp::servo::narrow;
use agent::{Move, MoveIn, Wait};
use motion::Pose;
use motion::profile::AxisLimits;
use nalgebra::Vector3;
use protocol::fault::Refusal;
use protocol::message::{
    AxisSpeeds, Instruction, PoseMessage, PosePath, PoseReference, PoseSpeeds,
};
use robots::Robot;

/// The greatest force a motion can be guarded by, N: beyond the ranges of the sensors.
const GREATEST_FORCE_N: f64 = 1000.0;

/// Speed before homing, as a fraction of the planning ceilings.
const UNSYNCHRONISED_SPEED: f64 = 0.2;

/// An instruction that waits for the next work.
#[derive(Clone, Debug)]
pub(super) struct Accepted {
    instruction: Instruction,
    homed: bool,
}

impl Accepted {
    /// Is it a path, which begins empty?
    pub(super) const fn is_path(&self) -> bool {
        matches!(self.instruction, Instruction::FollowPath { .. })
    }
}

impl<R: Robot<N> + Copy, const N: usize, P: Programs<N>, const W: usize> Ecp<R, N, P, W> {
    /// Take an instruction (R0 checks) in the place of what there was. `homed` decides what may be asked for.
    ///
    /// # Errors
    /// Why it was refused; nothing changed then.
    // a frame of its own: what else its caller does must not lie below it on the stack
    #[inline(never)]
    pub fn accept(&mut self, instruction: &Instruction, homed: bool) -> Result<(), Refusal> {
        let unhomed_ok = matches!(
            instruction,
            Instruction::MoveMotors { relative: true, .. } | Instruction::Hold { .. }
        );
        if !homed && !unhomed_ok {
            return Err(Refusal::NotSynchronised);
        }
        match instruction {
            Instruction::MoveMotors { target, speeds, .. }
            | Instruction::MoveJoints { target, speeds, .. } => {
                axes::<N>(target)?;
                shares::<N>(speeds)?;
            }
            Instruction::MovePose { target, speeds, .. } => {
                self.path_speeds(speeds)?;
                finite_pose(target)?;
            }
            Instruction::MoveUntilForce {
                target,
                speeds,
                newtons,
                ..
            } => {
                bounded(4, *newtons, GREATEST_FORCE_N)?;
                self.path_speeds(speeds)?;
                finite_pose(target)?;
            }
            Instruction::FollowPath { speeds } => self.path_speeds(speeds)?,
            Instruction::Program { program, argument } => {
                finite([argument])?;
                if !self.programs.begin(*program, *argument) {
                    return Err(Refusal::UnknownProgram { program: *program });
                }
            }
            Instruction::Hold { .. } | Instruction::Follow | Instruction::Wait { .. } => {}
        }
        self.accepted = Some(Accepted {
            instruction: instruction.clone(),
            homed,
        });
        Ok(())
    }

    /// The speeds along a path are what the robot may be asked for.
    fn path_speeds(&self, speeds: &PoseSpeeds) -> Result<(), Refusal> {
        let (v, a) = (
            self.limits.cartesian_velocity,
            self.limits.cartesian_acceleration,
        );
        bounded(0, speeds.velocity_m_s, v)?;
        bounded(1, speeds.angular_velocity_rad_s, v)?;
        bounded(2, speeds.acceleration_m_s2, a)?;
        bounded(3, speeds.angular_acceleration_rad_s2, a)
    }

    /// An instruction that has been accepted becomes the running one.
    ///
    /// # Errors
    /// As [`accept`](Self::accept): what that lets pass can be made.
    // a frame of its own: what else its caller does must not lie below it on the stack
    #[inline(never)]
    pub(super) fn take_up(&mut self) -> Result<(), Refusal> {
        if let Some(accepted) = self.accepted.take() {
            self.running = Running::None;
            self.running = self.behaviour(&accepted)?;
        }
        Ok(())
    }

    fn behaviour(&self, accepted: &Accepted) -> Result<Running<R, N, W>, Refusal> {
        Ok(match &accepted.instruction {
            Instruction::Hold { duration_ms } => Running::Hold(Move::new(Hold {
                macrosteps: self.macrosteps(*duration_ms),
            })),
            Instruction::MoveMotors {
                target,
                relative,
                speeds,
            } => {
                let slow = if accepted.homed {
                    1.0
                } else {
                    UNSYNCHRONISED_SPEED
                };
                Running::Motors(Move::new(MotorMove {
                    target: axes(target)?,
                    relative: *relative,
                    limits: scaled(&self.limits.motors, speeds, slow),
                    macrostep_s: self.macrostep_s,
                }))
            }
            Instruction::MoveJoints {
                target,
                relative,
                speeds,
            } => Running::Joints(Move::new(JointMove {
                robot: self.robot,
                motor_share: self.limits.motor_share,
                target: axes(target)?,
                relative: *relative,
                limits: scaled(&self.limits.joints, speeds, 1.0),
                macrostep_s: self.macrostep_s,
            })),
            Instruction::MovePose {
                target,
                reference,
                path,
                speeds,
            } => self.pose_move(target, *reference, *path, speeds),
            // the force is the foreground's, which looks at it in every servo step
            Instruction::MoveUntilForce {
                target,
                reference,
                speeds,
                ..
            } => self.pose_move(target, *reference, PosePath::Line, speeds),
            Instruction::Follow => Running::Follow(Move::new(Follow)),
            Instruction::FollowPath { speeds } => {
                Running::Path(MoveIn::new(PathMove(self.tool_motion(speeds))))
            }
            Instruction::Wait { until, timeout_ms } => Running::Wait {
                wait: Wait::new(FromWire(*until)),
                macrosteps_left: (*timeout_ms > 0).then(|| self.macrosteps(*timeout_ms)),
            },
            // begun already
            Instruction::Program { .. } => Running::Program,
        })
    }

    fn tool_motion(&self, speeds: &PoseSpeeds) -> ToolMotion<R, N> {
        ToolMotion {
            robot: self.robot,
            t_flange_tool: self.t_flange_tool,
            joint_limits: self.limits.joints_anywhere,
            speeds: PathSpeeds {
                velocity_m_s: f64::from(speeds.velocity_m_s),
                angular_velocity_rad_s: f64::from(speeds.angular_velocity_rad_s),
                acceleration_m_s2: f64::from(speeds.acceleration_m_s2),
                angular_acceleration_rad_s2: f64::from(speeds.angular_acceleration_rad_s2),
            },
            macrostep_s: self.macrostep_s,
        }
    }

    fn pose_move(
        &self,
        target: &PoseMessage,
        reference: PoseReference,
        path: PosePath,
        speeds: &PoseSpeeds,
    ) -> Running<R, N, W> {
        let reference = match reference {
            PoseReference::Base => Reference::Base,
            PoseReference::Tool => Reference::Tool,
        };
        let motion = self.tool_motion(speeds);
        let target = of_message(target);
        match path {
            PosePath::Line => Running::Line(MoveIn::new(LineMove {
                motion,
                target,
                reference,
            })),
            PosePath::Joint => {
                let (fv, fa) = (
                    motion.speeds.velocity_m_s / self.limits.cartesian_velocity,
                    motion.speeds.acceleration_m_s2 / self.limits.cartesian_acceleration,
                );
                Running::Pose(Move::new(PoseMove {
                    robot: self.robot,
                    motor_share: self.limits.motor_share,
                    t_flange_tool: self.t_flange_tool,
                    target,
                    reference,
                    limits: self.limits.joints.map(|l| AxisLimits {
                        v: l.v * fv,
                        a: l.a * fa,
                        j: l.j * fa,
                    }),
                    macrostep_s: self.macrostep_s,
                }))
            }
        }
    }

    fn macrosteps(&self, ms: u32) -> u32 {
        let steps = libm::ceil(f64::from(ms) * 1e-3 / self.macrostep_s);
        if steps < 1.0 {
            1
        } else {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "between 1 and 2³² ms / 1 ms; the conversion saturates"
            )]
            let steps = steps as u32;
            steps
        }
    }
}

/// A value for each axis.
fn axes<const N: usize>(values: &[f64]) -> Result<[f64; N], Refusal> {
    let out = <[f64; N]>::try_from(values).map_err(|_| count::<N>(values.len()))?;
    finite(&out)?;
    Ok(out)
}

fn finite<'a>(values: impl IntoIterator<Item = &'a f64>) -> Result<(), Refusal> {
    let found = (0..u8::MAX).zip(values).find(|(_, x)| !x.is_finite());
    found.map_or(Ok(()), |(index, _)| Err(Refusal::NotFinite { index }))
}

fn count<const N: usize>(got: usize) -> Refusal {
    Refusal::AxisCount {
        expected: u8::try_from(N).unwrap_or(u8::MAX),
        got: u8::try_from(got).unwrap_or(u8::MAX),
    }
}

/// Shares in (0, 1] of the limits of each axis.
fn shares<const N: usize>(speeds: &AxisSpeeds) -> Result<(), Refusal> {
    if speeds.velocity.len() != N {
        return Err(count::<N>(speeds.velocity.len()));
    }
    if speeds.acceleration.len() != N {
        return Err(count::<N>(speeds.acceleration.len()));
    }
    let shares = speeds.velocity.iter().zip(&speeds.acceleration);
    for (index, (v, a)) in (0..u8::MAX).zip(shares) {
        bounded(index, *v, 1.0)?;
        bounded(index, *a, 1.0)?;
    }
    Ok(())
}

/// The limits times the shares asked for.
fn scaled<const N: usize>(
    limits: &[AxisLimits; N],
    speeds: &AxisSpeeds,
    slow: f64,
) -> [AxisLimits; N] {
    let mut out = *limits;
    let shares = speeds.velocity.iter().zip(&speeds.acceleration);
    for (l, (v, a)) in out.iter_mut().zip(shares) {
        let (v, a) = (f64::from(*v) * slow, f64::from(*a) * slow);
        *l = AxisLimits {
            v: l.v * v,
            a: l.a * a,
            j: l.j * a,
        };
    }
    out
}

/// A number in (0, upper].
fn bounded(index: u8, value: f32, upper: f64) -> Result<(), Refusal> {
    if !value.is_finite() {
        return Err(Refusal::NotFinite { index });
    }
    let upper = narrow(upper);
    if value > 0.0 && value <= upper * (1.0 + f32::EPSILON) {
        return Ok(());
    }
    Err(Refusal::OutOfRange {
        index,
        value,
        lower: 0.0,
        upper,
    })
}

fn finite_pose(pose: &PoseMessage) -> Result<(), Refusal> {
    finite(pose.position_m.iter().chain(&pose.rotation_rad))
}

fn of_message(pose: &PoseMessage) -> Pose {
    Pose::from_rotation_vector(
        Vector3::from(pose.position_m),
        Vector3::from(pose.rotation_rad),
    )
}

/// A pose of finite numbers.
///
/// # Errors
/// [`Refusal::NotFinite`]
pub(super) fn pose(message: &PoseMessage) -> Result<Pose, Refusal> {
    finite_pose(message)?;
    Ok(of_message(message))
}
