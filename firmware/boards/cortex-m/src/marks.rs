//! Two functions that do nothing: a counter of instructions, outside, knows by them where a step of
//! the node begins and ends.

use core::arch::asm;

/// A step begins.
#[inline(never)]
#[unsafe(no_mangle)]
pub extern "C" fn mrroc_step_begins() {
    // SAFETY: no instruction at all, but a comment, that tells this function from the other: else they would
    // become one; memory counts as touched, so that nothing moves across a mark
    unsafe { asm!("@ a step begins", options(nostack, preserves_flags)) }
}

/// A step has ended.
#[inline(never)]
#[unsafe(no_mangle)]
pub extern "C" fn mrroc_step_ends() {
    // SAFETY: as above
    unsafe { asm!("@ a step has ended", options(nostack, preserves_flags)) }
}
