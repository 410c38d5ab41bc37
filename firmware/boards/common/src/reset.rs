//! Why the board was reset, and what is remembered of it over the next resets.

use crate::alive::Token;
pub use protocol::maintenance::ResetCause;
use protocol::message::NodeState;

/// The causes of which a chip tells: the others are a host's.
const CAUSES: [ResetCause; 6] = [
    ResetCause::Unknown,
    ResetCause::PowerOn,
    ResetCause::Pin,
    ResetCause::Software,
    ResetCause::Watchdog,
    ResetCause::Option,
];

/// From `RCC_CSR` of an STM32 of the families G0, G4, L4, WB, as it was at the start (RM0440, 7.4.29): clear it by `RMVF`
/// afterwards.
///
/// Every reset pulls the pin, so its flag says something only alone; and flags of several resets may have gathered, of
/// which power is the oldest. A supply that sagged has the same flag as one that was switched on.
#[must_use]
pub const fn cause_of_rcc_csr(csr: u32) -> ResetCause {
    const LOW_POWER: u32 = 1 << 31;
    const WINDOW_WATCHDOG: u32 = 1 << 30;
    const INDEPENDENT_WATCHDOG: u32 = 1 << 29;
    const SOFTWARE: u32 = 1 << 28;
    const BROWN_OUT: u32 = 1 << 27;
    const PIN: u32 = 1 << 26;
    const OPTION_BYTES: u32 = 1 << 25;
    if csr & BROWN_OUT != 0 {
        ResetCause::PowerOn
    } else if csr & (WINDOW_WATCHDOG | INDEPENDENT_WATCHDOG) != 0 {
        ResetCause::Watchdog
    } else if csr & SOFTWARE != 0 {
        ResetCause::Software
    } else if csr & (LOW_POWER | OPTION_BYTES) != 0 {
        ResetCause::Option
    } else if csr & PIN != 0 {
        ResetCause::Pin
    } else {
        ResetCause::Unknown
    }
}

/// Words that keep a [`Record`].
pub const WORDS: usize = 6;
/// "mrrc"
const MAGIC: u32 = 0x6372_726D;
/// No token is missing.
const NONE: u32 = 0xFF;

/// What is remembered: in RAM that nobody clears, as long as there is power.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Record {
    /// Resets since power came.
    pub resets: u32,
    /// Of these, by a watchdog.
    pub watchdog: u32,
    /// Why the processor began anew the last time.
    pub cause: ResetCause,
    /// The state of the node, as of the last tick.
    pub state: NodeState,
    /// The token that was missing.
    pub missing: Option<Token>,
}

/// The record of before, and what follows from it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Begun {
    /// What was remembered: nothing if power was off, or if nobody had written it.
    pub before: Option<Record>,
    /// What is to be remembered from now on.
    pub now: Record,
}

impl Record {
    /// After a reset: counts it. `words` are what the RAM held.
    #[must_use]
    pub fn begin(words: &[u32; WORDS], cause: ResetCause) -> Begun {
        let before = Self::read(words).filter(|_| cause != ResetCause::PowerOn);
        let one = u32::from(cause == ResetCause::Watchdog);
        let now = Self {
            resets: before.map_or(0, |b| b.resets.saturating_add(1)),
            watchdog: before.map_or(0, |b| b.watchdog).saturating_add(one),
            cause,
            state: NodeState::Boot,
            missing: None,
        };
        Begun { before, now }
    }

    /// As words, the last of which proves the others.
    #[must_use]
    pub fn write(&self) -> [u32; WORDS] {
        let last = u32::from(self.cause as u8)
            | u32::from(self.state as u8) << 8
            | self.missing.map_or(NONE, |token| u32::from(token as u8)) << 16;
        let words = [MAGIC, self.resets, self.watchdog, last, 0, 0];
        let [a, b, c, d, ..] = words;
        [a, b, c, d, !last, proof([a, b, c, d])]
    }

    /// What [`Self::write`] wrote; nothing if it did not write this.
    #[must_use]
    pub fn read(words: &[u32; WORDS]) -> Option<Self> {
        let [magic, resets, watchdog, last, inverted, proven] = *words;
        if magic != MAGIC || inverted != !last || proven != proof([magic, resets, watchdog, last]) {
            return None;
        }
        let [cause, state, missing, zero] = last.to_le_bytes();
        if zero != 0 {
            return None;
        }
        Some(Self {
            resets,
            watchdog,
            cause: CAUSES.into_iter().find(|c| *c as u8 == cause)?,
            state: NodeState::ALL.into_iter().find(|s| *s as u8 == state)?,
            missing: if u32::from(missing) == NONE {
                None
            } else {
                Some(Token::ALL.into_iter().find(|t| *t as u8 == missing)?)
            },
        })
    }
}

/// CRC-32 of the words.
fn proof(words: [u32; 4]) -> u32 {
    let crc = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);
    let mut digest = crc.digest();
    for word in words {
        digest.update(&word.to_le_bytes());
    }
    digest.finalize()
}

#[cfg(test)]
mod test {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn each_flag_is_its_cause_whatever_the_pin_says() {
        let pin = 1 << 26;
        for (bit, cause) in [
            (31, ResetCause::Option),
            (30, ResetCause::Watchdog),
            (29, ResetCause::Watchdog),
            (28, ResetCause::Software),
            (27, ResetCause::PowerOn),
            (25, ResetCause::Option),
        ] {
            for with in [0, pin] {
                assert_eq!(cause_of_rcc_csr(1 << bit | with), cause, "{bit}");
            }
        }
        assert_eq!(cause_of_rcc_csr(pin), ResetCause::Pin);
        assert_eq!(cause_of_rcc_csr(0), ResetCause::Unknown);
        // LSI on and ready, which are no flags of a reset
        assert_eq!(cause_of_rcc_csr(pin | 3), ResetCause::Pin);
        // power is oldest: whatever was seen since is not to be trusted
        assert_eq!(cause_of_rcc_csr(0xFE00_0000), ResetCause::PowerOn);
    }

    #[test]
    fn resets_are_counted_until_power_goes() {
        let mut words = [0xDEAD_BEEF; WORDS];
        let begun = Record::begin(&words, ResetCause::PowerOn);
        assert_eq!((begun.before, begun.now.resets), (None, 0));
        words = begun.now.write();
        let causes = [ResetCause::Watchdog, ResetCause::Pin, ResetCause::Watchdog];
        for (n, cause) in (1..).zip(causes) {
            let begun = Record::begin(&words, cause);
            assert_eq!(begun.before, Record::read(&words));
            assert_eq!(begun.now.resets, n);
            words = begun.now.write();
        }
        let now = Record::read(&words).unwrap();
        assert_eq!((now.resets, now.watchdog), (3, 2));
        assert_eq!(Record::begin(&words, ResetCause::PowerOn).before, None);
        assert_eq!(Record::begin(&words, ResetCause::PowerOn).now.resets, 0);
    }

    #[test]
    fn a_watchdog_without_a_record_is_counted_too() {
        let begun = Record::begin(&[0; WORDS], ResetCause::Watchdog);
        assert_eq!((begun.before, begun.now.watchdog), (None, 1));
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_and_one_wrong_bit_is_not(
            resets in any::<u32>(), watchdog in any::<u32>(), cause in 0..CAUSES.len(), state in 0_usize..10, missing in 0_usize..4,
            word in 0..WORDS, bit in 0_u32..32,
        ) {
            let record = Record {
                resets, watchdog,
                cause: CAUSES[cause],
                state: NodeState::ALL[state],
                missing: Token::ALL.get(missing).copied(),
            };
            let mut words = record.write();
            prop_assert_eq!(Record::read(&words), Some(record));
            words[word] ^= 1 << bit;
            prop_assert_eq!(Record::read(&words), None);
        }
    }
}
