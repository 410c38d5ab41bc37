//! A path that is streamed to one node, as fast as the node wants it.

use super::window::{PathSource, Window};
use crate::mp::command::{Commands, RobotCommand};
use crate::mp::robot::{Image, PathWanted};
use crate::mp::subsystem::MpSubsystem;
use agent::args::{E, F};
use agent::{Generator, X};
use protocol::message::{Instruction, PATH_BATCH, PoseSpeeds, Progress};
use protocol::time::Micros;
use std::sync::Arc;

/// Macrosteps between two questions for room while there was none.
const ASK_AGAIN_STEPS: u32 = 3;

/// `f^2(c_0, e_c)`: `FollowPath` on one robot, and its elements while it runs; ends when it is done.
///
/// Nothing is assumed of what the node has: every request begins with the element that the node said it
/// wants next, be it one that was sent already, and brings no more than it had room for. So a lost
/// answer costs a repetition and nothing else. Elements are made when they are wanted, and not kept for
/// long: a path may be longer than memory. One request is on its way at a time; an override that
/// is due goes before elements. If the node refuses an element, `f_E` ends it.
#[derive(Clone, Debug)]
pub struct Stream {
    robot: usize,
    speeds: PoseSpeeds,
    source: Arc<dyn PathSource>,
    overrides: Vec<(u32, f32)>,
}

/// What a stream remembers between macrosteps.
#[derive(Debug)]
pub struct Streaming {
    window: Window,
    /// The instant in which the path began to run.
    began: Option<u32>,
    /// The instant of the latest request for the path.
    asked: Option<u32>,
    /// Overrides that were sent.
    overridden: usize,
}

impl Stream {
    /// The elements of a source, the last of which is [`End`](protocol::message::PathElement::End):
    /// without it the node waits for more.
    #[must_use]
    pub fn new(robot: usize, speeds: PoseSpeeds, source: impl PathSource + 'static) -> Self {
        Self {
            robot,
            speeds,
            source: Arc::new(source),
            overrides: Vec::new(),
        }
    }

    /// Shares of the programmed feed (-1 to 1), each from so many macrosteps on after the path began
    /// to run, in the order of time. What is not due before the path is done is not sent.
    #[must_use]
    pub fn overriding(mut self, overrides: Vec<(u32, f32)>) -> Self {
        self.overrides = overrides;
        self
    }

    /// The elements the node wants, or a question for room if it is time for that.
    fn more(&self, state: &mut Streaming, i: u32, image: &Image) -> Commands {
        // before its first answer nothing is known of the node's room
        let PathWanted { next, room } = image.path().unwrap_or(PathWanted { next: 0, room: 0 });
        if state.window.get(next).is_none() {
            return Commands::none();
        }
        let elements: heapless::Vec<_, _> = (next..)
            .take(usize::from(room).min(PATH_BATCH))
            .map_while(|number| state.window.get(number))
            .collect();
        let again = state
            .asked
            .is_none_or(|asked| i.saturating_sub(asked) >= ASK_AGAIN_STEPS);
        if elements.is_empty() && !again {
            return Commands::none();
        }
        state.asked = Some(i);
        let first = next;
        Commands::one(self.robot, RobotCommand::Path { first, elements })
    }
}

impl Generator<MpSubsystem> for Stream {
    type Own = Streaming;
    type Args = F<(), E, ()>;

    fn first(&self, _: X<'_, MpSubsystem, Self::Args>) -> (Streaming, Commands) {
        let follow = RobotCommand::Execute {
            instruction: Instruction::FollowPath {
                speeds: self.speeds,
            },
            start_at: Micros(0),
        };
        let streaming = Streaming {
            window: Window::new(&self.source),
            began: None,
            asked: None,
            overridden: 0,
        };
        (streaming, Commands::one(self.robot, follow))
    }

    fn next(&self, state: &mut Streaming, x: X<'_, MpSubsystem, Self::Args>) -> Commands {
        let Some(image) = x.e().get(self.robot) else {
            return Commands::none();
        };
        if image.is_asked() || image.progress() != Some(Progress::Running) {
            return Commands::none();
        }
        let began = *state.began.get_or_insert(x.i());
        if let Some((steps, share)) = self.overrides.get(state.overridden)
            && x.i().saturating_sub(began) >= *steps
        {
            state.overridden += 1;
            return Commands::one(self.robot, RobotCommand::FeedOverride(*share));
        }
        self.more(state, x.i(), image)
    }

    fn terminal(&self, _: &Streaming, x: X<'_, MpSubsystem, Self::Args>) -> bool {
        // a node is done only when it has taken the last element
        x.e()
            .get(self.robot)
            .is_none_or(|image| !image.is_asked() && image.progress() == Some(Progress::Done))
    }
}
