//! The object dictionary of one drive: values, and the checks on writing them.

mod check;

use protocol::canopen::node::NodeId;
use protocol::canopen::objects::{self, Access, COUNT, DataType, Initial, TABLE, index};
use protocol::canopen::sdo::{Abort, Address, ObjectAccess};

use super::parameters::DriveParameters;

/// "save", little-endian: the signature object 1010 wants.
const SAVE: u32 = u32::from_le_bytes(*b"save");
/// "load", little-endian: the signature object 1011 wants.
const LOAD: u32 = u32::from_le_bytes(*b"load");

/// The values of one drive's objects.
#[derive(Clone, Debug)]
pub(crate) struct Dictionary {
    /// Values, sign-extended to 32 bits, in the order of the object table.
    values: Box<[u32; COUNT]>,
    /// What a reset restores.
    stored: Box<[u32; COUNT]>,
    defaults: Box<[u32; COUNT]>,
    /// Is torque on? Then scaling may not change.
    pub(crate) energised: bool,
    /// Was an object written since [`Self::take_written`]?
    written: Option<Address>,
}

impl Dictionary {
    pub(crate) fn new(node: NodeId, drive: &DriveParameters) -> Self {
        let mut defaults = Box::new([0; COUNT]);
        for (value, object) in defaults.iter_mut().zip(&TABLE) {
            *value = match object.initial {
                Initial::Number(number) => low_word(number),
                Initial::PlusNode(base) => base + u32::from(node.get()),
                Initial::Text(_) => 0,
            };
        }
        let units = drive.units_per_rad();
        let own = [
            ((0x1018, 4), drive.serial),
            ((index::RATED_CURRENT, 0), drive.rated_current_ma),
            ((index::RATED_TORQUE, 0), drive.rated_torque_mnm),
            ((index::ENCODER_RESOLUTION, 1), drive.increments_per_turn),
            ((index::MAX_SPEED, 0), drive.max_speed_rpm),
            ((index::FEED_CONSTANT, 1), drive.increments_per_turn * 1000),
            // ASSUMED: 200 and 500 rad/s² to slow down and to stop quickly, 100 rad/s² in homing;
            // 15 and 3.5 rad/s are MRROC++'s synchronisation speeds.
            ((index::PROFILE_DECELERATION, 0), saturate(200.0 * units)),
            ((index::QUICK_STOP_DECELERATION, 0), saturate(500.0 * units)),
            ((index::HOMING_ACCELERATION, 0), saturate(100.0 * units)),
            ((index::HOMING_SPEEDS, 1), saturate(15.0 * units)),
            ((index::HOMING_SPEEDS, 2), saturate(3.5 * units)),
        ];
        for ((index, sub), value) in own {
            if let Some(place) = objects::find(Address::new(index, sub)) {
                defaults[place] = value;
            }
        }
        let values = defaults.clone();
        let stored = defaults.clone();
        Self {
            values,
            stored,
            defaults,
            energised: false,
            written: None,
        }
    }

    /// Back to the stored values: what a reset of the device does.
    pub(crate) fn reset(&mut self) {
        self.values.clone_from(&self.stored);
        self.energised = false;
        self.written = None;
    }

    /// The value at a place of the table, as an unsigned number.
    #[inline]
    pub(crate) fn get(&self, place: usize) -> u32 {
        self.values[place]
    }

    /// The value at a place of the table, as a signed number.
    #[inline]
    pub(crate) fn signed(&self, place: usize) -> i32 {
        self.values[place].cast_signed()
    }

    /// Sets the value at a place of the table; no checks: the drive itself writes.
    #[inline]
    pub(crate) fn set(&mut self, place: usize, value: u32) {
        self.values[place] = value;
    }

    /// Sets a signed value.
    #[inline]
    pub(crate) fn set_signed(&mut self, place: usize, value: i32) {
        self.values[place] = value.cast_unsigned();
    }

    /// The value of an object that may not exist, 0 then.
    pub(crate) fn at(&self, index: u16, sub: u8) -> u32 {
        objects::find(Address::new(index, sub)).map_or(0, |place| self.values[place])
    }

    /// The last object written over SDO, once.
    pub(crate) fn take_written(&mut self) -> Option<Address> {
        self.written.take()
    }

    /// Writes a value that came in a PDO. Mapping made sure that the object may be written; the
    /// value itself is checked as if it came over SDO, and an invalid one is ignored.
    pub(crate) fn write_mapped(&mut self, place: usize, raw: u64) {
        let object = &TABLE[place];
        let value = extend(object.data_type, low_bits(raw));
        if check::value(self, object.at, value).is_ok() {
            self.values[place] = value;
        }
    }

    fn text(place: usize) -> Option<&'static str> {
        match TABLE[place].initial {
            Initial::Text(text) => Some(text),
            Initial::Number(_) | Initial::PlusNode(_) => None,
        }
    }

    fn place(at: Address) -> Result<usize, Abort> {
        objects::find(at).ok_or(if objects::has_index(at.index) {
            Abort::NoSubIndex
        } else {
            Abort::NoObject
        })
    }

    fn store(&mut self, at: Address, value: u32) -> Result<bool, Abort> {
        match (at.index, at.sub) {
            (0x1010, 1) if value == SAVE => self.stored.clone_from(&self.values),
            (0x1011, 1) if value == LOAD => self.stored.clone_from(&self.defaults),
            (0x1010 | 0x1011, 1) => return Err(Abort::Storage),
            _ => return Ok(false),
        }
        Ok(true)
    }
}

impl ObjectAccess for Dictionary {
    fn len(&self, at: Address) -> Result<usize, Abort> {
        let place = Self::place(at)?;
        let text = Self::text(place).map_or(0, str::len);
        Ok(TABLE[place].data_type.size().unwrap_or(text))
    }

    fn read(&self, at: Address, into: &mut [u8]) -> Result<usize, Abort> {
        let place = Self::place(at)?;
        let bytes = self.values[place].to_le_bytes();
        let value = match (TABLE[place].data_type.size(), Self::text(place)) {
            (Some(size), _) => &bytes[..size],
            (None, text) => text.unwrap_or_default().as_bytes(),
        };
        into.get_mut(..value.len())
            .ok_or(Abort::Memory)?
            .copy_from_slice(value);
        Ok(value.len())
    }

    fn write(&mut self, at: Address, data: &[u8]) -> Result<(), Abort> {
        let place = Self::place(at)?;
        let object = &TABLE[place];
        match object.access {
            Access::Write => {}
            Access::Constant | Access::Read => return Err(Abort::ReadOnly),
        }
        let size = object.data_type.size().ok_or(Abort::Access)?;
        if data.len() > size {
            return Err(Abort::TooLong);
        }
        let mut bytes = [0; 4];
        bytes
            .get_mut(..size)
            .ok_or(Abort::Length)?
            .get_mut(..data.len())
            .map_or_else(
                || Err(Abort::Length),
                |to| {
                    to.copy_from_slice(data);
                    if data.len() < size {
                        Err(Abort::TooShort)
                    } else {
                        Ok(())
                    }
                },
            )?;
        let value = extend(object.data_type, u32::from_le_bytes(bytes));
        if self.store(at, value)? {
            return Ok(());
        }
        check::value(self, at, value)?;
        self.values[place] = value;
        self.written = Some(at);
        Ok(())
    }
}

/// Sign-extends a value of the object's type to 32 bits.
fn extend(kind: DataType, raw: u32) -> u32 {
    let [a, b, ..] = raw.to_le_bytes();
    match kind {
        DataType::I8 => i32::from(i8::from_le_bytes([a])).cast_unsigned(),
        DataType::I16 => i32::from(i16::from_le_bytes([a, b])).cast_unsigned(),
        DataType::U8 => u32::from(a),
        DataType::U16 => u32::from(u16::from_le_bytes([a, b])),
        DataType::I32 | DataType::U32 | DataType::Text => raw,
    }
}

fn low_bits(raw: u64) -> u32 {
    let [a, b, c, d, ..] = raw.to_le_bytes();
    u32::from_le_bytes([a, b, c, d])
}

fn low_word(number: i64) -> u32 {
    low_bits(number.cast_unsigned())
}

/// A positive number as an unsigned word, saturated.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "saturates"
)]
fn saturate(value: f64) -> u32 {
    value as u32
}

#[cfg(test)]
mod tests;
