//! defmt frames in a ring: whoever logs never waits, whoever has time takes them out. A frame that
//! finds no room is left out as a whole and counted.

use core::cell::UnsafeCell;
use critical_section::RestoreState;

/// Bytes of the ring: about 60 lines.
const CAPACITY: usize = 1024;

struct Ring {
    bytes: [u8; CAPACITY],
    /// Where the next byte is taken out.
    first: usize,
    /// Bytes of whole frames.
    whole: usize,
    /// Bytes of the frame under way, behind them.
    begun: usize,
    /// The frame under way found no room.
    lost: bool,
    losses: u32,
    encoder: defmt::Encoder,
    restore: RestoreState,
}

struct Shared(UnsafeCell<Ring>);

// SAFETY: only touched inside critical sections
unsafe impl Sync for Shared {}

static RING: Shared = Shared(UnsafeCell::new(Ring {
    bytes: [0; CAPACITY],
    first: 0,
    whole: 0,
    begun: 0,
    lost: false,
    losses: 0,
    encoder: defmt::Encoder::new(),
    restore: RestoreState::invalid(),
}));

impl Ring {
    fn push(&mut self, bytes: &[u8]) {
        for byte in bytes {
            let used = self.whole.wrapping_add(self.begun);
            let at = self.first.wrapping_add(used) % CAPACITY;
            match self.bytes.get_mut(at) {
                Some(place) if used < CAPACITY => {
                    *place = *byte;
                    self.begun = self.begun.wrapping_add(1);
                }
                _ => self.lost = true,
            }
        }
    }

    fn end(&mut self) {
        if self.lost {
            self.losses = self.losses.saturating_add(1);
        } else {
            self.whole = self.whole.wrapping_add(self.begun);
        }
        self.begun = 0;
        self.lost = false;
    }

    fn pull(&mut self, out: &mut [u8]) -> usize {
        let mut taken = 0_usize;
        for (to, _) in out.iter_mut().zip(0..self.whole) {
            let Some(byte) = self.bytes.get(self.first) else {
                break;
            };
            *to = *byte;
            self.first = self.first.wrapping_add(1) % CAPACITY;
            taken = taken.wrapping_add(1);
        }
        self.whole = self.whole.saturating_sub(taken);
        taken
    }
}

/// The oldest bytes of whole frames, as many as there are and fit; how many.
#[must_use]
pub fn take(out: &mut [u8]) -> usize {
    // SAFETY: inside a critical section, and no reference leaves it
    critical_section::with(|_| unsafe { (*RING.0.get()).pull(out) })
}

/// Frames left out so far.
#[must_use]
pub fn losses() -> u32 {
    // SAFETY: inside a critical section
    critical_section::with(|_| unsafe { (*RING.0.get()).losses })
}

#[defmt::global_logger]
struct Logger;

// SAFETY: a critical section lasts from `acquire` to `release`, so nobody logs in between; frames are
// encoded as defmt demands
unsafe impl defmt::Logger for Logger {
    fn acquire() {
        // SAFETY: given back in `release`; the ring is touched only after it
        unsafe {
            let restore = critical_section::acquire();
            let ring = &mut *RING.0.get();
            ring.restore = restore;
            let Ring { encoder, .. } = ring;
            // the encoder borrows itself and the ring: it is taken out meanwhile
            let mut encoder = core::mem::replace(encoder, defmt::Encoder::new());
            encoder.start_frame(|bytes| ring.push(bytes));
            ring.encoder = encoder;
        }
    }

    unsafe fn flush() {}

    unsafe fn release() {
        // SAFETY: what `acquire` acquired
        unsafe {
            let ring = &mut *RING.0.get();
            let mut encoder = core::mem::replace(&mut ring.encoder, defmt::Encoder::new());
            encoder.end_frame(|bytes| ring.push(bytes));
            ring.encoder = encoder;
            ring.end();
            critical_section::release(ring.restore);
        }
    }

    unsafe fn write(bytes: &[u8]) {
        // SAFETY: between `acquire` and `release`
        unsafe {
            let ring = &mut *RING.0.get();
            let mut encoder = core::mem::replace(&mut ring.encoder, defmt::Encoder::new());
            encoder.write(bytes, |bytes| ring.push(bytes));
            ring.encoder = encoder;
        }
    }
}
