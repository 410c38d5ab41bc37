//! End-to-end protection of the messages that cause or report motion.
//!
//! CAN's own CRC guards the wire, not what lies beside it: a gateway's bug, a stale kernel queue,
//! swapped nodes, a session from before a restart. So these messages begin with three bytes, shaped
//! like AUTOSAR E2E Profile 5:
//!
//! ```text
//! crc_low  crc_high  counter  message …  padding
//! ```
//!
//! The CRC (polynomial 0x1021, initial value 0xFFFF) runs over the counter, the message, its
//! padding, and at last the two bytes (low, high) of a *data id* that is not transmitted: a hash of
//! port, destination, source, and the epoch of the lease. Both ends must agree on all of them.

use crate::id::CanId;
use crate::time::Micros;
use crate::transfer::CRC;

/// Bytes of protection before the message.
pub const HEADER: usize = 3;

/// After this silence any counter value is accepted as the first: the sender may have restarted.
pub const RESYNC: Micros = Micros::from_millis(100);

/// A counter further ahead than this is taken for one from the past.
const MAX_AHEAD: u8 = 127;

/// Bits 25 to 0 of a CAN identifier: all but the priority.
const ALL_BUT_PRIORITY: u32 = 0x03FF_FFFF;

/// The data id of what `id` says about port, destination and source, and of an epoch (0 where no
/// lease is involved).
///
/// FNV-1a over the 29-bit identifier without its priority and the epoch (four bytes each, little
/// endian), its halves added bit by bit modulo 2: not linear, so that it cannot cancel against a
/// difference in the message as another CRC could.
#[must_use]
pub fn data_id(id: CanId, epoch: u32) -> u16 {
    let [i0, i1, i2, i3] = (id.bits() & ALL_BUT_PRIORITY).to_le_bytes();
    let [e0, e1, e2, e3] = epoch.to_le_bytes();
    let hash = [i0, i1, i2, i3, e0, e1, e2, e3]
        .iter()
        .fold(0x811C_9DC5_u32, |hash, byte| {
            (hash ^ u32::from(*byte)).wrapping_mul(0x0100_0193)
        });
    let [a, b, c, d] = hash.to_le_bytes();
    u16::from_le_bytes([a ^ c, b ^ d])
}

fn crc(data_id: u16, counter_and_message: &[u8]) -> [u8; 2] {
    let mut digest = CRC.digest();
    digest.update(counter_and_message);
    digest.update(&data_id.to_le_bytes());
    digest.finalize().to_le_bytes()
}

/// Writes the header into the first [`HEADER`] bytes of `protected`; the message follows them.
/// A slice shorter than the header is left alone.
pub fn protect(data_id: u16, counter: u8, protected: &mut [u8]) {
    if let Some((check, rest)) = protected.split_first_chunk_mut::<2>()
        && let Some(place) = rest.first_mut()
    {
        *place = counter;
        *check = crc(data_id, rest);
    }
}

/// The counter and the message of protected bytes; `None` when the CRC does not fit.
#[must_use]
pub fn verify(data_id: u16, protected: &[u8]) -> Option<(u8, &[u8])> {
    let (check, rest) = protected.split_first_chunk::<2>()?;
    let (counter, message) = rest.split_first()?;
    (crc(data_id, rest) == *check).then_some((*counter, message))
}

/// The sending side: numbers the messages of one session.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Protector {
    counter: u8,
}

impl Protector {
    /// As [`protect`], with the next counter value.
    pub fn protect(&mut self, data_id: u16, protected: &mut [u8]) {
        protect(data_id, self.counter, protected);
        self.counter = self.counter.wrapping_add(1);
    }
}

/// What the receiving side found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The next message, or the first after silence.
    Ok,
    /// Valid, but so many before it are missing.
    Lost(u8),
    /// The counter of the last valid message again.
    Repeated,
    /// Damaged, of another port or source, or not protected at all.
    WrongCrc,
    /// From the past: an older counter, or the epoch of another lease.
    Stale,
}

impl Outcome {
    /// May the message be used? An invalid message is no message.
    #[must_use]
    pub const fn is_valid(self) -> bool {
        matches!(self, Self::Ok | Self::Lost(_))
    }

    /// Messages missing before this one.
    #[must_use]
    pub const fn lost(self) -> u8 {
        match self {
            Self::Lost(n) => n,
            Self::Ok | Self::Repeated | Self::WrongCrc | Self::Stale => 0,
        }
    }
}

/// How often each [`Outcome`] occurred; saturating.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Valid messages.
    pub ok: u32,
    /// Messages found missing.
    pub lost: u32,
    /// Repeated messages.
    pub repeated: u32,
    /// Messages with a wrong CRC.
    pub wrong_crc: u32,
    /// Messages from the past or of another epoch.
    pub stale: u32,
}

impl Counters {
    /// Counts one outcome.
    pub fn record(&mut self, outcome: Outcome) {
        let (counter, by) = match outcome {
            Outcome::Ok => (&mut self.ok, 1),
            Outcome::Lost(n) => {
                self.ok = self.ok.saturating_add(1);
                (&mut self.lost, u32::from(n))
            }
            Outcome::Repeated => (&mut self.repeated, 1),
            Outcome::WrongCrc => (&mut self.wrong_crc, 1),
            Outcome::Stale => (&mut self.stale, 1),
        };
        *counter = counter.saturating_add(by);
    }
}

/// The receiving side of one session.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Checker {
    last: Option<(u8, Micros)>,
}

impl Checker {
    /// Judges one protected message received at `now` (local, monotonic). Only a valid one changes
    /// what is expected next.
    pub fn check(&mut self, data_id: u16, protected: &[u8], now: Micros) -> Outcome {
        let Some((counter, _)) = verify(data_id, protected) else {
            return Outcome::WrongCrc;
        };
        let outcome = match self.last {
            Some((last, at)) if now.since(at) <= RESYNC => match counter.wrapping_sub(last) {
                0 => Outcome::Repeated,
                1 => Outcome::Ok,
                ahead if ahead <= MAX_AHEAD => Outcome::Lost(ahead - 1),
                _ => Outcome::Stale,
            },
            _ => Outcome::Ok,
        };
        if outcome.is_valid() {
            self.last = Some((counter, now));
        }
        outcome
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::id::{NodeId, Port, Priority, Subject};
    use proptest::prelude::*;

    const ID: u16 = 0x1234;

    fn feedback(source: u8, subject: u16) -> CanId {
        CanId {
            priority: Priority::High,
            source: NodeId::new(source).unwrap(),
            port: Port::Message(Subject::new(subject).unwrap()),
        }
    }

    fn message(counter: u8) -> [u8; 6] {
        let mut bytes = [0, 0, 0, 7, 8, 9];
        protect(ID, counter, &mut bytes);
        bytes
    }

    #[test]
    fn the_profile_5_example() {
        // AUTOSAR "Specification of E2E protocol", Profile 5: eight bytes, offset 0, data id
        // 0x1234, counter 0, data zero: CRC bytes 1C CA.
        let mut bytes = [0; 8];
        protect(0x1234, 0, &mut bytes);
        assert_eq!(bytes, [0x1C, 0xCA, 0, 0, 0, 0, 0, 0]);
    }

    #[test]
    fn every_outcome() {
        let mut checker = Checker::default();
        let mut check = |counter, at| checker.check(ID, &message(counter), Micros(at));
        assert_eq!(check(250, 0), Outcome::Ok);
        assert_eq!(check(251, 1), Outcome::Ok);
        assert_eq!(check(251, 2), Outcome::Repeated);
        assert_eq!(check(2, 3), Outcome::Lost(6));
        assert_eq!(check(1, 4), Outcome::Stale);
        assert_eq!(check(3, 5), Outcome::Ok);
        assert_eq!(check(130, 6), Outcome::Lost(126));
        assert_eq!(check(2, 7), Outcome::Stale);
        // After silence, the sender may have restarted.
        assert_eq!(check(100, 6 + RESYNC.0), Outcome::Stale);
        assert_eq!(check(100, 7 + RESYNC.0), Outcome::Ok);
        assert_eq!(
            checker.check(ID + 1, &message(1), Micros(8)),
            Outcome::WrongCrc
        );
        assert_eq!(checker.check(ID, &[0, 0], Micros(8)), Outcome::WrongCrc);
    }

    #[test]
    fn data_ids_of_neighbours_differ() {
        let base = data_id(feedback(11, 4300), 7);
        for n in (0..128).filter(|n| *n != 11) {
            assert_ne!(data_id(feedback(n, 4300), 7), base);
        }
        for subject in (4290..4310).filter(|p| *p != 4300) {
            assert_ne!(data_id(feedback(11, subject), 7), base);
        }
        let urgent = CanId {
            priority: Priority::Exceptional,
            ..feedback(11, 4300)
        };
        assert_eq!(data_id(urgent, 7), base);
    }

    proptest! {
        #[test]
        fn another_epoch_does_not_pass(epoch in any::<u32>(), step in 1u32..1000) {
            let id = feedback(1, 4107);
            let ids = [epoch, epoch.wrapping_add(step)].map(|e| data_id(id, e));
            let mut bytes = [0, 0, 0, 1, 2, 3];
            protect(ids[0], 0, &mut bytes);
            // Two of 2^16 data ids may coincide; otherwise the CRC must differ.
            prop_assert_eq!(verify(ids[1], &bytes).is_some(), ids[0] == ids[1]);
        }

        #[test]
        fn any_bytes_are_judged(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
            let mut checker = Checker::default();
            let outcome = checker.check(ID, &bytes, Micros(0));
            prop_assert_eq!(outcome.is_valid(), verify(ID, &bytes).is_some());
        }
    }
}
