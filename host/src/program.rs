//! From a task to motion: planned with kinematics before anything moves, then run step by step.
//!
//! | module | one line |
//! |---|---|
//! | [`plan`] | every node of a task walked through: limits, reach, homing |
//! | [`run`] | the handshake, the steps, and coming to rest whatever happens |
//! | [`progress`] | what a person is told, and what an observer compares with |
//!
//! ```text
//!  task ──▶ Plan (where the robots really are) ──▶ a job of the MP per step ──▶ rest ──▶ leases given back
//! ```

use crate::mp::arm::arm_with;
use crate::mp::config::{Config, RobotConfig};
use crate::task::{BusKind, Cell};
use protocol::id::NodeId;
use protocol::transfer::Mtu;
use robots::{RobotKind, VelocityFactor};

pub mod plan;
pub mod progress;
pub mod run;

pub use plan::{Plan, PlanError};
pub use progress::{Progress, Segment};
pub use run::{Run, RunError, RunStatus};

/// The Master Process of a cell. Frames are as long as the shortest of its buses towards the nodes
/// allows. A robot's effector number is that of its kind ([`RobotKind::effector`]), as nodes choose
/// it by themselves; a second robot of a kind gets the next number that no kind has.
///
/// Nothing if the cell has more robots than there are node numbers, or a velocity factor outside
/// (0, 1]; task files cannot say that.
#[must_use]
pub fn config_of(cell: &Cell) -> Option<Config> {
    let mut robots = Vec::new();
    let mut mtu = Mtu::Fd;
    let mut taken: Vec<u8> = Vec::new();
    for spec in &cell.robots {
        let own = spec.kind.effector();
        let j = (!taken.contains(&own)).then_some(own);
        let first = u8::try_from(RobotKind::ALL.len()).ok()?.checked_add(1)?;
        let j = j.or_else(|| (first..=u8::MAX).find(|j| !taken.contains(j)))?;
        taken.push(j);
        let arm = arm_with(spec.kind, spec.track);
        robots.push(RobotConfig {
            name: spec.name.clone(),
            node: NodeId::effector(j)?,
            arm,
            t_world_base: spec.t_world_base,
            t_flange_tool: arm.default_tool(),
            servo: spec.servo,
            velocity_factor: VelocityFactor::new(spec.velocity_factor)?,
        });
        if cell
            .buses
            .get(spec.mp_bus)
            .is_some_and(|bus| bus.kind == BusKind::Classic)
        {
            mtu = Mtu::Classic;
        }
    }
    (robots.len() == cell.robots.len()).then(|| Config {
        mtu,
        ..Config::new(robots)
    })
}

#[cfg(test)]
mod test;
