//! What travels: CAN frames, MP ↔ node messages and their framing, CANopen towards the drives.
//!
//! | module | one line |
//! |---|---|
//! | [`frame`] | one CAN or CAN FD data frame and its identifier |
//! | [`time`] | bus time in microseconds |
//! | [`units`] | axis counts, position units |
//! | [`message`] | every message between MP and node: the interface document |
//! | [`maintenance`] | who a node is, its first fault, its next image |
//! | [`fault`] | causes, reactions and refusals, as typed codes |
//! | [`id`] | Cyphal/CAN identifiers and the table of our ports |
//! | [`transfer`] | a payload as frames, and back |
//! | [`codec`] | messages as bytes |
//! | [`e2e`] | end-to-end protection |
//! | [`cyphal`] | the standard heartbeat and node information |
//! | [`link`] | an endpoint: typed messages in, frames out, and back |
//! | [`clock`] | two-step time synchronisation |
//! | [`embedded`] | classical frames for `embedded-can` drivers |
//! | [`budget`] | how long a frame occupies the wire |
//! | [`canopen`] | CiA 301 and CiA 402, for the node and for the drive |
//! | [`force_torque`] | what a force sensor in a wrist tells |
//! | [`schema`] | one hash of every type that travels |
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

#[cfg(test)]
extern crate std;

pub mod budget;
pub mod canopen;
pub mod clock;
pub mod codec;
pub mod cyphal;
pub mod e2e;
pub mod embedded;
pub mod fault;
pub mod force_torque;
pub mod frame;
pub mod id;
pub mod link;
pub mod maintenance;
pub mod message;
pub mod schema;
pub mod time;
pub mod transfer;
pub mod units;
