//! RS-274 (G-code), the dialect of `LinuxCNC`, run line by line.
//!
//! | understood | |
//! |---|---|
//! | motion | G0, G1, G2, G3 (centre, radius, turns P, helical), G5, G5.1, G5.2–G5.3, G80, G4 |
//! | modes | G17–G19, G20, G21, G90, G91, G90.1, G91.1, G93, G94, G61, G61.1, G64 P |
//! | neutral | G40, G43, G49, one of G54–G59.3, G97–G99, coolant, T without M6 |
//! | actions | S, M3, M4, M5, M0, M1, T with M6, M2, M30 |
//! | language | comments, block delete, `%`, parameters, expressions, O-words: subroutines, branches, loops |
//!
//! Whatever else a file says is refused with its line and column, and so is a cut from a place that the
//! program has not named in all three axes: a robot has no machine position to begin from.
//!
//! Our own reader, since the one maintained crate, `gcode` 0.7, has words but neither parameters,
//! expressions nor O-words. The text is read again wherever the program goes: memory is that of the text, the
//! parameters and the calls that are not over, however many moves it makes.

mod block;
mod cursor;
mod curve;
mod expression;
mod flow;
mod machine;
#[cfg(test)]
mod test;
mod vars;
#[cfg(test)]
pub(super) use test::golden;

use super::step::Step;
use crate::input::{DataError, Problem};
use block::Block;
use cursor::Cursor;
use flow::{Flow, OLine, Place, Word};
use machine::Machine;
use std::collections::VecDeque;
use std::sync::Arc;
use vars::{ARGUMENTS, Vars};

/// Calls within calls.
const MOST_CALLS: usize = 100;
/// The longest line, bytes.
const LONGEST_LINE: usize = 4096;

/// A program as text, and where its subroutines and loops are.
#[derive(Debug)]
pub struct Gcode {
    text: String,
    flow: Flow,
    unit_m: f64,
    most_blocks: u64,
    block_delete: bool,
}

impl Gcode {
    /// The program of a text, whose unit is `unit_m` metres until it says another. It executes at most
    /// `most_blocks` lines; those that begin with `/` it leaves out if `block_delete`.
    ///
    /// # Errors
    /// O-words that do not fit together, and lines that are too long.
    pub fn new(
        text: String,
        unit_m: f64,
        most_blocks: u64,
        block_delete: bool,
    ) -> Result<Self, DataError> {
        let mut long = None;
        let mut offset = 0;
        let lines = (1..).zip(text.split_inclusive('\n')).map(|(line, text)| {
            let place = Place { offset, line };
            offset += text.len();
            if text.len() > LONGEST_LINE {
                long.get_or_insert(line);
            }
            (place, text)
        });
        let flow = Flow::new(lines.filter(|(_, text)| is_o(text)))?;
        if let Some(line) = long {
            let expected = format!("at most {LONGEST_LINE} bytes");
            let problem = Problem::TooLong;
            return Err(DataError::at(
                (line, 1),
                problem,
                "line too long",
                expected,
                "more",
            ));
        }
        Ok(Self {
            text,
            flow,
            unit_m,
            most_blocks,
            block_delete,
        })
    }

    /// Runs it from the beginning.
    #[must_use]
    pub fn run(self: &Arc<Self>) -> Run {
        Run {
            machine: Machine::new(self.unit_m),
            program: self.clone(),
            place: Place { offset: 0, line: 1 },
            vars: Vars::new(),
            calls: Vec::new(),
            repeats: Vec::new(),
            made: VecDeque::new(),
            executed: 0,
            percents: 0,
            over: false,
        }
    }
}

fn is_o(text: &str) -> bool {
    let first = text.bytes().find(|byte| !byte.is_ascii_whitespace());
    matches!(first, Some(b'o' | b'O'))
}

/// A program that runs: an iterator over its steps, which ends with the first error.
#[derive(Clone, Debug)]
pub struct Run {
    program: Arc<Gcode>,
    machine: Machine,
    /// The next line.
    place: Place,
    vars: Vars,
    /// Where calls come back to, and how many repetitions were open there.
    calls: Vec<(Place, usize)>,
    /// The line of each open repetition, and how often it is still to be done.
    repeats: Vec<(usize, u32)>,
    made: VecDeque<Step>,
    executed: u64,
    /// `%` begins a program, and another ends it.
    percents: u32,
    over: bool,
}

impl Iterator for Run {
    type Item = Result<Step, DataError>;

    fn next(&mut self) -> Option<Self::Item> {
        // each round executes a line, and there is a greatest number of them
        loop {
            if let Some(step) = self.made.pop_front() {
                return Some(Ok(step));
            }
            if self.over {
                return None;
            }
            if let Err(error) = self.line() {
                self.over = true;
                return Some(Err(error));
            }
        }
    }
}

impl Run {
    /// Lines executed so far.
    #[must_use]
    pub const fn executed(&self) -> u64 {
        self.executed
    }

    /// What the latest line said that has no effect here; asking takes it.
    pub fn ignored(&mut self) -> Option<&'static str> {
        self.machine.ignored.take()
    }

    /// Metres in the unit of length that holds, and whether the program said so.
    #[must_use]
    pub const fn unit_m(&self) -> (f64, bool) {
        (self.machine.unit_m, self.machine.unit_said)
    }

    fn end(&mut self) -> Result<(), DataError> {
        self.over = true;
        self.machine.end()
    }

    /// The text of a line, and the place after it.
    fn text(program: &Gcode, place: Place) -> Option<(&str, Place)> {
        let rest = program
            .text
            .get(place.offset..)
            .filter(|rest| !rest.is_empty())?;
        let line = rest.split_inclusive('\n').next()?;
        let after = Place {
            offset: place.offset + line.len(),
            line: place.line.saturating_add(1),
        };
        Some((line, after))
    }

    fn line(&mut self) -> Result<(), DataError> {
        let program = self.program.clone();
        let Some((text, after)) = Self::text(&program, self.place) else {
            return self.end();
        };
        let here = self.place;
        self.place = after;
        self.executed += 1;
        let mut cursor = Cursor::new(text, here.line);
        if self.executed > program.most_blocks {
            let expected = format!("at most {}", program.most_blocks);
            return Err(cursor.error(
                Problem::WrongCount,
                "too many lines executed",
                expected,
                "more",
            ));
        }
        if cursor.take(b'/') && program.block_delete {
            return Ok(());
        }
        match cursor.peek() {
            None => return Ok(()),
            Some(b'%') => {
                self.percents += 1;
                return if self.percents > 1 {
                    self.end()
                } else {
                    Ok(())
                };
            }
            Some(b'o') => {
                // an O-word after a `/` was not looked for
                let Some((index, line)) = program.flow.at(here) else {
                    return Err(cursor.wrong("an O-word", "none in a line that may be left out"));
                };
                cursor.next();
                flow::word(&mut cursor)?;
                return self.go(&program, index, line, &mut cursor);
            }
            Some(_) => {}
        }
        let mut block = Block::parse(&mut cursor, &self.vars)?;
        let made = &mut self.made;
        self.machine
            .run(&mut block, here.line, &mut |step| made.push_back(step))?;
        for (name, value) in block.assigned {
            if !self.vars.set(name, value) {
                let expected = format!("at most {}", vars::MOST_NAMED);
                let cursor = Cursor::new(text, here.line);
                return Err(cursor.error(
                    Problem::WrongCount,
                    "too many parameters",
                    expected,
                    "more",
                ));
            }
        }
        if self.machine.over {
            self.over = true;
        }
        Ok(())
    }

    /// Does what an O-word says.
    fn go(
        &mut self,
        program: &Gcode,
        index: usize,
        line: &OLine,
        cursor: &mut Cursor<'_>,
    ) -> Result<(), DataError> {
        let here = *cursor;
        match line.word {
            Word::Sub | Word::Else => self.after(program, line.end),
            Word::Call => self.call(program, line, cursor)?,
            Word::EndSub | Word::Return => self.back(cursor)?,
            Word::If => self.branch(program, index, cursor)?,
            // the branch before it is over
            Word::ElseIf => {
                cursor.skip_rest();
                self.after(program, line.end);
            }
            Word::EndIf | Word::Do => {}
            Word::While => {
                if !self.truth(cursor)? {
                    self.after(program, line.end);
                }
            }
            Word::EndWhile => self.to(program, line.next),
            Word::DoWhile => {
                if self.truth(cursor)? {
                    self.after(program, line.next);
                }
            }
            Word::Repeat => {
                let times = expression::bracketed(cursor, &self.vars)?;
                let times = expression::whole(libm::floor(times)).unwrap_or(0);
                if times == 0 {
                    self.after(program, line.end);
                } else if self.repeats.len() < MOST_CALLS * 10 {
                    self.repeats.push((index, times - 1));
                } else {
                    return Err(here.wrong("repetitions within repetitions", "at most 1000"));
                }
            }
            Word::EndRepeat => self.again(program, line),
            Word::Break | Word::Continue => self.leave(program, line),
        }
        Self::rest(cursor)
    }

    /// Nothing but comments may follow an O-word.
    fn rest(cursor: &mut Cursor<'_>) -> Result<(), DataError> {
        while cursor.take(b'(') {
            cursor.comment()?;
        }
        match cursor.peek() {
            None | Some(b';') => Ok(()),
            Some(_) => Err(cursor.wrong("after an O-word", "a comment or the end of the line")),
        }
    }

    fn truth(&self, cursor: &mut Cursor<'_>) -> Result<bool, DataError> {
        Ok(expression::bracketed(cursor, &self.vars)?.abs() > 0.0)
    }

    /// Goes on with a line that has an O-word.
    fn to(&mut self, program: &Gcode, index: usize) {
        if let Some(line) = program.flow.get(index) {
            self.place = line.place;
        }
    }

    /// Goes on after it.
    fn after(&mut self, program: &Gcode, index: usize) {
        self.to(program, index);
        if let Some((_, after)) = Self::text(program, self.place) {
            self.place = after;
        }
    }

    /// From `if` to the branch whose condition holds.
    fn branch(
        &mut self,
        program: &Gcode,
        index: usize,
        cursor: &mut Cursor<'_>,
    ) -> Result<(), DataError> {
        if self.truth(cursor)? {
            return Ok(());
        }
        let mut part = index;
        // each part is after the one before
        while let Some(line) = program.flow.get(part) {
            let next = line.next;
            let Some(next_line) = program.flow.get(next).filter(|_| next > part) else {
                break;
            };
            if next_line.word == Word::ElseIf {
                let text = Self::text(program, next_line.place).map_or("", |(text, _)| text);
                let mut there = Cursor::new(text, next_line.place.line);
                there.next();
                flow::word(&mut there)?;
                if !self.truth(&mut there)? {
                    part = next;
                    continue;
                }
                Self::rest(&mut there)?;
            }
            self.after(program, next);
            break;
        }
        Ok(())
    }

    fn call(
        &mut self,
        program: &Gcode,
        line: &OLine,
        cursor: &mut Cursor<'_>,
    ) -> Result<(), DataError> {
        if self.calls.len() >= MOST_CALLS {
            let expected = format!("at most {MOST_CALLS}");
            return Err(cursor.error(Problem::OutOfRange, "calls within calls", expected, "more"));
        }
        let mut arguments = [0.0; ARGUMENTS];
        let mut places = arguments.iter_mut();
        while cursor.peek() == Some(b'[') {
            let here = *cursor;
            let value = expression::bracketed(cursor, &self.vars)?;
            let Some(place) = places.next() else {
                return Err(here.wrong("too many arguments", "at most 30"));
            };
            *place = value;
        }
        self.calls.push((self.place, self.repeats.len()));
        self.vars.enter(arguments);
        self.after(program, line.end);
        Ok(())
    }

    /// A call is over; a value goes to `#<_value>`.
    fn back(&mut self, cursor: &mut Cursor<'_>) -> Result<(), DataError> {
        let value = if cursor.peek() == Some(b'[') {
            Some(expression::bracketed(cursor, &self.vars)?)
        } else {
            None
        };
        let Some((place, repeats)) = self.calls.pop() else {
            return Err(cursor.wrong("the end of a subroutine", "a call before it"));
        };
        self.place = place;
        self.repeats.truncate(repeats);
        self.vars.leave();
        if let Some(value) = value {
            self.vars.set(vars::Name::Word("_value".to_owned()), value);
        }
        Ok(())
    }

    fn again(&mut self, program: &Gcode, line: &OLine) {
        match self.repeats.last_mut() {
            Some((_, times)) if *times > 0 => {
                *times -= 1;
                self.after(program, line.next);
            }
            _ => {
                self.repeats.pop();
            }
        }
    }

    /// `break` and `continue`: `next` is the first line of the loop.
    fn leave(&mut self, program: &Gcode, line: &OLine) {
        let Some(first) = program.flow.get(line.next) else {
            return;
        };
        // repetitions within this loop, begun in this call, are over
        let outside = self.calls.last().map_or(0, |(_, repeats)| *repeats);
        let inside = |index: &usize| (line.next + 1..first.end).contains(index);
        while self.repeats.len() > outside && self.repeats.last().is_some_and(|(k, _)| inside(k)) {
            self.repeats.pop();
        }
        if line.word == Word::Continue {
            // to the line that asks whether to go on
            self.to(
                program,
                if first.word == Word::While {
                    line.next
                } else {
                    first.end
                },
            );
            return;
        }
        if first.word == Word::Repeat {
            self.repeats.pop();
        }
        self.after(program, first.end);
    }
}
