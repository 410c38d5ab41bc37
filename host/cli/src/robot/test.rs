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

const SOURCES: [&str; 5] = [
    "MRROC++",
    "irp6_robot",
    "GraspIt! model",
    "by definition",
    "ASSUMED",
];

/// The sources of all rows of a robot, and of the places of its links.
fn sources(kind: RobotKind) -> Vec<(String, String)> {
    let shown: Value = serde_json::from_str(&show(&format!("{kind} --json")).unwrap()).unwrap();
    let list = |value: &Value| value.as_array().unwrap().clone();
    let mut rows = list(&shown["robot"]);
    for axis in list(&shown["axes"]) {
        rows.extend(list(&axis["parameters"]));
    }
    let text = |value: &Value| value.as_str().unwrap().to_owned();
    let of_rows = rows
        .iter()
        .map(|row| (text(&row["item"]), text(&row["source"])));
    let links = list(&shown["links"]);
    let of_links = links
        .iter()
        .map(|link| ("link".to_owned(), text(&link["geometry"])));
    of_rows.chain(of_links).collect()
}

#[test]
fn of_the_rnt_everything_is_assumed() {
    for (item, source) in sources(RobotKind::Rnt) {
        assert_eq!(source, "ASSUMED", "{item}");
    }
}

#[test]
fn of_polycrank_only_tool_and_links_are_known() {
    for (item, source) in sources(RobotKind::Polycrank) {
        let known = item == "link" || item == "default tool, in the flange";
        let expected = if known { "GraspIt! model" } else { "ASSUMED" };
        assert_eq!(source, expected, "{item}");
    }
}

#[test]
fn the_lesser_robots_have_sources_of_their_own() {
    use RobotKind::{Conveyor, Irp6Arm, Irp6Postument, Irp6TrackGripper};
    for (kind, item, expected) in [
        (Irp6Postument, "overcurrent", "MRROC++"),
        (Irp6Postument, "base, in the world", "MRROC++"),
        (Irp6Arm, "overcurrent", "ASSUMED"),
        (Irp6Arm, "motor at the reference", "MRROC++"),
        (Irp6Arm, "base, in the world", "ASSUMED"),
        (Conveyor, "current regulator limit", "ASSUMED"),
        (Conveyor, "torque constant", "irp6_robot"),
        (Conveyor, "default tool, in the flange", "by definition"),
        (Irp6TrackGripper, "motor velocity, planning", "ASSUMED"),
        (Irp6TrackGripper, "homing velocity, coarse", "MRROC++"),
        (Irp6TrackGripper, "homing velocity, fine", "ASSUMED"),
    ] {
        let rows = sources(kind);
        let (_, source) = rows.iter().find(|(of, _)| of == item).unwrap();
        assert_eq!(source, expected, "{kind}: {item}");
    }
}

#[test]
fn assumed_numbers_are_listed_with_their_reasons() {
    let text = show("rnt").unwrap();
    assert!(
        text.contains("  rnt: lead of the ball screws of the legs: 0.01 m/turn   a common lead")
    );
    assert!(
        text.contains("  RNT platform: 12 kg   a steel disc"),
        "{text}"
    );
    let shown: Value = serde_json::from_str(&show("conveyor --json").unwrap()).unwrap();
    let count = robots::ASSUMED.len() + robots::dynamics::ASSUMED.len();
    assert_eq!(shown["assumed"].as_array().unwrap().len(), count);
}

#[test]
fn the_urdf_of_a_loop_says_what_it_leaves_out() {
    let text = show("rnt --urdf").unwrap();
    assert!(text.contains("the tree part of the robot"), "{text}");
    assert!(text.contains("geometry: ASSUMED"), "{text}");
    assert!(!show("irp6-track --urdf").unwrap().contains("tree part"));
}

#[test]
fn without_links_there_is_no_urdf() {
    for name in ["conveyor", "irp6-track-gripper", "irp6-postument-gripper"] {
        let end = show(&format!("{name} --urdf")).unwrap_err();
        assert_eq!(end.code, exit::USAGE);
        let line = end.text;
        assert!(line.contains(name) && !line.contains('\n'), "{line}");
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
            assert!(SOURCES.contains(&source), "{row}");
            assert!(!row["unit"].as_str().unwrap().is_empty(), "{row}");
            let endless = row["item"].as_str().unwrap().ends_with(" position");
            let value = &row["values"][0];
            assert!(value.is_number() || endless && value.is_null(), "{row}");
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
