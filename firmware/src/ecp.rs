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
//! `ecp/condition`, an instruction of the wire an arm in `ecp/instruct`; a user's own program
//! implements [`Programs`] and needs none of these.

pub mod agenda;
pub mod census;
pub mod condition;
pub mod generator;
pub mod image;
mod instruct;
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
use generator::{Follow, Hold, JointMove, LineMove, MotorMove, PathMove, PoseMove};
use instruct::Accepted;
use motion::Pose;
use motion::interpolator::PathLimits;
use motion::profile::AxisLimits;
use own_frame::{one_step, one_step_in};
use protocol::fault::Refusal;
use protocol::message::{Coordination, KnotMessage, PoseMessage};
use robots::{Motors, Robot};
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
/// A program is started by [`Instruction::Program`](protocol::message::Instruction::Program) and stepped once per macrostep.
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
    /// What will be the running instruction with the next work.
    accepted: Option<Accepted>,
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
            accepted: None,
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
        self.t_flange_tool = instruct::pose(t_flange_tool)?;
        Ok(())
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
        let room = match (&self.accepted, &self.running) {
            // the first step begins with an empty path
            (Some(accepted), _) if accepted.is_path() => elements,
            (None, Running::Path(_)) => self.tool_path.room().min(elements),
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
        if let Err(refusal) = self.take_up() {
            self.plan.verdict = Verdict::Failed(refusal);
            return;
        }
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
}
