//! What `mrroc robot show` prints and how it fails.

use clap::Parser;
use process::{End, exit};
use robots::dynamics::IRP6_TRACK;
use robots::{Irp6Track, Robot as _, RobotKind};
use serde_json::Value;

use super::Robot;

#[derive(Parser)]
struct Shell {
    #[command(flatten)]
    robot: Robot,
}

fn show(arguments: &str) -> Result<String, End> {
    let line = format!("robot show {arguments}");
    let shell = Shell::try_parse_from(line.split_whitespace()).unwrap();
    let mut out = Vec::new();
    shell.robot.run(&mut out)?;
    Ok(String::from_utf8(out).unwrap())
}

#[test]
fn numbers_of_the_json_are_those_of_the_robot() {
    let shown: Value = serde_json::from_str(&show("irp6-track --json").unwrap()).unwrap();
    let axes = shown["axes"].as_array().unwrap();
    assert_eq!(axes.len(), 7);
    for (axis, of_robot) in axes.iter().zip(&Irp6Track::KEEP.description().axes) {
        assert_eq!(axis["name"], of_robot.name);
        let value = |item: &str| {
            let rows = axis["parameters"].as_array().unwrap();
            let row = rows.iter().find(|row| row["item"] == item).unwrap();
            (
                row["values"][0].as_f64().unwrap(),
                row["source"].as_str().unwrap().to_owned(),
            )
        };
        assert_eq!(
            value("joint position"),
            (of_robot.joint_position.lower, "MRROC++".into())
        );
        assert_eq!(
            value("motor jerk, hard"),
            (of_robot.hard_limits.jerk, "ASSUMED".into())
        );
        assert_eq!(
            value("rotor inertia"),
            (of_robot.motor.rotor_kg_m2, "irp6_robot".into())
        );
    }
    for (link, of_chain) in shown["links"]
        .as_array()
        .unwrap()
        .iter()
        .zip(&IRP6_TRACK.links)
    {
        assert_eq!(link["mass_kg"].as_f64(), Some(of_chain.body().mass_kg));
        assert_eq!(
            link["inertia_kg_m2"][2][2].as_f64(),
            Some(of_chain.body().inertia.zz)
        );
        assert_eq!(link["source"], "ASSUMED");
    }
}

#[test]
fn every_row_has_a_unit_and_a_source() {
    for kind in RobotKind::ALL {
        let shown: Value = serde_json::from_str(&show(&format!("{kind} --json")).unwrap()).unwrap();
        let of_axes = shown["axes"].as_array().unwrap().iter();
        let rows = of_axes.flat_map(|axis| axis["parameters"].as_array().unwrap());
        for row in rows.chain(shown["robot"].as_array().unwrap()) {
            let source = row["source"].as_str().unwrap();
            assert!(
                ["MRROC++", "irp6_robot", "ASSUMED"].contains(&source),
                "{row}"
            );
            assert!(!row["unit"].as_str().unwrap().is_empty(), "{row}");
            assert!(row["values"][0].is_number(), "{row}");
        }
    }
}

#[test]
fn people_read_axes_and_links() {
    let text = show("irp6-track").unwrap();
    assert!(
        text.starts_with("irp6-track: IRp-6 on its track\n"),
        "{text}"
    );
    assert!(text.contains("\naxis 3: lower arm, revolute\n"), "{text}");
    let jerk = text
        .lines()
        .find(|line| line.contains("motor jerk, hard"))
        .unwrap();
    assert!(
        jerk.contains("60000 rad/s³") && jerk.ends_with("ASSUMED"),
        "{jerk}"
    );
    let arm = text
        .lines()
        .find(|line| line.contains("  lower-arm"))
        .unwrap();
    assert!(arm.contains("8 kg") && arm.ends_with("ASSUMED"), "{arm}");
}

#[test]
fn the_urdf_names_its_robot_and_its_assumptions() {
    let text = show("irp6-postument --urdf").unwrap();
    assert!(text.contains("<robot name=\"irp6-postument\">"), "{text}");
    assert!(text.contains("<!-- IRp-6 on its postument") && text.contains("ASSUMED -->"));
    assert!(text.trim_end().ends_with("</robot>"));
    assert_eq!(text.matches("<mass").count(), 6);
}

#[test]
fn an_unknown_robot_is_a_mistake_of_use() {
    assert_eq!(show("irp7").unwrap_err().code, exit::USAGE);
    let both = Shell::try_parse_from(["robot", "show", "irp6-track", "--urdf", "--json"]);
    assert!(both.is_err());
}
