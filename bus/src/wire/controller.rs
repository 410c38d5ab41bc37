//! The CAN controller of a tap: does it take part, and from when on?

use super::confinement::{Counters, RECOVERY_SEQUENCES, SEQUENCE_BITS, State};

/// A bus-off controller that was told to recover.
#[derive(Clone, Copy, Debug)]
struct Recovery {
    /// Sequences of recessive bits still to be seen …
    remaining: u32,
    /// … from here on, as long as nobody sends.
    since_ns: u64,
}

/// One controller.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Controller {
    pub(super) counters: Counters,
    pub(super) detached: bool,
    /// It is on the other side of a cut.
    pub(super) cut: bool,
    /// It lets others begin until then.
    pub(super) silent_until_ns: u64,
    recovery: Option<Recovery>,
}

impl Controller {
    /// From when on it takes part if nobody sends before; `None`: not by itself.
    pub(super) fn takes_part_from(&self, bit_ns: u64) -> Option<u64> {
        if self.detached || self.cut {
            return None;
        }
        match (self.counters.state(), self.recovery) {
            (State::BusOff, None) => None,
            (State::BusOff, Some(recovery)) => Some(recovery.end_ns(bit_ns)),
            _ => Some(0),
        }
    }

    /// May it begin to send at `at_ns`?
    pub(super) fn may_begin(&self, at_ns: u64, bit_ns: u64) -> bool {
        let takes_part = self
            .takes_part_from(bit_ns)
            .is_some_and(|from| from <= at_ns);
        self.silent_until_ns <= at_ns && takes_part
    }

    /// Does it take part now?
    pub(super) const fn takes_part(&self) -> bool {
        !self.detached && !self.cut && !matches!(self.counters.state(), State::BusOff)
    }

    /// It has nothing to do with errors.
    pub(super) fn is_plain(&self) -> bool {
        !self.detached
            && !self.cut
            && self.counters == Counters::default()
            && self.silent_until_ns == 0
    }

    /// Told to recover; without effect if it is not bus-off, or recovers already.
    pub(super) fn recover(&mut self, now_ns: u64) {
        if self.counters.state() == State::BusOff && self.recovery.is_none() {
            self.recovery = Some(Recovery {
                remaining: RECOVERY_SEQUENCES,
                since_ns: now_ns,
            });
        }
    }

    /// The bus has been idle until now.
    pub(super) fn idle_until(&mut self, now_ns: u64, bit_ns: u64) {
        let Some(recovery) = &mut self.recovery else {
            return;
        };
        if recovery.end_ns(bit_ns) <= now_ns {
            self.counters = Counters::default();
            self.recovery = None;
        }
    }

    /// Somebody begins to send.
    pub(super) fn begun(&mut self, now_ns: u64, bit_ns: u64) {
        self.idle_until(now_ns, bit_ns);
        if let Some(recovery) = &mut self.recovery {
            let seen = now_ns.saturating_sub(recovery.since_ns) / sequence_ns(bit_ns);
            let seen = u32::try_from(seen).unwrap_or(u32::MAX);
            recovery.remaining = recovery.remaining.saturating_sub(seen);
        }
    }

    /// The bus was dominant until now: recessive bits are counted from here on.
    pub(super) const fn released(&mut self, now_ns: u64) {
        if let Some(recovery) = &mut self.recovery {
            recovery.since_ns = now_ns;
        }
    }

    /// A frame or an error frame has ended: with a delimiter, end of frame or not, and the interframe
    /// space, which are eleven recessive bits.
    pub(super) fn ended(&mut self, now_ns: u64, bit_ns: u64) {
        if let Some(recovery) = &mut self.recovery {
            recovery.remaining = recovery.remaining.saturating_sub(1);
            recovery.since_ns = now_ns;
        }
        self.idle_until(now_ns, bit_ns);
    }
}

impl Recovery {
    const fn end_ns(&self, bit_ns: u64) -> u64 {
        let left = sequence_ns(bit_ns).saturating_mul(self.remaining as u64);
        self.since_ns.saturating_add(left)
    }
}

const fn sequence_ns(bit_ns: u64) -> u64 {
    bit_ns.saturating_mul(SEQUENCE_BITS as u64)
}
