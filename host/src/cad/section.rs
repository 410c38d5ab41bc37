//! A program in sections: paths, and what is done between them.

use super::marks::Marks;
use super::place::Place;
use super::step::{Action, What};
use super::{Options, Steps};
use crate::mp::generator::{Elements, PathSource};
use crate::path::{Mark, Reference, streamed};
use motion::Pose;
use protocol::message::PathElement;

/// A section of a program.
#[derive(Clone, Debug)]
pub struct Section {
    /// The line it begins with, from 1.
    pub line: u32,
    /// What it is.
    pub what: Work,
}

/// What a section is.
#[derive(Clone, Debug)]
pub enum Work {
    /// The tool moves.
    Path(Box<PathSection>),
    /// Something is done at rest.
    Action(Action),
}

/// The sections of a program, in order: an iterator.
///
/// To find where a path ends its part of the program is run, without anything being made of it.
#[derive(Clone, Debug)]
pub struct Sections {
    steps: Steps,
    place: Place,
    options: Options,
    /// Is there a path whose moves were not passed by yet?
    within: bool,
}

impl Sections {
    pub(super) const fn new(steps: Steps, place: Place, options: Options) -> Self {
        Self {
            steps,
            place,
            options,
            within: false,
        }
    }
}

impl Iterator for Sections {
    type Item = Section;

    fn next(&mut self) -> Option<Section> {
        let before = self.steps.clone();
        // the first pass found no error, and the second is the same
        let step = loop {
            let step = self.steps.next()?.ok()?;
            if !(self.within && matches!(step.what, What::Move(_))) {
                break step;
            }
        };
        self.within = matches!(step.what, What::Move(_));
        let what = match step.what {
            What::Action(action) => Work::Action(action),
            What::Move(_) => Work::Path(Box::new(PathSection {
                steps: before,
                place: self.place,
                options: self.options,
            })),
        };
        Some(Section {
            line: step.line,
            what,
        })
    }
}

/// A path of a program: its moves up to the next action. It can be gone through any number of times.
#[derive(Clone, Debug)]
pub struct PathSection {
    steps: Steps,
    place: Place,
    options: Options,
}

impl PathSection {
    /// Its elements in the frame of the board, each with its line, and with its feed where that changes:
    /// made one by one.
    #[must_use]
    pub fn marks(&self) -> Marks {
        Marks::new(self.steps.clone(), self.place, self.options)
    }

    /// Its elements for a robot: `t_base_board`, turned as the tool is to be, which keeps its direction.
    #[must_use]
    pub const fn on(self, t_base_board: Pose, rotation: Pose) -> Placed {
        Placed {
            section: self,
            t_base_board,
            rotation,
        }
    }
}

/// A path of a program on a board that is somewhere.
#[derive(Clone, Debug)]
pub struct Placed {
    section: PathSection,
    t_base_board: Pose,
    /// Only its orientation counts.
    rotation: Pose,
}

impl Placed {
    /// Marks in the robot's base frame, to the tool's orientation.
    pub fn marks(&self) -> impl Iterator<Item = Mark> + Send + use<> {
        let (board, rotation) = (self.t_base_board, self.rotation.rotation_vector());
        self.section
            .marks()
            .map(move |mark| mark.on(&board, rotation.into()))
    }
}

impl PathSource for Placed {
    fn elements(&self) -> Elements {
        // every mark says where it is, and how the tool is turned
        let elements = self
            .marks()
            .flat_map(|mark| streamed(&mark, &Pose::identity(), Reference::Base));
        Box::new(elements.chain([PathElement::End]))
    }
}
