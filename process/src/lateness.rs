//! How late a process was called: a histogram in bins of 20 µs.

use std::fmt;
use std::time::Duration;

/// Width of a bin, µs.
const BIN_US: u64 = 20;
/// Bins: up to 20 ms; what is later is counted in one more.
const BINS: usize = 1000;

/// Lateness of every call, relative to the absolute deadline that was asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lateness {
    bins: Vec<u64>,
    beyond: u64,
    calls: u64,
    worst: Duration,
    overrun_from: Duration,
    overruns: u64,
}

impl Lateness {
    /// Nothing yet; calls later than `overrun_from` count as overruns.
    #[must_use]
    pub fn new(overrun_from: Duration) -> Self {
        Self {
            bins: vec![0; BINS],
            beyond: 0,
            calls: 0,
            worst: Duration::ZERO,
            overrun_from,
            overruns: 0,
        }
    }

    /// One call.
    pub fn record(&mut self, late: Duration) {
        let bin = usize::try_from(late.as_micros() / u128::from(BIN_US)).unwrap_or(usize::MAX);
        match self.bins.get_mut(bin) {
            Some(count) => *count += 1,
            None => self.beyond += 1,
        }
        self.calls += 1;
        self.worst = self.worst.max(late);
        if late > self.overrun_from {
            self.overruns += 1;
        }
    }

    /// Calls so far.
    #[must_use]
    pub const fn calls(&self) -> u64 {
        self.calls
    }

    /// Calls that came later than the next action was due.
    #[must_use]
    pub const fn overruns(&self) -> u64 {
        self.overruns
    }

    /// The latest call.
    #[must_use]
    pub const fn worst(&self) -> Duration {
        self.worst
    }

    /// The lateness that `permille` of 1000 calls do not exceed, rounded up to a whole bin.
    #[must_use]
    pub fn percentile(&self, permille: u64) -> Duration {
        let rank = (self.calls * permille).div_ceil(1000);
        let mut seen = 0;
        for (bin, count) in (1..).zip(&self.bins) {
            seen += count;
            if seen >= rank {
                return Duration::from_micros(bin * BIN_US).min(self.worst);
            }
        }
        self.worst
    }

    /// How many calls were no later than 20, 40, 80 … µs and later than the bound before, as pairs of bound and
    /// count up to the last call; the last bound is the worst lateness.
    #[must_use]
    pub fn histogram(&self) -> Vec<(u64, u64)> {
        let worst_us = u64::try_from(self.worst.as_micros()).unwrap_or(u64::MAX);
        let (mut rows, mut bins) = (Vec::new(), self.bins.iter());
        let mut width = 1;
        let mut bound_us = BIN_US;
        let mut left = self.calls;
        while left > 0 {
            let mut count: u64 = bins.by_ref().take(width).sum();
            let last = bound_us >= worst_us || bins.len() == 0;
            if last {
                // what is beyond the last bin too
                count = left;
            }
            rows.push((if last { worst_us } else { bound_us }, count));
            left -= count;
            width = usize::try_from(bound_us / BIN_US).unwrap_or(usize::MAX);
            bound_us *= 2;
        }
        rows
    }
}

impl fmt::Display for Lateness {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [p50, p99, p999] =
            [500, 990, 999].map(|permille| self.percentile(permille).as_micros());
        write!(
            f,
            "late by {p50} us (half of the calls), {p99} us (99 %), {p999} us (99.9 %), worst {} us; {} overruns \
             in {} calls; calls by us:",
            self.worst.as_micros(),
            self.overruns,
            self.calls
        )?;
        self.histogram()
            .iter()
            .try_for_each(|(bound_us, count)| write!(f, " <={bound_us} {count}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: Duration = Duration::from_millis(1);

    #[test]
    fn percentiles_are_upper_bounds_within_a_bin() {
        let mut lateness = Lateness::new(MS);
        assert_eq!(lateness.percentile(500), Duration::ZERO);
        for us in 0..1000 {
            lateness.record(Duration::from_micros(us));
        }
        assert_eq!(lateness.percentile(500), Duration::from_micros(500));
        assert_eq!(lateness.percentile(990), Duration::from_micros(999));
        assert_eq!(lateness.overruns(), 0);
        lateness.record(50 * MS);
        assert_eq!(lateness.percentile(999), MS);
        assert_eq!(lateness.percentile(1000), 50 * MS);
        assert_eq!((lateness.worst(), lateness.overruns()), (50 * MS, 1));
        assert_eq!(lateness.calls(), 1001);
    }

    #[test]
    fn every_call_is_in_one_row_of_the_histogram() {
        let mut lateness = Lateness::new(MS);
        assert_eq!(lateness.histogram(), []);
        for us in [0, 19, 20, 39, 40, 79, 100, 150] {
            lateness.record(Duration::from_micros(us));
        }
        let text = lateness.to_string();
        assert!(text.ends_with("<=20 2 <=40 2 <=80 2 <=150 2"), "{text}");
        // a bin begins with its lower bound
        assert_eq!(lateness.histogram(), [(20, 2), (40, 2), (80, 2), (150, 2)]);
        lateness.record(3 * MS);
        lateness.record(50 * MS);
        let rows = lateness.histogram();
        assert_eq!(rows.first(), Some(&(20, 2)));
        assert_eq!(rows.last(), Some(&(50_000, 1)));
        assert!(
            rows.windows(2).all(|pair| pair[0].0 < pair[1].0),
            "{rows:?}"
        );
        assert_eq!(rows.iter().map(|(_, count)| count).sum::<u64>(), 10);
    }
}
