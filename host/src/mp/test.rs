//! Scenarios of the Master Process in virtual time, against peers that speak the real wire.

mod handshake;
mod motion;
pub(crate) mod peer;
mod stream;
mod tight;
pub(crate) mod world;
