//! A line of a program, character by character, and what is wrong in it.
//!
//! Blanks mean nothing outside comments, and capital letters are small ones, as RS-274 has it.

use crate::input::{DataError, Problem, shown};

/// A place in a line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cursor<'a> {
    text: &'a str,
    at: usize,
    /// From 1.
    pub(super) line: u32,
}

impl<'a> Cursor<'a> {
    pub(super) const fn new(text: &'a str, line: u32) -> Self {
        Self { text, at: 0, line }
    }

    /// The next character that is no blank, in small letters.
    pub(super) fn peek(&mut self) -> Option<u8> {
        let rest = self.text.as_bytes().get(self.at..)?;
        let blanks = rest.iter().take_while(|b| b.is_ascii_whitespace()).count();
        self.at += blanks;
        Some(rest.get(blanks)?.to_ascii_lowercase())
    }

    pub(super) fn next(&mut self) -> Option<u8> {
        let next = self.peek()?;
        self.at += 1;
        Some(next)
    }

    /// Takes a character if it is this one.
    pub(super) fn take(&mut self, wanted: u8) -> bool {
        let there = self.peek() == Some(wanted);
        if there {
            self.at += 1;
        }
        there
    }

    /// Takes a word if it is this one, blanks within it or not.
    pub(super) fn take_word(&mut self, word: &str) -> bool {
        let mut ahead = *self;
        let there = word.bytes().all(|byte| ahead.take(byte));
        if there {
            *self = ahead;
        }
        there
    }

    /// The letters that follow, small, without blanks.
    pub(super) fn letters(&mut self) -> String {
        let mut letters = String::new();
        while let Some(letter) = self.peek().filter(u8::is_ascii_alphabetic) {
            letters.push(char::from(letter));
            self.at += 1;
        }
        letters
    }

    /// What stands between `<` and `>`: a name, small, without blanks.
    pub(super) fn name(&mut self) -> Result<String, DataError> {
        let begin = *self;
        if !self.take(b'<') {
            return Err(self.wrong("a name", "`<`"));
        }
        let mut name = String::new();
        while let Some(byte) = self.peek() {
            self.at += 1;
            match byte {
                b'>' if !name.is_empty() => return Ok(name),
                b'_' | b'a'..=b'z' | b'0'..=b'9' if name.len() < LONGEST_NAME => {
                    name.push(char::from(byte));
                }
                _ => break,
            }
        }
        let expected = "letters, digits and `_`, at most 64, between `<` and `>`";
        Err(begin.wrong("a name", expected))
    }

    /// An unsigned number that is no expression.
    pub(super) fn digits(&mut self) -> Result<f64, DataError> {
        let begin = *self;
        // no program needs more digits than this
        let mut digits = heapless::String::<40>::new();
        while let Some(byte) = self.peek().filter(|b| matches!(b, b'0'..=b'9' | b'.')) {
            if digits.push(char::from(byte)).is_err() {
                return Err(begin.wrong("a number", "at most 40 digits"));
            }
            self.at += 1;
        }
        digits
            .parse()
            .map_err(|_| begin.wrong("a value", "a number, `#` or `[`"))
    }

    /// The rest of a comment that began with `(`.
    pub(super) fn comment(&mut self) -> Result<&'a str, DataError> {
        let begin = *self;
        let rest = self.text.get(self.at..).unwrap_or_default();
        match rest.find([')', '(']) {
            Some(end) if rest.as_bytes().get(end) == Some(&b')') => {
                self.at += end + 1;
                Ok(rest.get(..end).unwrap_or_default())
            }
            Some(_) => Err(begin.wrong("a comment", "no `(` in it")),
            None => Err(begin.wrong("a comment", "`)` in the same line")),
        }
    }

    /// The line ends here: a comment that goes to its end.
    pub(super) fn skip_rest(&mut self) {
        self.at = self.text.len();
    }

    /// What is wrong here, and what is found here.
    pub(super) fn wrong(&self, what: &str, expected: &str) -> DataError {
        let mut here = *self;
        let got = match here.peek() {
            Some(_) => shown(here.rest()),
            None => "the end of the line".to_owned(),
        };
        here.error(Problem::Syntax, what, expected, got)
    }

    /// What is wrong here.
    pub(super) fn error(
        &self,
        problem: Problem,
        what: impl Into<String>,
        expected: impl Into<String>,
        got: impl Into<String>,
    ) -> DataError {
        let before = self.text.get(..self.at).unwrap_or(self.text);
        let column = u32::try_from(before.chars().count() + 1).unwrap_or(u32::MAX);
        DataError::at((self.line, column), problem, what, expected, got)
    }

    fn rest(&self) -> &'a str {
        let rest = self.text.get(self.at..).unwrap_or_default();
        let words = rest.trim_end();
        words.split_whitespace().next().unwrap_or(words)
    }
}

/// The longest name.
const LONGEST_NAME: usize = 64;
