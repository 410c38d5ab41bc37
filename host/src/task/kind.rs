//! What a cell assumes of a robot's kind where its file says nothing.

use crate::mp::arm::arm;
use motion::pose::Pose;
use robots::{Robot, RobotKind, RobotVisitor, TrackRule};

/// Which axes (from 0) share a drive bus.
pub(super) fn drive_groups(kind: RobotKind) -> Vec<Vec<usize>> {
    kind.visit(TrackRule::Keep, Groups)
}

struct Groups;

impl RobotVisitor for Groups {
    type Output = Vec<Vec<usize>>;

    fn visit<R: Robot<N>, const N: usize>(self, robot: R) -> Self::Output {
        let mut groups = Vec::new();
        for (axis, bus) in robot.description().drive_buses().into_iter().enumerate() {
            groups.resize_with(groups.len().max(usize::from(bus) + 1), Vec::new);
            if let Some(group) = groups.get_mut(usize::from(bus)) {
                group.push(axis);
            }
        }
        groups
    }
}

/// The base in the world, whose frame is that of the robot on the track.
pub(super) fn t_world_base(kind: RobotKind) -> Pose {
    arm(kind).base()
}
