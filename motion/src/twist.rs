//! The derivative of a pose.

use nalgebra::Vector3;

/// How a pose changes per unit of some parameter, both parts in the base frame.
///
/// With a dimensionless parameter ([`Line`](crate::Line)) the units are m and rad; with time, m/s and
/// rad/s; with a length, 1 and rad/m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Twist {
    /// Derivative of the origin's position, m per unit.
    pub linear: Vector3<f64>,
    /// Angular velocity, rad per unit.
    pub angular: Vector3<f64>,
}

impl Twist {
    /// At rest.
    #[must_use]
    pub fn zero() -> Self {
        Self {
            linear: Vector3::zeros(),
            angular: Vector3::zeros(),
        }
    }

    /// |linear|, m per unit.
    #[must_use]
    pub fn linear_norm(&self) -> f64 {
        libm::sqrt(self.linear.dot(&self.linear))
    }

    /// |angular|, rad per unit.
    #[must_use]
    pub fn angular_norm(&self) -> f64 {
        libm::sqrt(self.angular.dot(&self.angular))
    }
}
