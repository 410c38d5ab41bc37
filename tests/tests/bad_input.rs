//! Whatever a user gets wrong: one line that says what, where, expected and got, the documented exit
//! code, and nothing moves.

use bus::hub::HubServer;
use mrroc_tests::binary::{self, Output, Scratch};
use mrroc_tests::watch::ever_had_torque;
use std::ffi::OsString;
use std::path::Path;

const JOINTS: &str = "--joints=0,-1.5,0.1,1.4,1.2,-1.0";

/// One line, the code, every word, no sign of a panic.
fn told(what: &str, output: &Output, code: i32, words: &[&str]) {
    assert_eq!(output.code, Some(code), "{what}: {output:?}");
    let error = &output.stderr;
    assert!(
        error.starts_with("mrroc: ") && error.ends_with('\n'),
        "{what}: {error}"
    );
    assert_eq!(error.lines().count(), 1, "{what}: {error}");
    assert!(error.len() < 400, "{what}: {error}");
    for word in words {
        assert!(error.contains(word), "{what}: no {word:?} in {error}");
    }
    for word in ["panicked", "backtrace", "unwrap", "internal error"] {
        assert!(!error.contains(word), "{what}: {error}");
    }
}

fn arguments(text: &[&str]) -> Vec<OsString> {
    text.iter().map(OsString::from).collect()
}

/// Runs with a record, and looks into it: no drive was ever asked for torque and confirmed it.
fn unmoved(scratch: &Scratch, what: &str, mut arguments: Vec<OsString>, code: i32, words: &[&str]) {
    let record = scratch.path("record.log");
    let _ = std::fs::remove_file(&record);
    arguments.extend([
        "-q".into(),
        "--record".into(),
        record.clone().into_os_string(),
    ]);
    told(what, &binary::run(arguments), code, words);
    assert!(!ever_had_torque(&record), "{what}: something had torque");
}

#[test]
#[expect(clippy::too_many_lines, reason = "a table")]
fn the_command_line() {
    let mv = |more: &[&str]| arguments(&[&["move", "irp6-postument"], more].concat());
    let home = |more: &[&str]| arguments(&[&["home", "irp6-track"], more].concat());
    let run = |more: &[&str]| arguments(&[&["run"], more].concat());
    let plan = |more: &[&str]| arguments(&[&["plan", "profile"], more].concat());
    for (arguments, code, words) in [
        (
            mv(&[JOINTS, "--speed", "-1"]),
            64,
            &["-1", "--speed", "above 0 and at most 1"][..],
        ),
        (
            mv(&[JOINTS, "--speed=-1"]),
            64,
            &["-1", "--speed", "above 0 and at most 1"],
        ),
        (
            mv(&[JOINTS, "--speed=0"]),
            64,
            &["'0'", "above 0 and at most 1"],
        ),
        (mv(&[JOINTS, "--speed=1e309"]), 64, &["1e309", "finite"]),
        (mv(&[JOINTS, "--speed=NaN"]), 64, &["NaN", "finite"]),
        (mv(&[JOINTS, "--speed=1,5"]), 64, &["1,5", "--speed"]),
        (
            mv(&["--joints=0,nan,0,0,0,0"]),
            64,
            &["nan", "--joints", "finite"],
        ),
        (mv(&["--joints=0,0x10,0,0,0,0"]), 64, &["0x10", "--joints"]),
        (mv(&["--joints=0,,0,0,0,0"]), 64, &["--joints"]),
        (
            mv(&["--joints=0,1"]),
            64,
            &["--joints", "expected 6 values", "got 2"],
        ),
        (
            mv(&["--pose=0,0,0"]),
            64,
            &["--pose", "expected 6 values", "got 3"],
        ),
        (mv(&[]), 64, &["required"]),
        (
            mv(&[JOINTS, "--motors=0,0,0,0,0,0"]),
            64,
            &["--joints", "cannot be used"],
        ),
        (
            arguments(&["move", "irp7", JOINTS]),
            64,
            &["irp7", "irp6-track or irp6-postument"],
        ),
        (home(&["--seed=-1"]), 64, &["--seed", "-1"]),
        (
            home(&["--bus", "wire"]),
            64,
            &["wire", "virtual", "hub:PORT"],
        ),
        (home(&["--bus", "hub:99999"]), 64, &["99999", "port"]),
        (home(&["--bus", "hub:192.0.2.1:29536"]), 64, &["192.0.2.1"]),
        (home(&["--plot", "a.gif"]), 64, &["a.gif", ".svg or .png"]),
        (arguments(&["home"]), 64, &["required", "ROBOTS"]),
        (
            arguments(&["home", "irp6-trac"]),
            64,
            &["irp6-trac", "irp6-track"],
        ),
        (arguments(&["frobnicate"]), 64, &["frobnicate"]),
        (
            plan(&["--from=0,0", "--to=1"]),
            64,
            &["--to", "as --from (2)", "got 1"],
        ),
        (
            plan(&[&format!("--from=0{}", ",0".repeat(16))]),
            64,
            &["--from", "1 to 16", "got 17"],
        ),
        (plan(&["--from=0", "--to=1e999"]), 64, &["--to", "1e999"]),
        (
            arguments(&["stop", "--kind", "slow"]),
            64,
            &["slow", "path, quick or torque-off"],
        ),
        (run(&["tasks/track-reach.trj"]), 64, &["--robot"]),
        (
            run(&["tasks/track-reach.trj", "--robot", "irp7"]),
            64,
            &["irp7", "irp6-track"],
        ),
        (
            run(&["tasks/two-arms.toml", "--robot", "irp6-track"]),
            64,
            &["--robot", ".trj"],
        ),
        (
            run(&["tasks/nowhere.toml"]),
            66,
            &["tasks/nowhere.toml", "no such file"],
        ),
        (
            run(&["tasks"]),
            66,
            &["tasks", "not a file", "expected", "got"],
        ),
        (
            run(&["tasks/nowhere.trj", "--robot", "irp6-track"]),
            66,
            &["tasks/nowhere.trj"],
        ),
        (
            run(&["tasks/two-arms.toml", "--record", "nowhere/a.log"]),
            73,
            &["nowhere/a.log"],
        ),
        (
            run(&["tasks/two-arms.toml", "--plot", "nowhere/a.svg"]),
            73,
            &["nowhere/a.svg"],
        ),
    ] {
        told(
            &format!("{arguments:?}"),
            &binary::run(&arguments),
            code,
            words,
        );
    }
}

#[test]
fn targets_out_of_reach() {
    let scratch = Scratch::new("targets");
    let mv = |target: &str| arguments(&["move", "irp6-postument", target]);
    for (target, words) in [
        (
            "--joints=9,-1.5,0.1,1.4,1.2,-1.0",
            &["column", "9", "2.96"][..],
        ),
        ("--motors=500,0,0,0,0,0", &["column", "-3.26", "-2.96"]),
        ("--joints=0,-1.5,0.1,1.4,1.2,1e300", &["N", "2.93"]),
        ("--pose=5,0,0,0,0,0", &["irp6-postument"]),
        ("--pose=0,0,-3,0,0,0", &["irp6-postument"]),
    ] {
        unmoved(&scratch, target, mv(target), 11, words);
    }
}

/// A task of one robot and these steps.
fn task(steps: &str) -> String {
    format!("title = \"t\"\n[cell]\n[[cell.robot]]\nkind = \"irp6-postument\"\n{steps}")
}

const STEP: &str = "[[step]]\nname = \"s\"\n";

/// Twice 250 us for each of the track's seven axes and 55 us of SYNC are 1805 us of 2000.
#[test]
fn a_cell_whose_drives_have_not_enough_bus() {
    let scratch = Scratch::new("bus-load");
    let cell = mrroc_tests::workspace().join("tasks/cell.toml");
    let cell = std::fs::read_to_string(cell).unwrap();
    let split = [
        "axes = [1, 2, 3, 4]",
        "bus = \"track-wrist\", axes = [5, 6, 7]",
    ];
    assert!(split.iter().all(|part| cell.contains(part)));
    let crowded = cell.replace(split[0], "axes = [1, 2, 3, 4, 5, 6, 7]");
    let lines: Vec<&str> = crowded
        .lines()
        .filter(|line| !line.contains(split[1]))
        .collect();
    let crowded = lines.join("\n");
    let file = scratch.file("cell.toml", &crowded);
    let arguments = |json: bool| {
        let words: [OsString; 3] = ["bus".into(), "load".into(), file.clone().into()];
        words.into_iter().chain(json.then(|| "--json".into()))
    };
    let output = binary::run(arguments(false));
    assert_eq!(output.code, Some(65), "{output:?}");
    let line = output.stdout.lines().find(|l| l.starts_with("track-arm "));
    let line = line.unwrap_or_else(|| panic!("{output:?}"));
    assert!(line.contains(": more than 82 %"), "{line}");
    let buses = binary::run(arguments(true)).json();
    let fits = |name: &str| {
        let mut buses = buses["buses"].as_array().unwrap().iter();
        buses.find(|bus| bus["name"] == name).unwrap()["fits"].clone()
    };
    assert_eq!(
        (fits("track-arm"), fits("postument")),
        (false.into(), true.into())
    );

    let home = format!("title = \"t\"\ncell = \"cell.toml\"\n{STEP}home = [\"irp6-track\"]\n");
    let task = scratch.file("task.toml", &home);
    unmoved(
        &scratch,
        "a crowded bus",
        vec!["run".into(), task.into_os_string()],
        64,
        &["bus track-arm", "82 %", "see mrroc bus load"],
    );
}

#[test]
#[expect(clippy::too_many_lines, reason = "a table")]
fn tasks() {
    let scratch = Scratch::new("tasks");
    let home = format!("{STEP}home = [\"irp6-postument\"]\n");
    let step = |text: &str| task(&format!("{STEP}{text}\n"));
    let six = "[0, -1.5, 0.1, 1.4, 1.2, -1.0]";
    let mv = |more: &str| step(&format!("move = {{ robot = \"irp6-postument\", {more} }}"));
    for (what, text, code, words) in [
        ("empty", String::new(), 65, &["title"][..]),
        ("no TOML", "title =".into(), 65, &[":1:"]),
        ("binary", "\u{0}\u{1}".into(), 65, &[":1:"]),
        (
            "key unknown",
            task(&format!("colour = 1\n{home}")),
            65,
            &["colour"],
        ),
        (
            "key of a step unknown",
            step("hom = [\"irp6-postument\"]"),
            65,
            &[":7:", "hom"],
        ),
        (
            "key twice",
            format!("title = \"a\"\n{}", task(&home)),
            65,
            &[":2:"],
        ),
        ("wrong type", step("wait = 3"), 65, &[":7:", "expected"]),
        (
            "wrong type of a number",
            mv("joints = \"six\""),
            65,
            &[":7:", "expected"],
        ),
        (
            "nan",
            mv("joints = [0, nan, 0, 0, 0, 0]"),
            65,
            &[":7:", "finite"],
        ),
        (
            "inf",
            mv(&format!("joints = {six}, speed = inf")),
            65,
            &[":7:"],
        ),
        (
            "too fast",
            mv(&format!("joints = {six}, speed = 1.5")),
            65,
            &["1.5", "at most 1"],
        ),
        ("too few values", mv("joints = [0, 1]"), 65, &["6", "2"]),
        (
            "two targets",
            mv(&format!("joints = {six}, motors = {six}")),
            65,
            &["joints", "motors"],
        ),
        (
            "robot unknown",
            step("home = [\"irp7\"]"),
            65,
            &[":7:", "irp7", "irp6-postument"],
        ),
        ("no step", task(""), 65, &["step"]),
        (
            "file missing",
            step("trj = { irp6-postument = \"no.trj\" }"),
            66,
            &[":7:", "no.trj"],
        ),
        (
            "not homed",
            mv(&format!("joints = {six}")),
            11,
            &[":5:", "irp6-postument", "hom"],
        ),
        (
            "out of limits",
            task(&format!(
                "{home}{STEP}move = {{ robot = \"irp6-postument\", joints = [9, 0, 0, 0, 0, 0] }}\n"
            )),
            11,
            &[":8:", "column", "9"],
        ),
    ] {
        let file = scratch.file("task.toml", &text);
        unmoved(
            &scratch,
            what,
            vec!["run".into(), file.clone().into()],
            code,
            words,
        );
        let error = binary::run(["run".as_ref(), file.as_os_str(), "-q".as_ref()]).stderr;
        assert!(error.contains("task.toml"), "{what}: where? {error}");
    }
}

#[test]
#[expect(clippy::too_many_lines, reason = "a table")]
fn trajectories() {
    let scratch = Scratch::new("trajectories");
    let half = "0.5 0.5 0.5 0.5 0.5 0.5\n";
    let node = |joints: &str| format!("{half}{half}{joints}\n");
    let good = node("0 -1.5 0.1 1.4 1.2 -1.0");
    for (what, text, code, words) in [
        ("empty", String::new(), 65, &["expected"][..]),
        (
            "unknown pose type",
            format!("JOINTS 1 ABSOLUTE\n{good}"),
            65,
            &[":1:1", "JOINTS", "JOINT"],
        ),
        (
            "no count",
            format!("JOINT many\n{good}"),
            65,
            &[":1:7", "many"],
        ),
        ("count zero", "JOINT 0\n".into(), 65, &[":1:7", "0"]),
        (
            "too few nodes",
            format!("JOINT 2 ABSOLUTE\n{good}"),
            65,
            &["2"],
        ),
        (
            "too few values",
            format!("JOINT 1\n{}", node("0 -1.5 0.1")),
            65,
            &[":4:", "6", "3"],
        ),
        (
            "too few speeds",
            format!("JOINT 1\n0.5 0.5\n{half}0 0 0 0 0 0\n"),
            65,
            &[":2:", "6", "2"],
        ),
        (
            "NaN",
            format!("JOINT 1\n{}", node("0 NaN 0 0 0 0")),
            65,
            &[":4:3", "NaN"],
        ),
        (
            "inf",
            format!("JOINT 1\n{}", node("0 0 0 0 0 inf")),
            65,
            &[":4:", "inf"],
        ),
        (
            "comma",
            format!("JOINT 1\n{}", node("0 1,5 0 0 0 0")),
            65,
            &[":4:3", "1,5"],
        ),
        (
            "too fast",
            format!("JOINT 1\n9 9 9 9 9 9\n{half}0 0 0 0 0 0\n"),
            65,
            &[":2:", "9"],
        ),
        (
            "out of limits",
            format!("JOINT 1\n{}", node("0 0 0 0 0 0")),
            11,
            &[":4", "lower arm"],
        ),
    ] {
        let file = scratch.file("taught.trj", &text);
        let mut arguments = vec!["run".into(), file.into_os_string()];
        arguments.extend(["--robot".into(), "irp6-postument".into()]);
        unmoved(
            &scratch,
            what,
            arguments,
            code,
            &[words, &["taught.trj"]].concat(),
        );
    }
    // what is wrong in the examples above is what they say: this one is right
    let file = scratch.file("taught.trj", &format!("JOINT 1 ABSOLUTE\n{good}"));
    let output = binary::run([
        "run".as_ref(),
        file.as_os_str(),
        "--robot".as_ref(),
        "irp6-postument".as_ref(),
        "-q".as_ref(),
    ]);
    assert_eq!((output.code, output.stderr.as_str()), (Some(0), ""));
}

#[test]
fn nobody_there() {
    // a hub with nobody on it but the MP: no node answers
    let hub = HubServer::bind("127.0.0.1:0".parse().unwrap(), &["mp"]).unwrap();
    let bus = format!("hub:{}", hub.address().port());
    let silent = binary::run(["home", "irp6-track", "-q", "--bus", &bus]);
    told(
        "silent",
        &silent,
        69,
        &["irp6-track", "does not answer", "mrroc-node"],
    );
    drop(hub);
    // now that port has no listener
    let absent = binary::run(["home", "irp6-track", "-q", "--bus", &bus]);
    told("absent", &absent, 69, &["hub", "mrroc-hil-sim"]);
    let can = binary::run(["home", "irp6-track", "-q", "--bus", "can:nosuch0"]);
    assert!(matches!(can.code, Some(69 | 77)), "{can:?}");
    told("no interface", &can, can.code.unwrap(), &["nosuch0"]);
}

#[test]
fn what_moves_has_torque() {
    // the observer that finds nothing above finds something here
    let scratch = Scratch::new("moves");
    let record = scratch.path("record.log");
    let output = binary::run([
        "home".as_ref(),
        "irp6-postument".as_ref(),
        "-q".as_ref(),
        "--record".as_ref(),
        Path::as_os_str(&record),
    ]);
    assert_eq!(output.code, Some(0), "{output:?}");
    assert!(ever_had_torque(&record));
}
