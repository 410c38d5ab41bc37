//! Same seed and inputs, same bytes: twice in one process, in other processes, and in every profile.
//!
//! The digests in `golden/digests` hold for debug and release; run with `BLESS=1` to accept others.

use host::task::{MoveTarget, Task};
use mrroc_tests::binary::{self, Scratch};
use mrroc_tests::{digest, job, workspace};
use robots::RobotKind;
use std::collections::BTreeMap;
use std::sync::Mutex;

const TARGET: [f64; 6] = [0.3, -1.5, 0.1, 1.4, 1.2, -1.0];

fn task(seed: u64) -> Task {
    let target = MoveTarget::Joints(TARGET.to_vec());
    let mut task = Task::single_move(RobotKind::Irp6Postument, target, false, Some(0.5)).unwrap();
    task.seed = seed;
    task
}

/// Every frame of every bus and the true motor angles, as one number.
fn life(seed: u64) -> u64 {
    let mut record = digest::Record::default();
    let (error, _) = job::run(task(seed), &mut record);
    assert_eq!(error, None);
    assert!(record.frames > 50_000, "{}", record.frames);
    record.value()
}

/// The record and the summary (but for what the wall clock says) of the same move by the command.
fn process(scratch: &Scratch, name: &str, seed: u64) -> (u64, u64) {
    let record = scratch.path(name);
    let target = TARGET.map(|joint| joint.to_string()).join(",");
    let arguments = [
        "move",
        "irp6-postument",
        "--joints",
        &target,
        "--speed",
        "0.5",
        "--json",
        "-q",
        "--seed",
        &seed.to_string(),
        "--record",
    ];
    let mut arguments: Vec<_> = arguments.iter().map(std::ffi::OsString::from).collect();
    arguments.push(record.clone().into());
    let output = binary::run(arguments);
    assert_eq!(output.code, Some(0), "{output:?}");
    let mut summary = output.json();
    let machine = ["wall_s", "realtime_factor"];
    for key in machine {
        assert!(
            summary.as_object_mut().unwrap().remove(key).is_some(),
            "{key}"
        );
    }
    let bytes = std::fs::read(&record).unwrap();
    assert!(bytes.len() > 1_000_000);
    (
        digest::of(&bytes),
        digest::of(summary.to_string().as_bytes()),
    )
}

/// Compares with what was accepted.
fn golden(name: &str, value: u64) {
    static FILE: Mutex<()> = Mutex::new(());
    let _one_at_a_time = FILE.lock().unwrap();
    let path = workspace().join("tests/golden/digests");
    let text = std::fs::read_to_string(&path).unwrap_or_default();
    let mut accepted: BTreeMap<&str, String> = text
        .lines()
        .filter_map(|line| line.split_once(' '))
        .map(|(k, v)| (k, v.into()))
        .collect();
    let value = format!("{value:016x}");
    if std::env::var_os("BLESS").is_some() {
        accepted.insert(name, value);
        let lines = accepted
            .iter()
            .map(|(name, value)| format!("{name} {value}\n"));
        std::fs::write(&path, lines.collect::<String>()).unwrap();
    } else {
        assert_eq!(
            accepted.get(name),
            Some(&value),
            "{name}: BLESS=1 accepts what is meant"
        );
    }
}

#[test]
fn twice_in_one_process() {
    let first = life(1);
    assert_eq!(first, life(1));
    assert_ne!(first, life(2), "the seed changes nothing");
    golden("life", first);
}

#[test]
fn in_other_processes() {
    let scratch = Scratch::new("determinism");
    let (record, summary) = process(&scratch, "a.log", 1);
    assert_eq!((record, summary), process(&scratch, "b.log", 1));
    assert_ne!(
        record,
        process(&scratch, "c.log", 2).0,
        "the seed changes nothing"
    );
    golden("record", record);
    golden("summary", summary);
}
