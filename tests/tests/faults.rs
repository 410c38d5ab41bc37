//! Faults that are asked for on the command line: what the node says of them, and that nothing else ends the run.

use mrroc_tests::binary::{self, Scratch};

/// A move of a homed postument, with a fault in it.
fn broken(fault: &str) -> binary::Output {
    let joints = "--joints=1.0,-1.5,0.1,1.4,1.2,-1.0";
    let fault = format!("irp6-postument{fault}@24");
    binary::run(["move", "irp6-postument", joints, "-q", "--fault", &fault])
}

#[test]
fn what_breaks_is_told_with_its_cause_and_its_axis() {
    for (fault, code, axis) in [
        ("/1:frozen", 30, "axis 1 (column)"),
        ("/1:reversed", 33, "axis 1 (column)"),
        ("/4:garbage", 31, "axis 4 (T)"),
        ("/2:trip", 40, "axis 2 (lower arm)"),
        ("/6:silent", 41, "axis 6 (N)"),
        // behind the third drive, and all of them
        (".0:cut:3", 41, "axis 4 (T)"),
        (".0:short", 41, "axis 1 (column)"),
        (".0:stuck-dominant", 41, "axis 1 (column)"),
        (".0:wrecked:5", 41, "axis 5 (V)"),
    ] {
        let output = broken(fault);
        assert_eq!(output.code, Some(10), "{fault}: {output:?}");
        for word in [format!("fault {code}:"), axis.into(), "while Moving".into()] {
            assert!(
                output.stderr.contains(&word),
                "{fault}: no {word:?} in {}",
                output.stderr
            );
        }
    }
}

#[test]
fn a_node_whose_controller_is_in_trouble_says_so() {
    for (fault, told) in [
        (".0:stuck-dominant", Some("error-passive: ")),
        (".0:short", Some("bus-off: nothing is sent")),
        (".0:cut:3", None),
    ] {
        let output = broken(fault);
        let lines = output.stderr.lines();
        let of_the_bus = |line: &&str| line.contains("irp6-postument.0: ");
        let lines: Vec<&str> = lines.filter(of_the_bus).collect();
        match told {
            Some(words) => {
                let last = format!("mrroc: irp6-postument.0: {words}");
                assert!(
                    lines.iter().any(|line| line.starts_with(&last)),
                    "{fault}: {}",
                    output.stderr
                );
            }
            None => assert_eq!(lines, [""; 0], "{fault}"),
        }
    }
}

#[test]
fn what_has_no_part_in_the_motion_ends_nothing() {
    // switches and index are of homing, which is over
    for fault in ["/1:switch-on", "/1:no-index", "/1:none"] {
        let output = broken(fault);
        assert_eq!(output.code, Some(0), "{fault}: {output:?}");
    }
}

#[test]
fn a_fault_that_cannot_be_is_one_line() {
    for (fault, words) in [
        (
            "irp6-track/1:frozen@1",
            ["irp6-track/1:frozen@1", "irp6-postument"],
        ),
        ("irp6-postument/7:frozen@1", ["7:frozen", "1 to 6"]),
        ("irp6-postument.1:short@1", [".1:short", "0 to 0"]),
        ("irp6-postument/1:frozen", ["frozen", "@SECONDS"]),
        ("irp6-postument/1:melted@1", ["melted", "garbage"]),
    ] {
        let output = binary::run(["home", "irp6-postument", "-q", "--fault", fault]);
        assert_eq!(output.code, Some(64), "{output:?}");
        assert_eq!(output.stderr.lines().count(), 1, "{output:?}");
        for word in words {
            assert!(output.stderr.contains(word), "{fault}: {}", output.stderr);
        }
    }
}

/// A postument whose third drive must be this one, homed and moved.
fn named(scratch: &Scratch, serial: u32) -> std::path::PathBuf {
    let file = scratch.path("task.toml");
    let text = format!(
        r#"
        title = "A named drive"
        [[cell.robot]]
        kind = "irp6-postument"
        identities = [{{ axis = 3, vendor = 0, product = 402, revision = 0x10000, serial = {serial} }}]
        [[step]]
        home = ["irp6-postument"]
        [[step]]
        move = [{{ robot = "irp6-postument", joints = [0.1, -1.5, 0.1, 1.4, 1.2, -1.0], speed = 0.5 }}]
    "#
    );
    std::fs::write(&file, text).unwrap();
    file
}

#[test]
fn a_blank_drive_that_is_named_is_given_its_node_id_and_the_robot_homes_and_moves() {
    let scratch = Scratch::new("blank-drive");
    let task = named(&scratch, 3);
    let task = task.to_str().unwrap();
    let blank = "irp6-postument/3:blank@0";
    let output = binary::run(["run", task, "--fault", blank]);
    assert_eq!(output.code, Some(0), "{output:?}");
    let told = "drive bus 0, axis 3: its drive had no node id and was given one";
    assert!(output.stderr.contains(told), "{}", output.stderr);
    // without the fault nobody is given anything
    let output = binary::run(["run", task]);
    assert_eq!(output.code, Some(0), "{output:?}");
    assert!(!output.stderr.contains("node id"), "{}", output.stderr);
}

#[test]
fn a_blank_drive_that_is_another_is_refused_with_what_was_expected_and_what_there_is() {
    let scratch = Scratch::new("wrong-drive");
    let task = named(&scratch, 17);
    let blank = "irp6-postument/3:blank@0";
    let output = binary::run(["run", task.to_str().unwrap(), "--fault", blank]);
    assert_ne!(output.code, Some(0), "{output:?}");
    for words in [
        "axis 3: no drive without node id has the identity named",
        "serial 17)",
        "drive bus 0: a drive without node id that no axis names",
        "serial 3)",
        "fault 42:",
    ] {
        assert!(
            output.stderr.contains(words),
            "no {words:?} in {}",
            output.stderr
        );
    }
}
