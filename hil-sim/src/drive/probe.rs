//! Touch probe 1 on the encoder's zero impulse: latches the position at the index.

use protocol::canopen::cia402::probe;

/// The touch probe: function and what was latched, in encoder counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Probe {
    function: u16,
    positive: Option<i64>,
    negative: Option<i64>,
}

impl Probe {
    /// Takes a new function word: switching the probe on forgets what was latched.
    pub(crate) const fn set_function(&mut self, function: u16) {
        let on = function & probe::ENABLE != 0;
        let was_on = self.function & probe::ENABLE != 0;
        if !on || !was_on {
            (self.positive, self.negative) = (None, None);
        }
        self.function = function;
    }

    /// The index passed at `count`: did the status change?
    pub(crate) fn on_index(&mut self, count: i64) -> bool {
        let wanted = probe::ENABLE | probe::ZERO_IMPULSE;
        if self.function & wanted != wanted {
            return false;
        }
        let before = self.status();
        let again = self.function & probe::CONTINUOUS != 0;
        // The ideal pulse has no width: both edges lie at the same count.
        if self.function & probe::POSITIVE_EDGE != 0 && (again || self.positive.is_none()) {
            self.positive = Some(count);
        }
        if self.function & probe::NEGATIVE_EDGE != 0 && (again || self.negative.is_none()) {
            self.negative = Some(count);
        }
        self.status() != before
    }

    /// Object 60B9.
    pub(crate) const fn status(&self) -> u16 {
        let mut status = 0;
        if self.function & probe::ENABLE != 0 {
            status |= probe::ENABLED;
        }
        if self.positive.is_some() {
            status |= probe::POSITIVE_STORED;
        }
        if self.negative.is_some() {
            status |= probe::NEGATIVE_STORED;
        }
        status
    }

    /// The counts latched at the positive and the negative edge.
    pub(crate) const fn latched(&self) -> (Option<i64>, Option<i64>) {
        (self.positive, self.negative)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_shot_keeps_the_first_index() {
        let mut p = Probe::default();
        assert!(!p.on_index(1), "off");
        p.set_function(probe::INDEX_ONCE);
        assert_eq!(p.status(), probe::ENABLED);
        assert!(p.on_index(10));
        assert!(!p.on_index(20));
        assert_eq!(p.latched(), (Some(10), None));
        p.set_function(0);
        assert_eq!((p.status(), p.latched()), (0, (None, None)));
    }

    #[test]
    fn continuous_takes_every_index_and_both_edges() {
        let mut p = Probe::default();
        p.set_function(probe::INDEX_ONCE | probe::CONTINUOUS | probe::NEGATIVE_EDGE);
        p.on_index(10);
        p.on_index(20);
        assert_eq!(p.latched(), (Some(20), Some(20)));
        assert_eq!(p.status(), 7);
    }

    #[test]
    fn without_the_zero_impulse_as_source_nothing_is_latched() {
        let mut p = Probe::default();
        p.set_function(probe::ENABLE | probe::POSITIVE_EDGE);
        assert!(!p.on_index(10));
    }
}
