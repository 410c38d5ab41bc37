//! What is remembered over resets: RAM that nobody clears at the start.

use crate::report;
use board::reset::{Begun, Record, ResetCause, WORDS};
use core::sync::atomic::{AtomicU32, Ordering};

#[unsafe(link_section = ".uninit.kept")]
static KEPT: [AtomicU32; WORDS] = [const { AtomicU32::new(0) }; WORDS];

/// After a reset: what is there, which after power came is anything at all; it is counted, kept and logged.
#[must_use]
pub fn begin(cause: ResetCause) -> Begun {
    let found = KEPT.each_ref().map(|word| word.load(Ordering::Relaxed));
    let begun = Record::begin(&found, cause);
    write(begun.now.write());
    report::reset(&begun);
    begun
}

/// To be remembered.
pub fn write(words: [u32; WORDS]) {
    for (to, from) in KEPT.iter().zip(words) {
        to.store(from, Ordering::Relaxed);
    }
}
