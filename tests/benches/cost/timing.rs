//! How a piece of work is timed.
//!
//! Work is repeated identically, and of each piece the fastest time counts: whatever else the
//! machine did in between only ever adds. The spread that remains is that of the work itself.
//! Times are wall time of one `Instant` before and one after the piece, their own cost included.

use std::hint::black_box;
use std::time::Instant;

/// What is done with the work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mode {
    /// It is timed.
    Time,
    /// It is done once: an instrument counts what happens inside [`measured_work`].
    Once,
}

impl Mode {
    /// How often the same work is repeated.
    pub(crate) const fn repeats(self) -> usize {
        match self {
            Self::Time => 15,
            Self::Once => 1,
        }
    }
}

/// The only function in which measured work happens; instruments know it by its name.
#[inline(never)]
pub(crate) fn measured_work<T>(work: impl FnOnce() -> T) -> T {
    black_box(work())
}

/// The times of pieces of work, the fastest of each so far.
#[derive(Debug, Default)]
pub(crate) struct Pieces {
    fastest_ns: Vec<u64>,
    next: usize,
}

impl Pieces {
    /// The same work begins again.
    pub(crate) const fn again(&mut self) {
        self.next = 0;
    }

    /// Times the next piece.
    pub(crate) fn time<T>(&mut self, work: impl FnOnce() -> T) -> T {
        let begin = Instant::now();
        let result = measured_work(work);
        let ns = u64::try_from(begin.elapsed().as_nanos()).unwrap_or(u64::MAX);
        match self.fastest_ns.get_mut(self.next) {
            Some(fastest) => *fastest = ns.min(*fastest),
            None => self.fastest_ns.push(ns),
        }
        self.next += 1;
        result
    }

    /// What a unit of work costs, where each piece is `units` of them.
    #[expect(clippy::cast_precision_loss, reason = "nanoseconds far below 2^53")]
    pub(crate) fn cost(self, units: u32) -> Cost {
        let mut sorted = self.fastest_ns;
        sorted.sort_unstable();
        let per_unit = |ns: Option<&u64>| ns.map_or(f64::NAN, |ns| *ns as f64 / f64::from(units));
        let all_ns: u64 = sorted.iter().sum();
        let last = sorted.len().saturating_sub(1);
        Cost {
            units: sorted.len() as u64 * u64::from(units),
            mean_ns: all_ns as f64 / (sorted.len() as f64 * f64::from(units)),
            median_ns: per_unit(sorted.get(last / 2)),
            p99_ns: per_unit(sorted.get(last * 99 / 100)),
            worst_ns: per_unit(sorted.last()),
        }
    }
}

/// What a unit of work costs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cost {
    /// Units of work done, once.
    units: u64,
    mean_ns: f64,
    median_ns: f64,
    p99_ns: f64,
    worst_ns: f64,
}

impl Cost {
    /// One line for a program.
    pub(crate) fn json(&self, name: &str) -> serde_json::Value {
        serde_json::json!({
            "workload": name,
            "units": self.units,
            "mean_ns": self.mean_ns,
            "median_ns": self.median_ns,
            "p99_ns": self.p99_ns,
            "worst_ns": self.worst_ns,
        })
    }
}
