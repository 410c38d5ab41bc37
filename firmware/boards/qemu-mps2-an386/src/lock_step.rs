//! The node in lock step: at its own timer's tick it asks the host for the frames of this step, and
//! time stands still until they are there.

use crate::semihosting::File;
use board::boot::{Boot, Home};
use board::channel::{self, Answering, LENGTH, LONGEST, MAX_FRAMES, Request, Stepped};
use board::tandem::Halves;
use board_cortex_m::marks::{mrroc_step_begins, mrroc_step_ends};
use core::ffi::CStr;
use cortex_m_semihosting::nr;
use firmware::{NodeProcess, Received};

/// From the host.
const TO_IMAGE: &CStr = c"to-image";
/// To the host.
const FROM_IMAGE: &CStr = c"from-image";

/// Both directions of the channel.
pub struct Channel {
    input: File,
    output: File,
    buffer: &'static mut [u8; LONGEST],
}

/// Why it went no further.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    /// The host has no more to ask.
    Done,
    /// The host said something else, or nothing.
    Broken,
}

impl Channel {
    /// Open both files, in the folder in which the emulator runs.
    pub fn open(buffer: &'static mut [u8; LONGEST]) -> Option<Self> {
        Some(Self {
            input: File::open(TO_IMAGE, nr::open::R_BINARY)?,
            output: File::open(FROM_IMAGE, nr::open::RW_BINARY)?,
            buffer,
        })
    }

    fn receive(&mut self) -> Option<Request<'_>> {
        let mut length = [0; LENGTH];
        if !self.input.read(&mut length) {
            return None;
        }
        let body = self.buffer.get_mut(..channel::length(length)?)?;
        if !self.input.read(body) {
            return None;
        }
        channel::read_request(body)
    }

    fn answer(&self, len: Option<usize>) -> Option<()> {
        let bytes = self.buffer.get(..len?)?;
        self.output.write(bytes).then_some(())
    }

    /// The host says which node this is.
    pub fn boot(&mut self, home: impl Home) -> Option<(Halves, Boot)> {
        let Some(Request::Boot(boot)) = self.receive() else {
            return None;
        };
        let made = boot.node_with::<programs::Linked>(home);
        let len = match &made {
            Ok(Halves { node, .. }) => {
                channel::answer_booted(&Stepped::of(&**node, 0), &node.identity(), self.buffer)
            }
            Err(_) => channel::answer_none(self.buffer),
        };
        self.answer(len)?;
        Some((made.ok()?, boot))
    }

    /// One step of the node.
    pub fn step(
        &mut self,
        node: &mut (dyn NodeProcess + Send),
        cycles: u64,
        received: &mut heapless::Vec<Received, MAX_FRAMES>,
    ) -> Result<Stepped, Ended> {
        received.clear();
        let now = match self.receive() {
            Some(Request::Step(now, frames)) => {
                for frame in frames {
                    received.push(frame).map_err(|_| Ended::Broken)?;
                }
                now
            }
            Some(Request::End) => return Err(Ended::Done),
            Some(Request::Boot(_)) | None => return Err(Ended::Broken),
        };
        let mut answering = Answering::new(self.buffer).ok_or(Ended::Broken)?;
        mrroc_step_begins();
        node.step(now, received, &mut |port, frame| {
            answering.sent(port, frame)
        });
        mrroc_step_ends();
        let len = answering.finish();
        let stepped = Stepped::of(node, cycles);
        let len = len.and_then(|len| channel::answer_stepped(&stepped, len, self.buffer));
        self.answer(len).ok_or(Ended::Broken)?;
        Ok(stepped)
    }
}
