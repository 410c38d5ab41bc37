//! From the errors of planning, kinematics and paths to refusals on the wire.

use motion::interpolator::PushError;
use motion::profile::ProfileError;
use protocol::fault::{Quantity, Refusal};
use protocol::message::NodeState;
use robots::KinematicError;

/// The axis number on the wire.
fn axis(index: usize) -> u8 {
    u8::try_from(index).unwrap_or(u8::MAX)
}

/// A plan that cannot be made.
#[must_use]
pub const fn from_plan(error: ProfileError) -> Refusal {
    match error {
        ProfileError::NotFinite
        | ProfileError::NegativeDistance
        | ProfileError::NonPositiveLimit
        | ProfileError::EndOutsideLimits
        | ProfileError::OutsideRange
        | ProfileError::LeavesRange
        | ProfileError::NotRepresentable => Refusal::NotFinite { index: 0 },
    }
}

/// A pose or position without a solution.
#[must_use]
pub fn from_kinematics(error: &KinematicError) -> Refusal {
    match *error {
        KinematicError::NotFinite | KinematicError::NotARotation { .. } => {
            Refusal::NotFinite { index: 0 }
        }
        KinematicError::Unreachable => Refusal::Unreachable,
        KinematicError::Singular => Refusal::Singular,
        KinematicError::Limit {
            axis: index,
            quantity,
            value,
            lower,
            upper,
            ..
        } => Refusal::Limit {
            axis: axis(index),
            quantity: match quantity {
                robots::Quantity::Motor => Quantity::MotorPosition,
                robots::Quantity::Joint
                | robots::Quantity::ScrewAngle
                | robots::Quantity::ScrewLength => Quantity::JointPosition,
            },
            value,
            limit: if value > upper { upper } else { lower },
        },
    }
}

/// A knot of which there can be no piece, or a piece that does not go into the queue; `state` is the node's.
#[must_use]
pub fn from_push(error: &PushError, state: NodeState) -> Refusal {
    match *error {
        PushError::NotStarted | PushError::Stopped { .. } | PushError::Stale => {
            Refusal::WrongState { state }
        }
        PushError::Full => Refusal::QueueFull,
        PushError::NotMonotone { .. } => Refusal::NotMonotone,
        PushError::Late { .. } => Refusal::Late,
        PushError::NotFinite { axis: index } => Refusal::NotFinite { index: axis(index) },
        PushError::Limit {
            axis: index,
            quantity,
            value,
            limit,
        } => Refusal::Limit {
            axis: axis(index),
            quantity: match quantity {
                motion::knot::Quantity::Position => Quantity::MotorPosition,
                motion::knot::Quantity::Velocity => Quantity::Velocity,
                motion::knot::Quantity::Acceleration => Quantity::Acceleration,
                motion::knot::Quantity::Jerk => Quantity::Jerk,
            },
            value,
            limit,
        },
        PushError::Long => Refusal::OutOfRange {
            index: 0,
            value: f32::INFINITY,
            lower: 0.0,
            upper: 4294.0,
        },
        PushError::NoRoomToStop {
            axis: index,
            value,
            limit,
        }
        | PushError::Far {
            axis: index,
            value,
            limit,
        } => Refusal::Limit {
            axis: axis(index),
            quantity: Quantity::MotorPosition,
            value,
            limit,
        },
        PushError::AccelerationStep {
            axis: index,
            value,
            limit,
        } => Refusal::Limit {
            axis: axis(index),
            quantity: Quantity::Acceleration,
            value,
            limit,
        },
    }
}
