//! The planner for any number of axes, and the proof of what it made.

use std::{fmt, iter};

use motion::profile::{
    AxisBounds, Boundary, Phase, ProfileError, Request, Synchronisation, Trajectory,
    TrajectoryError, Violation, check,
};

/// The most axes of a motion: the planner is compiled for each number of them.
pub(super) const MOST_AXES: usize = 16;

/// What is asked of the planner; the three lists are of one length.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Asked {
    pub(super) start: Vec<Boundary>,
    pub(super) end: Vec<Boundary>,
    pub(super) bounds: Vec<AxisBounds>,
    pub(super) synchronisation: Synchronisation,
    pub(super) minimum_duration: f64,
}

/// A motion that was proved.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Motion {
    /// s
    pub(super) duration: f64,
    /// The phases of every axis.
    pub(super) axes: Vec<Vec<Phase>>,
}

/// Why there is no motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum NoMotion {
    /// The planner refuses.
    Refused(TrajectoryError),
    /// The planner is wrong: the checker refuses what it made.
    Unproved { axis: usize, violation: Violation },
}

impl NoMotion {
    /// A word for it, for programs.
    pub(super) const fn code(&self) -> &'static str {
        match self {
            Self::Unproved { .. } => "unproved",
            Self::Refused(error) => match error.reason {
                ProfileError::NotFinite => "not-finite",
                ProfileError::NegativeDistance => "negative-distance",
                ProfileError::NonPositiveLimit => "non-positive-limit",
                ProfileError::EndOutsideLimits => "end-outside-limits",
                ProfileError::OutsideRange => "outside-range",
                ProfileError::LeavesRange => "leaves-range",
                ProfileError::NotRepresentable => "not-representable",
            },
        }
    }

    /// Which axis, from 0, if it is one of them.
    pub(super) const fn axis(&self) -> Option<usize> {
        match self {
            Self::Refused(error) => error.axis,
            Self::Unproved { axis, .. } => Some(*axis),
        }
    }
}

impl fmt::Display for NoMotion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Refused(error) => error.fmt(f),
            Self::Unproved { axis, violation } => write!(
                f,
                "internal error: the motion planned for axis {} is wrong: {violation}; please report it",
                axis + 1
            ),
        }
    }
}

impl Asked {
    /// The motion, proved; nothing if the number of axes is not 1 to [`MOST_AXES`].
    pub(super) fn plan(&self) -> Option<Result<Motion, NoMotion>> {
        match self.start.len() {
            1 => self.plan_axes::<1>(),
            2 => self.plan_axes::<2>(),
            3 => self.plan_axes::<3>(),
            4 => self.plan_axes::<4>(),
            5 => self.plan_axes::<5>(),
            6 => self.plan_axes::<6>(),
            7 => self.plan_axes::<7>(),
            8 => self.plan_axes::<8>(),
            9 => self.plan_axes::<9>(),
            10 => self.plan_axes::<10>(),
            11 => self.plan_axes::<11>(),
            12 => self.plan_axes::<12>(),
            13 => self.plan_axes::<13>(),
            14 => self.plan_axes::<14>(),
            15 => self.plan_axes::<15>(),
            MOST_AXES => self.plan_axes::<MOST_AXES>(),
            _ => None,
        }
    }

    fn plan_axes<const N: usize>(&self) -> Option<Result<Motion, NoMotion>> {
        let request = Request::<N> {
            start: self.start.as_slice().try_into().ok()?,
            end: self.end.as_slice().try_into().ok()?,
            bounds: self.bounds.as_slice().try_into().ok()?,
            synchronisation: self.synchronisation,
            minimum_duration: self.minimum_duration,
        };
        Some(match Trajectory::new(&request) {
            Ok(trajectory) => {
                let axes = (0..N)
                    .map(|axis| trajectory.phases(axis).to_vec())
                    .collect();
                let motion = Motion {
                    duration: trajectory.duration(),
                    axes,
                };
                self.prove(&motion).map(|()| motion)
            }
            Err(error) => Err(NoMotion::Refused(error)),
        })
    }

    /// Proves a motion from its phases alone: from the asked start to the asked end, inside the bounds.
    pub(super) fn prove(&self, motion: &Motion) -> Result<(), NoMotion> {
        let asked = self.start.iter().zip(&self.end).zip(&self.bounds);
        // an axis that is not planned has no phases: proved only where start and end are one
        let planned = motion
            .axes
            .iter()
            .map(Vec::as_slice)
            .chain(iter::repeat(&[][..]));
        for (axis, (((start, end), bounds), phases)) in asked.zip(planned).enumerate() {
            check(phases, start, end, bounds)
                .map_err(|violation| NoMotion::Unproved { axis, violation })?;
        }
        Ok(())
    }
}
