//! A loopback TCP server of the socketcand protocol, and its client: a bus for other tools.
//!
//! The protocol is that of <https://github.com/linux-can/socketcand> (`doc/protocol.md`), raw mode,
//! so python-can (`interface="socketcand"`), Kayak and socketcand's own tools can join without
//! kernel support:
//!
//! ```text
//! server                       client
//! < hi >
//!                              < open mp >
//! < ok >
//!                              < rawmode >
//! < ok >
//! < frame 123 23.424242 1122 > < send 123 2 11 22 >
//! < echo >                     < echo >
//! < error what is wrong >      anything else
//! ```
//!
//! Three things are as existing clients need them rather than as the document says: data bytes of
//! `frame` are written without spaces (socketcand and python-can do so), an empty frame keeps the
//! space of its data, and frames are held for [`HOLD`] after `rawmode`, since python-can does not
//! expect a frame in the same packet as the `< ok >`. Identifiers have three digits (11 bits) or
//! eight (29 bits). CAN FD and remote frames are refused with an error line.
//!
//! A [`HubServer`] has several named channels, each a bus of its own. Whatever one participant
//! sends, all others of the channel receive. Input is not trusted: lines, clients, and queues are
//! bounded; a participant that does not read loses frames ([`HubServer::dropped`]), not the others.

mod channel;
mod client;
mod element;
mod server;

pub use channel::HubTap;
pub use client::HubClient;
pub use server::{HubServer, Reachable};

use std::time::Duration;

/// The port of socketcand.
pub const DEFAULT_PORT: u16 = 29536;

/// The longest `< … >`, bytes.
pub const MAX_ELEMENT: usize = 256;

/// The most clients at once, over all channels.
pub const MAX_CLIENTS: usize = 32;

/// Frames that wait for one participant.
pub const QUEUE: usize = 4096;

/// The longest name of a channel (socketcand: 16).
pub const MAX_NAME: usize = 16;

/// How long frames are held back after `< rawmode >` was acknowledged.
pub const HOLD: Duration = Duration::from_millis(100);

/// A client that does not open a channel within this time is sent away.
const HANDSHAKE: Duration = Duration::from_secs(10);

/// A client that takes no data for this time is sent away.
const STUCK: Duration = Duration::from_secs(5);

#[cfg(test)]
mod tests;
