//! A straight line between two poses, turning about one fixed axis.

use crate::pose::{Pose, log, turned};
pub use crate::twist::Twist;

/// The straight line from one pose to another with the orientation on the shortest arc (slerp).
///
/// The parameter s runs from 0 to 1. Position: `start + s·(end − start)`; orientation:
/// `exp(s·w)·R_start` with `w = log(R_end·R_startᵀ)`, so the [twist](Self::twist) with respect to s
/// is constant. A turn of exactly half a revolution has two shortest arcs; the one [`log`] picks
/// is taken.
///
/// ```
/// use motion::{Line, Pose};
/// use nalgebra::Vector3;
/// let end = Pose::from_rotation_vector(Vector3::new(0.3, 0.0, 0.4), Vector3::z());
/// let line = Line::new(Pose::identity(), end);
/// assert!((line.length_m() - 0.5).abs() < 1e-15);
/// assert!((line.angle_rad() - 1.0).abs() < 1e-15);
/// assert_eq!(line.at(1.0), end);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    start: Pose,
    end: Pose,
    twist: Twist,
}

impl Line {
    /// The line between two poses given in the same base frame.
    #[must_use]
    pub fn new(start: Pose, end: Pose) -> Self {
        let twist = Twist {
            linear: end.position - start.position,
            angular: log(&(end.rotation * start.rotation.transpose())),
        };
        Self { start, end, twist }
    }

    /// Where the line begins (s = 0).
    #[must_use]
    pub fn start(&self) -> &Pose {
        &self.start
    }

    /// Where the line ends (s = 1).
    #[must_use]
    pub fn end(&self) -> &Pose {
        &self.end
    }

    /// Distance between the origins, m.
    #[must_use]
    pub fn length_m(&self) -> f64 {
        self.twist.linear_norm()
    }

    /// Angle turned, rad, in \[0, π\].
    #[must_use]
    pub fn angle_rad(&self) -> f64 {
        self.twist.angular_norm()
    }

    /// The pose at s; the given ends, to the bit, for s ≤ 0 (or not a number) and s ≥ 1.
    #[must_use]
    pub fn at(&self, s: f64) -> Pose {
        if s >= 1.0 {
            return self.end;
        }
        if s > 0.0 {
            return self.extended(s);
        }
        self.start
    }

    /// The pose at s on the line continued beyond both ends: what differences at the ends need.
    #[must_use]
    pub fn extended(&self, s: f64) -> Pose {
        Pose {
            position: self.start.position + self.twist.linear * s,
            rotation: turned(&self.twist.angular, s, &self.start.rotation),
        }
    }

    /// The derivative of the pose with respect to s: constant, in the base frame.
    #[must_use]
    pub fn twist(&self) -> Twist {
        self.twist
    }
}

#[cfg(test)]
mod test {
    use super::*;
    use nalgebra::{Matrix3, Vector3};
    use proptest::prelude::*;

    fn pose() -> impl Strategy<Value = Pose> {
        prop::array::uniform6(-1.5..1.5f64).prop_map(|[x, y, z, a, b, c]| {
            Pose::from_rotation_vector(Vector3::new(x, y, z), Vector3::new(a, b, c))
        })
    }

    proptest! {
        #[test]
        fn the_ends_are_exact_and_approached_continuously(a in pose(), b in pose()) {
            let line = Line::new(a, b);
            prop_assert_eq!(line.at(0.0), a);
            prop_assert_eq!(line.at(-3.0), a);
            prop_assert_eq!(line.at(1.0), b);
            prop_assert_eq!(line.at(7.0), b);
            prop_assert_eq!(line.at(f64::NAN), a);
            // one step of 1e-12 of the parameter moves at most 1e-11 m or rad here; log adds its error near π
            let near = line.at(1.0 - 1e-12);
            prop_assert!((near.position - b.position).norm() < 1e-10);
            prop_assert!((near.rotation - b.rotation).norm() < 1e-7);
        }

        #[test]
        fn the_twist_is_the_derivative_everywhere(a in pose(), b in pose(), s in 0.01..0.99f64) {
            let (line, h) = (Line::new(a, b), 1e-4);
            let (before, here, after) = (line.at(s - h), line.at(s), line.at(s + h));
            let velocity = (after.position - before.position) / (2.0 * h);
            prop_assert!((velocity - line.twist().linear).norm() < 1e-9);
            // dR/ds·Rᵀ is the cross matrix of the angular velocity; central differences: w³h²/6 < 6e-8
            let spin = (after.rotation - before.rotation) / (2.0 * h) * here.rotation.transpose();
            prop_assert!((spin - line.twist().angular.cross_matrix()).norm() < 1e-6);
        }

        #[test]
        fn every_orientation_is_a_rotation(a in pose(), b in pose(), s in 0.0..1.0f64) {
            let r = Line::new(a, b).at(s).rotation;
            prop_assert!((r * r.transpose() - Matrix3::identity()).norm() < 1e-12);
            prop_assert!((r.determinant() - 1.0).abs() < 1e-12);
        }

        #[test]
        fn half_way_is_equally_far_from_both_ends(a in pose(), b in pose()) {
            let line = Line::new(a, b);
            let middle = line.at(0.5);
            let (first, second) = (Line::new(a, middle), Line::new(middle, b));
            prop_assert!((first.length_m() - second.length_m()).abs() < 1e-12);
            prop_assert!((first.angle_rad() - second.angle_rad()).abs() < 1e-7);
            prop_assert!((first.angle_rad() - 0.5 * line.angle_rad()).abs() < 1e-7);
        }
    }

    #[test]
    fn a_line_to_the_same_pose_stays() {
        let pose = Pose::from_rotation_vector(Vector3::x(), Vector3::y());
        let line = Line::new(pose, pose);
        assert!(line.length_m() == 0.0 && line.angle_rad() < 1e-15);
        assert!((line.at(0.3).rotation - pose.rotation).norm() < 1e-15);
    }
}
