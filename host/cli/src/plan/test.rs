//! What `mrroc plan profile` prints, draws and refuses.

mod refused;

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

/// A good line with one key replaced or added.
fn with(key: &str, value: &str) -> String {
    let good = [
        ("p0", "[0]"),
        ("p1", "[1]"),
        ("v_max", "[1]"),
        ("a_max", "[1]"),
        ("j_max", "[1]"),
    ];
    let others = good.into_iter().filter(|(name, _)| *name != key);
    let all = others.chain([(key, value)]);
    let pairs: Vec<String> = all
        .map(|(key, value)| format!("\"{key}\":{value}"))
        .collect();
    format!("{{{}}}", pairs.join(","))
}

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
