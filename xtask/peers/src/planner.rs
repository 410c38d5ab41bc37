//! Who is compared.

use crate::case::Case;
use crate::ours::Ours;
use crate::plan::Batch;
use crate::rsruckig::Rsruckig;
use crate::ruckig::Ruckig;
use std::fmt;
use std::str::FromStr;

/// A planner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Planner {
    /// That of `motion`.
    Ours,
    /// The C++ original of Ruckig: what the others are compared with.
    Ruckig,
    /// Its port to Rust.
    Rsruckig,
}

impl Planner {
    /// All of them, in the order of reports.
    pub const ALL: [Self; 3] = [Self::Ours, Self::Ruckig, Self::Rsruckig];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Ours => "mrroc",
            Self::Ruckig => "ruckig",
            Self::Rsruckig => "rsruckig",
        }
    }

    /// Copies cases into its own types.
    ///
    /// # Panics
    /// If N is not one of [`AXES`](crate::ruckig::AXES).
    #[must_use]
    pub fn batch<const N: usize>(self, cases: &[Case<N>]) -> Box<dyn Batch> {
        match self {
            Self::Ours => Box::new(Ours::new(cases)),
            Self::Ruckig => Box::new(Ruckig::new(cases)),
            Self::Rsruckig => Box::new(Rsruckig::new(cases)),
        }
    }
}

impl fmt::Display for Planner {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Planner {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|planner| planner.name() == text);
        found.ok_or_else(|| format!("no planner {text}"))
    }
}
