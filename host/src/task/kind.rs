//! What a cell assumes of a robot's kind where its file says nothing.

use crate::mp::arm::arm;
use motion::pose::Pose;
use robots::RobotKind;

/// The most axes of one drive bus, and how many are on the first of two: what a classical bus at
/// 1 Mbit/s carries at the robots' servo rate.
const AXES_OF_A_BUS: usize = 6;
const AXES_OF_THE_FIRST: usize = 4;

/// Which axes (from 0) share a drive bus.
pub(super) fn drive_groups(kind: RobotKind) -> Vec<Vec<usize>> {
    let axes = kind.axes();
    if axes > AXES_OF_A_BUS {
        vec![
            (0..AXES_OF_THE_FIRST).collect(),
            (AXES_OF_THE_FIRST..axes).collect(),
        ]
    } else {
        vec![(0..axes).collect()]
    }
}

/// The base in the world, whose frame is that of the robot on the track.
pub(super) fn t_world_base(kind: RobotKind) -> Pose {
    arm(kind).base()
}
