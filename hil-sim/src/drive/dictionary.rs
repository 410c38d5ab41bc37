//! The object dictionary of one drive: values, and the checks on writing them.

mod check;
pub(crate) mod program;

use protocol::canopen::node::NodeId;
use protocol::canopen::objects::{self, Access, COUNT, DataType, Initial, Mappable, TABLE, index};
use protocol::canopen::sdo::{Abort, Address, CAPACITY, ObjectAccess};

use super::parameters::DriveParameters;
use super::quirk::{Quirk, Quirks};
use program::Program;

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
    /// Of which some concern objects.
    quirks: Quirks,
    /// Does the drive hang on a bus with CAN FD?
    fd: bool,
    /// Object 2000: now and stored.
    note: [Vec<u8>; 2],
    program: Program,
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
            (
                (index::MAX_PROFILE_VELOCITY, 0),
                saturate(drive.max_speed_rad_s() * units),
            ),
            ((index::PROFILE_VELOCITY, 0), saturate(50.0 * units)),
            ((index::PROFILE_ACCELERATION, 0), saturate(200.0 * units)),
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
            quirks: drive.quirks,
            fd: drive.fd,
            note: [Vec::new(), Vec::new()],
            program: Program::default(),
        }
    }

    /// The node identifier changed from `from` to `to`: defaults that contain it change with it.
    pub(crate) fn set_node(&mut self, from: NodeId, to: NodeId) {
        for (place, object) in TABLE.iter().enumerate() {
            let Initial::PlusNode(base) = object.initial else {
                continue;
            };
            let (old, new) = (base + u32::from(from.get()), base + u32::from(to.get()));
            self.defaults[place] = new;
            for value in [&mut self.stored[place], &mut self.values[place]] {
                if *value == old {
                    *value = new;
                }
            }
        }
    }

    /// The default of each object, as this drive has it.
    pub(crate) fn default_of(&self, object: &objects::Object) -> Option<i64> {
        let place = objects::find(object.at)?;
        let raw = *self.defaults.get(place)?;
        Some(if object.data_type.is_signed() {
            i64::from(raw.cast_signed())
        } else {
            i64::from(raw)
        })
    }

    /// Back to the stored values: what a reset of the device does.
    pub(crate) fn reset(&mut self) {
        self.values.clone_from(&self.stored);
        let [now, stored] = &mut self.note;
        now.clone_from(stored);
        self.publish_program();
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

    fn text(&self, place: usize) -> Option<&[u8]> {
        let [note, _] = &self.note;
        match TABLE[place].initial {
            Initial::Text(_) if TABLE[place].at.index == index::NOTE => Some(note),
            Initial::Text(_) if TABLE[place].at.index == index::PROGRAM_DATA => {
                Some(self.program.data())
            }
            Initial::Text(text) => Some(text.as_bytes()),
            Initial::Number(_) | Initial::PlusNode(_) => None,
        }
    }

    fn place(&self, at: Address) -> Result<usize, Abort> {
        let lacking = match at.index {
            index::INTERPOLATION_PERIOD => self.quirks.has(Quirk::NoInterpolationPeriod),
            index::VERIFY_CONFIGURATION => self.quirks.has(Quirk::NoVerifyConfiguration),
            _ => false,
        };
        if lacking {
            return Err(Abort::NoObject);
        }
        objects::find(at).ok_or(if objects::has_index(at.index) {
            Abort::NoSubIndex
        } else {
            Abort::NoObject
        })
    }

    fn store(&mut self, at: Address, value: u32) -> Result<bool, Abort> {
        match (at.index, at.sub) {
            (index::STORE, 1) if value == SAVE => {
                self.stored.clone_from(&self.values);
                let [now, stored] = &mut self.note;
                stored.clone_from(now);
            }
            (index::RESTORE, 1) if value == LOAD => {
                self.stored.clone_from(&self.defaults);
                let [_, stored] = &mut self.note;
                stored.clear();
            }
            (index::STORE | index::RESTORE, 1) => return Err(Abort::Storage),
            _ => return Ok(false),
        }
        Ok(true)
    }
}

impl ObjectAccess for Dictionary {
    fn len(&self, at: Address) -> Result<usize, Abort> {
        let place = self.place(at)?;
        let text = self.text(place).map_or(0, <[u8]>::len);
        Ok(TABLE[place].data_type.size().unwrap_or(text))
    }

    fn read(&self, at: Address, into: &mut [u8]) -> Result<usize, Abort> {
        let place = self.place(at)?;
        if at.index == index::ERROR_HISTORY && u32::from(at.sub) > self.at(at.index, 0) {
            // so many errors have not happened
            return Err(Abort::NoData);
        }
        let bytes = self.values[place].to_le_bytes();
        let value = match (TABLE[place].data_type.size(), self.text(place)) {
            (Some(size), _) => &bytes[..size],
            (None, text) => text.unwrap_or_default(),
        };
        into.get_mut(..value.len())
            .ok_or(Abort::Memory)?
            .copy_from_slice(value);
        Ok(value.len())
    }

    fn write(&mut self, at: Address, data: &[u8]) -> Result<(), Abort> {
        let place = self.place(at)?;
        let object = &TABLE[place];
        match object.access {
            Access::Write => {}
            Access::Constant | Access::Read => return Err(Abort::ReadOnly),
        }
        let Some(size) = object.data_type.size() else {
            if at.index == index::PROGRAM_DATA {
                return self.load_program(data);
            }
            if data.len() > CAPACITY {
                return Err(Abort::TooLong);
            }
            let [note, _] = &mut self.note;
            *note = data.to_vec();
            return Ok(());
        };
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
        if at.index == index::PROGRAM_CONTROL {
            return self.control_program(value);
        }
        self.values[place] = value;
        if is_configuration(object) {
            for sub in [1, 2] {
                self.values[objects::slot(index::VERIFY_CONFIGURATION, sub)] = 0;
            }
        }
        self.written = Some(at);
        Ok(())
    }
}

/// Does writing it make another configuration than object 1020 tells of? What can be a set-point does not.
const fn is_configuration(object: &objects::Object) -> bool {
    let tells = matches!(
        object.at.index,
        index::ERROR_HISTORY | index::STORE | index::RESTORE | index::VERIFY_CONFIGURATION
    );
    !tells && matches!(object.mappable, Mappable::No)
}

/// Sign-extends a value of the object's type to 32 bits.
fn extend(kind: DataType, raw: u32) -> u32 {
    let [a, b, ..] = raw.to_le_bytes();
    match kind {
        DataType::I8 => i32::from(i8::from_le_bytes([a])).cast_unsigned(),
        DataType::I16 => i32::from(i16::from_le_bytes([a, b])).cast_unsigned(),
        DataType::U8 => u32::from(a),
        DataType::U16 => u32::from(u16::from_le_bytes([a, b])),
        DataType::I32 | DataType::U32 | DataType::Text | DataType::Domain => raw,
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
