//! Several robots, one instruction each, begun in the same servo step.

use crate::mp::command::{Commands, RobotCommand};
use crate::mp::config::Grid;
use crate::mp::subsystem::MpSubsystem;
use agent::args::{E, F};
use agent::{Generator, X};
use protocol::message::{Decision, Instruction, Progress};
use protocol::time::Micros;

/// `f^2(c_0, e_c)`: an instruction for each of a list of robots; ends when all are done.
///
/// Several robots get a common start time so far ahead that requests can be repeated until then;
/// one robot starts at once. If one refuses or fails, `f_E` ends it for all.
#[derive(Clone, Debug)]
pub struct Together {
    items: Vec<(usize, Instruction)>,
    decision: Option<Decision>,
    grid: Grid,
    lead: u32,
    start: Option<u32>,
    follow: bool,
}

impl Together {
    /// These instructions; several start `lead` macrosteps after they are asked for.
    #[must_use]
    pub const fn new(items: Vec<(usize, Instruction)>, grid: Grid, lead: u32) -> Self {
        Self {
            items,
            decision: None,
            grid,
            lead,
            start: None,
            follow: false,
        }
    }

    /// Tight coordination: every robot follows, at once; ends when all of them run.
    #[must_use]
    pub fn follow(robots: &[usize], grid: Grid) -> Self {
        let items = robots
            .iter()
            .map(|robot| (*robot, Instruction::Follow))
            .collect();
        Self {
            items,
            decision: None,
            grid,
            lead: 0,
            start: None,
            follow: true,
        }
    }

    /// Start at this instant: for robots that begin together in different behaviours.
    #[must_use]
    pub const fn starting_at(mut self, i: u32) -> Self {
        self.start = Some(i);
        self
    }

    /// Loose coordination: the decision that goes with it, told to every robot in its cyclic
    /// messages.
    #[must_use]
    pub const fn deciding(mut self, decision: Decision) -> Self {
        self.decision = Some(decision);
        self
    }
}

impl Generator<MpSubsystem> for Together {
    type Own = ();
    type Args = F<(), E, ()>;

    fn first(&self, x: X<'_, MpSubsystem, Self::Args>) -> ((), Commands) {
        let start_at = if let Some(i) = self.start {
            self.grid.at(i)
        } else if self.items.len() > 1 && !self.follow {
            self.grid.at(x.i().saturating_add(self.lead))
        } else {
            Micros(0)
        };
        let decisions = self
            .items
            .iter()
            .filter_map(|(robot, _)| Some((*robot, RobotCommand::Loose(self.decision?))));
        let executes = self.items.iter().map(|(robot, instruction)| {
            let instruction = instruction.clone();
            (
                *robot,
                RobotCommand::Execute {
                    instruction,
                    start_at,
                },
            )
        });
        (
            (),
            Commands {
                robots: decisions.chain(executes).collect(),
                give_up: None,
            },
        )
    }

    fn next(&self, (): &mut (), _: X<'_, MpSubsystem, Self::Args>) -> Commands {
        Commands::none()
    }

    fn terminal(&self, (): &(), x: X<'_, MpSubsystem, Self::Args>) -> bool {
        self.items
            .iter()
            .filter_map(|(robot, _)| x.e().get(*robot))
            .all(|image| {
                match image.progress() {
                    Some(Progress::Done) => true,
                    Some(Progress::Running) => self.follow,
                    // a node may wait for its first knot before it calls itself running
                    Some(Progress::Pending) => self.follow && !image.is_asked(),
                    Some(Progress::Idle | Progress::Failed(_)) | None => false,
                }
            })
    }
}
