//! The memory of the node.

use board::boot::{BootError, Home};
use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicBool, Ordering};
use firmware::NodeProcess;

/// Memory for one node of at most `BYTES` bytes, aligned to 8; a node that does not fit is not made.
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
    fn keep<T: NodeProcess + Send + 'static>(
        self,
        make: impl FnOnce() -> T,
    ) -> Result<&'static mut (dyn NodeProcess + Send), BootError> {
        // not an error of the build: the compiler looks at every robot, also at those that this image leaves out
        if size_of::<T>() > BYTES || align_of::<T>() > 8 {
            return Err(BootError::Room);
        }
        if self.taken.swap(true, Ordering::AcqRel) {
            return Err(BootError::Occupied);
        }
        // SAFETY: size and alignment are checked above, and nobody else has seen `taken` change
        let place = unsafe { &mut *self.memory.get().cast::<MaybeUninit<T>>() };
        Ok(place.write(make()))
    }
}
