//! Parameters: `#1`, `#<name>`, and what a subroutine has of its own.

use std::collections::BTreeMap;

/// The parameters that a call has of its own are 1 to this.
pub(super) const ARGUMENTS: usize = 30;
/// The greatest number of a parameter that a program may set; above are those of a machine.
pub(super) const MOST_NUMBERED: u32 = 5000;
/// The most named parameters there may be at one time.
pub(super) const MOST_NAMED: usize = 10_000;

/// All parameters.
#[derive(Clone, Debug, Default)]
pub(super) struct Vars {
    numbered: BTreeMap<u32, f64>,
    global: BTreeMap<String, f64>,
    /// Of the main program and of every call that is not over.
    frames: Vec<Frame>,
    named: usize,
}

#[derive(Clone, Debug)]
struct Frame {
    arguments: [f64; ARGUMENTS],
    named: BTreeMap<String, f64>,
}

/// A parameter.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Name {
    /// `#1`
    Number(u32),
    /// `#<name>`; global if it begins with `_`.
    Word(String),
}

impl Vars {
    pub(super) fn new() -> Self {
        let mut this = Self::default();
        this.enter([0.0; ARGUMENTS]);
        this
    }

    /// A call begins.
    pub(super) fn enter(&mut self, arguments: [f64; ARGUMENTS]) {
        self.frames.push(Frame {
            arguments,
            named: BTreeMap::new(),
        });
    }

    /// A call is over.
    pub(super) fn leave(&mut self) {
        if let Some(frame) = self.frames.pop() {
            self.named -= frame.named.len();
        }
    }

    /// The value; a number that was never set is 0, a name that was never set is none.
    pub(super) fn get(&self, name: &Name) -> Option<f64> {
        match name {
            Name::Number(number) => Some(match (argument(*number), self.frames.last()) {
                (Some(k), Some(frame)) => frame.arguments.get(k).copied().unwrap_or_default(),
                _ => self.numbered.get(number).copied().unwrap_or_default(),
            }),
            Name::Word(word) if word.starts_with('_') => self.global.get(word).copied(),
            Name::Word(word) => self.frames.last()?.named.get(word).copied(),
        }
    }

    /// Sets a value; false if there is no room for another name.
    pub(super) fn set(&mut self, name: Name, value: f64) -> bool {
        let Some(frame) = self.frames.last_mut() else {
            return false;
        };
        let names = match name {
            Name::Number(number) => {
                if let Some(place) = argument(number).and_then(|k| frame.arguments.get_mut(k)) {
                    *place = value;
                } else {
                    self.numbered.insert(number, value);
                }
                return true;
            }
            Name::Word(word) => {
                let global = word.starts_with('_');
                let names = if global {
                    &mut self.global
                } else {
                    &mut frame.named
                };
                names.insert(word, value).is_none()
            }
        };
        self.named += usize::from(names);
        self.named <= MOST_NAMED
    }
}

fn argument(number: u32) -> Option<usize> {
    let number = usize::try_from(number).ok()?;
    number.checked_sub(1).filter(|k| *k < ARGUMENTS)
}
