//! The Effector Control Process: `C_j` without its servos.
//!
//! Once per macrostep it takes what the coordinator said (`c_0`), the image of the effector
//! (`e_j`) and the virtual sensors' readings (`v_j`), makes one step of the running instruction,
//! and gives the EDP the motion state to be attained next. No clock, no bus: time is an argument.
//!
//! Where to add: a generator is a file in `ecp/generator`, a condition a type in
//! `ecp/condition`, an instruction of the wire an arm in [`Ecp::accept`]; a user's own program
//! implements [`Programs`] and needs none of these.

pub mod census;
pub mod condition;
pub mod generator;
pub mod image;
mod own_frame;
mod path_feed;
mod path_stream;
pub mod refusal;
pub mod tool_motion;
pub mod tool_path;
pub use image::{Coordinator, Demand, EffectorImage, Sensors};

use crate::capacity::{KNOT_INBOX, PATH_INBOX};
use agent::{Behaviour, Input, Move, MoveIn, Step, Subsystem, Wait, args};
use condition::FromWire;
use generator::axis_move::{Course, MotorShare};
use generator::follow::Followed;
use generator::line_move::Reference;
use generator::{Follow, Hold, JointMove, LineMove, MotorMove, PathMove, PoseMove};
use motion::Pose;
use motion::profile::AxisLimits;
use nalgebra::Vector3;
use own_frame::{one_step, one_step_in};
use protocol::fault::Refusal;
use protocol::message::{
    AxisSpeeds, Coordination, Decision, Instruction, KnotMessage, PathElement, PoseMessage,
    PosePath, PoseReference, PoseSpeeds, Progress,
};
use protocol::time::Micros;
use robots::Robot;
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

/// What one macrostep of the ECP results in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome<const N: usize> {
    /// Nothing is running, or it waits for its start time.
    Idle,
    /// The instruction begins with this step.
    Demand(Demand<N>),
    /// The instruction is complete.
    Ended,
    /// The instruction cannot go on.
    Failed(Refusal),
    /// `f_E` holds: an error, even if the terminal condition holds too.
    Error,
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
    start_at: Micros,
    id: u32,
    progress: Progress,
    decision: Option<Decision>,
    inbox: heapless::Deque<KnotMessage, KNOT_INBOX>,
    end_motion: bool,
    /// Elements of a path that wait to be taken, and the number of the one wanted next.
    path: heapless::Deque<PathElement, PATH_INBOX>,
    path_next: u32,
    feed_override: f64,
    i: u32,
}

impl<R: Robot<N> + Copy, const N: usize, P: Programs<N>, const W: usize> Ecp<R, N, P, W> {
    /// An ECP with nothing to do.
    pub fn new(robot: R, limits: Limits<N>, macrostep_s: f64, programs: P) -> Self {
        Self {
            robot,
            limits,
            macrostep_s,
            t_flange_tool: robot.description().default_tool(),
            programs,
            running: Running::None,
            tool_path: ToolPath::new(),
            start_at: Micros(0),
            id: 0,
            progress: Progress::Idle,
            decision: None,
            inbox: heapless::Deque::new(),
            end_motion: false,
            path: heapless::Deque::new(),
            path_next: 0,
            feed_override: 1.0,
            i: 0,
        }
    }

    /// The latest instruction and how far it is.
    pub const fn progress(&self) -> (u32, Progress) {
        (self.id, self.progress)
    }

    /// Is an instruction running or waiting for its start?
    pub const fn busy(&self) -> bool {
        !matches!(self.running, Running::None)
    }

    /// Does the running instruction take its knots from the coordinator?
    pub const fn follows(&self) -> bool {
        matches!(self.running, Running::Follow(_))
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

    /// A new epoch: forget the last one's instruction.
    pub fn forget(&mut self) {
        self.abort();
        self.id = 0;
        self.progress = Progress::Idle;
        self.decision = None;
    }

    /// What the coordinator says in its cyclic message.
    ///
    /// # Errors
    /// [`Refusal::QueueFull`] when knots come faster than they are consumed.
    pub fn coordinate(&mut self, says: &Coordination) -> Result<(), Refusal> {
        match says {
            Coordination::Loose(decision) => {
                self.decision = Some(*decision);
                Ok(())
            }
            Coordination::Tight(knot) if self.follows() => self
                .inbox
                .push_back(knot.clone())
                .map_err(|_| Refusal::QueueFull),
            Coordination::None | Coordination::Tight(_) => Ok(()),
        }
    }

    /// Take an instruction (R0 checks). `homed` decides what may be asked for.
    ///
    /// # Errors
    /// Why it was refused; nothing changed then.
    pub fn accept(
        &mut self,
        id: u32,
        start_at: Micros,
        instruction: &Instruction,
        homed: bool,
    ) -> Result<(), Refusal> {
        let unhomed_ok = matches!(
            instruction,
            Instruction::MoveMotors { relative: true, .. } | Instruction::Hold { .. }
        );
        if !homed && !unhomed_ok {
            return Err(Refusal::NotSynchronised);
        }
        let running = match instruction {
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
        self.running = running;
        self.id = id;
        self.start_at = start_at;
        self.progress = Progress::Pending;
        self.clear_streams();
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

    /// The coordinator ends the motion.
    pub const fn end_motion(&mut self) {
        self.end_motion = true;
    }

    /// The instruction ends here, because of a stop or a fault.
    pub fn abort(&mut self) {
        if self.busy() {
            self.progress = Progress::Failed(Refusal::Aborted);
        }
        self.running = Running::None;
        self.clear_streams();
    }

    /// One macrostep. Under tight coordination it is called again in the same macrostep while
    /// [`Ecp::more`] says that knots wait.
    // a frame of its own: what else its caller does must not lie below it on the stack
    #[inline(never)]
    pub fn step(&mut self, now: Micros, e: EffectorImage<N>, v: Sensors<N>) -> Outcome<N> {
        if !self.busy() || now < self.start_at {
            return Outcome::Idle;
        }
        self.i = self.i.wrapping_add(1);
        let says = match self.inbox.pop_front() {
            Some(knot) => Coordination::Tight(knot),
            None => self
                .decision
                .map_or(Coordination::None, Coordination::Loose),
        };
        let c0 = Coordinator {
            says,
            end_motion: self.end_motion,
            path: self.path_elements(),
            feed_override: self.feed_override,
        };
        let x = Input {
            i: self.i,
            c0,
            e,
            v,
            t: (),
        };
        let step = match &mut self.running {
            Running::None => return Outcome::Idle,
            Running::Hold(b) => one_step(b, &x),
            Running::Motors(b) => one_step(b, &x),
            Running::Joints(b) => one_step(b, &x),
            Running::Pose(b) => one_step(b, &x),
            Running::Line(b) => one_step_in(b, &mut self.tool_path, &x),
            Running::Follow(b) => one_step(b, &x),
            Running::Path(b) => one_step_in(b, &mut self.tool_path, &x),
            Running::Wait {
                wait,
                macrosteps_left,
            } => {
                let step = wait.step(&x);
                match macrosteps_left {
                    Some(0) if step != Step::Done => {
                        return self.fail(Refusal::Late);
                    }
                    Some(left) => *left = left.saturating_sub(1),
                    None => {}
                }
                step
            }
            Running::Program => {
                // f_E comes first and wins over f_T ([Z1] (4), (5))
                if self.programs.error(&x) {
                    self.abort();
                    return Outcome::Error;
                }
                self.programs.step(&x)
            }
        };
        self.progress = Progress::Running;
        match step {
            Step::Demand(Demand::Refuse(refusal)) => self.fail(refusal),
            Step::Demand(demand) => Outcome::Demand(demand),
            Step::Hold => Outcome::Demand(Demand::Stay),
            Step::Done => {
                self.running = Running::None;
                Outcome::Ended
            }
        }
    }

    /// Do knots of tight coordination wait to be taken?
    pub fn more(&self) -> bool {
        !self.inbox.is_empty()
    }

    /// The arm has come to rest after the instruction ended: it is complete.
    pub fn complete(&mut self) {
        if self.progress == Progress::Running || self.progress == Progress::Pending {
            self.progress = Progress::Done;
        }
    }

    /// The EDP refused what the instruction demands.
    pub fn fail(&mut self, refusal: Refusal) -> Outcome<N> {
        self.abort();
        self.progress = Progress::Failed(refusal);
        Outcome::Failed(refusal)
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

/// Speed before homing, as a fraction of the planning ceilings.
pub const UNSYNCHRONISED_SPEED: f64 = 0.2;

fn axes<const N: usize>(values: &[f64]) -> Result<[f64; N], Refusal> {
    let out = <[f64; N]>::try_from(values).map_err(|_| count::<N>(values.len()))?;
    for (k, value) in out.iter().enumerate() {
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
