//! The memory of the node.

use board::boot::{BootError, Home};
use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicBool, Ordering};

unsafe extern "C" {
    /// Nobody defines it. What is left out of an image is asked for its size too, but never calls this.
    fn mrroc_the_node_does_not_fit_into_its_place() -> !;
}

/// Memory for one node of at most `BYTES` bytes, aligned to 8; a node that does not fit is an error
/// of the build: of a robot that the image knows, not of one that was left out.
#[repr(C, align(8))]
pub struct Place<const BYTES: usize> {
    memory: UnsafeCell<MaybeUninit<[u8; BYTES]>>,
    taken: AtomicBool,
}

// SAFETY: the memory is given away once, to the one who saw `taken` change
unsafe impl<const BYTES: usize> Sync for Place<BYTES> {}

impl<const BYTES: usize> Place<BYTES> {
    /// Free.
    #[expect(clippy::new_without_default, reason = "a static")]
    pub const fn new() -> Self {
        Self {
            memory: UnsafeCell::new(MaybeUninit::uninit()),
            taken: AtomicBool::new(false),
        }
    }
}

impl<const BYTES: usize> Home for &'static Place<BYTES> {
    fn keep<T: Send + 'static>(
        self,
        make: impl FnOnce() -> T,
    ) -> Result<&'static mut T, BootError> {
        if size_of::<T>() > BYTES || align_of::<T>() > 8 {
            // SAFETY: no image that calls it can be linked, so it is never called
            unsafe { mrroc_the_node_does_not_fit_into_its_place() }
        }
        if self.taken.swap(true, Ordering::AcqRel) {
            return Err(BootError::Occupied);
        }
        // SAFETY: size and alignment are checked above, and nobody else has seen `taken` change
        let place = unsafe { &mut *self.memory.get().cast::<MaybeUninit<T>>() };
        Ok(place.write(make()))
    }
}
