//! A chain as a URDF file: the XML of robot models that Pinocchio, `MuJoCo`, `RViz` and others read.
//!
//! Joints are the chain's: Denavit–Hartenberg relative, z of the link's frame the axis. Numbers are
//! printed with as few digits as give the same number back. A placement's rotation becomes roll, pitch
//! and yaw, R = Z(yaw)·Y(pitch)·X(roll), which is right to rounding (1e-16 an entry). Rotors' inertias
//! are not in the file: they are the motors'.

use core::fmt::{self, Write};

use crate::description::{JointKind, Range, RobotDescription};
use crate::dynamics::{Body, Chain, Link, Placement, Shape};

/// What a URDF file says of a joint's limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLimits {
    /// rad or m; an infinite end makes a revolute joint `continuous`.
    pub position: Range,
    /// Greatest speed, rad/s or m/s.
    pub velocity: f64,
    /// Greatest torque, N·m, or force, N.
    pub effort: f64,
}

/// The limits of a robot's joints: ranges and speeds of its description; as effort, the motor's torque
/// at the current at which its drive trips, times the greatest slope of its own gear.
#[must_use]
pub fn joint_limits<const N: usize>(
    robot: &RobotDescription<N>,
    motor_slopes: &[f64; N],
) -> [JointLimits; N] {
    let mut slopes = motor_slopes.iter();
    robot.axes.map(|axis| {
        let torque = f64::from(axis.overcurrent_ma) * 1e-3 * axis.motor.torque_constant_nm_a;
        JointLimits {
            position: axis.joint_position,
            velocity: axis.joint_velocity,
            effort: torque * slopes.next().copied().unwrap_or(0.0),
        }
    })
}

/// Writes the chain as a URDF robot of this name: the link `base`, a link for each of the chain's with
/// its joint `NAME-joint`, and the link `flange`. A `comment`, if not empty, is put before it; it must
/// not contain two hyphens in a row. Names are written as they are.
///
/// # Errors
/// Those of `out`.
pub fn write_urdf<const N: usize>(
    out: &mut impl Write,
    name: &str,
    comment: &str,
    limits: &[JointLimits; N],
    chain: &Chain<N>,
) -> fmt::Result {
    writeln!(out, "<?xml version=\"1.0\"?>")?;
    if !comment.is_empty() {
        writeln!(out, "<!-- {comment} -->")?;
    }
    writeln!(out, "<robot name=\"{name}\">\n  <link name=\"base\"/>")?;
    let mut parent = "base";
    for (link, limits) in chain.links.iter().zip(limits) {
        joint(out, link, parent, limits)?;
        body(out, link)?;
        parent = link.name;
    }
    writeln!(out, "  <joint name=\"flange-joint\" type=\"fixed\">")?;
    ends(out, parent, "flange", &chain.flange)?;
    writeln!(out, "  </joint>\n  <link name=\"flange\"/>\n</robot>")
}

fn joint(out: &mut impl Write, link: &Link, parent: &str, limits: &JointLimits) -> fmt::Result {
    let Range { lower, upper } = limits.position;
    let bounded = lower.is_finite() && upper.is_finite();
    let kind = match link.kind {
        JointKind::Revolute if bounded => "revolute",
        JointKind::Revolute => "continuous",
        JointKind::Prismatic => "prismatic",
    };
    let name = link.name;
    writeln!(out, "  <joint name=\"{name}-joint\" type=\"{kind}\">")?;
    ends(out, parent, name, &link.placement)?;
    writeln!(out, "    <axis xyz=\"0 0 1\"/>")?;
    write!(out, "    <limit")?;
    if bounded {
        write!(out, " lower=\"{lower}\" upper=\"{upper}\"")?;
    }
    let JointLimits {
        velocity, effort, ..
    } = limits;
    writeln!(
        out,
        " velocity=\"{velocity}\" effort=\"{effort}\"/>\n  </joint>"
    )
}

fn ends(out: &mut impl Write, parent: &str, child: &str, placement: &Placement) -> fmt::Result {
    writeln!(
        out,
        "    <parent link=\"{parent}\"/>\n    <child link=\"{child}\"/>"
    )?;
    let turn = roll_pitch_yaw(&placement.axes);
    origin(out, "    ", placement.position_m, turn)
}

fn origin(
    out: &mut impl Write,
    indent: &str,
    [x, y, z]: [f64; 3],
    [roll, pitch, yaw]: [f64; 3],
) -> fmt::Result {
    let [x, y, z, roll, pitch, yaw] = [x, y, z, roll, pitch, yaw].map(plain);
    writeln!(
        out,
        "{indent}<origin xyz=\"{x} {y} {z}\" rpy=\"{roll} {pitch} {yaw}\"/>"
    )
}

fn body(out: &mut impl Write, link: &Link) -> fmt::Result {
    let Body {
        mass_kg,
        centre_m,
        inertia: i,
    } = link.body();
    writeln!(out, "  <link name=\"{}\">\n    <inertial>", link.name)?;
    origin(out, "      ", *centre_m, [0.0; 3])?;
    writeln!(out, "      <mass value=\"{mass_kg}\"/>")?;
    let [xx, yy, zz, xy, xz, yz] = [i.xx, i.yy, i.zz, i.xy, i.xz, i.yz].map(plain);
    writeln!(
        out,
        "      <inertia ixx=\"{xx}\" iyy=\"{yy}\" izz=\"{zz}\" ixy=\"{xy}\" ixz=\"{xz}\" iyz=\"{yz}\"/>"
    )?;
    writeln!(out, "    </inertial>\n    <visual>")?;
    match link.shape {
        Shape::Cylinder {
            from: [a, b, c],
            to: [d, e, f],
            radius,
        } => {
            let (x, y, z) = (d - a, e - b, f - c);
            let across = libm::sqrt(x * x + y * y);
            let length = libm::sqrt(x * x + y * y + z * z);
            // Z(yaw)·Y(pitch) takes z onto the axis
            let turn = [0.0, libm::atan2(across, z), libm::atan2(y, x)];
            let middle = [0.5 * (a + d), 0.5 * (b + e), 0.5 * (c + f)];
            origin(out, "      ", middle, turn)?;
            writeln!(
                out,
                "      <geometry><cylinder radius=\"{radius}\" length=\"{length}\"/></geometry>"
            )?;
        }
        Shape::Box {
            centre,
            size: [x, y, z],
        } => {
            origin(out, "      ", centre, [0.0; 3])?;
            writeln!(
                out,
                "      <geometry><box size=\"{x} {y} {z}\"/></geometry>"
            )?;
        }
    }
    writeln!(out, "    </visual>\n  </link>")
}

/// The same number, without the sign of a zero.
fn plain(x: f64) -> f64 {
    x + 0.0
}

/// Below this |cos(pitch)| roll and yaw turn about the same line, and roll takes all of it.
const UPRIGHT: f64 = 1e-9;

/// Roll, pitch, yaw of a rotation, rad. With yaw known, roll is found from what is left, so it is right
/// where pitch is 90° too.
fn roll_pitch_yaw([x, y, z]: &[[f64; 3]; 3]) -> [f64; 3] {
    let level = libm::sqrt(x[0] * x[0] + x[1] * x[1]);
    let pitch = libm::atan2(-x[2], level);
    let yaw = if level < UPRIGHT {
        0.0
    } else {
        libm::atan2(x[1], x[0])
    };
    let (s, c) = (libm::sin(yaw), libm::cos(yaw));
    let roll = libm::atan2(s * z[0] - c * z[1], c * y[1] - s * y[0]);
    [roll, pitch, yaw]
}

#[cfg(test)]
mod test {
    use super::*;
    use motion::pose::exp;
    use nalgebra::{Matrix3, Vector3};
    use proptest::prelude::*;

    fn product([roll, pitch, yaw]: [f64; 3]) -> Matrix3<f64> {
        exp(Vector3::z() * yaw) * exp(Vector3::y() * pitch) * exp(Vector3::x() * roll)
    }

    proptest! {
        #[test]
        fn angles_give_the_rotation_back(w in prop::array::uniform3(-3.0..3.0f64), quarter in -1i8..=1) {
            let upright = exp(Vector3::y() * (f64::from(quarter) * core::f64::consts::FRAC_PI_2));
            for r in [exp(w.into()), exp(Vector3::z() * w[0]) * upright * exp(Vector3::x() * w[1])] {
                let back = product(roll_pitch_yaw(&r.into()));
                prop_assert!((back - r).amax() < 1e-9 + 1e-15, "{r} {back}");
            }
        }
    }

    #[test]
    fn quarter_turns_are_exact_to_rounding() {
        for axes in [
            crate::dynamics::IRP6_TRACK.links[0].placement.axes,
            crate::dynamics::IRP6_TRACK.links[1].placement.axes,
        ] {
            let back = product(roll_pitch_yaw(&axes));
            assert!((back - Matrix3::from(axes)).amax() < 4e-16, "{back}");
        }
    }
}
