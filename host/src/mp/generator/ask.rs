//! Ask several robots for something, and wait for every answer.

use crate::mp::command::{Commands, RobotCommand};
use crate::mp::subsystem::MpSubsystem;
use agent::args::{E, F};
use agent::{Generator, X};

/// `f^2(c_0, e_c)`: one command for each of a list of robots; ends when all have answered.
///
/// Refusals and missing answers are found by `f_E`, see [`crate::mp::watch`].
#[derive(Clone, Debug)]
pub struct Ask {
    commands: Vec<(usize, RobotCommand)>,
}

impl Ask {
    /// These commands.
    #[must_use]
    pub const fn new(commands: Vec<(usize, RobotCommand)>) -> Self {
        Self { commands }
    }

    /// The same of each of a list of robots.
    #[must_use]
    pub fn all(robots: &[usize], command: &RobotCommand) -> Self {
        Self {
            commands: robots
                .iter()
                .map(|robot| (*robot, command.clone()))
                .collect(),
        }
    }
}

impl Generator<MpSubsystem> for Ask {
    type Own = ();
    type Args = F<(), E, ()>;

    fn first(&self, _: X<'_, MpSubsystem, Self::Args>) -> ((), Commands) {
        (
            (),
            Commands {
                robots: self.commands.clone(),
                give_up: None,
            },
        )
    }

    fn next(&self, (): &mut (), _: X<'_, MpSubsystem, Self::Args>) -> Commands {
        Commands::none()
    }

    fn terminal(&self, (): &(), x: X<'_, MpSubsystem, Self::Args>) -> bool {
        self.commands
            .iter()
            .filter_map(|(robot, _)| x.e().get(*robot))
            .all(|image| !image.is_asked())
    }
}
