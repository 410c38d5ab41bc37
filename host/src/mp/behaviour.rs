//! Building blocks: behaviours of the Master Process, made of its generators and conditions.

use super::command::{Commands, RobotCommand};
use super::condition::{AllAtRest, AllDone, Until};
use super::config::{Grid, Timing};
use super::generator::{Ask, Carry, GetReady, Home, Pace, Readiness, Shadow, Stream, Together};
use super::robot::Image;
use super::subsystem::{BoxedBehaviour, MpSubsystem};
use agent::{Behaviour, Input, List, Move, Rest, Sequence, Step, Then, Wait};
use protocol::message::{Instruction, ServoLaw, StopKind};

/// Behaviours one after another.
#[must_use]
pub fn sequence(parts: Vec<BoxedBehaviour>) -> BoxedBehaviour {
    Box::new(Sequence::new(List(parts)))
}

/// The handshake: who are you, the lease, the drives, torque.
#[must_use]
pub fn get_ready(robots: Vec<usize>, goal: Readiness, timing: Timing) -> BoxedBehaviour {
    Box::new(Move::new(GetReady::new(robots, goal, timing)))
}

/// The handshake with a latched fault acknowledged on the way.
#[must_use]
pub fn recover(robots: Vec<usize>, goal: Readiness, timing: Timing) -> BoxedBehaviour {
    Box::new(Move::new(
        GetReady::new(robots, goal, timing).acknowledging(),
    ))
}

/// Acknowledge the latched faults of robots whose lease we hold.
#[must_use]
pub fn acknowledge(robots: &[usize]) -> BoxedBehaviour {
    Box::new(Move::new(Ask::all(robots, &RobotCommand::Acknowledge)))
}

/// Home every robot of a list; those that are homed stay where they are.
#[must_use]
pub fn home(robots: Vec<usize>, timing: Timing) -> BoxedBehaviour {
    Box::new(Move::new(Home::new(robots, timing)))
}

/// An instruction for each of a list of robots, begun in the same servo step; ends when all are done.
#[must_use]
pub fn execute(items: Vec<(usize, Instruction)>, grid: Grid, timing: &Timing) -> BoxedBehaviour {
    Box::new(Move::new(Together::new(
        items,
        grid,
        timing.start_lead_steps,
    )))
}

/// A robot follows a path that is streamed to its node; ends when it is done.
#[must_use]
pub fn stream(stream: Stream) -> BoxedBehaviour {
    Box::new(Move::new(stream))
}

/// Let time pass until an instant.
#[must_use]
pub fn wait_until(i: u32) -> BoxedBehaviour {
    Box::new(Wait::new(Until { i }))
}

/// Close the loops of a robot by another law.
#[must_use]
pub fn select_servo(robot: usize, law: ServoLaw) -> BoxedBehaviour {
    Box::new(Move::new(Ask::new(vec![(
        robot,
        RobotCommand::SelectServo(law),
    )])))
}

/// Switch digital outputs of a robot at rest.
#[must_use]
pub fn outputs(robot: usize, mask: u16, on: u16) -> BoxedBehaviour {
    Box::new(Move::new(Ask::new(vec![(
        robot,
        RobotCommand::Outputs { mask, on },
    )])))
}

/// Have robots publish their demand every `every`-th servo step; 0 = never.
#[must_use]
pub fn trace(robots: &[usize], every: u16) -> BoxedBehaviour {
    Box::new(Move::new(Ask::all(robots, &RobotCommand::Trace(every))))
}

/// `f**`: begin a program linked into each of a list of nodes; they go on alone.
#[must_use]
pub fn start_programs(robots: &[usize], program: u16, argument: f64) -> BoxedBehaviour {
    let start = RobotCommand::Start { program, argument };
    let robots = robots.iter().map(|robot| (*robot, start.clone())).collect();
    let constant: super::generator::Start = agent::Constant(Commands {
        robots,
        give_up: None,
    });
    Box::new(Move::new(constant))
}

/// Tight coordination: all follow, the object is carried, and the motion is ended.
#[must_use]
pub fn carry<P>(carry: Carry<P>, grid: Grid) -> BoxedBehaviour
where
    P: Pace + 'static,
{
    let robots: Vec<usize> = carry.course().robots().iter().map(|c| c.robot).collect();
    tight(&robots, Box::new(Move::new(carry)), grid)
}

/// Tight coordination by feedback: the leader moves by itself, the follower keeps its place beside
/// the leader's tool.
#[must_use]
pub fn shadow(
    leader: &(usize, Instruction),
    follower: usize,
    grid: Grid,
    timing: &Timing,
) -> BoxedBehaviour {
    let together = in_parallel(vec![
        execute(vec![leader.clone()], grid, timing),
        Box::new(Then::new(
            // the leader's instruction is issued in this very step
            agent::ForSteps::new(1, Rest),
            Move::new(Shadow::new(leader.0, follower, grid, timing)),
        )),
    ]);
    tight(&[follower], together, grid)
}

/// Tight coordination by any behaviour that sends [knots](super::generator::knot): the robots
/// follow, it runs, and the motion is ended.
#[must_use]
pub fn tight(robots: &[usize], knots: BoxedBehaviour, grid: Grid) -> BoxedBehaviour {
    sequence(vec![
        Box::new(Move::new(Together::follow(robots, grid))),
        knots,
        end_motion(robots),
    ])
}

fn end_motion(robots: &[usize]) -> BoxedBehaviour {
    sequence(vec![
        Box::new(Move::new(Ask::all(robots, &RobotCommand::EndMotion))),
        Box::new(Wait::new(AllDone {
            robots: robots.to_vec(),
        })),
    ])
}

/// Stop robots and wait until they are at rest.
#[must_use]
pub fn stop(robots: &[usize], kind: StopKind) -> BoxedBehaviour {
    sequence(vec![
        Box::new(Move::new(Ask::all(robots, &RobotCommand::Stop(kind)))),
        Box::new(Wait::new(AllAtRest {
            robots: robots.to_vec(),
        })),
    ])
}

/// Give the leases back, with torque as it is or off.
#[must_use]
pub fn release(images: &[Image], torque_off: bool) -> BoxedBehaviour {
    let ours: Vec<usize> = images
        .iter()
        .enumerate()
        .filter(|(_, image)| image.epoch().is_some())
        .map(|(robot, _)| robot)
        .collect();
    let under_torque: Vec<usize> = ours
        .iter()
        .copied()
        .filter(|robot| {
            use protocol::message::NodeState::{Holding, Unsynchronised};
            let state = images.get(*robot).and_then(Image::state);
            torque_off && matches!(state, Some(Holding | Unsynchronised))
        })
        .collect();
    sequence(vec![
        Box::new(Move::new(Ask::all(&under_torque, &RobotCommand::Disable))),
        Box::new(Move::new(Ask::all(&ours, &RobotCommand::Release))),
    ])
}

/// Behaviours side by side, for different robots; ends when all have ended.
#[must_use]
pub fn in_parallel(parts: Vec<BoxedBehaviour>) -> BoxedBehaviour {
    let ended = vec![false; parts.len()];
    Box::new(InParallel { parts, ended })
}

struct InParallel {
    parts: Vec<BoxedBehaviour>,
    ended: Vec<bool>,
}

impl Behaviour<MpSubsystem> for InParallel {
    fn begin(&mut self) {
        for (part, ended) in self.parts.iter_mut().zip(&mut self.ended) {
            part.begin();
            *ended = false;
        }
    }

    fn step(&mut self, x: &Input<MpSubsystem>) -> Step<Commands> {
        let mut together: Option<Commands> = None;
        for (part, ended) in self.parts.iter_mut().zip(&mut self.ended) {
            if *ended {
                continue;
            }
            match part.step(x) {
                Step::Done => *ended = true,
                Step::Hold => {}
                Step::Demand(commands) => {
                    together = Some(together.unwrap_or_default().and(commands));
                }
            }
        }
        match together {
            Some(commands) => Step::Demand(commands),
            None if self.ended.iter().all(|ended| *ended) => Step::Done,
            None => Step::Hold,
        }
    }
}
