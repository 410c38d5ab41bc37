//! CANopen (CiA 301) and the drive profile CiA 402, for both ends of the wire.
//!
//! The controller node is NMT master, SYNC producer and SDO client; the drive (simulated or real)
//! is NMT slave, SYNC consumer and SDO server. Each protocol is a small state machine that is told
//! the time and the frame and returns frames: no clock, no queue, no allocation, no panic.
//!
//! ```text
//! cycle k:  SYNC ──▶ drives latch the targets of cycle k and sample their actual values
//!           TPDO1 of every drive ──▶ node computes the targets of cycle k+1
//!           RPDO1 to every drive (held back in the drive until SYNC k+1)
//! ```
//!
//! | module | one line |
//! |---|---|
//! | [`node`] | node identifiers and the predefined connection set |
//! | [`nmt`] | network management, boot-up, heartbeat both ways |
//! | [`sync`] | the SYNC message |
//! | [`emcy`] | emergency messages, error codes, error register |
//! | [`sdo`] | service data: client and server |
//! | [`lss`] | node identifiers for devices that have none |
//! | [`pdo`] | process data: mapping, parameters, latching, sending |
//! | [`cia402`] | power state machine, modes, option codes |
//! | [`objects`] | indices and the object table of the drive |
//! | [`axis`] | the process data this system exchanges with one axis |
//!
//! Numbers of the profile are those of CiA 301 4.2 and CiA 402 (IEC 61800-7-201), as implemented by
//! public stacks (`CANopenNode`, `python-canopen`) and printed in drive manuals.

pub mod axis;
pub mod cia402;
pub mod emcy;
pub mod fast;
pub mod lss;
pub mod nmt;
pub mod node;
pub mod objects;
pub mod pdo;
pub mod sdo;
pub mod sync;
