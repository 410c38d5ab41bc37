//! What was measured, and how it is printed.
//!
//! | module | one line |
//! |---|---|
//! | [`markdown`] | as tables |
//! | [`mod@json`] | as one JSON object |

pub mod json;
pub mod markdown;

use crate::class::Class;
use crate::planner::Planner;
use crate::tally::Tallies;
use crate::timing::Cost;

/// Under which conditions it was measured.
#[derive(Clone, Debug, PartialEq)]
pub struct About {
    /// Model of the processor.
    pub cpu: String,
    /// Seed of the generator.
    pub seed: u64,
    /// Cases of each class, in the part about correctness.
    pub cases: u64,
    /// Axes of each case, in that part.
    pub axes: usize,
}

/// What the Rust compiler says of itself.
pub const RUSTC: &str = env!("PEERS_RUSTC");
/// What the C++ compiler says of itself.
pub const CXX: &str = env!("PEERS_CXX");
/// Flags of the C++ compiler.
pub const CXX_FLAGS: &str = env!("PEERS_CXX_FLAGS");
/// Those of the Rust compiler, in the words of cargo's profile.
pub const RUST_FLAGS: &str = "opt-level 3, lto thin, codegen-units 1";

impl About {
    /// The versions of the planners, by name.
    #[must_use]
    pub fn versions() -> [(&'static str, &'static str); 3] {
        [
            ("mrroc", env!("CARGO_PKG_VERSION")),
            ("ruckig", env!("PEERS_RUCKIG")),
            ("rsruckig", env!("PEERS_RSRUCKIG")),
        ]
    }
}

/// The model of the processor, or else its architecture.
#[must_use]
pub fn cpu() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = text.lines().find_map(|line| {
        let (key, value) = line.split_once(':')?;
        (key.trim() == "model name").then(|| value.trim().to_owned())
    });
    model.unwrap_or_else(|| std::env::consts::ARCH.to_owned())
}

/// What plans of a class cost.
#[derive(Clone, Debug, PartialEq)]
pub struct CostRow {
    /// The class.
    pub class: Class,
    /// Axes of each case.
    pub axes: usize,
    /// In the order of [`Planner::ALL`].
    pub costs: [Cost; Planner::ALL.len()],
}

/// What samples of motions of a class cost.
#[derive(Clone, Debug, PartialEq)]
pub struct SampleRow {
    /// The class.
    pub class: Class,
    /// Axes of each case.
    pub axes: usize,
    /// CPU time, ns, and the relative spread of the rounds; in the order of [`Planner::ALL`].
    pub ns: [(f64, f64); Planner::ALL.len()],
}

/// Everything measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// Under which conditions.
    pub about: About,
    /// Correctness.
    pub classes: Vec<(Class, Tallies)>,
    /// Cost of plans.
    pub costs: Vec<CostRow>,
    /// Cost of samples.
    pub samples: Vec<SampleRow>,
}

impl Report {
    /// What plans of a class cost, if measured.
    #[must_use]
    pub fn cost(&self, class: Class, axes: usize) -> Option<&[Cost; Planner::ALL.len()]> {
        let mut rows = self.costs.iter();
        let row = rows.find(|row| row.class == class && row.axes == axes)?;
        Some(&row.costs)
    }
}
