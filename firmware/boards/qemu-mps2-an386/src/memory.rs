//! Whether memory is copied and cleared as it should be, by the functions of `board_cortex_m` that compilers call: every
//! length up to three turns of their loops, from and to every alignment, and not a byte beside it.
//!
//! The emulator's exit code tells; `cargo xtask hil-qemu` asks for it.
#![no_std]
#![no_main]
#![deny(clippy::undocumented_unsafe_blocks, missing_docs)]

// the functions, and the panic handler
use board_cortex_m as _;
use core::ptr::{read_volatile, write_volatile};
use cortex_m_rt::entry;
use cortex_m_semihosting::debug;

/// The longest that is tried.
const LONGEST: usize = 100;
/// Places in a doubleword.
const PLACES: usize = 8;
/// Room for both, and for what must not be touched behind it.
const ROOM: usize = LONGEST + 3 * PLACES;
/// What has not been touched.
const UNTOUCHED: u8 = 0xA5;

/// Bytes at the beginning of a doubleword.
#[repr(C, align(8))]
struct Bytes([u8; ROOM]);

unsafe extern "C" {
    fn memcpy(to: *mut u8, from: *const u8, bytes: usize) -> *mut u8;
    fn __aeabi_memcpy(to: *mut u8, from: *const u8, bytes: usize);
    fn __aeabi_memclr(to: *mut u8, bytes: usize);
}

/// Byte `k` of what is copied.
const fn pattern(k: usize) -> u8 {
    (k.wrapping_mul(37) ^ k >> 3) as u8 | 1
}

/// One by one, and not by a function that the compiler thinks of.
fn fill(bytes: &mut Bytes, with: impl Fn(usize) -> u8) {
    for (k, byte) in bytes.0.iter_mut().enumerate() {
        // SAFETY: a reference is valid
        unsafe { write_volatile(byte, with(k)) }
    }
}

fn holds(bytes: &Bytes, expected: impl Fn(usize) -> u8) -> bool {
    // SAFETY: a reference is valid
    let read = |byte| unsafe { read_volatile(byte) };
    let mut bytes = bytes.0.iter().enumerate();
    bytes.all(|(k, byte)| read(byte) == expected(k))
}

/// Is every byte of `to` right after `bytes` of them at `place` were made, of which the k-th is `made(k)`?
fn only(to: &Bytes, place: usize, bytes: usize, made: impl Fn(usize) -> u8) -> bool {
    holds(to, |k| match k.checked_sub(place) {
        Some(k) if k < bytes => made(k),
        _ => UNTOUCHED,
    })
}

fn is_right() -> bool {
    let (mut from, mut to) = (Bytes([0; ROOM]), Bytes([0; ROOM]));
    fill(&mut from, pattern);
    for bytes in 0..=LONGEST {
        for place in 0..PLACES {
            fill(&mut to, |_| UNTOUCHED);
            // SAFETY: there is room for as many behind it
            unsafe { __aeabi_memclr(to.0.as_mut_ptr().add(place), bytes) }
            if !only(&to, place, bytes, |_| 0) {
                return false;
            }
            for origin in 0..PLACES {
                let copied = |k: usize| pattern(k.wrapping_add(origin));
                fill(&mut to, |_| UNTOUCHED);
                let at = to.0.as_mut_ptr().wrapping_add(place);
                // SAFETY: there are, and there is room for, as many behind them
                let returned = unsafe { memcpy(at, from.0.as_ptr().add(origin), bytes) };
                if returned != at || !only(&to, place, bytes, copied) {
                    return false;
                }
                fill(&mut to, |_| UNTOUCHED);
                // SAFETY: as above
                unsafe { __aeabi_memcpy(at, from.0.as_ptr().add(origin), bytes) }
                if !only(&to, place, bytes, copied) {
                    return false;
                }
            }
        }
    }
    holds(&from, pattern)
}

#[entry]
fn main() -> ! {
    debug::exit(if is_right() {
        debug::EXIT_SUCCESS
    } else {
        debug::EXIT_FAILURE
    });
    loop {
        core::hint::spin_loop();
    }
}
