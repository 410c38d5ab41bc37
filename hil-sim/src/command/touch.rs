//! What robots feel: their force sensors, and what stands in the way of their tools.

use core::str::FromStr;
use hil_sim::plant::contact::Plate;
use nalgebra::Vector3;

/// The force sensor of a robot: `ROBOT.BUS`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct ForceBus {
    /// The robot's name.
    pub(crate) robot: String,
    /// On which of its drive buses, from 0.
    pub(crate) bus: u8,
}

impl FromStr for ForceBus {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.rsplit_once('.');
        let read = parts.and_then(|(robot, bus)| Some((robot, bus.parse().ok()?)));
        let (robot, bus) = read.ok_or("expected ROBOT.BUS, as in irp6-postument.1")?;
        Ok(Self {
            robot: robot.to_owned(),
            bus,
        })
    }
}

/// A plate before the tool of a robot: `ROBOT:X,Y,Z:NX,NY,NZ:EDGE:STIFFNESS`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Surface {
    /// The robot's name.
    pub(crate) robot: String,
    /// The plate.
    pub(crate) plate: Plate,
}

impl FromStr for Surface {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts: Vec<&str> = text.split(':').collect();
        let &[robot, point, normal, edge, stiffness] = parts.as_slice() else {
            return Err(
                "expected ROBOT:X,Y,Z:NX,NY,NZ:EDGE:STIFFNESS, as in irp6-track:1,0,0.3:0,0,1:0.1:1e4"
                    .into(),
            );
        };
        let direction = triple(normal)?;
        let length = libm::sqrt(direction.dot(&direction));
        if length < 1e-6 {
            return Err(format!("expected a normal of some length, got {normal}"));
        }
        Ok(Self {
            robot: robot.to_owned(),
            plate: Plate {
                point_m: triple(point)?,
                normal: direction / length,
                edge_m: within(edge, "m", 0.01, 10.0)?,
                stiffness_n_m: within(stiffness, "N/m", 100.0, 1e6)?,
            },
        })
    }
}

fn triple(text: &str) -> Result<Vector3<f64>, String> {
    let numbers: Option<Vec<f64>> = text
        .split(',')
        .map(|part| part.parse().ok().filter(|x: &f64| x.is_finite()))
        .collect();
    match numbers.as_deref() {
        Some(&[x, y, z]) => Ok(Vector3::new(x, y, z)),
        _ => Err(format!("expected three numbers, got {text}")),
    }
}

fn within(text: &str, unit: &str, low: f64, high: f64) -> Result<f64, String> {
    let number = text.parse().ok().filter(|x| (low..=high).contains(x));
    number.ok_or_else(|| format!("expected {low} to {high} {unit}, got {text}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sensor_and_a_surface_are_read_as_they_are_written() {
        let force: ForceBus = "irp6-postument.1".parse().unwrap();
        assert_eq!((force.robot.as_str(), force.bus), ("irp6-postument", 1));
        let surface: Surface = "irp6-track:0.9,-0.1,2e-1:0,0,-2:0.1:1e4".parse().unwrap();
        assert_eq!(surface.robot, "irp6-track");
        let plate = Plate {
            point_m: Vector3::new(0.9, -0.1, 0.2),
            normal: Vector3::new(0.0, 0.0, -1.0),
            edge_m: 0.1,
            stiffness_n_m: 1e4,
        };
        assert_eq!(surface.plate, plate);
    }

    #[test]
    fn what_is_neither_says_what_is_expected() {
        for text in [
            "",
            "irp6-track",
            "irp6-track.",
            "irp6-track.x",
            "irp6-track.256",
        ] {
            let error = text.parse::<ForceBus>().unwrap_err();
            assert!(error.contains("expected"), "{text}: {error}");
        }
        for text in [
            "",
            "a:1,2,3",
            "a:1,2:0,0,1:0.1:1e4",
            "a:1,2,nan:0,0,1:0.1:1e4",
            "a:1,2,3:0,0,0:0.1:1e4",
            "a:1,2,3:0,0,1:0:1e4",
            "a:1,2,3:0,0,1:0.1:inf",
            "a:1,2,3:0,0,1:0.1:1e4:9",
        ] {
            let error = text.parse::<Surface>().unwrap_err();
            assert!(error.contains("expected"), "{text}: {error}");
        }
    }
}
