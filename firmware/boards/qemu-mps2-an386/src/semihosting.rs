//! Files of the host, by semihosting: a breakpoint that the emulator understands.

use core::ffi::CStr;
use cortex_m_semihosting::{nr, syscall};

/// An open file of the host.
#[derive(Clone, Copy)]
pub struct File(usize);

/// The console's name.
const CONSOLE: &CStr = c":tt";

impl File {
    /// Open a file to read it (`nr::open::R_BINARY`) or to write it (`nr::open::RW_BINARY`).
    pub fn open(path: &CStr, mode: usize) -> Option<Self> {
        // SAFETY: the arguments SYS_OPEN asks for: name, mode, length of the name without its zero
        let handle = unsafe { syscall!(OPEN, path.as_ptr(), mode, path.count_bytes()) };
        (handle != usize::MAX).then_some(Self(handle))
    }

    /// The standard output of the emulator.
    pub fn console() -> Option<Self> {
        Self::open(CONSOLE, nr::open::W_TRUNC)
    }

    /// Fill the buffer, waiting as long as it takes; `false` at the end of the file.
    pub fn read(self, buffer: &mut [u8]) -> bool {
        let mut at = 0_usize;
        // each turn reads a byte at least
        for _ in 0..buffer.len() {
            let Some(rest) = buffer.get_mut(at..) else {
                return false;
            };
            if rest.is_empty() {
                break;
            }
            // SAFETY: the arguments SYS_READ asks for; the buffer is ours
            let left = unsafe { syscall!(READ, self.0, rest.as_mut_ptr(), rest.len()) };
            if left >= rest.len() {
                return false;
            }
            at = at.wrapping_add(rest.len().wrapping_sub(left));
        }
        true
    }

    /// Write all of it; `false` if the host did not take it.
    pub fn write(self, bytes: &[u8]) -> bool {
        // SAFETY: the arguments SYS_WRITE asks for
        let left = unsafe { syscall!(WRITE, self.0, bytes.as_ptr(), bytes.len()) };
        left == 0
    }
}
