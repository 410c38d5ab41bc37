//! From the errors of planning and kinematics to refusals on the wire.

use motion::profile::ProfileError;
use protocol::fault::{Quantity, Refusal};
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
