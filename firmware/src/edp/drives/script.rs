//! How a drive is configured: the SDO writes between power-up and "operational".

use protocol::canopen::axis;
use protocol::canopen::fast::Slot;
use protocol::canopen::lss::Identity;
use protocol::canopen::node::NodeId as DriveId;
use protocol::canopen::objects::index;
use protocol::canopen::pdo::{Direction, Setup, SetupWrite, Value};
use protocol::canopen::sdo::Address;
use protocol::time::Micros;

/// What the node tells a drive about its axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AxisSetup {
    /// SYNC's COB-ID.
    pub sync_cob: u16,
    /// SYNC period.
    pub period: Micros,
    /// The CANopen id under which the node's own heartbeat comes.
    pub master: u8,
    /// Following-error window of the drive, drive units.
    pub following_window: u32,
    /// Deceleration of a quick stop, drive units/s².
    pub quick_stop_deceleration: u32,
    /// Greatest torque, per mille of rated; 0 = leave as it is.
    pub max_torque: u16,
    /// Mode of operation at start (csp 8, cst 10).
    pub mode: i8,
    /// The torque offset is mapped.
    pub torque_offset: bool,
    /// Its slot in the fast profile.
    pub slot: Option<Slot>,
    /// The device that it must be; it is given its node id if it has none.
    pub identity: Option<Identity>,
    /// Strangers without node id are looked for while it does not boot.
    pub find: bool,
    /// It stores its set-up, which is written again only if object 1020 tells of another one.
    pub stored: bool,
}

impl Default for AxisSetup {
    fn default() -> Self {
        Self {
            sync_cob: 0x080,
            period: Micros(2000),
            master: 127,
            following_window: 1_000_000,
            quick_stop_deceleration: 100_000_000,
            max_torque: 0,
            mode: 8,
            torque_offset: false,
            slot: None,
            identity: None,
            find: false,
            stored: false,
        }
    }
}

/// The drive's own heartbeat period, ms.
pub const DRIVE_HEARTBEAT_MS: u16 = 100;
/// For how long the drive waits for the node's heartbeat, ms: three periods.
const MASTER_WINDOW_MS: u32 = 300;
/// For how long a following error may last before the drive trips, ms.
const FOLLOWING_TIMEOUT_MS: u16 = 20;
/// 6007: what a drive does when the node's heartbeat is lost: quick stop.
const ABORT_CONNECTION_QUICK_STOP: u16 = 3;
/// 605A, 605E: ramp down with the quick-stop deceleration, then torque off.
const RAMP_THEN_OFF: u16 = 2;

/// Position in the script.
#[derive(Clone, Debug)]
pub(super) enum Script {
    Objects(u8),
    Rpdo1(Setup<'static>),
    Rpdo2(Setup<'static>),
    Tpdo1(Setup<'static>),
    Tpdo2(Setup<'static>),
    /// Object 1020 tells of this set-up, then it is stored.
    Verify(u8),
    Store,
    /// Of a drive that has stored the set-up: what changes in operation.
    Volatile(u8),
    End,
}

/// "save", little-endian: what object 1010 wants.
const SAVE: u32 = u32::from_le_bytes(*b"save");
/// More writes than any script has: 16 objects, four PDOs with at most nine.
const WRITES: u8 = 96;
/// The steps of objects that change in operation: touch probe and mode. They are no part of what is stored.
const VOLATILE: [u8; 2] = [12, 13];
/// Days of a time of day (CiA 301) have 16 bits, of which 0 is not used.
const DAYS: u32 = 0xFFFF;
/// Milliseconds of a day; 0 is not used.
const MILLISECONDS: u32 = 86_400_000;
/// FNV-1a, 64 bits.
const FNV_OFFSET: u64 = 0xCBF2_9CE4_8422_2325;
const FNV_PRIME: u64 = 0x0000_0100_0000_01B3;

/// 60C2: the interpolation period as value · 10^exponent seconds.
fn interpolation_period(period: Micros) -> (u8, i8) {
    let mut value = period.0;
    let mut exponent = -6_i8;
    while value > 0 && value.is_multiple_of(10) && exponent < 0 {
        value /= 10;
        exponent += 1;
    }
    (u8::try_from(value).unwrap_or(u8::MAX), exponent)
}

fn object(setup: &AxisSetup, step: u8) -> Option<SetupWrite> {
    let (digits, exponent) = interpolation_period(setup.period);
    let [exponent] = exponent.to_le_bytes();
    let [mode] = setup.mode.to_le_bytes();
    let window = u32::from(setup.master) << 16 | MASTER_WINDOW_MS;
    let period = u32::try_from(setup.period.0).unwrap_or(u32::MAX);
    let (index, sub, value) = match step {
        0 => (index::SYNC_COB, 0, Value::word(u32::from(setup.sync_cob))),
        1 => (index::CYCLE_PERIOD, 0, Value::word(period)),
        2 => (index::CONSUMER_HEARTBEAT, 1, Value::word(window)),
        3 => (
            index::PRODUCER_HEARTBEAT,
            0,
            Value::half(DRIVE_HEARTBEAT_MS),
        ),
        4 => (
            index::ABORT_CONNECTION,
            0,
            Value::half(ABORT_CONNECTION_QUICK_STOP),
        ),
        5 => (index::QUICK_STOP_OPTION, 0, Value::half(RAMP_THEN_OFF)),
        6 => (index::FAULT_OPTION, 0, Value::half(RAMP_THEN_OFF)),
        7 => (
            index::QUICK_STOP_DECELERATION,
            0,
            Value::word(setup.quick_stop_deceleration),
        ),
        8 => (
            index::FOLLOWING_WINDOW,
            0,
            Value::word(setup.following_window),
        ),
        9 => (
            index::FOLLOWING_TIMEOUT,
            0,
            Value::half(FOLLOWING_TIMEOUT_MS),
        ),
        10 => (index::INTERPOLATION_PERIOD, 1, Value::byte(digits)),
        11 => (index::INTERPOLATION_PERIOD, 2, Value::byte(exponent)),
        12 => (index::TOUCH_PROBE, 0, Value::half(0)),
        13 => (index::MODE, 0, Value::byte(mode)),
        _ => optional(setup, step.saturating_sub(14))?,
    };
    Some(SetupWrite {
        at: Address::new(index, sub),
        value,
    })
}

/// The writes that not every drive gets, by their number: (index, sub, value).
fn optional(setup: &AxisSetup, number: u8) -> Option<(u16, u8, Value)> {
    let torque = (setup.max_torque > 0).then(|| Value::half(setup.max_torque));
    let slot = setup.slot.map(|slot| Value::byte(slot.get()));
    [(index::MAX_TORQUE, torque), (index::FAST_SLOT, slot)]
        .into_iter()
        .filter_map(|(index, value)| Some((index, 0, value?)))
        .nth(usize::from(number))
}

impl Script {
    pub(super) const fn new() -> Self {
        Self::Objects(0)
    }

    /// For a drive that has stored the set-up.
    pub(super) const fn of_stored() -> Self {
        Self::Volatile(0)
    }

    /// Is the drive configured, whatever comes of what was written last?
    pub(super) const fn is_complete(&self) -> bool {
        matches!(self, Self::Verify(_) | Self::Store | Self::End)
    }

    /// What object 1020 tells of this set-up, sub 1 and 2: the hash (FNV-1a, 64 bits) of every write's index, sub-index,
    /// length and value but for those that change in operation, its low half brought into the days and its high half into
    /// the milliseconds of a time of day (CiA 301), both from 1: 0 means that nothing is known.
    #[inline(never)]
    pub(super) fn fingerprint(node: DriveId, setup: &AxisSetup) -> [u32; 2] {
        let setup = AxisSetup {
            stored: false,
            ..*setup
        };
        let volatile = VOLATILE.map(|step| object(&setup, step).map(|write| write.at));
        let mut hash = FNV_OFFSET;
        let mut script = Self::new();
        for _ in 0..WRITES {
            let Some(SetupWrite { at, value }) = script.next(node, &setup) else {
                break;
            };
            if volatile.contains(&Some(at)) {
                continue;
            }
            let [low, high] = at.index.to_le_bytes();
            let length = u8::try_from(value.data().len()).unwrap_or(u8::MAX);
            for byte in [low, high, at.sub, length].iter().chain(value.data()) {
                hash = (hash ^ u64::from(*byte)).wrapping_mul(FNV_PRIME);
            }
        }
        let [a, b, c, d, e, f, g, h] = hash.to_le_bytes();
        let (low, high) = (u32::from_le_bytes([a, b, c, d]), [e, f, g, h]);
        [
            low % DAYS + 1,
            u32::from_le_bytes(high) % (MILLISECONDS - 1) + 1,
        ]
    }

    /// The next write, `None` when the drive is configured.
    #[inline(never)]
    pub(super) fn next(&mut self, node: DriveId, setup: &AxisSetup) -> Option<SetupWrite> {
        // one pass per section at most
        for _ in 0..8 {
            let (write, after) = match self {
                Self::Objects(step) => {
                    let write = object(setup, *step);
                    *step = step.saturating_add(1);
                    let entries: &[_] = if setup.torque_offset {
                        &axis::RPDO1_CSP_OFFSET
                    } else {
                        &axis::RPDO1_CSP
                    };
                    let pdo = Setup::new(Direction::Receive, 1, axis::rpdo1(node), entries);
                    (write, Self::Rpdo1(pdo))
                }
                Self::Rpdo1(pdo) => {
                    let entries: &[_] = if setup.torque_offset {
                        &axis::RPDO2_CST_OFFSET
                    } else {
                        &axis::RPDO2_CST
                    };
                    let next = Setup::new(Direction::Receive, 2, axis::rpdo2(node), entries);
                    (pdo.next(), Self::Rpdo2(next))
                }
                Self::Rpdo2(pdo) => {
                    let next = Setup::new(Direction::Transmit, 1, axis::tpdo1(node), &axis::TPDO1);
                    (pdo.next(), Self::Tpdo1(next))
                }
                Self::Tpdo1(pdo) => {
                    let next = Setup::new(Direction::Transmit, 2, axis::tpdo2(node), &axis::TPDO2);
                    (pdo.next(), Self::Tpdo2(next))
                }
                Self::Tpdo2(pdo) => {
                    let after = if setup.stored {
                        Self::Verify(1)
                    } else {
                        Self::End
                    };
                    (pdo.next(), after)
                }
                Self::Verify(sub) => {
                    let [date, time] = Self::fingerprint(node, setup);
                    let value = match *sub {
                        1 => Some(date),
                        2 => Some(time),
                        _ => None,
                    };
                    let at = Address::new(index::VERIFY_CONFIGURATION, *sub);
                    *sub = sub.saturating_add(1);
                    let write = value.map(|value| SetupWrite {
                        at,
                        value: Value::word(value),
                    });
                    (write, Self::Store)
                }
                Self::Store => {
                    *self = Self::End;
                    return Some(SetupWrite {
                        at: Address::new(index::STORE, 1),
                        value: Value::word(SAVE),
                    });
                }
                Self::Volatile(number) => {
                    let step = VOLATILE.get(usize::from(*number));
                    *number = number.saturating_add(1);
                    (step.and_then(|step| object(setup, *step)), Self::End)
                }
                Self::End => return None,
            };
            if write.is_some() {
                return write;
            }
            *self = after;
        }
        None
    }
}

#[cfg(test)]
mod test;
