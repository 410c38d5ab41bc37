//! Fault confinement: the error counters of a CAN controller and what they decide.
//!
//! Rules of ISO 11898-1:2015, 12.1.4.2 (the letters are the standard's): TEC and REC are the transmit
//! and the receive error counter.
//!
//! | event | counter |
//! |---|---|
//! | a: a receiver detects an error | REC + 1 |
//! | b: … and sees a dominant bit right after its own flag: it was the first | REC + 8 |
//! | c: a transmitter sends an error flag | TEC + 8 |
//! | c, exception A: it is error-passive, got no acknowledge and sees no dominant bit | – |
//! | c, exception B: a recessive stuff bit of its arbitration is dominant | – |
//! | f: 14 dominant bits from the start of its flag on, and every 8 more | transmitter TEC + 8, receiver REC + 8 |
//! | g: a frame was sent | TEC − 1, not below 0 |
//! | h: a frame was received | REC − 1, not below 0; from above 127 to 119 … 127 |
//!
//! Above 127 a controller is error-passive: its error flags are recessive and disturb nobody, and after a
//! frame of its own it lets others begin ([`SUSPEND_BITS`]). With TEC above 255 it is bus-off: it takes no
//! part until it is told to recover, and has seen [`RECOVERY_SEQUENCES`] times eleven recessive bits.

/// Bits for which an error-passive transmitter stays silent after the interframe space.
pub const SUSPEND_BITS: u32 = 8;

/// Sequences of eleven recessive bits that end a bus-off.
pub const RECOVERY_SEQUENCES: u32 = 128;

/// Recessive bits of one such sequence.
pub const SEQUENCE_BITS: u32 = 11;

/// Above this a counter makes error-passive.
const PASSIVE_ABOVE: u16 = 127;
/// Above this TEC makes bus-off.
const OFF_ABOVE: u16 = 255;
/// Where a successful reception brings a REC above [`PASSIVE_ABOVE`] to; the standard allows 119 to 127.
const RECEIVED_FROM_PASSIVE: u16 = 119;

/// What a controller may do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum State {
    /// Everything; its error flags are dominant.
    #[default]
    Active,
    /// Everything; its error flags are recessive.
    Passive,
    /// Nothing.
    BusOff,
}

/// The error counters of one controller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// TEC.
    pub transmit: u16,
    /// REC.
    pub receive: u16,
}

impl Counters {
    /// What these counters allow.
    #[must_use]
    pub const fn state(self) -> State {
        if self.transmit > OFF_ABOVE {
            State::BusOff
        } else if self.transmit > PASSIVE_ABOVE || self.receive > PASSIVE_ABOVE {
            State::Passive
        } else {
            State::Active
        }
    }

    /// c: its frame was destroyed.
    pub(super) const fn send_failed(&mut self) {
        self.transmit = self.transmit.saturating_add(8);
    }

    /// c with exception A: nobody acknowledged its frame.
    pub(super) const fn not_acknowledged(&mut self) {
        if matches!(self.state(), State::Active) {
            self.send_failed();
        }
    }

    /// a, and b if it was the first to see the error. An error-passive receiver counts on, but there is
    /// no use in counting beyond what makes it passive.
    pub(super) const fn receive_failed(&mut self, first: bool) {
        if self.receive <= PASSIVE_ABOVE {
            self.receive += if first { 9 } else { 1 };
        }
    }

    /// f of a receiver, and b of one that need not have been the first: the level does not end.
    pub(super) const fn held_dominant(&mut self) {
        if self.receive <= PASSIVE_ABOVE {
            self.receive += 8;
        }
    }

    /// g.
    pub(super) const fn sent(&mut self) {
        self.transmit = self.transmit.saturating_sub(1);
    }

    /// h.
    pub(super) const fn received(&mut self) {
        self.receive = if self.receive > PASSIVE_ABOVE {
            RECEIVED_FROM_PASSIVE
        } else {
            self.receive.saturating_sub(1)
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn sixteen_lost_frames_make_passive_and_thirty_two_bus_off() {
        let mut counters = Counters::default();
        let mut states = Vec::new();
        for _ in 0..32 {
            states.push(counters.state());
            counters.send_failed();
        }
        // 8 · 15 = 120 is active still, 8 · 16 = 128 passive; 8 · 31 = 248 passive, 8 · 32 = 256 off
        assert!(states[..16].iter().all(|state| *state == State::Active));
        assert!(states[16..].iter().all(|state| *state == State::Passive));
        assert_eq!(counters.state(), State::BusOff);
    }

    #[test]
    fn who_is_alone_becomes_passive_and_never_bus_off() {
        let mut counters = Counters::default();
        for _ in 0..1000 {
            counters.not_acknowledged();
        }
        assert_eq!((counters.transmit, counters.state()), (128, State::Passive));
    }

    #[test]
    fn a_passive_receiver_is_active_after_one_frame() {
        let mut counters = Counters::default();
        for _ in 0..200 {
            counters.receive_failed(true);
        }
        // nine at a time: 9 · 15 = 135 is the first above 127
        assert_eq!((counters.receive, counters.state()), (135, State::Passive));
        counters.received();
        assert_eq!((counters.receive, counters.state()), (119, State::Active));
    }

    proptest! {
        /// However it goes, a receiver is never bus-off, and success leads back to 0. The greatest: 127 + 9
        /// and 127 + 8.
        #[test]
        fn only_a_transmitter_goes_off(events in proptest::collection::vec(0..5u8, 0..400)) {
            let mut counters = Counters::default();
            for event in events {
                let before = counters;
                match event {
                    0 => counters.receive_failed(false),
                    1 => counters.receive_failed(true),
                    2 => counters.received(),
                    3 => counters.not_acknowledged(),
                    _ => counters.sent(),
                }
                prop_assert!(counters.state() != State::BusOff);
                prop_assert!(counters.receive <= 136 && counters.transmit <= 135);
                prop_assert!(event < 2 || counters.receive <= before.receive);
            }
            for _ in 0..300 {
                counters.sent();
                counters.received();
            }
            prop_assert_eq!(counters, Counters::default());
        }
    }
}
