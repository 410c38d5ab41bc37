//! The node in real time: frames come and go by a mailbox in memory that the host shares.

use board::boot::Home;
use board::channel::{MAX_FRAMES, Stepped};
use board::mailbox::{self, BYTES, FROM_IMAGE, Memory, TO_IMAGE, Told};
use board::tandem::Halves;
use board_cortex_m::marks::{mrroc_step_begins, mrroc_step_ends};
use core::sync::atomic::{Ordering, fence};
use firmware::{NodeProcess, Received};
use protocol::time::Micros;

/// Where the host's memory is: the machine's PSRAM.
const ADDRESS: usize = 0x2100_0000;

/// The shared memory.
pub struct Shared;

/// Is this within the mailbox?
fn inside(at: u32, bytes: &[u8]) -> Option<usize> {
    let at = at as usize;
    let end = at.checked_add(bytes.len())?;
    (end <= BYTES).then_some(ADDRESS.wrapping_add(at))
}

impl Memory for Shared {
    fn read(&mut self, at: u32, bytes: &mut [u8]) {
        let Some(mut from) = inside(at, bytes) else {
            return;
        };
        for byte in bytes {
            // SAFETY: inside the mailbox, which is RAM of this machine; the host writes there too
            *byte = unsafe { (from as *const u8).read_volatile() };
            from = from.wrapping_add(1);
        }
        fence(Ordering::SeqCst);
    }

    fn write(&mut self, at: u32, bytes: &[u8]) {
        fence(Ordering::SeqCst);
        let Some(mut to) = inside(at, bytes) else {
            return;
        };
        for byte in bytes {
            // SAFETY: inside the mailbox, which is RAM of this machine; the host reads there too
            unsafe { (to as *mut u8).write_volatile(*byte) };
            to = to.wrapping_add(1);
        }
        fence(Ordering::SeqCst);
    }
}

/// The image's side of the mailbox.
pub struct Mailbox {
    memory: Shared,
    lost: u32,
    held: u32,
}

impl Mailbox {
    /// The host says which node this is; waits until it does.
    pub fn boot(home: impl Home) -> Option<(Self, Halves, Micros)> {
        let mut memory = Shared;
        // ended by the host, which ends the emulator if it has nothing to say
        let boot = loop {
            if let Some(boot) = mailbox::offered(&mut memory) {
                break boot;
            }
        };
        let made = boot.node_with::<programs::Linked>(home).ok();
        mailbox::accept(&mut memory, made.is_some());
        let mailbox = Self {
            memory,
            lost: 0,
            held: 0,
        };
        Some((mailbox, made?, boot.now))
    }

    /// Is time held, because the cell is not as far as this tick wants it?
    pub fn holds(&mut self, ticks: u64) -> bool {
        let holds = !mailbox::left(&mut self.memory)
            && mailbox::too_early(&mut self.memory, ticks as u32);
        self.held = self.held.wrapping_add(u32::from(holds));
        holds
    }

    /// Takes what has come, and makes a step of the node if one is due at `now`; what it was due for
    /// counts, not when it is made. `None` when the host has gone.
    pub fn tick(
        &mut self,
        node: &mut (dyn NodeProcess + Send),
        ticks: u64,
        now: Micros,
        received: &mut heapless::Vec<Received, MAX_FRAMES>,
    ) -> Option<Stepped> {
        if mailbox::left(&mut self.memory) {
            return None;
        }
        for _ in 0..MAX_FRAMES {
            if received.is_full() {
                break;
            }
            let Some(frame) = TO_IMAGE.pop(&mut self.memory) else {
                break;
            };
            let _ = received.push(frame);
        }
        let due = node.next_wake();
        if now >= due {
            let Self { memory, lost, .. } = self;
            mrroc_step_begins();
            node.step(due, received, &mut |port, frame| {
                let at = due;
                if !FROM_IMAGE.push(memory, &Received { port, at, frame }) {
                    *lost = lost.saturating_add(1);
                }
            });
            mrroc_step_ends();
            received.clear();
        }
        let told = Told {
            ticks: ticks as u32,
            lost: self.lost,
            held: self.held,
        };
        mailbox::tell(&mut self.memory, told);
        Some(Stepped::of(node, ticks))
    }
}
