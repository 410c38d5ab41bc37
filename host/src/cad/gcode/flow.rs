//! O-words: where subroutines, loops and branches begin and end.

use super::cursor::Cursor;
use crate::input::{DataError, Problem};
use std::collections::BTreeMap;

/// The most lines with an O-word.
pub(super) const MOST_LINES: usize = 100_000;

/// What an O-word says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Word {
    Sub,
    EndSub,
    Return,
    Call,
    If,
    ElseIf,
    Else,
    EndIf,
    While,
    EndWhile,
    Do,
    /// The `while` that ends a `do`.
    DoWhile,
    Repeat,
    EndRepeat,
    Break,
    Continue,
}

const WORDS: [(&str, Word); 15] = [
    ("sub", Word::Sub),
    ("endsub", Word::EndSub),
    ("return", Word::Return),
    ("call", Word::Call),
    ("if", Word::If),
    ("elseif", Word::ElseIf),
    ("else", Word::Else),
    ("endif", Word::EndIf),
    ("while", Word::While),
    ("endwhile", Word::EndWhile),
    ("do", Word::Do),
    ("repeat", Word::Repeat),
    ("endrepeat", Word::EndRepeat),
    ("break", Word::Break),
    ("continue", Word::Continue),
];

/// Where a line is in the text.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Place {
    pub(super) offset: usize,
    pub(super) line: u32,
}

/// A line with an O-word.
#[derive(Clone, Debug)]
pub(super) struct OLine {
    pub(super) place: Place,
    label: String,
    pub(super) word: Word,
    /// Index of the next line of the same construct; of its last line, the first.
    pub(super) next: usize,
    /// Index of its last line; of `call`, that of the subroutine's first.
    pub(super) end: usize,
}

/// All of them, in the order of the text.
#[derive(Clone, Debug, Default)]
pub(super) struct Flow {
    lines: Vec<OLine>,
    /// The first line of every subroutine.
    subs: BTreeMap<String, usize>,
}

/// The label and the word of a line whose `o` was taken.
pub(super) fn word(cursor: &mut Cursor<'_>) -> Result<(String, Word), DataError> {
    let label = if cursor.peek() == Some(b'<') {
        cursor.name()?
    } else {
        let begin = *cursor;
        let number = cursor
            .digits()
            .map_err(|_| begin.wrong("an O-word", "a number or `<`name`>` after the `o`"))?;
        number.to_string()
    };
    let begin = *cursor;
    let said = cursor.letters();
    let found = WORDS.iter().find(|(name, _)| *name == said);
    found.map(|(_, word)| (label, *word)).ok_or_else(|| {
        begin.wrong(
            "an O-word",
            "`sub`, `call`, `if`, `while`, `do`, `repeat` or a part of them",
        )
    })
}

/// Constructs that are open, by the index of the line they began with, and the last line of theirs.
struct Open {
    first: usize,
    last: usize,
}

impl Flow {
    /// Finds the parts of every construct in lines that have an O-word.
    pub(super) fn new<'a>(
        lines: impl Iterator<Item = (Place, &'a str)>,
    ) -> Result<Self, DataError> {
        let mut flow = Self::default();
        let mut open: Vec<Open> = Vec::new();
        for (place, text) in lines {
            let mut cursor = Cursor::new(text, place.line);
            let begin = {
                cursor.peek();
                cursor
            };
            cursor.next();
            let (label, word) = word(&mut cursor)?;
            if flow.lines.len() == MOST_LINES {
                let expected = format!("at most {MOST_LINES}");
                return Err(begin.error(Problem::WrongCount, "too many O-words", expected, "more"));
            }
            flow.lines.push(OLine {
                place,
                label,
                word,
                next: 0,
                end: 0,
            });
            flow.add(&mut open, &begin)?;
        }
        if let Some(line) = open.last().and_then(|open| flow.lines.get(open.first)) {
            return Err(DataError::at(
                (line.place.line, 1),
                Problem::Missing,
                format!("a construct without an end: `o{}`", line.label),
                "its end",
                "the end of the file",
            ));
        }
        flow.bind_calls()?;
        Ok(flow)
    }

    /// The last line that was pushed becomes part of a construct.
    fn add(&mut self, open: &mut Vec<Open>, begin: &Cursor<'_>) -> Result<(), DataError> {
        let index = self.lines.len() - 1;
        let Some(line) = self.lines.get(index) else {
            return Ok(());
        };
        let (label, word) = (line.label.clone(), line.word);
        let top = open.last().and_then(|open| self.lines.get(open.last));
        let of_top = top.filter(|top| top.label == label).map(|top| top.word);
        let wrong = |expected: &str| {
            Err(begin.error(
                Problem::Conflict,
                "an O-word where it does not belong",
                expected,
                format!("`o{label} {}`", name(word)),
            ))
        };
        let (ends, fits) = match word {
            Word::While if of_top == Some(Word::Do) => {
                if let Some(line) = self.lines.get_mut(index) {
                    line.word = Word::DoWhile;
                }
                (true, true)
            }
            Word::Sub if !open.is_empty() => return wrong("a subroutine outside of all others"),
            Word::Sub | Word::If | Word::While | Word::Do | Word::Repeat => {
                if word == Word::Sub && self.subs.insert(label.clone(), index).is_some() {
                    return wrong("a label that no other subroutine has");
                }
                open.push(Open {
                    first: index,
                    last: index,
                });
                return Ok(());
            }
            Word::Call => return Ok(()),
            Word::Return | Word::Break | Word::Continue => {
                let fits = |open: &&Open| {
                    self.lines.get(open.first).is_some_and(|line| {
                        line.label == label
                            && (line.word == Word::Sub) == (word == Word::Return)
                            && line.word != Word::If
                    })
                };
                let Some(of) = open.iter().rev().find(fits) else {
                    return wrong("one inside its subroutine or loop");
                };
                let first = of.first;
                if let Some(line) = self.lines.get_mut(index) {
                    line.next = first;
                }
                return Ok(());
            }
            Word::EndSub => (true, of_top == Some(Word::Sub)),
            Word::ElseIf | Word::Else => (false, matches!(of_top, Some(Word::If | Word::ElseIf))),
            Word::EndIf => (
                true,
                matches!(of_top, Some(Word::If | Word::ElseIf | Word::Else)),
            ),
            Word::EndWhile => (true, of_top == Some(Word::While)),
            Word::EndRepeat => (true, of_top == Some(Word::Repeat)),
            Word::DoWhile => (true, false),
        };
        let Some(top) = open.last_mut().filter(|_| fits) else {
            return wrong("the next part of the construct that is open");
        };
        if let Some(last) = self.lines.get_mut(top.last) {
            last.next = index;
        }
        let first = top.first;
        top.last = index;
        if ends {
            open.pop();
            self.close(first, index);
        }
        Ok(())
    }

    /// Every part of a construct knows its end.
    fn close(&mut self, first: usize, end: usize) {
        let mut part = first;
        // each is after the one before
        while part < end {
            let Some(line) = self.lines.get_mut(part) else {
                break;
            };
            line.end = end;
            part = line.next;
        }
        if let Some(line) = self.lines.get_mut(end) {
            line.next = first;
            line.end = end;
        }
    }

    fn bind_calls(&mut self) -> Result<(), DataError> {
        for line in self.lines.iter_mut().filter(|line| line.word == Word::Call) {
            line.end = *self.subs.get(&line.label).ok_or_else(|| {
                DataError::at(
                    (line.place.line, 1),
                    Problem::Missing,
                    "a call of a subroutine that is not in the file",
                    "one that is",
                    format!("`o{}`", line.label),
                )
            })?;
        }
        Ok(())
    }

    pub(super) fn get(&self, index: usize) -> Option<&OLine> {
        self.lines.get(index)
    }

    /// The line at a place.
    pub(super) fn at(&self, place: Place) -> Option<(usize, &OLine)> {
        let index = self.lines.binary_search_by_key(&place, |line| line.place);
        let index = index.ok()?;
        Some((index, self.lines.get(index)?))
    }
}

pub(super) fn name(word: Word) -> &'static str {
    let found = WORDS.iter().find(|(_, known)| *known == word);
    found.map_or("while", |(name, _)| name)
}
