//! Which values an object accepts.

use protocol::canopen::cia402::{HomingMethod, Mode, Options};
use protocol::canopen::objects::{self, Access, Mappable, TABLE, index};
use protocol::canopen::pdo::{Entry, MAX_ENTRIES, Mapping, MappingError, Transmission};
use protocol::canopen::sdo::{Abort, Address};

use super::Dictionary;

/// Bit 31 of a PDO's identifier: it does not exist.
const OFF: u32 = 1 << 31;

/// Is `value` (sign-extended) acceptable for the object `at`?
pub(super) fn value(od: &Dictionary, at: Address, value: u32) -> Result<(), Abort> {
    let signed = value.cast_signed();
    within_limits(at, value)?;
    let good = match at.index {
        index::ERROR_HISTORY => value == 0,
        index::SYNC_COB => value & !0x4000_07FF == 0,
        index::EMERGENCY_COB => value & !0x8000_07FF == 0,
        index::CONSUMER_HEARTBEAT => (value >> 16) & 0xFF <= 127 && value >> 24 == 0,
        index::SYNC_OVERFLOW => value == 0 || (2..=240).contains(&value),
        0x1400..=0x1403 | 0x1800..=0x1803 => return communication(od, at, value),
        0x1600..=0x1603 => return mapping(od, at, value, true),
        0x1A00..=0x1A03 => return mapping(od, at, value, false),
        // nobody could hear it on a classical bus
        index::FAST_SLOT if value > 0 && !od.fd => return Err(Abort::DeviceState),
        index::QUICK_STOP_OPTION => narrow(signed).and_then(Options::quick_stop).is_some(),
        index::MODE => i8::try_from(signed)
            .ok()
            .and_then(Mode::from_code)
            .is_some(),
        index::HOMING_METHOD => i8::try_from(signed)
            .ok()
            .and_then(HomingMethod::from_code)
            .is_some(),
        index::ENCODER_RESOLUTION | index::GEAR_RATIO | index::FEED_CONSTANT => {
            if od.energised {
                return Err(Abort::DeviceState);
            }
            true
        }
        _ => true,
    };
    if good { Ok(()) } else { Err(Abort::Range) }
}

/// The limits of the table.
fn within_limits(at: Address, value: u32) -> Result<(), Abort> {
    let Some(object) = objects::find(at).map(|place| &TABLE[place]) else {
        return Ok(());
    };
    let number = if object.data_type.is_signed() {
        i64::from(value.cast_signed())
    } else {
        i64::from(value)
    };
    match object.limits {
        Some((low, _)) if number < i64::from(low) => Err(Abort::TooLow),
        Some((_, high)) if number > i64::from(high) => Err(Abort::TooHigh),
        Some(_) | None => Ok(()),
    }
}

fn narrow(value: i32) -> Option<i16> {
    i16::try_from(value).ok()
}

fn communication(od: &Dictionary, at: Address, value: u32) -> Result<(), Abort> {
    let now = od.at(at.index, 1);
    let active = now & OFF == 0;
    match at.sub {
        1 => {
            let stays = active && value & OFF == 0;
            if value & 0x3FFF_F800 != 0 {
                return Err(Abort::Range);
            }
            if stays && (value ^ now) & 0x7FF != 0 {
                // An active PDO keeps its identifier: it must be switched off first.
                return Err(Abort::DeviceState);
            }
            if value & OFF == 0 && is_restricted(value & 0x7FF) {
                return Err(Abort::Range);
            }
            Ok(())
        }
        2 => {
            let code = u8::try_from(value).ok().and_then(Transmission::from_code);
            code.map(drop).ok_or(Abort::Range)
        }
        3 if active => Err(Abort::DeviceState),
        _ => Ok(()),
    }
}

/// Identifiers CiA 301 keeps from process data.
fn is_restricted(cob: u32) -> bool {
    matches!(
        cob,
        0x000..=0x07F | 0x101..=0x180 | 0x581..=0x5FF | 0x601..=0x67F | 0x6E0..=0x6FF | 0x701..
    )
}

fn mapping(od: &Dictionary, at: Address, value: u32, receive: bool) -> Result<(), Abort> {
    if od.at(at.index - 0x200, 1) & OFF == 0 {
        return Err(Abort::DeviceState);
    }
    if at.sub > 0 {
        if od.at(at.index, 0) != 0 {
            return Err(Abort::DeviceState);
        }
        return if value == 0 {
            Ok(())
        } else {
            entry(Entry(value), receive)
        };
    }
    let count = usize::try_from(value)
        .ok()
        .filter(|count| *count <= MAX_ENTRIES);
    let count = count.ok_or(Abort::Range)?;
    let entries: Vec<Entry> = (1..=8)
        .map(|sub| Entry(od.at(at.index, sub)))
        .take(count)
        .collect();
    for item in &entries {
        entry(*item, receive)?;
    }
    Mapping::new(&entries)
        .map(drop)
        .map_err(|error| match error {
            MappingError::TooLong => Abort::PdoLength,
            MappingError::TooMany | MappingError::Bits => Abort::NotMappable,
        })
}

/// May this object be mapped, with this length?
fn entry(entry: Entry, receive: bool) -> Result<(), Abort> {
    if entry.is_dummy() {
        return if receive {
            Ok(())
        } else {
            Err(Abort::NotMappable)
        };
    }
    let at = entry.address();
    let place = objects::find(at).ok_or(if objects::has_index(at.index) {
        Abort::NoSubIndex
    } else {
        Abort::NoObject
    })?;
    let object = &TABLE[place];
    let allowed = match (object.mappable, receive) {
        (Mappable::No, _) | (Mappable::Transmit, true) => false,
        (Mappable::Transmit, false) => true,
        (Mappable::Both, receive) => !receive || object.access == Access::Write,
    };
    let fits = object
        .data_type
        .size()
        .is_some_and(|size| size * 8 == usize::from(entry.bits()));
    if allowed && fits {
        Ok(())
    } else {
        Err(Abort::NotMappable)
    }
}
