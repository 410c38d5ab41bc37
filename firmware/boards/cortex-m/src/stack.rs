//! How much of the stack was used: `cortex-m-rt` paints it before the image starts, and what has
//! been used is what is no longer of that colour. A board may [divide] it: interrupts have the upper end of it,
//! and what they preempt the rest.

use core::arch::asm;

unsafe extern "C" {
    static _stack_start: u32;
    static _stack_end: u32;
}

/// The colour of `cortex-m-rt`'s feature `paint-stack`.
const COLOUR: u32 = 0xCCCC_CCCC;
/// Bytes of a divided stack that are left to interrupts, and to what ran before it was divided.
const INTERRUPTS: usize = 16 * 1024;

/// Lowest address of the stack, and the one above it.
fn ends() -> (usize, usize) {
    (
        &raw const _stack_end as usize,
        &raw const _stack_start as usize,
    )
}

/// Where a divided stack is divided.
fn middle() -> usize {
    ends().1.wrapping_sub(INTERRUPTS)
}

/// Bytes ever used of what is between two addresses.
fn used_between(bottom: usize, top: usize) -> u32 {
    let mut at = bottom;
    // bounded by the size of the stack
    while at < top {
        // SAFETY: aligned words of this image's own stack; volatile, since others write there
        if unsafe { (at as *const u32).read_volatile() } != COLOUR {
            break;
        }
        at = at.wrapping_add(4);
    }
    top.wrapping_sub(at) as u32
}

/// Paint what is between two addresses and below the caller.
fn paint_between(bottom: usize, top: usize) {
    let mut at = bottom;
    let here = &raw const at as usize;
    // what is next to this function's own frame stays as it is
    let end = here.wrapping_sub(64);
    while at < end && at < top {
        // SAFETY: below every live frame; an interrupt writes there before it reads
        unsafe { (at as *mut u32).write_volatile(COLOUR) };
        at = at.wrapping_add(4);
    }
}

/// Bytes reserved for the stack.
#[must_use]
pub fn reserved() -> u32 {
    let (bottom, top) = ends();
    top.wrapping_sub(bottom) as u32
}

/// The most bytes ever used of it.
#[must_use]
pub fn used() -> u32 {
    let (bottom, top) = ends();
    used_between(bottom, top)
}

/// The most bytes that interrupts ever used of a divided stack.
#[must_use]
pub fn used_by_interrupts() -> u32 {
    used_between(middle(), ends().1)
}

/// The most bytes that the rest ever used of a divided stack.
#[must_use]
pub fn used_by_rest() -> u32 {
    used_between(ends().0, middle())
}

/// Paint what lies below the caller again: the most used from now on shows itself.
pub fn repaint() {
    let (bottom, top) = ends();
    paint_between(bottom, top);
}

/// Goes on with `rest` on a stack of its own; the old one, from its beginning, is left to interrupts, of which none
/// may be enabled yet. Both are painted.
pub fn divide(rest: extern "C" fn() -> !) -> ! {
    repaint();
    let (bottom, top) = ends();
    let middle = middle();
    if middle < bottom {
        // no room to divide: the linker's memory is the board's
        loop {
            core::hint::spin_loop();
        }
    }
    // SAFETY: both stacks are memory of this stack, apart from each other and aligned to 8; nothing of the frames
    // that are given up is used any more, for `rest` does not return and takes nothing from here
    unsafe {
        asm!(
            "msr psp, {middle}",
            "msr control, {own}",
            "isb",
            "msr msp, {top}",
            "bx {rest}",
            middle = in(reg) middle,
            own = in(reg) 2,
            top = in(reg) top,
            rest = in(reg) rest,
            options(noreturn)
        )
    }
}

/// The rest of a divided stack paints that of the interrupts, before there are any.
pub fn paint_interrupts() {
    let mut at = middle();
    let top = ends().1;
    while at < top {
        // SAFETY: nobody uses it: the caller runs on the other stack, and interrupts are not enabled yet
        unsafe { (at as *mut u32).write_volatile(COLOUR) };
        at = at.wrapping_add(4);
    }
}
