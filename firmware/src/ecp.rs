//! The Effector Control Process: `C_j` without its servos.
//!
//! Once per macrostep it takes what the coordinator said (`c_0`), the image of the effector
//! (`e_j`) and the virtual sensors' readings (`v_j`), makes one step of the running instruction,
//! and gives the EDP the motion state to be attained next. No clock, no bus: time is an argument.
//!
//! It has two sides. The [`agenda`] is what it has been told; it belongs to the servo step and answers at
//! once. [`Ecp`] is the work itself, which may take as long as eight of the ten servo steps of a macrostep: it is given an order, works,
//! and has a plan, and in between nobody looks at it. So it may be preempted by servo steps.
//!
//! Where to add: a generator is a file in `ecp/generator`, a condition a type in
//! `ecp/condition`, an instruction of the wire an arm in [`Ecp::accept`]; a user's own program
//! implements [`Programs`] and needs none of these.

pub mod agenda;
pub mod census;
pub mod condition;
pub mod generator;
pub mod image;
mod own_frame;
mod path_feed;
pub mod plan;
pub mod refusal;
pub mod tool_motion;
pub mod tool_path;
pub use image::{Coordinator, Demand, EffectorAtMotors, EffectorImage, Sensors};
pub use plan::{Ahead, Plan, PlannedPiece, Verdict};

use crate::capacity::{KNOTS_PER_PLAN, path_per_macrostep};
use crate::edp::envelopes::envelopes;
use agenda::Agenda;
use agent::{Behaviour, Input, Move, MoveIn, Step, Subsystem, Wait, args};
use condition::FromWire;
use generator::axis_move::{Course, MotorShare};
use generator::follow::Followed;
use generator::line_move::Reference;
use generator::{Follow, Hold, JointMove, LineMove, MotorMove, PathMove, PoseMove};
use motion::Pose;
use motion::interpolator::PathLimits;
use motion::profile::AxisLimits;
use nalgebra::Vector3;
use own_frame::{one_step, one_step_in};
use protocol::fault::Refusal;
use protocol::message::{
    AxisSpeeds, Coordination, Instruction, KnotMessage, PoseMessage, PosePath, PoseReference,
    PoseSpeeds,
};
use robots::{Motors, Robot};
use tool_motion::{PathSpeeds, ToolMotion};
use tool_path::ToolPath;

/// The subsystem `C_j` of a robot with N axes, as the formalism sees it.
#[derive(Clone, Copy, Debug)]
pub enum EcpOf<const N: usize> {}

impl<const N: usize> Subsystem for EcpOf<N> {
    type Level = args::Executor;
    type Coordination = Coordinator;
    type Effector = EffectorImage<N>;
    type Sensors = Sensors<N>;
    type Transmissions = ();
    type Command = Demand<N>;
}

/// Programs of the user, linked into the node: behaviours made of their own generators.
///
/// A program is started by [`Instruction::Program`] and stepped once per macrostep.
pub trait Programs<const N: usize> {
    /// Start program `program`; `false` if there is none of that number.
    fn begin(&mut self, program: u16, argument: f64) -> bool;
    /// One step of the program begun last.
    fn step(&mut self, x: &Input<EcpOf<N>>) -> Step<Demand<N>>;
    /// `f_E` of the running program: `true` ends it as an error, whatever else holds in that step.
    fn error(&self, x: &Input<EcpOf<N>>) -> bool {
        let _ = x;
        false
    }
}

/// No programs but the built-in instructions.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoPrograms;

impl<const N: usize> Programs<N> for NoPrograms {
    fn begin(&mut self, _: u16, _: f64) -> bool {
        false
    }
    fn step(&mut self, _: &Input<EcpOf<N>>) -> Step<Demand<N>> {
        Step::Done
    }
}

/// One program, number 1: this behaviour.
#[derive(Clone, Copy, Debug)]
pub struct OneProgram<B>(pub B);

impl<B: Behaviour<EcpOf<N>>, const N: usize> Programs<N> for OneProgram<B> {
    fn begin(&mut self, program: u16, _: f64) -> bool {
        let known = program == 1;
        if known {
            self.0.begin();
        }
        known
    }
    fn step(&mut self, x: &Input<EcpOf<N>>) -> Step<Demand<N>> {
        self.0.step(x)
    }
}

/// The running instruction.
#[derive(Debug)]
enum Running<R, const N: usize, const W: usize> {
    None,
    Hold(Move<Hold, u32>),
    Motors(Move<MotorMove<N>, Course<N>>),
    Joints(Move<JointMove<R, N>, Course<N>>),
    Pose(Move<PoseMove<R, N>, Course<N>>),
    Line(MoveIn<LineMove<R, N, W>>),
    Follow(Move<Follow, Followed>),
    Path(MoveIn<PathMove<R, N, W>>),
    Wait {
        wait: Wait<FromWire>,
        macrosteps_left: Option<u32>,
    },
    Program,
}

/// What the ECP knows of its robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits<const N: usize> {
    /// What a plan may ask of the motors.
    pub motors: [AxisLimits; N],
    /// What a plan may ask of the joints; the motors may bear less.
    pub joints: [AxisLimits; N],
    /// What the motors bear whatever the other joints do: for ways that are not straight in joint
    /// space.
    pub joints_anywhere: [AxisLimits; N],
    /// How far the motors may be used on a straight line in joint space.
    pub motor_share: MotorShare,
    /// m/s and rad/s.
    pub cartesian_velocity: f64,
    /// m/s² and rad/s².
    pub cartesian_acceleration: f64,
}

/// The ECP of one robot, which looks at W samples of a path.
#[derive(Debug)]
pub struct Ecp<R, const N: usize, P, const W: usize> {
    robot: R,
    limits: Limits<N>,
    macrostep_s: f64,
    t_flange_tool: Pose,
    programs: P,
    running: Running<R, N, W>,
    /// The path of the running instruction, if it has one; it is too large to travel by value.
    tool_path: ToolPath<N, W>,
    /// What the step is to be made of, in its place: large too.
    input: Input<EcpOf<N>>,
    /// The set-point queue at the order.
    ahead: Ahead<N>,
    homed: bool,
    /// Knots of tight coordination that this step takes beside the one that it begins with.
    knots: heapless::Deque<KnotMessage, KNOTS_PER_PLAN>,
    plan: Plan<N>,
}

impl<R: Robot<N> + Copy, const N: usize, P: Programs<N>, const W: usize> Ecp<R, N, P, W> {
    /// An ECP with nothing to do.
    #[expect(
        clippy::inline_always,
        reason = "so that what is large is made where it stays, and not on the stack"
    )]
    #[inline(always)]
    pub fn new(robot: R, limits: Limits<N>, macrostep_s: f64, programs: P) -> Self {
        Self {
            robot,
            limits,
            macrostep_s,
            t_flange_tool: robot.description().default_tool(),
            programs,
            running: Running::None,
            tool_path: ToolPath::new(),
            input: Input {
                i: 0,
                c0: Coordinator {
                    says: Coordination::None,
                    end_motion: false,
                    path: heapless::Vec::new(),
                    feed_override: 1.0,
                },
                e: EffectorImage {
                    motors: Motors([0.0; N]),
                    joints: None,
                    demanded_motors: Motors([0.0; N]),
                    demanded_joints: None,
                    following_error: [0.0; N],
                },
                v: Sensors::NONE,
                t: (),
            },
            ahead: Ahead::nothing(),
            homed: false,
            knots: heapless::Deque::new(),
            plan: Plan::new(),
        }
    }

    /// `t_flange_tool`
    pub const fn tool(&self) -> &Pose {
        &self.t_flange_tool
    }

    /// Change the tool.
    ///
    /// # Errors
    /// [`Refusal::NotFinite`]
    pub fn set_tool(&mut self, t_flange_tool: &PoseMessage) -> Result<(), Refusal> {
        self.t_flange_tool = pose(t_flange_tool)?;
        Ok(())
    }

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
        self.running = match instruction {
            Instruction::Hold { duration_ms } => Running::Hold(Move::new(Hold {
                macrosteps: self.macrosteps(*duration_ms),
            })),
            Instruction::MoveMotors {
                target,
                relative,
                speeds,
            } => {
                let slow = if homed { 1.0 } else { UNSYNCHRONISED_SPEED };
                Running::Motors(Move::new(MotorMove {
                    target: axes(target)?,
                    relative: *relative,
                    limits: scaled(&self.limits.motors, speeds, slow)?,
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
                limits: scaled(&self.limits.joints, speeds, 1.0)?,
                macrostep_s: self.macrostep_s,
            })),
            Instruction::MovePose {
                target,
                reference,
                path,
                speeds,
            } => self.pose_move(target, *reference, *path, speeds)?,
            Instruction::MoveUntilForce {
                target,
                reference,
                speeds,
                newtons,
            } => {
                // the force is the foreground's, which looks at it in every servo step
                bounded(4, *newtons, GREATEST_FORCE_N)?;
                self.pose_move(target, *reference, PosePath::Line, speeds)?
            }
            Instruction::Follow => Running::Follow(Move::new(Follow)),
            Instruction::FollowPath { speeds } => {
                Running::Path(MoveIn::new(PathMove(self.tool_motion(speeds)?)))
            }
            Instruction::Wait { until, timeout_ms } => Running::Wait {
                wait: Wait::new(FromWire(*until)),
                macrosteps_left: (*timeout_ms > 0).then(|| self.macrosteps(*timeout_ms)),
            },
            Instruction::Program { program, argument } => {
                if !argument.is_finite() {
                    return Err(Refusal::NotFinite { index: 0 });
                }
                if !self.programs.begin(*program, *argument) {
                    return Err(Refusal::UnknownProgram { program: *program });
                }
                Running::Program
            }
        };
        Ok(())
    }

    fn tool_motion(&self, speeds: &PoseSpeeds) -> Result<ToolMotion<R, N>, Refusal> {
        let (v, a) = (
            self.limits.cartesian_velocity,
            self.limits.cartesian_acceleration,
        );
        Ok(ToolMotion {
            robot: self.robot,
            t_flange_tool: self.t_flange_tool,
            joint_limits: self.limits.joints_anywhere,
            speeds: PathSpeeds {
                velocity_m_s: bounded(0, speeds.velocity_m_s, v)?,
                angular_velocity_rad_s: bounded(1, speeds.angular_velocity_rad_s, v)?,
                acceleration_m_s2: bounded(2, speeds.acceleration_m_s2, a)?,
                angular_acceleration_rad_s2: bounded(3, speeds.angular_acceleration_rad_s2, a)?,
            },
            macrostep_s: self.macrostep_s,
        })
    }

    fn pose_move(
        &self,
        target: &PoseMessage,
        reference: PoseReference,
        path: PosePath,
        speeds: &PoseSpeeds,
    ) -> Result<Running<R, N, W>, Refusal> {
        let reference = match reference {
            PoseReference::Base => Reference::Base,
            PoseReference::Tool => Reference::Tool,
        };
        let motion = self.tool_motion(speeds)?;
        let target = pose(target)?;
        Ok(match path {
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
        })
    }

    /// The order to make a step: what was said until now, the image and the readings of now, and what its plan will be
    /// ahead of. The joints are found where there is time for it.
    // a frame of its own: what else its caller does must not lie below it on the stack
    #[inline(never)]
    pub fn order(
        &mut self,
        agenda: &mut Agenda,
        e: &EffectorAtMotors<N>,
        v: Sensors<N>,
        ahead: Ahead<N>,
    ) {
        let Coordinator {
            says,
            end_motion,
            path,
            feed_override,
        } = &mut self.input.c0;
        self.knots.clear();
        *says = match agenda.take_knot() {
            Some(knot) => {
                for _ in 1..KNOTS_PER_PLAN {
                    let Some(knot) = agenda.take_knot() else {
                        break;
                    };
                    let _ = self.knots.push_back(knot);
                }
                Coordination::Tight(knot)
            }
            None => agenda
                .decision()
                .map_or(Coordination::None, Coordination::Loose),
        };
        *end_motion = agenda.motion_ends();
        *feed_override = agenda.feed_override();
        let (elements, _) = path_per_macrostep(W);
        let room = match &self.running {
            Running::Path(running) if running.runs() => self.tool_path.room().min(elements),
            // the first step begins with an empty path
            Running::Path(_) => elements,
            _ => 0,
        };
        agenda.take_path(room, path);
        let image = &mut self.input.e;
        image.motors = e.motors;
        image.demanded_motors = e.demanded_motors;
        image.following_error = e.following_error;
        self.homed = e.homed;
        self.ahead = ahead;
        self.input.v = v;
    }

    /// Does what was ordered: a step of the instruction or, under tight coordination, one for each knot of the
    /// order. The [plan](Self::plan) is what came of it.
    // a frame of its own: what else its caller does must not lie below it on the stack
    #[inline(never)]
    pub fn work(&mut self) {
        self.plan.clear();
        let Input { e, .. } = &mut self.input;
        let joints = |m: &Motors<N>| self.homed.then(|| self.robot.joints(m).ok()).flatten();
        e.joints = joints(&e.motors);
        e.demanded_joints = joints(&e.demanded_motors);
        let factor = self.limits.motor_share.factor.value();
        let envelopes = envelopes(self.robot.description(), factor, self.ahead.homed);
        let Ok(path) = PathLimits::new(envelopes) else {
            // a setup with such limits is refused
            self.plan.verdict = Verdict::Failed(Refusal::Unreachable);
            return;
        };
        for _ in 0..KNOTS_PER_PLAN {
            self.plan.verdict = self.step(&path);
            if self.plan.verdict != Verdict::Goes {
                self.running = Running::None;
                return;
            }
            let Some(knot) = self.knots.pop_front() else {
                return;
            };
            self.input.c0.says = Coordination::Tight(knot);
        }
    }

    /// What the last work came to.
    pub const fn plan(&self) -> &Plan<N> {
        &self.plan
    }

    fn step(&mut self, path: &PathLimits<N>) -> Verdict {
        self.input.i = self.input.i.wrapping_add(1);
        let x = &self.input;
        let step = match &mut self.running {
            Running::None => return Verdict::Goes,
            Running::Hold(b) => one_step(b, x),
            Running::Motors(b) => one_step(b, x),
            Running::Joints(b) => one_step(b, x),
            Running::Pose(b) => one_step(b, x),
            Running::Line(b) => one_step_in(b, &mut self.tool_path, x),
            Running::Follow(b) => one_step(b, x),
            Running::Path(b) => one_step_in(b, &mut self.tool_path, x),
            Running::Wait {
                wait,
                macrosteps_left,
            } => {
                let step = wait.step(x);
                match macrosteps_left {
                    Some(0) if step != Step::Done => {
                        return Verdict::Failed(Refusal::Late);
                    }
                    Some(left) => *left = left.saturating_sub(1),
                    None => {}
                }
                step
            }
            Running::Program => {
                // f_E comes first and wins over f_T ([Z1] (4), (5))
                if self.programs.error(x) {
                    return Verdict::Error;
                }
                self.programs.step(x)
            }
        };
        match step {
            Step::Demand(demand) => match self.plan.add(&self.robot, path, &self.ahead, &demand) {
                Ok(()) => Verdict::Goes,
                Err(refusal) => Verdict::Failed(refusal),
            },
            Step::Hold => Verdict::Goes,
            Step::Done => Verdict::Ended,
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

/// The greatest force a motion can be guarded by, N: beyond the ranges of the sensors.
const GREATEST_FORCE_N: f64 = 1000.0;

/// Speed before homing, as a fraction of the planning ceilings.
pub const UNSYNCHRONISED_SPEED: f64 = 0.2;

fn axes<const N: usize>(values: &[f64]) -> Result<[f64; N], Refusal> {
    let out = <[f64; N]>::try_from(values).map_err(|_| count::<N>(values.len()))?;
    for (k, value) in (0..N).zip(&out) {
        if !value.is_finite() {
            return Err(Refusal::NotFinite {
                index: u8::try_from(k).unwrap_or(u8::MAX),
            });
        }
    }
    Ok(out)
}

fn count<const N: usize>(got: usize) -> Refusal {
    Refusal::AxisCount {
        expected: u8::try_from(N).unwrap_or(u8::MAX),
        got: u8::try_from(got).unwrap_or(u8::MAX),
    }
}

/// The limits times the fractions asked for.
fn scaled<const N: usize>(
    limits: &[AxisLimits; N],
    speeds: &AxisSpeeds,
    slow: f64,
) -> Result<[AxisLimits; N], Refusal> {
    if speeds.velocity.len() != N {
        return Err(count::<N>(speeds.velocity.len()));
    }
    if speeds.acceleration.len() != N {
        return Err(count::<N>(speeds.acceleration.len()));
    }
    let mut out = *limits;
    for (k, ((l, v), a)) in (0..N).zip(
        out.iter_mut()
            .zip(&speeds.velocity)
            .zip(&speeds.acceleration),
    ) {
        let index = u8::try_from(k).unwrap_or(u8::MAX);
        let (v, a) = (
            bounded(index, *v, 1.0)? * slow,
            bounded(index, *a, 1.0)? * slow,
        );
        *l = AxisLimits {
            v: l.v * v,
            a: l.a * a,
            j: l.j * a,
        };
    }
    Ok(out)
}

/// A speed in (0, upper].
fn bounded(index: u8, value: f32, upper: f64) -> Result<f64, Refusal> {
    if !value.is_finite() {
        return Err(Refusal::NotFinite { index });
    }
    if value > 0.0 && f64::from(value) <= upper * (1.0 + f64::from(f32::EPSILON)) {
        Ok(f64::from(value))
    } else {
        #[expect(clippy::cast_possible_truncation, reason = "for the message")]
        let upper = upper as f32;
        Err(Refusal::OutOfRange {
            index,
            value,
            lower: 0.0,
            upper,
        })
    }
}

fn pose(message: &PoseMessage) -> Result<Pose, Refusal> {
    let all = message.position_m.iter().chain(&message.rotation_rad);
    for (index, value) in (0..u8::MAX).zip(all) {
        if !value.is_finite() {
            return Err(Refusal::NotFinite { index });
        }
    }
    Ok(Pose::from_rotation_vector(
        Vector3::from(message.position_m),
        Vector3::from(message.rotation_rad),
    ))
}
