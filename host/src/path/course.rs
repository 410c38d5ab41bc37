//! The curve that a node makes of the elements of a path: the same pieces of crate `motion`, all of
//! them at once.

use super::pose;
use motion::Pose;
use motion::path::{
    Arc, Blend, Curve, Join, METRES_PER_RADIAN, MovingSegment, PathPoint, Piece, PieceError,
    PointError, Quintic, SHORTEST_BLEND_M, Straight, Tolerance,
};
use nalgebra::Vector3;
use protocol::fault::PathProblem;
use protocol::message::{Corner, PathElement};
use std::collections::VecDeque;

/// Why elements make no curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Broken {
    /// The element, from 0.
    pub element: usize,
    /// Why it cannot be part of the path.
    pub problem: PathProblem,
}

/// The whole curve, over the parameter s of crate `motion`: metres, and [`METRES_PER_RADIAN`] where
/// the tool turns more than it goes.
#[derive(Clone, Debug, PartialEq)]
pub struct Course {
    parts: Vec<Part>,
    end: f64,
    length_m: f64,
}

/// A part of a piece.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Part {
    piece: Piece,
    from: f64,
    to: f64,
    /// s where it begins.
    start: f64,
    element: usize,
}

/// What is left of a piece after blending is not kept if it is rounding only, m.
const NOTHING_M: f64 = 1e-12;

impl Course {
    /// The curve of elements from where the tool is, `t_base_tool`; what follows an
    /// [`End`](PathElement::End) is not looked at.
    ///
    /// # Errors
    /// The first element that a node would refuse.
    pub fn new(start: Pose, elements: &[PathElement]) -> Result<Self, Broken> {
        let mut builder = Builder {
            parts: Vec::new(),
            at: start,
            curve: MovingSegment::new(),
            open: false,
            points: VecDeque::new(),
        };
        for (number, element) in elements.iter().enumerate() {
            if *element == PathElement::End {
                break;
            }
            builder.take(number, element).map_err(|problem| Broken {
                element: number,
                problem,
            })?;
        }
        builder.close();
        Ok(Self::of(builder.parts))
    }

    fn of(mut parts: Vec<Part>) -> Self {
        let (mut end, mut length_m) = (0.0, 0.0);
        for part in &mut parts {
            part.start = end;
            end += part.to - part.from;
            length_m += part.piece.arc_length(part.from, part.to);
        }
        Self {
            parts,
            end,
            length_m,
        }
    }

    /// The greatest s, m.
    #[must_use]
    pub const fn end(&self) -> f64 {
        self.end
    }

    /// Length of the way of the tool's origin, m.
    #[must_use]
    pub const fn length_m(&self) -> f64 {
        self.length_m
    }

    /// The point at s, limited to the curve; none where there is no curve.
    #[must_use]
    pub fn at(&self, s: f64) -> Option<PathPoint> {
        Some(self.part(s)?.at(s))
    }

    /// The element of s, from 0; that of a blend is the one it leads to.
    #[must_use]
    pub fn element(&self, s: f64) -> usize {
        self.part(s).map_or(0, |part| part.element)
    }

    /// s from 0, exclusive, to the end, at most `step` apart, and everywhere where a piece ends.
    pub fn samples(&self, step: f64) -> impl Iterator<Item = f64> + '_ {
        self.parts.iter().flat_map(move |part| {
            let span = part.to - part.from;
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "not negative; the conversion saturates"
            )]
            let count = libm::ceil(span / step) as u32;
            let count = count.max(1);
            (1..=count).map(move |k| part.start + span * f64::from(k) / f64::from(count))
        })
    }

    fn part(&self, s: f64) -> Option<&Part> {
        self.parts.get(self.index(s))
    }

    /// The part of s.
    fn index(&self, s: f64) -> usize {
        let after = self.parts.partition_point(|part| part.start <= s);
        after.saturating_sub(1)
    }

    /// The s of a tool that was near `last` a moment ago, and its distance from the curve, m.
    ///
    /// The neighbourhood `reach` (m) of `last` is searched for where position and orientation fit best;
    /// about there the nearest position is taken, on the pieces within two millimetres.
    #[must_use]
    pub fn nearest(&self, tool: &Pose, last: f64, reach: f64) -> Option<(f64, f64)> {
        let settled = self.beside(tool, last)?;
        if settled.1 < ON_IT_M && self.misfit(tool, settled.0)? < 2.0 * ON_IT_M {
            return Some(settled);
        }
        let mut best = (last, self.misfit(tool, last)?);
        #[expect(
            clippy::cast_possible_truncation,
            reason = "a reach of some mm; the conversion saturates"
        )]
        let steps = libm::ceil(reach / SCAN_M) as i32;
        for k in -steps..=steps {
            let s = (last + SCAN_M * f64::from(k)).clamp(0.0, self.end);
            let misfit = self.misfit(tool, s)?;
            if misfit < best.1 {
                best = (s, misfit);
            }
        }
        self.beside(tool, best.0)
    }

    /// The nearest position within [`REFINE_M`] of s, on either side of a corner.
    fn beside(&self, tool: &Pose, s: f64) -> Option<(f64, f64)> {
        let mut nearest = (s, f64::INFINITY);
        let first = self.index(s - REFINE_M);
        for part in self.parts.iter().skip(first) {
            if part.start > s + REFINE_M {
                break;
            }
            let found = part.refine(tool, s);
            if found.1 < nearest.1 {
                nearest = found;
            }
        }
        nearest.1.is_finite().then_some(nearest)
    }

    /// Distance, m, with the turn of the tool counted as way.
    fn misfit(&self, tool: &Pose, s: f64) -> Option<f64> {
        let at = self.at(s)?.pose;
        let way = tool.position - at.position;
        // ‖R − R₀‖² = 4·(1 − cos θ), about 2·θ²
        let turn = 0.5 * (tool.rotation - at.rotation).norm_squared();
        Some(libm::sqrt(
            way.dot(&way) + METRES_PER_RADIAN * METRES_PER_RADIAN * turn,
        ))
    }
}

impl Part {
    /// The point at s of the course, limited to the part.
    fn at(&self, s: f64) -> PathPoint {
        let local = self.from + (s - self.start);
        self.piece.at(local.clamp(self.from, self.to))
    }

    /// Newton's method for (p(s) − x)·p'(s) = 0 within the part; the best point that it met. It does not
    /// go over to the next part, in which another minimum might draw it away from a corner.
    fn refine(&self, tool: &Pose, from: f64) -> (f64, f64) {
        let end = self.start + (self.to - self.from);
        let mut s = from.clamp(self.start, end);
        let mut best = (s, f64::INFINITY);
        for _ in 0..ROUNDS {
            let point = self.at(s);
            let off: Vector3<f64> = point.pose.position - tool.position;
            let distance = libm::sqrt(off.dot(&off));
            if distance < best.1 {
                best = (s, distance);
            }
            let (p1, p2) = (point.first.linear, point.second.linear);
            let slope = p1.dot(&p1) + off.dot(&p2);
            let slope = if slope > 0.0 { slope } else { p1.dot(&p1) };
            if slope <= 0.0 {
                break;
            }
            let next = (s - off.dot(&p1) / slope).clamp(self.start, end);
            if (next - s).abs() < 1e-12 {
                break;
            }
            s = next;
        }
        best
    }
}

/// A tool this near to the curve is on it, m.
const ON_IT_M: f64 = 1e-6;
/// The neighbourhood is searched in steps of this, m.
const SCAN_M: f64 = 5e-4;
/// And refined on the pieces within this, m.
const REFINE_M: f64 = 1.5e-3;
/// Rounds of Newton's method: it squares its error each time.
const ROUNDS: u32 = 8;

/// What has come so far.
struct Builder {
    parts: Vec<Part>,
    /// Where the last element ends.
    at: Pose,
    curve: MovingSegment,
    /// Is a curve through points being made?
    open: bool,
    /// Elements whose spans are not made yet.
    points: VecDeque<usize>,
}

impl Builder {
    fn take(&mut self, number: usize, element: &PathElement) -> Result<(), PathProblem> {
        match element {
            PathElement::Through(to) => {
                let to = pose(to);
                if !self.open {
                    self.curve.push(self.at).map_err(of_point)?;
                    self.open = true;
                }
                let span = self.curve.push(to).map_err(of_point)?;
                self.points.push_back(number);
                self.at = to;
                if let Some(span) = span {
                    self.span(&span);
                }
            }
            PathElement::Line { to, corner } => {
                self.close();
                let to = pose(to);
                match Straight::new(self.at, to) {
                    Ok(piece) => self.join(number, &piece.into(), *corner)?,
                    // a line that goes nowhere is none
                    Err(PieceError::TooShort) => {}
                    Err(error) => return Err(of_piece(error)),
                }
                self.at = to;
            }
            PathElement::Arc { via_m, to, corner } => {
                self.close();
                let to = pose(to);
                let piece = Arc::through(self.at, (*via_m).into(), to).map_err(of_piece)?;
                self.join(number, &piece.into(), *corner)?;
                self.at = to;
            }
            PathElement::Feed { metres_per_second } => {
                if !(*metres_per_second > 0.0 && metres_per_second.is_finite()) {
                    return Err(PathProblem::Feed);
                }
            }
            PathElement::End => {}
        }
        Ok(())
    }

    /// The curve through points ends here.
    fn close(&mut self) {
        if self.open {
            while let Some(span) = self.curve.finish() {
                self.span(&span);
            }
            self.open = false;
            self.points.clear();
        }
    }

    fn span(&mut self, span: &Quintic) {
        let element = self.points.pop_front().unwrap_or_default();
        self.append(&(*span).into(), 0.0, element);
    }

    fn append(&mut self, piece: &Piece, from: f64, element: usize) {
        self.parts.push(Part {
            piece: *piece,
            from,
            to: piece.length(),
            start: 0.0,
            element,
        });
    }

    /// Appends a piece with the corner before it rounded, if that is wanted and there is one.
    fn join(&mut self, element: usize, piece: &Piece, corner: Corner) -> Result<(), PathProblem> {
        let (metres, radians) = (f64::from(corner.metres), f64::from(corner.radians));
        let valid = |x: f64| x.is_finite() && x >= 0.0;
        if !valid(metres) || !valid(radians) {
            return Err(PathProblem::Corner);
        }
        let wanted = metres > 0.0 && radians > 0.0;
        let smooth = |last: &Part| {
            let (end, start) = (last.piece.at(last.to), piece.at(0.0));
            Join::between(&end, &start) == Some(Join::Smooth)
        };
        let last = match self.parts.last_mut() {
            Some(last) if wanted && !smooth(last) => last,
            _ => {
                self.append(piece, 0.0, element);
                return Ok(());
            }
        };
        let tolerance = Tolerance { metres, radians };
        let blend =
            Blend::between(&last.piece, piece, &tolerance).map_err(|_| PathProblem::Corner)?;
        if blend.curve().length() < SHORTEST_BLEND_M {
            // a node leaves such a corner as it is
            self.append(piece, 0.0, element);
            return Ok(());
        }
        last.to -= blend.distance();
        if last.to - last.from <= NOTHING_M {
            self.parts.pop();
        }
        self.append(&(*blend.curve()).into(), 0.0, element);
        self.append(piece, blend.distance(), element);
        Ok(())
    }
}

const fn of_point(error: PointError) -> PathProblem {
    match error {
        PointError::NotFinite | PointError::Finishing => PathProblem::NotFinite,
        PointError::TurnTooLarge => PathProblem::TurnTooLarge,
    }
}

const fn of_piece(error: PieceError) -> PathProblem {
    match error {
        PieceError::NotFinite => PathProblem::NotFinite,
        PieceError::TooShort => PathProblem::NoLength,
        PieceError::Collinear
        | PieceError::NoRadius
        | PieceError::NoNormal
        | PieceError::NotEquidistant => PathProblem::NotAnArc,
    }
}
