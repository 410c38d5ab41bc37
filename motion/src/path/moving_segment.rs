//! A smooth curve through points that come one by one: a segment of eight points moves along.
//!
//! After \[Z1\], section I: "a series of B-spline curves spanning eight point segments", of which "only the
//! curve between the middle (4th and 5th) points is utilised", then "the segment is shifted by one point".
//! Taken literally, two neighbouring segments disagree slightly about velocity and curvature at the point
//! where one follows the other. Here they agree: at each point the first and second derivative come from
//! the cubic B-spline through seven points, itself and three on either side; the span between two points
//! is the quintic that has the derivatives of both. It depends on the same eight points.

use super::window::{self, Knot, Value};
use super::{PathPoint, Quintic, SHORTEST_M, extent, is_finite};
use crate::pose::{Pose, log};
use crate::twist::Twist;
use core::fmt;
use nalgebra::Vector3;

/// Points on either side of the one whose derivatives are found.
const SIDE: usize = 3;
/// Neighbouring points differ by at most this angle, rad, so that no point of a window is half a turn away.
const MOST_TURN: f64 = 1.0;
/// Neighbouring points are no farther apart, m: with [`SHORTEST_M`] this keeps every quotient a number.
const LONGEST_M: f64 = 1e6;

/// Why a point is refused; the curve stays as it was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointError {
    /// A number of the pose is infinite or not a number, or the way to it is 1000 km.
    NotFinite,
    /// More than 1 rad away from the point before.
    TurnTooLarge,
    /// [`MovingSegment::finish`] has begun, and has not come to its end.
    Finishing,
}

impl fmt::Display for PointError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotFinite => "a number of the point is infinite, not a number, or far too large",
            Self::TurnTooLarge => "the point is turned by more than 1 rad from the one before",
            Self::Finishing => "the curve is being finished",
        })
    }
}

impl core::error::Error for PointError {}

/// Makes spans of points, each as soon as the eight points that it depends on are known.
///
/// - The parameter of a span is its chord (m; see [`METRES_PER_RADIAN`](super::METRES_PER_RADIAN) for turns).
///   On a circle with points an angle θ apart |p'| is between 1 and 1 + 1.06·θ²/24; on random walks that
///   turn by up to 0.2, 0.5, 1 rad at each point it stays within 0.8 %, 5 %, 17 % of 1. Where the way turns
///   sharply right at its end, or long chords follow short ones, it may be far off: [`PathPoint::first`] tells.
/// - A circle of radius R is met to R·θ⁴/500 (fourth order), its curvature to θ²/14 of it (second order).
/// - At the first three points and the last three the window has what there is: at the first point itself
///   and three after it, at the second one more before it, and so on. Two points make a straight line,
///   three a parabola, four one cubic.
/// - A point closer than [`SHORTEST_M`] to the last one kept is left out.
/// - Orientations are rotation vectors relative to the one in the middle of the window; the curve is the
///   same for any choice of base and tool frame.
/// - C2 where spans meet, in position and orientation, by construction: both have the same [`PathPoint`]
///   there, up to the third derivative.
///
/// ```
/// use motion::path::{Curve, MovingSegment};
/// use motion::Pose;
/// use nalgebra::Vector3;
/// let mut curve = MovingSegment::new();
/// let mut spans = 0;
/// for i in 0..20 {
///     let at = Vector3::new(0.01 * f64::from(i), 1e-4 * f64::from(i * i), 0.0);
///     let pose = Pose::from_rotation_vector(at, Vector3::zeros());
///     if let Some(span) = curve.push(pose)? {
///         spans += 1;
///         assert!((span.at(0.0).first.linear_norm() - 1.0).abs() < 1e-3);
///     }
/// }
/// while let Some(_) = curve.finish() {
///     spans += 1;
/// }
/// assert_eq!(spans, 19);
/// # Ok::<(), motion::path::PointError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct MovingSegment {
    /// The last points, oldest first.
    points: [Point; window::MOST],
    count: usize,
    /// How many of them, from the newest, have no derivatives yet.
    waiting: usize,
    /// The last point that has.
    last: Option<PathPoint>,
    finishing: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Point {
    pose: Pose,
    /// From the point before, m.
    chord: f64,
}

impl Default for MovingSegment {
    fn default() -> Self {
        Self::new()
    }
}

impl MovingSegment {
    /// No points yet.
    #[must_use]
    #[expect(
        clippy::inline_always,
        reason = "so that what is large is made where it stays, and not on the stack"
    )]
    #[inline(always)]
    pub fn new() -> Self {
        let nowhere = Point {
            pose: Pose::identity(),
            chord: 0.0,
        };
        Self {
            points: [nowhere; window::MOST],
            count: 0,
            waiting: 0,
            last: None,
            finishing: false,
        }
    }

    /// No points, as [`new`](Self::new).
    pub fn clear(&mut self) {
        *self = Self::new();
    }

    /// The next point, in the base frame; the span that it completes, if any. Work: one window.
    ///
    /// # Errors
    /// [`PointError`].
    pub fn push(&mut self, pose: Pose) -> Result<Option<Quintic>, PointError> {
        if self.finishing {
            return Err(PointError::Finishing);
        }
        if !is_finite(&pose) {
            return Err(PointError::NotFinite);
        }
        let mut chord = 0.0;
        if let Some(before) = self.known().last() {
            let way = pose.position - before.pose.position;
            let turn = log(&(pose.rotation * before.pose.rotation.transpose()));
            let angle = libm::sqrt(turn.dot(&turn));
            chord = extent(libm::sqrt(way.dot(&way)), angle);
            if chord.is_nan() || chord > LONGEST_M {
                return Err(PointError::NotFinite);
            }
            if angle > MOST_TURN {
                return Err(PointError::TurnTooLarge);
            }
            if chord < SHORTEST_M {
                return Ok(None);
            }
        }
        if self.count == self.points.len() {
            self.points.rotate_left(1);
            self.count = self.count.saturating_sub(1);
        }
        if let Some(place) = self.points.get_mut(self.count) {
            *place = Point { pose, chord };
            self.count = self.count.saturating_add(1);
        }
        self.waiting = self.waiting.saturating_add(1);
        if self.waiting <= SIDE {
            return Ok(None);
        }
        Ok(self.advance())
    }

    /// No more points: the spans that are left, one per call, at most three. None ends it; then a new curve
    /// may begin. A single point has no span.
    pub fn finish(&mut self) -> Option<Quintic> {
        self.finishing = true;
        // the first point of a short curve has no span before it
        for _ in 0..=SIDE {
            if self.waiting == 0 {
                break;
            }
            let span = self.advance();
            if span.is_some() {
                return span;
            }
        }
        self.clear();
        None
    }

    fn known(&self) -> &[Point] {
        self.points.get(..self.count).unwrap_or_default()
    }

    /// Find the derivatives at the oldest point that waits for them; the span from the one before it.
    fn advance(&mut self) -> Option<Quintic> {
        let here = self.count.checked_sub(self.waiting)?;
        self.waiting = self.waiting.saturating_sub(1);
        let centre = self.known().get(here)?;
        let (chord, node) = (centre.chord, self.node(here, &centre.pose));
        let from = self.last.replace(node)?;
        // never refused: the chord is between SHORTEST_M and LONGEST_M
        Quintic::between(&from, &node, chord).ok()
    }

    /// The point with the derivatives of the spline through its neighbours.
    fn node(&self, here: usize, centre: &Pose) -> PathPoint {
        let begin = here.saturating_sub(SIDE);
        let mut knots = [Knot {
            step: 0.0,
            value: Value::zeros(),
        }; window::MOST];
        let points = self.known().iter().skip(begin).take(2 * SIDE + 1);
        let mut used = 0;
        for (knot, point) in knots.iter_mut().zip(points) {
            knot.step = point.chord;
            knot.value = relative(&point.pose, centre);
            used += 1;
        }
        let knots = knots.get(..used).unwrap_or_default();
        let [first, second] = window::derivatives(knots, here - begin).map(twist);
        // at φ = 0 the derivatives of the rotation vector are ω and ω'
        PathPoint {
            pose: *centre,
            first,
            second,
            third: Twist::zero(),
        }
    }
}

fn relative(pose: &Pose, centre: &Pose) -> Value {
    let way = pose.position - centre.position;
    let turn = log(&(pose.rotation * centre.rotation.transpose()));
    Value::new(way.x, way.y, way.z, turn.x, turn.y, turn.z)
}

fn twist(value: Value) -> Twist {
    let [[x, y, z, a, b, c]] = value.data.0;
    Twist {
        linear: Vector3::new(x, y, z),
        angular: Vector3::new(a, b, c),
    }
}
