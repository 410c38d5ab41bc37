//! Where two pieces meet: whether the tool may pass at speed.

use super::PathPoint;
use crate::pose::Pose;
use nalgebra::Vector3;

/// Two poses this close are the same, m: rounding, and nothing that a robot could repeat.
pub(super) const SAME_PLACE_M: f64 = 1e-6;
/// Two orientations this close are the same, rad.
pub(super) const SAME_TURN: f64 = 1e-5;
/// Greatest jump of p' in a smooth join: at 1 m/s a jump of 1 µm/s.
const SAME_SLOPE: f64 = 1e-6;
/// Greatest jump of ω, rad/m: at 1 m/s a jump of 50 µrad/s.
const SAME_TURNING: f64 = 5e-5;
/// Greatest jump of p'', 1/m: at 1 m/s a step of the acceleration of 10 mm/s².
const SAME_BEND: f64 = 1e-2;
/// Greatest jump of ω', rad/m²: at 1 m/s a step of 0.1 rad/s².
const SAME_WINDING: f64 = 1e-1;

/// How the tool passes from one piece to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Join {
    /// At any speed: pose, first and second derivative agree.
    Smooth,
    /// At rest: the pose agrees, a derivative jumps.
    Stop,
}

impl Join {
    /// What joins the end of one piece to the start of the next; none if the poses are more than 1 µm or
    /// 10 µrad apart, or not numbers.
    ///
    /// Smooth: p' agrees to 1e-6, ω to 5e-5 rad/m, p'' to 1e-2 1/m, ω' to 1e-1 rad/m². These are what the
    /// rounding of the shortest pieces makes of equal derivatives, and at 1 m/s too little for any limit.
    #[must_use]
    pub fn between(end: &PathPoint, start: &PathPoint) -> Option<Self> {
        let (metres, radians) = distance(&end.pose, &start.pose);
        if !(metres <= SAME_PLACE_M && radians <= SAME_TURN) {
            return None;
        }
        let agree = |a: &Vector3<f64>, b: &Vector3<f64>, most: f64| {
            let jump = b - a;
            libm::sqrt(jump.dot(&jump)) <= most
        };
        let smooth = agree(&end.first.linear, &start.first.linear, SAME_SLOPE)
            && agree(&end.first.angular, &start.first.angular, SAME_TURNING)
            && agree(&end.second.linear, &start.second.linear, SAME_BEND)
            && agree(&end.second.angular, &start.second.angular, SAME_WINDING);
        Some(if smooth { Self::Smooth } else { Self::Stop })
    }
}

/// How far two poses are apart, m, and by the chord of the angle θ between them, 2·sin(θ/2): of rotations,
/// ‖A − B‖² = 8·sin²(θ/2). Of small angles the chord is the angle, and needs none of its functions.
pub(super) fn distance(a: &Pose, b: &Pose) -> (f64, f64) {
    let way = b.position - a.position;
    let squares = a.rotation.iter().zip(b.rotation.iter());
    let squares: f64 = squares.map(|(a, b)| (a - b) * (a - b)).sum();
    (libm::sqrt(way.dot(&way)), libm::sqrt(0.5 * squares))
}
