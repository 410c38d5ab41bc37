//! The speed along a path keeps every limit at every time, and is nearly the fastest.
#![expect(clippy::cast_precision_loss, reason = "counts of steps and samples")]
#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "small random indices"
)]

mod behaviour;
mod limits;
mod random;
mod refusals;
mod support;
