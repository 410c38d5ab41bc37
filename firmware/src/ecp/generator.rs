//! The motion generators every node has.
//!
//! One file per generator; its class (\[Z1\] VI) stands in the first line of its documentation.

pub mod axis_move;
pub mod follow;
pub mod guarded;
pub mod hold;
pub mod line_move;
pub mod path_move;
pub mod pose_move;

pub use axis_move::{JointMove, MotorMove};
pub use follow::Follow;
pub use guarded::Guarded;
pub use hold::Hold;
pub use line_move::LineMove;
pub use path_move::PathMove;
pub use pose_move::PoseMove;
