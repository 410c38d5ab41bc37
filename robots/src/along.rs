//! A pose on a path and its derivatives, and those of the joints.

use motion::Pose;
use motion::path::PathPoint;
use nalgebra::Vector3;

use crate::jet::Jet;
use crate::narrow::narrow;
use crate::space::Joints;

/// A pose of the flange on a path in the base frame, with its derivatives by the path's parameter s.
///
/// The pose is f64: joints are found from it. The derivatives are f32, off by some units of 6e-8 of themselves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseAlong {
    /// `t_base_flange`.
    pub pose: Pose,
    /// p', p'', p''': m per unit of s, its square, its cube.
    pub linear: [Vector3<f32>; 3],
    /// ω, ω', ω'', where R' = \[ω\]ₓ·R: rad likewise.
    pub angular: [Vector3<f32>; 3],
}

/// Joints on a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointsAlong<const N: usize> {
    /// q, rad or m.
    pub position: Joints<N>,
    /// q', q'', q''' by the path's parameter; none where the robot does not know them, or near a singularity.
    pub rates: Option<[[f32; N]; 3]>,
}

impl<const N: usize> JointsAlong<N> {
    /// Without their derivatives.
    pub(crate) const fn at(position: Joints<N>) -> Self {
        Self {
            position,
            rates: None,
        }
    }
}

impl PoseAlong {
    /// The flange, where the tool is at a point of a path.
    ///
    /// With c the flange's origin as the tool sees it, `p = p_tool + R·c`, and a vector v that turns with ω has
    /// v' = ω×v, v'' = ω'×v + ω×v', v''' = ω''×v + 2·ω'×v' + ω×v''.
    #[must_use]
    pub fn of_flange(tool: &PathPoint, t_tool_flange: &Pose) -> Self {
        let offset = tool.pose.rotation * t_tool_flange.position;
        let angular = [&tool.first, &tool.second, &tool.third].map(|twist| short(&twist.angular));
        let [p1, p2, p3] = [&tool.first, &tool.second, &tool.third].map(|t| short(&t.linear));
        let [_, c1, c2, c3] = carried(short(&offset), &angular);
        Self {
            pose: Pose {
                position: tool.pose.position + offset,
                rotation: tool.pose.rotation * t_tool_flange.rotation,
            },
            linear: [p1 + c1, p2 + c2, p3 + c3],
            angular,
        }
    }

    /// x, y, z of the flange's origin.
    pub(crate) fn origin(&self) -> [Jet; 3] {
        let [a, b, c] = self.linear;
        jets([short(&self.pose.position), a, b, c])
    }

    /// x, y, z of a vector that turns with the flange.
    pub(crate) fn turning(&self, v: &Vector3<f64>) -> [Jet; 3] {
        jets(carried(short(v), &self.angular))
    }
}

/// A vector that turns, and its derivatives.
fn carried(v: Vector3<f32>, [w, w1, w2]: &[Vector3<f32>; 3]) -> [Vector3<f32>; 4] {
    let v1 = w.cross(&v);
    let v2 = w1.cross(&v) + w.cross(&v1);
    let v3 = w2.cross(&v) + w1.cross(&v1) * 2.0 + w.cross(&v2);
    [v, v1, v2, v3]
}

fn jets([a, b, c, d]: [Vector3<f32>; 4]) -> [Jet; 3] {
    [
        Jet([a.x, b.x, c.x, d.x]),
        Jet([a.y, b.y, c.y, d.y]),
        Jet([a.z, b.z, c.z, d.z]),
    ]
}

fn short(v: &Vector3<f64>) -> Vector3<f32> {
    Vector3::new(narrow(v.x), narrow(v.y), narrow(v.z))
}
