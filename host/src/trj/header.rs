//! The keywords and the count before the nodes.

use super::{Reference, Row, Space, Token, TrjError, error_at};
use crate::input::Problem;

/// Reads word after word, as the original does, however they are spread over lines.
pub(super) struct Header<'a, 'r> {
    rows: &'r [Row<'a>],
    /// The row of the next word, and the word in it.
    row: usize,
    word: usize,
    end: u32,
}

impl<'a, 'r> Header<'a, 'r> {
    pub(super) fn new(rows: &'r [Row<'a>], end: u32) -> Self {
        Self {
            rows,
            row: 0,
            word: 0,
            end,
        }
    }

    fn peek(&self) -> Option<Token<'a>> {
        self.rows.get(self.row)?.tokens.get(self.word).copied()
    }

    fn advance(&mut self) {
        self.word += 1;
        if self
            .rows
            .get(self.row)
            .is_some_and(|row| self.word >= row.tokens.len())
        {
            self.row += 1;
            self.word = 0;
        }
    }

    fn next(&mut self, what: &str, expected: &str) -> Result<Token<'a>, TrjError> {
        let token = self.peek().ok_or_else(|| {
            error_at(self.end, 1, Problem::Missing, what, expected, "end of file")
        })?;
        self.advance();
        Ok(token)
    }

    pub(super) fn space(&mut self) -> Result<Space, TrjError> {
        const EXPECTED: &str = "MOTOR, JOINT, XYZ_ANGLE_AXIS or XYZ_EULER_ZYZ";
        let token = self.next("no pose specification", EXPECTED)?;
        Space::ALL
            .into_iter()
            .find(|space| space.name() == token.text)
            .ok_or_else(|| {
                token.error(
                    Problem::UnknownName,
                    "unknown pose specification".into(),
                    EXPECTED,
                )
            })
    }

    pub(super) fn count(&mut self) -> Result<usize, TrjError> {
        const EXPECTED: &str = "a whole number from 1";
        let token = self.next("no number of nodes", EXPECTED)?;
        match token.text.parse::<usize>() {
            Ok(count) if count > 0 => Ok(count),
            Ok(_) => Err(token.error(Problem::OutOfRange, "no nodes declared".into(), EXPECTED)),
            Err(_) => Err(token.error(
                Problem::WrongType,
                "the number of nodes is not one".into(),
                EXPECTED,
            )),
        }
    }

    pub(super) fn reference(&mut self) -> Result<Reference, TrjError> {
        let Some(token) = self.peek() else {
            return Ok(Reference::Absolute);
        };
        let reference = match token.text {
            "ABSOLUTE" => Reference::Absolute,
            "RELATIVE" => Reference::Relative,
            // numbers, and NaN and the infinities, belong to the nodes
            text if text.parse::<f64>().is_ok() => return Ok(Reference::Absolute),
            _ => {
                return Err(token.error(
                    Problem::UnknownName,
                    "unknown word after the number of nodes".into(),
                    "ABSOLUTE, RELATIVE or the velocities of node 1",
                ));
            }
        };
        self.advance();
        Ok(reference)
    }

    /// The rows after the header, which must end its line.
    pub(super) fn body(self) -> Result<&'r [Row<'a>], TrjError> {
        if self.word > 0
            && let Some(token) = self.peek()
        {
            return Err(token.error(
                Problem::Trailing,
                "more words on the last line of the header".into(),
                "the end of the line",
            ));
        }
        Ok(self.rows.get(self.row..).unwrap_or_default())
    }
}
