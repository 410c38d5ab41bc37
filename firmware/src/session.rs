//! The command lease: one holder at a time, one epoch per holder.
//!
//! Only a fresh, in-sequence, valid [`Command`] of the holder renews the lease: an invalid frame
//! is no frame. Anyone may stop; only the holder may command and clear.

use protocol::fault::Refusal;
use protocol::message::Command;
use protocol::time::Micros;

/// The shortest lease that may be asked for, ms: five macrosteps of 4 ms.
pub const MIN_LEASE_MS: u16 = 20;
/// The longest lease that may be asked for, ms.
pub const MAX_LEASE_MS: u16 = 2000;

/// The present holder of the command lease.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Holder {
    node: u8,
    term: Micros,
    expires: Micros,
    sequence: Option<u16>,
}

/// Why a cyclic command was not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rejected {
    /// Not from the holder, or of another epoch.
    Foreign,
    /// Repeated or out of order.
    OutOfOrder,
    /// After its own deadline.
    Expired,
}

/// Who may command.
#[derive(Clone, Debug)]
pub struct Session {
    epoch: u32,
    holder: Option<Holder>,
    last_command: u32,
    lost: u32,
}

impl Session {
    /// Nobody holds the lease; `seed` makes the epochs of different boots differ.
    #[must_use]
    pub const fn new(seed: u32) -> Self {
        // The low bits count takeovers within one boot.
        Self {
            epoch: (seed & 0x00FF_FFFF) << 8,
            holder: None,
            last_command: 0,
            lost: 0,
        }
    }

    /// The epoch now valid, 0 if nobody holds the lease.
    #[must_use]
    pub const fn epoch(&self) -> u32 {
        match self.holder {
            Some(_) => self.epoch,
            None => 0,
        }
    }

    /// Cyclic messages lost in this epoch.
    #[must_use]
    pub const fn lost(&self) -> u32 {
        self.lost
    }

    /// Take the lease for `node`.
    ///
    /// # Errors
    /// [`Refusal::LeaseHeld`] while another holds it, unless `takeover` and the arm is at rest;
    /// [`Refusal::OutOfRange`] for a term outside 20…2000 ms.
    pub fn acquire(
        &mut self,
        now: Micros,
        node: u8,
        term_ms: u16,
        takeover: bool,
        at_rest: bool,
    ) -> Result<u32, Refusal> {
        if !(MIN_LEASE_MS..=MAX_LEASE_MS).contains(&term_ms) {
            return Err(Refusal::OutOfRange {
                index: 0,
                value: f32::from(term_ms),
                lower: f32::from(MIN_LEASE_MS),
                upper: f32::from(MAX_LEASE_MS),
            });
        }
        if let Some(holder) = self.holder
            && holder.node != node
            && !(takeover && at_rest)
        {
            return Err(Refusal::LeaseHeld {
                holder: holder.node,
            });
        }
        self.epoch = self.epoch.wrapping_add(1);
        if self.epoch == 0 {
            self.epoch = 1;
        }
        let term = Micros::from_millis(u64::from(term_ms));
        self.holder = Some(Holder {
            node,
            term,
            expires: now + term,
            sequence: None,
        });
        self.last_command = 0;
        self.lost = 0;
        Ok(self.epoch)
    }

    /// Is this the holder, speaking of the present epoch?
    ///
    /// # Errors
    /// [`Refusal::NoLease`] otherwise.
    pub const fn authorise(&self, node: u8, epoch: u32) -> Result<(), Refusal> {
        match self.holder {
            Some(holder) if holder.node == node && epoch == self.epoch => Ok(()),
            _ => Err(Refusal::NoLease {
                epoch: self.epoch(),
            }),
        }
    }

    /// Give the lease back.
    pub const fn release(&mut self) {
        self.holder = None;
    }

    /// A cyclic command: renews the lease if it is fresh. Its deadline is in bus time, the lease
    /// runs in local time.
    ///
    /// # Errors
    /// Why it was not taken; nothing changed then.
    pub fn renew(
        &mut self,
        bus_now: Micros,
        now: Micros,
        node: u8,
        command: &Command,
    ) -> Result<(), Rejected> {
        let epoch = self.epoch;
        let Some(holder) = self.holder.as_mut().filter(|h| h.node == node) else {
            return Err(Rejected::Foreign);
        };
        if command.epoch != epoch {
            return Err(Rejected::Foreign);
        }
        if command.valid_until < bus_now {
            return Err(Rejected::Expired);
        }
        if let Some(last) = holder.sequence {
            let ahead = command.sequence.wrapping_sub(last);
            if ahead == 0 || ahead > u16::MAX / 2 {
                return Err(Rejected::OutOfOrder);
            }
            self.lost = self.lost.saturating_add(u32::from(ahead) - 1);
        }
        holder.sequence = Some(command.sequence);
        holder.expires = now + holder.term;
        Ok(())
    }

    /// Has the lease run out? It is then given up, and this is true once.
    pub fn expired(&mut self, now: Micros) -> bool {
        let expired = self.holder.is_some_and(|h| h.expires < now);
        if expired {
            self.holder = None;
        }
        expired
    }

    /// A command id: strictly increasing within the epoch, so nothing is executed twice.
    ///
    /// # Errors
    /// [`Refusal::Stale`] for an id that is not greater than the last.
    pub const fn fresh(&mut self, id: u32) -> Result<(), Refusal> {
        if id > self.last_command {
            self.last_command = id;
            Ok(())
        } else {
            Err(Refusal::Stale {
                last: self.last_command,
            })
        }
    }
}

#[cfg(test)]
mod test {
    use super::*;
    use protocol::message::Coordination;

    fn command(epoch: u32, sequence: u16, valid_until: u64) -> Command {
        Command {
            epoch,
            sequence,
            valid_until: Micros(valid_until),
            coordination: Coordination::None,
        }
    }

    #[test]
    fn one_holder_per_epoch() {
        let mut s = Session::new(5);
        let epoch = s.acquire(Micros(0), 1, 100, false, true).unwrap();
        assert_eq!(
            s.acquire(Micros(0), 2, 100, false, true),
            Err(Refusal::LeaseHeld { holder: 1 })
        );
        assert_eq!(
            s.acquire(Micros(0), 2, 100, true, false),
            Err(Refusal::LeaseHeld { holder: 1 })
        );
        let second = s.acquire(Micros(0), 2, 100, true, true).unwrap();
        assert!(second > epoch);
        assert_eq!(
            s.authorise(1, epoch),
            Err(Refusal::NoLease { epoch: second })
        );
        assert_eq!(
            s.authorise(2, epoch),
            Err(Refusal::NoLease { epoch: second })
        );
        assert_eq!(s.authorise(2, second), Ok(()));
        assert!(s.acquire(Micros(0), 2, 5, false, true).is_err());
    }

    #[test]
    fn only_fresh_commands_of_the_holder_renew() {
        let mut s = Session::new(1);
        let e = s.acquire(Micros(0), 1, 100, false, true).unwrap();
        assert_eq!(
            s.renew(Micros(50_000), Micros(50_000), 1, &command(e, 1, 60_000)),
            Ok(())
        );
        for (node, c, why) in [
            (2, command(e, 2, 90_000), Rejected::Foreign),
            (1, command(e - 1, 2, 90_000), Rejected::Foreign),
            (1, command(e, 1, 90_000), Rejected::OutOfOrder),
            (1, command(e, 0, 90_000), Rejected::OutOfOrder),
            (1, command(e, 2, 10_000), Rejected::Expired),
        ] {
            assert_eq!(s.renew(Micros(80_000), Micros(80_000), node, &c), Err(why));
        }
        assert!(!s.expired(Micros(150_000)));
        assert_eq!(
            s.renew(Micros(140_000), Micros(140_000), 1, &command(e, 5, 200_000)),
            Ok(())
        );
        assert_eq!(s.lost(), 3);
        assert!(s.expired(Micros(240_001)));
        assert!(!s.expired(Micros(240_002)), "told once");
        assert_eq!(s.epoch(), 0);
    }

    #[test]
    fn sequence_numbers_wrap() {
        let mut s = Session::new(1);
        let e = s.acquire(Micros(0), 1, 100, false, true).unwrap();
        s.renew(Micros(0), Micros(0), 1, &command(e, u16::MAX, 1))
            .unwrap();
        assert_eq!(s.renew(Micros(0), Micros(0), 1, &command(e, 0, 1)), Ok(()));
        assert_eq!(s.lost(), 0);
    }

    #[test]
    fn command_ids_increase() {
        let mut s = Session::new(1);
        assert_eq!(s.fresh(3), Ok(()));
        assert_eq!(s.fresh(3), Err(Refusal::Stale { last: 3 }));
        assert_eq!(s.fresh(2), Err(Refusal::Stale { last: 3 }));
    }
}
