//! Why a kinematic question has no answer.

use core::fmt;

/// What a bound was put on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// A joint position, rad or m.
    Joint,
    /// A motor shaft angle, rad.
    Motor,
    /// The angle a ball-screw triangle drives, rad; outside its bounds the triangle would have to
    /// pass its dead centre.
    ScrewAngle,
    /// The length of a ball screw between its pivots, mm; outside its bounds the triangle does not
    /// close, or a leg is off its screw.
    ScrewLength,
}

impl Quantity {
    /// The word for it in messages and machine-readable output.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Joint => "joint",
            Self::Motor => "motor",
            Self::ScrewAngle => "screw-angle",
            Self::ScrewLength => "screw-length",
        }
    }
}

/// Why a conversion has no answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KinematicError {
    /// An input is infinite or not a number.
    NotFinite,
    /// The rotation given is not one: its columns are not orthonormal or not right-handed.
    NotARotation {
        /// The greatest entry of |`RᵀR − I`|, or 2 for a left-handed frame.
        deviation: f64,
    },
    /// No configuration of the links reaches the pose, or joins legs of the lengths the motors give.
    Unreachable,
    /// The solutions form a continuum, and the one that keeps the free joint where it is does not
    /// exist.
    Singular,
    /// A value is outside its range.
    Limit {
        /// Index of the axis, in axis order.
        axis: usize,
        /// Its name in the description.
        name: &'static str,
        /// What is bounded; gives the unit of the numbers below.
        quantity: Quantity,
        /// What it would be.
        value: f64,
        /// The least allowed value.
        lower: f64,
        /// The greatest allowed value.
        upper: f64,
    },
}

impl KinematicError {
    /// A short, stable word for machine-readable output.
    #[must_use]
    pub const fn code(&self) -> &'static str {
        match self {
            Self::NotFinite => "not-finite",
            Self::NotARotation { .. } => "not-a-rotation",
            Self::Unreachable => "unreachable",
            Self::Singular => "singular",
            Self::Limit { .. } => "limit",
        }
    }
}

impl fmt::Display for KinematicError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite => write!(f, "a coordinate is not a finite number"),
            Self::NotARotation { deviation } => write!(
                f,
                "the rotation is not orthonormal and right-handed (off by {deviation:e})"
            ),
            Self::Unreachable => write!(
                f,
                "no configuration of the links reaches the pose or joins the legs"
            ),
            Self::Singular => write!(f, "singular: no solution keeps the free joint where it is"),
            Self::Limit {
                axis,
                name,
                quantity,
                value,
                lower,
                upper,
            } => write!(
                f,
                "{} of axis {} ({name}) would be {value:?}, allowed {lower} to {upper}",
                quantity.name(),
                // people count from 1
                axis.saturating_add(1)
            ),
        }
    }
}

impl core::error::Error for KinematicError {}
