//! Values: numbers, parameters, `[` expressions `]`, functions.
//!
//! From the strongest: `**`; `*` `/` `mod`; `+` `-`; `eq` `ne` `gt` `ge` `lt` `le`; `and` `or` `xor`; from left to
//! right among equals. Angles are degrees, a truth is 1 or 0.

use super::cursor::Cursor;
use super::vars::{MOST_NUMBERED, Name, Vars};
use crate::input::{DataError, Problem};

/// Brackets within brackets.
const DEEPEST: u32 = 40;

/// A value: what follows a letter.
pub(super) fn value(cursor: &mut Cursor<'_>, vars: &Vars) -> Result<f64, DataError> {
    real(cursor, vars, 0)
}

/// An expression in its brackets.
pub(super) fn bracketed(cursor: &mut Cursor<'_>, vars: &Vars) -> Result<f64, DataError> {
    if cursor.peek() == Some(b'[') {
        real(cursor, vars, 0)
    } else {
        Err(cursor.wrong("an expression", "`[`"))
    }
}

/// What follows `#`.
pub(super) fn name(cursor: &mut Cursor<'_>, vars: &Vars) -> Result<Name, DataError> {
    parameter(cursor, vars, 0)
}

fn real(cursor: &mut Cursor<'_>, vars: &Vars, depth: u32) -> Result<f64, DataError> {
    if depth > DEEPEST {
        let expected = format!("at most {DEEPEST} levels");
        return Err(cursor.wrong("brackets within brackets", &expected));
    }
    let begin = *cursor;
    let value = match cursor.peek() {
        Some(b'+') => {
            cursor.next();
            real(cursor, vars, depth + 1)?
        }
        Some(b'-') => {
            cursor.next();
            -real(cursor, vars, depth + 1)?
        }
        Some(b'[') => {
            cursor.next();
            let value = level(cursor, vars, depth + 1, LEVELS.len())?;
            if !cursor.take(b']') {
                return Err(cursor.wrong("an expression", "an operator or `]`"));
            }
            value
        }
        Some(b'#') => {
            cursor.next();
            let name = parameter(cursor, vars, depth + 1)?;
            vars.get(&name).ok_or_else(|| {
                begin.error(
                    Problem::Missing,
                    "a parameter that has no value",
                    "one that was set before",
                    format!("`{}`", Shown(&name)),
                )
            })?
        }
        Some(b'a'..=b'z') => function(cursor, vars, depth + 1)?,
        _ => cursor.digits()?,
    };
    if value.is_finite() {
        Ok(value)
    } else {
        Err(begin.error(
            Problem::NotFinite,
            "a value that is no number",
            "a finite one",
            value.to_string(),
        ))
    }
}

fn parameter(cursor: &mut Cursor<'_>, vars: &Vars, depth: u32) -> Result<Name, DataError> {
    if cursor.peek() == Some(b'<') {
        return cursor.name().map(Name::Word);
    }
    let begin = *cursor;
    let number = real(cursor, vars, depth + 1)?;
    whole(number)
        .filter(|number| (1..=MOST_NUMBERED).contains(number))
        .map(Name::Number)
        .ok_or_else(|| {
            begin.error(
                Problem::OutOfRange,
                "the number of a parameter",
                format!("1 to {MOST_NUMBERED}: those above are a machine's"),
                number.to_string(),
            )
        })
}

/// A number without a fraction, to rounding.
pub(super) fn whole(value: f64) -> Option<u32> {
    let nearest = libm::round(value);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "in the range of u32"
    )]
    let number = nearest as u32;
    let is = (value - nearest).abs() <= 1e-4 && (0.0..=4e9).contains(&nearest);
    is.then_some(number)
}

type Operator = (&'static str, fn(f64, f64) -> f64);

fn truth(is: bool) -> f64 {
    f64::from(u8::from(is))
}

/// Operators, the strongest first; where one is the beginning of another, the longer first.
const LEVELS: [&[Operator]; 5] = [
    &[("**", libm::pow)],
    &[
        ("*", |a, b| a * b),
        ("/", |a, b| a / b),
        // of the sign of the second, as in RS-274
        ("mod", |a, b| a - b * libm::floor(a / b)),
    ],
    &[("+", |a, b| a + b), ("-", |a, b| a - b)],
    &[
        ("eq", |a, b| truth((a - b).abs() < 1e-6)),
        ("ne", |a, b| truth((a - b).abs() >= 1e-6)),
        ("gt", |a, b| truth(a > b)),
        ("ge", |a, b| truth(a >= b)),
        ("lt", |a, b| truth(a < b)),
        ("le", |a, b| truth(a <= b)),
    ],
    &[
        ("and", |a, b| truth(is(a) && is(b))),
        ("or", |a, b| truth(is(a) || is(b))),
        ("xor", |a, b| truth(is(a) != is(b))),
    ],
];

fn is(value: f64) -> bool {
    value.abs() > 0.0
}

/// Operators of the first so many levels.
fn level(cursor: &mut Cursor<'_>, vars: &Vars, depth: u32, count: usize) -> Result<f64, DataError> {
    let Some(operators) = count.checked_sub(1).and_then(|k| LEVELS.get(k)) else {
        return real(cursor, vars, depth);
    };
    let mut left = level(cursor, vars, depth, count - 1)?;
    // a line is not endless
    loop {
        let begin = *cursor;
        let found = operators.iter().find(|(word, _)| {
            // `*` is not the beginning of `**`
            let other = *word == "*" && begin.clone().take_word("**");
            !other && cursor.take_word(word)
        });
        let Some((_, apply)) = found else {
            return Ok(left);
        };
        let right = level(cursor, vars, depth, count - 1)?;
        left = apply(left, right);
        if !left.is_finite() {
            return Err(begin.error(
                Problem::NotFinite,
                "a value that is no number",
                "a finite one",
                left.to_string(),
            ));
        }
    }
}

fn function(cursor: &mut Cursor<'_>, vars: &Vars, depth: u32) -> Result<f64, DataError> {
    let begin = *cursor;
    let name = cursor.letters();
    if name == "exists" {
        let there = cursor.take(b'[') && cursor.take(b'#');
        if !there {
            return Err(cursor.wrong("`exists`", "`[#<`name`>]`"));
        }
        let name = Name::Word(cursor.name()?);
        if !cursor.take(b']') {
            return Err(cursor.wrong("`exists`", "`]`"));
        }
        return Ok(truth(vars.get(&name).is_some()));
    }
    let degrees = |angle: f64| angle * 180.0 / core::f64::consts::PI;
    let radians = |angle: f64| angle * core::f64::consts::PI / 180.0;
    let known = [
        "abs", "acos", "asin", "atan", "cos", "exp", "fix", "fup", "ln", "round", "sin", "sqrt",
        "tan",
    ];
    if !known.contains(&name.as_str()) {
        return Err(begin.wrong("a value", "a number, `#`, `[` or a function"));
    }
    if cursor.peek() != Some(b'[') {
        return Err(cursor.wrong("a function", "`[`"));
    }
    let x = real(cursor, vars, depth)?;
    Ok(match name.as_str() {
        "abs" => x.abs(),
        "acos" => degrees(libm::acos(x)),
        "asin" => degrees(libm::asin(x)),
        "atan" => {
            if !cursor.take(b'/') || cursor.peek() != Some(b'[') {
                return Err(cursor.wrong("`atan`", "`[`y`]/[`x`]`"));
            }
            degrees(libm::atan2(x, real(cursor, vars, depth)?))
        }
        "cos" => libm::cos(radians(x)),
        "exp" => libm::exp(x),
        "fix" => libm::floor(x),
        "fup" => libm::ceil(x),
        "ln" => libm::log(x),
        "round" => libm::round(x),
        "sin" => libm::sin(radians(x)),
        "sqrt" => libm::sqrt(x),
        _ => libm::tan(radians(x)),
    })
}

/// A parameter as a program names it.
struct Shown<'a>(&'a Name);

impl core::fmt::Display for Shown<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self.0 {
            Name::Number(number) => write!(f, "#{number}"),
            Name::Word(word) => write!(f, "#<{word}>"),
        }
    }
}
