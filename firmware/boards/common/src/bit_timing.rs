//! Bit times of CAN and CAN FD, from the clock of the controller.
//!
//! A bit is 1 quantum of synchronisation, `before` quanta up to the sample point, and `after` quanta
//! behind it; a quantum is `prescaler` cycles of the controller's clock (ISO 11898-1, 11.3).
//!
//! The rules, and where they come from:
//! - sample point of a CANopen bus: 87.5 %, and within 75 to 90 % from 800 kbit/s on, within 85 to 90 % below
//!   (CiA 301 4.2, table of bit rates);
//! - CAN FD: both phases with the same quantum, the shortest that fits, the jump as wide as the segment behind the
//!   sample point, and the transmitter's delay compensated, its second sample point where the receivers' is (the
//!   design rules of CiA 601-3);
//! - 80 % and 75 % for the two phases of 1 and 5 Mbit/s are ASSUMED: the rules only ask that all participants have
//!   the same.

/// One of the two bit times of a controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Segments {
    /// Cycles of the clock in a quantum, from 1.
    pub prescaler: u16,
    /// Quanta between the synchronisation and the sample point: propagation and first phase.
    pub before: u16,
    /// Quanta behind the sample point: the second phase.
    pub after: u16,
    /// Quanta by which an edge may shift the sample point.
    pub jump: u16,
}

impl Segments {
    /// Quanta of a bit.
    #[must_use]
    pub const fn quanta(&self) -> u32 {
        1 + self.before as u32 + self.after as u32
    }

    /// Where the bit is sampled, per mille of it, rounded down.
    #[must_use]
    pub const fn sample_point(&self) -> u32 {
        (1 + self.before as u32) * 1000 / self.quanta()
    }

    /// Bit rate with this clock, bit/s, rounded down.
    #[must_use]
    pub const fn bit_rate(&self, clock_hz: u32) -> u32 {
        clock_hz / (self.prescaler as u32 * self.quanta())
    }
}

/// The longest segments of a controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Longest {
    /// Of the nominal bit time, and of classical frames.
    pub nominal: Segments,
    /// Of the data phase.
    pub data: Segments,
    /// The greatest offset of the transmitter's second sample point, cycles of the clock.
    pub delay_offset: u16,
}

/// Bosch's `M_CAN`, and so STM32's FDCAN: registers NBTP, DBTP and TDCR.
pub const M_CAN: Longest = Longest {
    nominal: Segments {
        prescaler: 512,
        before: 256,
        after: 128,
        jump: 128,
    },
    data: Segments {
        prescaler: 32,
        before: 32,
        after: 16,
        jump: 16,
    },
    delay_offset: 127,
};

/// The data phase of CAN FD.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DataPhase {
    /// Its bit time.
    pub segments: Segments,
    /// Where the transmitter samples its own bits behind the delay that the controller measures,
    /// cycles of the clock; `None` up to 1 Mbit/s, where it needs none.
    pub delay_offset: Option<u16>,
}

/// Everything about the bits of a bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BitTiming {
    /// Of classical frames, and of the arbitration of CAN FD.
    pub nominal: Segments,
    /// Of CAN FD; `None` on a classical bus.
    pub data: Option<DataPhase>,
}

/// Why a bit rate cannot be had.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimingError {
    /// A bit rate of 0, or a sample point outside 1 to 999 per mille.
    Nonsense,
    /// No quantum that divides both the bit and the clock gives segments that this controller has.
    NoQuantum,
    /// The offset of the second sample point is longer than the controller's, or the quantum longer than
    /// two cycles, with which it does not compensate.
    Delay,
}

impl core::fmt::Display for TimingError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Nonsense => {
                "expected a bit rate above 0 and a sample point of 1 to 999 per mille"
            }
            Self::NoQuantum => {
                "the clock is no multiple of the bit rate that this controller has segments for"
            }
            Self::Delay => "the delay of the transmitter cannot be compensated at this bit rate",
        })
    }
}

impl core::error::Error for TimingError {}

/// A bit rate and where the bit is to be sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rate {
    /// bit/s.
    pub bit_s: u32,
    /// Per mille of the bit.
    pub sample_point: u32,
}

impl Rate {
    /// A CANopen bus: sampled at 87.5 % (CiA 301).
    #[must_use]
    pub const fn canopen(bit_s: u32) -> Self {
        Self {
            bit_s,
            sample_point: 875,
        }
    }

    /// The MP bus, arbitration: 1 Mbit/s, ASSUMED 80 %.
    pub const MP_NOMINAL: Self = Self {
        bit_s: 1_000_000,
        sample_point: 800,
    };
    /// The MP bus, data phase: 5 Mbit/s, ASSUMED 75 %.
    pub const MP_DATA: Self = Self {
        bit_s: 5_000_000,
        sample_point: 750,
    };
}

/// Where CiA 301 allows a CANopen bus of this bit rate to be sampled, per mille.
#[must_use]
pub const fn canopen_range(bit_s: u32) -> (u32, u32) {
    if bit_s >= 800_000 {
        (750, 900)
    } else {
        (850, 900)
    }
}

/// The bit time of this rate with this quantum, if there is one within `longest`.
const fn fit(clock_hz: u32, rate: Rate, prescaler: u16, longest: Segments) -> Option<Segments> {
    let Some(cycles) = rate.bit_s.checked_mul(prescaler as u32) else {
        return None;
    };
    if cycles == 0 || !clock_hz.is_multiple_of(cycles) || prescaler > longest.prescaler {
        return None;
    }
    let quanta = clock_hz / cycles;
    let most = 1 + longest.before as u32 + longest.after as u32;
    if quanta > most {
        return None;
    }
    // the quanta up to the sample point, rounded to the nearest: below 400 · 1000
    let sampled = (quanta * rate.sample_point + 500) / 1000;
    if sampled < 2 || sampled >= quanta {
        return None;
    }
    let (before, after) = (sampled - 1, quanta - sampled);
    if before > longest.before as u32 || after > longest.after as u32 {
        return None;
    }
    // a jump longer than the first phase would begin before the bit
    let jump = if after < before { after } else { before };
    let jump = if jump < longest.jump as u32 {
        jump
    } else {
        longest.jump as u32
    };
    #[expect(
        clippy::cast_possible_truncation,
        reason = "none is longer than in `longest`, which are u16"
    )]
    Some(Segments {
        prescaler,
        before: before as u16,
        after: after as u16,
        jump: jump as u16,
    })
}

const fn checked(rate: Rate) -> bool {
    rate.bit_s > 0 && rate.sample_point > 0 && rate.sample_point < 1000
}

/// The bit time of a classical bus, with the shortest quantum.
///
/// ```
/// use board::bit_timing::{M_CAN, Rate, classic};
/// let timing = classic(170_000_000, Rate::canopen(500_000), &M_CAN).unwrap();
/// assert_eq!((timing.nominal.quanta(), timing.nominal.sample_point()), (170, 876));
/// ```
///
/// # Errors
/// [`TimingError::Nonsense`], [`TimingError::NoQuantum`]
pub const fn classic(
    clock_hz: u32,
    rate: Rate,
    longest: &Longest,
) -> Result<BitTiming, TimingError> {
    if !checked(rate) {
        return Err(TimingError::Nonsense);
    }
    let mut prescaler = 1;
    // bounded by the controller's greatest prescaler
    while prescaler <= longest.nominal.prescaler {
        if let Some(nominal) = fit(clock_hz, rate, prescaler, longest.nominal) {
            return Ok(BitTiming {
                nominal,
                data: None,
            });
        }
        prescaler += 1;
    }
    Err(TimingError::NoQuantum)
}

/// Above this bit rate the transmitter would sample its own bits before they have come back.
const COMPENSATED_ABOVE: u32 = 1_000_000;

/// The bit times of a CAN FD bus: the shortest quantum that both phases have.
///
/// # Errors
/// [`TimingError`]
pub const fn fd(
    clock_hz: u32,
    nominal: Rate,
    data: Rate,
    longest: &Longest,
) -> Result<BitTiming, TimingError> {
    if !checked(nominal) || !checked(data) {
        return Err(TimingError::Nonsense);
    }
    let mut prescaler = 1;
    // bounded by the controller's greatest prescaler
    while prescaler <= longest.data.prescaler {
        let both = (
            fit(clock_hz, nominal, prescaler, longest.nominal),
            fit(clock_hz, data, prescaler, longest.data),
        );
        if let (Some(nominal), Some(segments)) = both {
            let offset = segments.prescaler as u32 * (1 + segments.before as u32);
            let delay_offset = if data.bit_s <= COMPENSATED_ABOVE {
                None
            } else if prescaler > 2 || offset > longest.delay_offset as u32 {
                return Err(TimingError::Delay);
            } else {
                #[expect(clippy::cast_possible_truncation, reason = "compared above")]
                Some(offset as u16)
            };
            return Ok(BitTiming {
                nominal,
                data: Some(DataPhase {
                    segments,
                    delay_offset,
                }),
            });
        }
        prescaler += 1;
    }
    Err(TimingError::NoQuantum)
}

#[cfg(test)]
mod test {
    use super::*;
    use proptest::prelude::*;

    /// Clocks of controllers one can buy.
    const CLOCKS: [u32; 7] = [
        170_000_000,
        160_000_000,
        80_000_000,
        64_000_000,
        48_000_000,
        40_000_000,
        24_000_000,
    ];

    fn checked_segments(segments: Segments, longest: Segments, clock: u32, rate: Rate) {
        assert_eq!(segments.bit_rate(clock), rate.bit_s, "{clock} {segments:?}");
        assert_eq!(
            u64::from(clock),
            u64::from(rate.bit_s) * u64::from(segments.prescaler) * u64::from(segments.quanta()),
            "{clock}: exact, nothing rounded"
        );
        assert!(segments.prescaler >= 1 && segments.prescaler <= longest.prescaler);
        assert!(segments.before >= 1 && segments.before <= longest.before);
        assert!(segments.after >= 1 && segments.after <= longest.after);
        assert!(segments.jump >= 1 && segments.jump <= longest.jump);
        assert!(segments.jump <= segments.after && segments.jump <= segments.before);
        // half a quantum, rounded down to a per mille
        let off = segments.sample_point().abs_diff(rate.sample_point);
        assert!(off <= 500 / segments.quanta() + 1, "{clock} {segments:?}");
    }

    #[test]
    fn canopen_buses_are_sampled_where_cia_301_says() {
        for clock in CLOCKS {
            for bit_s in [1_000_000, 500_000, 250_000, 125_000, 50_000] {
                let rate = Rate::canopen(bit_s);
                let timing = classic(clock, rate, &M_CAN).unwrap();
                checked_segments(timing.nominal, M_CAN.nominal, clock, rate);
                let (low, high) = canopen_range(bit_s);
                let at = timing.nominal.sample_point();
                assert!(low <= at && at <= high, "{clock} {bit_s}: {at}");
                assert_eq!(timing.data, None);
            }
        }
    }

    #[test]
    fn the_nucleos_numbers_are_these() {
        let clock = 170_000_000;
        let segments = |bit_s| {
            classic(clock, Rate::canopen(bit_s), &M_CAN)
                .unwrap()
                .nominal
        };
        // by hand: 170 MHz / 1 Mbit/s = 170 quanta, 87.5 % of them are 148.75: 149 = 1 + 148
        let one = Segments {
            prescaler: 1,
            before: 148,
            after: 21,
            jump: 21,
        };
        assert_eq!(segments(1_000_000), one);
        // 340 cycles: with a quantum of one, 297 before would not fit 256
        assert_eq!(
            segments(500_000),
            Segments {
                prescaler: 2,
                ..one
            }
        );
        let timing = fd(clock, Rate::MP_NOMINAL, Rate::MP_DATA, &M_CAN).unwrap();
        assert_eq!(
            timing,
            BitTiming {
                // 80 % of 170 are 136
                nominal: Segments {
                    prescaler: 1,
                    before: 135,
                    after: 34,
                    jump: 34
                },
                data: Some(DataPhase {
                    // 75 % of 34 are 25.5, rounded up: 26 = 1 + 25
                    segments: Segments {
                        prescaler: 1,
                        before: 25,
                        after: 8,
                        jump: 8
                    },
                    delay_offset: Some(26),
                }),
            }
        );
    }

    #[test]
    fn both_phases_of_can_fd_have_one_quantum_and_the_delay_is_compensated() {
        for clock in CLOCKS {
            for data in [
                Rate::MP_DATA,
                Rate {
                    bit_s: 2_000_000,
                    ..Rate::MP_DATA
                },
            ] {
                let timing = match (clock, data.bit_s, fd(clock, Rate::MP_NOMINAL, data, &M_CAN)) {
                    (_, _, Ok(timing)) => timing,
                    // 5 Mbit/s is no part of these
                    (64_000_000 | 48_000_000 | 24_000_000, 5_000_000, Err(error)) => {
                        assert_eq!(error, TimingError::NoQuantum);
                        continue;
                    }
                    // 85 cycles of 170 MHz: more quanta than there are, and as 17 of 5 cycles not compensated
                    (170_000_000, 2_000_000, Err(error)) => {
                        assert_eq!(error, TimingError::Delay);
                        continue;
                    }
                    other => panic!("{other:?}"),
                };
                let phase = timing.data.unwrap();
                checked_segments(timing.nominal, M_CAN.nominal, clock, Rate::MP_NOMINAL);
                checked_segments(phase.segments, M_CAN.data, clock, data);
                assert_eq!(timing.nominal.prescaler, phase.segments.prescaler);
                // the second sample point is where a receiver samples: cycles up to it
                let sampled = phase.segments.prescaler * (1 + phase.segments.before);
                assert_eq!(phase.delay_offset, Some(sampled), "{clock}");
            }
        }
        let slow = Rate {
            bit_s: 1_000_000,
            ..Rate::MP_DATA
        };
        let timing = fd(40_000_000, Rate::MP_NOMINAL, slow, &M_CAN).unwrap();
        assert_eq!(timing.data.unwrap().delay_offset, None);
    }

    #[test]
    fn what_cannot_be_had_is_an_error() {
        let wrong = [
            (
                Rate {
                    bit_s: 0,
                    sample_point: 875,
                },
                TimingError::Nonsense,
            ),
            (
                Rate {
                    bit_s: 500_000,
                    sample_point: 0,
                },
                TimingError::Nonsense,
            ),
            (
                Rate {
                    bit_s: 500_000,
                    sample_point: 1000,
                },
                TimingError::Nonsense,
            ),
            (Rate::canopen(7_000_000), TimingError::NoQuantum),
            (Rate::canopen(300), TimingError::NoQuantum),
            (Rate::canopen(u32::MAX), TimingError::NoQuantum),
        ];
        for (rate, error) in wrong {
            assert_eq!(classic(170_000_000, rate, &M_CAN), Err(error), "{rate:?}");
            assert_eq!(fd(170_000_000, Rate::MP_NOMINAL, rate, &M_CAN), Err(error));
            assert_eq!(fd(170_000_000, rate, Rate::MP_DATA, &M_CAN), Err(error));
        }
        assert_eq!(
            classic(0, Rate::canopen(500_000), &M_CAN),
            Err(TimingError::NoQuantum)
        );
        let short = Longest {
            delay_offset: 25,
            ..M_CAN
        };
        assert_eq!(
            fd(170_000_000, Rate::MP_NOMINAL, Rate::MP_DATA, &short),
            Err(TimingError::Delay)
        );
    }

    proptest! {
        #[test]
        fn whatever_is_found_is_exact_and_within_the_controllers_segments(
            clock in 1_u32..200_000_000, bit_s in 1_u32..10_000_000, sample_point in 1_u32..1000,
        ) {
            let rate = Rate { bit_s, sample_point };
            // clocks that are multiples, else almost nothing would be found
            let clock = clock / bit_s * bit_s;
            if let Ok(timing) = classic(clock, rate, &M_CAN) {
                checked_segments(timing.nominal, M_CAN.nominal, clock, rate);
            }
        }
    }
}
