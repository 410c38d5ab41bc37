//! Limits of one axis, what can be wrong with a request, and the shortest time within limits.

use crate::scalar::{cube_root, larger};
use core::fmt;

/// Symmetric limits of one axis: |velocity| ≤ v, |acceleration| ≤ a, |jerk| ≤ j.
///
/// Units: the axis' unit (rad, m, or a path parameter) per s, s² and s³.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisLimits {
    /// Velocity limit.
    pub v: f64,
    /// Acceleration limit.
    pub a: f64,
    /// Jerk limit.
    pub j: f64,
}

impl AxisLimits {
    /// All three limits multiplied by one factor.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        Self {
            v: self.v * factor,
            a: self.a * factor,
            j: self.j * factor,
        }
    }

    /// # Errors
    /// [`ProfileError::NotFinite`] or [`ProfileError::NonPositiveLimit`].
    pub(crate) fn validate(&self) -> Result<(), ProfileError> {
        let all = [self.v, self.a, self.j];
        if all.iter().any(|x| !x.is_finite()) {
            return Err(ProfileError::NotFinite);
        }
        if all.iter().any(|x| *x <= 0.0) {
            return Err(ProfileError::NonPositiveLimit);
        }
        Ok(())
    }
}

/// Limits of one axis that may differ by direction, and the range of its positions.
///
/// Units: the axis' unit, per s, s² and s³.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisBounds {
    /// Lowest velocity, below 0.
    pub v_min: f64,
    /// Highest velocity, above 0.
    pub v_max: f64,
    /// Lowest acceleration, below 0.
    pub a_min: f64,
    /// Highest acceleration, above 0.
    pub a_max: f64,
    /// Limit of |jerk|, above 0.
    pub j_max: f64,
    /// Lowest position; -∞ where there is none.
    pub p_min: f64,
    /// Highest position; ∞ where there is none.
    pub p_max: f64,
}

impl From<AxisLimits> for AxisBounds {
    fn from(limits: AxisLimits) -> Self {
        Self {
            v_min: -limits.v,
            v_max: limits.v,
            a_min: -limits.a,
            a_max: limits.a,
            j_max: limits.j,
            p_min: f64::NEG_INFINITY,
            p_max: f64::INFINITY,
        }
    }
}

impl AxisBounds {
    /// Whether positions are limited at all.
    pub(super) fn has_range(&self) -> bool {
        self.p_min > f64::NEG_INFINITY || self.p_max < f64::INFINITY
    }

    /// # Errors
    /// [`ProfileError::NotFinite`] or [`ProfileError::NonPositiveLimit`].
    pub(crate) fn validate(&self) -> Result<(), ProfileError> {
        let magnitudes = [-self.v_min, self.v_max, -self.a_min, self.a_max, self.j_max];
        if magnitudes.iter().any(|x| !x.is_finite()) || self.p_min.is_nan() || self.p_max.is_nan() {
            return Err(ProfileError::NotFinite);
        }
        if magnitudes.iter().any(|x| *x <= 0.0) {
            return Err(ProfileError::NonPositiveLimit);
        }
        Ok(())
    }
}

/// Why a profile cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProfileError {
    /// A distance, position, limit or duration is infinite or not a number.
    NotFinite,
    /// A distance is negative: the sign of a motion is its caller's.
    NegativeDistance,
    /// A limit is zero or negative.
    NonPositiveLimit,
    /// The end state is outside the limits, or can only be reached from outside them.
    EndOutsideLimits,
    /// Start or end is outside the range of positions.
    OutsideRange,
    /// The axis cannot stop, or cannot come to its end state, without leaving the range of positions.
    LeavesRange,
    /// Some quantity of the motion is too large or too small for a floating-point number.
    NotRepresentable,
}

impl fmt::Display for ProfileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotFinite => "an argument is infinite or not a number",
            Self::NegativeDistance => "the distance is negative",
            Self::NonPositiveLimit => "a limit is not positive",
            Self::EndOutsideLimits => "the end state cannot be reached within the limits",
            Self::OutsideRange => "start or end is outside the range of positions",
            Self::LeavesRange => "the motion cannot keep to the range of positions",
            Self::NotRepresentable => "the motion is outside the range of floating point",
        })
    }
}

impl core::error::Error for ProfileError {}

/// The shortest time (s) over `distance` ≥ 0 from rest to rest: infinite or NaN for senseless input.
///
/// In closed form; a [`Profile`](super::Profile) of the same arguments takes this long.
#[must_use]
pub fn rest_time(distance: f64, limits: &AxisLimits) -> f64 {
    let AxisLimits { v, a, j } = *limits;
    let accelerating = if a / j * a > v {
        2.0 * libm::sqrt(v / j)
    } else {
        a / j + v / a
    };
    if distance >= v * accelerating {
        return accelerating + distance / v;
    }
    let tj = a / j;
    if distance >= 2.0 * a * tj * tj {
        tj + libm::sqrt(tj * tj + 4.0 * (distance / a))
    } else {
        4.0 * cube_root(0.5 * (larger(distance, 0.0) / j))
    }
}
