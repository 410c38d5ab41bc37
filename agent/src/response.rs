//! How strongly a stimulus invites a behaviour, and how that changes with practice.

use core::num::NonZeroU8;

use crate::exp::exp_of_minus;

/// The response function `P_q(ζ)`: a probability in `[0, 1]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Response {
    /// `P_q = ζⁿ / (ζⁿ + θⁿ)`, rising with the stimulus. \[Z2\] (21).
    Threshold {
        /// `θ > 0`, in the unit of the stimulus: there `P = 1/2`.
        theta: f64,
        /// `n`: the steepness at `θ`; the paper's experiments use 2.
        n: NonZeroU8,
    },
    /// `P_q = exp(−(ψ(ζ − θ))²)`, high within a range around `θ`. \[Z2\] (22).
    Window {
        /// `θ`: the middle of the range, in the unit of the stimulus; there `P = 1`.
        theta: f64,
        /// `ψ`: the steepness, in the inverse unit of the stimulus; at `θ ± 1/ψ`, `P = 1/e`.
        psi: f64,
    },
}

impl Response {
    /// A threshold response with the paper's exponent `n = 2`.
    #[must_use]
    pub const fn threshold(theta: f64) -> Self {
        const TWO: NonZeroU8 = NonZeroU8::MIN.saturating_add(1);
        Self::Threshold { theta, n: TWO }
    }

    /// A window response.
    #[must_use]
    pub const fn window(theta: f64, psi: f64) -> Self {
        Self::Window { theta, psi }
    }

    /// `P_q(ζ)`, always a number in `[0, 1]`.
    ///
    /// Without a stimulus (`ζ ≤ 0` at a threshold, or NaN) the probability is 0; with a threshold
    /// `θ ≤ 0` any stimulus is enough and it is 1.
    #[must_use]
    pub fn probability(self, zeta: f64) -> f64 {
        match self {
            Self::Threshold { theta, n } => {
                if zeta.is_nan() || theta.is_nan() || zeta <= 0.0 {
                    return 0.0;
                }
                if theta <= 0.0 || zeta.is_infinite() {
                    return 1.0;
                }
                // 1/(1 + (θ/ζ)ⁿ): the same value, and neither power can overflow to ∞/∞.
                let ratio = theta / zeta;
                let power = (0..n.get()).fold(1.0, |p, _| p * ratio);
                1.0 / (1.0 + power)
            }
            Self::Window { theta, psi } => {
                let u = psi * (zeta - theta);
                exp_of_minus(u * u)
            }
        }
    }

    /// `θ`
    #[must_use]
    pub const fn theta(self) -> f64 {
        match self {
            Self::Threshold { theta, .. } | Self::Window { theta, .. } => theta,
        }
    }

    /// The same response with another `θ`.
    #[must_use]
    pub const fn with_theta(self, theta: f64) -> Self {
        match self {
            Self::Threshold { n, .. } => Self::Threshold { theta, n },
            Self::Window { psi, .. } => Self::Window { theta, psi },
        }
    }
}

/// How a threshold `θ` changes at each decision, within bounds. \[Z2\] §3 leaves the rule open.
///
/// A lower threshold means a stronger inclination. Changes are in the unit of the stimulus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adaptation {
    /// Added to `θ` when the behaviour was chosen.
    pub chosen: f64,
    /// Added to `θ` when it was not.
    pub passed: f64,
    /// The least `θ`.
    pub least: f64,
    /// The greatest `θ`.
    pub greatest: f64,
}

impl Adaptation {
    /// A constant threshold.
    pub const NONE: Self = Self {
        chosen: 0.0,
        passed: 0.0,
        least: f64::NEG_INFINITY,
        greatest: f64::INFINITY,
    };

    /// Positive feedback: what is done is done again more easily (by `learn`), what is not done is
    /// forgotten (by `forget`). Both are magnitudes.
    #[must_use]
    pub const fn reinforcement(learn: f64, forget: f64, least: f64, greatest: f64) -> Self {
        Self {
            chosen: -learn.abs(),
            passed: forget.abs(),
            least,
            greatest,
        }
    }

    /// Negative feedback: what is done tires (by `tire`), what is not done recovers (by
    /// `recover`). Both are magnitudes.
    #[must_use]
    pub const fn habituation(tire: f64, recover: f64, least: f64, greatest: f64) -> Self {
        Self {
            chosen: tire.abs(),
            passed: -recover.abs(),
            least,
            greatest,
        }
    }

    /// `θ` after a decision.
    #[must_use]
    pub fn next(self, theta: f64, chosen: bool) -> f64 {
        let theta = theta + if chosen { self.chosen } else { self.passed };
        if theta < self.least {
            self.least
        } else if theta > self.greatest {
            self.greatest
        } else {
            theta
        }
    }
}
