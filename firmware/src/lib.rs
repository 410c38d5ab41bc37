//! `C_j`: the controller node of one effector, ECP and EDP, for microcontrollers and hosts alike.
//!
//! [`Node::step`] is the whole of it: frames and the time go in, frames come out. No allocation, no
//! clock, no panic path; the same bytes on every machine.
//!
//! | module | one line |
//! |---|---|
//! | [`process`] | a node without its type parameters, and how a cell is wired |
//! | [`node`] | the node: link, lease, ECP and EDP in one step function |
//! | [`session`] | the command lease: who may command |
//! | [`ecp`] | the Effector Control Process: instructions, generators, conditions |
//! | [`edp`] | the Effector Driver Process: homing, interpolation, limits, servo loops, drives |
//! | [`maintenance`] | what a node does for those who keep it: identity, black box, updates |
//! | [`update`] | the next image: slots, transfer, which one starts |
//! | [`vsp`] | virtual sensors on the node |
//! | [`config`] | what a node is told about itself |
//! | [`capacity`] | every capacity, with its arithmetic |
//! | [`io`] | ports and received frames: the rim |
#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    deny(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::indexing_slicing
    )
)]

pub mod capacity;
pub mod config;
pub mod ecp;
pub mod edp;
pub mod io;
pub mod maintenance;
pub mod node;
pub mod process;
pub mod session;
pub mod update;
pub mod vsp;

pub use config::{ConfigError, DriveAddress, KnownDrives, NodeConfig};
pub use ecp::Ecp;
pub use io::{Port, Received};
pub use node::{Foreground, Node, NodeSetup};
pub use process::{NodeProcess, Station};
