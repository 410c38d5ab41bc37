//! How late the node was called: a histogram in bins of 20 µs.

use protocol::time::Micros;

/// Width of a bin, µs.
const BIN_US: u64 = 20;
/// Bins: up to 20 ms; what is later is counted in one more.
const BINS: usize = 1000;

/// Lateness of every call, relative to the absolute deadline the node had asked for.
#[derive(Debug)]
pub(crate) struct Lateness {
    bins: Vec<u64>,
    beyond: u64,
    calls: u64,
    worst: Micros,
    overrun_from: Micros,
    overruns: u64,
}

impl Lateness {
    /// Nothing yet; calls later than `overrun_from` count as overruns.
    pub(crate) fn new(overrun_from: Micros) -> Self {
        Self {
            bins: vec![0; BINS],
            beyond: 0,
            calls: 0,
            worst: Micros(0),
            overrun_from,
            overruns: 0,
        }
    }

    /// One call.
    pub(crate) fn record(&mut self, late: Micros) {
        let bin = usize::try_from(late.0 / BIN_US).unwrap_or(usize::MAX);
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
    pub(crate) const fn calls(&self) -> u64 {
        self.calls
    }

    /// Calls that came later than the next action was due.
    pub(crate) const fn overruns(&self) -> u64 {
        self.overruns
    }

    /// The latest call.
    pub(crate) const fn worst(&self) -> Micros {
        self.worst
    }

    /// The lateness that `permille` of 1000 calls do not exceed, rounded up to a whole bin.
    pub(crate) fn percentile(&self, permille: u64) -> Micros {
        let rank = (self.calls * permille).div_ceil(1000);
        let mut seen = 0;
        for (bin, count) in (1..).zip(&self.bins) {
            seen += count;
            if seen >= rank {
                return Micros(bin * BIN_US).min(self.worst);
            }
        }
        self.worst
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_upper_bounds_within_a_bin() {
        let mut lateness = Lateness::new(Micros(1000));
        assert_eq!(lateness.percentile(500), Micros(0));
        for us in 0..1000 {
            lateness.record(Micros(us));
        }
        assert_eq!(lateness.percentile(500), Micros(500));
        assert_eq!(lateness.percentile(990), Micros(999));
        assert_eq!(lateness.overruns(), 0);
        lateness.record(Micros(50_000));
        assert_eq!(lateness.percentile(999), Micros(1000));
        assert_eq!(lateness.percentile(1000), Micros(50_000));
        assert_eq!((lateness.worst(), lateness.overruns()), (Micros(50_000), 1));
        assert_eq!(lateness.calls(), 1001);
    }
}
