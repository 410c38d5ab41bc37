//! Several taps that send the same identifier at once.
//!
//! All of them win the arbitration and send on (ISO 11898-1:2015, 10.7 and 10.11). At the first bit in which they differ,
//! those who send it recessive see it dominant: a bit error. If one of them is error-active, its flag destroys the frame
//! for everybody; all who sent count it as theirs, and begin again together. If all of them are error-passive, nobody
//! sees their flags: they fall silent, and the frame goes on with what the others send. Who agrees to the end has sent one
//! frame together, which somebody else must acknowledge.
//!
//! So two nodes that are error-active collide 16 times, until both are error-passive; then one falls silent and gets its
//! turn behind the other. Only one that collides with ever new frames goes bus-off.

use super::attempt::Outcome;
use super::bits::{self, Bit, Level};
use super::confinement::State;
use super::fault::Seen;
use super::{Tap, Taps, Wire};

/// Bits from the end of a frame on, its interframe space included, after which one who fell silent in it is through with
/// its own: six equal bits are its passive flag, and the first are the delimiter of the acknowledgement and five of the
/// end of frame; eight of a delimiter and three of interframe space follow.
pub(super) const FALLEN_BITS: u32 = 6;

/// How it ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Collision {
    /// Whose bits are on the wire: the lowest of them.
    pub(super) from: Tap,
    /// Who fell silent.
    pub(super) fallen: Taps,
    /// Unless the frame goes on.
    pub(super) destroyed: Option<Outcome>,
}

impl Wire {
    /// These begin their frames at `start_ns`; `lowest` is the lowest of them.
    pub(super) fn collide(&self, start_ns: u64, lowest: Tap, senders: Taps) -> Collision {
        let taps = self.queues.taps.iter().enumerate();
        let mut left: Vec<(Tap, Vec<Bit>)> = taps
            .filter(|(tap, _)| senders.contains(*tap))
            .filter_map(|(tap, queue)| {
                let passive = self.state(tap) != State::Active;
                Some((tap, bits::of(queue.offer(start_ns)?, passive)))
            })
            .collect();
        let mut collision = Collision {
            from: lowest,
            fallen: Taps::NONE,
            destroyed: None,
        };
        // each round parts at least one from the others
        for _ in 0..left.len() {
            collision.from = left.first().map_or(lowest, |(tap, _)| *tap);
            let Some(bit) = difference(&left) else {
                break;
            };
            let sends = |bits: &[Bit], level| bits.get(bit).is_some_and(|bit| bit.level == level);
            let fall = |(_, bits): &&(Tap, Vec<Bit>)| sends(bits, Level::Recessive);
            let falling: Vec<Tap> = left.iter().filter(fall).map(|(tap, _)| *tap).collect();
            if falling.iter().any(|tap| self.state(*tap) == State::Active) {
                let (seen, first) = (Seen::OneByOne, None);
                let bit = u32::try_from(bit).unwrap_or(u32::MAX);
                collision.destroyed = Some(Outcome::Destroyed { bit, seen, first });
                break;
            }
            left.retain(|(_, bits)| sends(bits, Level::Dominant));
            collision.fallen = falling.into_iter().fold(collision.fallen, Taps::with);
        }
        collision
    }
}

/// The first bit in which not all are alike. Frames of different lengths differ where they tell them.
fn difference(all: &[(Tap, Vec<Bit>)]) -> Option<usize> {
    let (_, first) = all.first()?;
    let unlike = |(_, other): &(Tap, Vec<Bit>)| {
        let pairs = first.iter().zip(other);
        pairs.enumerate().find(|(_, (a, b))| a != b).map(|(k, _)| k)
    };
    all.iter().filter_map(unlike).min()
}
