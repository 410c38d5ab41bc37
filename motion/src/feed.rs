//! As fast along a path as joints and tool can bear, with limited jerk, from a stream of samples.
//!
//! A path q(s) is known by samples of its derivatives on a uniform grid of s. [`Feed`] chooses s(t), one
//! macrostep after the other, such that at every time, for every joint,
//! `|q'·v| ≤ V`, `|q'·a + q''·v²| ≤ A`, `|q'·j + 3·q''·v·a + q'''·v³| ≤ J`, with v, a, j the derivatives of s,
//! and likewise for the norms of the tool's velocity, acceleration and jerk. It sees no poses: whatever it
//! decides, the motion is on the path.
//!
//! **Two motions.** An inner motion s\* has constant acceleration u in each macrostep h, and limits of
//! velocity and acceleration only. Its state is (s\*, x = ṡ\*²), in which the limits are linear; what
//! they allow at one s is convex and contains (0, 0). A pass back from every wall gives the envelope
//! X(s): from x ≤ X the wall can be respected (the controllable sets of Pham and Pham, "A new approach to
//! time-optimal path parameterization based on reachability analysis", 2018). Each step takes the largest u that stays below.
//!
//! What goes out is the mean of s\* over the last τ = m·h. The mean of a piecewise constant acceleration
//! is continuous, its derivative `(u_k − u_(k−m))/τ`. While u is part of the mean, the mean is somewhere
//! around: u is held to what all samples there allow, so the mean is allowed, too.
//! τ is 2·A/(0.65·J), the largest of all joints and the tool; 0.35·J is left for curvature.
//!
//! **Walls.** The motion never passes the end of a piece, nor what is known: while a stream of samples
//! is late, it slows down and stops, and goes on when more have come. At the end of a piece it comes to
//! rest exactly. With a negative override it runs back, as far as samples are retained.
//!
//! **Work.** The wall passes at most 6 cells in a macrostep, or 1.5 times as many as the motion can. For each
//! of them, what the samples allow that bear on it becomes one polygon of at most 10 sides. A pass goes over
//! at most W cells, with two chords on these sides in each; a step looks at the samples that bear on it, at
//! most W/2 + 4, each with N + 3 limits. With N = 6, W = 128 and all limits of the tool, a macrostep of
//! `examples/feed_cost.rs` takes 0.104 million x86 instructions in the mean (three samples pushed) and 0.242
//! million in the worst (eight); the state takes 30 kB, with W = 96 23 kB.
//!
//! **Numbers.** Where the motion is, and how fast, is f64, and so are the walls. What is allowed there is f32: samples are
//! rounded as they come, and 2e-5 of every limit is kept free for it.

mod average;
mod envelope;
mod erosion;
mod gauge;
mod inner;
mod intake;
mod limits;
mod polygon;
mod sample;
mod window;

pub use limits::{FeedError, FeedLimits, LEAST_SAMPLES, NormLimits};
pub use sample::{PushError, Sample, ToolSample};

use crate::profile::{Phase, State};
use crate::scalar::within;
use average::Average;
use inner::{Heading, Inner, Wall};
use intake::Pending;
use limits::Plan;
use window::Window;

/// What the motion does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// It moves, or is about to.
    Moving,
    /// At rest because the override is 0.
    Held,
    /// At rest at the last sample that may be reached: waiting for more.
    Waiting,
    /// At rest at the oldest retained sample, with a negative override.
    AtStart,
    /// At rest at the end of the path, exactly.
    Done,
}

/// One macrostep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// s during the macrostep: a cubic of time; see [`Phase::at`].
    pub phase: Phase,
    /// s and its derivatives at its end (jerk: until then).
    pub end: State,
    /// What the motion does.
    pub status: Status,
}

/// s(t) along a path of N joints, with room for W samples and for a mean over up to M macrosteps.
///
/// ```
/// use motion::AxisLimits;
/// use motion::feed::{Feed, FeedLimits, NormLimits, Sample, Status, ToolSample};
/// let limits = FeedLimits {
///     joints: [AxisLimits { v: 1.0, a: 5.0, j: 100.0 }],
///     linear: NormLimits::default(),
///     angular: NormLimits::default(),
/// };
/// // one joint turns by 1 rad: q = s, a sample every 0.05
/// let mut feed = Feed::<1, 64, 16>::new(&limits, 0.05, 0.02)?;
/// let sample = Sample {
///     first: [1.0], second: [0.0], third: [0.0], tool: ToolSample::default(), feed: f64::INFINITY,
/// };
/// for _ in 0..20 {
///     feed.push(&sample)?;
/// }
/// feed.end_piece(&sample, 1.0)?;
/// feed.finish()?;
/// let mut step = feed.step(1.0);
/// while step.status != Status::Done {
///     step = feed.step(1.0);
/// }
/// assert!((step.end.p - 1.0).abs() < 1e-12 && step.end.v == 0.0 && step.end.a == 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Feed<const N: usize, const W: usize, const M: usize> {
    plan: Plan<N>,
    window: Window<N, W>,
    /// The last sample of an unfinished piece, which is used when the next one says how it goes on.
    pending: Option<Pending<N>>,
    begins: bool,
    next_s: f64,
    finished: bool,
    inner: Inner,
    /// First and last record of the present piece, and the wall ahead.
    first: usize,
    front: usize,
    average: Average<M>,
}

/// Longest hold that [`Feed::stops_at`] looks at, in macrosteps.
pub const MOST_HOLD_STEPS: usize = 1024;

/// What a macrostep reads.
struct Known<'a, const N: usize, const W: usize> {
    window: &'a Window<N, W>,
    plan: &'a Plan<N>,
    wall: Wall,
}

impl<const N: usize, const W: usize> Known<'_, N, W> {
    fn advance<const M: usize>(
        &self,
        inner: &mut Inner,
        average: &mut Average<M>,
        feed_override: f64,
    ) -> Phase {
        let side = inner.heading.side();
        let behind = average.behind(side, self.plan);
        let now = inner.step(self.window, self.wall, behind, feed_override, self.plan);
        average.step(now, inner.s, side * inner.speed, self.plan)
    }
}

impl<const N: usize, const W: usize, const M: usize> Feed<N, W, M> {
    /// At rest at s = 0, the first sample; `grid` is Δs, `macrostep_s` is h.
    ///
    /// # Errors
    /// [`FeedError`].
    pub fn new(limits: &FeedLimits<N>, grid: f64, macrostep_s: f64) -> Result<Self, FeedError> {
        let mut feed = Self::nothing();
        feed.begin(limits, grid, macrostep_s)?;
        Ok(feed)
    }

    /// No path: it takes no samples, and its steps rest, [`Status::Done`]. A place in which one may
    /// [`begin`](Self::begin).
    #[must_use]
    #[expect(
        clippy::inline_always,
        reason = "so that what is large is made where it stays, and not on the stack"
    )]
    #[inline(always)]
    pub const fn nothing() -> Self {
        Self {
            plan: Plan::NOTHING,
            window: Window::new(),
            pending: None,
            begins: true,
            next_s: 0.0,
            finished: true,
            inner: Inner::START,
            first: 0,
            front: 0,
            average: Average::new(),
        }
    }

    /// Another path, in the same place: as [`new`](Self::new), without moving what is large.
    ///
    /// # Errors
    /// [`FeedError`]; nothing has changed then.
    pub fn begin(
        &mut self,
        limits: &FeedLimits<N>,
        grid: f64,
        macrostep_s: f64,
    ) -> Result<(), FeedError> {
        self.plan = Plan::new(limits, grid, macrostep_s, W, M)?;
        self.window.clear();
        self.pending = None;
        self.begins = true;
        self.next_s = 0.0;
        self.finished = false;
        self.inner = Inner::START;
        self.first = 0;
        self.front = 0;
        self.average = Average::new();
        Ok(())
    }

    /// The time over which the motion is averaged, s: it comes to rest this much after the inner one.
    #[must_use]
    pub fn smoothing_s(&self) -> f64 {
        self.plan.tau
    }

    /// One macrostep, with an override in \[−1, 1\] of the programmed feed.
    ///
    /// The speed asked for is the override times the programmed feed (where none is programmed, times
    /// the speed limits at that sample), held under the envelope. 0 is a feed hold: the hardest
    /// braking that limits allow. Negative: back, after coming to rest. Not a number counts as 0.
    // a frame of its own: what else its caller does must not lie below it on the stack
    #[inline(never)]
    pub fn step(&mut self, feed_override: f64) -> Step {
        let feed_override = if feed_override.is_nan() {
            0.0
        } else {
            within(feed_override, -1.0, 1.0)
        };
        if self.inner.speed <= 0.0 {
            self.turn(feed_override);
        }
        let wall = self.extend();
        let known = Known {
            window: &self.window,
            plan: &self.plan,
            wall,
        };
        let phase = known.advance(&mut self.inner, &mut self.average, feed_override);
        let end = self.average.end();
        Step {
            phase,
            end,
            status: self.status(&end, feed_override, wall),
        }
    }

    /// Where on the path a feed hold would come to rest if it began with the next macrostep.
    ///
    /// Found by making the macrosteps of the inner motion, at most [`MOST_HOLD_STEPS`] of them; the
    /// wall, if it is not at rest by then.
    #[must_use]
    pub fn stops_at(&self) -> f64 {
        let wall = self.wall();
        let known = Known {
            window: &self.window,
            plan: &self.plan,
            wall,
        };
        let (mut inner, mut average) = (self.inner, self.average.clone());
        for _ in 0..MOST_HOLD_STEPS {
            if inner.speed <= 0.0 {
                return inner.s;
            }
            known.advance(&mut inner, &mut average, 0.0);
        }
        self.window.get(wall.record).map_or(inner.s, |r| r.s)
    }

    fn wall(&self) -> Wall {
        Wall {
            record: match self.inner.heading {
                Heading::Forward => self.front,
                Heading::Backward => self.first,
            },
        }
    }

    /// At rest: goes on to another piece, or the other way.
    fn turn(&mut self, feed_override: f64) {
        let heading = if feed_override > 0.0 {
            Heading::Forward
        } else if feed_override < 0.0 {
            Heading::Backward
        } else {
            return;
        };
        if heading != self.inner.heading {
            self.inner.heading = heading;
            self.renew();
        }
        // the smoothed motion must rest too, before the path may bend
        let out = self.average.end();
        let drained = out.v.abs() <= 0.0 && out.a.abs() <= 0.0;
        let Some((a, b)) = self.window.cell(self.inner.cell) else {
            return;
        };
        match heading {
            Heading::Forward if drained && b.ends && self.inner.s >= b.s => {
                let after = self.inner.cell.saturating_add(2);
                if self.window.cell(after).is_some() {
                    self.inner.cell = after;
                    self.renew();
                }
            }
            Heading::Backward if drained && a.begins && self.inner.s <= a.s => {
                if self.inner.cell >= 2 {
                    self.inner.cell -= 2;
                    self.renew();
                }
            }
            Heading::Forward | Heading::Backward => {}
        }
    }

    /// All that depends on the piece and the heading, anew.
    fn renew(&mut self) {
        let (first, last) = self.window.piece(self.inner.cell);
        self.first = first;
        self.window.clear_envelope(first, last);
        match self.inner.heading {
            Heading::Forward => {
                self.front = self.inner.cell;
                let last = Wall { record: last };
                self.inner.find_cell(&self.window, last);
                self.front = self.inner.cell;
            }
            Heading::Backward => {
                self.inner.find_cell(&self.window, Wall { record: first });
                let cell = self.inner.cell;
                self.window.envelope_backward(first, cell, &self.plan);
            }
        }
    }

    /// Moves the wall on as far as all samples beyond it are known that bear on the steps before it.
    fn extend(&mut self) -> Wall {
        if self.inner.heading == Heading::Backward {
            return self.wall();
        }
        let known = self.front;
        let mut surveys = 0;
        for _ in 0..W {
            let Some(record) = self.window.get(self.front) else {
                break;
            };
            if record.ends {
                break;
            }
            if record.bounds.is_none() {
                if surveys >= self.plan.most_surveys || !self.window.survey(self.front, &self.plan)
                {
                    break;
                }
                surveys = surveys.saturating_add(1);
            }
            self.front = self.front.saturating_add(1);
        }
        if self.front > known {
            let (cell, front) = (self.inner.cell, self.front);
            self.window.envelope_forward(cell, known, front, &self.plan);
        }
        let wall = self.wall();
        self.inner.find_cell(&self.window, wall);
        wall
    }

    fn status(&self, end: &State, feed_override: f64, wall: Wall) -> Status {
        let rests = self.inner.speed <= 0.0 && end.v.abs() <= 0.0 && end.a.abs() <= 0.0;
        if !rests {
            return Status::Moving;
        }
        let (forward, side) = (
            self.inner.heading == Heading::Forward,
            self.inner.heading.side(),
        );
        let at = self.window.get(wall.record);
        let at_wall = at.is_none_or(|r| side * (r.s - self.inner.s) <= 0.0);
        // where the next piece, or the next sample of this one, is not known
        let after = wall.record.saturating_add(1);
        let nothing = at.is_none_or(|r| !r.ends || self.window.cell(after).is_none());
        let last = self.finished && after >= self.window.len();
        if forward && at_wall && last && nothing {
            Status::Done
        } else if feed_override.abs() <= 0.0 {
            Status::Held
        } else if forward && at_wall && nothing && feed_override > 0.0 {
            Status::Waiting
        } else if !forward && at_wall && wall.record == 0 && feed_override < 0.0 {
            Status::AtStart
        } else {
            Status::Moving
        }
    }
}
