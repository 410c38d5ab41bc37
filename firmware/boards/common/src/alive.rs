//! Who may feed the watchdog: nobody but all of them together.
//!
//! Every part of the image that must run tells its token, in the order of [`Token`]; a token out of order is none. Only
//! when all of them have been told, each within its period, is the watchdog fed, and the round begins anew. If
//! one comes too late the watchdog is never fed again: the board is reset, drives stop by themselves, and the
//! record of the reset says whose token was missing (`docs/faults`, C2).

use protocol::time::Micros;

/// What must run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Token {
    /// The tick: emergency stop, brakes, time.
    Tick = 0,
    /// The node's step, and the CAN controllers that are served by it.
    Step = 1,
    /// What has no deadline: configuration, log.
    Idle = 2,
}

/// For so long idle may have to wait for the work below the servo steps, which then tells its token: a node whose ECP takes longer
/// has stopped already, and a page of flash is erased in 25 ms.
pub const LONGEST_WORK: Micros = Micros::from_millis(40);

/// Of [`Token`].
const TOKENS: usize = 3;

impl Token {
    /// All of them, in their order.
    pub const ALL: [Self; TOKENS] = [Self::Tick, Self::Step, Self::Idle];
}

/// Periods, µs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Periods {
    /// In which each token must be told, from the last feeding on.
    pub tokens: [u32; TOKENS],
    /// The watchdog takes no food before so much time has passed since the last: its window.
    pub opens: u32,
}

/// The tokens of one round.
#[derive(Clone, Copy, Debug)]
pub struct Alive {
    periods: Periods,
    /// When the round began.
    fed: Micros,
    /// How many of the tokens have been told.
    told: usize,
    missing: Option<Token>,
}

impl Alive {
    /// A round that begins now.
    #[must_use]
    pub const fn new(now: Micros, periods: Periods) -> Self {
        Self {
            periods,
            fed: now,
            told: 0,
            missing: None,
        }
    }

    /// The token whose turn it is.
    const fn turn(&self) -> Option<Token> {
        match self.told {
            0 => Some(Token::Tick),
            1 => Some(Token::Step),
            2 => Some(Token::Idle),
            _ => None,
        }
    }

    const fn late(&self, now: Micros, token: Token) -> bool {
        let [tick, step, idle] = self.periods.tokens;
        let period = match token {
            Token::Tick => tick,
            Token::Step => step,
            Token::Idle => idle,
        };
        now.since(self.fed).0 > period as u64
    }

    /// This part runs.
    pub fn tell(&mut self, now: Micros, token: Token) {
        if self.turn() != Some(token) {
            return;
        }
        if self.late(now, token) {
            self.missing = self.missing.or(Some(token));
        } else {
            self.told = self.told.saturating_add(1);
        }
    }

    /// May the watchdog be fed now? If so it must be, and a new round begins.
    pub fn feed(&mut self, now: Micros) -> bool {
        if let Some(token) = self.turn() {
            if self.late(now, token) {
                self.missing = self.missing.or(Some(token));
            }
            return false;
        }
        if self.missing.is_some() || now.since(self.fed).0 < u64::from(self.periods.opens) {
            return false;
        }
        self.fed = now;
        self.told = 0;
        true
    }

    /// Whose token was missing: the watchdog will not be fed again.
    #[must_use]
    pub const fn missing(&self) -> Option<Token> {
        self.missing
    }
}

#[cfg(test)]
mod test {
    use super::*;
    use proptest::prelude::*;

    const PERIODS: Periods = Periods {
        tokens: [1000, 3000, 4000],
        opens: 1500,
    };

    fn at(us: u64) -> Micros {
        Micros(10_000_000 + us)
    }

    fn round() -> Alive {
        Alive::new(at(0), PERIODS)
    }

    #[test]
    fn all_tokens_in_order_feed_once_the_window_is_open() {
        let mut alive = round();
        for (us, token) in [(500, Token::Tick), (900, Token::Step), (1000, Token::Idle)] {
            assert!(!alive.feed(at(us)));
            alive.tell(at(us), token);
        }
        assert!(!alive.feed(at(1499)), "the window is closed");
        assert!(alive.feed(at(1500)));
        assert!(!alive.feed(at(1501)), "fed already");
        assert_eq!(alive.missing(), None);
    }

    #[test]
    fn each_token_is_missed_and_then_nothing_feeds_any_more() {
        for missing in Token::ALL {
            let mut alive = round();
            for us in (0..6000).step_by(100) {
                for token in Token::ALL {
                    if token != missing {
                        alive.tell(at(us), token);
                    }
                }
                assert!(!alive.feed(at(us)), "{missing:?} {us}");
            }
            assert_eq!(alive.missing(), Some(missing));
            for us in (6000..20_000).step_by(100) {
                for token in Token::ALL {
                    alive.tell(at(us), token);
                }
                assert!(!alive.feed(at(us)), "{missing:?} came back too late");
            }
            assert_eq!(alive.missing(), Some(missing), "the first is kept");
        }
    }

    #[test]
    fn a_token_out_of_order_is_none() {
        let mut alive = round();
        for token in [
            Token::Idle,
            Token::Step,
            Token::Tick,
            Token::Idle,
            Token::Step,
        ] {
            alive.tell(at(100), token);
        }
        assert!(!alive.feed(at(2000)), "the last token is still wanted");
        alive.tell(at(2000), Token::Idle);
        assert!(alive.feed(at(2000)));
    }

    #[test]
    fn a_token_at_its_last_instant_is_in_time_and_one_behind_is_not() {
        for (us, fed) in [(1000, true), (1001, false)] {
            let mut alive = round();
            alive.tell(at(us), Token::Tick);
            alive.tell(at(us), Token::Step);
            alive.tell(at(us), Token::Idle);
            assert_eq!(alive.feed(at(2000)), fed, "{us}");
        }
    }

    proptest! {
        /// Whatever is told when, two feedings are apart by the window at least, and by the longest period
        /// and the time since at most.
        #[test]
        fn feedings_are_never_too_close(told in proptest::collection::vec((0_u64..600, 0_usize..3), 0..400)) {
            let mut alive = round();
            let (mut now, mut last) = (0, 0);
            for (passed, token) in told {
                now += passed;
                alive.tell(at(now), Token::ALL[token]);
                if alive.feed(at(now)) {
                    prop_assert!(now - last >= u64::from(PERIODS.opens));
                    prop_assert!(alive.missing().is_none());
                    last = now;
                }
            }
        }
    }
}
