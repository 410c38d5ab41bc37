//! A TOML document read strictly: every key known, every value of its type and range, every
//! mistake with its place.

use crate::input::{DataError, Files, LoadError, Problem, position, shown};
use std::ops::Range;
use std::path::{Path, PathBuf};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The text of a document and where it came from.
pub(super) struct Document<'t> {
    pub(super) path: Option<&'t Path>,
    pub(super) text: &'t str,
    /// Where the files it names come from.
    pub(super) files: &'t Files,
}

impl<'t> Document<'t> {
    /// Reads a file and hands it to `f`.
    pub(super) fn load<T>(
        path: &Path,
        files: &Files,
        f: impl FnOnce(&Document<'_>) -> Result<T, DataError>,
    ) -> Result<T, LoadError> {
        let text = files.read(path)?;
        Ok(f(&Document {
            path: Some(path),
            text: &text,
            files,
        })?)
    }

    pub(super) fn parse(&self) -> Result<Spanned<DeTable<'t>>, DataError> {
        DeTable::parse(self.text).map_err(|error| {
            let span = error.span().unwrap_or_default();
            let found = self.text.get(span.clone()).unwrap_or_default();
            let got = match (found, error.message().starts_with("duplicate")) {
                ("", _) => "something else".to_owned(),
                (found, true) => format!("{} again", shown(found)),
                (found, false) => shown(found),
            };
            let what = error.message().replace('\n', "; ");
            self.error(&span, Problem::Syntax, what, "TOML", got)
        })
    }

    pub(super) fn error(
        &self,
        span: &Range<usize>,
        problem: Problem,
        what: impl Into<String>,
        expected: impl Into<String>,
        got: impl Into<String>,
    ) -> DataError {
        let at = position(self.text, span.start);
        DataError {
            path: self.path.map(Path::to_path_buf),
            ..DataError::at(at, problem, what, expected, got)
        }
    }

    /// A path the document names, relative to the document.
    pub(super) fn resolve(&self, named: &str) -> PathBuf {
        match self.path.and_then(Path::parent) {
            Some(folder) => folder.join(named),
            None => PathBuf::from(named),
        }
    }
}

/// A table whose keys are all known.
pub(super) struct Fields<'d, 't> {
    pub(super) document: &'d Document<'t>,
    pub(super) span: Range<usize>,
    /// What the table is, for messages: `a robot`.
    noun: &'static str,
    table: &'d DeTable<'t>,
}

impl<'d, 't> Fields<'d, 't> {
    pub(super) fn new(
        document: &'d Document<'t>,
        span: Range<usize>,
        table: &'d DeTable<'t>,
        noun: &'static str,
        known: &[&str],
    ) -> Result<Self, DataError> {
        // the first unknown key in the order of the text
        let unknown = table
            .keys()
            .filter(|key| !known.contains(&key.get_ref().as_ref()))
            .min_by_key(|key| key.span().start);
        if let Some(key) = unknown {
            return Err(document.error(
                &key.span(),
                Problem::UnknownKey,
                format!("unknown key in {noun}"),
                one_of(known),
                shown(key.get_ref()),
            ));
        }
        Ok(Self {
            document,
            span,
            noun,
            table,
        })
    }

    pub(super) fn optional(&self, key: &'static str) -> Option<Value<'d, 't>> {
        self.table.get(key).map(|value| Value {
            document: self.document,
            key,
            node: value,
        })
    }

    pub(super) fn required(&self, key: &'static str) -> Result<Value<'d, 't>, DataError> {
        self.optional(key).ok_or_else(|| {
            self.document.error(
                &self.span,
                Problem::Missing,
                format!("{} without `{key}`", self.noun),
                format!("`{key}`"),
                "none",
            )
        })
    }

    /// The one of these keys that is there.
    pub(super) fn exactly_one(
        &self,
        keys: &[&'static str],
    ) -> Result<(&'static str, Value<'d, 't>), DataError> {
        let mut present = keys
            .iter()
            .filter_map(|key| Some((*key, self.optional(key)?)));
        let expected = || format!("exactly one of {}", one_of(keys));
        let Some(first) = present.next() else {
            return Err(self.document.error(
                &self.span,
                Problem::Missing,
                format!("{} that says nothing", self.noun),
                expected(),
                "none",
            ));
        };
        match present.next() {
            None => Ok(first),
            Some((key, value)) => Err(self.document.error(
                &value.node.span(),
                Problem::Conflict,
                format!("{} that says two things", self.noun),
                expected(),
                format!("`{}` and `{key}`", first.0),
            )),
        }
    }
}

/// `` `a`, `b` or `c` ``
pub(super) fn one_of(names: &[&str]) -> String {
    let mut out = String::new();
    for (index, name) in names.iter().enumerate() {
        if index > 0 {
            out.push_str(if index + 1 == names.len() {
                " or "
            } else {
                ", "
            });
        }
        out.push('`');
        out.push_str(name);
        out.push('`');
    }
    out
}

/// A value and the key it stands at.
#[derive(Clone)]
pub(super) struct Value<'d, 't> {
    document: &'d Document<'t>,
    key: &'static str,
    node: &'d Spanned<DeValue<'t>>,
}

impl<'d, 't> Value<'d, 't> {
    pub(super) fn error(
        &self,
        problem: Problem,
        what: impl Into<String>,
        expected: impl Into<String>,
        got: impl Into<String>,
    ) -> DataError {
        self.document
            .error(&self.node.span(), problem, what, expected, got)
    }

    fn wrong_type(&self, expected: &str) -> DataError {
        let got = match self.node.get_ref() {
            DeValue::String(text) => format!("the text {}", shown(text)),
            DeValue::Integer(_) | DeValue::Float(_) => self.as_written(),
            DeValue::Boolean(value) => value.to_string(),
            DeValue::Datetime(_) => "a date".to_owned(),
            DeValue::Array(values) => format!("a list of {}", values.len()),
            DeValue::Table(_) => "a table".to_owned(),
        };
        self.error(
            Problem::WrongType,
            format!("`{}` of the wrong type", self.key),
            expected,
            got,
        )
    }

    fn as_written(&self) -> String {
        shown(self.document.text.get(self.node.span()).unwrap_or_default())
    }

    pub(super) fn text(&self) -> Result<&'d str, DataError> {
        const LONGEST: usize = 1024;
        let text = self
            .node
            .get_ref()
            .as_str()
            .ok_or_else(|| self.wrong_type("text in quotes"))?;
        if text.is_empty() || text.len() > LONGEST || text.chars().any(char::is_control) {
            return Err(self.error(
                Problem::OutOfRange,
                format!("`{}` is not a line of text", self.key),
                format!("1 to {LONGEST} bytes without control characters"),
                shown(text),
            ));
        }
        Ok(text)
    }

    pub(super) fn is_text(&self) -> bool {
        self.node.get_ref().is_str()
    }

    pub(super) fn is_list(&self) -> bool {
        self.node.get_ref().is_array()
    }

    pub(super) fn boolean(&self) -> Result<bool, DataError> {
        self.node
            .get_ref()
            .as_bool()
            .ok_or_else(|| self.wrong_type("true or false"))
    }

    /// A whole number of which `good` holds.
    pub(super) fn integer(
        &self,
        expected: &str,
        good: impl FnOnce(u64) -> bool,
    ) -> Result<u64, DataError> {
        let integer = self
            .node
            .get_ref()
            .as_integer()
            .ok_or_else(|| self.wrong_type(expected))?;
        u64::from_str_radix(integer.as_str(), integer.radix())
            .ok()
            .filter(|value| good(*value))
            .ok_or_else(|| {
                self.error(
                    Problem::OutOfRange,
                    format!("`{}` out of range", self.key),
                    expected,
                    self.as_written(),
                )
            })
    }

    /// A finite number of which `good` holds.
    pub(super) fn number(
        &self,
        expected: &str,
        good: impl FnOnce(f64) -> bool,
    ) -> Result<f64, DataError> {
        let number = match self.node.get_ref() {
            DeValue::Float(float) => float.as_str().parse::<f64>().ok(),
            DeValue::Integer(integer) => i64::from_str_radix(integer.as_str(), integer.radix())
                .ok()
                // exact up to 2⁵³, as a number written with a point would be
                .and_then(|value| value.to_string().parse::<f64>().ok()),
            _ => return Err(self.wrong_type(expected)),
        };
        let wrong = |problem, what| {
            self.error(
                problem,
                format!("`{}` {what}", self.key),
                expected,
                self.as_written(),
            )
        };
        match number {
            Some(value) if !value.is_finite() => Err(wrong(Problem::NotFinite, "is not finite")),
            Some(value) if good(value) => Ok(value),
            _ => Err(wrong(Problem::OutOfRange, "out of range")),
        }
    }

    /// The values of a list.
    pub(super) fn list(&self) -> Result<Vec<Value<'d, 't>>, DataError> {
        let values = self
            .node
            .get_ref()
            .as_array()
            .ok_or_else(|| self.wrong_type("a list"))?;
        Ok(values
            .iter()
            .map(|value| Value {
                document: self.document,
                key: self.key,
                node: value,
            })
            .collect())
    }

    /// So many finite numbers.
    pub(super) fn numbers(&self, count: usize) -> Result<Vec<f64>, DataError> {
        let list = self.list()?;
        if list.len() != count {
            return Err(self.error(
                Problem::WrongCount,
                format!("wrong number of values in `{}`", self.key),
                format!("{count} numbers"),
                list.len().to_string(),
            ));
        }
        list.iter()
            .map(|value| value.number("a finite number", |_| true))
            .collect()
    }

    /// Three finite numbers.
    pub(super) fn triple(&self) -> Result<[f64; 3], DataError> {
        let mut triple = [0.0; 3];
        for (slot, value) in triple.iter_mut().zip(self.numbers(3)?) {
            *slot = value;
        }
        Ok(triple)
    }

    /// A table of known keys.
    pub(super) fn fields(
        &self,
        noun: &'static str,
        known: &[&str],
    ) -> Result<Fields<'d, 't>, DataError> {
        let table = self
            .node
            .get_ref()
            .as_table()
            .ok_or_else(|| self.wrong_type("a table"))?;
        Fields::new(self.document, self.node.span(), table, noun, known)
    }

    /// The keys (in the order of the text) and values of a table with free keys.
    pub(super) fn entries(&self) -> Result<Vec<Entry<'d, 't>>, DataError> {
        let table = self
            .node
            .get_ref()
            .as_table()
            .ok_or_else(|| self.wrong_type("a table"))?;
        let mut entries: Vec<_> = table
            .iter()
            .map(|(key, value)| Entry {
                name: key.get_ref().as_ref(),
                span: key.span(),
                value: Value {
                    document: self.document,
                    key: self.key,
                    node: value,
                },
            })
            .collect();
        entries.sort_by_key(|entry| entry.span.start);
        Ok(entries)
    }

    /// One of the named things.
    pub(super) fn choice<T: Copy>(
        &self,
        what: &str,
        choices: &[(&str, T)],
    ) -> Result<T, DataError> {
        let text = self.text()?;
        choices
            .iter()
            .find(|(name, _)| *name == text)
            .map(|(_, choice)| *choice)
            .ok_or_else(|| {
                let names: Vec<&str> = choices.iter().map(|(name, _)| *name).collect();
                self.error(
                    Problem::UnknownName,
                    format!("unknown {what}"),
                    one_of(&names),
                    shown(text),
                )
            })
    }
}

/// A key of the writer's choosing and its value.
pub(super) struct Entry<'d, 't> {
    pub(super) name: &'d str,
    pub(super) span: Range<usize>,
    pub(super) value: Value<'d, 't>,
}
