//! The user's programs that are linked into the image of every board: the one line to be changed for one's own.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(not(feature = "mcu-generator"))]
pub use board::boot::NothingLinked as Linked;
#[cfg(feature = "mcu-generator")]
pub use mcu_generator::Linked;
