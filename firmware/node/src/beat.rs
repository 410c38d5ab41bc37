//! The node's time: exact instants for the node, whatever the operating system does.
//!
//! The node computes its set-points for the instant it is told, so it is told the one it asked for
//! and not the one at which the process happened to run: jitter of the process is not jitter of
//! the path. After an overrun the node's time lags behind the wall's instead of leaving set-points
//! out, since a step over the gap would break the limits; the lag is made good slowly.

use protocol::time::Micros;

/// Of every step, one part in so many is taken from the lag: 5 ms are made good in 0.25 s.
const RECOVERY: u64 = 50;

/// The relation of the node's time to the wall's.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Beat {
    step: Micros,
    lag: Micros,
    worst: Micros,
}

impl Beat {
    /// No lag; the node is called once in `step`, and a call later than that is an overrun.
    pub(crate) const fn new(step: Micros) -> Self {
        Self {
            step,
            lag: Micros(0),
            worst: Micros(0),
        }
    }

    /// When the instant `due` of the node comes, wall time.
    pub(crate) fn wall(&self, due: Micros) -> Micros {
        due + self.lag
    }

    /// The instant of the node at which something happened at `wall`.
    pub(crate) const fn node(&self, wall: Micros) -> Micros {
        wall.since(self.lag)
    }

    /// The node is called for `due` at `wall`.
    pub(crate) fn called(&mut self, due: Micros, wall: Micros) {
        if wall.since(self.wall(due)) > self.step {
            self.lag = wall.since(due);
            self.worst = self.worst.max(self.lag);
        } else {
            self.lag = self.lag.since(Micros(self.step.0 / RECOVERY));
        }
    }

    /// The greatest lag so far.
    pub(crate) const fn worst(&self) -> Micros {
        self.worst
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jitter_leaves_no_lag() {
        let mut beat = Beat::new(Micros(1000));
        for k in 0..1000 {
            let due = Micros(k * 1000);
            beat.called(due, Micros(due.0 + k % 1000));
            assert_eq!(beat.wall(due), due);
        }
        assert_eq!(beat.worst(), Micros(0));
    }

    #[test]
    fn an_overrun_is_a_lag_that_is_made_good() {
        let mut beat = Beat::new(Micros(1000));
        beat.called(Micros(10_000), Micros(15_000));
        assert_eq!(beat.wall(Micros(11_000)), Micros(16_000));
        assert_eq!(beat.node(Micros(16_000)), Micros(11_000));
        let mut wall = Micros(15_000);
        for k in 1..=250 {
            let due = Micros(10_000 + k * 1000);
            let next = beat.wall(due);
            // 1000 µs less the fiftieth that is made good, but for the step after the overrun
            let span = next.since(wall).0;
            assert!(span == 980 || k == 1 && span == 1000, "{k}: {span}");
            wall = next;
            beat.called(due, wall);
        }
        assert_eq!(beat.node(wall), wall);
        assert_eq!(beat.worst(), Micros(5000));
    }
}
