//! Paths of a tool: what a path file says, and what becomes of it where the tool is.
//!
//! | module | one line |
//! |---|---|
//! | [`csv`] | points of smooth curves, a line each |
//! | [`course`] | the curve that a node makes of elements, for whoever plans or looks on |
//!
//! A [`ToolPath`] is as written. Where the tool will be is known only to a plan: [`ToolPath::from`]
//! makes the [`Streamed`] elements of it and, with them, their [`Course`].

use core::fmt;
use motion::Pose;
use motion::path::{METRES_PER_RADIAN, SHORTEST_M};
use motion::pose::{exp, log};
use nalgebra::Vector3;
use protocol::fault::PathProblem;
use protocol::message::{Corner, PathElement, PoseMessage};
use std::path::PathBuf;
use std::sync::Arc;

pub mod course;
pub mod csv;
#[cfg(test)]
mod test;

pub use course::{Broken, Course};

/// The most points, or elements, of one path.
pub const MOST_POINTS: usize = 100_000;

/// The largest path file, bytes: 80 for each of [`MOST_POINTS`].
pub const MAX_BYTES: u64 = 8_000_000;

/// A corner in which the tool rests.
pub const SHARP: Corner = Corner {
    metres: 0.0,
    radians: 0.0,
};

/// Where an element leads to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// x, y, z, m.
    pub position_m: [f64; 3],
    /// Rotation vector, rad; absent: as where the path begins.
    pub rotation_rad: Option<[f64; 3]>,
}

/// How the tool gets there from the goal before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Way {
    /// On a smooth curve through this point and its neighbours of the same kind.
    Through,
    /// On a straight line.
    Line {
        /// The corner it begins with.
        corner: Corner,
    },
    /// On a circular arc.
    Arc {
        /// A point on the way, m.
        via_m: [f64; 3],
        /// The corner it begins with.
        corner: Corner,
    },
}

/// One element as written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    /// Its line in the file, from 1.
    pub line: u32,
    /// How to get there.
    pub way: Way,
    /// Where.
    pub to: Goal,
    /// From here on the greatest feed is this, m/s; absent: as before.
    pub feed_m_s: Option<f64>,
}

/// A path as written.
#[derive(Clone, Debug, PartialEq)]
pub struct ToolPath {
    /// The file, if it has one of its own.
    pub file: Option<PathBuf>,
    /// Its elements, in order; at least one.
    pub marks: Vec<Mark>,
}

/// What positions and orientations of a path are relative to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Reference {
    /// Absolute, in the robot's base frame.
    #[default]
    Base,
    /// Offsets from where the tool is, along the axes of the base frame; orientations likewise turn
    /// the tool from where it is about axes of the base frame.
    Start,
}

/// A path from where the tool is, as it is streamed.
#[derive(Clone, Debug, PartialEq)]
pub struct Streamed {
    /// What is sent; the last is [`PathElement::End`].
    pub elements: Arc<[PathElement]>,
    /// The mark of each element but the last.
    pub marks: Vec<usize>,
    /// The curve of the elements.
    pub course: Course,
}

/// Why there is no such path from where the tool is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PathFault {
    /// The mark, counted from 0.
    pub mark: usize,
    /// Why it cannot be.
    pub problem: PathProblem,
}

impl fmt::Display for PathFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(crate::error::text::path_problem(self.problem))
    }
}

/// A line to where the tool is within this, m and rad, is no line: set-points are rounded to units of
/// the drives, and a plan knows a start after relative motions to some µm.
const SAME_M: f64 = 1e-5;
const SAME_RAD: f64 = 1e-4;

impl ToolPath {
    /// The path that begins where the tool is, `t_base_tool`.
    ///
    /// A straight line that leads to where the tool is anyway is left out at the beginning, and so are
    /// points of a curve that repeat the one before: a node takes none of them for a place of its own.
    ///
    /// # Errors
    /// [`PathFault`]: an element that no node would take.
    pub fn from(&self, start: &Pose, reference: Reference) -> Result<Streamed, PathFault> {
        let (mut elements, mut marks) = (Vec::new(), Vec::new());
        let mut last = *start;
        // the feed of marks that are left out holds for the one after them
        let mut feeds = None;
        for (number, mark) in self.marks.iter().enumerate() {
            let to = mark.to.pose(start, reference);
            let (metres, radians) = apart(&last, &to);
            let stays = match mark.way {
                Way::Line { .. } => elements.is_empty() && metres <= SAME_M && radians <= SAME_RAD,
                Way::Through => metres < SHORTEST_M && METRES_PER_RADIAN * radians < SHORTEST_M,
                Way::Arc { .. } => false,
            };
            if stays {
                if let Some(feed) = mark.feed_m_s {
                    feeds = Some(feed);
                }
                continue;
            }
            let mark = &Mark {
                feed_m_s: mark.feed_m_s.or(feeds.take()),
                ..*mark
            };
            last = to;
            for element in streamed(mark, start, reference) {
                marks.push(number);
                elements.push(element);
            }
        }
        if elements.is_empty() {
            let problem = PathProblem::NoLength;
            return Err(PathFault { mark: 0, problem });
        }
        elements.push(PathElement::End);
        let course = Course::new(*start, &elements).map_err(|broken| PathFault {
            mark: marks.get(broken.element).copied().unwrap_or_default(),
            problem: broken.problem,
        })?;
        Ok(Streamed {
            elements: elements.into(),
            marks,
            course,
        })
    }
}

/// What a mark becomes on its way to a node: its feed, if it has one, and where it leads to.
pub(crate) fn streamed(
    mark: &Mark,
    start: &Pose,
    reference: Reference,
) -> impl Iterator<Item = PathElement> + use<> {
    let to = crate::instruct::pose_message(&mark.to.pose(start, reference));
    #[expect(
        clippy::cast_possible_truncation,
        reason = "speeds travel as f32; 24 bits are enough"
    )]
    let feed = mark.feed_m_s.map(|feed| PathElement::Feed {
        metres_per_second: feed as f32,
    });
    let element = match mark.way {
        Way::Through => PathElement::Through(to),
        Way::Line { corner } => PathElement::Line { to, corner },
        Way::Arc { via_m, corner } => PathElement::Arc {
            via_m: reference.position(start, via_m).into(),
            to,
            corner,
        },
    };
    feed.into_iter().chain([element])
}

impl Mark {
    /// A mark on a board that is somewhere, with an orientation (a rotation vector, rad).
    pub(crate) fn on(self, t_base_board: &Pose, rotation_rad: [f64; 3]) -> Self {
        let at = |point: [f64; 3]| -> [f64; 3] {
            let turned = t_base_board.rotation * Vector3::from(point);
            (t_base_board.position + turned).into()
        };
        let way = match self.way {
            Way::Arc { via_m, corner } => Way::Arc {
                via_m: at(via_m),
                corner,
            },
            other => other,
        };
        let to = Goal {
            position_m: at(self.to.position_m),
            rotation_rad: Some(rotation_rad),
        };
        Self { way, to, ..self }
    }
}

impl Reference {
    fn position(self, start: &Pose, written: [f64; 3]) -> Vector3<f64> {
        match self {
            Self::Base => written.into(),
            Self::Start => start.position + Vector3::from(written),
        }
    }
}

impl Goal {
    fn pose(&self, start: &Pose, reference: Reference) -> Pose {
        let rotation = match (self.rotation_rad, reference) {
            (None, _) => start.rotation,
            (Some(turn), Reference::Base) => exp(turn.into()),
            (Some(turn), Reference::Start) => exp(turn.into()) * start.rotation,
        };
        Pose {
            position: reference.position(start, self.position_m),
            rotation,
        }
    }
}

/// A pose that has travelled.
#[must_use]
pub fn pose(message: &PoseMessage) -> Pose {
    Pose::from_rotation_vector(message.position_m.into(), message.rotation_rad.into())
}

/// How far two poses are apart, m and rad.
fn apart(a: &Pose, b: &Pose) -> (f64, f64) {
    let way = b.position - a.position;
    let turn = log(&(b.rotation * a.rotation.transpose()));
    (libm::sqrt(way.dot(&way)), libm::sqrt(turn.dot(&turn)))
}
