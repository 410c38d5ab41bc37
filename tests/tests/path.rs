//! A path from a file, by the operator's command, streamed to the real node.

use mrroc_tests::binary::{self, Scratch};

#[test]
fn setpoints_follow_a_path_file_exactly() {
    let files = Scratch::new("path");
    let path = files.path("path.csv");
    // a curve of four points, a corner, and a line back
    let text = "x,y,z\n0,0,0\n-0.01,0.01,0\n-0.02,0.03,0\n-0.02,0.05,0.01\n\n-0.02,0.05,0.01\n-0.02,0.02,0.02\n";
    std::fs::write(&path, text).unwrap();
    let mut arguments: Vec<std::ffi::OsString> = [
        "move",
        "irp6-postument",
        "--relative",
        "--feed",
        "0.04",
        "--json",
        "-q",
        "--path",
    ]
    .map(Into::into)
    .to_vec();
    arguments.push(path.into());
    let output = binary::run(arguments);
    assert_eq!(output.code, Some(0), "{output:?}");
    let summary = output.json();
    assert_eq!(summary["robots"][0]["limit_violations"], 0);
    let measured = &summary["steps"][1]["path"];
    // the first point is where the tool is, the one of the corner is said twice
    assert_eq!(measured["points"], 5);
    let number = |key: &str| {
        measured[key]
            .as_f64()
            .unwrap_or_else(|| panic!("{key}: {measured}"))
    };
    // the chords are 14.1, 22.4 and 22.4 mm, the line 31.6 mm; a curve is a little longer
    assert!((0.0905..0.0925).contains(&number("length_m")), "{measured}");
    // units of the drives: some 0.04 µm of the tool, and what quintics leave between knots
    let error = number("setpoint_path_error_max_m");
    assert!(error > 0.0 && error < 1e-7, "{measured}");
    // 0.1 %: differences of set-points that are rounded to units
    assert!(number("feed_max_m_s") <= 0.04 * 1.001, "{measured}");
    let mean = number("length_m") / number("moving_s");
    assert!(
        (number("feed_mean_m_s") / mean - 1.0).abs() < 0.01,
        "{measured}"
    );
}

#[test]
fn a_path_out_of_reach_moves_nothing_and_names_its_line() {
    let files = Scratch::new("far-path");
    let path = files.path("far.csv");
    std::fs::write(&path, "0,0,0\n-0.01,0.01,0\n\n# far\n5,0,0\n").unwrap();
    let mut arguments: Vec<std::ffi::OsString> =
        ["move", "irp6-postument", "--relative", "-q", "--path"]
            .map(Into::into)
            .to_vec();
    arguments.push(path.into());
    let output = binary::run(arguments);
    assert_eq!(output.code, Some(11), "{output:?}");
    assert!(
        output
            .stderr
            .contains("far.csv:5: error: irp6-postument: to point 3 of the path: ")
    );
}
