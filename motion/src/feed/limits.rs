//! What joints and tool can bear, and how much of it is spent on what.

use crate::profile::AxisLimits;
use crate::scalar::{larger, narrow, smaller};
use core::fmt;

/// Limits of the norm of one part of the tool's motion; `None`: not limited.
///
/// Linear: m/s, m/s², m/s³. Angular: rad/s, rad/s², rad/s³.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NormLimits {
    /// |velocity|
    pub v: Option<f64>,
    /// |acceleration|
    pub a: Option<f64>,
    /// |jerk|
    pub j: Option<f64>,
}

/// Limits of N joints and of the tool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FeedLimits<const N: usize> {
    /// Of every joint. A jerk limit may be infinite.
    pub joints: [AxisLimits; N],
    /// Of the tool's centre point.
    pub linear: NormLimits,
    /// Of the tool's turning.
    pub angular: NormLimits,
}

/// Why no feed can be made of these limits and steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FeedError {
    /// A limit, the grid or the macrostep is not a number, or infinite where it must not be.
    NotFinite,
    /// A limit, the grid or the macrostep is not positive.
    NotPositive,
    /// Fewer than [`LEAST_SAMPLES`] samples or no step of smoothing.
    NoRoom,
}

impl fmt::Display for FeedError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotFinite => "a limit, the grid or the macrostep is infinite or not a number",
            Self::NotPositive => "a limit, the grid or the macrostep is not positive",
            Self::NoRoom => "too few samples or steps of smoothing",
        })
    }
}

impl core::error::Error for FeedError {}

/// Fewest samples of a window: a quarter of it is behind, a quarter ahead of what a step may touch.
pub const LEAST_SAMPLES: usize = 16;
/// Least bound of the cells by which the wall moves on in a macrostep.
const LEAST_SURVEYS: usize = 6;
/// Share of every jerk limit for q'·j; the rest is for 3·q''·v·a + q'''·v³. A larger share shortens the
/// smoothing, τ = 2·A/(share·J), and with it every stop; a smaller one lets curves be run faster.
pub(super) const RAMP_SHARE: f64 = 0.65;
/// Part of that rest which q'''·v³ alone may take: what it leaves is for 3·q''·v·a.
pub(super) const CUBIC_SHARE: f32 = 0.5;
/// Kept below every limit, for what a choice in f32 is off. No term of a constraint is more than three times its limit
/// (|q'·u| one, |q''·x| two, of a norm the square), each is off by some units of 6e-8, and so are their sums of two or
/// three: 2e-6. The rest is room.
const ROUNDING_MARGIN: f64 = 1.0 - 2e-5;

/// The limits of one joint, or of one norm, as they are spent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Budget {
    /// |q'·v|
    pub(super) v: f32,
    /// |q'·u + q''·x|
    pub(super) a: f32,
    /// |q'·u|: at most a, and what the ramp share of jerk allows in the smoothing time.
    pub(super) ramp: f32,
    /// 3·|q''|·v·|a| + |q'''|·v³
    pub(super) bend: f32,
}

/// All limits, and the times of the discretisation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plan<const N: usize> {
    pub(super) joints: [Budget; N],
    pub(super) tool: [Budget; 2],
    /// Distance of the samples by s.
    pub(super) grid: f64,
    /// Macrostep, s.
    pub(super) step: f64,
    /// Macrosteps over which the motion is averaged; 0 without any jerk limit.
    pub(super) averaged: usize,
    /// The same in s.
    pub(super) tau: f64,
    /// Largest speed and acceleration by s that the window of samples can serve.
    pub(super) fastest: f64,
    pub(super) hardest: f64,
    /// Cells by which the wall may move on in a macrostep.
    pub(super) most_surveys: usize,
}

impl<const N: usize> Plan<N> {
    /// Of a motion that is not there: nothing is allowed.
    pub(super) const NOTHING: Self = {
        let none = Budget {
            v: 0.0,
            a: 0.0,
            ramp: 0.0,
            bend: 0.0,
        };
        Self {
            joints: [none; N],
            tool: [none; 2],
            grid: 0.0,
            step: 0.0,
            averaged: 0,
            tau: 0.0,
            fastest: 0.0,
            hardest: 0.0,
            most_surveys: 0,
        }
    };

    /// # Errors
    /// [`FeedError`].
    pub(super) fn new(
        limits: &FeedLimits<N>,
        grid: f64,
        step: f64,
        samples: usize,
        most_averaged: usize,
    ) -> Result<Self, FeedError> {
        if samples < LEAST_SAMPLES || most_averaged == 0 {
            return Err(FeedError::NoRoom);
        }
        for x in [grid, step] {
            positive(x)?;
            finite(x)?;
        }
        for joint in &limits.joints {
            positive(joint.v)?;
            positive(joint.a)?;
            positive(joint.j)?;
            finite(joint.v)?;
            finite(joint.a)?;
        }
        let joints = limits.joints.map(|l| [l.v, l.a, l.j]);
        let tool = [norm(&limits.linear)?, norm(&limits.angular)?];
        let longest = float(most_averaged);
        let mut needed = 0.0;
        for [_, a, j] in joints.iter().chain(&tool) {
            if j.is_finite() {
                // without a limit of acceleration, the ramp is cut to one step's
                let steps = if a.is_finite() {
                    2.0 * a / (RAMP_SHARE * j * step)
                } else {
                    1.0
                };
                needed = larger(needed, larger(steps, 1.0));
            }
        }
        let averaged = count(smaller(libm::ceil(needed), longest));
        let tau = float(averaged) * step;
        let spent = |limit: f64| narrow(limit * ROUNDING_MARGIN);
        let spend = |[v, a, j]: [f64; 3]| Budget {
            v: spent(v),
            a: spent(a),
            ramp: spent(smaller(
                a,
                if j.is_finite() {
                    0.5 * RAMP_SHARE * j * tau
                } else {
                    a
                },
            )),
            bend: spent((1.0 - RAMP_SHARE) * j),
        };
        let fastest = 0.25 * float(samples) * grid / (step + tau);
        Ok(Self {
            joints: joints.map(spend),
            tool: tool.map(spend),
            grid,
            step,
            averaged,
            tau,
            fastest,
            hardest: fastest / step,
            most_surveys: most_surveys(fastest * step / grid),
        })
    }
}

/// Half as many cells again as the motion can pass in a macrostep, so that it never comes up with the wall.
fn most_surveys(passed: f64) -> usize {
    count(libm::ceil(1.5 * passed)).max(LEAST_SURVEYS)
}

fn positive(x: f64) -> Result<(), FeedError> {
    if x.is_nan() {
        Err(FeedError::NotFinite)
    } else if x > 0.0 {
        Ok(())
    } else {
        Err(FeedError::NotPositive)
    }
}

fn finite(x: f64) -> Result<(), FeedError> {
    if x.is_finite() {
        Ok(())
    } else {
        Err(FeedError::NotFinite)
    }
}

fn norm(limits: &NormLimits) -> Result<[f64; 3], FeedError> {
    let each = [limits.v, limits.a, limits.j];
    for limit in each.into_iter().flatten() {
        positive(limit)?;
        finite(limit)?;
    }
    Ok(each.map(|limit| limit.unwrap_or(f64::INFINITY)))
}

/// A count as a float.
#[expect(clippy::cast_precision_loss, reason = "capacities: far below 2^53")]
pub(super) fn float(n: usize) -> f64 {
    n as f64
}

/// A float ≥ 0 as a count.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the cast saturates, and the argument is not negative"
)]
pub(super) fn count(x: f64) -> usize {
    x as usize
}
