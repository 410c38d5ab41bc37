//! The URDF of a chain, read back.

use robots::description::Range;
use robots::dynamics::{Chain, IRP6_TRACK, POLYCRANK};
use robots::urdf::{JointLimits, joint_limits, write_urdf};
use robots::{Irp6Track, Robot};

fn track() -> String {
    let limits = joint_limits(
        Irp6Track::KEEP.description(),
        &Irp6Track::KEEP.motor_slopes(),
    );
    let mut text = String::new();
    write_urdf(&mut text, "irp6-track", "", &limits, &IRP6_TRACK).unwrap();
    text
}

/// The values of an attribute, in order.
fn values<'a>(text: &'a str, attribute: &str) -> Vec<&'a str> {
    let pattern = format!(" {attribute}=\"");
    let after = text.split(&pattern).skip(1);
    after.map(|rest| rest.split('"').next().unwrap()).collect()
}

#[test]
fn numbers_come_back_to_the_bit() {
    let text = track();
    let masses = values(&text, "value");
    assert_eq!(masses.len(), 7);
    for (value, link) in masses.iter().zip(&IRP6_TRACK.links) {
        let mass: f64 = value.parse().unwrap();
        assert_eq!(mass.to_bits(), link.body().mass_kg.to_bits());
    }
    assert!(!text.contains("\"-0\"") && !text.contains("-0 "), "{text}");
    for (value, link) in values(&text, "ixx").iter().zip(&IRP6_TRACK.links) {
        let inertia: f64 = value.parse().unwrap();
        assert_eq!(inertia.to_bits(), link.body().inertia.xx.to_bits());
    }
    for (value, axis) in values(&text, "lower")
        .iter()
        .zip(&Irp6Track::KEEP.description().axes)
    {
        let lower: f64 = value.parse().unwrap();
        assert_eq!(lower.to_bits(), axis.joint_position.lower.to_bits());
    }
}

#[test]
fn every_element_is_closed_and_every_link_has_one_joint() {
    let text = track();
    assert!(text.starts_with("<?xml version=\"1.0\"?>\n<robot name=\"irp6-track\">"));
    let mut open = vec![];
    for tag in text.split('<').skip(2) {
        let tag = tag.split('>').next().unwrap();
        let name = tag
            .trim_start_matches('/')
            .split([' ', '/'])
            .next()
            .unwrap();
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name));
        } else if !tag.ends_with('/') {
            open.push(name);
        }
    }
    assert!(open.is_empty(), "{open:?}");
    let (children, parents) = (
        values(&text, "link"),
        IRP6_TRACK.links.map(|link| link.name),
    );
    // parent and child of seven joints and of the flange
    assert_eq!(children.len(), 16);
    assert_eq!(children[0], "base");
    for (k, name) in parents.iter().enumerate() {
        assert_eq!(children[2 * k + 1], *name);
        assert_eq!(children[2 * k + 2], *name);
    }
    assert_eq!(
        values(&text, "type")
            .iter()
            .filter(|kind| **kind == "revolute")
            .count(),
        6
    );
    assert_eq!(values(&text, "type")[0], "prismatic");
}

#[test]
fn the_effort_is_the_drive_at_its_trip_through_its_gear() {
    let [track, column, ..] = joint_limits(
        Irp6Track::KEEP.description(),
        &Irp6Track::KEEP.motor_slopes(),
    );
    // 25 A and 15 A at 0.105 N·m/A; 1570.8 rad/m and 158
    assert!((track.effort - 25.0 * 0.105 * 1_570.796_326_794_896_6).abs() < 1e-9);
    assert!((column.effort - 15.0 * 0.105 * 158.0).abs() < 1e-9);
    assert!(track.velocity > 0.0 && track.position.lower < track.position.upper);
}

fn unlimited(chain: &Chain<7>) -> String {
    let limits = JointLimits {
        position: Range {
            lower: f64::NEG_INFINITY,
            upper: f64::INFINITY,
        },
        velocity: 6.3,
        effort: 50.0,
    };
    let mut text = String::new();
    write_urdf(&mut text, "p", "all turn for ever", &[limits; 7], chain).unwrap();
    text
}

#[test]
fn a_joint_without_an_end_is_continuous() {
    let text = unlimited(&POLYCRANK);
    assert!(text.contains("<!-- all turn for ever -->"));
    let kinds = values(&text, "type");
    assert_eq!(
        kinds.iter().filter(|kind| **kind == "continuous").count(),
        7
    );
    assert!(!text.contains("inf") && !text.contains("NaN"));
}

/// Nothing is swallowed when the writer is full.
#[test]
fn an_error_of_the_writer_is_handed_on() {
    struct Full(usize);
    impl std::fmt::Write for Full {
        fn write_str(&mut self, text: &str) -> std::fmt::Result {
            self.0 = self.0.checked_sub(text.len()).ok_or(std::fmt::Error)?;
            Ok(())
        }
    }
    let limits = joint_limits(
        Irp6Track::KEEP.description(),
        &Irp6Track::KEEP.motor_slopes(),
    );
    let length = track().len();
    for (room, fits) in [
        (0, false),
        (length / 2, false),
        (length - 1, false),
        (length, true),
    ] {
        let result = write_urdf(&mut Full(room), "irp6-track", "", &limits, &IRP6_TRACK);
        assert_eq!(result.is_ok(), fits, "{room}");
    }
}
