//! Messages as bytes: postcard, self-delimiting, at most [`Payload::MAX`] bytes.
//!
//! postcard writes integers above 8 bits as varints (7 bits a byte, least significant first,
//! signed ones zig-zag), floats little endian as they are, enum variants as a varint, a vector as
//! its length and its items, an option as 0 or 1 and the value.
//!
//! ```
//! use protocol::codec::{decode, encode};
//! use protocol::message::{StopAll, StopKind};
//! let mut buffer = [0; 8];
//! let bytes = encode(&StopAll { kind: StopKind::Quick }, &mut buffer).unwrap();
//! assert_eq!(bytes, [1]);
//! assert_eq!(decode(bytes), Ok(StopAll { kind: StopKind::Quick }));
//! ```

use crate::maintenance::{
    IMAGE_CHUNK, MAX_TARGET, MaintenanceReply, MaintenanceRequest, SAMPLE_BATCH,
};
use crate::message::{
    Command, DemandTrace, Event, Feedback, MAX_NAME, PATH_BATCH, Reply, Request, StopAll, TimeSync,
};
use crate::transfer::{MAX_PADDING, MAX_TRANSFER};
use crate::units::MAX_AXES;
use serde::{Serialize, de::DeserializeOwned};

/// A message of our own on the MP wire.
pub trait Payload: Serialize + DeserializeOwned {
    /// As in `docs/wire.md`.
    const NAME: &'static str;
    /// The longest encoding, bytes.
    const MAX: usize;
}

// The longest encodings of the parts.
const TAG: usize = 1; // fewer than 128 variants
const BYTE: usize = 1;
const U16: usize = 3;
const U32: usize = 5;
const I64: usize = 10;
const U64: usize = 10;
const F32: usize = 4;
const F64: usize = 8;

const fn per_axis(item: usize) -> usize {
    BYTE + MAX_AXES * item
}
const fn greater(a: usize, b: usize) -> usize {
    if a > b { a } else { b }
}

const POSE: usize = 6 * F64;
const KNOT: usize = U64 + TAG + per_axis(F64) + 2 * per_axis(F32);
/// Cause, axis, step, state.
const FAULT: usize = U16 + (TAG + BYTE) + U32 + TAG;
/// `Limit` is the longest: axis, quantity, value, limit.
const REFUSAL: usize = TAG + BYTE + TAG + 2 * F64;
const AXIS_MOVE: usize = per_axis(F64) + BYTE + 2 * per_axis(F32);
const POSE_MOVE: usize = POSE + 2 * TAG + 4 * F32;
const INSTRUCTION: usize = TAG + greater(AXIS_MOVE, POSE_MOVE);
/// An arc is the longest element: a point, a pose, two tolerances.
const PATH: usize = BYTE + PATH_BATCH * (TAG + 3 * F64 + POSE + 2 * F32);
const IDENTITY: usize = (BYTE + MAX_NAME)
    + U64 // unique id
    + 2 // protocol
    + U64 // schema hash
    + U32 // configuration
    + 3 // firmware
    + BYTE // axes
    + U32 // servo step
    + U16; // macrostep
/// Robot, target, version, schema, length, CRC.
const IMAGE_HEADER: usize = (BYTE + MAX_NAME) + (BYTE + MAX_TARGET) + 3 + U64 + 2 * U32;
const NODE_IDENTITY: usize = (BYTE + MAX_NAME)
    + (BYTE + MAX_TARGET)
    + U64 // unique id
    + 2 // protocol
    + U64 // schema hash
    + U32 // configuration
    + 3 // firmware
    + (TAG + TAG + 3 + U32 + TAG); // image
/// Step, state, fault; of an axis: position, error, current.
const SAMPLE: usize = U32 + TAG + U16 + per_axis(U32 + 2 * U16);

impl Payload for Command {
    const NAME: &'static str = "Command";
    const MAX: usize = U32 + U16 + U64 + TAG + KNOT;
}
impl Payload for Feedback {
    const NAME: &'static str = "Feedback";
    const MAX: usize = U32 // step
        + U64 // sampled at
        + TAG // state
        + (TAG + FAULT)
        + BYTE // synchronised
        + 2 * U32 // epoch, instruction
        + (TAG + REFUSAL)
        + U32 // horizon
        + 2 * per_axis(I64)
        + per_axis(U16)
        + per_axis(U32)
        + 2 * U32 // violations, lost
        + F32 // acceleration step
        + (TAG + 3 * F32); // force
}
impl Payload for DemandTrace {
    const NAME: &'static str = "DemandTrace";
    const MAX: usize = U32 + per_axis(I64);
}
impl Payload for Event {
    const NAME: &'static str = "Event";
    const MAX: usize = TAG + greater(IDENTITY, FAULT);
}
impl Payload for StopAll {
    const NAME: &'static str = "StopAll";
    const MAX: usize = TAG;
}
impl Payload for TimeSync {
    const NAME: &'static str = "TimeSync";
    const MAX: usize = BYTE + U64;
}
impl Payload for Request {
    const NAME: &'static str = "Request";
    const MAX: usize = TAG + U32 + greater(U32 + U64 + INSTRUCTION, U32 + PATH);
}
impl Payload for Reply {
    const NAME: &'static str = "Reply";
    const MAX: usize = TAG + greater(IDENTITY, REFUSAL);
}
impl Payload for MaintenanceRequest {
    const NAME: &'static str = "MaintenanceRequest";
    const MAX: usize = TAG + U32 + greater(IMAGE_HEADER, U32 + U32 + 2 * BYTE + IMAGE_CHUNK);
}
impl Payload for MaintenanceReply {
    const NAME: &'static str = "MaintenanceReply";
    const MAX: usize = TAG + greater(NODE_IDENTITY, U32 + U16 + BYTE + SAMPLE_BATCH * SAMPLE);
}

/// The longest message, bytes.
pub const MAX_MESSAGE: usize = {
    let mut rest: &[usize] = &[
        Command::MAX,
        Feedback::MAX,
        DemandTrace::MAX,
        Event::MAX,
        StopAll::MAX,
        TimeSync::MAX,
        Request::MAX,
        Reply::MAX,
        MaintenanceRequest::MAX,
        MaintenanceReply::MAX,
    ];
    let mut most = 0;
    while let [first, tail @ ..] = rest {
        most = greater(most, *first);
        rest = tail;
    }
    most
};

const _: () = assert!(MAX_MESSAGE + crate::e2e::HEADER + MAX_PADDING <= MAX_TRANSFER);

/// The buffer is shorter than the message's encoding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EncodeError;

impl core::fmt::Display for EncodeError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("the buffer is shorter than the message")
    }
}
impl core::error::Error for EncodeError {}

/// Why bytes are not a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DecodeError {
    /// The bytes end before the message does.
    Truncated,
    /// An unknown variant, too many items, or text that is not UTF-8.
    Invalid,
    /// Bytes follow the message.
    Trailing {
        /// How many.
        bytes: usize,
    },
}

impl core::fmt::Display for DecodeError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Truncated => f.write_str("the bytes end before the message does"),
            Self::Invalid => f.write_str("a value no message has"),
            Self::Trailing { bytes } => write!(f, "{bytes} bytes follow the message"),
        }
    }
}
impl core::error::Error for DecodeError {}

/// Writes a message to the beginning of `buffer`; [`Payload::MAX`] bytes are always enough.
///
/// # Errors
/// When the buffer is too short.
pub fn encode<'a, M: Payload>(message: &M, buffer: &'a mut [u8]) -> Result<&'a [u8], EncodeError> {
    postcard::to_slice(message, buffer)
        .map(|bytes| &*bytes)
        .map_err(|_| EncodeError)
}

/// The message these bytes are, all of them.
///
/// # Errors
/// When the bytes are not exactly one message.
pub fn decode<M: Payload>(bytes: &[u8]) -> Result<M, DecodeError> {
    match take(bytes)? {
        (message, []) => Ok(message),
        (_, rest) => Err(DecodeError::Trailing { bytes: rest.len() }),
    }
}

/// As [`decode`], but allows the zero bytes that CAN FD needs as padding ([`MAX_PADDING`]).
///
/// # Errors
/// When the bytes are not exactly one message and its padding.
pub fn decode_padded<M: Payload>(bytes: &[u8]) -> Result<M, DecodeError> {
    let (message, rest) = take(bytes)?;
    if rest.len() <= MAX_PADDING && rest.iter().all(|byte| *byte == 0) {
        Ok(message)
    } else {
        Err(DecodeError::Trailing { bytes: rest.len() })
    }
}

/// The epoch that a [`Command`] states: the first of its fields.
pub(crate) fn stated_epoch(command: &[u8]) -> Option<u32> {
    let (epoch, _) = postcard::take_from_bytes(command).ok()?;
    Some(epoch)
}

fn take<M: Payload>(bytes: &[u8]) -> Result<(M, &[u8]), DecodeError> {
    postcard::take_from_bytes(bytes).map_err(|error| match error {
        postcard::Error::DeserializeUnexpectedEnd => DecodeError::Truncated,
        _ => DecodeError::Invalid,
    })
}
