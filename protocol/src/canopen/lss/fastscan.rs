//! Fastscan: finds the device with the least identity among those without node identifier.

use super::{Answer, Identity, MASTER_COB, cs, with_number};
use crate::canopen::node::frame;
use crate::frame::Frame;
use crate::time::Micros;

/// How long the master waits for slaves to answer one question: a few frame times at 10 kbit/s, and what a
/// slow device takes to look.
pub const ANSWER_WINDOW: Micros = Micros::from_millis(20);

/// "Bit" of the first question, which every unconfigured device answers.
pub(super) const START: u8 = 0x80;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Question {
    /// Is anybody there?
    Start,
    /// Is there one with this bit of the part clear (the bits above as found)?
    Bit(u8),
    /// Is the part as found? Then go on to the next.
    Confirm,
}

/// What the scan wants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scan {
    /// Send this.
    Send(Frame),
    /// Wait: for an answer, or for the window to pass.
    Wait,
    /// This device was found; it is in configuration now.
    Found(Identity),
    /// No device without node identifier, or it fell silent.
    Nobody,
}

/// One scan: at most 1 + 4·33 questions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fastscan {
    question: Question,
    part: usize,
    found: [u32; 4],
    /// Until when answers to the question that is out count.
    until: Option<Micros>,
    heard: bool,
    ended: Option<bool>,
}

impl Default for Fastscan {
    fn default() -> Self {
        Self::new()
    }
}

impl Fastscan {
    /// A scan that has not begun.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            question: Question::Start,
            part: 0,
            found: [0; 4],
            until: None,
            heard: false,
            ended: None,
        }
    }

    /// Takes the data of a frame on [`super::SLAVE_COB`].
    pub fn on_answer(&mut self, data: &[u8]) {
        if Answer::decode(data) == Some(Answer::Identified) {
            self.heard = true;
        }
    }

    /// Looks at the clock. Several devices answer at once, so every window is waited for.
    pub fn poll(&mut self, now: Micros) -> Scan {
        if let Some(end) = self.end() {
            return end;
        }
        match self.until {
            Some(until) if now < until => return Scan::Wait,
            Some(_) => self.conclude(),
            None => {}
        }
        if let Some(end) = self.end() {
            return end;
        }
        self.heard = false;
        self.until = Some(now + ANSWER_WINDOW);
        Scan::Send(frame(MASTER_COB, self.bytes()))
    }

    fn end(&self) -> Option<Scan> {
        let found = Scan::Found(Identity::from_parts(self.found));
        self.ended
            .map(|well| if well { found } else { Scan::Nobody })
    }

    fn bytes(&self) -> [u8; 8] {
        let number = self.found.get(self.part).copied().unwrap_or(0);
        let part = u8::try_from(self.part).unwrap_or(3);
        let rest = match self.question {
            Question::Start => [START, 0, 0],
            Question::Bit(bit) => [bit, part, part],
            Question::Confirm => [0, part, part.saturating_add(1) & 3],
        };
        with_number(cs::FASTSCAN, number, rest)
    }

    /// What the silence, or its absence, says.
    fn conclude(&mut self) {
        match self.question {
            Question::Start if self.heard => self.question = Question::Bit(31),
            Question::Start => self.ended = Some(false),
            Question::Bit(bit) => {
                if !self.heard
                    && let Some(number) = self.found.get_mut(self.part)
                {
                    *number |= 1_u32.checked_shl(u32::from(bit)).unwrap_or(0);
                }
                self.question = match bit.checked_sub(1) {
                    Some(next) => Question::Bit(next),
                    None => Question::Confirm,
                };
            }
            Question::Confirm if !self.heard => self.ended = Some(false),
            Question::Confirm if self.part >= 3 => self.ended = Some(true),
            Question::Confirm => {
                self.part = self.part.saturating_add(1);
                self.question = Question::Bit(31);
            }
        }
    }
}
