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

use crate::mp::arm::arm;
use crate::mp::config::{Config, RobotConfig};
use crate::task::{BusKind, Cell};
use protocol::id::NodeId;
use protocol::transfer::Mtu;
use robots::VelocityFactor;

pub mod plan;
pub mod progress;
pub mod run;

pub use plan::{Plan, PlanError};
pub use progress::{Progress, Segment};
pub use run::{Run, RunError, RunStatus};

/// The Master Process of a cell: robots are effectors 1, 2, … in the cell's order, and frames are as
/// long as the shortest of its buses towards the nodes allows.
///
/// Nothing if the cell has more robots than there are node numbers, or a velocity factor outside
/// (0, 1]; task files cannot say that.
#[must_use]
pub fn config_of(cell: &Cell) -> Option<Config> {
    let mut robots = Vec::new();
    let mut mtu = Mtu::Fd;
    for (spec, j) in cell.robots.iter().zip(1_u8..) {
        let arm = arm(spec.kind);
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
