//! What is remembered over resets: RAM that nobody clears at the start.

use crate::report;
use board::reset::{Begun, Record, ResetCause, WORDS};
use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use firmware::maintenance::black_box;
use protocol::units::MAX_AXES;

#[unsafe(link_section = ".uninit.kept")]
static KEPT: [AtomicU32; WORDS] = [const { AtomicU32::new(0) }; WORDS];

/// Bytes of a black box of any robot.
const BOX: usize = black_box::bytes(MAX_AXES);

/// Memory that [`black_box`] gives away, once.
struct UnsafeBytes(UnsafeCell<[u8; BOX]>);

// SAFETY: see `black_box`
unsafe impl Sync for UnsafeBytes {}

#[unsafe(link_section = ".uninit.black_box")]
static BLACK_BOX: UnsafeBytes = UnsafeBytes(UnsafeCell::new([0; BOX]));

/// The memory of the black box, as the reset has left it; once.
#[must_use]
pub fn black_box() -> Option<&'static mut [u8]> {
    static TAKEN: AtomicBool = AtomicBool::new(false);
    if TAKEN.swap(true, Ordering::AcqRel) {
        return None;
    }
    // what is there is not what is written above, and the compiler must not believe it is
    let memory = core::hint::black_box(BLACK_BOX.0.get());
    // SAFETY: nobody else has seen `TAKEN` change; any bytes are bytes
    Some(unsafe { &mut *memory })
}

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
