//! What `mrroc robot report` answers, against the robots and against numbers known otherwise.

use clap::Parser;
use process::{End, exit};
use robots::report::posture;
use robots::{Irp6Postument, Joints, Rnt, RobotKind};
use serde_json::Value;

use super::super::Robot;

#[derive(Parser)]
struct Shell {
    #[command(flatten)]
    robot: Robot,
}

fn report(arguments: &str) -> Result<String, End> {
    let line = format!("robot report {arguments}");
    let shell = Shell::try_parse_from(line.split_whitespace()).unwrap();
    let mut out = Vec::new();
    shell.robot.run(&mut out)?;
    Ok(String::from_utf8(out).unwrap())
}

fn as_json(arguments: &str) -> Value {
    serde_json::from_str(&report(&format!("{arguments} --json")).unwrap()).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    let values = value.as_array().unwrap();
    values.iter().map(|v| v.as_f64().unwrap()).collect()
}

#[test]
fn a_posture_is_that_of_the_robot() {
    let shown = as_json("irp6-postument --joints 0,-1.57,0,1.56,0.8,-1.57");
    let joints = Joints([0.0, -1.57, 0.0, 1.56, 0.8, -1.57]);
    let expected = posture(&Irp6Postument, &joints, 0.25).unwrap();
    assert_eq!(numbers(&shown["singular_values"]), expected.singular_values);
    assert_eq!(shown["condition"], expected.condition());
    assert_eq!(shown["near_singular"], false);
    // T stands 0.0457 rad below its upper limit of 92°
    let t = &shown["axes"][3];
    let left = t["joint"][1].as_f64().unwrap();
    assert!((left - (92.0_f64.to_radians() - 1.56)).abs() < 1e-12);
    assert_eq!(shown["nearest_joint"]["axis"], "T");
    assert!(shown["legs"].is_null());
}

#[test]
fn a_stretched_wrist_is_near_a_singularity() {
    let shown = as_json("irp6-postument --joints 0,-1.57,0,1.56,0,-1.57");
    assert_eq!(shown["near_singular"], true);
    let values = numbers(&shown["singular_values"]);
    assert!(values.len() == 6 && values[5] < 1e-15, "{shown}");
}

#[test]
fn robots_of_fewer_axes_have_as_many_singular_values() {
    let shown = as_json("irp6-arm --joints 0,-1.57,0,1.56,0.8");
    assert_eq!(numbers(&shown["singular_values"]).len(), 5);
    assert_eq!(shown["near_singular"], false, "{shown}");
    // a belt moves by as much as it is driven, and has no limits
    let belt = as_json("conveyor --joints 12.5");
    assert_eq!(numbers(&belt["singular_values"]), [1.0]);
    assert!(belt["axes"][0]["joint"][0].is_null(), "{belt}");
    assert_eq!(
        numbers(&as_json("polycrank --joints 0,1,0,0,1,0,0")["singular_values"]).len(),
        6
    );
}

#[test]
fn the_rnt_tells_of_its_legs() {
    let legs = &as_json("rnt --joints 0,0,1.1,0,1.047,0")["legs"];
    // at no tilt L² = r² + (B − a)², so ∂L/∂r = r/L of every leg, and √3 of them along the reach
    let slope = 1.1 / libm::sqrt(1.1 * 1.1 + 0.25 * 0.25);
    let greatest = numbers(&legs["singular_values"])[0];
    assert!((greatest - libm::sqrt(3.0) * slope).abs() < 1e-12, "{legs}");
    let condition = legs["condition"].as_f64().unwrap();
    let jacobian = Rnt
        .leg_jacobian(&Joints([0.0, 0.0, 1.1, 0.0, 1.0, 0.0]))
        .unwrap();
    // by tilting y, leg 2 and 3 alone change, one as the other not: their column is √2 of a leg
    let tilt = libm::sqrt(2.0) * jacobian[1][0].abs();
    assert!((condition - greatest / tilt).abs() < 1e-9, "{legs}");
}

#[test]
fn a_workspace_is_what_the_lengths_allow() {
    let shown = as_json("irp6-postument");
    let flange = shown["flange_m"].as_array().unwrap();
    for axis in &flange[..2] {
        // lower arm, upper arm and wrist stretched out; with the lower arm up to 40° off the vertical
        // (−130°…−50°) and the wrist seldom straight, most of it is met
        let reach = 0.455 * libm::cos(50.0_f64.to_radians()) + 0.67 + 0.19;
        for side in numbers(axis) {
            assert!(side.abs() <= reach && side.abs() > 0.8 * reach, "{shown}");
        }
    }
    assert!(shown["manipulability"]["worst"].as_f64() < shown["manipulability"]["median"].as_f64());
    let belt = as_json("conveyor");
    assert_eq!(belt["driveable"], belt["samples"]);
    let along = numbers(&belt["flange_m"][0]);
    // a metre of an endless belt
    assert!((-0.5..-0.49).contains(&along[0]) && (0.49..0.5).contains(&along[1]));
}

#[test]
fn the_share_near_singular_is_that_of_the_wrist() {
    let shown = as_json("rnt");
    // the wrist's least singular value is w2/√2 or a little less: below 0.05 of ±110° is 3.7 %;
    // of 4036 evenly spread samples, a percent of it
    let expected = 0.05 * libm::sqrt(2.0) / 110.0_f64.to_radians();
    let share = shown["near_singular"].as_f64().unwrap();
    assert!(
        (expected * 0.95..expected * 1.05).contains(&share),
        "{share} {expected}"
    );
    assert_eq!(numbers(&shown["work_area"]["size_m"]), [0.8, 0.6]);
    assert!(shown["legs"]["worst_condition"].as_f64().unwrap() > 3.5);
}

#[test]
fn every_robot_has_a_report_and_always_the_same() {
    for kind in RobotKind::ALL {
        let first = report(&kind.to_string()).unwrap();
        assert_eq!(first, report(&kind.to_string()).unwrap());
        assert!(first.starts_with(&format!("{kind}\n")), "{first}");
        let shown = as_json(kind.name());
        assert!(shown["driveable"].as_u64().unwrap() > 500, "{shown}");
    }
}

#[test]
fn what_cannot_be_answered_is_refused() {
    assert_eq!(report("irp7").unwrap_err().code, exit::USAGE);
    let few = report("rnt --joints 1,2").unwrap_err();
    assert_eq!(few.code, exit::USAGE);
    assert!(few.text.contains("6 joints, not 2"), "{}", few.text);
    // 60° of tilt: beyond what is known of the tripod
    assert_eq!(
        report("rnt --joints 1.05,0,1.1,0,1,0").unwrap_err().code,
        exit::REFUSED
    );
    let nan = Shell::try_parse_from(["robot", "report", "conveyor", "--joints", "nan"]);
    assert!(nan.is_err());
}
