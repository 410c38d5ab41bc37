//! What the one status light says: a pattern of 2 s for every state.

use crate::alive::Token;
use crate::emergency::Emergency;
use protocol::message::NodeState;
use protocol::time::Micros;

/// A pattern: 16 parts of 125 ms, the highest bit first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pattern(pub u16);

/// What is said.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Light {
    /// There is no node: the configuration cannot be used.
    NoNode,
    /// A token is missing: the watchdog is about to reset the board.
    Starving,
    /// The contacts of the emergency stop differ.
    Discrepant,
    /// The emergency stop is pressed.
    Pressed,
    /// The emergency stop waits for its reset.
    AwaitingReset,
    /// The node is in this state.
    Node(NodeState),
}

impl Light {
    /// The first that holds, from the top of the enumeration.
    #[must_use]
    pub const fn of(node: Option<NodeState>, missing: Option<Token>, emergency: Emergency) -> Self {
        match (node, missing, emergency) {
            (None, _, _) => Self::NoNode,
            (_, Some(_), _) => Self::Starving,
            (_, _, Emergency::Discrepant) => Self::Discrepant,
            (_, _, Emergency::Pressed) => Self::Pressed,
            (_, _, Emergency::AwaitingReset) => Self::AwaitingReset,
            (Some(state), None, Emergency::Clear) => Self::Node(state),
        }
    }

    /// The table: what somebody in front of the board sees.
    #[must_use]
    pub const fn pattern(self) -> Pattern {
        Pattern(match self {
            // flickers
            Self::NoNode => 0b1010_1010_1010_1010,
            // nearly always on
            Self::Starving => 0b1111_1111_1111_1110,
            // groups of flashes: 4, 3, 2
            Self::Discrepant => 0b1010_1010_0000_0000,
            Self::Pressed => 0b1010_1000_0000_0000,
            Self::AwaitingReset => 0b1010_0000_0000_0000,
            Self::Node(state) => match state {
                // twice a second
                NodeState::Boot => 0b1100_1100_1100_1100,
                NodeState::Configuring => 0b1000_1000_1000_1000,
                // one flash: it is there, and has no torque
                NodeState::Disabled => 0b1000_0000_0000_0000,
                // half of the time
                NodeState::Enabling => 0b1111_0000_1111_0000,
                NodeState::Unsynchronised => 0b1111_1111_0000_0000,
                // mostly on: torque
                NodeState::Synchronising => 0b1111_0111_1111_0111,
                NodeState::Holding => 0b1111_1111_1111_1111,
                NodeState::Moving => 0b1101_1101_1101_1101,
                NodeState::Stopping => 0b1110_1110_1110_1010,
                // 5 flashes
                NodeState::Faulted => 0b1010_1010_1000_0000,
            },
        })
    }
}

impl Pattern {
    /// One part, µs.
    pub const PART_US: u64 = 125_000;

    /// Is the light on now?
    #[must_use]
    pub const fn lit(self, now: Micros) -> bool {
        let part = (now.0 / Self::PART_US) % 16;
        (self.0 << part) & 0x8000 != 0
    }
}

#[cfg(test)]
mod test {
    use super::*;

    fn all() -> Vec<Light> {
        let others = [
            Light::NoNode,
            Light::Starving,
            Light::Discrepant,
            Light::Pressed,
            Light::AwaitingReset,
        ];
        others
            .into_iter()
            .chain(NodeState::ALL.map(Light::Node))
            .collect()
    }

    use std::vec::Vec;

    #[test]
    fn no_two_patterns_look_alike_wherever_one_begins_to_look() {
        let all = all();
        for (k, a) in all.iter().enumerate() {
            for b in &all[k + 1..] {
                for shift in 0..16 {
                    assert_ne!(
                        a.pattern().0.rotate_left(shift),
                        b.pattern().0,
                        "{a:?} and {b:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn every_pattern_shows_that_the_board_runs() {
        for light in all() {
            assert_ne!(light.pattern().0, 0, "{light:?}");
        }
    }

    #[test]
    fn the_pattern_is_shown_from_its_highest_bit_on_and_again() {
        let pattern = Pattern(0b1000_0000_0000_0001);
        let lit: Vec<bool> = (0..32)
            .map(|part| pattern.lit(Micros(part * 125_000 + 124_999)))
            .collect();
        for (part, lit) in lit.iter().enumerate() {
            assert_eq!(*lit, [0, 15, 16, 31].contains(&part), "{part}");
        }
    }

    #[test]
    fn the_worst_is_shown_first() {
        let clear = Emergency::Clear;
        let faulted = Some(NodeState::Faulted);
        assert_eq!(Light::of(None, Some(Token::Step), clear), Light::NoNode);
        assert_eq!(
            Light::of(faulted, Some(Token::Step), Emergency::Pressed),
            Light::Starving
        );
        for (emergency, light) in [
            (Emergency::Discrepant, Light::Discrepant),
            (Emergency::Pressed, Light::Pressed),
            (Emergency::AwaitingReset, Light::AwaitingReset),
            (Emergency::Clear, Light::Node(NodeState::Faulted)),
        ] {
            assert_eq!(Light::of(faulted, None, emergency), light);
        }
    }
}
