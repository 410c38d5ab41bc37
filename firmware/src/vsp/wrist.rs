//! `f_v`: the force at the wrist, from its sensor on a drive bus.

use crate::config::ForceAddress;
use agent::VirtualSensor;
use protocol::force_torque::{FORCE_UNIT_N, Reading, Receiver};
use protocol::frame::Frame;
use protocol::time::Micros;

/// A sample older than this is none: three periods of the sensor, as of a drive.
const OLDEST: Micros = Micros(6000);
/// A sensor has noise: when so many samples in a row are the one before, force and moment, it tells nothing any more. With
/// noise of 0.3 units six values stay in their units half of the time at most (0.9⁶), so many times once in 10¹³.
const FROZEN: u8 = 50;

/// How much the force has changed, N: the length of the difference of two vectors. The tool's weight is in both,
/// and so is what the sensor tells where there is nothing; so the tool must not turn meanwhile.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct ForceChange;

impl VirtualSensor for ForceChange {
    type Configuration = ();
    type Effector = ();
    /// Units of the sensor.
    type Receptors = [i16; 3];
    /// The same when the motion began.
    type Own = [i16; 3];
    type Reading = f64;

    fn aggregate(&self, own: &mut [i16; 3], (): &(), (): &(), now: &[i16; 3]) -> Option<f64> {
        let mut sum = 0.0;
        for (now, then) in now.iter().zip(own) {
            let by = f64::from(i32::from(*now).saturating_sub(i32::from(*then)));
            sum += by * by;
        }
        Some(libm::sqrt(sum) * FORCE_UNIT_N)
    }
}

/// The sensor as the node knows it.
#[derive(Debug)]
pub struct Wrist {
    sensor: Option<(u8, Receiver)>,
    latest: Option<(Micros, Reading)>,
    /// So many samples were the one before.
    same: u8,
    began: [i16; 3],
}

impl Wrist {
    /// Nothing heard yet; without an address there is no sensor.
    #[must_use]
    pub fn new(address: Option<ForceAddress>) -> Self {
        Self {
            sensor: address.map(|address| (address.bus, Receiver::new(address.number))),
            latest: None,
            same: 0,
            began: [0; 3],
        }
    }

    /// A frame of a drive bus.
    pub fn on_frame(&mut self, at: Micros, bus: u8, frame: &Frame) {
        if let Some((own, receiver)) = &mut self.sensor
            && *own == bus
            && let Some(reading) = receiver.take(frame)
        {
            self.hear(at, reading);
        }
    }

    /// A sample; one of the number of the last is not new, whoever repeats it.
    fn hear(&mut self, at: Micros, reading: Reading) {
        if let Some((_, last)) = &self.latest {
            if last.number == reading.number {
                return;
            }
            let same = (last.force, last.moment) == (reading.force, reading.moment);
            self.same = if same { self.same.saturating_add(1) } else { 0 };
        }
        self.latest = Some((at, reading));
    }

    /// The latest sample, if it is one: not too old, not frozen, and nothing is wrong with it.
    fn reading(&self, now: Micros) -> Option<&Reading> {
        let (at, reading) = self.latest.as_ref()?;
        let status = reading.status;
        let good = !(status.failed || status.saturated || status.over_force);
        (good && self.same < FROZEN && now.since(*at) <= OLDEST).then_some(reading)
    }

    /// Is there a sensor, and nothing to be read of it?
    #[must_use]
    pub fn is_blind(&self, now: Micros) -> bool {
        self.sensor.is_some() && self.reading(now).is_none()
    }

    /// A motion begins.
    pub fn begin(&mut self) {
        if let Some((_, reading)) = &self.latest {
            self.began = reading.force;
        }
    }

    /// How much the force has changed since then, N.
    #[must_use]
    pub fn change_n(&mut self, now: Micros) -> Option<f64> {
        let force = self.reading(now)?.force;
        ForceChange.aggregate(&mut self.began, &(), &(), &force)
    }

    /// The force, N along the sensor's axes.
    #[must_use]
    pub fn force_n(&self, now: Micros) -> Option<[f32; 3]> {
        let reading = self.reading(now)?;
        #[expect(clippy::cast_possible_truncation, reason = "16 bits of a force")]
        let force = reading.force_n().map(|n| n as f32);
        Some(force)
    }
}

#[cfg(test)]
mod test {
    use super::*;
    use protocol::force_torque::{SensorNumber, Status};

    const SENSOR: SensorNumber = match SensorNumber::new(3) {
        Some(number) => number,
        None => panic!(),
    };

    fn wrist() -> Wrist {
        Wrist::new(Some(ForceAddress {
            bus: 1,
            number: SENSOR,
        }))
    }

    /// The next sample.
    fn tell(wrist: &mut Wrist, at: u64, bus: u8, force_n: [f64; 3], status: Status) {
        let number = wrist
            .latest
            .map_or(7, |(_, last)| last.number.wrapping_add(1));
        tell_as(wrist, at, bus, force_n, (number, status));
    }

    fn tell_as(
        wrist: &mut Wrist,
        at: u64,
        bus: u8,
        force_n: [f64; 3],
        (number, status): (u8, Status),
    ) {
        let reading = Reading::new(force_n, [0.0; 3], number, status);
        for frame in reading.frames(SENSOR) {
            wrist.on_frame(Micros(at), bus, &frame);
        }
    }

    #[test]
    fn what_it_feels_is_told_from_where_the_motion_began() {
        let mut wrist = wrist();
        assert!(wrist.is_blind(Micros(0)));
        tell(&mut wrist, 1000, 1, [1.0, -2.0, 8.0], Status::default());
        wrist.begin();
        assert_eq!(wrist.force_n(Micros(2000)), Some([1.0, -2.0, 8.0]));
        assert_eq!(wrist.change_n(Micros(2000)), Some(0.0));
        // 3, 4, 12: 13
        tell(&mut wrist, 3000, 1, [4.0, 2.0, -4.0], Status::default());
        let change = wrist.change_n(Micros(9000)).unwrap();
        assert!((change - 13.0).abs() < 1e-9);
        assert_eq!(wrist.change_n(Micros(9001)), None, "three periods old");
        assert!(wrist.is_blind(Micros(9001)));
    }

    #[test]
    fn a_sample_that_is_none_is_not_told() {
        for status in [
            Status {
                failed: true,
                ..Status::default()
            },
            Status {
                saturated: true,
                ..Status::default()
            },
            Status {
                over_force: true,
                ..Status::default()
            },
        ] {
            let mut wrist = wrist();
            tell(&mut wrist, 0, 1, [0.0; 3], status);
            assert!(wrist.is_blind(Micros(0)) && wrist.change_n(Micros(0)).is_none());
            tell(&mut wrist, 0, 1, [0.0; 3], Status::default());
            assert!(!wrist.is_blind(Micros(0)));
        }
        // no number
        let mut wrist = wrist();
        tell(&mut wrist, 0, 1, [f64::NAN, 0.0, 0.0], Status::default());
        assert!(wrist.is_blind(Micros(0)));
        // of another bus
        tell(&mut wrist, 0, 0, [0.0; 3], Status::default());
        assert!(wrist.is_blind(Micros(0)));
    }

    #[test]
    fn a_sample_that_is_repeated_is_none() {
        let mut wrist = wrist();
        let fine = (255, Status::default());
        tell_as(&mut wrist, 0, 1, [1.0; 3], fine);
        tell_as(&mut wrist, 6000, 1, [2.0; 3], fine);
        assert_eq!(wrist.force_n(Micros(6000)), Some([1.0; 3]));
        assert!(wrist.is_blind(Micros(6001)), "the number of the last");
        // after 255 comes 0, and what is lost in between is no harm
        tell_as(&mut wrist, 6001, 1, [2.0; 3], (0, Status::default()));
        assert_eq!(wrist.force_n(Micros(6001)), Some([2.0; 3]));
    }

    #[test]
    fn a_value_without_noise_is_none_after_a_tenth_of_a_second() {
        let mut wrist = wrist();
        let mut at = 0;
        let mut next = |wrist: &mut Wrist, z: f64| {
            at += 2000;
            tell(wrist, at, 1, [1.0, 2.0, z], Status::default());
            wrist.is_blind(Micros(at))
        };
        assert!(!next(&mut wrist, 3.0));
        for _ in 1..FROZEN {
            assert!(!next(&mut wrist, 3.0));
        }
        assert!(next(&mut wrist, 3.0) && next(&mut wrist, 3.0));
        // a unit of one component is enough
        assert!(!next(&mut wrist, 3.01));
        for _ in 1..FROZEN {
            assert!(!next(&mut wrist, 3.01));
        }
        assert!(!next(&mut wrist, 3.0));
    }

    #[test]
    fn where_there_is_none_nobody_is_blind() {
        let mut wrist = Wrist::new(None);
        tell(&mut wrist, 0, 1, [1.0; 3], Status::default());
        assert!(!wrist.is_blind(Micros(0)) && wrist.force_n(Micros(0)).is_none());
    }
}
