//! Homing.

use crate::mp::command::{Commands, RobotCommand};
use crate::mp::config::Timing;
use crate::mp::failure::{Awaited, Failure};
use crate::mp::robot::Image;
use crate::mp::subsystem::MpSubsystem;
use agent::args::{E, F};
use agent::{Generator, X};
use protocol::message::NodeState;

/// `f^2(c_0, e_c)`: every robot of a list homes the axes that are not homed; all at the same time,
/// each axis after axis in its own order. Ends when all hold, homed.
#[derive(Clone, Debug)]
pub struct Home {
    robots: Vec<usize>,
    timing: Timing,
}

impl Home {
    /// These robots.
    #[must_use]
    pub const fn new(robots: Vec<usize>, timing: Timing) -> Self {
        Self { robots, timing }
    }
}

fn is_home(image: &Image) -> bool {
    image.is_homed() && image.state() == Some(NodeState::Holding) && !image.is_asked()
}

impl Generator<MpSubsystem> for Home {
    /// The instant in which it began.
    type Own = u32;
    type Args = F<(), E, ()>;

    fn first(&self, x: X<'_, MpSubsystem, Self::Args>) -> (u32, Commands) {
        let robots = self
            .robots
            .iter()
            .filter(|robot| x.e().get(**robot).is_some_and(|image| !is_home(image)))
            .map(|robot| (*robot, RobotCommand::Synchronise))
            .collect();
        (
            x.i(),
            Commands {
                robots,
                give_up: None,
            },
        )
    }

    fn next(&self, began: &mut u32, x: X<'_, MpSubsystem, Self::Args>) -> Commands {
        let span_ms = self.timing.home_ms;
        if x.i().saturating_sub(*began) < self.timing.steps(span_ms) {
            return Commands::none();
        }
        let mut late = self.robots.iter().filter_map(|robot| x.e().get(*robot));
        match late.find(|image| !is_home(image)) {
            None => Commands::none(),
            Some(image) => {
                let seen = image
                    .homing()
                    .map_or("no axis begun".to_owned(), |(axis, phase)| {
                        let name = image.axis_name(axis).unwrap_or("?");
                        format!("axis {} ({name}) in {phase:?}", u32::from(axis) + 1)
                    });
                Commands::give_up(Failure::TimedOut {
                    who: image.who(),
                    awaited: Awaited::Homing,
                    span_ms,
                    seen,
                })
            }
        }
    }

    fn terminal(&self, _: &u32, x: X<'_, MpSubsystem, Self::Args>) -> bool {
        self.robots
            .iter()
            .filter_map(|robot| x.e().get(*robot))
            .all(is_home)
    }
}
