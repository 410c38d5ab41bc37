//! Several axes from rest to rest on the straight line between two points.

use super::{AxisLimits, Boundary, Phase, Profile, ProfileError, State, Violation, check};
use crate::scalar::{larger, smaller};

/// Kept below each limit on a line, so that the rounding of a direction never exceeds it.
const ROUNDING_MARGIN: f64 = 1.0 - 1e-14;

fn displacements<const N: usize>(
    start: &[f64; N],
    end: &[f64; N],
) -> Result<[f64; N], ProfileError> {
    let mut moves = [0.0; N];
    for ((d, from), to) in moves.iter_mut().zip(start).zip(end) {
        *d = to - from;
        if !d.is_finite() {
            return Err(ProfileError::NotFinite);
        }
    }
    Ok(moves)
}

/// All axes share one shape: the set-point stays on the straight line between start and end.
///
/// The scalar profile runs over the longest axis' distance with the limits that the tightest axis
/// leaves: min over axes of limitᵢ/|directionᵢ|, where the longest axis has direction ±1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhaseSynchronised<const N: usize> {
    start: [f64; N],
    end: [f64; N],
    direction: [f64; N],
    profile: Profile,
}

impl<const N: usize> PhaseSynchronised<N> {
    /// The fastest motion on the straight line.
    ///
    /// # Errors
    /// As [`Profile::new`], for any axis.
    pub fn new(
        start: [f64; N],
        end: [f64; N],
        limits: &[AxisLimits; N],
    ) -> Result<Self, ProfileError> {
        let moves = displacements(&start, &end)?;
        let longest = moves.iter().fold(0.0, |m, d| larger(m, d.abs()));
        let mut direction = [0.0; N];
        let unlimited = AxisLimits {
            v: f64::INFINITY,
            a: f64::INFINITY,
            j: f64::INFINITY,
        };
        let mut shared = unlimited;
        for ((k, d), limit) in direction.iter_mut().zip(&moves).zip(limits) {
            limit.validate()?;
            if longest > 0.0 {
                *k = d / longest;
            }
            if k.abs() > 0.0 {
                shared.v = smaller(shared.v, ROUNDING_MARGIN * (limit.v / k.abs()));
                shared.a = smaller(shared.a, ROUNDING_MARGIN * (limit.a / k.abs()));
                shared.j = smaller(shared.j, ROUNDING_MARGIN * (limit.j / k.abs()));
            }
        }
        let profile = if longest > 0.0 {
            Profile::new(longest, &shared)?
        } else {
            Profile::nothing()
        };
        Ok(Self {
            start,
            end,
            direction,
            profile,
        })
    }

    /// Length in time, s.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.profile.duration()
    }

    /// The states t seconds after the beginning; exactly at the end positions from the end on.
    #[must_use]
    pub fn at(&self, t: f64) -> [State; N] {
        let s = self.profile.at(t);
        let arrived = t >= self.duration();
        let mut states = [State::default(); N];
        let axes = self.start.iter().zip(&self.end).zip(&self.direction);
        for (state, ((from, to), k)) in states.iter_mut().zip(axes) {
            *state = State {
                p: if arrived { *to } else { from + k * s.p },
                v: k * s.v,
                a: k * s.a,
                j: k * s.j,
            };
        }
        states
    }

    /// The phases of one axis, positions counted from its start; `None` beyond the last axis.
    #[must_use]
    pub fn phases(&self, axis: usize) -> Option<[Phase; 7]> {
        let k = self.direction.get(axis)?;
        Some(self.profile.phases().map(|phase| phase.times(*k)))
    }

    /// Proves every axis with [`check`](super::check()).
    ///
    /// # Errors
    /// The axis and its first violation.
    pub fn check(&self, limits: &[AxisLimits; N]) -> Result<(), (usize, Violation)> {
        let phases = self.profile.phases();
        let axes = self.start.iter().zip(&self.end).zip(&self.direction);
        for (axis, (((from, to), k), limit)) in axes.zip(limits).enumerate() {
            let end = Boundary {
                p: to - from,
                ..Boundary::default()
            };
            let phases = phases.map(|phase| phase.times(*k));
            check(&phases, &Boundary::default(), &end, &(*limit).into()).map_err(|v| (axis, v))?;
        }
        Ok(())
    }
}
