//! The RNT engraves: a drawing, a small program, and what cannot be engraved.

use mrroc_tests::binary::{self, Output, Scratch};
use mrroc_tests::workspace;

/// A small board for the RNT, and a step.
fn task(files: &Scratch, step: &str) -> std::path::PathBuf {
    let path = files.path("job.toml");
    let text = format!(
        r#"title = "job"
[[cell.robot]]
kind = "rnt"
[cell.board]
robot = "rnt"
position_m = [-0.05, -0.05, -1.30]
size_m = [0.10, 0.10]
thickness_m = 0.01
cutter = {{ flat_m = 2e-3 }}
[[step]]
home = ["rnt"]
[[step]]
move = {{ robot = "rnt", pose = {{ position_m = [0, 0, -1.28], rotation_rad = [0, 3.141592653589793, 0] }}, path = "joint", speed = 0.03 }}
[[step]]
{step}
"#
    );
    std::fs::write(&path, text).unwrap();
    path
}

fn run(path: &std::path::Path) -> Output {
    binary::run([
        "run".as_ref(),
        path.as_os_str(),
        "--json".as_ref(),
        "-q".as_ref(),
    ])
}

#[test]
fn the_shipped_drawing_is_engraved_on_its_path() {
    let output = run(&workspace().join("tasks/engrave.toml"));
    assert_eq!(output.code, Some(0), "{output:?}");
    let summary = output.json();
    let robot = &summary["robots"][0];
    assert_eq!(
        (&robot["limit_violations"], &robot["faults"]),
        (&0.into(), &0.into())
    );
    let board = &summary["engraving"];
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    // 2.48 m of strokes, 0.8 mm deep: a V of 60° with a flat of 0.2 mm is 0.53 mm² there
    assert!((2.4..2.55).contains(&number(&board["cut_m"])), "{board}");
    assert!(
        (1.2e-6..1.4e-6).contains(&number(&board["removed_m3"])),
        "{board}"
    );
    // the mechanics overshoot the depth by some µm
    assert!(
        (7.9e-4..8.3e-4).contains(&number(&board["depth_m"])),
        "{board}"
    );
    // units of the drives are 1.25 nm of a leg
    assert!(number(&board["setpoints"]["max_m"]) < 2e-8, "{board}");
    let mechanics = number(&board["mechanics"]["max_m"]);
    assert!(mechanics > 1e-6 && mechanics < 1e-4, "{board}");
    assert_eq!(
        (&board["stalled"], &board["collisions"]),
        (&0.into(), &0.into())
    );
}

#[test]
fn a_program_cuts_a_slot_where_it_says() {
    let files = Scratch::new("slot");
    let program =
        "G21 G90 G17\nM3 S10000\nG0 Z5\nG0 X20 Y50\nG1 Z-1 F300\nG1 X80 F1200\nG0 Z5\nM5\nM30\n";
    std::fs::write(files.path("slot.ngc"), program).unwrap();
    let step = r#"engrave = { robot = "rnt", file = "slot.ngc", scale = 1.0 }"#;
    let output = run(&task(&files, step));
    assert_eq!(output.code, Some(0), "{output:?}");
    let board = &output.json()["engraving"];
    let number = |key: &str| board[key].as_f64().unwrap();
    // 60 mm of a slot 2 mm wide and 1 mm deep, and its two ends: 123.1 mm³, to the cells of 0.1 mm
    assert!(
        (number("removed_m3") / 123.1e-9 - 1.0).abs() < 0.03,
        "{board}"
    );
    assert_eq!(
        (&board["stalled"], &board["collisions"]),
        (&0.into(), &0.into())
    );
}

#[test]
fn a_spindle_that_stands_still_is_told() {
    let files = Scratch::new("stalled");
    std::fs::write(
        files.path("a.ngc"),
        "G21 G90\nG0 Z5\nG0 X20 Y50\nG1 Z-1 F300\nG0 Z5\nM30\n",
    )
    .unwrap();
    let output = run(&task(
        &files,
        r#"engrave = { robot = "rnt", file = "a.ngc", scale = 1.0 }"#,
    ));
    assert_eq!(output.code, Some(0), "{output:?}");
    let stalled = output.json()["engraving"]["stalled"].as_u64().unwrap();
    assert!(stalled > 100, "{stalled}");
}

#[test]
fn what_cannot_be_engraved_moves_nothing_and_names_its_line() {
    let files = Scratch::new("refused");
    std::fs::write(
        files.path("a.ngc"),
        "G21 G90\nG0 X0 Y0 Z5\nG1 Z-15 F100\nM30\n",
    )
    .unwrap();
    std::fs::write(
        files.path("b.ngc"),
        "G21 G90\nG0 X0 Y0 Z5\nG38.2 Z-1 F100\nM30\n",
    )
    .unwrap();
    for (step, said) in [
        (
            r#"engrave = { robot = "rnt", file = "a.ngc", scale = 1.0 }"#,
            "cuts deeper than the board is thick (expected at most 0.01 m, see depth_m and surface_m, got 0.0150 m)",
        ),
        (r#"engrave = { robot = "rnt", file = "b.ngc" }"#, "b.ngc:3:"),
        (
            r#"engrave = { robot = "rnt", file = "none.svg" }"#,
            "cannot read the program",
        ),
        (
            r#"engrave = { robot = "rnt", file = "a.ngc", depth_m = 0.2 }"#,
            "`depth_m` out of range",
        ),
    ] {
        let output = run(&task(&files, step));
        assert_ne!(output.code, Some(0), "{step}");
        assert!(output.stderr.contains(said), "{step}: {}", output.stderr);
        assert_eq!(output.stderr.trim().lines().count(), 1, "{}", output.stderr);
    }
}
