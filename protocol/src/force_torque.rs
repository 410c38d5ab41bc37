//! What a force sensor in a wrist tells, on a drive bus.
//!
//! Two classical frames a sample, 11-bit: `0x680 + 2·number` with the force, `0x681 + 2·number` with the moment.
//! `CANopen`'s predefined connection set and the identifiers CiA 301 restricts leave 0x680 to 0x6DF free; the MP bus
//! uses 29 bits. Both frames:
//!
//! | bytes | what |
//! |---|---|
//! | 0–1, 2–3, 4–5 | x, y, z along the sensor's axes, little-endian, signed: 0.01 N, or 0.001 N·m about its origin |
//! | 6 | the sample's number, modulo 256: the same in both frames |
//! | 7 | [`Status`]: the same in both frames |
//!
//! The force is what all beyond the sensor exerts on it: contact, and the weight and inertia of the tool.

use crate::canopen::node::standard;
use crate::frame::{Frame, Id};

/// Force of one unit, N.
pub const FORCE_UNIT_N: f64 = 0.01;
/// Moment of one unit, N·m.
pub const MOMENT_UNIT_NM: f64 = 0.001;

/// The first identifier.
const FIRST: u16 = 0x680;
/// How many sensors there can be on a bus.
const SENSORS: u8 = 16;

/// A sensor on a bus, 0 to 15.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SensorNumber(u8);

impl SensorNumber {
    /// `None` above 15.
    #[must_use]
    pub const fn new(number: u8) -> Option<Self> {
        if number < SENSORS {
            Some(Self(number))
        } else {
            None
        }
    }

    /// The identifier of its frame with the force; that with the moment is the next.
    #[must_use]
    pub const fn force_cob(self) -> u16 {
        FIRST + 2 * self.0 as u16
    }
}

/// What a sensor says of itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Status {
    /// Bit 0: a force or a moment is beyond what the sensor is allowed to bear.
    pub over_force: bool,
    /// Bit 1: a value is cut at the end of the sensor's range, or of the 16 bits.
    pub saturated: bool,
    /// Bit 2: the sensor has failed, its values mean nothing.
    pub failed: bool,
}

impl Status {
    const fn byte(self) -> u8 {
        self.over_force as u8 | (self.saturated as u8) << 1 | (self.failed as u8) << 2
    }

    const fn from_byte(byte: u8) -> Self {
        Self {
            over_force: byte & 1 != 0,
            saturated: byte & 2 != 0,
            failed: byte & 4 != 0,
        }
    }
}

/// A sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reading {
    /// x, y, z in units of [`FORCE_UNIT_N`].
    pub force: [i16; 3],
    /// x, y, z in units of [`MOMENT_UNIT_NM`].
    pub moment: [i16; 3],
    /// The sample's number, modulo 256.
    pub number: u8,
    /// What the sensor says of itself.
    pub status: Status,
}

impl Reading {
    /// A sample of a force, N, and a moment, N·m. What is beyond 16 bits is cut, and marked as saturated; a value
    /// that is no number is 0, and marked as failed.
    #[must_use]
    pub fn new(force_n: [f64; 3], moment_nm: [f64; 3], number: u8, status: Status) -> Self {
        let mut status = status;
        Self {
            force: force_n.map(|n| units(n / FORCE_UNIT_N, &mut status)),
            moment: moment_nm.map(|nm| units(nm / MOMENT_UNIT_NM, &mut status)),
            number,
            status,
        }
    }

    /// N.
    #[must_use]
    pub fn force_n(&self) -> [f64; 3] {
        self.force.map(|units| f64::from(units) * FORCE_UNIT_N)
    }

    /// N·m.
    #[must_use]
    pub fn moment_nm(&self) -> [f64; 3] {
        self.moment.map(|units| f64::from(units) * MOMENT_UNIT_NM)
    }

    /// Its frames: force, then moment.
    #[must_use]
    pub fn frames(&self, sensor: SensorNumber) -> [Frame; 2] {
        let cob = sensor.force_cob();
        [(cob, self.force), (cob + 1, self.moment)].map(|(cob, [x, y, z])| {
            let ([x0, x1], [y0, y1]) = (x.to_le_bytes(), y.to_le_bytes());
            let [z0, z1] = z.to_le_bytes();
            let bytes = [x0, x1, y0, y1, z0, z1, self.number, self.status.byte()];
            Frame::short(Id::Standard(cob), bytes, 8)
        })
    }
}

/// The nearest whole number of units; halves away from 0.
fn units(value: f64, status: &mut Status) -> i16 {
    status.failed |= value.is_nan();
    let away = value + if value < 0.0 { -0.5 } else { 0.5 };
    status.saturated |= away >= 32_768.0 || away <= -32_769.0;
    #[expect(clippy::cast_possible_truncation, reason = "saturates; NaN becomes 0")]
    let units = away as i16;
    units
}

/// One frame's content.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Half {
    values: [i16; 3],
    number: u8,
    status: u8,
}

/// Puts the frames of one sensor together again.
#[derive(Clone, Copy, Debug)]
pub struct Receiver {
    sensor: SensorNumber,
    force: Option<Half>,
}

impl Receiver {
    /// Of this sensor.
    #[must_use]
    pub const fn new(sensor: SensorNumber) -> Self {
        Self {
            sensor,
            force: None,
        }
    }

    /// Takes a frame of the bus; a sample once its second frame has come. Frames of others, of another length, and
    /// halves that do not belong together are dropped.
    pub fn take(&mut self, frame: &Frame) -> Option<Reading> {
        let cob = standard(frame)?;
        let first = self.sensor.force_cob();
        if cob == first {
            self.force = half(frame.data());
            return None;
        }
        if cob != first + 1 {
            return None;
        }
        let (force, moment) = (self.force.take()?, half(frame.data())?);
        if (force.number, force.status) != (moment.number, moment.status) {
            return None;
        }
        Some(Reading {
            force: force.values,
            moment: moment.values,
            number: force.number,
            status: Status::from_byte(force.status),
        })
    }
}

fn half(data: &[u8]) -> Option<Half> {
    let &[x0, x1, y0, y1, z0, z1, number, status] = data else {
        return None;
    };
    Some(Half {
        values: [[x0, x1], [y0, y1], [z0, z1]].map(i16::from_le_bytes),
        number,
        status,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::canopen::node::{Function, NodeId, frame};

    const SENSOR: SensorNumber = SensorNumber(1);

    fn reading() -> Reading {
        let status = Status {
            over_force: true,
            ..Status::default()
        };
        Reading::new([1.234, -65.0, 130.0], [0.5, -0.001, 4.999_6], 7, status)
    }

    #[test]
    fn golden_bytes() {
        let [force, moment] = reading().frames(SENSOR);
        let bytes = [0x7B, 0x00, 0x9C, 0xE6, 0xC8, 0x32, 0x07, 0x01];
        assert_eq!(force, frame(0x682, bytes));
        let bytes = [0xF4, 0x01, 0xFF, 0xFF, 0x88, 0x13, 0x07, 0x01];
        assert_eq!(moment, frame(0x683, bytes));
    }

    #[test]
    fn what_is_sent_is_received_to_half_a_unit() {
        let mut receiver = Receiver::new(SENSOR);
        let [force, moment] = reading().frames(SENSOR);
        assert_eq!(receiver.take(&force), None);
        let got = receiver.take(&moment).unwrap();
        assert_eq!(got, reading());
        for (got, sent) in got.force_n().iter().zip([1.234, -65.0, 130.0]) {
            assert!((got - sent).abs() <= 0.5 * FORCE_UNIT_N + 1e-12);
        }
        for (got, sent) in got.moment_nm().iter().zip([0.5, -0.001, 4.999_6]) {
            assert!((got - sent).abs() <= 0.5 * MOMENT_UNIT_NM + 1e-12);
        }
    }

    #[test]
    fn halves_that_do_not_belong_together_are_dropped() {
        let mut receiver = Receiver::new(SENSOR);
        let [force, moment] = reading().frames(SENSOR);
        let next = Reading {
            number: 8,
            ..reading()
        };
        let [_, other] = next.frames(SENSOR);
        assert_eq!(receiver.take(&moment), None, "no force before it");
        receiver.take(&force);
        assert_eq!(receiver.take(&other), None, "another sample's");
        assert_eq!(receiver.take(&moment), None, "its force is gone");
        receiver.take(&force);
        assert_eq!(receiver.take(&frame(0x683, [0; 7])), None, "too short");
        let [_, foreign] = reading().frames(SensorNumber(0));
        receiver.take(&force);
        assert_eq!(receiver.take(&foreign), None);
        assert_eq!(
            receiver.take(&moment),
            Some(reading()),
            "foreign frames do no harm"
        );
    }

    #[test]
    fn values_that_do_not_fit_are_marked() {
        let with = |x: f64| Reading::new([x, 0.0, 0.0], [0.0; 3], 0, Status::default());
        assert_eq!(with(1e9).force[0], i16::MAX);
        assert!(with(1e9).status.saturated && with(-1e9).status.saturated);
        assert!(with(f64::INFINITY).status.saturated);
        let none = with(f64::NAN);
        assert!(none.force[0] == 0 && none.status.failed);
        assert_eq!(with(327.67).status, Status::default());
        assert_eq!(SensorNumber::new(16), None);
    }

    #[test]
    fn no_device_of_canopen_has_its_identifiers() {
        let functions = [
            Function::Emergency,
            Function::Tpdo1,
            Function::Rpdo1,
            Function::Tpdo2,
            Function::Rpdo2,
            Function::Tpdo3,
            Function::Rpdo3,
            Function::Tpdo4,
            Function::Rpdo4,
            Function::SdoAnswer,
            Function::SdoRequest,
            Function::Heartbeat,
        ];
        for number in 0..SENSORS {
            let first = SensorNumber::new(number).unwrap().force_cob();
            for id in 1..=127 {
                let node = NodeId::new(id).unwrap();
                for function in functions {
                    assert!(node.cob(function) != first && node.cob(function) != first + 1);
                }
            }
            // restricted by CiA 301
            assert!(first + 1 < 0x6E0);
        }
    }
}
