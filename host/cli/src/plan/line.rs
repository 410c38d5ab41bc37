//! A case from a line of JSON; what is wrong with a line names the key and the place in its list.

use std::fmt;

use serde::de::{self, Deserialize, Deserializer, MapAccess, SeqAccess, Visitor};

use super::case::{Case, Sync};

/// The case of a line.
///
/// # Errors
/// What is wrong with the line, in one line, with the column if it is known.
pub(super) fn case(line: &[u8]) -> Result<Case, String> {
    let line = line.trim_ascii_end();
    serde_json::from_slice(line).map_err(|error| {
        let (column, text) = (error.column(), error.to_string());
        // a line of JSONL is all there is: only the column says something
        let place = format!(" at line {} column {column}", error.line());
        match text.strip_suffix(&place) {
            Some(what) => format!("{what} at column {column}"),
            None => text,
        }
    })
}

impl<'de> Deserialize<'de> for Case {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(CaseVisitor)
    }
}

struct CaseVisitor;

impl<'de> Visitor<'de> for CaseVisitor {
    type Value = Case;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object")
    }

    fn visit_map<M: MapAccess<'de>>(self, mut map: M) -> Result<Case, M::Error> {
        let mut case = Case::default();
        while let Some(key) = map.next_key::<String>()? {
            let twice = match key.as_str() {
                "sync" => {
                    let sync = map.next_value::<Sync>();
                    case.sync.replace(sync.map_err(named(&key))?).is_some()
                }
                "minimum_duration" => {
                    let least = map.next_value::<f64>().map_err(named(&key))?;
                    case.minimum_duration.replace(least).is_some()
                }
                _ => {
                    let list = case.list_mut(&key).ok_or_else(|| unknown(&key))?;
                    let numbers = map.next_value::<Numbers>().map_err(named(&key))?;
                    list.replace(numbers.0).is_some()
                }
            };
            if twice {
                return Err(de::Error::custom(format!(
                    "{key}: expected once, got twice"
                )));
            }
        }
        Ok(case)
    }
}

fn named<E: de::Error>(what: &str) -> impl FnOnce(E) -> E {
    move |error| E::custom(format!("{what}: {error}"))
}

fn unknown<E: de::Error>(key: &str) -> E {
    let key: String = key.chars().take(40).collect();
    E::custom(format!(
        "unknown key {key:?}, expected p0, v0, a0, p1, v1, a1, v_max, a_max, j_max, v_min, a_min, \
         p_min, p_max, sync or minimum_duration"
    ))
}

/// The numbers of a list.
struct Numbers(Vec<f64>);

impl<'de> Deserialize<'de> for Numbers {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_seq(NumbersVisitor)
    }
}

struct NumbersVisitor;

impl<'de> Visitor<'de> for NumbersVisitor {
    type Value = Numbers;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a list of numbers")
    }

    fn visit_seq<S: SeqAccess<'de>>(self, mut list: S) -> Result<Numbers, S::Error> {
        let mut numbers = Vec::new();
        loop {
            let place = format!("axis {}", numbers.len() + 1);
            match list.next_element().map_err(named(&place))? {
                Some(number) => numbers.push(number),
                None => return Ok(Numbers(numbers)),
            }
        }
    }
}
