//! What is refused, and in which words.

use clap::Parser;
use serde_json::Value;

use super::{ONE, Shell, axes, profile, with};

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

#[test]
#[expect(clippy::too_many_lines, reason = "a table")]
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
            "--from 0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0",
            "--from: expected 1 to 16 numbers, one per axis, got 17",
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
