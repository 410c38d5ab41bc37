//! Functions that do nothing: a counter of instructions, outside, knows by them where a step of the node begins and
//! ends, where the ECP's work does, and where an interrupt preempts it.

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

/// The ECP's work begins.
#[inline(never)]
#[unsafe(no_mangle)]
pub extern "C" fn mrroc_work_begins() {
    // SAFETY: as above
    unsafe { asm!("@ work begins", options(nostack, preserves_flags)) }
}

/// The ECP's work has ended.
#[inline(never)]
#[unsafe(no_mangle)]
pub extern "C" fn mrroc_work_ends() {
    // SAFETY: as above
    unsafe { asm!("@ work has ended", options(nostack, preserves_flags)) }
}

/// The servo tick preempts what there was.
#[inline(never)]
#[unsafe(no_mangle)]
pub extern "C" fn mrroc_tick_begins() {
    // SAFETY: as above
    unsafe { asm!("@ a tick begins", options(nostack, preserves_flags)) }
}

/// It goes on.
#[inline(never)]
#[unsafe(no_mangle)]
pub extern "C" fn mrroc_tick_ends() {
    // SAFETY: as above
    unsafe { asm!("@ a tick has ended", options(nostack, preserves_flags)) }
}
