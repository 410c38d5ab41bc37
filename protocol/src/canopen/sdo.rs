//! Service data: reads and writes of single objects, expedited (up to 4 bytes), segmented or in blocks.
//!
//! ```text
//! client                          server
//!   download initiate ──▶                  expedited: one exchange
//!                     ◀── answer
//!   segment (toggle)  ──▶                  segmented: 7 bytes each,
//!                     ◀── answer           toggle 0, 1, 0, … until the last
//! ```
//! Either side ends a transfer with an [`Abort`]; a lost or doubled frame ends in success or in one, never in
//! waiting. The server also transfers in blocks ([`MAX_BLOCK`]). A node's drives need none, so the client of
//! blocks is a type of its own, [`BlockClient`]: who does not use it does not pay for it.
//!
//! Why not a crate: canopen-rs 0.6 (`no_std`, without unsafe) has block transfer as codecs only, indexes
//! slices, and brings a second version of `heapless`; the node's `#![deny]` of panics would end at its door.
//! LSS and EDS are small once the object table exists. Strangers prove both: `tests/strangers`.

mod abort;
mod block;
mod block_client;
mod client;
mod server;

pub use abort::Abort;
pub use block::{MAX_BLOCK, RETRIES};
pub use block_client::BlockClient;
pub use client::{Client, ClientError, Outcome, Progress};
pub use server::Server;

use crate::time::Micros;

/// The longest object one transfer moves, in bytes, unless client and server are made for longer ones.
pub const CAPACITY: usize = 256;

/// The SDO time-out on both sides unless told otherwise.
///
/// Drives that store parameters answer after tens of milliseconds; 250 ms leaves room for them and
/// is short against a person waiting.
pub const DEFAULT_TIMEOUT: Micros = Micros::from_millis(250);

/// An object: index and sub-index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Address {
    /// The index.
    pub index: u16,
    /// The sub-index.
    pub sub: u8,
}

impl Address {
    /// The object `index`, sub-index `sub`.
    #[must_use]
    pub const fn new(index: u16, sub: u8) -> Self {
        Self { index, sub }
    }

    const fn in_frame(frame: [u8; 8]) -> Self {
        let [_, low, high, sub, ..] = frame;
        Self {
            index: u16::from_le_bytes([low, high]),
            sub,
        }
    }
}

/// The object dictionary as an SDO server sees it.
pub trait ObjectAccess {
    /// Length of the object's value in bytes.
    ///
    /// # Errors
    /// The abort code the client is to get.
    fn len(&self, address: Address) -> Result<usize, Abort>;

    /// Copies the object's value into `into` and tells how many bytes it has.
    ///
    /// # Errors
    /// The abort code the client is to get.
    fn read(&self, address: Address, into: &mut [u8]) -> Result<usize, Abort>;

    /// Replaces the object's value by `data`, little-endian.
    ///
    /// # Errors
    /// The abort code the client is to get; nothing was changed then.
    fn write(&mut self, address: Address, data: &[u8]) -> Result<(), Abort>;
}

/// The 8 bytes `head, index, sub, rest`.
fn with_address(head: u8, at: Address, rest: [u8; 4]) -> [u8; 8] {
    let [low, high] = at.index.to_le_bytes();
    let [a, b, c, d] = rest;
    [head, low, high, at.sub, a, b, c, d]
}

/// The 8 bytes of an abort.
fn abort_bytes(at: Address, abort: Abort) -> [u8; 8] {
    with_address(ABORT, at, abort.code().to_le_bytes())
}

/// The last four bytes.
const fn tail(frame: [u8; 8]) -> [u8; 4] {
    let [_, _, _, _, a, b, c, d] = frame;
    [a, b, c, d]
}

/// The last seven bytes.
const fn segment_tail(frame: [u8; 8]) -> [u8; 7] {
    let [_, a, b, c, d, e, f, g] = frame;
    [a, b, c, d, e, f, g]
}

/// A segment: head with the count of unused bytes in bits 1–3 and the last-flag in bit 0.
fn segment(specifier: u8, toggle: bool, chunk: &[u8], last: bool) -> [u8; 8] {
    let mut bytes = [0; 8];
    for (to, from) in bytes.iter_mut().skip(1).zip(chunk) {
        *to = *from;
    }
    let unused = 7_u8.saturating_sub(u8::try_from(chunk.len()).unwrap_or(7));
    if let Some(head) = bytes.first_mut() {
        *head = specifier | u8::from(toggle) << 4 | unused << 1 | u8::from(last);
    }
    bytes
}

const ABORT: u8 = 0x80;
/// Client command specifiers (bits 5–7).
mod ccs {
    pub(super) const DOWNLOAD_SEGMENT: u8 = 0;
    pub(super) const DOWNLOAD: u8 = 1;
    pub(super) const UPLOAD: u8 = 2;
    pub(super) const UPLOAD_SEGMENT: u8 = 3;
    pub(super) const ABORT: u8 = 4;
}
/// Server command specifiers (bits 5–7).
mod scs {
    pub(super) const UPLOAD_SEGMENT: u8 = 0;
    pub(super) const DOWNLOAD_SEGMENT: u8 = 1;
    pub(super) const UPLOAD: u8 = 2;
    pub(super) const DOWNLOAD: u8 = 3;
    pub(super) const ABORT: u8 = 4;
}

#[cfg(test)]
mod tests;
