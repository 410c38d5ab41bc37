//! Several axes from any state to any state, in the shortest time.

use super::blend::Phases;
use super::brake::{Brake, INSIDE};
use super::earliest::{Arrival, Verdict};
use super::farthest::Task;
use super::rest::RestToRest;
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
    /// Which axis, from 0.
    pub axis: usize,
    /// What is wrong with it.
    pub reason: ProfileError,
}

impl fmt::Display for TrajectoryError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "axis {}: {}", self.axis + 1, self.reason)
    }
}

impl core::error::Error for TrajectoryError {}

/// A time-optimal jerk-limited motion of N axes.
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
    /// # Errors
    /// [`TrajectoryError`]; the motion is empty then.
    pub fn plan(&mut self, request: &Request<N>) -> Result<(), TrajectoryError> {
        match plan(request, &mut self.axes) {
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

    /// The states t seconds after the beginning. Before it, the first; from an axis' end on, it goes on with its end velocity and acceleration.
    #[must_use]
    pub fn at(&self, t: f64) -> [State; N] {
        let mut states = [State::default(); N];
        for (state, axis) in states.iter_mut().zip(&self.axes) {
            *state = axis.at(t);
        }
        states
    }

    /// The phases of one axis in order, none beyond the last axis.
    pub fn phases(&self, axis: usize) -> impl Iterator<Item = Phase> + '_ {
        self.axes.get(axis).into_iter().flat_map(|axis| axis.as_slice().iter().copied())
    }
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
    Moving { brake: Brake, arrival: Arrival },
}

impl Axis {
    fn new(task: &Task) -> Option<Self> {
        let axis = if let Some(way) = RestToRest::of(task) {
            Self { earliest: way.time, way: Way::AtRest(way) }
        } else {
            let brake = Brake::of(task);
            let arrival = Arrival::new(brake.applied(task));
            Self {
                earliest: arrival.earliest()? + brake.duration(),
                way: Way::Moving { brake, arrival },
            }
        };
        axis.earliest.is_finite().then_some(axis)
    }
}

fn plan<const N: usize>(
    request: &Request<N>,
    out: &mut [Phases; N],
) -> Result<f64, TrajectoryError> {
    let refused = |axis: usize| move |reason: ProfileError| TrajectoryError { axis, reason };
    let mut duration = request.minimum_duration;
    if !duration.is_finite() || duration < 0.0 {
        return Err(refused(0)(ProfileError::NotFinite));
    }
    let mut axes = [None; N];
    let each = request.start.iter().zip(&request.end).zip(&request.bounds);
    for (i, (slot, ((start, end), bounds))) in axes.iter_mut().zip(each).enumerate() {
        let task = task(start, end, bounds).map_err(refused(i))?;
        let axis = Axis::new(&task).ok_or(refused(i)(ProfileError::NotRepresentable))?;
        duration = larger(duration, axis.earliest);
        *slot = Some(axis);
    }
    // Every axis has at most three times before which it cannot arrive.
    let most = N.saturating_mul(4).saturating_add(1);
    for _ in 0..most {
        match draw(request, &axes, duration, out).map_err(refused(0))? {
            Some(later) => duration = later,
            None => return Ok(duration),
        }
    }
    Err(refused(0)(ProfileError::NotRepresentable))
}

/// Writes the motion of every axis that arrives at `duration`; a later time if one of them cannot.
fn draw<const N: usize>(
    request: &Request<N>,
    axes: &[Option<Axis>; N],
    duration: f64,
    out: &mut [Phases; N],
) -> Result<Option<f64>, ProfileError> {
    let mut later = None;
    let each = request.start.iter().zip(&request.end).zip(&request.bounds);
    for ((axis, out), ((start, end), bounds)) in axes.iter().flatten().zip(out).zip(each) {
        let time = match request.synchronisation {
            Synchronisation::None => larger(axis.earliest, request.minimum_duration),
            Synchronisation::Time => duration,
        };
        let mut pen = out.pen(start, end, bounds.j_max);
        match &axis.way {
            Way::AtRest(way) => pen.stretch(way, time),
            Way::Moving { brake, arrival } => {
                let braking = brake.duration();
                match arrival.at(time - braking) {
                    Verdict::Possible(between) => pen.arrive(brake, arrival, &between),
                    Verdict::NotBefore(time) => {
                        later = Some(larger(time + braking, later.unwrap_or(duration)));
                    }
                    Verdict::Never => return Err(ProfileError::NotRepresentable),
                }
            }
        }
    }
    Ok(later.filter(|time| *time > duration))
}

/// The task in units of the jerk limit.
fn task(start: &Boundary, end: &Boundary, bounds: &AxisBounds) -> Result<Task, ProfileError> {
    bounds.validate()?;
    let all = [start.p, start.v, start.a, end.p, end.v, end.a];
    if all.iter().any(|x| !x.is_finite()) {
        return Err(ProfileError::NotFinite);
    }
    let per = 1.0 / bounds.j_max;
    let task = Task {
        v0: start.v * per,
        a0: start.a * per,
        v1: end.v * per,
        a1: end.a * per,
        distance: (end.p - start.p) * per,
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
