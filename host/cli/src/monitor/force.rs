//! What the force sensors on a drive bus tell: force and moment as they are on the wire.
//!
//! A node passes on the force alone; who wants the moment, or to know what a sensor says of itself, must listen where the
//! sensor hangs.

use super::SILENT;
use crate::world::bus_error;
use bus::hub::HubClient;
use bus::spec::Place;
use bus::{Bus, Hears, open_can};
use host::error::Error;
use protocol::force_torque::{Reading, Receiver, SensorNumber};
use protocol::time::Micros;
use std::fmt::Write as _;

/// A bus of a hub that is not there is not waited for: whoever is on it was there before.
const HUB_PATIENCE: Micros = Micros::from_millis(500);

/// A sensor, and what was heard of it last.
struct Sensor {
    number: u8,
    receiver: Receiver,
    heard: Option<(Micros, Reading)>,
}

/// The sensors of one drive bus.
pub(super) struct Sensors {
    name: String,
    bus: Box<dyn Bus>,
    all: Vec<Sensor>,
}

impl Sensors {
    /// Those of the hub's channel of this name, or of this CAN interface.
    pub(super) fn open(place: &Place, name: &str) -> Result<Self, Error> {
        let bus: Box<dyn Bus> = match place {
            Place::Hub { host, port } => {
                let client = HubClient::connect(host, *port, name, bus::now() + HUB_PATIENCE);
                Box::new(client.map_err(|error| bus_error(&error))?)
            }
            Place::Can { .. } => {
                let (can, _) =
                    open_can(name, Hears::Standard).map_err(|error| bus_error(&error))?;
                can
            }
            Place::Slcan(_) => {
                return Err(Error::Usage {
                    what: "--force-bus opens a second bus".into(),
                    expected: "a hub, or a CAN interface".into(),
                    got: place.to_string(),
                });
            }
        };
        Ok(Self::on(name, bus))
    }

    fn on(name: &str, bus: Box<dyn Bus>) -> Self {
        let sensor = |number| {
            SensorNumber::new(number).map(|of| Sensor {
                number,
                receiver: Receiver::new(of),
                heard: None,
            })
        };
        Self {
            name: name.to_owned(),
            bus,
            all: (0..).map_while(sensor).collect(),
        }
    }

    /// Takes what has arrived.
    pub(super) fn listen(&mut self) -> Result<(), Error> {
        while let Some(received) = self.bus.receive().map_err(|error| bus_error(&error))? {
            for sensor in &mut self.all {
                if let Some(reading) = sensor.receiver.take(&received.frame) {
                    sensor.heard = Some((received.at, reading));
                }
            }
        }
        Ok(())
    }

    fn heard(&self) -> impl Iterator<Item = (u8, Micros, Reading)> {
        let sensors = self.all.iter();
        sensors.filter_map(|sensor| {
            sensor
                .heard
                .map(|(at, reading)| (sensor.number, at, reading))
        })
    }

    /// A line each.
    pub(super) fn table(&self) -> String {
        let mut text = String::new();
        for (number, at, reading) in self.heard() {
            let [fx, fy, fz] = reading.force_n();
            let [mx, my, mz] = reading.moment_nm();
            let silent = bus::now().since(at) > SILENT;
            let marks = [
                (silent, "(silent)"),
                (reading.status.over_force, "over-force"),
                (reading.status.saturated, "saturated"),
                (reading.status.failed, "failed"),
            ];
            let marks = marks.iter().filter(|(is, _)| *is).map(|(_, mark)| *mark);
            let marks = marks.collect::<Vec<_>>().join(" ");
            // writing to a String cannot fail
            let _ = writeln!(
                text,
                "      {} sensor {number}: {fx:8.2} {fy:8.2} {fz:8.2} N {mx:8.3} {my:8.3} {mz:8.3} N·m  {marks}",
                self.name
            );
        }
        text
    }

    /// A JSON value each.
    pub(super) fn json(&self) -> String {
        let mut text = String::new();
        for (number, at, reading) in self.heard() {
            let status = reading.status;
            let value = serde_json::json!({
                "bus": self.name,
                "sensor": number,
                "force_n": reading.force_n(),
                "moment_nm": reading.moment_nm(),
                "over_force": status.over_force,
                "saturated": status.saturated,
                "failed": status.failed,
                "age_ms": bus::now().since(at).0 / 1000,
            });
            let _ = writeln!(text, "{value}");
        }
        text
    }
}

#[cfg(test)]
mod test {
    use super::*;
    use bus::hub::HubServer;
    use protocol::force_torque::Status;
    use std::time::{Duration, Instant};

    #[test]
    fn a_sensor_on_a_channel_of_a_hub_is_told_with_its_moment_and_its_state() {
        let hub = HubServer::bind("127.0.0.1:0".parse().unwrap(), &["mp", "arm.1"]).unwrap();
        let place: Place = format!("hub:{}", hub.address().port()).parse().unwrap();
        assert!(Sensors::open(&place, "arm.2").is_err());
        let mut sensors = Sensors::open(&place, "arm.1").unwrap();
        let mut tap = hub.tap("arm.1").unwrap();
        let status = Status {
            saturated: true,
            ..Status::default()
        };
        let reading = Reading::new([1.0, -2.5, 81.25], [0.1, 0.0, -5.0], 9, status);
        for frame in reading.frames(SensorNumber::new(3).unwrap()) {
            tap.send(&frame).unwrap();
        }
        let until = Instant::now() + Duration::from_secs(20);
        while sensors.heard().next().is_none() {
            assert!(Instant::now() < until, "nothing is heard");
            sensors.listen().unwrap();
        }
        let told: serde_json::Value = serde_json::from_str(&sensors.json()).unwrap();
        assert_eq!(told["bus"], "arm.1");
        assert_eq!(told["sensor"], 3);
        assert_eq!(told["force_n"], serde_json::json!([1.0, -2.5, 81.25]));
        assert_eq!(told["moment_nm"], serde_json::json!([0.1, 0.0, -5.0]));
        assert_eq!(
            (&told["saturated"], &told["failed"]),
            (&true.into(), &false.into())
        );
        let table = sensors.table();
        for word in ["arm.1 sensor 3", "81.25 N", "-5.000 N·m", "saturated"] {
            assert!(table.contains(word), "{word}: {table}");
        }
        assert!(!table.contains("over-force"), "{table}");
    }
}
