//! A task that feels its way: a motion that ends at a force, by the operator's command.

use hil_sim::plant::force_sensor::ForceFault;
use mrroc_tests::binary::{self, Output, Scratch};

const TASK: &str = "tests/data/until-force.toml";

fn seconds(output: &Output, step: &str) -> f64 {
    let summary = output.json();
    let steps = summary["steps"].as_array().unwrap().iter();
    let mut found = steps.filter(|s| s["name"] == step);
    found.next().unwrap()["duration_s"].as_f64().unwrap()
}

/// The task with other contents.
fn changed(name: &str, from: &str, to: &str) -> (Scratch, std::path::PathBuf) {
    let path = mrroc_tests::workspace().join(TASK);
    let text = std::fs::read_to_string(path).unwrap();
    assert!(text.contains(from), "{from}");
    let scratch = Scratch::new(name);
    let file = scratch.path("task.toml");
    std::fs::write(&file, text.replacen(from, to, 1)).unwrap();
    (scratch, file)
}

#[test]
fn a_motion_until_a_force_stops_at_the_surface_and_the_task_goes_on() {
    let touched = binary::run(["run", TASK, "--json", "-q"]);
    assert_eq!(touched.code, Some(0), "{touched:?}");
    // 40 mm at 10 mm/s are 4 s; the surface is 6 mm away: 0.6 s, 100 ms more to start, and what the force and its
    // reaction take, below 300 ms, and the end is told at the next macrostep
    let down = seconds(&touched, "down");
    assert!((0.6..1.3).contains(&down), "{down} s");
    let (_scratch, nothing) = changed("force-nothing", "point_m = [0.92,", "point_m = [9.92,");
    let free = binary::run([
        "run".as_ref(),
        nothing.as_os_str(),
        "--json".as_ref(),
        "-q".as_ref(),
    ]);
    assert_eq!(free.code, Some(0), "{free:?}");
    let down = seconds(&free, "down");
    assert!((4.0..4.6).contains(&down), "{down} s");
}

#[test]
fn without_the_condition_the_sensor_ends_what_it_cannot_bear() {
    let (_scratch, blind) = changed("force-blind", ", until_force_n = 10", "");
    let output = binary::run(["run".as_ref(), blind.as_os_str(), "-q".as_ref()]);
    assert_eq!(output.code, Some(10), "{output:?}");
    assert!(output.stderr.contains("fault 60:"), "{output:?}");
}

#[test]
fn a_sensor_that_breaks_on_the_way_down_ends_the_task_and_one_that_is_mended_does_not() {
    // the way down begins at 37.8 s and ends at the surface a second later
    for fault in ForceFault::ALL.map(ForceFault::name) {
        let fault = format!("irp6-postument/force:{fault}@38");
        let output = binary::run(["run", TASK, "-q", "--fault", &fault]);
        assert_eq!(output.code, Some(10), "{output:?}");
        for word in ["\"down\"", "fault 60:", "while Moving"] {
            assert!(output.stderr.contains(word), "{fault}: {output:?}");
        }
    }
    let output = binary::run(["run", TASK, "-q", "--fault", "irp6-postument/force:none@38"]);
    assert_eq!(output.code, Some(0), "{output:?}");
    let without = [
        "home",
        "irp6-postument",
        "-q",
        "--fault",
        "irp6-postument/force:failed@1",
    ];
    let output = binary::run(without);
    assert_eq!(output.code, Some(64), "{output:?}");
    assert!(output.stderr.contains("with a force sensor"), "{output:?}");
}

#[test]
fn what_cannot_be_felt_is_told_before_anything_moves() {
    for (name, from, to, word) in [
        ("force-none", "force_bus = \"wrist\"\n", "", "force_bus"),
        (
            "force-crowded",
            "force_bus = \"wrist\"",
            "force_bus = \"drives\"",
            "five drives",
        ),
        (
            "force-weak",
            "until_force_n = 10",
            "until_force_n = 0",
            "greater than 0",
        ),
        (
            "force-path",
            "until_force_n = 10",
            "until_force_n = 10, path = \"joint\"",
            "line",
        ),
        (
            "force-flat",
            "normal = [0, 0, 1]",
            "normal = [0, 0, 0]",
            "normal",
        ),
    ] {
        let (_scratch, file) = changed(name, from, to);
        let output = binary::run(["run".as_ref(), file.as_os_str(), "-q".as_ref()]);
        assert_eq!(output.code, Some(65), "{name}: {output:?}");
        assert_eq!(output.stderr.lines().count(), 1, "{name}: {output:?}");
        assert!(output.stderr.contains(word), "{name}: {output:?}");
    }
}
