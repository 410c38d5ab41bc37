//! Arcs of circles, whole circles, several turns, helices.

use super::{Curve, PathPoint, PieceError, SHORTEST_M, extent, is_finite, reach};
use crate::pose::{Pose, log, turned};
use crate::twist::Twist;
use core::f64::consts::TAU;
use nalgebra::{Matrix3, Vector3};

/// Sine of the angle at the first of three points below which they are taken for a straight line.
///
/// The radius would be half a million times the distance of the other two points.
const STRAIGHT_SINE: f64 = 1e-6;

/// An arc about an axis, perhaps rising along it, the orientation turning about one axis of its own at a
/// constant rate (slerp).
///
/// With θ = s/length·angle, x the radius vector at the start and y = axis × x:
/// `p = start + (cos θ − 1)·x + sin θ·y + rise·θ·axis`, so `|p'|` is constant, and the length exact.
///
/// ```
/// use motion::path::{Arc, Curve};
/// use motion::Pose;
/// use nalgebra::Vector3;
/// let at = |x, y| Pose::from_rotation_vector(Vector3::new(x, y, 0.0), Vector3::zeros());
/// let arc = Arc::through(at(1.0, 0.0), Vector3::new(0.0, 1.0, 0.0), at(-1.0, 0.0))?;
/// assert!((arc.length() - core::f64::consts::PI).abs() < 1e-15);
/// assert!((arc.at(0.3).curvature() - 1.0).abs() < 1e-15);
/// # Ok::<(), motion::path::PieceError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arc {
    start: Pose,
    /// Radius vector at the start, and the one a quarter of a turn later, m.
    radii: [Vector3<f64>; 2],
    /// Along the axis, m/rad.
    rise: Vector3<f64>,
    /// rad, > 0.
    angle: f64,
    /// Rotation vector of the whole piece, rad.
    turn: Vector3<f64>,
    length: f64,
}

impl Arc {
    /// From the start on the circle through three positions to the end, less than one turn.
    ///
    /// The orientation goes from the start's to the end's on the shortest arc.
    ///
    /// # Errors
    /// [`PieceError::NotFinite`]; [`PieceError::Collinear`] also where two of the points coincide: a whole
    /// circle is made [about](Self::about) its axis.
    pub fn through(start: Pose, via: Vector3<f64>, end: Pose) -> Result<Self, PieceError> {
        let (a, b) = (via - start.position, end.position - start.position);
        let normal = a.cross(&b);
        let (aa, bb, nn) = (a.dot(&a), b.dot(&b), normal.dot(&normal));
        if !(is_finite(&start) && is_finite(&end) && nn.is_finite() && (aa * bb).is_finite()) {
            return Err(PieceError::NotFinite);
        }
        if nn <= STRAIGHT_SINE * STRAIGHT_SINE * aa * bb {
            return Err(PieceError::Collinear);
        }
        // circumcentre, seen from the start
        let centre = (b * aa - a * bb).cross(&normal) / (2.0 * nn);
        let axis = normal / libm::sqrt(nn);
        let angle = angle_about(&axis, &-centre, &(b - centre));
        Self::build(start, -centre, axis, angle, 0.0, &end.rotation)
    }

    /// From the start by an angle (rad, any number of turns, negative: clockwise) about the axis through
    /// the centre along the normal, advancing along the normal by so many metres in all.
    ///
    /// The orientation goes to `end` on the shortest arc. The centre may lie anywhere on the axis.
    ///
    /// # Errors
    /// [`PieceError::NotFinite`], [`PieceError::NoNormal`], [`PieceError::NoRadius`],
    /// [`PieceError::TooShort`].
    pub fn about(
        start: Pose,
        centre: Vector3<f64>,
        normal: Vector3<f64>,
        angle_rad: f64,
        advance_m: f64,
        end: &Matrix3<f64>,
    ) -> Result<Self, PieceError> {
        let axis = unit(&normal)?;
        let x = radial(&axis, &(start.position - centre));
        if angle_rad < 0.0 {
            Self::build(start, x, -axis, -angle_rad, -advance_m, end)
        } else {
            Self::build(start, x, axis, angle_rad, advance_m, end)
        }
    }

    /// From start to end counter-clockwise about the axis through the centre along the normal, and then
    /// as many whole turns more; the difference of both ends along the normal is the rise.
    ///
    /// Ends in the same place, seen along the normal, are one whole turn apart. Both ends are met: the
    /// axis is moved to be equally far from them, by at most `tolerance_m`.
    ///
    /// # Errors
    /// [`PieceError`], all but [`PieceError::Collinear`].
    pub fn to(
        start: Pose,
        end: Pose,
        centre: Vector3<f64>,
        normal: Vector3<f64>,
        more_turns: u16,
        tolerance_m: f64,
    ) -> Result<Self, PieceError> {
        let axis = unit(&normal)?;
        let way = end.position - start.position;
        let chord = radial(&axis, &way);
        let distance = libm::sqrt(chord.dot(&chord));
        let mut x = radial(&axis, &(start.position - centre));
        let mut angle = TAU;
        if distance >= SHORTEST_M {
            // seen from the centre, the middle of the chord must not lie off to either side
            let along = chord / distance;
            let shift = along * along.dot(&(x + chord * 0.5));
            let off = libm::sqrt(shift.dot(&shift));
            if off.is_nan() || tolerance_m.is_nan() {
                return Err(PieceError::NotFinite);
            }
            if off > tolerance_m {
                return Err(PieceError::NotEquidistant);
            }
            x -= shift;
            angle = angle_about(&axis, &x, &(x + chord));
        }
        let angle = angle + TAU * f64::from(more_turns);
        Self::build(start, x, axis, angle, axis.dot(&way), &end.rotation)
    }

    /// Radius, m.
    #[must_use]
    pub fn radius(&self) -> f64 {
        let [x, _] = &self.radii;
        libm::sqrt(x.dot(x))
    }

    /// Angle about the axis, rad, positive.
    #[must_use]
    pub fn angle(&self) -> f64 {
        self.angle
    }

    fn build(
        start: Pose,
        x: Vector3<f64>,
        axis: Vector3<f64>,
        angle: f64,
        advance: f64,
        end: &Matrix3<f64>,
    ) -> Result<Self, PieceError> {
        let turn = log(&(end * start.rotation.transpose()));
        let xx = x.dot(&x);
        let metres = libm::sqrt(xx * angle * angle + advance * advance);
        let length = extent(metres, libm::sqrt(turn.dot(&turn)));
        if !(is_finite(&start) && length.is_finite() && angle.is_finite()) {
            return Err(PieceError::NotFinite);
        }
        if xx < SHORTEST_M * SHORTEST_M {
            return Err(PieceError::NoRadius);
        }
        if length < SHORTEST_M || angle <= 0.0 {
            return Err(PieceError::TooShort);
        }
        let radii = [x, axis.cross(&x)];
        let rise = axis * (advance / angle);
        Ok(Self {
            start,
            radii,
            rise,
            angle,
            turn,
            length,
        })
    }
}

/// The part perpendicular to a unit vector.
fn radial(axis: &Vector3<f64>, v: &Vector3<f64>) -> Vector3<f64> {
    v - axis * axis.dot(v)
}

fn unit(normal: &Vector3<f64>) -> Result<Vector3<f64>, PieceError> {
    let norm = libm::sqrt(normal.dot(normal));
    if !norm.is_finite() {
        return Err(PieceError::NotFinite);
    }
    let axis = normal / norm;
    // a norm of 0, or so small that its square has lost its digits, leaves no unit vector
    if libm::fabs(axis.dot(&axis) - 1.0) < 1e-9 {
        Ok(axis)
    } else {
        Err(PieceError::NoNormal)
    }
}

/// The angle from one vector to another counter-clockwise about an axis, in (0, 2π].
fn angle_about(axis: &Vector3<f64>, from: &Vector3<f64>, to: &Vector3<f64>) -> f64 {
    let angle = libm::atan2(axis.dot(&from.cross(to)), from.dot(to));
    if angle > 0.0 { angle } else { angle + TAU }
}

/// Where on an arc: sine of the angle, cosine less 1, and the position.
struct Place {
    sin: f64,
    cos_less_1: f64,
    position: Vector3<f64>,
}

impl Arc {
    /// How much of the arc lies before s.
    fn share(&self, s: f64) -> f64 {
        reach(s, self.length) / self.length
    }

    fn place(&self, s: f64) -> Place {
        let [x, y] = &self.radii;
        let theta = self.angle * self.share(s);
        // of the half angle: 1 − cos θ = 2·sin², with all its digits
        let (half_sin, half_cos) = libm::sincos(0.5 * theta);
        let (sin, cos_less_1) = (2.0 * half_sin * half_cos, -2.0 * half_sin * half_sin);
        Place {
            sin,
            cos_less_1,
            position: self.start.position + x * cos_less_1 + y * sin + self.rise * theta,
        }
    }
}

impl Curve for Arc {
    fn length(&self) -> f64 {
        self.length
    }

    fn at(&self, s: f64) -> PathPoint {
        let Place {
            sin,
            cos_less_1,
            position,
        } = self.place(s);
        let rotation = turned(&self.turn, self.share(s), &self.start.rotation);
        let rate = self.angle / self.length;
        let [x, y] = &self.radii;
        let cos = 1.0 + cos_less_1;
        let (out, ahead) = (x * cos + y * sin, y * cos - x * sin);
        let linear = |linear| Twist {
            linear,
            angular: Vector3::zeros(),
        };
        let square = rate * rate;
        PathPoint {
            pose: Pose { position, rotation },
            first: Twist {
                linear: (ahead + self.rise) * rate,
                angular: self.turn / self.length,
            },
            second: linear(out * -square),
            third: linear(ahead * (-square * rate)),
        }
    }

    fn position_at(&self, s: f64) -> Vector3<f64> {
        self.place(s).position
    }

    fn turns_from(&self) -> Matrix3<f64> {
        self.start.rotation
    }

    fn turn_at(&self, s: f64) -> Vector3<f64> {
        self.turn * self.share(s)
    }

    fn arc_length(&self, from: f64, to: f64) -> f64 {
        let [x, _] = &self.radii;
        let per_radian = libm::sqrt(x.dot(x) + self.rise.dot(&self.rise));
        (to - from) / self.length * self.angle * per_radian
    }
}
