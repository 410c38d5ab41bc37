//! What every board of the controller node has in common, as far as it is no hardware; and what an
//! emulated board and the process that emulates its world say to each other.
//!
//! | module | one line |
//! |---|---|
//! | [`boot`] | what an image is told when it starts, and the node made of it |
//! | [`upkeep`] | who keeps a node: the recorder in the servo steps, the librarian below them |
//! | [`tandem`] | the two halves of a node: servo steps, and the work of the ECP below them |
//! | [`frames`] | a CAN frame with its port and time as bytes |
//! | [`channel`] | the lock-step channel: one message in, one message out, a step of the node between |
//! | [`mailbox`] | the real-time mailbox: two rings of frames in shared memory |
//!
//! And what a board with pins needs, without its pins:
//!
//! | module | one line |
//! |---|---|
//! | [`bit_timing`] | the bits of CAN and CAN FD, from the clock of the controller |
//! | [`mcan`] | Bosch's CAN controller, as in the STM32: registers and message memory |
//! | [`port`] | one CAN port: controller, frames that wait, bus-off |
//! | [`outbox`] | frames that wait to be sent, the most urgent first |
//! | [`time_base`] | microseconds from counters that wrap around |
//! | [`inbox`] | frames that wait for the node |
//! | [`rim`] | a step of the node |
//! | [`tick`] | all that a tick does: the next five |
//! | [`guard`] | what stops a robot by wire, and the pins |
//! | [`emergency`] | the emergency stop: two contacts, debounced, compared, latched |
//! | [`torque`] | safe torque off and the brake, in their order |
//! | [`alive`] | who may feed the watchdog |
//! | [`light`] | what the status light says |
//! | [`reset`] | why the board was reset, kept over resets |
//! | [`config`] | which node a board makes |
//! | [`store`] | a configuration in flash, twice |
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

pub mod alive;
pub mod bit_timing;
pub mod boot;
mod bytes;
pub mod channel;
pub mod config;
pub mod emergency;
pub mod frames;
pub mod guard;
pub mod inbox;
pub mod light;
pub mod mailbox;
pub mod mcan;
pub mod outbox;
pub mod port;
pub mod reset;
pub mod rim;
pub mod store;
pub mod tandem;
pub mod tick;
pub mod time_base;
pub mod torque;
pub mod upkeep;
#[cfg(test)]
mod wire;
