//! The rim: where frames come from and go to.

use protocol::frame::Frame;
use protocol::time::Micros;

/// One of the node's CAN ports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Port {
    /// Towards the MP.
    Mp,
    /// Towards the drives; a node may have several drive buses.
    Drives(u8),
}

/// A frame that arrived.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Received {
    /// Where.
    pub port: Port,
    /// When, local time.
    pub at: Micros,
    /// What.
    pub frame: Frame,
}
