//! What `mrroc kin` prints and how it fails.

use clap::Parser;

use super::{Kin, KinError};

#[derive(Parser)]
struct Shell {
    #[command(flatten)]
    kin: Kin,
}

fn kin(arguments: &str, stdin: &str) -> (String, Result<(), KinError>) {
    let shell = Shell::try_parse_from(format!("kin {arguments}").split_whitespace()).unwrap();
    let mut out = Vec::new();
    let result = shell.kin.run(&mut out, &mut stdin.as_bytes());
    (String::from_utf8(out).unwrap(), result)
}

fn numbers(value: &serde_json::Value) -> Vec<f64> {
    value
        .as_array()
        .unwrap()
        .iter()
        .map(|v| v.as_f64().unwrap())
        .collect()
}

const FRONT: &str = "0,-1.57,0,1.56,1.57,-1.57";

#[test]
fn forward_by_flags() {
    let (out, result) = kin(&format!("fk irp6-postument --joints {FRONT}"), "");
    result.unwrap();
    let pose: serde_json::Value = serde_json::from_str(&out).unwrap();
    let p = numbers(&pose["position_m"]);
    assert!((p[0] - 0.6723).abs() < 6e-5 && p[1].abs() < 6e-5 && (p[2] - 0.2645).abs() < 6e-5);
    // rows: the first holds the x of N, O and A, and A points along x
    assert!(
        (numbers(&pose["rotation"][0])[2] - 1.0).abs() < 1e-3,
        "{out}"
    );
    let (tool, _) = kin(
        &format!("fk irp6-postument --joints {FRONT} --frame tool"),
        "",
    );
    let tool: serde_json::Value = serde_json::from_str(&tool).unwrap();
    assert!((numbers(&tool["position_m"])[0] - p[0] - 0.25).abs() < 1e-3);
}

#[test]
fn a_line_a_case_and_back() {
    for frame in ["flange", "tool"] {
        let q = r#"{"joints":[0.25,0.1,-1.4,0.1,0.9,1.2,0.3]}"#;
        let (pose, result) = kin(&format!("fk irp6-track --jsonl --frame {frame}"), q);
        result.unwrap();
        let near = r#","near":[0.25,0,-1.5,0,1,1,0]}"#;
        let case = format!("{}{near}\n", pose.trim_end().trim_end_matches('}'));
        let (out, result) = kin(
            &format!("ik irp6-track --jsonl --frame {frame}"),
            &case.repeat(2),
        );
        result.unwrap();
        assert_eq!(out.lines().count(), 2);
        let found: serde_json::Value = serde_json::from_str(out.lines().next().unwrap()).unwrap();
        let nearest = numbers(&found["nearest"]);
        for (got, expected) in nearest.iter().zip([0.25, 0.1, -1.4, 0.1, 0.9, 1.2, 0.3]) {
            assert!((got - expected).abs() < 1e-9, "{out}");
        }
        assert!(found["branches"].as_array().unwrap().len() >= 3);
    }
}

#[test]
fn motors_and_joints() {
    let (out, _) = kin(&format!("motors irp6-postument --joints {FRONT}"), "");
    assert!(out.starts_with("{\"motors\":[-15.9,-4.86"), "{out}");
    let (out, _) = kin("joints irp6-postument --motors 0,0,0,0,0,0", "");
    assert!(out.starts_with("{\"joints\":[-0.1006"), "{out}");
    let (out, _) = kin(&format!("jacobian irp6-postument --joints {FRONT}"), "");
    let jacobian: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!(jacobian["jacobian"].as_array().unwrap().len(), 6);
    assert_eq!(
        numbers(&jacobian["jacobian"][5])[0].to_bits(),
        1.0_f64.to_bits()
    );
}

#[test]
fn a_case_without_an_answer_is_an_answer_on_a_line_and_an_error_by_flags() {
    let out_of_triangle = r#"{"motors":[0,-300,0,0,0,0]}"#;
    let (out, result) = kin("joints irp6-postument --jsonl", out_of_triangle);
    result.unwrap();
    assert!(
        out.starts_with(
            r#"{"error":"limit","quantity":"screw-length","axis":1,"name":"lower arm""#
        ),
        "{out}"
    );
    let (out, result) = kin("joints irp6-postument --motors 0,-300,0,0,0,0", "");
    assert!(out.contains("\"limit\""));
    assert_eq!(result.unwrap_err().exit_code(), 65);
    let far =
        r#"{"position_m":[9,0,0],"rotation":[[1,0,0],[0,1,0],[0,0,1]],"near":[0,-1.5,0,0,1,0]}"#;
    let (out, result) = kin("ik irp6-postument --jsonl", far);
    result.unwrap();
    assert!(out.starts_with(r#"{"error":"unreachable""#), "{out}");
}

#[test]
fn malformed_lines_are_answered_counted_and_passed() {
    let good = r#"{"joints":[0,-1.57,0,1.56,1.57,-1.57]}"#;
    let stdin =
        format!("{good}\n{{\"joints\":[1,2]}}\nnonsense\n\n{{\"joint\":[]}}\n\u{fffd}\n{good}\n");
    let (out, result) = kin("fk irp6-postument --jsonl", &stdin);
    let lines: Vec<_> = out.lines().collect();
    assert_eq!(lines.len(), 7);
    assert_eq!(lines[0], lines[6]);
    for line in &lines[1..6] {
        assert!(
            line.starts_with(r#"{"error":"malformed","message":"line "#),
            "{line}"
        );
    }
    let error = result.unwrap_err();
    assert_eq!(error.exit_code(), 65);
    assert_eq!(
        error.to_string(),
        "5 lines of stdin are malformed, the first is line 2: \
         joints of irp6-postument: expected 6 numbers, got 2"
    );
}

#[test]
fn wrong_use_says_what_was_expected() {
    let (out, result) = kin("fk irp7 --joints 1", "");
    let error = result.unwrap_err();
    assert_eq!((out.as_str(), error.exit_code()), ("", 64));
    assert_eq!(
        error.to_string(),
        "unknown robot \"irp7\"; known: irp6-track, irp6-postument, polycrank, irp6-arm, conveyor, \
         irp6-track-gripper, irp6-postument-gripper, rnt"
    );
    for (arguments, text) in [
        (
            "fk irp6-track --joints 1,2",
            "joints of irp6-track: expected 7 numbers, got 2",
        ),
        ("fk irp6-track", "expected --joints, or --jsonl"),
        (
            "ik irp6-track --position 1,2",
            "--position: expected 3 numbers, got 2",
        ),
    ] {
        let (out, result) = kin(arguments, "");
        let error = result.unwrap_err();
        assert_eq!((out.as_str(), error.exit_code()), ("", 64));
        assert_eq!(error.to_string(), text);
    }
    let (_, result) = kin("fk irp6-postument --joints nan,0,0,0,0,0", "");
    assert_eq!(
        result.unwrap_err().to_string(),
        "a coordinate is not a finite number"
    );
}
