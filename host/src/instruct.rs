//! What tasks and trajectories ask for, as instructions of the controller node's library.

use crate::task::{Move, Target};
use crate::trj::{Node, Reference, Space, Trajectory};
use motion::pose::Pose;
use protocol::message::{
    AxisSpeeds, Instruction, PoseMessage, PosePath, PoseReference, PoseSpeeds,
};
use protocol::units::{MAX_AXES, PerAxis};

impl Trajectory {
    /// The instruction that runs one of its nodes: axes straight in their space, poses on a
    /// straight line at the slowest of the speeds given for x, y, z and for the orientation.
    #[must_use]
    pub fn instruction(&self, node: &Node) -> Instruction {
        let relative = self.reference == Reference::Relative;
        let target = per_axis(&node.coordinates);
        let speeds = AxisSpeeds {
            velocity: fractions(node.velocity.iter().copied()),
            acceleration: fractions(node.acceleration.iter().copied()),
        };
        match self.space {
            Space::Motor => Instruction::MoveMotors {
                target,
                relative,
                speeds,
            },
            Space::Joint => Instruction::MoveJoints {
                target,
                relative,
                speeds,
            },
            Space::XyzAngleAxis | Space::XyzEulerZyz => Instruction::MovePose {
                target: pose_message(&self.pose(node).unwrap_or_else(Pose::identity)),
                reference: if relative {
                    PoseReference::Tool
                } else {
                    PoseReference::Base
                },
                path: PosePath::Line,
                speeds: pose_speeds(
                    [
                        slowest(node.velocity.iter().take(3)),
                        slowest(node.velocity.iter().skip(3)),
                    ],
                    [
                        slowest(node.acceleration.iter().take(3)),
                        slowest(node.acceleration.iter().skip(3)),
                    ],
                ),
            },
        }
    }
}

impl Move {
    /// The instruction that runs it.
    #[must_use]
    pub fn instruction(&self) -> Instruction {
        let speeds = |axes: usize| AxisSpeeds {
            velocity: fractions(std::iter::repeat_n(self.velocity, axes)),
            acceleration: fractions(std::iter::repeat_n(self.acceleration, axes)),
        };
        match &self.target {
            Target::Motors { values, relative } => Instruction::MoveMotors {
                target: per_axis(values),
                relative: *relative,
                speeds: speeds(values.len()),
            },
            Target::Joints { values, relative } => Instruction::MoveJoints {
                target: per_axis(values),
                relative: *relative,
                speeds: speeds(values.len()),
            },
            Target::Pose {
                pose, reference, ..
            } if self.until_force_n.is_some() => Instruction::MoveUntilForce {
                target: pose_message(pose),
                reference: *reference,
                speeds: pose_speeds([self.velocity; 2], [self.acceleration; 2]),
                newtons: narrow(self.until_force_n.unwrap_or(0.0)),
            },
            Target::Pose {
                pose,
                reference,
                path,
            } => Instruction::MovePose {
                target: pose_message(pose),
                reference: *reference,
                path: *path,
                speeds: pose_speeds([self.velocity; 2], [self.acceleration; 2]),
            },
        }
    }
}

/// A pose as it travels.
#[must_use]
pub fn pose_message(pose: &Pose) -> PoseMessage {
    PoseMessage {
        position_m: pose.position.into(),
        rotation_rad: pose.rotation_vector().into(),
    }
}

/// One value per axis; readers of files have seen to it that there are no more than [`MAX_AXES`].
fn per_axis(values: &[f64]) -> PerAxis<f64> {
    values.iter().copied().take(MAX_AXES).collect()
}

fn fractions(values: impl Iterator<Item = f64>) -> PerAxis<f32> {
    values.map(narrow).take(MAX_AXES).collect()
}

fn slowest<'a>(fractions: impl Iterator<Item = &'a f64>) -> f64 {
    fractions.fold(
        1.0,
        |least, &value| if value < least { value } else { least },
    )
}

/// Fractions (translation, rotation) of velocity and acceleration as speeds of the tool.
fn pose_speeds(velocity: [f64; 2], acceleration: [f64; 2]) -> PoseSpeeds {
    let [v, w] = velocity.map(|f| narrow(f * Space::XyzAngleAxis.velocity_ceiling()));
    let [a, b] = acceleration.map(|f| narrow(f * Space::XyzAngleAxis.acceleration_ceiling()));
    PoseSpeeds {
        velocity_m_s: v,
        angular_velocity_rad_s: w,
        acceleration_m_s2: a,
        angular_acceleration_rad_s2: b,
    }
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "speeds travel as f32; 24 bits of a fraction are enough"
)]
fn narrow(value: f64) -> f32 {
    value as f32
}

#[cfg(test)]
mod test {
    use super::*;

    #[test]
    fn a_relative_pose_node_is_a_line_in_the_tool_frame() {
        let text = "XYZ_ANGLE_AXIS\n1\nRELATIVE\n0.02 0.01 0.03 0.1 0.1 0.1\n\
            0.1 0.1 0.1 0.04 0.05 0.06\n0 0 0.1 0 0 0.5\n";
        let read = crate::trj::parse(text, 7).unwrap();
        let Instruction::MovePose {
            target,
            reference,
            path,
            speeds,
        } = read.instruction(&read.nodes[0])
        else {
            panic!("not a pose");
        };
        assert_eq!(reference, PoseReference::Tool);
        assert_eq!(path, PosePath::Line);
        assert!((target.position_m[2] - 0.1).abs() < 1e-15);
        assert!((target.rotation_rad[2] - 0.5).abs() < 1e-15);
        // the slowest fraction of each kind, times 5 m/s, 5 rad/s, …
        assert!((speeds.velocity_m_s - 0.05).abs() < 1e-6);
        assert!((speeds.angular_velocity_rad_s - 0.5).abs() < 1e-6);
        assert!((speeds.acceleration_m_s2 - 0.5).abs() < 1e-6);
        assert!((speeds.angular_acceleration_rad_s2 - 0.2).abs() < 1e-6);
    }

    #[test]
    fn axes_keep_their_own_fractions() {
        let read = crate::trj::parse("MOTOR\n1\n0.5 0.25\n1 0.125\n-3 4\n", 2).unwrap();
        let Instruction::MoveMotors {
            target,
            relative,
            speeds,
        } = read.instruction(&read.nodes[0])
        else {
            panic!("not motors");
        };
        assert!(!relative);
        assert_eq!(target.as_slice(), [-3.0, 4.0]);
        assert_eq!(speeds.velocity.as_slice(), [0.5, 0.25]);
        assert_eq!(speeds.acceleration.as_slice(), [1.0, 0.125]);
    }
}
