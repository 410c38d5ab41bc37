//! A sample of the path, and what it allows s̈ and ṡ² to be.

use super::limits::{Budget, CUBIC_SHARE, Plan};
use crate::scalar::{cube_root, larger, smaller};
use core::fmt;

/// The tool's motion at one s; any common frame will do, only norms are used.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ToolSample {
    /// First, second and third derivative of the position by s, m per unit, unit², unit³.
    pub linear: [[f64; 3]; 3],
    /// Angular velocity by s, and its first and second derivative by s, rad per unit, unit², unit³.
    pub angular: [[f64; 3]; 3],
}

/// The path at one s: derivatives by s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample<const N: usize> {
    /// q', rad or m per unit.
    pub first: [f64; N],
    /// q'', per unit².
    pub second: [f64; N],
    /// q''', per unit³.
    pub third: [f64; N],
    /// The tool.
    pub tool: ToolSample,
    /// Programmed feed, m/s of the tool's centre point; infinite: as fast as limits allow.
    pub feed: f64,
}

/// Why a sample is refused. A refused sample changes nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PushError {
    /// The window is full of samples that are still needed.
    Full,
    /// A derivative is infinite or not a number, or the feed is not a number.
    NotFinite,
    /// The feed is not positive.
    NotPositive,
    /// The length of the last cell is not in (0, 1] of the grid, or there is no sample before it.
    Fraction,
    /// So steep that a cell would take more than a million macrosteps: a singularity of the arm.
    Singular,
    /// The path is finished, or is to be finished where no piece ends.
    Finished,
}

impl fmt::Display for PushError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Full => "the window is full",
            Self::NotFinite => "a derivative is infinite or not a number",
            Self::NotPositive => "the feed is not positive",
            Self::Fraction => {
                "a piece ends less than nothing or more than a cell after its last sample"
            }
            Self::Singular => "the path is singular here: too steep for any speed",
            Self::Finished => "the path is finished, or inside a piece",
        })
    }
}

impl core::error::Error for PushError {}

impl<const N: usize> Sample<N> {
    /// # Errors
    /// [`PushError::NotFinite`], [`PushError::NotPositive`].
    pub(super) fn validate(&self) -> Result<(), PushError> {
        let joints = self.first.iter().chain(&self.second).chain(&self.third);
        let tool = self.tool.linear.iter().chain(&self.tool.angular).flatten();
        if self.feed.is_nan() || joints.chain(tool).any(|x| !x.is_finite()) {
            return Err(PushError::NotFinite);
        }
        if self.feed <= 0.0 {
            return Err(PushError::NotPositive);
        }
        Ok(())
    }
}

/// How far the derivatives between two samples may be from their linear interpolation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Between<const N: usize> {
    joints: [[f64; 3]; N],
    tool: [[f64; 3]; 2],
}

impl<const N: usize> Between<N> {
    pub(super) const NOTHING: Self = Self {
        joints: [[0.0; 3]; N],
        tool: [[0.0; 3]; 2],
    };

    /// For a cell of length δ. The error of linear interpolation is at most δ²/8·max|f''|: of q' with
    /// q''', whose largest value is taken as the larger end plus the difference of the ends; of q'' with
    /// q'''' taken as twice the difference quotient of q'''. For q''' itself, half the difference.
    pub(super) fn new(a: &Sample<N>, b: &Sample<N>, delta: f64) -> Self {
        let error = |most: f64, difference: f64| {
            [
                0.125 * delta * delta * (most + difference),
                0.25 * delta * difference,
                0.5 * difference,
            ]
        };
        let mut between = Self::NOTHING;
        for (out, (a, b)) in between.joints.iter_mut().zip(a.third.iter().zip(&b.third)) {
            *out = error(larger(a.abs(), b.abs()), (a - b).abs());
        }
        let [linear, angular] = &mut between.tool;
        for (out, a, b) in [
            (linear, &a.tool.linear, &b.tool.linear),
            (angular, &a.tool.angular, &b.tool.angular),
        ] {
            let ([.., a], [.., b]) = (a, b);
            let [a0, a1, a2] = a;
            let [b0, b1, b2] = b;
            *out = error(larger(norm(a), norm(b)), norm(&[a0 - b0, a1 - b1, a2 - b2]));
        }
        between
    }

    /// The larger error of two cells.
    pub(super) fn or(&self, other: &Self) -> Self {
        let mut out = *self;
        let mine = out.joints.iter_mut().chain(&mut out.tool);
        for (mine, other) in mine.zip(other.joints.iter().chain(&other.tool)) {
            for (mine, other) in mine.iter_mut().zip(other) {
                *mine = larger(*mine, *other);
            }
        }
        out
    }
}

/// What one sample allows (u, x) = (s̈, ṡ²) to be, scaled so that every limit of acceleration is 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Allowed<const N: usize> {
    /// |first·u + second·x| ≤ 1
    pub(super) first: [f64; N],
    pub(super) second: [f64; N],
    /// b·b, b·c, c·c of |b·u + c·x| ≤ 1, linear and angular.
    pub(super) tool: [[f64; 3]; 2],
    /// mixed\[0\]·|u| + mixed\[1\]·x ≤ 1
    pub(super) mixed: [f64; 2],
    /// |u| ≤ `most_u`, x ≤ `most_x`; x ≤ `coast_x` is allowed with u = 0.
    pub(super) most_u: f64,
    pub(super) most_x: f64,
    pub(super) coast_x: f64,
    /// ṡ that an override is a share of.
    pub(super) nominal: f64,
}

/// A joint or norm: bounds of its derivatives between samples, and the errors in them.
struct Part {
    size: [f64; 3],
    error: [f64; 3],
    budget: Budget,
}

/// 2·u/(3·√3) with u0·√x0: the largest |u|·√x on the line u/u0 + x/x0 = 1, at x = x0/3, is 2/(3√3)·u0·√x0.
const LINE_OVER_PRODUCT: f64 = 2.598_076_211_353_316;
/// Where that line meets u = 0, in units of the largest x: at `most_x` a third of u0 is left.
const MIXED_HEADROOM: f64 = 1.5;
/// Largest part of a limit of acceleration spent on errors between samples, for u and for x.
const MOST_SPENT_BETWEEN: f64 = 0.25;
/// Least part of a cell in a macrostep at the largest speed.
const SLOWEST: f64 = 1e-6;

impl<const N: usize> Allowed<N> {
    /// Of a sample, for itself and the cells at both sides of it.
    ///
    /// Between two samples, derivatives are convex combinations of theirs plus an error e, so
    /// |q'·u + q''·x| ≤ A there follows from |q'·u + q''·x| ≤ A − e1·|u| − e2·x at both.
    ///
    /// With smoothing, |q'·u| ≤ A is demanded besides: the means (a, v²) of (u, x) have v² ≤ mean of x,
    /// so they lie between (mean u, 0) and (mean u, mean x). And v·|a| ≤ c, for 3·|q''|·v·|a|, holds of
    /// the means if (u, x) stay below a line that lies below u·√x = c.
    ///
    /// # Errors
    /// [`PushError::Singular`].
    pub(super) fn new(
        sample: &Sample<N>,
        between: &Between<N>,
        plan: &Plan<N>,
    ) -> Result<Self, PushError> {
        let smooth = plan.averaged > 0;
        let tool = [&sample.tool.linear, &sample.tool.angular].map(tool_sizes);
        let [[linear, ..], _] = tool;
        let nominal = sample.feed / (linear + between.tool[0][0]);
        let mut v = smaller(plan.fastest, nominal);
        let mut most_u = plan.hardest;
        let (mut error_u, mut error_x, mut second) = (0.0, 0.0, 0.0);
        let mut cubic = f64::INFINITY;
        for Part {
            size: [s1, s2, s3],
            error: [e1, e2, _],
            budget,
        } in parts(sample, &tool, between, plan)
        {
            v = smaller(v, budget.v / s1);
            cubic = smaller(cubic, budget.bend / s3);
            error_u = larger(error_u, e1 / budget.a);
            error_x = larger(error_x, e2 / budget.a);
            second = larger(second, s2 / budget.a);
        }
        v = smaller(v, cube_root(CUBIC_SHARE * cubic));
        let most_x = smaller(v * v, smaller(2.0 / second, MOST_SPENT_BETWEEN / error_x));
        let root = libm::sqrt(most_x);
        let mut product = f64::INFINITY;
        for Part {
            size: [s1, s2, s3],
            budget,
            ..
        } in parts(sample, &tool, between, plan)
        {
            let most = if smooth {
                budget.ramp
            } else {
                budget.a + s2 * most_x
            };
            most_u = smaller(most_u, most / s1);
            let left = budget.bend - s3 * most_x * root;
            product = smaller(product, left / (3.0 * s2));
        }
        most_u = smaller(most_u, MOST_SPENT_BETWEEN / error_u);
        let left = 1.0 - error_u * most_u - error_x * most_x;
        let mut mixed = [0.0; 2];
        if most_u * root > product {
            let by_u = LINE_OVER_PRODUCT * product / most_u;
            let x0 = larger(by_u * by_u, MIXED_HEADROOM * most_x);
            mixed = [libm::sqrt(x0) / (LINE_OVER_PRODUCT * product), 1.0 / x0];
        }
        let scaled = |values: &[f64; N]| {
            let mut out = *values;
            for (x, budget) in out.iter_mut().zip(&plan.joints) {
                *x /= budget.a * left;
            }
            out
        };
        let mut out = Self {
            first: scaled(&sample.first),
            second: scaled(&sample.second),
            tool: tool_products(sample, plan, left),
            mixed,
            most_u,
            most_x,
            coast_x: smaller(most_x, 1.0 / mixed[1]),
            nominal: 0.0,
        };
        for second in &out.second {
            out.coast_x = smaller(out.coast_x, 1.0 / second.abs());
        }
        for [_, _, cc] in &out.tool {
            out.coast_x = smaller(out.coast_x, 1.0 / libm::sqrt(*cc));
        }
        out.nominal = if nominal.is_finite() { nominal } else { root };
        let slowest = SLOWEST * plan.grid / plan.step;
        let moves = libm::sqrt(out.coast_x) > slowest && most_u * plan.step > SLOWEST * slowest;
        if moves {
            Ok(out)
        } else {
            Err(PushError::Singular)
        }
    }
}

fn parts<'a, const N: usize>(
    sample: &'a Sample<N>,
    tool: &'a [[f64; 3]; 2],
    between: &'a Between<N>,
    plan: &'a Plan<N>,
) -> impl Iterator<Item = Part> + 'a {
    let derivatives = sample.first.iter().zip(&sample.second).zip(&sample.third);
    let joints = derivatives.map(|((a, b), c)| [a.abs(), b.abs(), c.abs()]);
    let sizes = joints.chain(*tool);
    let errors = between.joints.iter().chain(&between.tool);
    let budgets = plan.joints.iter().chain(&plan.tool);
    sizes
        .zip(errors)
        .zip(budgets)
        .map(|(([s1, s2, s3], error), budget)| {
            let [e1, e2, e3] = *error;
            Part {
                size: [s1 + e1, s2 + e2, s3 + e3],
                error: *error,
                budget: *budget,
            }
        })
}

fn tool_sizes(derivatives: &[[f64; 3]; 3]) -> [f64; 3] {
    let [first, second, third] = derivatives;
    [norm(first), norm(second), norm(third)]
}

fn tool_products<const N: usize>(sample: &Sample<N>, plan: &Plan<N>, left: f64) -> [[f64; 3]; 2] {
    let [linear, angular] = &plan.tool;
    [
        (&sample.tool.linear, linear),
        (&sample.tool.angular, angular),
    ]
    .map(|([b, c, _], budget)| {
        let limit = budget.a * left;
        let scale = 1.0 / (limit * limit);
        [dot(b, b) * scale, dot(b, c) * scale, dot(c, c) * scale]
    })
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    let ([a0, a1, a2], [b0, b1, b2]) = (a, b);
    a0 * b0 + a1 * b1 + a2 * b2
}

fn norm(a: &[f64; 3]) -> f64 {
    libm::sqrt(dot(a, a))
}
