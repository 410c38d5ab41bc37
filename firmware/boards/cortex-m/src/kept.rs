//! What is remembered over resets: RAM that nobody clears at the start.

use board::reset::WORDS;
use core::sync::atomic::{AtomicU32, Ordering};

#[unsafe(link_section = ".uninit.kept")]
static KEPT: [AtomicU32; WORDS] = [const { AtomicU32::new(0) }; WORDS];

/// What is there: anything at all, after power came.
#[must_use]
pub fn read() -> [u32; WORDS] {
    KEPT.each_ref().map(|word| word.load(Ordering::Relaxed))
}

/// To be remembered.
pub fn write(words: [u32; WORDS]) {
    for (to, from) in KEPT.iter().zip(words) {
        to.store(from, Ordering::Relaxed);
    }
}
