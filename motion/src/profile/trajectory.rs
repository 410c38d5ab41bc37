//! Several axes from any state to any state, in the shortest time.

use super::blend::Phases;
use super::brake::{Brake, INSIDE};
use super::check::{Violation, check};
use super::earliest::{Arrival, Verdict};
use super::farthest::Task;
use super::gain::Gain;
use super::line::Line;
use super::rest::RestToRest;
use super::turn::{Turn, leaves};
use super::{AxisBounds, Boundary, Phase, ProfileError, State};
use crate::scalar::{larger, smaller};
use core::fmt;

/// Whether and how the axes wait for each other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Synchronisation {
    /// Every axis arrives as early as it can.
    None,
    /// All axes arrive together, at the earliest time at which all can.
    #[default]
    Time,
    /// The axes stay on a straight line, where all states lie on one: all velocities and accelerations are
    /// along the way from start to end. Else as [`Time`](Self::Time).
    Phase,
}

/// What is asked of a [`Trajectory`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Request<const N: usize> {
    /// Where the axes are and how they move.
    pub start: [Boundary; N],
    /// Where they shall be and how they shall move there.
    pub end: [Boundary; N],
    /// What they can bear.
    pub bounds: [AxisBounds; N],
    /// Whether they wait for each other.
    pub synchronisation: Synchronisation,
    /// Not shorter than this, s; 0 for as short as possible.
    pub minimum_duration: f64,
}

/// Why a trajectory cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TrajectoryError {
    /// Which axis, from 0; nothing if it is not one of them.
    pub axis: Option<usize>,
    /// What is wrong with it.
    pub reason: ProfileError,
}

impl fmt::Display for TrajectoryError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.axis {
            Some(axis) => write!(f, "axis {}: {}", axis + 1, self.reason),
            None => self.reason.fmt(f),
        }
    }
}

impl core::error::Error for TrajectoryError {}

/// A time-optimal jerk-limited motion of N axes.
///
/// ```
/// use motion::profile::{AxisLimits, Boundary, Request, Synchronisation, Trajectory};
/// let bounds = [AxisLimits { v: 1.0, a: 2.0, j: 10.0 }.into(); 2];
/// let moving = Boundary { p: 0.0, v: 0.5, a: -0.2 };
/// let request = Request {
///     start: [moving, Boundary::default()],
///     end: [Boundary { p: 1.0, ..Boundary::default() }, Boundary { p: -0.3, ..Boundary::default() }],
///     bounds,
///     synchronisation: Synchronisation::Time,
///     minimum_duration: 0.0,
/// };
/// let trajectory = Trajectory::new(&request)?;
/// assert_eq!(trajectory.at(trajectory.duration())[0].p, 1.0);
/// assert_eq!(trajectory.check(&request), Ok(()));
/// # Ok::<(), motion::profile::TrajectoryError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory<const N: usize> {
    axes: [Phases; N],
    duration: f64,
}

impl<const N: usize> Trajectory<N> {
    /// No motion: to be filled by [`Self::plan`].
    #[must_use]
    pub const fn empty() -> Self {
        Self {
            axes: [const { Phases::new() }; N],
            duration: 0.0,
        }
    }

    /// The fastest motion that was asked for.
    ///
    /// # Errors
    /// As [`Self::plan`].
    pub fn new(request: &Request<N>) -> Result<Self, TrajectoryError> {
        let mut trajectory = Self::empty();
        trajectory.plan(request)?;
        Ok(trajectory)
    }

    /// Replaces the motion by the fastest one that was asked for: the way to plan again and again.
    ///
    /// An axis that starts outside its limits of velocity or acceleration is brought back inside as fast as
    /// possible, and goes on from there. An axis with a range of positions keeps to it: where the fastest
    /// motion would leave the range, it turns at its end.
    ///
    /// # Errors
    /// [`TrajectoryError`]; the motion is empty then.
    pub fn plan(&mut self, request: &Request<N>) -> Result<(), TrajectoryError> {
        let planned = if request.synchronisation == Synchronisation::Phase
            && let Some(line) = Line::of(request)
        {
            line.plan(request, &mut self.axes)
        } else {
            plan(request, Goal::State, &mut self.axes)
        };
        self.take(planned)
    }

    /// Replaces the motion by the fastest one to the velocities and accelerations of `request.end`, wherever
    /// that leads: its positions are not looked at, nor are ranges. With both zero, this is a stop.
    ///
    /// An axis that must wait for others keeps the velocity it has come to. If it must arrive with an acceleration,
    /// it waits before that, at the velocity at which the acceleration of its start has ended; where there is
    /// less time than that takes, it does not wait but goes between the extremal ways, and if that
    /// broke a limit all arrive later.
    ///
    /// # Errors
    /// [`TrajectoryError`]; the motion is empty then.
    pub fn plan_velocity(&mut self, request: &Request<N>) -> Result<(), TrajectoryError> {
        let planned = plan(request, Goal::Velocity, &mut self.axes);
        self.take(planned)
    }

    fn take(&mut self, planned: Result<f64, TrajectoryError>) -> Result<(), TrajectoryError> {
        match planned {
            Ok(duration) => {
                self.duration = duration;
                Ok(())
            }
            Err(error) => {
                self.duration = 0.0;
                for axis in &mut self.axes {
                    axis.clear();
                }
                Err(error)
            }
        }
    }

    /// Length in time, s: that of the last axis.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// The states t seconds after the beginning; before it, the first. From its end on an axis goes on with
    /// the velocity and acceleration it has there.
    #[must_use]
    pub fn at(&self, t: f64) -> [State; N] {
        let mut states = [State::default(); N];
        for (state, axis) in states.iter_mut().zip(&self.axes) {
            *state = axis.at(t);
        }
        states
    }

    /// The same for times in ascending order, in a step each.
    #[must_use]
    pub fn sampler(&self) -> Sampler<'_, N> {
        Sampler {
            trajectory: self,
            places: [Place {
                phase: 0,
                begin: 0.0,
            }; N],
        }
    }

    /// The phases of one axis in order, none beyond the last axis.
    #[must_use]
    pub fn phases(&self, axis: usize) -> &[Phase] {
        self.axes.get(axis).map_or(&[], Phases::as_slice)
    }

    pub(super) fn axes(&self) -> &[Phases; N] {
        &self.axes
    }

    /// Where one axis is at the end of its phases.
    #[must_use]
    pub fn end(&self, axis: usize) -> Option<Boundary> {
        self.axes.get(axis).map(Phases::end)
    }

    /// Proves every axis with [`check`](super::check()): that it begins and ends as asked, within its bounds.
    ///
    /// The end's position is that of [`Self::end`], which [`Self::plan_velocity`] leaves to the motion.
    ///
    /// # Errors
    /// The first axis that breaks its promise, and how.
    pub fn check(&self, request: &Request<N>) -> Result<(), (usize, Violation)> {
        let each = Asked::of(request).zip(&self.axes);
        for (number, (asked, axis)) in each.enumerate() {
            let end = Boundary {
                p: axis.end().p,
                ..*asked.end
            };
            check(axis.as_slice(), asked.start, &end, asked.bounds).map_err(|v| (number, v))?;
        }
        Ok(())
    }
}

/// Reads a [`Trajectory`] forward in time.
#[derive(Clone, Debug)]
pub struct Sampler<'a, const N: usize> {
    trajectory: &'a Trajectory<N>,
    places: [Place; N],
}

#[derive(Clone, Copy, Debug)]
struct Place {
    phase: usize,
    /// When that phase begins.
    begin: f64,
}

impl<const N: usize> Sampler<'_, N> {
    /// The states t seconds after the beginning, as [`Trajectory::at`]; `t` is not below any asked before.
    pub fn at(&mut self, t: f64) -> [State; N] {
        let mut states = [State::default(); N];
        let each = states
            .iter_mut()
            .zip(&self.trajectory.axes)
            .zip(&mut self.places);
        for ((state, axis), place) in each {
            if t >= axis.duration() {
                *state = axis.at(t);
                continue;
            }
            let phases = axis.as_slice();
            *state = loop {
                let Some(phase) = phases.get(place.phase) else {
                    break axis.at(t);
                };
                let tau = t - place.begin;
                if tau < phase.t {
                    break phase.at(larger(tau, 0.0));
                }
                place.begin += phase.t;
                place.phase += 1;
            };
        }
        states
    }
}

/// What the ends of a request mean.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Goal {
    State,
    Velocity,
}

/// One axis, and its earliest arrival.
#[derive(Clone, Copy)]
struct Axis {
    way: Way,
    earliest: f64,
}

#[derive(Clone, Copy)]
enum Way {
    /// Given more time, the fastest motion is stretched.
    AtRest(RestToRest),
    /// Given more time, a mean of extremal motions.
    Moving {
        brake: Brake,
        arrival: Arrival,
        /// The earliest arrival after the brake, s.
        earliest: f64,
    },
    /// To a velocity.
    Gaining(Gain),
}

/// One axis of a request.
#[derive(Clone, Copy)]
struct Asked<'a> {
    start: &'a Boundary,
    end: &'a Boundary,
    bounds: &'a AxisBounds,
}

impl<'a> Asked<'a> {
    fn of<const N: usize>(request: &'a Request<N>) -> impl Iterator<Item = Self> {
        let ends = request.start.iter().zip(&request.end);
        ends.zip(&request.bounds)
            .map(|((start, end), bounds)| Self { start, end, bounds })
    }

    fn axis(&self, goal: Goal) -> Result<Axis, ProfileError> {
        let task = self.task(goal)?;
        let axis = match goal {
            Goal::Velocity => {
                let gain = Gain::new(&task);
                Some(Axis {
                    earliest: gain.earliest() + gain.brake.duration(),
                    way: Way::Gaining(gain),
                })
            }
            Goal::State => {
                if let Some(way) = RestToRest::of(&task) {
                    Some(Axis {
                        earliest: way.time,
                        way: Way::AtRest(way),
                    })
                } else {
                    let brake = Brake::of(&task);
                    let arrival = Arrival::new(brake.applied(&task));
                    arrival.earliest().map(|earliest| Axis {
                        earliest: earliest + brake.duration(),
                        way: Way::Moving {
                            brake,
                            arrival,
                            earliest,
                        },
                    })
                }
            }
        };
        let mut axis = axis.ok_or(ProfileError::NotRepresentable)?;
        if goal == Goal::State && self.bounds.has_range() {
            axis.earliest = self.earliest_in_range(&axis, &task)?;
        }
        if axis.earliest.is_finite() {
            Ok(axis)
        } else {
            Err(ProfileError::NotRepresentable)
        }
    }

    fn earliest_in_range(&self, axis: &Axis, task: &Task) -> Result<f64, ProfileError> {
        let mut scratch = Phases::new();
        let time = match self.draw(axis, axis.earliest, &mut scratch) {
            Ok(()) => axis.earliest,
            // where two ways meet, rounding may close the earlier one
            Err(Verdict::NotBefore(later)) if self.draw(axis, later, &mut scratch).is_ok() => later,
            Err(_) => return Err(ProfileError::NotRepresentable),
        };
        leaves(&scratch, self.bounds).map_or(Ok(time), |at| {
            let turn = Turn {
                task,
                start: self.start,
                end: self.end,
                bounds: self.bounds,
                at,
            };
            turn.earliest().ok_or(ProfileError::LeavesRange)
        })
    }

    /// Writes the motion that arrives at `time`.
    fn draw(&self, axis: &Axis, time: f64, out: &mut Phases) -> Result<(), Verdict> {
        let mut pen = out.pen(self.start, self.end, self.bounds.j_max);
        match &axis.way {
            Way::AtRest(way) => pen.stretch(way, time),
            Way::Gaining(gain) => {
                let brake = gain.brake.duration();
                let left = left_of(time, brake, gain.earliest());
                let paused = gain.is_timed().then(|| gain.paused());
                if let Some(paused) = &paused
                    && left + rounding(time) >= paused.earliest
                {
                    let pause = larger(left - paused.earliest, 0.0);
                    pen.gain_after(&gain.brake, paused, pause);
                    return Ok(());
                }
                let change = match gain.at(left) {
                    Err(Verdict::NotBefore(later)) if later - left <= rounding(time) => {
                        gain.at(later)
                    }
                    found => found,
                }
                .map_err(|verdict| verdict.after(brake))?;
                pen.gain(&gain.brake, &change);
                if let Some(paused) = paused
                    && left > gain.earliest()
                    && self.check(out).is_err()
                {
                    // a mean may pass a limit of velocity that the way with a pause keeps
                    return Err(Verdict::NotBefore(paused.earliest).after(brake));
                }
            }
            Way::Moving {
                brake,
                arrival,
                earliest,
            } => {
                let left = left_of(time, brake.duration(), *earliest);
                let verdict = match arrival.at(left) {
                    Verdict::NotBefore(later) if later - left <= rounding(time) => {
                        arrival.at(later)
                    }
                    verdict => verdict,
                };
                match verdict {
                    Verdict::Possible(between) => pen.arrive(brake, arrival, &between),
                    verdict => return Err(verdict.after(brake.duration())),
                }
            }
        }
        Ok(())
    }

    /// Proves a motion to the velocity asked for, wherever it ends.
    fn check(&self, phases: &Phases) -> Result<(), Violation> {
        let p = phases.end().p;
        let end = Boundary { p, ..*self.end };
        check(phases.as_slice(), self.start, &end, self.bounds)
    }

    /// The same, turned where it would leave the range.
    fn draw_in_range(&self, axis: &Axis, time: f64, out: &mut Phases) -> Result<(), Verdict> {
        self.draw(axis, time, out)?;
        if !self.bounds.has_range() {
            return Ok(());
        }
        let Some(at) = leaves(out, self.bounds) else {
            return Ok(());
        };
        let task = self.task(Goal::State).map_err(|_| Verdict::Never)?;
        let turn = Turn {
            task: &task,
            start: self.start,
            end: self.end,
            bounds: self.bounds,
            at,
        };
        let earliest = turn.earliest().ok_or(Verdict::Never)?;
        if time < earliest {
            return Err(Verdict::NotBefore(earliest));
        }
        turn.draw(out, time).ok_or(Verdict::Never)
    }

    /// The task in units of the jerk limit.
    fn task(&self, goal: Goal) -> Result<Task, ProfileError> {
        let Self { start, end, bounds } = *self;
        bounds.validate()?;
        let position = match goal {
            Goal::State => end.p,
            Goal::Velocity => start.p,
        };
        let all = [start.p, start.v, start.a, position, end.v, end.a];
        if all.iter().any(|x| !x.is_finite()) {
            return Err(ProfileError::NotFinite);
        }
        let inside = |p: f64| p >= bounds.p_min && p <= bounds.p_max;
        if goal == Goal::State && !(inside(start.p) && inside(end.p)) {
            return Err(ProfileError::OutsideRange);
        }
        let per = 1.0 / bounds.j_max;
        let task = Task {
            v0: start.v * per,
            a0: start.a * per,
            v1: end.v * per,
            a1: end.a * per,
            distance: (position - start.p) * per,
            v_up: bounds.v_max * per,
            v_down: -bounds.v_min * per,
            a_up: bounds.a_max * per,
            a_down: -bounds.a_min * per,
        };
        // coming from inside the limits, is the end state possible?
        let spare = |limit: f64| limit + INSIDE * limit;
        let top = task.v1 + 0.5 * smaller(task.a1, 0.0) * task.a1;
        let bottom = task.v1 - 0.5 * larger(task.a1, 0.0) * task.a1;
        if task.a1 > spare(task.a_up)
            || -task.a1 > spare(task.a_down)
            || top > spare(task.v_up)
            || -bottom > spare(task.v_down)
        {
            return Err(ProfileError::EndOutsideLimits);
        }
        Ok(task)
    }
}

/// What the rounding of sums may make of a time.
fn rounding(time: f64) -> f64 {
    2.0 * f64::EPSILON * time
}

/// What is left of a time after a brake. Their sum was rounded: just after the earliest arrival is at it, which
/// matters where the times after it are not possible.
fn left_of(time: f64, brake: f64, earliest: f64) -> f64 {
    let left = time - brake;
    if left - earliest <= rounding(time) {
        earliest
    } else {
        left
    }
}

/// Plans every axis into `out`; the length in time.
fn plan<const N: usize>(
    request: &Request<N>,
    goal: Goal,
    out: &mut [Phases; N],
) -> Result<f64, TrajectoryError> {
    let mut duration = request.minimum_duration;
    if !duration.is_finite() || duration < 0.0 {
        return Err(TrajectoryError {
            axis: None,
            reason: ProfileError::NotFinite,
        });
    }
    let mut axes = [None; N];
    for (number, (slot, asked)) in axes.iter_mut().zip(Asked::of(request)).enumerate() {
        let axis = asked.axis(goal).map_err(|reason| TrajectoryError {
            axis: Some(number),
            reason,
        })?;
        duration = larger(duration, axis.earliest);
        *slot = Some(axis);
    }
    // Every axis has at most three times before which it cannot arrive.
    let most = N.saturating_mul(4).saturating_add(1);
    for _ in 0..most {
        match draw(request, &axes, duration, out)? {
            Some(later) => duration = later,
            None => return Ok(duration),
        }
    }
    Err(TrajectoryError {
        axis: None,
        reason: ProfileError::NotRepresentable,
    })
}

/// Writes the motion of every axis that arrives at `duration`; a later time if one of them cannot.
fn draw<const N: usize>(
    request: &Request<N>,
    axes: &[Option<Axis>; N],
    duration: f64,
    out: &mut [Phases; N],
) -> Result<Option<f64>, TrajectoryError> {
    let mut latest = None;
    let each = axes.iter().flatten().zip(out).zip(Asked::of(request));
    for (number, ((axis, out), asked)) in each.enumerate() {
        let time = match request.synchronisation {
            Synchronisation::None => larger(axis.earliest, request.minimum_duration),
            Synchronisation::Time | Synchronisation::Phase => duration,
        };
        match asked.draw_in_range(axis, time, out) {
            Ok(()) => {
                out.settle();
                out.ends_at(time);
            }
            Err(Verdict::NotBefore(later)) if later > time => {
                latest = Some(larger(later, latest.unwrap_or(duration)));
            }
            Err(_) => {
                return Err(TrajectoryError {
                    axis: Some(number),
                    reason: ProfileError::NotRepresentable,
                });
            }
        }
    }
    Ok(latest)
}
