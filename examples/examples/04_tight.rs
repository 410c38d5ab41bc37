//! Tight coordination: two arms carry an object that neither may bend.
//!
//! The Master Process computes where the object is at every instant, and from that the joints of
//! both arms. What counts is how the tools stand to each other: measured here from the true angles
//! of the motors, after gears, friction and gravity have had their say.

use agent::Class;
use anyhow::{Context as _, Result};
use firmware::ecp::NoPrograms;
use host::mp::behaviour::{carry, execute};
use host::mp::generator::{AsPlanned, Carried, Carry, Course};
use host::mp::subsystem::MpSubsystem;
use host::task::Tight;
use mrroc_examples::{Arm, World};
use protocol::message::{Instruction, PoseMessage, PosePath, PoseReference, PoseSpeeds};

/// Where the tools of the two arms grip the object: `t_base_tool`, m and rotation vector in rad.
const GRIPS: [PoseMessage; 2] = [
    PoseMessage {
        position_m: [0.80, 0.55, 0.38],
        rotation_rad: [-1.60, 0.10, -2.05],
    },
    PoseMessage {
        position_m: [0.80, -0.38, 0.38],
        rotation_rad: [1.60, 0.10, 2.05],
    },
];

/// What happens to the object: lifted by 8 cm and turned by 0.12 rad within 6 s.
fn lift_and_turn() -> Tight {
    Tight {
        robots: vec![0, 1],
        displacement_m: [0.0, 0.0, 0.08],
        rotation_rad: [0.0, 0.0, 0.12],
        centre_m: [0.76, 1.14, 0.37],
        duration_s: 6.0,
    }
}

/// An instruction of the node's own library: to a grip, straight in joint space.
fn to_grip(grip: PoseMessage) -> Instruction {
    Instruction::MovePose {
        target: grip,
        reference: PoseReference::Base,
        path: PosePath::Joint,
        speeds: PoseSpeeds {
            velocity_m_s: 1.0,
            angular_velocity_rad_s: 1.0,
            acceleration_m_s2: 1.0,
            angular_acceleration_rad_s2: 1.0,
        },
    }
}

/// `f^0(c_0)`: the carry, begun where the arms stand.
fn carrying(world: &World) -> Result<Carry<AsPlanned>> {
    let mut carried = Vec::new();
    for (k, image) in world.mp.robots().iter().enumerate() {
        let joints = image.demanded_joints().context("no feedback")?;
        carried.push(Carried::new(k, image.config(), joints)?);
    }
    let course = Course::new(lift_and_turn(), carried)?;
    Ok(Carry::new(
        course,
        AsPlanned,
        world.mp.grid(),
        &world.mp.config().timing,
    )?)
}

/// The example, as the text it prints.
pub(crate) fn example() -> Result<String> {
    let mut world = World::new(vec![Arm::track(NoPrograms)?, Arm::postument(NoPrograms)?])?;
    world.get_ready()?;
    let (grid, timing) = (world.mp.grid(), world.mp.config().timing);
    let grips = GRIPS.into_iter().map(to_grip).enumerate().collect();
    world.run(execute(grips, grid, &timing))?;

    let between = |world: &World| Ok(world.tool(0)?.inverse() * world.tool(1)?);
    let gripped = between(&world)?;
    let from = world.tool(0)?;
    let (mut shift_m, mut turn_rad) = (0.0, 0.0);
    let carrying = carrying(&world)?;
    world.watch(carry(carrying, grid), |world| {
        let strain: Result<motion::Pose> = between(world).map(|now| gripped.inverse() * now);
        if let Ok(strain) = strain {
            let (shift, turn) = (strain.position.norm(), strain.rotation_vector().norm());
            shift_m = if shift > shift_m { shift } else { shift_m };
            turn_rad = if turn > turn_rad { turn } else { turn_rad };
        }
    })?;
    let way = from.inverse() * world.tool(0)?;
    Ok(format!(
        "Move by {}\n\
         the first tool: moved by {:.1} mm, turned by {:.1} mrad\n\
         between the tools: at most {:.2} mm, {:.2} mrad from the grip\n\
         {} faults\n",
        Class::generator::<MpSubsystem, Carry<AsPlanned>>(),
        1e3 * way.position.norm(),
        1e3 * way.rotation_vector().norm(),
        1e3 * shift_m,
        1e3 * turn_rad,
        world.faults(),
    ))
}

fn main() -> Result<()> {
    print!("{}", example()?);
    Ok(())
}
