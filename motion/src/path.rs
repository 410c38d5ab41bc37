//! Tool paths with exact derivatives: lines, arcs, blended corners, curves through points.
//!
//! Every piece is a [`Curve`]: a pose and its first three derivatives by a path parameter s. A planner
//! chooses the speed v along s afterwards. Joint accelerations then hold `q''·v²` and joint jerks `q'''·v³`,
//! so where two pieces meet, position and orientation are twice continuously differentiable by s (C2), or
//! the tool stops there: a [`Path`] decides which, [`Join`] by join.
//!
//! | piece | made from | its parameter |
//! |---|---|---|
//! | [`Straight`] | two poses | arc length, exact |
//! | [`Arc`] | three points, or centre, normal and angle | arc length, exact |
//! | [`Blend`] | two pieces that meet in a corner, and a tolerance | close to arc length: see there |
//! | [`Quintic`] of a [`MovingSegment`] | points, one by one | accumulated chord: see there |
//!
//! The parameter of a piece that turns by more than 1 rad per [`METRES_PER_RADIAN`] of its way, and of a turn
//! on the spot, is that constant times the angle instead. So `|p'| ≤ 1` and `|ω| ≤ 1/METRES_PER_RADIAN` on
//! lines and arcs, whatever they do, and there is one unit of s: the metre.
//!
//! Constant memory, a bounded amount of work per call, no allocation: this runs on a node.

mod arc;
mod blend;
mod join;
mod moving_segment;
mod piece;
mod queue;
mod quintic;
mod rotation;
mod straight;
mod window;

pub use arc::Arc;
pub use blend::{Blend, BlendError, Tolerance};
pub use join::Join;
pub use moving_segment::{MovingSegment, PointError};
pub use piece::{Piece, PieceError};
pub use queue::{Path, QueueError};
pub use quintic::Quintic;
pub use straight::Straight;

use crate::pose::{Pose, exp, log};
use crate::scalar::smaller;
use crate::twist::Twist;
use nalgebra::{Matrix3, Vector3};

/// What one radian of turning counts in the parameter of a path, m/rad.
///
/// ASSUMED: a wrist that turns 1 rad within 20 mm is at its own limit, not at the limit of the path.
pub const METRES_PER_RADIAN: f64 = 0.02;

/// The shortest piece, and the smallest distance between two points that are not the same, m.
///
/// Far below what a robot can repeat, far above what rounding makes of a coordinate; second derivatives
/// of a piece this short still have three digits after the point.
pub const SHORTEST_M: f64 = 1e-6;

/// Blends on a node are no shorter, m: it samples a path every 0.2 mm at the finest, and would creep through
/// a shorter one for longer than a stop in the corner takes.
pub const SHORTEST_BLEND_M: f64 = 1e-4;

/// A point of a path: the pose and its derivatives by the path parameter, in the base frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPoint {
    /// Where the tool is: m, rotation matrix.
    pub pose: Pose,
    /// `p'` (1) and `ω` (rad/m), where `R' = [ω]ₓ·R`.
    pub first: Twist,
    /// `p''` (1/m) and `ω'` (rad/m²).
    pub second: Twist,
    /// `p'''` (1/m²) and `ω''` (rad/m³).
    pub third: Twist,
}

impl PathPoint {
    /// The pose `ds` further on, by the derivatives here: to third order, with an error of ds⁴/24 times the fourth.
    ///
    /// For difference quotients that must not see where the path turns off. The rotation vector is Magnus'
    /// expansion: `ω·ds + ω'·ds²/2 + (ω''/6 + ω'×ω/12)·ds³`.
    #[must_use]
    pub fn continued(&self, ds: f64) -> Pose {
        let (p, w) = (&self.first.linear, &self.first.angular);
        let (p2, w2) = (&self.second.linear, &self.second.angular);
        let (p3, w3) = (&self.third.linear, &self.third.angular);
        let way = (p + (p2 * 0.5 + p3 * (ds / 6.0)) * ds) * ds;
        let turn = (w + (w2 * 0.5 + (w3 / 6.0 + w2.cross(w) / 12.0) * ds) * ds) * ds;
        Pose {
            position: self.pose.position + way,
            rotation: exp(turn) * self.pose.rotation,
        }
    }

    /// Curvature of the path of the tool's origin, `|p'×p''|/|p'|³`, 1/m; the same for every parameter.
    ///
    /// Infinite in a cusp, where `p'` vanishes and `p''` does not; 0 where nothing moves.
    #[must_use]
    pub fn curvature(&self) -> f64 {
        let speed = self.first.linear_norm();
        let cubed = speed * speed * speed;
        if cubed > 0.0 {
            let bend = self.first.linear.cross(&self.second.linear);
            libm::sqrt(bend.dot(&bend)) / cubed
        } else if self.second.linear_norm() > 0.0 {
            f64::INFINITY
        } else {
            0.0
        }
    }
}

/// A piece of a path: poses over a parameter s that runs from 0 to its length.
pub trait Curve {
    /// Where the parameter ends, m (see [`METRES_PER_RADIAN`]); at least [`SHORTEST_M`].
    fn length(&self) -> f64;

    /// The point at s, which may lie beyond both ends by as much as the length: difference quotients at the
    /// ends need that. What is farther out counts as the farthest point, what is not a number as 0.
    fn at(&self, s: f64) -> PathPoint;

    /// The same point with derivatives that are off by some parts in 1e7 of the largest: enough for whoever follows the
    /// path, where [`at`](Self::at) is for whoever joins pieces of it.
    fn followed_at(&self, s: f64) -> PathPoint {
        self.at(s)
    }

    /// The position of that point, m.
    fn position_at(&self, s: f64) -> Vector3<f64> {
        self.at(s).pose.position
    }

    /// An orientation of the piece, from which [`turn_at`](Self::turn_at) counts.
    fn turns_from(&self) -> Matrix3<f64> {
        self.at(0.0).pose.rotation
    }

    /// The rotation vector from there to the orientation at s, in the base frame, rad.
    fn turn_at(&self, s: f64) -> Vector3<f64> {
        log(&(self.at(s).pose.rotation * self.turns_from().transpose()))
    }

    /// Whether it is a line at a constant rate, turning about one axis.
    fn is_straight(&self) -> bool {
        false
    }

    /// Length of the way of the tool's origin between two values of s, m; negative backwards.
    ///
    /// Where a piece has no closed form: Gauss–Legendre with five nodes in each of eight panels. Relative
    /// error below 1e-8 where |p'| stays above 0.7, on spans of curves through points as on blends of lines
    /// that turn by up to 150°; below 1e-6 on blends that turn back; up to 1e-3 on wild curves.
    fn arc_length(&self, from: f64, to: f64) -> f64 {
        let panel = (to - from) / f64::from(PANELS);
        let mut sum = 0.0;
        for i in 0..PANELS {
            let middle = from + (f64::from(i) + 0.5) * panel;
            for (node, weight) in GAUSS {
                let s = middle + 0.5 * panel * node;
                sum += weight * self.at(s).first.linear_norm();
            }
        }
        0.5 * panel * sum
    }
}

/// Panels of [`Curve::arc_length`].
const PANELS: u32 = 8;
/// Nodes and weights of Gauss–Legendre quadrature with five nodes on \[−1, 1\]: 0, ±⅓√(5 ∓ 2√(10/7)) with
/// 128/225, (322 ± 13√70)/900 (Abramowitz and Stegun, table 25.4).
const GAUSS: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.906_179_845_938_664, 0.236_926_885_056_189_1),
];

/// The parameter that a way of so many metres and radians takes: see [`METRES_PER_RADIAN`]. Not a number if
/// either is not.
fn extent(metres: f64, radians: f64) -> f64 {
    let turned = METRES_PER_RADIAN * radians;
    if turned > metres || turned.is_nan() {
        turned
    } else {
        metres
    }
}

/// s limited to one length beyond either end; 0 if it is not a number.
fn reach(s: f64, length: f64) -> f64 {
    if s >= -length {
        smaller(s, 2.0 * length)
    } else if s < -length {
        -length
    } else {
        0.0
    }
}

fn is_finite(pose: &Pose) -> bool {
    let mut entries = pose.position.iter().chain(pose.rotation.iter());
    entries.all(|x| x.is_finite())
}
