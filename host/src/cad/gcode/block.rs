//! A line of words: each letter at most once, `G` and `M` once of each modal group.

use super::cursor::Cursor;
use super::expression::{name, value, whole};
use super::vars::{Name, Vars};
use crate::input::{DataError, Problem};

/// The letters that have a value of their own, in the order of [`Block::values`].
const LETTERS: [u8; 16] = *b"xyzijkrpqfstldeh";

/// The words of a line.
#[derive(Clone, Debug, Default)]
pub(super) struct Block<'a> {
    values: [Option<(f64, Cursor<'a>)>; LETTERS.len()],
    /// Tenths: G5.2 is 52.
    g: heapless::Vec<(u32, Cursor<'a>), MOST_CODES>,
    m: heapless::Vec<(u32, Cursor<'a>), MOST_CODES>,
    /// What is assigned, in the end.
    pub(super) assigned: Vec<(Name, f64)>,
    /// Letters that were used, as bits.
    used: u32,
}

/// The most G or M words in a line: there are not that many groups.
const MOST_CODES: usize = 14;

/// Modal groups of G words that may stand in one line, in tenths.
const G_GROUPS: [&[u32]; 12] = [
    &[0, 10, 20, 30, 50, 51, 52, 53, 800],
    &[170, 180, 190],
    &[900, 910],
    &[901, 911],
    &[930, 940],
    &[200, 210],
    &[400],
    &[430, 490],
    &[540, 550, 560, 570, 580, 590, 591, 592, 593],
    &[610, 611, 640],
    &[980, 990],
    &[40],
];

/// Modal groups of M words.
const M_GROUPS: [&[u32]; 5] = [
    &[0, 10, 20, 300],
    &[30, 40, 50],
    &[60],
    &[70, 80, 90],
    &[480, 490],
];

impl<'a> Block<'a> {
    /// The words from here to the end of the line.
    pub(super) fn parse(cursor: &mut Cursor<'a>, vars: &Vars) -> Result<Self, DataError> {
        let mut block = Self::default();
        let mut first = true;
        while let Some(letter) = cursor.peek() {
            let begin = *cursor;
            cursor.next();
            match letter {
                b';' => cursor.skip_rest(),
                b'(' => {
                    cursor.comment()?;
                    continue;
                }
                b'n' if first => {
                    cursor.digits()?;
                }
                b'#' => {
                    let name = name(cursor, vars)?;
                    if !cursor.take(b'=') {
                        return Err(cursor.wrong("an assignment", "`=`"));
                    }
                    let value = value(cursor, vars)?;
                    block.assigned.push((name, value));
                }
                b'g' | b'm' => block.code(letter, value(cursor, vars)?, begin)?,
                _ => block.word(letter, &begin, cursor, vars)?,
            }
            first = false;
        }
        Ok(block)
    }

    fn word(
        &mut self,
        letter: u8,
        begin: &Cursor<'a>,
        cursor: &mut Cursor<'a>,
        vars: &Vars,
    ) -> Result<(), DataError> {
        let place = LETTERS.iter().position(|known| *known == letter);
        let Some(place) = place.and_then(|k| self.values.get_mut(k)) else {
            let expected = "one of G M X Y Z I J K R P Q F S T L D H N, `#`, or a comment";
            return Err(match letter {
                b'a' | b'b' | b'c' | b'u' | b'v' | b'w' => begin.wrong(
                    "an axis that there is not",
                    "X, Y and Z: the tool keeps its direction",
                ),
                _ => begin.wrong("a word that is not known", expected),
            });
        };
        let value = value(cursor, vars)?;
        if place.replace((value, *begin)).is_some() {
            return Err(begin.wrong(
                "a letter for the second time",
                "each at most once in a line",
            ));
        }
        Ok(())
    }

    fn code(&mut self, letter: u8, value: f64, begin: Cursor<'a>) -> Result<(), DataError> {
        let (codes, groups): (_, &[&[u32]]) = if letter == b'g' {
            (&mut self.g, &G_GROUPS)
        } else {
            (&mut self.m, &M_GROUPS)
        };
        let Some(code) = whole(10.0 * value) else {
            return Err(begin.wrong("a code", "a number with at most one decimal"));
        };
        let group = groups.iter().position(|group| group.contains(&code));
        let same = |(other, _): &(u32, Cursor<'_>)| {
            group.is_some() && groups.iter().position(|group| group.contains(other)) == group
        };
        if codes.iter().any(same) {
            return Err(begin.wrong("a code", "one that does not exclude another in the line"));
        }
        codes
            .push((code, begin))
            .map_err(|_| begin.wrong("too many codes in a line", "at most 14 of each letter"))
    }

    /// The value of a letter, with its place; from now on it counts as used.
    pub(super) fn value(&mut self, letter: u8) -> Option<(f64, Cursor<'a>)> {
        let place = LETTERS.iter().position(|known| *known == letter)?;
        self.used |= 1 << place;
        self.values.get(place).copied().flatten()
    }

    /// Whether there is such a word.
    pub(super) fn has(&self, letter: u8) -> bool {
        let place = LETTERS.iter().position(|known| *known == letter);
        place
            .and_then(|k| self.values.get(k))
            .is_some_and(Option::is_some)
    }

    pub(super) fn g(&self) -> &[(u32, Cursor<'a>)] {
        &self.g
    }

    pub(super) fn m(&self) -> &[(u32, Cursor<'a>)] {
        &self.m
    }

    /// A word that nothing in the line asked for.
    ///
    /// # Errors
    /// The first one.
    pub(super) fn all_used(&self) -> Result<(), DataError> {
        for (k, value) in self.values.iter().enumerate() {
            if let Some((_, cursor)) = value
                && self.used & (1 << k) == 0
            {
                return Err(cursor.error(
                    Problem::Conflict,
                    "a word that nothing in its line uses",
                    "a code that does, or none",
                    format!("`{}`", char::from(LETTERS.get(k).copied().unwrap_or(b'?'))),
                ));
            }
        }
        Ok(())
    }
}
