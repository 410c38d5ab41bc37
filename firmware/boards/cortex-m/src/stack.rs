//! How much of the stack was used: `cortex-m-rt` paints it before the image starts, and what has
//! been used is what is no longer of that colour.

unsafe extern "C" {
    static _stack_start: u32;
    static _stack_end: u32;
}

/// The colour of `cortex-m-rt`'s feature `paint-stack`.
const COLOUR: u32 = 0xCCCC_CCCC;

/// Lowest address of the stack, and the one above it.
fn ends() -> (usize, usize) {
    (
        &raw const _stack_end as usize,
        &raw const _stack_start as usize,
    )
}

/// The lowest address that was ever used.
fn low_water() -> usize {
    let (mut at, top) = ends();
    // bounded by the size of the stack
    while at < top {
        // SAFETY: aligned words of this image's own stack; volatile, since others write there
        if unsafe { (at as *const u32).read_volatile() } != COLOUR {
            break;
        }
        at = at.wrapping_add(4);
    }
    at
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
    ends().1.wrapping_sub(low_water()) as u32
}

/// Paint what lies below the caller again: the most used from now on shows itself.
pub fn repaint() {
    let (mut at, top) = ends();
    let here = &raw const at as usize;
    // what is next to this function's own frame stays as it is
    let end = here.wrapping_sub(64);
    while at < end && at < top {
        // SAFETY: below every live frame; an interrupt writes there before it reads
        unsafe { (at as *mut u32).write_volatile(COLOUR) };
        at = at.wrapping_add(4);
    }
}
