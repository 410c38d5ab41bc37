//! Any piece of a path, and why a piece cannot be made.

use super::{Arc, Curve, PathPoint, Quintic, Straight};
use core::fmt;
use nalgebra::{Matrix3, Vector3};

/// Why there is no such piece.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PieceError {
    /// A number is infinite or not a number.
    NotFinite,
    /// Shorter than [`SHORTEST_M`](super::SHORTEST_M).
    TooShort,
    /// The three points lie on a straight line, or two of them in the same place: no circle.
    Collinear,
    /// The radius is less than [`SHORTEST_M`](super::SHORTEST_M): no circle.
    NoRadius,
    /// The normal of the plane has no direction.
    NoNormal,
    /// Start and end are not equally far from the centre.
    NotEquidistant,
}

impl fmt::Display for PieceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotFinite => "a number of the piece is infinite or not a number",
            Self::TooShort => "the piece has no length",
            Self::Collinear => "three points on a straight line are on no circle",
            Self::NoRadius => "the arc has no radius",
            Self::NoNormal => "the normal of the arc's plane has no direction",
            Self::NotEquidistant => "start and end are not equally far from the centre",
        })
    }
}

impl core::error::Error for PieceError {}

/// Any piece of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Piece {
    /// A straight line, or a turn on the spot.
    Straight(Straight),
    /// An arc or a helix.
    Arc(Arc),
    /// A blend at a corner, or a span of a curve through points.
    Quintic(Quintic),
}

impl From<Straight> for Piece {
    fn from(piece: Straight) -> Self {
        Self::Straight(piece)
    }
}

impl From<Arc> for Piece {
    fn from(piece: Arc) -> Self {
        Self::Arc(piece)
    }
}

impl From<Quintic> for Piece {
    fn from(piece: Quintic) -> Self {
        Self::Quintic(piece)
    }
}

impl Curve for Piece {
    fn length(&self) -> f64 {
        match self {
            Self::Straight(piece) => piece.length(),
            Self::Arc(piece) => piece.length(),
            Self::Quintic(piece) => piece.length(),
        }
    }

    fn at(&self, s: f64) -> PathPoint {
        match self {
            Self::Straight(piece) => piece.at(s),
            Self::Arc(piece) => piece.at(s),
            Self::Quintic(piece) => piece.at(s),
        }
    }

    fn followed_at(&self, s: f64) -> PathPoint {
        match self {
            Self::Straight(piece) => piece.at(s),
            Self::Arc(piece) => piece.at(s),
            Self::Quintic(piece) => piece.followed_at(s),
        }
    }

    fn position_at(&self, s: f64) -> Vector3<f64> {
        match self {
            Self::Straight(piece) => piece.position_at(s),
            Self::Arc(piece) => piece.position_at(s),
            Self::Quintic(piece) => piece.position_at(s),
        }
    }

    fn turns_from(&self) -> Matrix3<f64> {
        match self {
            Self::Straight(piece) => piece.turns_from(),
            Self::Arc(piece) => piece.turns_from(),
            Self::Quintic(piece) => piece.turns_from(),
        }
    }

    fn turn_at(&self, s: f64) -> Vector3<f64> {
        match self {
            Self::Straight(piece) => piece.turn_at(s),
            Self::Arc(piece) => piece.turn_at(s),
            Self::Quintic(piece) => piece.turn_at(s),
        }
    }

    fn is_straight(&self) -> bool {
        matches!(self, Self::Straight(_))
    }

    fn arc_length(&self, from: f64, to: f64) -> f64 {
        match self {
            Self::Straight(piece) => piece.arc_length(from, to),
            Self::Arc(piece) => piece.arc_length(from, to),
            Self::Quintic(piece) => piece.arc_length(from, to),
        }
    }
}
