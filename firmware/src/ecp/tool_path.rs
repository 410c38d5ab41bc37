//! The tool along a path: pieces, a look ahead at what the joints can bear, and the speed.
//!
//! Whatever the generator, each macrostep does a bounded amount of work: some elements become pieces of the
//! path, some samples are taken ahead of the tool (at each the inverse kinematics gives q(s) and, by
//! differences, q', q'', q'''), and the [`Feed`] moves s on as far as the samples allow. What lies ahead and
//! cannot be done is a wall: the tool comes to rest before it, and then the instruction is refused.

use crate::capacity::{PATH_AVERAGED, PATH_PIECES, PATH_SAMPLES, PATH_SAMPLES_PER_MACROSTEP};
use crate::ecp::path_feed::{Feeds, chord};
use crate::ecp::{Demand, pose, refusal};
use motion::Pose;
use motion::feed::{Feed, FeedLimits, NormLimits, PushError, Sample, Status, ToolSample};
use motion::path::{
    Arc, BlendError, Curve, Join, MovingSegment, Path, PathPoint, Piece, PieceError, PointError,
    QueueError, Straight, Tolerance,
};
use motion::profile::{AxisLimits, State};
use nalgebra::Vector3;
use protocol::fault::{PathProblem, Refusal};
use protocol::message::{Corner, PathElement};
use robots::{JointMotion, Joints, Robot};

/// Step of the difference quotients, m: of q''' the error is δ² times the fifth derivative, and rounding
/// (1e-16/δ³) a part in 1e5 of what a millimetre's radius makes of it.
const DELTA: f64 = 2.5e-4;
/// Greatest and least distance of samples, m.
const COARSEST: f64 = 1.5e-3;
const FINEST: f64 = 2e-4;
/// The motion is smoothed over this times acceleration by jerk: see [`motion::feed`].
const SMOOTHING: f64 = 2.0 / 0.65;
/// Share of the samples that lies ahead of the tool, and must hold the way to a stop.
const AHEAD: f64 = 0.7;

/// What is asked for along a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathSpeeds {
    /// m/s
    pub velocity_m_s: f64,
    /// rad/s
    pub angular_velocity_rad_s: f64,
    /// m/s²
    pub acceleration_m_s2: f64,
    /// rad/s²
    pub angular_acceleration_rad_s2: f64,
}

/// An arm with its tool, and how it may move along a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolMotion<R, const N: usize> {
    /// The robot's kinematics.
    pub robot: R,
    /// The tool in the flange frame.
    pub t_flange_tool: Pose,
    /// What every joint can bear.
    pub joint_limits: [AxisLimits; N],
    /// What is asked for along the path.
    pub speeds: PathSpeeds,
    /// Macrostep, s.
    pub macrostep_s: f64,
}

/// q and its derivatives by s.
struct Local<const N: usize> {
    q: Joints<N>,
    first: [f64; N],
    second: [f64; N],
    third: [f64; N],
}

impl<R: Robot<N>, const N: usize> ToolMotion<R, N> {
    fn joints(&self, t_base_tool: &Pose, near: &Joints<N>) -> Result<Joints<N>, Refusal> {
        let t_base_flange = *t_base_tool * self.t_flange_tool.inverse();
        self.robot
            .inverse_near(&t_base_flange, near)
            .map_err(|e| refusal::from_kinematics(&e))
    }

    /// Central differences of the fourth order for q' and q'', of the second for q'''.
    fn local(&self, point: &PathPoint, near: &Joints<N>) -> Result<Local<N>, Refusal> {
        let q = self.joints(&point.pose, near)?;
        let at = |steps: f64| self.joints(&point.continued(steps * DELTA), &q);
        let (b2, b1, a1, a2) = (at(-2.0)?, at(-1.0)?, at(1.0)?, at(2.0)?);
        let mut local = Local {
            q,
            first: [0.0; N],
            second: [0.0; N],
            third: [0.0; N],
        };
        let outer = b2.0.iter().zip(&a2.0);
        let inner = b1.0.iter().zip(&a1.0);
        let out = local
            .first
            .iter_mut()
            .zip(&mut local.second)
            .zip(&mut local.third);
        for ((((first, second), third), q), ((b2, a2), (b1, a1))) in
            out.zip(&q.0).zip(outer.zip(inner))
        {
            *first = (8.0 * (a1 - b1) - (a2 - b2)) / (12.0 * DELTA);
            *second = (16.0 * (a1 + b1) - (a2 + b2) - 30.0 * q) / (12.0 * DELTA * DELTA);
            *third = ((a2 - b2) - 2.0 * (a1 - b1)) / (2.0 * DELTA * DELTA * DELTA);
        }
        Ok(local)
    }

    fn sample(
        &self,
        point: &PathPoint,
        feed: f64,
        near: &mut Joints<N>,
    ) -> Result<Sample<N>, Refusal> {
        let local = self.local(point, near)?;
        *near = local.q;
        let rows = |a: &Vector3<f64>, b: &Vector3<f64>, c: &Vector3<f64>| {
            [(*a).into(), (*b).into(), (*c).into()]
        };
        let PathPoint {
            first,
            second,
            third,
            ..
        } = point;
        Ok(Sample {
            first: local.first,
            second: local.second,
            third: local.third,
            tool: ToolSample {
                linear: rows(&first.linear, &second.linear, &third.linear),
                angular: rows(&first.angular, &second.angular, &third.angular),
            },
            feed,
        })
    }

    /// Samples as far apart as it takes for the window to hold the way to a stop from the speed asked for, and
    /// for a quarter of it to hold what one step must look at: the way during the smoothing and two macrosteps.
    fn grid(&self) -> f64 {
        let (v, a) = (self.speeds.velocity_m_s, self.speeds.acceleration_m_s2);
        let smoothing = self.joint_limits.iter().fold(0.0, |longest, joint| {
            let tau = SMOOTHING * joint.a / joint.j;
            if tau > longest { tau } else { longest }
        });
        let step = v * (smoothing + 3.0 * self.macrostep_s);
        let stop = 0.5 * v * v / a + step;
        #[expect(clippy::cast_precision_loss, reason = "some hundred samples")]
        let window = PATH_SAMPLES as f64;
        let (ahead, quarter) = (2.0 * stop / (AHEAD * window), 4.0 * step / window);
        let grid = if ahead > quarter { ahead } else { quarter };
        if grid > COARSEST {
            COARSEST
        } else if grid > FINEST {
            grid
        } else {
            FINEST
        }
    }
}

/// A path on its way: what the tool has before it, and where it is.
#[derive(Clone, Debug)]
pub struct ToolPath<const N: usize> {
    path: Path<PATH_PIECES>,
    /// The curve through points that is being made.
    curve: Option<MovingSegment>,
    /// Where the last element ends.
    last: Pose,
    /// No more elements will come.
    ended: bool,
    feed: Feed<N, PATH_SAMPLES, PATH_AVERAGED>,
    /// The programmed feeds of what is sampled and of what is not yet.
    feeds: Feeds,
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
}

impl<const N: usize> ToolPath<N> {
    /// At rest, with no path yet.
    ///
    /// # Errors
    /// [`Refusal::NotFinite`] if the limits admit no motion.
    pub fn begin<R: Robot<N>>(
        motion: &ToolMotion<R, N>,
        from: &Joints<N>,
    ) -> Result<Self, Refusal> {
        let PathSpeeds {
            velocity_m_s,
            angular_velocity_rad_s,
            acceleration_m_s2,
            angular_acceleration_rad_s2,
        } = motion.speeds;
        let limits = FeedLimits {
            joints: motion.joint_limits,
            linear: NormLimits {
                v: Some(velocity_m_s),
                a: Some(acceleration_m_s2),
                j: None,
            },
            angular: NormLimits {
                v: Some(angular_velocity_rad_s),
                a: Some(angular_acceleration_rad_s2),
                j: None,
            },
        };
        let grid = motion.grid();
        let feed = Feed::new(&limits, grid, motion.macrostep_s)
            .map_err(|_| Refusal::NotFinite { index: 0 })?;
        Ok(Self {
            path: Path::new(),
            curve: None,
            last: motion.robot.forward(from) * motion.t_flange_tool,
            ended: false,
            feed,
            feeds: Feeds::new(velocity_m_s),
            grid,
            piece_from: 0.0,
            sampled: None,
            ahead: *from,
            along: State::default(),
            s: 0.0,
            here: *from,
            begun: false,
            status: Status::Waiting,
            wall: None,
        })
    }

    /// Where the path ends so far: `t_base_tool`.
    #[must_use]
    pub const fn last(&self) -> &Pose {
        &self.last
    }

    /// How many elements can be taken now.
    #[must_use]
    pub fn room(&self) -> usize {
        if self.ended || self.wall.is_some() {
            return 0;
        }
        // one of them may end a curve: four spans; each may add a blend and a piece
        self.path.room().saturating_sub(4) / 2
    }

    /// An element of the path, the `number`-th. One that cannot be is a wall.
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
                let curve = if let Some(curve) = &mut self.curve {
                    curve
                } else {
                    let curve = self.curve.insert(MovingSegment::new());
                    curve.push(self.last).map_err(point_problem)?;
                    curve
                };
                let span = curve.push(to).map_err(point_problem)?;
                self.feeds.waiting_m += chord(&self.last, &to);
                self.last = to;
                if let Some(span) = span {
                    self.feeds.waiting_m -= span.length();
                    self.path.push(span).map_err(queue_problem)?;
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
                self.push(arc, *corner)?;
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
            Ok(line) => self.push(line, corner)?,
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
        let Some(mut curve) = self.curve.take() else {
            return Ok(());
        };
        self.feeds.waiting_m = 0.0;
        for _ in 0..PATH_PIECES {
            let Some(span) = curve.finish() else {
                break;
            };
            self.path.push(span).map_err(queue_problem)?;
        }
        Ok(())
    }

    fn push(&mut self, piece: impl Into<Piece>, corner: Corner) -> Result<(), PathProblem> {
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
            self.path.push(piece)
        } else {
            self.path.push_blended(piece, &tolerance)
        }
        .map_err(queue_problem)?;
        Ok(())
    }

    /// Takes samples as far as the path is settled and there is room.
    fn look_ahead<R: Robot<N>>(&mut self, motion: &ToolMotion<R, N>) {
        for _ in 0..PATH_SAMPLES_PER_MACROSTEP {
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
        if next > known {
            return Ok(false);
        }
        let sample = self.sample_at(motion, next)?;
        self.feed.push(&sample).map_err(push_refusal)?;
        self.sampled = Some(next);
        Ok(true)
    }

    fn sample_at<R: Robot<N>>(
        &mut self,
        motion: &ToolMotion<R, N>,
        s: f64,
    ) -> Result<Sample<N>, Refusal> {
        let point = self.path.at(s).ok_or(Refusal::Unreachable)?;
        motion.sample(&point, self.feeds.at(s), &mut self.ahead)
    }

    /// One macrostep, at a share of the programmed feed.
    pub fn step<R: Robot<N>>(
        &mut self,
        motion: &ToolMotion<R, N>,
        feed_override: f64,
    ) -> Demand<N> {
        let known = (self.piece_from, self.sampled, self.path.end());
        self.look_ahead(motion);
        let step = self.feed.step(feed_override);
        self.status = step.status;
        self.along = step.end;
        let end = self.path.end();
        let s = if step.end.p < end { step.end.p } else { end };
        let moved = libm::fabs(s - self.s) > 0.0;
        self.s = s;
        if self.room() == 0 && !self.ended {
            // many short pieces: more of them lie behind than there is room for
            self.feed.discard_before(s);
        }
        self.path.discard_before(self.feed.retained_from());
        let at_rest = step.end.v.abs() <= 0.0 && step.end.a.abs() <= 0.0;
        let stuck = known == (self.piece_from, self.sampled, self.path.end());
        let waiting = self.status == Status::Waiting && self.begun;
        if waiting && stuck && self.room() == 0 && !self.ended {
            self.refuse(Refusal::QueueFull);
        }
        if at_rest && !moved {
            return match (self.status, self.wall) {
                (Status::Waiting, Some(refusal)) => Demand::Refuse(refusal),
                _ if !self.begun => Demand::Stay,
                // knots at rest, so that the set-points keep their lead
                _ => Demand::Joints(JointMotion {
                    position: self.here,
                    velocity: [0.0; N],
                    acceleration: [0.0; N],
                }),
            };
        }
        self.begun = true;
        let Some(point) = self.path.at(s) else {
            return Demand::Stay;
        };
        match motion.local(&point, &self.here) {
            Ok(local) => {
                self.here = local.q;
                let (v, a) = (step.end.v, step.end.a);
                let (mut velocity, mut acceleration) = ([0.0; N], [0.0; N]);
                let out = velocity.iter_mut().zip(&mut acceleration);
                for ((qv, qa), (first, second)) in out.zip(local.first.iter().zip(&local.second)) {
                    *qv = first * v;
                    *qa = second * v * v + first * a;
                }
                Demand::Joints(JointMotion {
                    position: local.q,
                    velocity,
                    acceleration,
                })
            }
            Err(refusal) => Demand::Refuse(refusal),
        }
    }

    /// s, ṡ, s̈ and s⃛ at the end of the last macrostep (jerk: until then), over the parameter s of
    /// [`motion::path`]: m, m/s, m/s², m/s³.
    #[must_use]
    pub const fn along(&self) -> &State {
        &self.along
    }

    /// Whether the tool has come to the end of the path.
    #[must_use]
    pub fn done(&self) -> bool {
        self.status == Status::Done
    }

    /// Whether the tool rests.
    #[must_use]
    pub fn rests(&self) -> bool {
        self.status != Status::Moving
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
