//! Simulated time beside the wall's: on a hub it waits a little for a SYNC that is late.
//!
//! A hub is TCP between processes. Whoever the operating system lets wait is late without any bus
//! or drive being at fault, and a drive that trips over it would tell of the machine the
//! simulation runs on, not of the robot. So simulated time stands still while a SYNC is overdue, up
//! to a bound; how often and how long is counted. After the bound it goes on, and the drives
//! react to the silence as drives do.

/// How long simulated time waits for a SYNC, wall time. The arm does not move meanwhile.
pub const PATIENCE_NS: u64 = 200_000_000;

/// How often and how long simulated time stood still.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Held {
    /// How often.
    pub count: u64,
    /// In all, ns.
    pub total_ns: u64,
    /// The longest time, ns.
    pub worst_ns: u64,
}

/// The last SYNC: when, in both times, ns, and how long it has been waited since.
#[derive(Clone, Copy, Debug)]
struct Sync {
    wall: u64,
    sim: u64,
    held: u64,
}

/// Simulated time as a function of the wall's; both in ns, both from the start of the process.
#[derive(Clone, Debug)]
pub struct Clock {
    overdue_ns: Option<u64>,
    lag_ns: u64,
    latest_ns: u64,
    sync: Option<Sync>,
    held: Held,
}

impl Clock {
    /// Simulated time is the wall's.
    #[must_use]
    pub const fn strict() -> Self {
        let held = Held {
            count: 0,
            total_ns: 0,
            worst_ns: 0,
        };
        Self {
            overdue_ns: None,
            lag_ns: 0,
            latest_ns: 0,
            sync: None,
            held,
        }
    }

    /// Simulated time stands still from one and a half periods after a SYNC on, until the next.
    #[must_use]
    pub const fn waiting(period_ns: u64) -> Self {
        let mut clock = Self::strict();
        clock.overdue_ns = Some(period_ns + period_ns / 2);
        clock
    }

    /// Simulated time at `wall_ns`; never goes back.
    pub fn at(&mut self, wall_ns: u64) -> u64 {
        let mut sim_ns = wall_ns.saturating_sub(self.lag_ns);
        if let (Some(overdue_ns), Some(sync)) = (self.overdue_ns, &mut self.sync) {
            let limit_ns = sync.sim + overdue_ns;
            if sim_ns > limit_ns {
                // what lies beyond the bound is not waited for
                let end_ns = wall_ns.min(sync.wall + PATIENCE_NS);
                let hold_ns = (sim_ns - limit_ns).saturating_sub(wall_ns - end_ns);
                if sync.held == 0 && hold_ns > 0 {
                    self.held.count += 1;
                }
                sync.held += hold_ns;
                self.held.total_ns += hold_ns;
                self.held.worst_ns = self.held.worst_ns.max(sync.held);
                self.lag_ns += hold_ns;
                sim_ns -= hold_ns;
                if end_ns < wall_ns {
                    self.sync = None;
                }
            }
        }
        self.latest_ns = self.latest_ns.max(sim_ns);
        self.latest_ns
    }

    /// A SYNC arrived at `wall_ns`.
    pub fn synced(&mut self, wall_ns: u64) {
        let sim_ns = self.at(wall_ns);
        self.sync = Some(Sync {
            wall: wall_ns,
            sim: sim_ns,
            held: 0,
        });
    }

    /// How often and how long it stood still.
    #[must_use]
    pub const fn held(&self) -> Held {
        self.held
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const MS: u64 = 1_000_000;

    #[test]
    fn strict_time_is_the_walls() {
        let mut clock = Clock::strict();
        clock.synced(5 * MS);
        assert_eq!(clock.at(500 * MS), 500 * MS);
        assert_eq!(clock.held(), Held::default());
    }

    #[test]
    fn it_waits_for_a_late_sync_and_says_so() {
        let mut clock = Clock::waiting(2 * MS);
        assert_eq!(clock.at(100 * MS), 100 * MS, "no SYNC was ever heard");
        clock.synced(102 * MS);
        clock.synced(104 * MS);
        assert_eq!(clock.at(106 * MS), 106 * MS);
        assert_eq!(clock.at(107 * MS), 107 * MS);
        assert_eq!(clock.at(110 * MS), 107 * MS);
        assert_eq!(clock.at(120 * MS), 107 * MS);
        clock.synced(121 * MS);
        assert_eq!(clock.at(122 * MS), 108 * MS);
        let held = Held {
            count: 1,
            total_ns: 14 * MS,
            worst_ns: 14 * MS,
        };
        assert_eq!(clock.held(), held);
    }

    #[test]
    fn it_does_not_wait_for_ever() {
        let mut clock = Clock::waiting(2 * MS);
        clock.synced(100 * MS);
        assert_eq!(clock.at(299 * MS), 103 * MS);
        assert_eq!(clock.at(300 * MS), 103 * MS);
        assert_eq!(clock.at(301 * MS), 104 * MS);
        assert_eq!(clock.at(401 * MS), 204 * MS);
        assert_eq!(clock.held().worst_ns, 197 * MS);
    }

    proptest! {
        /// However the wall's time is looked at, simulated time depends on SYNCs only.
        #[test]
        fn looking_changes_nothing(
            gaps in proptest::collection::vec(0..300_u64, 1..20), looks in 1..200_u64,
        ) {
            let (mut one, mut many) = (Clock::waiting(2 * MS), Clock::waiting(2 * MS));
            let (mut wall, mut before) = (0, 0);
            for gap in gaps {
                let next = wall + gap * MS;
                let mut look = wall;
                while look < next {
                    look = (look + looks * MS / 7).min(next);
                    let now = many.at(look);
                    prop_assert!(now >= before && now <= look);
                    before = now;
                }
                wall = next;
                one.synced(wall);
                many.synced(wall);
                prop_assert_eq!(one.at(wall), many.at(wall));
            }
        }
    }
}
