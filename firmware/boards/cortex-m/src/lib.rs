//! What every Cortex-M board has in common.
//!
//! | module | one line |
//! |---|---|
//! | [`place`] | the memory of the node, made once |
//! | [`log`] | defmt frames in a ring, taken out by whoever has time |
//! | [`report`] | what a board says of itself |
//! | [`rtt`] | the log's way out through a debugger |
//! | [`stack`] | how much of the painted stack was used; a stack of its own for interrupts |
//! | [`marks`] | where a step and the ECP's work begin and end, for a counter of instructions |
//! | [`window`] | registers as numbered words |
//! | `copy` | memory copied and cleared |
//! | [`kept`] | what is remembered over resets |
//!
//! The panic handler is here too: it calls a symbol that nobody defines, so an image from which a
//! panic can be reached does not link.
#![no_std]
#![deny(clippy::undocumented_unsafe_blocks, missing_docs)]

mod copy;
pub mod kept;
pub mod log;
pub mod marks;
pub mod place;
pub mod report;
pub mod rtt;
pub mod stack;
pub mod window;

#[cfg(not(feature = "panics"))]
unsafe extern "C" {
    /// Nobody defines it.
    fn mrroc_a_panic_is_reachable() -> !;
}

#[cfg(not(feature = "panics"))]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    // SAFETY: no image that calls it can be linked, so it is never called
    unsafe { mrroc_a_panic_is_reachable() }
}

#[cfg(feature = "panics")]
#[panic_handler]
fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
    // whoever asks where it came from, the compiler too, finds it here
    let place = info.location().map(|at| (at.file().as_ptr(), at.line()));
    core::hint::black_box(place);
    loop {
        core::hint::spin_loop();
    }
}
