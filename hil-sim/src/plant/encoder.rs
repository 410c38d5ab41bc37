//! How an encoder can be wrong.

use super::random::SplitMix64;

/// An encoder that tells something else than where the motor is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum EncoderFault {
    /// Its count does not change any more, and there is no index.
    Frozen,
    /// It jumps by half a turn, and back after 50 ms, and so on.
    Jumping,
    /// It counts the wrong way from now on: two of its lines changed places.
    Reversed,
    /// It counts half a turn a second too many: disturbances count as lines.
    Drifting,
    /// Any number, within 256 turns.
    Garbage,
}

/// The period of [`EncoderFault::Jumping`], s.
const JUMP_S: f64 = 0.1;

impl EncoderFault {
    /// Every one.
    pub const ALL: [Self; 5] = [
        Self::Frozen,
        Self::Jumping,
        Self::Reversed,
        Self::Drifting,
        Self::Garbage,
    ];

    /// Its name on a command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Frozen => "frozen",
            Self::Jumping => "jumping",
            Self::Reversed => "reversed",
            Self::Drifting => "drifting",
            Self::Garbage => "garbage",
        }
    }

    /// The fault of a name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|fault| fault.name() == name)
    }
}

/// An encoder that has been wrong for some time.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Wrong {
    fault: EncoderFault,
    /// What it told when that began.
    anchor: i64,
    /// For how long, s.
    since_s: f64,
    per_turn: f64,
    random: SplitMix64,
}

impl Wrong {
    pub(super) const fn new(
        fault: EncoderFault,
        anchor: i64,
        per_turn: u32,
        random: SplitMix64,
    ) -> Self {
        Self {
            fault,
            anchor,
            since_s: 0.0,
            per_turn: per_turn as f64,
            random,
        }
    }

    pub(super) const fn fault(&self) -> EncoderFault {
        self.fault
    }

    pub(super) fn pass(&mut self, dt_s: f64) {
        self.since_s += dt_s;
    }

    /// What it tells of a count.
    #[expect(clippy::cast_possible_truncation, reason = "a few turns")]
    pub(super) fn told(&mut self, count: i64) -> i64 {
        match self.fault {
            EncoderFault::Frozen => self.anchor,
            EncoderFault::Jumping => {
                let phase = self.since_s / JUMP_S;
                let away = phase - libm::floor(phase) < 0.5;
                count
                    + if away {
                        (0.5 * self.per_turn) as i64
                    } else {
                        0
                    }
            }
            EncoderFault::Reversed => 2 * self.anchor - count,
            EncoderFault::Drifting => count + (0.5 * self.per_turn * self.since_s) as i64,
            EncoderFault::Garbage => {
                let turns = self.random.between(-256.0, 256.0);
                (turns * self.per_turn) as i64
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_fault_has_a_name_of_its_own() {
        for fault in EncoderFault::ALL {
            assert_eq!(EncoderFault::from_name(fault.name()), Some(fault));
        }
        assert_eq!(EncoderFault::from_name("Frozen"), None);
    }

    #[test]
    fn each_tells_what_it_says() {
        let wrong = |fault| Wrong::new(fault, 100, 4000, SplitMix64::new(1));
        let after = |fault, s, count| {
            let mut wrong = wrong(fault);
            wrong.pass(s);
            wrong.told(count)
        };
        assert_eq!(after(EncoderFault::Frozen, 1.0, 700), 100);
        assert_eq!(after(EncoderFault::Jumping, 0.01, 700), 2700);
        assert_eq!(after(EncoderFault::Jumping, 0.06, 700), 700);
        assert_eq!(after(EncoderFault::Reversed, 1.0, 130), 70);
        assert_eq!(after(EncoderFault::Drifting, 0.25, 700), 1200);
        let mut garbage = wrong(EncoderFault::Garbage);
        let told: Vec<i64> = (0..1000).map(|_| garbage.told(0)).collect();
        assert!(told.iter().all(|count| count.abs() <= 256 * 4000));
        assert!(
            told.iter().any(|count| *count > 500_000) && told.iter().any(|count| *count < -500_000)
        );
    }
}
