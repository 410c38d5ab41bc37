//! Knots: what the interpolator is asked to pass through; and what it may be asked.

use crate::angle::Angle;
use crate::profile::AxisLimits;
use crate::scalar::{US_PER_S, float_us, smaller};
use core::fmt;

/// A state of N axes at an instant of path time.
///
/// Unit: the axis' (rad of the motor shaft on a controller node), per s, per s².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knot<const N: usize> {
    /// When the state holds, µs; path time, which is the caller's clock as long as the feed rate is 1.
    pub at_us: u64,
    /// Positions.
    pub position: [f64; N],
    /// Velocities.
    pub velocity: [f64; N],
    /// Accelerations: the segment to this knot is a quintic (C2). `None`: it is a cubic (C1), and
    /// acceleration steps where it begins.
    pub acceleration: Option<[f64; N]>,
}

/// One set-point of N axes: positions in fixed point, derivatives per s and per s² with the 24 bits of f32.
///
/// What is sent is the position; velocity and acceleration are what a servo law feeds forward.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setpoint<const N: usize> {
    /// Positions.
    pub position: [Angle; N],
    /// Velocities.
    pub velocity: [f32; N],
    /// Accelerations.
    pub acceleration: [f32; N],
}

impl<const N: usize> Setpoint<N> {
    /// Standing at a position.
    #[must_use]
    pub const fn at_rest(position: [Angle; N]) -> Self {
        Self {
            position,
            velocity: [0.0; N],
            acceleration: [0.0; N],
        }
    }
}

/// What one axis may be asked to do, and what it will never be made to do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisEnvelope {
    /// Lowest position; −∞ if there is none.
    pub lower: f64,
    /// Highest position; +∞ if there is none.
    pub upper: f64,
    /// Limits of every set-point, whatever happens.
    pub hard: AxisLimits,
    /// Limits of the path between knots. The room up to `hard` is what a stop on the path uses.
    pub plan: AxisLimits,
    /// Largest step of acceleration where a cubic segment begins, or ends at rest.
    pub acceleration_step: f64,
}

/// Part of the room between plan and hard limits that the stop tail takes; the rest is for changes of
/// the feed rate, which may coincide with it. A compromise: either grows as the other shrinks.
const TAIL_SHARE: f64 = 0.4;

/// The fading acceleration of a stop tail overshoots velocity by 4/27·a·t, t = 8·a/j.
const FADE_OVERSHOOT: f64 = 32.0 / 27.0;

/// Norms of the map from a motion's jerk over one segment (of length 1, at most 1 by magnitude) to its
/// quintic's jerk, and to the errors of acceleration and velocity: integrals over |kernel|, the kernel
/// being that of the projection on Legendre polynomials of degree ≤ 2, and its integrals. Rounded up.
const STRAY_JERK: f64 = 2.176;
const STRAY_ACCELERATION: f64 = 0.208_34;
const STRAY_VELOCITY: f64 = 0.022_1;
/// Largest part of velocity and acceleration that the jerk of a plan may cost.
const MOST_STRAY: f64 = 0.2;
/// Largest part of a hard limit that a plan limit may take: some of it is needed to stop.
const MOST_PLAN: f64 = 0.95;
/// Largest part of the hard velocity that path and stop tail may take: covers rounding at push.
const MOST_VELOCITY: f64 = 1.0 - 1e-6;

impl AxisEnvelope {
    /// An envelope whose plan limits leave a proven stop: half of acceleration and jerk, and all of
    /// the velocity (at most nine tenths) that a stop tail beginning at full acceleration cannot need.
    #[must_use]
    pub fn new(lower: f64, upper: f64, hard: AxisLimits) -> Self {
        let mut plan = hard.scaled(0.5);
        let fade_jerk = plan.j + TAIL_SHARE * (hard.j - plan.j);
        let overshoot_quarter = libm::sqrt(0.25 * hard.v * fade_jerk / FADE_OVERSHOOT);
        plan.a = smaller(plan.a, overshoot_quarter);
        plan.v = smaller(
            0.9 * hard.v,
            MOST_VELOCITY * hard.v - FADE_OVERSHOOT * plan.a * plan.a / fade_jerk,
        );
        Self {
            lower,
            upper,
            hard,
            plan,
            acceleration_step: plan.a,
        }
    }

    /// Limits for planning a jerk-limited motion that is then sampled into knots every `knot_us`.
    ///
    /// Between samples of a motion with |jerk| ≤ j, h apart, a quintic's jerk is the best quadratic fit
    /// (in the mean square) to the motion's, so it stays below 2.176·j, and acceleration and velocity
    /// stray from the motion's by less than 5/24·j·h and 0.0221·j·h². What is left of the plan limits
    /// after that is returned, with j small enough to cost at most a fifth of velocity and acceleration.
    /// Knots of such a motion are never refused for velocity, acceleration or jerk.
    #[must_use]
    pub fn for_planning(&self, knot_us: u64) -> AxisLimits {
        let h = float_us(knot_us) / US_PER_S;
        let (stray_a, stray_v) = (STRAY_ACCELERATION * h, STRAY_VELOCITY * h * h);
        let mut j = MOST_VELOCITY * self.plan.j / STRAY_JERK;
        j = smaller(j, MOST_STRAY * self.plan.a / stray_a);
        j = smaller(j, MOST_STRAY * self.plan.v / stray_v);
        AxisLimits {
            v: MOST_VELOCITY * (self.plan.v - stray_v * j),
            a: MOST_VELOCITY * (self.plan.a - stray_a * j),
            j,
        }
    }

    /// Limits of the path including its stop tail: between plan and hard limits.
    // one function: many ask for it, and it is all f64
    #[inline(never)]
    pub(crate) fn tail(&self) -> AxisLimits {
        let a = self.plan.a + TAIL_SHARE * (self.hard.a - self.plan.a);
        let j = self.plan.j + TAIL_SHARE * (self.hard.j - self.plan.j);
        AxisLimits {
            v: self.plan.v + FADE_OVERSHOOT * self.plan.a * self.plan.a / j,
            a,
            j,
        }
    }

    /// Time in which an end acceleration fades, s: with it the fading takes half of the tail's jerk.
    pub(crate) fn fade_s(&self) -> f64 {
        8.0 * self.plan.a / self.tail().j
    }

    // one function, as above
    #[inline(never)]
    pub(crate) fn validate(&self, axis: usize) -> Result<(), EnvelopeError> {
        let valid = self.hard.validate().is_ok()
            && self.plan.validate().is_ok()
            && self.lower < self.upper
            && self.acceleration_step >= 0.0
            && self.acceleration_step.is_finite();
        if !valid {
            return Err(EnvelopeError::Senseless { axis });
        }
        let pairs = [
            (
                Quantity::Velocity,
                self.tail().v,
                MOST_VELOCITY * self.hard.v,
            ),
            (Quantity::Acceleration, self.plan.a, MOST_PLAN * self.hard.a),
            (Quantity::Jerk, self.plan.j, MOST_PLAN * self.hard.j),
        ];
        for (quantity, needed, available) in pairs {
            if needed > available * (1.0 + 1e-12) {
                return Err(EnvelopeError::NoRoomToStop {
                    axis,
                    quantity,
                    needed,
                    available,
                });
            }
        }
        Ok(())
    }
}

/// A limited quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Position.
    Position,
    /// Velocity.
    Velocity,
    /// Acceleration.
    Acceleration,
    /// Jerk.
    Jerk,
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Position => "position",
            Self::Velocity => "velocity",
            Self::Acceleration => "acceleration",
            Self::Jerk => "jerk",
        })
    }
}

/// Why there can be no path within these limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EnvelopeError {
    /// A limit is infinite, not a number, or not positive, or the positions are out of order.
    Senseless {
        /// Which axis.
        axis: usize,
    },
    /// The plan limits leave no room below the hard limits for a stop.
    NoRoomToStop {
        /// Which axis.
        axis: usize,
        /// Which limit.
        quantity: Quantity,
        /// What a stop from the plan limits needs.
        needed: f64,
        /// What there is.
        available: f64,
    },
}

impl fmt::Display for EnvelopeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Senseless { axis } => write!(f, "axis {axis}: senseless limits"),
            Self::NoRoomToStop {
                axis,
                quantity,
                needed,
                available,
            } => write!(
                f,
                "axis {axis}: a stop needs {quantity} {needed}, there is {available}"
            ),
        }
    }
}

impl core::error::Error for EnvelopeError {}
