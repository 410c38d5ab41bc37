//! What a cell assumes of a robot's kind where its file says nothing.

use motion::pose::Pose;
use robots::{Irp6Postument, Irp6Track, Robot, RobotKind};

/// Which axes (from 0) share a drive bus: no more than a classical bus at 1 Mbit/s carries at the
/// robot's servo rate.
pub(super) const fn drive_groups(kind: RobotKind) -> &'static [&'static [usize]] {
    match kind {
        RobotKind::Irp6Track => &[&[0, 1, 2, 3], &[4, 5, 6]],
        RobotKind::Irp6Postument => &[&[0, 1, 2, 3, 4, 5]],
    }
}

/// The base in the world, whose frame is that of the robot on the track.
pub(super) fn t_world_base(kind: RobotKind) -> Pose {
    match kind {
        RobotKind::Irp6Track => Irp6Track.description().base(),
        RobotKind::Irp6Postument => Irp6Postument.description().base(),
    }
}
