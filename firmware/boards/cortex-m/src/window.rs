//! Registers and other memory that hardware changes, as numbered words.

use board::mcan::Words;

/// Words from an address on.
#[derive(Debug)]
pub struct Window {
    address: usize,
    words: usize,
}

impl Window {
    /// So many words from here on.
    ///
    /// # Safety
    /// They are registers of this processor, or memory that is nothing else's; reading and writing any of them in
    /// any order breaks no promise of safe Rust; and whoever else writes them knows of this.
    #[must_use]
    pub const unsafe fn new(address: usize, words: usize) -> Self {
        Self { address, words }
    }

    /// The address of a word; nothing outside the window.
    fn at(&self, word: usize) -> Option<usize> {
        let inside = word < self.words;
        inside.then(|| self.address.wrapping_add(word.wrapping_mul(4)))
    }
}

impl Words for Window {
    fn read(&self, word: usize) -> u32 {
        // SAFETY: inside the window, of which `new` was promised that it can be read
        self.at(word)
            .map_or(0, |at| unsafe { (at as *const u32).read_volatile() })
    }

    fn write(&mut self, word: usize, value: u32) {
        if let Some(at) = self.at(word) {
            // SAFETY: inside the window, of which `new` was promised that it can be written
            unsafe { (at as *mut u32).write_volatile(value) };
        }
    }
}
