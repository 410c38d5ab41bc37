//! What `mrroc plan profile` prints, draws and refuses.

use clap::Parser;
use motion::profile::{ProfileError, TrajectoryError, Violation};
use proptest::prelude::*;
use serde_json::Value;

use super::case::Names;
use super::motion::{MOST_AXES, NoMotion};
use super::{Plan, PlanError, line};

#[derive(Parser)]
struct Shell {
    #[command(flatten)]
    plan: Plan,
}

/// `mrroc plan profile` with these arguments.
fn profile(arguments: &str, stdin: &str) -> (String, Result<(), PlanError>) {
    let words = format!("plan profile {arguments}");
    let shell = Shell::try_parse_from(words.split_whitespace()).unwrap();
    let mut out = Vec::new();
    let result = shell.plan.run(&mut out, &mut stdin.as_bytes());
    (String::from_utf8(out).unwrap(), result)
}

const ONE: &str = "--from 0 --to 1 --v-max 0.5 --a-max 1 --j-max 10";

/// A number per axis.
fn each(axes: usize, number: &str) -> String {
    vec![number; axes].join(",")
}

fn axes(axes: usize) -> String {
    let [p0, p1, limit] = ["0", "1", "2"].map(|number| each(axes, number));
    format!("--from {p0} --to {p1} --v-max {limit} --a-max {limit} --j-max {limit}")
}

/// The same shape and words, and numbers equal to 1e-9: a motion keeps its asked ends to 1e-12, a change
/// of the planner's rounding is no change of what it says.
fn alike(one: &Value, other: &Value) -> bool {
    match (one, other) {
        (Value::Number(x), Value::Number(y)) => {
            (x.as_f64().unwrap() - y.as_f64().unwrap()).abs() < 1e-9
        }
        (Value::Array(x), Value::Array(y)) => {
            x.len() == y.len() && x.iter().zip(y).all(|(x, y)| alike(x, y))
        }
        (Value::Object(x), Value::Object(y)) => {
            x.len() == y.len()
                && x.iter()
                    .all(|(key, x)| y.get(key).is_some_and(|y| alike(x, y)))
        }
        _ => one == other,
    }
}

#[test]
fn lines_are_answered_as_they_always_were() {
    let (out, result) = profile("--jsonl", include_str!("golden/cases.jsonl"));
    let golden = include_str!("golden/motions.jsonl");
    assert_eq!(out.lines().count(), golden.lines().count());
    for (got, expected) in out.lines().zip(golden.lines()) {
        let [got_value, value]: [Value; 2] =
            [got, expected].map(|t| serde_json::from_str(t).unwrap());
        assert!(alike(&got_value, &value), "got {got}\nexpected {expected}");
    }
    assert_eq!(
        result.unwrap_err().to_string(),
        "2 lines of stdin are malformed, the first is line 9: p0: axis 2: number out of range at column 14"
    );
}

#[test]
fn a_motion_by_flags_takes_as_long_as_the_formula_says() {
    let (out, result) = profile(&format!("{ONE} --json"), "");
    result.unwrap();
    let answer: Value = serde_json::from_str(&out).unwrap();
    // a/j + v/a + D/v, all limits reached; rounding of seven phases
    assert!(
        (answer["duration_s"].as_f64().unwrap() - 2.6).abs() < 1e-12,
        "{out}"
    );
    assert_eq!(answer["axes"][0].as_array().unwrap().len(), 7);
    let (table, result) = profile(ONE, "");
    result.unwrap();
    assert!(
        table.starts_with("Motion of 1 axis in 2.6 s; proved\n\naxis 1: 7 phases, 2.6 s\n"),
        "{table}"
    );
    // two lines of head, seven phases, the end
    assert_eq!(table.lines().count(), 3 + 2 + 7 + 1);
    assert!(
        table.ends_with(&format!(
            "{:>14}{:>28}{:>14}{:>14}\n",
            "2.600000", "1.000000", 0, 0
        )),
        "{table}"
    );
}

#[test]
fn axes_wait_for_each_other_as_asked() {
    let two = "--from 0,0 --to 1,0.25 --v-max 1,1 --a-max 1,1 --j-max 10,10 --json";
    let ends = |sync: &str| {
        let (out, result) = profile(&format!("{two} {sync}"), "");
        result.unwrap();
        let answer: Value = serde_json::from_str(&out).unwrap();
        let end = |axis: usize| -> f64 {
            let phases = answer["axes"][axis].as_array().unwrap();
            phases
                .iter()
                .map(|phase| phase["t"].as_f64().unwrap())
                .sum()
        };
        (end(0), end(1), answer)
    };
    let (first, second, _) = ends("--sync none");
    assert!(second < 0.7 * first, "{first} {second}");
    let (_, _, default) = ends("");
    for sync in ["--sync time", "--sync phase"] {
        let (first, second, answer) = ends(sync);
        // sums of at most 16 phases of about a second
        assert!((first - second).abs() < 1e-12, "{first} {second}");
        assert_eq!(answer == default, sync == "--sync time");
    }
    let (first, second, _) = ends("--minimum-duration 5");
    assert!((first - 5.0).abs() < 1e-12 && (second - 5.0).abs() < 1e-12);
}

#[test]
fn any_number_of_axes_up_to_sixteen_is_planned() {
    for n in 1..=MOST_AXES {
        let (out, result) = profile(&format!("{} --json", axes(n)), "");
        result.unwrap();
        let answer: Value = serde_json::from_str(&out).unwrap();
        assert_eq!(answer["axes"].as_array().unwrap().len(), n);
    }
}

#[test]
fn seventeen_axes_and_none_are_refused() {
    let (out, result) = profile(&axes(17), "");
    let error = result.unwrap_err();
    assert_eq!((out.as_str(), error.exit_code()), ("", 64));
    assert_eq!(
        error.to_string(),
        "--from: expected 1 to 16 numbers, one per axis, got 17"
    );
    let none = r#"{"p0":[],"p1":[],"v_max":[],"a_max":[],"j_max":[]}"#;
    let (out, result) = profile("--jsonl", none);
    assert_eq!(result.unwrap_err().exit_code(), 65);
    assert!(
        out.contains("p0: expected 1 to 16 numbers, one per axis, got 0"),
        "{out}"
    );
}

/// A good line with one key replaced or added.
fn with(key: &str, value: &str) -> String {
    let mut line = String::from("{");
    for (name, good) in [
        ("p0", "[0]"),
        ("p1", "[1]"),
        ("v_max", "[1]"),
        ("a_max", "[1]"),
        ("j_max", "[1]"),
    ] {
        if name != key {
            line += &format!("\"{name}\":{good},");
        }
    }
    line + &format!("\"{key}\":{value}}}")
}

#[test]
fn a_malformed_line_is_told_by_its_place_and_the_rest_goes_on() {
    let p0 = |value| with("p0", value);
    for (line, what) in [
        (p0("[1e999]"), "p0: axis 1: number out of range at column"),
        (p0("[-1e999]"), "p0: axis 1: number out of range at column"),
        (p0("[0,NaN]"), "p0: axis 2: expected value at column"),
        (
            p0("[\"1\"]"),
            "p0: axis 1: invalid type: string \"1\", expected f64 at column",
        ),
        (
            p0("[null]"),
            "p0: axis 1: invalid type: null, expected f64 at column",
        ),
        (
            p0("1"),
            "p0: invalid type: integer `1`, expected a list of numbers at column",
        ),
        (
            p0("[0],\"p0\":[0]"),
            "p0: expected once, got twice at column",
        ),
        (
            p0("null"),
            "p0: invalid type: null, expected a list of numbers at column",
        ),
        (
            with("p1", "[1,2]"),
            "p1: expected as many numbers as p0 (1), got 2",
        ),
        (
            with("v0", "[]"),
            "v0: expected as many numbers as p0 (1), got 0",
        ),
        (
            with("p_max", "[1,2]"),
            "p_max: expected as many numbers as p0 (1), got 2",
        ),
        (
            with("j_max", "[0]"),
            "j_max: axis 1: expected a number above 0, got 0",
        ),
        (
            with("v_max", "[-1]"),
            "v_max: axis 1: expected a number above 0, got -1",
        ),
        (
            with("a_min", "[0]"),
            "a_min: axis 1: expected a number below 0, got 0",
        ),
        (
            with("sync", "\"fast\""),
            "sync: unknown variant `fast`, expected one of `time`, `none`, `phase`",
        ),
        (with("sync", "1"), "sync: "),
        (
            with("minimum_duration", "-1"),
            "minimum_duration: expected 0 or more, got -1",
        ),
        (
            with("minimum_duration", "1e400"),
            "minimum_duration: number out of range at column",
        ),
        (with("p2", "[1]"), "unknown key \"p2\", expected p0, v0, a0"),
        (
            r#"{"p0":[0]}"#.into(),
            "p1: expected as many numbers as p0 (1), got none",
        ),
        (
            r#"{"p1":[0]}"#.into(),
            "p0: expected 1 to 16 numbers, one per axis, got none",
        ),
        ("[]".into(), "invalid type: sequence, expected an object"),
        (String::new(), "EOF while parsing a value"),
        ("nonsense".into(), "expected ident at column"),
        (p0("[0]") + " x", "trailing characters at column"),
        ("\u{fffd}".into(), "expected value at column"),
    ] {
        let good = with("v0", "[0]");
        let (out, result) = profile("--jsonl", &format!("{good}\n{line}\n{good}\n"));
        let answers: Vec<&str> = out.lines().collect();
        assert_eq!(answers.len(), 3, "{line}");
        assert!(answers[0].starts_with("{\"duration_s\":") && answers[0] == answers[2]);
        let answer: Value = serde_json::from_str(answers[1]).unwrap();
        assert_eq!(answer["error"], "malformed");
        let message = answer["message"].as_str().unwrap();
        assert!(
            message.starts_with(&format!("line 2 of stdin: {what}")),
            "{message}"
        );
        let error = result.unwrap_err();
        assert_eq!(
            (error.exit_code(), error.to_string().as_str()),
            (65, message)
        );
    }
}

#[test]
fn a_case_without_a_motion_is_an_answer_on_a_line_and_an_error_by_flags() {
    for (key, value, flags, code) in [
        ("v1", "[1.5]", "--to-velocity 1.5", "end-outside-limits"),
        (
            "a1",
            "[-1.5]",
            "--to-acceleration=-1.5",
            "end-outside-limits",
        ),
        ("p_max", "[0.5]", "--p-max 0.5", "outside-range"),
        ("p_min", "[0.5]", "--p-min 0.5", "outside-range"),
    ] {
        let (out, result) = profile("--jsonl", &with(key, value));
        result.unwrap();
        let answer: Value = serde_json::from_str(&out).unwrap();
        assert_eq!(
            (&answer["error"], &answer["axis"]),
            (&code.into(), &0.into()),
            "{out}"
        );
        let (same, result) = profile(
            &format!("--from 0 --to 1 --v-max 1 --a-max 1 --j-max 1 --json {flags}"),
            "",
        );
        let error = result.unwrap_err();
        assert_eq!((same, error.exit_code()), (out, 65));
        assert_eq!(answer["message"], error.to_string());
    }
    let (out, result) = profile(&format!("{ONE} --p-max 0.5"), "");
    assert_eq!((out.as_str(), result.unwrap_err().exit_code()), ("", 65));
}

#[test]
fn wrong_use_says_what_was_expected() {
    for (arguments, text) in [
        (
            "",
            "expected --from, --to, --v-max, --a-max and --j-max, or --jsonl",
        ),
        (
            "--to 1",
            "--from: expected 1 to 16 numbers, one per axis, got none",
        ),
        (
            "--from 0",
            "--to: expected as many numbers as --from (1), got none",
        ),
        (
            "--from 0 --to 1,2",
            "--to: expected as many numbers as --from (1), got 2",
        ),
        (
            "--from 0 --to 1 --from-velocity 1,2",
            "--from-velocity: expected as many numbers as --from (1), got 2",
        ),
        (
            "--from 0 --to 1 --v-max 0",
            "--v-max: axis 1: expected a number above 0, got 0",
        ),
        (
            &format!("{ONE} --v-min 1"),
            "--v-min: axis 1: expected a number below 0, got 1",
        ),
        (
            &format!("{ONE} --minimum-duration=-1"),
            "--minimum-duration: expected 0 or more, got -1",
        ),
    ] {
        let (out, result) = profile(arguments, "");
        let error = result.unwrap_err();
        assert_eq!((out.as_str(), error.exit_code()), ("", 64), "{arguments}");
        assert_eq!(error.to_string(), text);
    }
    for (arguments, word) in [
        ("--from nan", "finite"),
        ("--p-max inf", "finite"),
        ("--from 0 --jsonl", "cannot be used with"),
        ("--jsonl --plot a.svg", "cannot be used with"),
        ("--sync fast", "time, none, phase"),
    ] {
        let words = format!("plan profile {arguments}");
        let error = Shell::try_parse_from(words.split_whitespace())
            .err()
            .unwrap();
        assert!(error.to_string().contains(word), "{error}");
    }
}

#[test]
fn the_picture_is_written_and_another_ending_is_refused() {
    let folder = std::env::temp_dir().join(format!("mrroc-plan-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let place = folder.display();
    for n in [1, 7, 16] {
        let plots = format!("--plot {place}/{n}.svg --plot {place}/{n}.png");
        let (_, result) = profile(&format!("{} {plots} --unit m", axes(n)), "");
        result.unwrap();
        let svg = std::fs::read_to_string(folder.join(format!("{n}.svg"))).unwrap();
        for words in [
            "position [m]",
            "velocity [m/s]",
            "acceleration [m/s²]",
            "jerk [m/s³]",
            &format!("axis {n}"),
        ] {
            assert!(svg.contains(&format!(">{words}</text>")), "{words}");
        }
        let png = std::fs::read(folder.join(format!("{n}.png"))).unwrap();
        assert_eq!(&png[..8], b"\x89PNG\r\n\x1a\n");
    }
    let (out, result) = profile(&format!("{ONE} --plot {place}/a.gif"), "");
    assert_eq!((out.as_str(), result.unwrap_err().exit_code()), ("", 64));
    let (_, result) = profile(&format!("{ONE} --plot {place}/nowhere/a.svg"), "");
    assert_eq!(result.unwrap_err().exit_code(), 73);
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn a_motion_that_is_not_the_asked_one_is_not_proved() {
    let asked = line::case(with("v0", "[0.5]").as_bytes())
        .unwrap()
        .asked(Names::Keys)
        .unwrap();
    let motion = asked.plan().unwrap().unwrap();
    assert_eq!(asked.prove(&motion), Ok(()));
    let mut later = asked.clone();
    later.end[0].p += 1e-6;
    let unproved = NoMotion::Unproved {
        axis: 0,
        violation: Violation::End,
    };
    assert_eq!(later.prove(&motion), Err(unproved));
    let mut slower = asked.clone();
    slower.bounds[0].j_max *= 0.999;
    assert!(slower.prove(&motion).is_err());
    let mut jumping = motion.clone();
    jumping.axes[0][1].p0 += 1e-6;
    assert_eq!(
        asked.prove(&jumping),
        Err(NoMotion::Unproved {
            axis: 0,
            violation: Violation::Jump { phase: 1 }
        })
    );
    let mut missing = motion.clone();
    missing.axes.clear();
    assert_eq!(
        asked.prove(&missing),
        Err(unproved),
        "an axis that is not planned is not proved"
    );
    let error = PlanError::from(unproved);
    assert_eq!(error.exit_code(), 70);
    assert_eq!(
        error.to_string(),
        "internal error: the motion planned for axis 1 is wrong: does not end in the asked state; please report it"
    );
    let refused = TrajectoryError {
        axis: Some(0),
        reason: ProfileError::LeavesRange,
    };
    assert_eq!(PlanError::from(NoMotion::Refused(refused)).exit_code(), 65);
}

proptest! {
    #[test]
    fn what_is_printed_is_the_motion_to_the_last_bit(
        p in prop::collection::vec(-10.0..10.0f64, 2..=6),
        v in -0.9..0.9f64,
        limits in prop::array::uniform3(1.0..50.0f64),
    ) {
        let axes = p.len() / 2;
        let (p0, p1) = (&p[..axes], &p[axes..2 * axes]);
        let [v_max, a_max, j_max] = limits.map(|limit| vec![limit; axes]);
        let line = serde_json::json!({
            "p0": p0, "p1": p1, "v0": vec![v; axes], "v_max": v_max, "a_max": a_max, "j_max": j_max,
        });
        let line = line.to_string();
        let asked = line::case(line.as_bytes()).unwrap().asked(Names::Keys).unwrap();
        let read: Vec<u64> = asked.start.iter().map(|start| start.p.to_bits()).collect();
        prop_assert_eq!(read, p0.iter().map(|x| x.to_bits()).collect::<Vec<u64>>());
        let motion = asked.plan().unwrap().unwrap();
        let (out, result) = profile("--jsonl", &line);
        prop_assert!(result.is_ok());
        let answer: Value = serde_json::from_str(&out).unwrap();
        prop_assert_eq!(answer["duration_s"].as_f64().unwrap().to_bits(), motion.duration.to_bits());
        for (printed, phases) in answer["axes"].as_array().unwrap().iter().zip(&motion.axes) {
            let printed = printed.as_array().unwrap();
            prop_assert_eq!(printed.len(), phases.len());
            for (printed, phase) in printed.iter().zip(phases) {
                for (key, x) in [("t", phase.t), ("j", phase.j), ("a0", phase.a0), ("v0", phase.v0), ("p0", phase.p0)] {
                    prop_assert_eq!(printed[key].as_f64().unwrap().to_bits(), x.to_bits());
                }
            }
        }
    }
}
