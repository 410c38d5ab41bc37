//! Ctrl-C during a motion: a stop on the path, and an end that says so.
#![cfg(unix)]

use mrroc_tests::binary::{self, Scratch};
use std::time::Duration;

const TASK: &str = r#"
title = "a long way without homing"
[cell]
[[cell.robot]]
kind = "irp6-postument"
[[step]]
name = "turn"
move = { robot = "irp6-postument", motors = [120, 0, 0, 0, 0, 0], relative = true, speed = 0.1 }
"#;

#[test]
fn an_interrupt_stops_on_the_path() {
    let files = Scratch::new("interrupt");
    let task = files.file("long.toml", TASK);
    let record = files.path("long.log");
    let mut running = binary::start([
        "run".as_ref(),
        task.as_os_str(),
        "--realtime".as_ref(),
        "--json".as_ref(),
        "-q".as_ref(),
        "--record".as_ref(),
        record.as_os_str(),
    ]);
    // long after torque is on, long before the motion ends by itself (some 20 s)
    std::thread::sleep(Duration::from_secs(4));
    assert!(!running.has_ended(), "{:?}", running.finish());
    let id = running.id().to_string();
    let sent = std::process::Command::new("kill")
        .args(["-INT", &id])
        .status()
        .unwrap();
    assert!(sent.success());
    let output = running.finish();
    assert_eq!(output.code, Some(12), "{output:?}");
    assert_eq!(
        output.stderr,
        "mrroc: step \"turn\": stopped by the operator (Path)\n"
    );
    let summary = output.json();
    assert_eq!(summary["ok"], false);
    assert!(
        summary["error"]
            .as_str()
            .unwrap()
            .contains("stopped by the operator"),
        "{summary}"
    );
    let robot = &summary["robots"][0];
    assert_eq!(
        (&robot["faults"], &robot["limit_violations"]),
        (&0.into(), &0.into()),
        "{summary}"
    );
    assert!(summary["duration_s"].as_f64().unwrap() < 20.0);
}
