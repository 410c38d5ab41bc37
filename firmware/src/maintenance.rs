//! What a node does for those who keep it: it says who it is and why it started, keeps the signals before its first
//! fault, and takes its next image.
//!
//! The node itself only collects: the signals of a step, and one request. Beside it are the [`Recorder`], whose memory is quick,
//! and the [`Librarian`], whose memory is not. A microcontroller has the one in the servo step and the other between servo
//! steps; a host has both right after them ([`Kept`]).

pub mod black_box;
mod kept;
mod librarian;
mod recorder;

pub use kept::{Keeper, Kept, Maintainable};
pub use librarian::Librarian;
pub use recorder::Recorder;

use protocol::id::NodeId;
use protocol::maintenance::{MAX_TARGET, MaintenanceRefusal, MaintenanceRequest, ResetCause};
use protocol::transfer::TransferId;

/// A request that waits for its answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Asked {
    /// Who asks.
    pub from: NodeId,
    /// To be repeated in the answer.
    pub transfer_id: TransferId,
    /// May the sender write now?
    pub allowed: Result<(), MaintenanceRefusal>,
    /// What is asked for.
    pub request: MaintenanceRequest,
}

impl Asked {
    /// Whoever writes must be allowed to.
    fn permitted(&self) -> Result<(), MaintenanceRefusal> {
        match self.request.epoch() {
            Some(_) => self.allowed,
            None => Ok(()),
        }
    }
}

/// What the rim knows of its node's start.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Start {
    /// What images must be made for.
    pub target: heapless::String<MAX_TARGET>,
    /// Why it started.
    pub cause: ResetCause,
    /// Starts so far, this one included.
    pub boots: u32,
}
