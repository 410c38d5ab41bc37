//! The node's microseconds from counters that wrap around.
//!
//! A board has one free-running counter of 32 bits, 1 µs a count, and its CAN controllers stamp frames with the
//! lowest 16 bits of the same time.

use protocol::budget::{Rates, exact};
use protocol::frame::Frame;
use protocol::time::Micros;

/// A stamp may be so much ahead of the counter that was read behind it: two timers started one after the other.
const AHEAD: u16 = 16;

/// The counter, extended to 64 bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TimeBase {
    now: u64,
}

impl TimeBase {
    /// The time of this count. To be asked more often than the counter wraps around, every 71 minutes; a count
    /// that seems to lie behind the last one by less than half of that does not turn the time back.
    pub const fn at(&mut self, counter: u32) -> Micros {
        #[expect(
            clippy::cast_possible_truncation,
            reason = "the lowest 32 bits are meant"
        )]
        let passed = counter.wrapping_sub(self.now as u32);
        if passed < u32::MAX / 2 {
            self.now = self.now.saturating_add(passed as u64);
        }
        Micros(self.now)
    }
}

/// When a frame with this stamp began, if that was within 65 ms before `now`.
#[must_use]
pub const fn stamped(now: Micros, stamp: u16) -> Micros {
    #[expect(
        clippy::cast_possible_truncation,
        reason = "the lowest 16 bits are meant"
    )]
    let age = (now.0 as u16).wrapping_sub(stamp);
    let ahead = age.wrapping_neg();
    if ahead < AHEAD {
        Micros(now.0.saturating_add(ahead as u64))
    } else {
        Micros(now.0.saturating_sub(age as u64))
    }
}

/// When this frame ended, which began at `began`: controllers stamp the start of a frame, the clock synchronisation
/// of the MP bus and every host speak of its end. To 1 µs.
#[must_use]
pub fn ended(began: Micros, frame: &Frame, rates: Rates) -> Micros {
    Micros(
        began
            .0
            .saturating_add(rates.duration_ns(exact(frame)) / 1000),
    )
}

/// How evenly something comes that should come once a period: SYNC.
#[derive(Clone, Copy, Debug)]
pub struct Beat {
    period: Micros,
    last: Option<Micros>,
    worst: u32,
}

impl Beat {
    /// Of this period.
    #[must_use]
    pub const fn new(period: Micros) -> Self {
        Self {
            period,
            last: None,
            worst: 0,
        }
    }

    /// It came.
    pub fn heard(&mut self, at: Micros) {
        if let Some(last) = self.last {
            let off = at.since(last).0.abs_diff(self.period.0);
            let off = u32::try_from(off).unwrap_or(u32::MAX);
            if off > self.worst {
                self.worst = off;
            }
        }
        self.last = Some(at);
    }

    /// By how much the worst period differed since this was asked the last time, µs.
    pub const fn worst(&mut self) -> u32 {
        core::mem::replace(&mut self.worst, 0)
    }
}

#[cfg(test)]
#[expect(
    clippy::cast_possible_truncation,
    reason = "counters have lost their higher bits"
)]
mod test {
    use super::*;
    use proptest::prelude::*;
    use protocol::frame::Id;

    #[test]
    fn the_time_goes_on_where_the_counter_wraps() {
        let mut base = TimeBase::default();
        let mut true_time = 0_u64;
        for _ in 0..10_000 {
            // 2.1 s steps: the counter wraps five times
            true_time += 2_100_007;
            assert_eq!(base.at(true_time as u32), Micros(true_time));
        }
        assert!(true_time > 4 * u64::from(u32::MAX));
    }

    #[test]
    fn the_time_never_turns_back() {
        let mut base = TimeBase::default();
        assert_eq!(base.at(1000), Micros(1000));
        // read before, asked behind: by an interrupt between
        assert_eq!(base.at(998), Micros(1000));
        assert_eq!(base.at(1001), Micros(1001));
    }

    proptest! {
        #[test]
        fn a_stamp_of_the_last_65_ms_is_that_instant(now in 70_000_u64.., age in 0_u64..65_520) {
            let began = now - age;
            prop_assert_eq!(stamped(Micros(now), began as u16), Micros(began));
        }

        #[test]
        fn a_stamp_that_is_just_ahead_is_ahead(now in 0..u64::MAX - 20, ahead in 0_u64..16) {
            prop_assert_eq!(stamped(Micros(now), (now + ahead) as u16), Micros(now + ahead));
        }
    }

    #[test]
    fn a_frame_ends_when_its_bits_are_sent() {
        let frame = Frame::classic(Id::Standard(0x555), &[0x55; 8]).unwrap();
        // alternating bits: hardly any stuffing, at least the 111 bits that every such frame has, at most 135
        let end = ended(Micros(1000), &frame, Rates::CLASSIC_1M);
        assert!((1111..1135).contains(&end.0), "{end:?}");
    }

    #[test]
    fn the_worst_period_is_told_once() {
        let mut beat = Beat::new(Micros(2000));
        for at in [5, 2005, 4006, 5999, 8006] {
            beat.heard(Micros(at));
        }
        // 1993 and 2007 are off by 7
        assert_eq!((beat.worst(), beat.worst()), (7, 0));
        beat.heard(Micros(10_004));
        assert_eq!(beat.worst(), 2);
    }
}
