//! Two functions that do nothing: a counter of instructions, outside, knows by them where a step of
//! the node begins and ends.

/// A step begins.
#[inline(never)]
#[unsafe(no_mangle)]
pub extern "C" fn mrroc_step_begins() {
    nothing();
}

/// A step has ended.
#[inline(never)]
#[unsafe(no_mangle)]
pub extern "C" fn mrroc_step_ends() {
    nothing();
}

fn nothing() {
    // SAFETY: no instruction at all; memory counts as touched, so that nothing moves across a mark
    unsafe { core::arch::asm!("", options(nostack, preserves_flags)) }
}
