//! A quick test that joints are well inside their ranges, for every servo step.
//!
//! From motors to joints it goes as [`Robot::joints`](crate::Robot::joints) does, but in f32. It can only accept: what
//! it does not accept is decided by that function and [`Robot::check_joints`](crate::Robot::check_joints), in f64. So
//! the decision is theirs always, and a microcontroller needs them only near a limit. f32 is off by 2.4e-5 rad at most, and a joint
//! held by parallelograms by twice that: less than a tenth of `MARGIN`.

use motion::Angle;

use crate::description::{AxisDescription, RobotDescription};
use crate::narrow::{Axis, narrow};

/// Nearer to a limit than this nothing is accepted, rad or m.
const MARGIN: f64 = 1e-3;

/// One axis.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Guarded {
    axis: Axis,
    /// The range of the joint, narrowed by the margin.
    lower: f32,
    upper: f32,
}

impl Guarded {
    fn new(axis: &AxisDescription) -> Option<Self> {
        Some(Self {
            axis: Axis::new(axis)?,
            lower: narrow(axis.joint_position.lower + MARGIN),
            upper: narrow(axis.joint_position.upper - MARGIN),
        })
    }
}

/// The quick test of one robot: see the [module](self).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointGuard<const N: usize> {
    axes: [Option<Guarded>; N],
}

impl<const N: usize> JointGuard<N> {
    /// Of a robot whose joints follow from its description alone; with legs or quadratic gears nothing is accepted.
    #[must_use]
    pub fn new(description: &RobotDescription<N>) -> Self {
        Self {
            axes: description.axes.each_ref().map(Guarded::new),
        }
    }

    /// Is every joint inside its range for sure, where the motors are at these angles?
    #[must_use]
    pub fn accepts(&self, motors: &[Angle; N]) -> bool {
        self.test(motors).is_some()
    }

    fn test(&self, motors: &[Angle; N]) -> Option<()> {
        let (mut previous_travel, mut previous_x) = (0.0, 0.0);
        for (guarded, motor) in self.axes.iter().zip(motors) {
            let Guarded { axis, lower, upper } = guarded.as_ref()?;
            let travel = axis.travel(*motor);
            let x = axis.gear.x(travel, previous_travel)?;
            let joint = axis.joint(x, previous_x);
            // what is not a number is not inside
            (joint > *lower && joint < *upper).then_some(())?;
            (previous_travel, previous_x) = (travel, x);
        }
        Some(())
    }
}
