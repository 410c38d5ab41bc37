//! The emergency stop by wire: two contacts that open, debounced, compared, and latched until somebody resets them.
//!
//! ```text
//!            any contact opens                     both closed
//!  Clear ────────────────────────▶ Pressed ─────────────────────▶ AwaitingReset ──▶ Clear
//!    ▲                                │ they differ for 10 ms          ▲   the reset button is pressed
//!    │                                ▼                  both opened,  │
//!    └──── never by itself        Discrepant ────────────then closed───┘
//! ```
//! It begins latched: whoever switches on has to reset. The reset counts by its edge and only while both
//! contacts are closed, so a stuck button resets nothing; what was under way is not resumed (ISO 13850).

use protocol::time::Micros;

/// An input must be read so often in a row before it counts: at a tick of 500 µs within one servo step.
pub const SAMPLES: u8 = 2;
/// Two contacts of one button may differ for so long.
pub const DISCREPANCY: Micros = Micros::from_millis(10);

/// An input without its bouncing.
#[derive(Clone, Copy, Debug)]
pub struct Debounced {
    level: bool,
    others: u8,
}

impl Debounced {
    /// An input of this level.
    #[must_use]
    pub const fn new(level: bool) -> Self {
        Self { level, others: 0 }
    }

    /// The level, this sample included.
    pub fn sample(&mut self, raw: bool) -> bool {
        if raw == self.level {
            self.others = 0;
        } else {
            self.others = self.others.saturating_add(1);
            if self.others >= SAMPLES {
                self.level = raw;
                self.others = 0;
            }
        }
        self.level
    }
}

/// What the wires say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wires {
    /// The first contact is closed.
    pub first_closed: bool,
    /// The second contact is closed.
    pub second_closed: bool,
    /// The reset button is pressed.
    pub reset: bool,
}

/// Whether one may move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Emergency {
    /// One may.
    Clear,
    /// A contact is open.
    Pressed,
    /// The contacts differed for too long: one of them, or its wire, is broken.
    Discrepant,
    /// Both contacts are closed again; nobody has reset yet.
    AwaitingReset,
}

/// The two contacts and the reset button.
#[derive(Clone, Copy, Debug)]
pub struct EmergencyStop {
    first: Debounced,
    second: Debounced,
    reset: Debounced,
    reset_was: bool,
    /// Since when the contacts differ.
    differ: Option<Micros>,
    /// Both were open since the discrepancy.
    both_opened: bool,
    state: Emergency,
}

impl Default for EmergencyStop {
    fn default() -> Self {
        Self {
            first: Debounced::new(true),
            second: Debounced::new(true),
            // pressed: one that hangs from the start has no edge
            reset: Debounced::new(true),
            reset_was: true,
            differ: None,
            both_opened: false,
            state: Emergency::AwaitingReset,
        }
    }
}

impl EmergencyStop {
    /// Takes a sample of the wires: at every tick.
    pub fn sample(&mut self, now: Micros, wires: Wires) -> Emergency {
        let first = self.first.sample(wires.first_closed);
        let second = self.second.sample(wires.second_closed);
        let reset = self.reset.sample(wires.reset);
        let edge = reset && !self.reset_was;
        self.reset_was = reset;
        let too_long = if first == second {
            self.differ = None;
            false
        } else {
            let since = *self.differ.get_or_insert(now);
            now.since(since) > DISCREPANCY
        };
        let (closed, open) = (first && second, !first && !second);
        self.state = match self.state {
            _ if too_long => {
                self.both_opened = false;
                Emergency::Discrepant
            }
            Emergency::Discrepant => {
                self.both_opened |= open;
                if self.both_opened && closed {
                    Emergency::AwaitingReset
                } else {
                    Emergency::Discrepant
                }
            }
            Emergency::Pressed if closed => Emergency::AwaitingReset,
            Emergency::AwaitingReset if closed && edge => Emergency::Clear,
            Emergency::Clear | Emergency::AwaitingReset if !closed => Emergency::Pressed,
            same @ (Emergency::Clear | Emergency::Pressed | Emergency::AwaitingReset) => same,
        };
        self.state
    }

    /// The state as of the last sample.
    #[must_use]
    pub const fn state(&self) -> Emergency {
        self.state
    }
}

#[cfg(test)]
mod test {
    use super::*;
    use proptest::prelude::*;

    struct Button {
        stop: EmergencyStop,
        now: u64,
    }

    impl Button {
        fn new() -> Self {
            Self {
                stop: EmergencyStop::default(),
                now: 0,
            }
        }

        /// So many ticks of 500 µs.
        fn ticks(&mut self, count: u32, first: bool, second: bool, reset: bool) -> Emergency {
            for _ in 0..count {
                self.now += 500;
                let wires = Wires {
                    first_closed: first,
                    second_closed: second,
                    reset,
                };
                let _ = self.stop.sample(Micros(self.now), wires);
            }
            self.stop.state()
        }

        fn cleared() -> Self {
            let mut button = Self::new();
            assert_eq!(button.ticks(5, true, true, false), Emergency::AwaitingReset);
            assert_eq!(button.ticks(5, true, true, true), Emergency::Clear);
            assert_eq!(button.ticks(5, true, true, false), Emergency::Clear);
            button
        }
    }

    #[test]
    fn it_begins_latched_and_a_reset_that_hangs_is_no_edge() {
        let mut button = Button::new();
        assert_eq!(button.stop.state(), Emergency::AwaitingReset);
        assert_eq!(
            button.ticks(100, true, true, true),
            Emergency::AwaitingReset
        );
        assert_eq!(button.ticks(5, true, true, false), Emergency::AwaitingReset);
        assert_eq!(button.ticks(5, true, true, true), Emergency::Clear);
    }

    #[test]
    fn either_contact_stops_within_two_samples_and_one_sample_is_noise() {
        for (first, second) in [(false, true), (true, false), (false, false)] {
            let mut button = Button::cleared();
            assert_eq!(button.ticks(1, first, second, false), Emergency::Clear);
            assert_eq!(button.ticks(1, true, true, false), Emergency::Clear);
            assert_eq!(button.ticks(1, first, second, false), Emergency::Clear);
            assert_eq!(button.ticks(1, first, second, false), Emergency::Pressed);
        }
    }

    #[test]
    fn nothing_but_a_new_press_of_the_reset_with_both_contacts_closed_clears_it() {
        let mut button = Button::cleared();
        assert_eq!(button.ticks(5, false, false, false), Emergency::Pressed);
        // pressed while open, and held
        assert_eq!(button.ticks(50, false, false, true), Emergency::Pressed);
        assert_eq!(button.ticks(50, true, true, true), Emergency::AwaitingReset);
        assert_eq!(button.ticks(5, true, true, false), Emergency::AwaitingReset);
        assert_eq!(button.ticks(5, true, true, true), Emergency::Clear);
    }

    #[test]
    fn contacts_that_differ_for_longer_than_10_ms_are_a_discrepancy() {
        // debounced behind two samples, which is 500 µs from the first to the second; then more than 10 ms
        for (ticks, state) in [(22, Emergency::Pressed), (23, Emergency::Discrepant)] {
            let mut button = Button::cleared();
            assert_eq!(button.ticks(ticks, true, false, false), state, "{ticks}");
        }
        let mut button = Button::cleared();
        let _ = button.ticks(30, true, false, false);
        // the broken contact came back: that proves nothing
        assert_eq!(button.ticks(50, true, true, false), Emergency::Discrepant);
        assert_eq!(button.ticks(5, true, true, true), Emergency::Discrepant);
        // both open, both closed: both work
        assert_eq!(button.ticks(5, false, false, false), Emergency::Discrepant);
        assert_eq!(button.ticks(5, true, true, false), Emergency::AwaitingReset);
        assert_eq!(button.ticks(5, true, true, true), Emergency::Clear);
    }

    proptest! {
        /// Whatever the wires do, it is clear only if a reset was pressed anew since a contact was open, and
        /// never while one has been open for two samples.
        #[test]
        fn it_is_never_clear_while_a_contact_is_open(samples in proptest::collection::vec(any::<[bool; 3]>(), 2..400)) {
            let mut stop = EmergencyStop::default();
            let mut last = [true; 2];
            for (k, [first, second, reset]) in samples.into_iter().enumerate() {
                let now = Micros(500 * k as u64);
                let was = stop.state();
                let state = stop.sample(now, Wires { first_closed: first, second_closed: second, reset });
                let open = !first && !last[0] || !second && !last[1];
                prop_assert!(!(open && state == Emergency::Clear));
                if state == Emergency::Clear && was != Emergency::Clear {
                    prop_assert!(was == Emergency::AwaitingReset);
                }
                last = [first, second];
            }
        }
    }
}
