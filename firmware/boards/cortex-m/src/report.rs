//! What a board says once a second, and of its resets.

use crate::stack;
use board::mcan::Counts;
use board::reset::{Begun, Record};
use board::time_base::Beat;

/// After a reset of which something is remembered.
pub fn reset(begun: &Begun) {
    if let Some(Record { state, missing, .. }) = begun.before {
        defmt::info!(
            "reset {=u32}, cause {=u8}, watchdog {=u32}; in state {=u8}, missing {=u8}",
            begun.now.resets,
            begun.now.cause as u8,
            begun.now.watchdog,
            state as u8,
            missing.map_or(u8::MAX, |token| token as u8)
        );
    }
}

/// Whenever one likes: how evenly SYNC was sent, and what was lost.
pub fn counts(beat: &mut Beat, lost: u32, buses: [(Counts, u32); 3]) {
    defmt::info!(
        "SYNC off by {=u32} us at most; stack {=u32} of {=u32} bytes; {=u32} frames without room",
        beat.worst(),
        stack::used(),
        stack::reserved(),
        lost
    );
    for (bus, (counts, unsent)) in [1, 2, 3].into_iter().zip(buses) {
        if counts.overrun != 0 || counts.bus_off != 0 || unsent != 0 {
            defmt::warn!(
                "CAN {=u8}: {=u32} overruns, {=u32} times off, {=u32} unsent",
                bus,
                counts.overrun,
                counts.bus_off,
                unsent
            );
        }
    }
}
