//! How fast a path may be run through: limits of joints and of the tool, as limits of the path parameter.

use crate::line::Twist;
use crate::profile::{AxisLimits, ProfileError, rest_time};
use crate::scalar::{larger, smaller};
use core::fmt;

/// Speed limits of the tool: |v| ≤ linear, |ω| ≤ angular.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolLimits {
    /// m/s.
    pub linear_m_s: f64,
    /// rad/s.
    pub angular_rad_s: f64,
}

/// Why no limits for the path parameter can be given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PathError {
    /// A sample, limit or length is infinite or not a number.
    NotFinite,
    /// A limit or the length is not positive.
    NotPositive,
    /// Nothing moves along the path: any speed would do.
    Still,
    /// Some result is too large or too small for a floating-point number.
    NotRepresentable,
}

impl fmt::Display for PathError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotFinite => "a sample, limit or length is infinite or not a number",
            Self::NotPositive => "a limit or the length is not positive",
            Self::Still => "nothing moves along the path",
            Self::NotRepresentable => "the limits are outside the range of floating point",
        })
    }
}

impl core::error::Error for PathError {}

/// Largest |q'|, |q''|, |q'''| of each joint over the samples of a path q(s), in constant memory.
///
/// Derivatives are taken with respect to the path parameter s. What the path does between samples is not
/// seen: sample densely, and let the interpolator's check at push have the last word.
///
/// ```
/// use motion::path_profile::PathScan;
/// use motion::profile::AxisLimits;
/// let mut scan = PathScan::<2>::new();
/// scan.add(&[2.0, 1.0], &[0.0, 0.0], &[0.0, 0.0]);
/// let joint = AxisLimits { v: 1.0, a: 4.0, j: 40.0 };
/// let s = scan.limits(&[joint; 2], None, 1.0)?;
/// assert!((s.v - 0.5).abs() < 1e-6 && (s.a - 2.0).abs() < 1e-6 && (s.j - 20.0).abs() < 1e-5);
/// # Ok::<(), motion::path_profile::PathError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathScan<const N: usize> {
    /// |q'|, |q''|, |q'''| of each joint.
    most: [[f64; 3]; N],
    linear: f64,
    angular: f64,
    sound: bool,
}

impl<const N: usize> Default for PathScan<N> {
    fn default() -> Self {
        Self::new()
    }
}

/// How many values are tried: of the speed, and of the share of acceleration for each.
#[derive(Clone, Copy, Debug)]
struct Effort {
    speeds: u32,
    shares: u32,
    /// Thirds taken off the interval around the best.
    refinements: u32,
}

/// To 3e-4 of the interval around the best of the grid; some 5000 evaluations.
const THOROUGH: Effort = Effort {
    speeds: 48,
    shares: 16,
    refinements: 20,
};
/// (8 + 2·3)·(4 + 2·3) = 140 evaluations, for one step of the node.
const QUICK: Effort = Effort {
    speeds: 8,
    shares: 4,
    refinements: 3,
};
/// Kept below what is allowed, for rounding.
const ROUNDING_MARGIN: f64 = 1.0 - 1e-9;

impl<const N: usize> PathScan<N> {
    /// No samples yet.
    #[must_use]
    pub fn new() -> Self {
        Self {
            most: [[0.0; 3]; N],
            linear: 0.0,
            angular: 0.0,
            sound: true,
        }
    }

    /// One sample: first, second and third derivative of the joints with respect to s.
    pub fn add(&mut self, first: &[f64; N], second: &[f64; N], third: &[f64; N]) {
        let each = first.iter().zip(second).zip(third);
        for (most, ((first, second), third)) in self.most.iter_mut().zip(each) {
            for (most, x) in most.iter_mut().zip([first, second, third]) {
                *most = larger(*most, x.abs());
                self.sound &= x.is_finite();
            }
        }
    }

    /// One sample of the tool's motion per unit of s.
    pub fn add_twist(&mut self, twist: &Twist) {
        let (linear, angular) = (twist.linear_norm(), twist.angular_norm());
        self.linear = larger(self.linear, linear);
        self.angular = larger(self.angular, angular);
        self.sound &= linear.is_finite() && angular.is_finite();
    }

    /// Limits (v, a, j) of the path parameter such that every joint and the tool keep theirs.
    ///
    /// By the chain rule it suffices, for every joint, that
    /// `|q'|·v ≤ V`, `|q''|·v² + |q'|·a ≤ A`, `|q'''|·v³ + 3·|q''|·v·a + |q'|·j ≤ J`
    /// with the maxima over the path. The limits with the shortest rest-to-rest time over `length` are
    /// searched: for a speed v, a is a share of what v leaves, and j all that both leave. Speeds are tried
    /// on a grid, for each the shares on a grid; the neighbourhood of the best is searched by thirds.
    /// Times found are within 1 % of the best split of these maxima.
    ///
    /// # Errors
    /// [`PathError`].
    pub fn limits(
        &self,
        joints: &[AxisLimits; N],
        tool: Option<ToolLimits>,
        length: f64,
    ) -> Result<AxisLimits, PathError> {
        self.search(joints, tool, length, THOROUGH)
    }

    /// The same in 140 evaluations, for the node: the time found is at most a fifth longer.
    ///
    /// # Errors
    /// [`PathError`].
    pub fn quick_limits(
        &self,
        joints: &[AxisLimits; N],
        tool: Option<ToolLimits>,
        length: f64,
    ) -> Result<AxisLimits, PathError> {
        self.search(joints, tool, length, QUICK)
    }

    fn search(
        &self,
        joints: &[AxisLimits; N],
        tool: Option<ToolLimits>,
        length: f64,
        effort: Effort,
    ) -> Result<AxisLimits, PathError> {
        for joint in joints {
            joint.validate().map_err(|error| match error {
                ProfileError::NonPositiveLimit => PathError::NotPositive,
                _ => PathError::NotFinite,
            })?;
        }
        if !self.sound || !length.is_finite() {
            return Err(PathError::NotFinite);
        }
        let fastest = self.fastest(joints, tool)?;
        if length <= 0.0 {
            return Err(PathError::NotPositive);
        }
        let by_speed = |v: f64| {
            let by_share = |a: f64| {
                self.left(joints, v * fastest, a)
                    .map(|found| (rest_time(length, &found), found))
            };
            best_of(effort.shares, effort.refinements, by_share)
        };
        let (_, found) = best_of(effort.speeds, effort.refinements, by_speed)
            .ok_or(PathError::NotRepresentable)?;
        Ok(found)
    }

    /// The largest speed that velocities, and accelerations with a = 0, allow.
    fn fastest(
        &self,
        joints: &[AxisLimits; N],
        tool: Option<ToolLimits>,
    ) -> Result<f64, PathError> {
        let mut v = f64::INFINITY;
        for ([first, second, third], joint) in self.most.iter().zip(joints) {
            v = smaller(v, joint.v / first);
            v = smaller(v, libm::sqrt(joint.a / second));
            v = smaller(v, libm::cbrt(joint.j / third));
        }
        if let Some(ToolLimits {
            linear_m_s,
            angular_rad_s,
        }) = tool
        {
            for (limit, most) in [(linear_m_s, self.linear), (angular_rad_s, self.angular)] {
                if !limit.is_finite() {
                    return Err(PathError::NotFinite);
                }
                if limit <= 0.0 {
                    return Err(PathError::NotPositive);
                }
                v = smaller(v, limit / most);
            }
        }
        let moves = self.most.iter().any(|[first, ..]| *first > 0.0);
        if !moves {
            return Err(PathError::Still);
        }
        if v.is_normal() {
            Ok(v * ROUNDING_MARGIN)
        } else {
            Err(PathError::NotRepresentable)
        }
    }

    /// What a speed, and a share of the acceleration it leaves, leave; `None` if that is nothing.
    fn left(&self, joints: &[AxisLimits; N], v: f64, a_share: f64) -> Option<AxisLimits> {
        let mut a = f64::INFINITY;
        for ([first, second, _], joint) in self.most.iter().zip(joints) {
            if *first > 0.0 {
                a = smaller(a, (joint.a * ROUNDING_MARGIN - second * v * v) / first);
            }
        }
        a *= a_share;
        let mut j = f64::INFINITY;
        for ([first, second, third], joint) in self.most.iter().zip(joints) {
            let used = third * v * v * v + 3.0 * second * v * a;
            if *first > 0.0 {
                j = smaller(j, (joint.j * ROUNDING_MARGIN - used) / first);
            } else if used > joint.j {
                return None;
            }
        }
        let found = AxisLimits { v, a, j };
        [v, a, j]
            .iter()
            .all(|x| x.is_normal() && *x > 0.0)
            .then_some(found)
    }
}

type Timed = (f64, AxisLimits);

/// The shortest time of `f` over (0, 1]: on a grid, then by thirds around the best.
fn best_of(grid: u32, refinements: u32, f: impl Fn(f64) -> Option<Timed>) -> Option<Timed> {
    let step = 1.0 / f64::from(grid);
    let time = |found: &Option<Timed>| found.map_or(f64::INFINITY, |(time, _)| time);
    let (mut best, mut middle) = (None, 0.0);
    for k in 1..=grid {
        let x = step * f64::from(k);
        let found = f(x);
        if time(&found) < time(&best) {
            (best, middle) = (found, x);
        }
    }
    let (mut from, mut to) = (middle - step, smaller(middle + step, 1.0));
    for _ in 0..refinements {
        let (left, right) = (from + (to - from) / 3.0, to - (to - from) / 3.0);
        let (at_left, at_right) = (f(left), f(right));
        let nearer = time(&at_left) < time(&at_right);
        let better = if nearer { at_left } else { at_right };
        (from, to) = if nearer { (from, right) } else { (left, to) };
        if time(&better) < time(&best) {
            best = better;
        }
    }
    best
}
