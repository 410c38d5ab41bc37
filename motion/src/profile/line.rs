//! States that lie on one straight line: all axes move in proportion.

use super::blend::Phases;
use super::trajectory::{Request, Synchronisation, Trajectory, TrajectoryError};
use super::{AxisBounds, Boundary, ProfileError};
use crate::scalar::{larger, smaller};

/// Relative deviation from proportion that counts as rounding.
const PROPORTION: f64 = 1e-12;
/// Kept below each limit, so that the rounding of a direction never exceeds it.
const ROUNDING_MARGIN: f64 = 1.0 - 1e-14;

/// A motion of all axes along the way from start to end, as that of a parameter from 0 to 1.
pub(super) struct Line {
    start: Boundary,
    end: Boundary,
    bounds: AxisBounds,
}

impl Line {
    /// Nothing if the states do not lie on a line, or the ends are one point.
    pub(super) fn of<const N: usize>(request: &Request<N>) -> Option<Self> {
        let axes = || request.start.iter().zip(&request.end).zip(&request.bounds);
        let mut leading = (0.0, 0.0, 0.0, 0.0, 0.0);
        for ((start, end), _) in axes() {
            let d = end.p - start.p;
            if d.abs() > libm::fabs(leading.0) {
                leading = (d, start.v, start.a, end.v, end.a);
            }
        }
        let (d, v0, a0, v1, a1) = leading;
        if d == 0.0 {
            return None;
        }
        let (v0, a0, v1, a1) = (v0 / d, a0 / d, v1 / d, a1 / d);
        let infinity = f64::INFINITY;
        let mut bounds = AxisBounds {
            v_min: -infinity,
            v_max: infinity,
            a_min: -infinity,
            a_max: infinity,
            j_max: infinity,
            p_min: -infinity,
            p_max: infinity,
        };
        for ((start, end), axis) in axes() {
            let d = end.p - start.p;
            for (value, factor, limit) in [
                (start.v, v0, larger(axis.v_max, -axis.v_min)),
                (start.a, a0, larger(axis.a_max, -axis.a_min)),
                (end.v, v1, larger(axis.v_max, -axis.v_min)),
                (end.a, a1, larger(axis.a_max, -axis.a_min)),
            ] {
                let deviation = libm::fabs(value - factor * d);
                if !(deviation <= PROPORTION * smaller(limit, libm::fabs(value))
                    || deviation == 0.0)
                {
                    return None;
                }
            }
            if d == 0.0 {
                continue;
            }
            let (size, ahead) = (libm::fabs(d), d > 0.0);
            let along = |low: f64, high: f64, offset: f64| {
                let (low, high) = ((low - offset) / size, (high - offset) / size);
                if ahead { (low, high) } else { (-high, -low) }
            };
            let (v_low, v_high) = along(axis.v_min, axis.v_max, 0.0);
            let (a_low, a_high) = along(axis.a_min, axis.a_max, 0.0);
            let (p_low, p_high) = along(axis.p_min, axis.p_max, start.p);
            bounds.v_min = larger(bounds.v_min, ROUNDING_MARGIN * v_low);
            bounds.v_max = smaller(bounds.v_max, ROUNDING_MARGIN * v_high);
            bounds.a_min = larger(bounds.a_min, ROUNDING_MARGIN * a_low);
            bounds.a_max = smaller(bounds.a_max, ROUNDING_MARGIN * a_high);
            bounds.j_max = smaller(bounds.j_max, ROUNDING_MARGIN * axis.j_max / size);
            bounds.p_min = larger(bounds.p_min, smaller(p_low, 0.0));
            bounds.p_max = smaller(bounds.p_max, larger(p_high, 1.0));
        }
        Some(Self {
            start: Boundary {
                p: 0.0,
                v: v0,
                a: a0,
            },
            end: Boundary {
                p: 1.0,
                v: v1,
                a: a1,
            },
            bounds,
        })
    }

    /// Plans the parameter, and every axis as many times as far as it has to go.
    pub(super) fn plan<const N: usize>(
        &self,
        request: &Request<N>,
        out: &mut [Phases; N],
    ) -> Result<f64, TrajectoryError> {
        for (number, (start, (end, bounds))) in request
            .start
            .iter()
            .zip(request.end.iter().zip(&request.bounds))
            .enumerate()
        {
            let inside = |p: f64| p >= bounds.p_min && p <= bounds.p_max;
            let valid = bounds.validate().and_then(|()| {
                if inside(start.p) && inside(end.p) {
                    Ok(())
                } else {
                    Err(ProfileError::OutsideRange)
                }
            });
            valid.map_err(|reason| TrajectoryError {
                axis: Some(number),
                reason,
            })?;
        }
        let parameter = Trajectory::<1>::new(&Request {
            start: [self.start],
            end: [self.end],
            bounds: [self.bounds],
            synchronisation: Synchronisation::Time,
            minimum_duration: request.minimum_duration,
        })
        .map_err(|error| TrajectoryError {
            axis: None,
            ..error
        })?;
        let [shared] = parameter.axes();
        for (axis, (start, end)) in out.iter_mut().zip(request.start.iter().zip(&request.end)) {
            *axis = shared.times(end.p - start.p, start.p, *end);
        }
        Ok(shared.duration())
    }
}
