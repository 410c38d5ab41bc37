//! A case of `mrroc plan profile`, and what it asks for.

use std::fmt;

use clap::{Args, ValueEnum};
use motion::profile::{AxisBounds, Boundary, Synchronisation};
use serde::Deserialize;

use super::motion::{Asked, MOST_AXES};
use crate::commands::finite;

/// A case as it was written, by a line or by flags: lists of one number per axis.
#[derive(Args, Debug, Default)]
#[group(conflicts_with = "jsonl")]
pub(super) struct Case {
    /// Positions at the start, one per axis, separated by commas
    #[arg(long = "from", value_name = "P", value_delimiter = ',', allow_hyphen_values = true, value_parser = finite)]
    p0: Option<Vec<f64>>,
    /// Velocities at the start [default: 0]
    #[arg(long = "from-velocity", value_name = "V", value_delimiter = ',', allow_hyphen_values = true, value_parser = finite)]
    v0: Option<Vec<f64>>,
    /// Accelerations at the start [default: 0]
    #[arg(long = "from-acceleration", value_name = "A", value_delimiter = ',', allow_hyphen_values = true, value_parser = finite)]
    a0: Option<Vec<f64>>,
    /// Positions at the end
    #[arg(long = "to", value_name = "P", value_delimiter = ',', allow_hyphen_values = true, value_parser = finite)]
    p1: Option<Vec<f64>>,
    /// Velocities at the end [default: 0]
    #[arg(long = "to-velocity", value_name = "V", value_delimiter = ',', allow_hyphen_values = true, value_parser = finite)]
    v1: Option<Vec<f64>>,
    /// Accelerations at the end [default: 0]
    #[arg(long = "to-acceleration", value_name = "A", value_delimiter = ',', allow_hyphen_values = true, value_parser = finite)]
    a1: Option<Vec<f64>>,
    /// Highest velocities, above 0
    #[arg(long, value_name = "V", value_delimiter = ',', allow_hyphen_values = true, value_parser = finite)]
    v_max: Option<Vec<f64>>,
    /// Highest accelerations, above 0
    #[arg(long, value_name = "A", value_delimiter = ',', allow_hyphen_values = true, value_parser = finite)]
    a_max: Option<Vec<f64>>,
    /// Highest jerks either way, above 0
    #[arg(long, value_name = "J", value_delimiter = ',', allow_hyphen_values = true, value_parser = finite)]
    j_max: Option<Vec<f64>>,
    /// Lowest velocities, below 0 [default: the highest, negated]
    #[arg(long, value_name = "V", value_delimiter = ',', allow_hyphen_values = true, value_parser = finite)]
    v_min: Option<Vec<f64>>,
    /// Lowest accelerations, below 0 [default: the highest, negated]
    #[arg(long, value_name = "A", value_delimiter = ',', allow_hyphen_values = true, value_parser = finite)]
    a_min: Option<Vec<f64>>,
    /// Lowest positions [default: none]
    #[arg(long, value_name = "P", value_delimiter = ',', allow_hyphen_values = true, value_parser = finite)]
    p_min: Option<Vec<f64>>,
    /// Highest positions [default: none]
    #[arg(long, value_name = "P", value_delimiter = ',', allow_hyphen_values = true, value_parser = finite)]
    p_max: Option<Vec<f64>>,
    /// How the axes wait for each other [default: time]
    #[arg(long, value_enum)]
    pub(super) sync: Option<Sync>,
    /// The motion takes no less than this, s [default: 0]
    #[arg(long, value_name = "S", allow_hyphen_values = true, value_parser = finite)]
    pub(super) minimum_duration: Option<f64>,
}

/// How the axes wait for each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Sync {
    /// They arrive together
    Time,
    /// Each arrives as early as it can
    None,
    /// They stay on the straight line where start and end states lie on one, else as time
    Phase,
}

/// What the numbers of a case are called in messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Names {
    /// By the keys of a line.
    Keys,
    /// By the flags of the command line.
    Flags,
}

impl Names {
    fn of(self, key: &str) -> String {
        match (self, key) {
            (Self::Keys, key) => key.into(),
            (Self::Flags, "p0") => "--from".into(),
            (Self::Flags, "v0") => "--from-velocity".into(),
            (Self::Flags, "a0") => "--from-acceleration".into(),
            (Self::Flags, "p1") => "--to".into(),
            (Self::Flags, "v1") => "--to-velocity".into(),
            (Self::Flags, "a1") => "--to-acceleration".into(),
            (Self::Flags, key) => format!("--{}", key.replace('_', "-")),
        }
    }

    /// What is wrong with a number of axes.
    pub(super) fn wrong_axes(self, got: impl fmt::Display) -> String {
        let name = self.of("p0");
        format!("{name}: expected 1 to {MOST_AXES} numbers, one per axis, got {got}")
    }
}

/// The lists of a case, read for a number of axes.
struct Reader<'a> {
    case: &'a Case,
    names: Names,
    axes: usize,
}

impl Reader<'_> {
    /// The numbers of a key, one per axis.
    fn given(&self, key: &str) -> Result<Option<Vec<f64>>, String> {
        let numbers = self.case.list(key);
        match numbers.map(Vec::len) {
            Some(got) if got != self.axes => Err(self.wrong_count(key, got)),
            _ => Ok(numbers.cloned()),
        }
    }

    fn wrong_count(&self, key: &str, got: impl fmt::Display) -> String {
        let (name, first, axes) = (self.names.of(key), self.names.of("p0"), self.axes);
        format!("{name}: expected as many numbers as {first} ({axes}), got {got}")
    }

    fn required(&self, key: &str) -> Result<Vec<f64>, String> {
        self.given(key)?
            .ok_or_else(|| self.wrong_count(key, "none"))
    }

    fn or_all(&self, key: &str, default: f64) -> Result<Vec<f64>, String> {
        Ok(self.given(key)?.unwrap_or_else(|| vec![default; self.axes]))
    }

    /// Highest values, above 0.
    fn highest(&self, key: &str) -> Result<Vec<f64>, String> {
        let numbers = self.required(key)?;
        self.refuse(key, &numbers, "above 0", |x| x <= 0.0)?;
        Ok(numbers)
    }

    /// Lowest values, below 0; the highest negated where there are none.
    fn lowest(&self, key: &str, highest: &[f64]) -> Result<Vec<f64>, String> {
        let mirrored = || highest.iter().map(|x| -x).collect();
        let numbers = self.given(key)?.unwrap_or_else(mirrored);
        self.refuse(key, &numbers, "below 0", |x| x >= 0.0)?;
        Ok(numbers)
    }

    fn refuse(
        &self,
        key: &str,
        numbers: &[f64],
        expected: &str,
        wrong: impl Fn(f64) -> bool,
    ) -> Result<(), String> {
        let name = self.names.of(key);
        match (1..).zip(numbers).find(|(_, x)| wrong(**x)) {
            Some((axis, got)) => Err(format!(
                "{name}: axis {axis}: expected a number {expected}, got {got}"
            )),
            None => Ok(()),
        }
    }

    fn boundaries(&self, [p, v, a]: [&str; 3]) -> Result<Vec<Boundary>, String> {
        let p = self.required(p)?;
        let (v, a) = (self.or_all(v, 0.0)?, self.or_all(a, 0.0)?);
        let each = p.into_iter().zip(v).zip(a);
        Ok(each.map(|((p, v), a)| Boundary { p, v, a }).collect())
    }

    fn bounds(&self) -> Result<Vec<AxisBounds>, String> {
        let (v_max, a_max) = (self.highest("v_max")?, self.highest("a_max")?);
        let j_max = self.highest("j_max")?;
        let v_min = self.lowest("v_min", &v_max)?;
        let a_min = self.lowest("a_min", &a_max)?;
        let p_min = self.or_all("p_min", f64::NEG_INFINITY)?;
        let p_max = self.or_all("p_max", f64::INFINITY)?;
        let velocities = v_min.into_iter().zip(v_max);
        let accelerations = a_min.into_iter().zip(a_max);
        let positions = p_min.into_iter().zip(p_max);
        let each = velocities.zip(accelerations).zip(positions).zip(j_max);
        Ok(each
            .map(
                |((((v_min, v_max), (a_min, a_max)), (p_min, p_max)), j_max)| AxisBounds {
                    v_min,
                    v_max,
                    a_min,
                    a_max,
                    j_max,
                    p_min,
                    p_max,
                },
            )
            .collect())
    }
}

impl Case {
    /// Is there neither a start nor an end?
    pub(super) fn is_empty(&self) -> bool {
        self.p0.is_none() && self.p1.is_none()
    }

    /// What the case asks for, or in one line what is wrong with it.
    pub(super) fn asked(&self, names: Names) -> Result<Asked, String> {
        let axes = self.p0.as_ref().map(Vec::len);
        let axes = axes.ok_or_else(|| names.wrong_axes("none"))?;
        // told before every other list is found to be of another length
        if !(1..=MOST_AXES).contains(&axes) {
            return Err(names.wrong_axes(axes));
        }
        let minimum_duration = self.minimum_duration.unwrap_or(0.0);
        if minimum_duration < 0.0 {
            let name = names.of("minimum_duration");
            return Err(format!(
                "{name}: expected 0 or more, got {minimum_duration}"
            ));
        }
        let reader = Reader {
            case: self,
            names,
            axes,
        };
        Ok(Asked {
            start: reader.boundaries(["p0", "v0", "a0"])?,
            end: reader.boundaries(["p1", "v1", "a1"])?,
            bounds: reader.bounds()?,
            synchronisation: match self.sync {
                None | Some(Sync::Time) => Synchronisation::Time,
                Some(Sync::None) => Synchronisation::None,
                Some(Sync::Phase) => Synchronisation::Phase,
            },
            minimum_duration,
        })
    }

    fn list(&self, key: &str) -> Option<&Vec<f64>> {
        match key {
            "p0" => self.p0.as_ref(),
            "v0" => self.v0.as_ref(),
            "a0" => self.a0.as_ref(),
            "p1" => self.p1.as_ref(),
            "v1" => self.v1.as_ref(),
            "a1" => self.a1.as_ref(),
            "v_max" => self.v_max.as_ref(),
            "a_max" => self.a_max.as_ref(),
            "j_max" => self.j_max.as_ref(),
            "v_min" => self.v_min.as_ref(),
            "a_min" => self.a_min.as_ref(),
            "p_min" => self.p_min.as_ref(),
            "p_max" => self.p_max.as_ref(),
            _ => None,
        }
    }

    /// Where the list of a key is kept; nothing if there is no such key.
    pub(super) fn list_mut(&mut self, key: &str) -> Option<&mut Option<Vec<f64>>> {
        Some(match key {
            "p0" => &mut self.p0,
            "v0" => &mut self.v0,
            "a0" => &mut self.a0,
            "p1" => &mut self.p1,
            "v1" => &mut self.v1,
            "a1" => &mut self.a1,
            "v_max" => &mut self.v_max,
            "a_max" => &mut self.a_max,
            "j_max" => &mut self.j_max,
            "v_min" => &mut self.v_min,
            "a_min" => &mut self.a_min,
            "p_min" => &mut self.p_min,
            "p_max" => &mut self.p_max,
            _ => return None,
        })
    }
}
