//! The log's way out on a board with a debugger: a ring in RAM that the debugger finds by its name and reads while
//! the processor runs. Nobody waits for it. The layout is SEGGER's RTT, with one channel up, which is called
//! "defmt": so `probe-rs run` decodes it.

use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicU32, Ordering, fence};

/// Bytes of the ring.
const SIZE: u32 = 1024;

/// What the debugger looks for.
#[repr(C)]
struct Control {
    id: [u8; 16],
    up: u32,
    down: u32,
    name: &'static [u8; 6],
    buffer: &'static Buffer,
    size: u32,
    /// Where the processor writes next, and where the debugger reads next.
    write: AtomicU32,
    read: AtomicU32,
    /// 0: what finds no room is left out.
    flags: u32,
}

struct Buffer(UnsafeCell<[u8; SIZE as usize]>);

// SAFETY: written by `write` alone, inside critical sections; the debugger reads it, and only what has been written
unsafe impl Sync for Buffer {}

static BUFFER: Buffer = Buffer(UnsafeCell::new([0; SIZE as usize]));

/// The name by which debuggers find it.
#[unsafe(no_mangle)]
static _SEGGER_RTT: Control = Control {
    id: *b"SEGGER RTT\0\0\0\0\0\0",
    up: 1,
    down: 0,
    name: b"defmt\0",
    buffer: &BUFFER,
    size: SIZE,
    write: AtomicU32::new(0),
    read: AtomicU32::new(0),
    flags: 0,
};

/// For the debugger: all of it, or as much as there is room for.
pub fn write(bytes: &[u8]) {
    let Control {
        write,
        read,
        buffer,
        ..
    } = &_SEGGER_RTT;
    critical_section::with(|_| {
        let mut at = write.load(Ordering::Relaxed) % SIZE;
        for byte in bytes {
            let next = at.wrapping_add(1) % SIZE;
            if next == read.load(Ordering::Relaxed) {
                break;
            }
            // SAFETY: inside the buffer, in a place that the debugger has read already
            unsafe {
                let place = buffer.0.get().cast::<u8>().add(at as usize);
                place.write_volatile(*byte);
            }
            at = next;
        }
        // the bytes are there before they are counted
        fence(Ordering::SeqCst);
        write.store(at, Ordering::Relaxed);
    });
}
