//! Safe torque off and the brake: which of two outputs is on, in which order, and how long one waits for the other.
//!
//! ```text
//!                 safe torque off released   brake released
//!  Locked                  no                     no
//!  Braked                  yes                    no        torque is allowed, the brake still holds
//!  Open                    yes                    yes
//!  Locked -> Braked at once, Braked -> Open after `opens_after`: the drives hold before the brake lets go.
//!  Open -> Braked at once,   Braked -> Locked after `closes_within`: the brake holds before the drives let go.
//!  any -> Locked at once when torque must go at once (R3, stop category 0).
//! ```

use protocol::message::NodeState;
use protocol::time::Micros;

/// What the outputs may be at most.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Permit {
    /// No torque, and the brake closed.
    Locked,
    /// The drives may have torque; the brake stays closed.
    Braked,
    /// The brake may be open.
    Open,
}

impl Permit {
    /// What a node in this state needs. With a latched fault the brake closes: what stands stays standing, whether the
    /// node keeps its torque (R1) or not (R2, R3).
    #[must_use]
    pub const fn of(state: NodeState) -> Self {
        match state {
            NodeState::Boot | NodeState::Configuring => Self::Locked,
            NodeState::Disabled | NodeState::Enabling | NodeState::Faulted => Self::Braked,
            NodeState::Unsynchronised
            | NodeState::Synchronising
            | NodeState::Holding
            | NodeState::Moving
            | NodeState::Stopping => Self::Open,
        }
    }
}

/// How long the one waits for the other, µs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Delays {
    /// From torque allowed to the brake opening: the drives hold by then.
    pub opens_after: u32,
    /// From the brake told to close to torque off: its data sheet's closing time, and some more.
    pub closes_within: u32,
}

/// The outputs: what is off without current is `false`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Outputs {
    /// Safe torque off is released.
    pub torque: bool,
    /// The brake is open.
    pub brake: bool,
}

/// The sequence.
#[derive(Clone, Copy, Debug)]
pub struct Torque {
    delays: Delays,
    outputs: Outputs,
    /// Since when the outputs are as they are.
    since: Micros,
}

impl Torque {
    /// Locked.
    #[must_use]
    pub const fn new(now: Micros, delays: Delays) -> Self {
        Self {
            delays,
            outputs: Outputs {
                torque: false,
                brake: false,
            },
            since: now,
        }
    }

    /// The outputs from now on; to be asked every tick. `at_once`: torque off without waiting for the brake.
    pub fn step(&mut self, now: Micros, permit: Permit, at_once: bool) -> Outputs {
        let waited = now.since(self.since).0;
        let Outputs { torque, brake } = self.outputs;
        let next = if at_once {
            Outputs::default()
        } else {
            match permit {
                Permit::Locked => Outputs {
                    torque: torque && (brake || waited < u64::from(self.delays.closes_within)),
                    brake: false,
                },
                Permit::Braked => Outputs {
                    torque: true,
                    brake: false,
                },
                Permit::Open => Outputs {
                    torque: true,
                    brake: torque && (brake || waited >= u64::from(self.delays.opens_after)),
                },
            }
        };
        if next != self.outputs {
            self.outputs = next;
            self.since = now;
        }
        next
    }

    /// The outputs as they are.
    #[must_use]
    pub const fn outputs(&self) -> Outputs {
        self.outputs
    }
}

#[cfg(test)]
mod test {
    use super::*;
    use proptest::prelude::*;

    const DELAYS: Delays = Delays {
        opens_after: 20_000,
        closes_within: 80_000,
    };
    const OFF: Outputs = Outputs {
        torque: false,
        brake: false,
    };
    const BRAKED: Outputs = Outputs {
        torque: true,
        brake: false,
    };
    const OPEN: Outputs = Outputs {
        torque: true,
        brake: true,
    };

    /// When, in ticks of 500 µs from `from`, the outputs become this.
    fn until(torque: &mut Torque, from: u64, permit: Permit, wanted: Outputs) -> u64 {
        (from..from + 1_000_000)
            .step_by(500)
            .find(|us| torque.step(Micros(*us), permit, false) == wanted)
            .unwrap()
            - from
    }

    #[test]
    fn torque_comes_before_the_brake_opens_and_goes_after_it_has_closed() {
        let mut torque = Torque::new(Micros(0), DELAYS);
        assert_eq!(torque.step(Micros(0), Permit::Locked, false), OFF);
        assert_eq!(until(&mut torque, 500, Permit::Open, BRAKED), 0);
        assert_eq!(until(&mut torque, 500, Permit::Open, OPEN), 20_000);
        assert_eq!(until(&mut torque, 30_000, Permit::Locked, BRAKED), 0);
        assert_eq!(until(&mut torque, 30_000, Permit::Locked, OFF), 80_000);
    }

    #[test]
    fn torque_goes_at_once_when_it_must() {
        let mut torque = Torque::new(Micros(0), DELAYS);
        let _ = torque.step(Micros(0), Permit::Open, false);
        assert_eq!(torque.step(Micros(20_000), Permit::Open, false), OPEN);
        assert_eq!(torque.step(Micros(20_500), Permit::Open, true), OFF);
        // and while it must, nothing comes back
        assert_eq!(torque.step(Micros(900_000), Permit::Open, true), OFF);
        assert_eq!(torque.step(Micros(900_500), Permit::Open, false), BRAKED);
    }

    #[test]
    fn a_faulted_node_keeps_its_torque_behind_a_closed_brake() {
        let mut torque = Torque::new(Micros(0), DELAYS);
        let _ = torque.step(Micros(0), Permit::Open, false);
        let _ = torque.step(Micros(20_000), Permit::Open, false);
        let faulted = Permit::of(NodeState::Faulted);
        for us in [20_500, 200_000, 5_000_000] {
            assert_eq!(torque.step(Micros(us), faulted, false), BRAKED);
        }
    }

    #[test]
    fn every_state_that_moves_or_holds_has_an_open_brake_and_no_other() {
        use NodeState as S;
        for (state, permit) in [
            (S::Boot, Permit::Locked),
            (S::Configuring, Permit::Locked),
            (S::Disabled, Permit::Braked),
            (S::Enabling, Permit::Braked),
            (S::Unsynchronised, Permit::Open),
            (S::Synchronising, Permit::Open),
            (S::Holding, Permit::Open),
            (S::Moving, Permit::Open),
            (S::Stopping, Permit::Open),
            (S::Faulted, Permit::Braked),
        ] {
            assert_eq!(Permit::of(state), permit, "{state:?}");
        }
    }

    proptest! {
        /// Whatever is asked when: the brake is never open without torque; it opens only `opens_after` behind torque;
        /// torque goes only `closes_within` behind the brake, or because it must.
        #[test]
        fn the_order_is_always_kept(asked in proptest::collection::vec((0_u8..3, 0_u8..10, 1_u64..50_000), 1..300)) {
            let mut torque = Torque::new(Micros(0), DELAYS);
            let (mut now, mut torque_since, mut braked_since) = (0, 0, 0);
            let mut was = OFF;
            for (permit, at_once, passed) in asked {
                now += passed;
                let permit = [Permit::Locked, Permit::Braked, Permit::Open][usize::from(permit)];
                let at_once = at_once == 0;
                let is = torque.step(Micros(now), permit, at_once);
                prop_assert!(is.torque || !is.brake);
                if is.torque && !was.torque { torque_since = now; }
                if !is.brake && was.brake { braked_since = now; }
                if is.brake && !was.brake { prop_assert!(now - torque_since >= 20_000); }
                if was.torque && !is.torque && !at_once {
                    prop_assert!(!was.brake && now - braked_since >= 80_000 || braked_since == 0);
                }
                prop_assert!(!at_once || is == OFF);
                was = is;
            }
        }
    }
}
