//! What every board of the controller node has in common, as far as it is no hardware; and what an
//! emulated board and the process that emulates its world say to each other.
//!
//! | module | one line |
//! |---|---|
//! | [`boot`] | what an image is told when it starts, and the node made of it |
//! | [`frames`] | a CAN frame with its port and time as bytes |
//! | [`channel`] | the lock-step channel: one message in, one message out, a step of the node between |
//! | [`mailbox`] | the real-time mailbox: two rings of frames in shared memory |
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

pub mod boot;
mod bytes;
pub mod channel;
pub mod frames;
pub mod mailbox;
