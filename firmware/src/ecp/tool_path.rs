//! The tool along a path: pieces, a look ahead at what the joints can bear, and the speed.
//!
//! Whatever the generator, each macrostep does a bounded amount of work: some elements become pieces of the
//! path, some samples are taken ahead of the tool (at each the inverse kinematics gives q(s) and, by
//! differences, q', q'', q'''), and the [`Feed`] moves s on as far as the samples allow. What lies ahead and
//! cannot be done is a wall: the tool comes to rest before it, and then the instruction is refused.

use crate::capacity::{PATH_AVERAGED, path_per_macrostep};
use crate::ecp::Demand;
use crate::ecp::instruct::pose;
use crate::ecp::path_feed::{Feeds, chord};
use crate::ecp::tool_motion::{ToolMotion, bend};
use motion::Pose;
use motion::feed::{Feed, PushError, Sample, Status, Step};
use motion::path::{
    Arc, BlendError, Curve, Join, MovingSegment, Path, Piece, PieceError, PointError, QueueError,
    Quintic, SHORTEST_BLEND_M, Straight, Tolerance,
};
use motion::profile::State;
use nalgebra::Vector3;
use protocol::fault::{PathProblem, Refusal};
use protocol::message::{Corner, PathElement};
use robots::{JointMotion, Joints, Robot};

/// Pieces below so many distances of samples are looked at one by one: a blend bends most in its middle, and
/// falls to half of that an eighth of its length away.
const SHORT: f64 = 4.0;

/// Whether a curve through points is being made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Curving {
    /// None is.
    Not,
    /// It has no span yet.
    Begun,
    /// The last piece is a span of it.
    Inside,
}

/// A path on its way: what the tool has before it, and where it is. With room for W pieces and for W samples
/// of them, and as many changes of the feed.
///
/// Large: it stays in its place, in which one path [begins](Self::begin) after the other.
#[derive(Clone, Debug)]
pub struct ToolPath<const N: usize, const W: usize> {
    path: Path<W>,
    /// The curve through points that is being made, if one is.
    curve: MovingSegment,
    curving: Curving,
    /// Where the last element ends.
    last: Pose,
    /// No more elements will come.
    ended: bool,
    feed: Feed<N, W, PATH_AVERAGED>,
    /// The programmed feeds of what is sampled and of what is not yet.
    feeds: Feeds<W>,
    grid: f64,
    /// Where the piece begins that is sampled, where its last sample was taken, and the joints there.
    piece_from: f64,
    sampled: Option<f64>,
    ahead: Joints<N>,
    /// How the feed moves.
    along: State,
    /// Where the tool is, and its joints there.
    s: f64,
    here: Joints<N>,
    begun: bool,
    status: Status,
    /// Why the path cannot go on beyond what is sampled.
    wall: Option<Refusal>,
    /// Why there is no path at all.
    none: Option<Refusal>,
}

impl<const N: usize, const W: usize> Default for ToolPath<N, W> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize, const W: usize> ToolPath<N, W> {
    /// No path yet.
    #[must_use]
    #[expect(
        clippy::inline_always,
        reason = "so that what is large is made where it stays, and not on the stack"
    )]
    #[inline(always)]
    pub fn new() -> Self {
        Self {
            path: Path::new().without_blends_below(SHORTEST_BLEND_M),
            curve: MovingSegment::new(),
            curving: Curving::Not,
            last: Pose::identity(),
            ended: true,
            feed: Feed::nothing(),
            feeds: Feeds::new(0.0),
            grid: 0.0,
            piece_from: 0.0,
            sampled: None,
            ahead: Joints([0.0; N]),
            along: State::REST,
            s: 0.0,
            here: Joints([0.0; N]),
            begun: false,
            status: Status::Done,
            wall: None,
            none: None,
        }
    }

    /// Another path, at rest, with no elements yet; what there was is gone.
    ///
    /// # Errors
    /// [`Refusal::NotFinite`] if the limits admit no motion; [`Refusal::OutOfRange`] if the robot's rule for
    /// its redundancy has it elsewhere than it stands: a path cannot begin with a jump. Then there is no path,
    /// and each step refuses with the same.
    // a frame of its own: what else its caller does must not lie below it on the stack
    #[inline(never)]
    pub fn begin<R: Robot<N>>(
        &mut self,
        motion: &ToolMotion<R, N>,
        from: &Joints<N>,
    ) -> Result<(), Refusal> {
        let begun = self.try_begin(motion, from);
        self.none = begun.err();
        begun
    }

    /// There is no path, for a reason.
    pub(super) fn refuse_all(&mut self, refusal: Refusal) {
        self.none = Some(refusal);
    }

    fn try_begin<R: Robot<N>>(
        &mut self,
        motion: &ToolMotion<R, N>,
        from: &Joints<N>,
    ) -> Result<(), Refusal> {
        let last = motion.begin(from)?;
        let grid = motion.grid::<W>();
        self.feed
            .begin(&motion.feed_limits(), grid, motion.macrostep_s)
            .map_err(|_| Refusal::NotFinite { index: 0 })?;
        self.path.clear();
        self.curve.clear();
        self.curving = Curving::Not;
        self.last = last;
        self.ended = false;
        self.feeds.begin(motion.speeds.velocity_m_s);
        self.grid = grid;
        self.piece_from = 0.0;
        self.sampled = None;
        self.ahead = *from;
        self.along = State::REST;
        self.s = 0.0;
        self.here = *from;
        self.begun = false;
        self.status = Status::Waiting;
        self.wall = None;
        Ok(())
    }

    /// Where the path ends so far: `t_base_tool`.
    #[must_use]
    pub const fn last(&self) -> &Pose {
        &self.last
    }

    /// How many elements can be taken now.
    #[must_use]
    pub fn room(&self) -> usize {
        if self.ended || self.wall.is_some() || self.none.is_some() {
            return 0;
        }
        // one of them may end a curve: four spans; each may add a blend and a piece, or change the feed
        (self.path.room().saturating_sub(4) / 2).min(self.feeds.room())
    }

    /// An element of the path, the `number`-th. One that cannot be is a wall.
    // a frame of its own: what else its caller does must not lie below it on the stack
    #[inline(never)]
    pub fn take(&mut self, number: u32, element: &PathElement) {
        if let Err(problem) = self.element(element) {
            self.refuse(Refusal::Path {
                element: number,
                problem,
            });
        }
    }

    /// The path ends where it is, for a reason.
    fn refuse(&mut self, refusal: Refusal) {
        self.wall.get_or_insert(refusal);
    }

    fn element(&mut self, element: &PathElement) -> Result<(), PathProblem> {
        match element {
            PathElement::Through(to) => {
                let to = pose(to).map_err(|_| PathProblem::NotFinite)?;
                if self.curving == Curving::Not {
                    self.curving = Curving::Begun;
                    self.curve.push(self.last).map_err(point_problem)?;
                }
                let span = self.curve.push(to).map_err(point_problem)?;
                self.feeds.waiting_m += chord(&self.last, &to);
                self.last = to;
                if let Some(span) = span {
                    self.feeds.waiting_m -= span.length();
                    self.span(&span)?;
                }
                Ok(())
            }
            PathElement::Line { to, corner } => {
                let to = pose(to).map_err(|_| PathProblem::NotFinite)?;
                self.line(to, *corner)
            }
            PathElement::Arc { via_m, to, corner } => {
                self.end_curve()?;
                let to = pose(to).map_err(|_| PathProblem::NotFinite)?;
                let arc =
                    Arc::through(self.last, Vector3::from(*via_m), to).map_err(piece_problem)?;
                self.push(&arc.into(), *corner)?;
                self.last = to;
                Ok(())
            }
            PathElement::End => {
                self.end_curve()?;
                self.ended = true;
                Ok(())
            }
            PathElement::Feed { metres_per_second } => {
                self.feeds.change(self.path.end(), *metres_per_second)
            }
        }
    }

    /// A straight line; one that goes nowhere is none.
    fn line(&mut self, to: Pose, corner: Corner) -> Result<(), PathProblem> {
        self.end_curve()?;
        match Straight::new(self.last, to) {
            Ok(line) => self.push(&line.into(), corner)?,
            Err(PieceError::TooShort) => {}
            Err(error) => return Err(piece_problem(error)),
        }
        self.last = to;
        Ok(())
    }

    /// The straight line to a pose, and nothing more.
    ///
    /// # Errors
    /// [`Refusal::Path`]
    pub fn only_line(&mut self, to: Pose) -> Result<(), Refusal> {
        let exact = Corner {
            metres: 0.0,
            radians: 0.0,
        };
        self.ended = true;
        self.line(to, exact).map_err(|problem| Refusal::Path {
            element: 0,
            problem,
        })
    }

    fn end_curve(&mut self) -> Result<(), PathProblem> {
        if self.curving == Curving::Not {
            return Ok(());
        }
        self.feeds.waiting_m = 0.0;
        for _ in 0..W {
            let Some(span) = self.curve.finish() else {
                break;
            };
            self.span(&span)?;
        }
        self.curving = Curving::Not;
        Ok(())
    }

    /// A span of a curve goes on with the one before it; the first of them with what there was.
    fn span(&mut self, span: &Quintic) -> Result<(), PathProblem> {
        if self.curving == Curving::Inside {
            return self.path.push_span(span).map_err(queue_problem);
        }
        self.curving = Curving::Inside;
        let _: Join = self.path.push(*span).map_err(queue_problem)?;
        Ok(())
    }

    #[inline(never)]
    fn push(&mut self, piece: &Piece, corner: Corner) -> Result<(), PathProblem> {
        let tolerance = Tolerance {
            metres: f64::from(corner.metres),
            radians: f64::from(corner.radians),
        };
        let valid = |x: f64| x.is_finite() && x >= 0.0;
        if !valid(tolerance.metres) || !valid(tolerance.radians) {
            return Err(PathProblem::Corner);
        }
        let exact = tolerance.metres <= 0.0 || tolerance.radians <= 0.0;
        let _: Join = if exact {
            self.path.push(*piece)
        } else {
            self.path.push_blended(*piece, &tolerance)
        }
        .map_err(queue_problem)?;
        Ok(())
    }

    /// Takes samples as far as the path is settled and there is room.
    // a frame of its own: what else its caller does must not lie below it on the stack
    #[inline(never)]
    fn look_ahead<R: Robot<N>>(&mut self, motion: &ToolMotion<R, N>) {
        let (_, samples) = path_per_macrostep(W);
        for _ in 0..samples {
            // an end of a piece takes two places
            if self.wall.is_some() || self.feed.room() < 2 {
                return;
            }
            match self.sample(motion) {
                Ok(true) => {}
                Ok(false) => return,
                Err(refusal) => self.refuse(refusal),
            }
        }
    }

    /// One sample; false if nothing more is known.
    fn sample<R: Robot<N>>(&mut self, motion: &ToolMotion<R, N>) -> Result<bool, Refusal> {
        let known = if self.ended {
            self.path.end()
        } else {
            self.path.settled()
        };
        let Some(last) = self.sampled else {
            // a piece begins
            if self.ended && self.piece_from >= known {
                let _ = self.feed.finish();
                return Ok(false);
            }
            if self.piece_from >= known {
                return Ok(false);
            }
            let sample = self.sample_at(motion, self.piece_from)?;
            self.feed.push(&sample).map_err(push_refusal)?;
            self.sampled = Some(self.piece_from);
            return Ok(true);
        };
        let end = self.path.end();
        // from where the piece began: the last sample may lie on its end, to the bit
        let stop = self.path.stop_after(self.piece_from + HARDLY);
        let stop = stop.or(self.ended.then_some(end));
        if let Some(stop) = stop
            && stop - last <= self.grid
        {
            // what is left of the piece; the path at the stop itself is the next piece's
            let sample = self.sample_at(motion, stop - HARDLY)?;
            let rest = stop - last;
            let rest = if rest > HARDLY { rest } else { HARDLY };
            self.feed
                .end_piece(&sample, rest / self.grid)
                .map_err(push_refusal)?;
            self.piece_from = stop;
            self.sampled = None;
            return Ok(true);
        }
        let next = last + self.grid;
        // what bends the path up to the sample after this one counts here too
        let needed = if self.ended { next } else { next + self.grid };
        if needed > known {
            return Ok(false);
        }
        let sample = self.sample_at(motion, next)?;
        self.feed.push(&sample).map_err(push_refusal)?;
        self.sampled = Some(next);
        Ok(true)
    }

    // a frame of its own: what else its caller does must not lie below it on the stack
    #[inline(never)]
    fn sample_at<R: Robot<N>>(
        &mut self,
        motion: &ToolMotion<R, N>,
        s: f64,
    ) -> Result<Sample<N>, Refusal> {
        let mut sharpest = self.path.followed_at(s).ok_or(Refusal::Unreachable)?;
        let (from, to) = (s - self.grid, s + self.grid);
        let short = SHORT * self.grid;
        let mut middles = heapless::Vec::<f64, 8>::new();
        for middle in self.path.short_between(from, to, short) {
            // at most eight
            let _ = middles.push(middle);
        }
        for middle in middles {
            if let Some(point) = self
                .path
                .followed_at(middle)
                .filter(|point| bend(point) > bend(&sharpest))
            {
                sharpest = point;
            }
        }
        motion.sample(&sharpest, self.feeds.at(s), &mut self.ahead)
    }

    /// One macrostep, at a share of the programmed feed.
    pub fn step<R: Robot<N>>(
        &mut self,
        motion: &ToolMotion<R, N>,
        feed_override: f64,
    ) -> Demand<N> {
        if let Some(refusal) = self.none {
            return Demand::Refuse(refusal);
        }
        let known = (self.piece_from, self.sampled, self.path.end());
        self.look_ahead(motion);
        let step = self.feed.step(feed_override);
        self.status = step.status;
        self.along = step.end;
        let end = self.path.end();
        let s = if step.end.p < end { step.end.p } else { end };
        let moved = libm::fabs(s - self.s) > 0.0;
        self.s = s;
        let at_rest = step.end.v.abs() <= 0.0 && step.end.a.abs() <= 0.0;
        let rests = at_rest && !moved;
        let demand = if rests {
            None
        } else {
            Some(self.knots(motion, &step, end))
        };
        self.forget(s);
        let stuck = known == (self.piece_from, self.sampled, end);
        let waiting = self.status == Status::Waiting && self.begun;
        if waiting && stuck && self.room() == 0 && !self.ended {
            self.refuse(Refusal::QueueFull);
        }
        if let Some(demand) = demand {
            self.begun = true;
            return demand;
        }
        match (self.status, self.wall) {
            (Status::Waiting, Some(refusal)) => Demand::Refuse(refusal),
            _ if !self.begun => Demand::Stay,
            // knots at rest, so that the set-points keep their lead
            _ => Demand::Joints(JointMotion {
                position: self.here,
                velocity: [0.0; N],
                acceleration: [0.0; N],
            }),
        }
    }

    /// What lies behind s and need not be run back to.
    fn forget(&mut self, s: f64) {
        if self.room() == 0 && !self.ended {
            // many short pieces: more of them lie behind than there is room for
            self.feed.discard_before(s);
        }
        self.path.discard_before(self.feed.retained_from());
    }

    /// The macrostep in two halves: between knots q(t) is a quintic, which over a whole macrostep of a curve,
    /// whose third derivative jumps where its points are, leaves it by more than a nanometre.
    // a frame of its own: what else its caller does must not lie below it on the stack
    #[inline(never)]
    fn knots<R: Robot<N>>(
        &mut self,
        motion: &ToolMotion<R, N>,
        step: &Step,
        end: f64,
    ) -> Demand<N> {
        let middle = step.phase.at(0.5 * motion.macrostep_s);
        match [middle, step.end].map(|along| self.knot(motion, &along, end)) {
            [Ok(middle), Ok(end)] => {
                self.here = end.position;
                Demand::JointsTwice([middle, end])
            }
            [Err(refusal), _] | [_, Err(refusal)] => Demand::Refuse(refusal),
        }
    }

    /// The joints where the feed is at an instant, before `end`.
    // a frame of its own: what else its caller does must not lie below it on the stack
    #[inline(never)]
    fn knot<R: Robot<N>>(
        &mut self,
        motion: &ToolMotion<R, N>,
        along: &State,
        end: f64,
    ) -> Result<JointMotion<N>, Refusal> {
        let s = if along.p < end { along.p } else { end };
        let point = self.path.followed_at(s).ok_or(Refusal::QueueFull)?;
        motion.knot(&point, &self.here, along)
    }

    /// s, ṡ, s̈ and s⃛ at the end of the last macrostep (jerk: until then), over the parameter s of
    /// [`motion::path`]: m, m/s, m/s², m/s³.
    #[must_use]
    pub const fn along(&self) -> &State {
        &self.along
    }

    /// Whether the tool has come to the end of the path, or there is none.
    #[must_use]
    pub fn done(&self) -> bool {
        self.none.is_some() || self.status == Status::Done
    }

    /// Whether the tool rests.
    #[must_use]
    pub fn rests(&self) -> bool {
        self.none.is_some() || self.status != Status::Moving
    }
}

/// A length of path that no robot can repeat, m: the least that is left of a piece for its last sample.
const HARDLY: f64 = 1e-9;

const fn point_problem(error: PointError) -> PathProblem {
    match error {
        PointError::NotFinite | PointError::Finishing => PathProblem::NotFinite,
        PointError::TurnTooLarge => PathProblem::TurnTooLarge,
    }
}

const fn piece_problem(error: PieceError) -> PathProblem {
    match error {
        PieceError::NotFinite => PathProblem::NotFinite,
        PieceError::TooShort => PathProblem::NoLength,
        PieceError::Collinear
        | PieceError::NoRadius
        | PieceError::NoNormal
        | PieceError::NotEquidistant => PathProblem::NotAnArc,
    }
}

const fn queue_problem(error: QueueError) -> PathProblem {
    match error {
        // neither can be: elements are taken only with room, and begin where the path ends
        QueueError::Full | QueueError::Gap => PathProblem::NoLength,
        QueueError::Corner(BlendError::NotFinite) => PathProblem::NotFinite,
        QueueError::Corner(BlendError::Tolerance | BlendError::Gap | BlendError::TooShort) => {
            PathProblem::Corner
        }
    }
}

/// A sample that the choice of speed cannot use: the arm is singular there.
const fn push_refusal(error: PushError) -> Refusal {
    match error {
        PushError::NotFinite
        | PushError::NotPositive
        | PushError::Full
        | PushError::Fraction
        | PushError::Finished
        | PushError::Singular => Refusal::Singular,
    }
}
