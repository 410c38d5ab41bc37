//! Coordinates of a robot, one type a space, so that they cannot be mixed up.

/// Motor shaft angles, rad, in axis order; 0 where homing ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motors<const N: usize>(pub [f64; N]);

/// Joint positions in axis order: rad for a revolute joint, m for a prismatic one; each link
/// against the one before it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joints<const N: usize>(pub [f64; N]);

/// Position, velocity and acceleration of every joint at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointMotion<const N: usize> {
    /// rad or m.
    pub position: Joints<N>,
    /// rad/s or m/s.
    pub velocity: [f64; N],
    /// rad/s² or m/s².
    pub acceleration: [f64; N],
}

/// Position, velocity and acceleration of every motor shaft at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorMotion<const N: usize> {
    /// rad.
    pub position: Motors<N>,
    /// rad/s.
    pub velocity: [f64; N],
    /// rad/s².
    pub acceleration: [f64; N],
}
