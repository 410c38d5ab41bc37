//! Paths of the tool: pieces, blends, curves through points, the queue that holds them.

#![expect(
    clippy::disallowed_methods,
    clippy::float_cmp,
    reason = "oracles and bounds; exact where the text says so"
)]

mod blend;
mod gcode;
mod golden;
mod literal;
mod moving_segment;
mod oracle;
mod pieces;
mod queue;
mod support;
