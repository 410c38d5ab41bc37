//! What travels: CAN frames, MP ↔ node messages and their framing, CANopen towards the drives.
//!
//! | module | one line |
//! |---|---|
//! | [`frame`] | one CAN or CAN FD data frame and its identifier |
//! | [`time`] | bus time in microseconds |
//! | [`units`] | axis counts, position units |
//! | [`message`] | every message between MP and node: the interface document |
//! | [`fault`] | causes, reactions and refusals, as typed codes |
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

pub mod fault;
pub mod frame;
pub mod message;
pub mod time;
pub mod units;
