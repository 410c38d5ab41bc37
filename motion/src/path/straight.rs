//! The straight line between two poses, and the turn on the spot.

use super::{Curve, PathPoint, PieceError, SHORTEST_M, extent, is_finite, reach};
use crate::line::Line;
use crate::pose::Pose;
use crate::twist::Twist;
use nalgebra::{Matrix3, Vector3};

/// A [`Line`] over its length instead of \[0, 1\]: position straight, orientation on the shortest arc, both
/// at a constant rate.
///
/// ```
/// use motion::path::{Curve, Straight};
/// use motion::Pose;
/// use nalgebra::Vector3;
/// let end = Pose::from_rotation_vector(Vector3::new(0.3, 0.0, 0.4), Vector3::z());
/// let straight = Straight::new(Pose::identity(), end)?;
/// assert!((straight.length() - 0.5).abs() < 1e-15);
/// assert_eq!(straight.at(straight.length()).pose, end);
/// # Ok::<(), motion::path::PieceError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Straight {
    line: Line,
    length: f64,
}

impl Straight {
    /// From one pose to another, both in the base frame.
    ///
    /// # Errors
    /// [`PieceError::NotFinite`]; [`PieceError::TooShort`] if the poses are the same to within
    /// [`SHORTEST_M`], or a turn of as little as that.
    pub fn new(start: Pose, end: Pose) -> Result<Self, PieceError> {
        if !is_finite(&start) || !is_finite(&end) {
            return Err(PieceError::NotFinite);
        }
        let line = Line::new(start, end);
        let length = extent(line.length_m(), line.angle_rad());
        if !length.is_finite() {
            return Err(PieceError::NotFinite);
        }
        if length < SHORTEST_M {
            return Err(PieceError::TooShort);
        }
        Ok(Self { line, length })
    }

    /// How much of the line lies before s.
    fn share(&self, s: f64) -> f64 {
        reach(s, self.length) / self.length
    }

    /// The line itself, over \[0, 1\].
    #[must_use]
    pub fn line(&self) -> &Line {
        &self.line
    }
}

impl Curve for Straight {
    fn length(&self) -> f64 {
        self.length
    }

    fn at(&self, s: f64) -> PathPoint {
        let u = self.share(s);
        let pose = if (0.0..=1.0).contains(&u) {
            self.line.at(u)
        } else {
            self.line.extended(u)
        };
        let twist = self.line.twist();
        let first = Twist {
            linear: twist.linear / self.length,
            angular: twist.angular / self.length,
        };
        PathPoint {
            pose,
            first,
            second: Twist::zero(),
            third: Twist::zero(),
        }
    }

    fn position_at(&self, s: f64) -> Vector3<f64> {
        self.line.start().position + self.line.twist().linear * self.share(s)
    }

    fn turns_from(&self) -> Matrix3<f64> {
        self.line.start().rotation
    }

    fn turn_at(&self, s: f64) -> Vector3<f64> {
        self.line.twist().angular * self.share(s)
    }

    fn is_straight(&self) -> bool {
        true
    }

    fn arc_length(&self, from: f64, to: f64) -> f64 {
        (to - from) / self.length * self.line.length_m()
    }
}
