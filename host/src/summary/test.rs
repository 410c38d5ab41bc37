use super::*;
use std::time::Duration;

fn example() -> Summary {
    Summary {
        ok: true,
        error: None,
        title: "Two arms".into(),
        duration_s: 62.5,
        machine: MachinePart::measured(62.5, 0.25),
        seed: 2010,
        robots: vec![
            RobotSummary {
                name: "irp6-track".into(),
                kind: "irp6-track".into(),
                servo: "drive-position".into(),
                servo_step_s: 0.002,
                servo_steps: 31_250,
                following_error_max: 0.012_34,
                following_error_axis: 3,
                following_error_max_rad: vec![0.0, 0.0, 0.012_34],
                setpoint_path_error_max_m: Some(1.5e-9),
                actual_path_error_max_m: Some(2.25e-4),
                ..RobotSummary::default()
            },
            RobotSummary {
                name: "irp6-postument".into(),
                kind: "irp6-postument".into(),
                servo: "original".into(),
                servo_step_s: 0.002,
                ..RobotSummary::default()
            },
        ],
        buses: vec![BusSummary {
            name: "mp".into(),
            frames: 123_456,
            load_mean: Some(0.0612),
            load_max: Some(0.25),
            load_window_s: 0.01,
            latency_max_s: Some(2.5e-4),
        }],
        engraving: None,
        steps: vec![StepSummary {
            name: "home both".into(),
            start_s: 0.0,
            duration_s: 12.0,
            ok: true,
            path: None,
        }],
    }
}

#[test]
fn the_json_has_the_promised_keys() {
    let value: serde_json::Value = serde_json::from_str(&example().to_json().unwrap()).unwrap();
    for key in [
        "ok",
        "duration_s",
        "realtime_factor",
        "seed",
        "robots",
        "buses",
        "steps",
    ] {
        assert!(value.get(key).is_some(), "{key}");
    }
    for key in [
        "name",
        "servo_steps",
        "limit_violations",
        "faults",
        "following_error_max",
        "setpoint_path_error_max_m",
        "actual_path_error_max_m",
    ] {
        assert!(value["robots"][0].get(key).is_some(), "{key}");
    }
    for key in ["name", "frames", "load_max"] {
        assert!(value["buses"][0].get(key).is_some(), "{key}");
    }
    assert_eq!(value["realtime_factor"], 250.0);
    assert_eq!(
        value["robots"][1]["actual_path_error_max_m"],
        serde_json::Value::Null
    );
}

#[test]
fn what_is_reproducible_does_not_know_the_wall_clock() {
    let (mut fast, mut slow) = (example(), example());
    fast.machine = MachinePart::measured(62.5, 0.2);
    slow.machine = MachinePart::measured(62.5, 70.0);
    let mut late = Lateness::new(Duration::from_millis(20));
    late.record(Duration::from_micros(130));
    slow.machine.called = Some(Called(late));
    let called =
        serde_json::from_str::<serde_json::Value>(&slow.to_json().unwrap()).unwrap()["called"]
            .take();
    assert_eq!(called["lateness_us"]["max"], 130);
    assert_eq!(called["lateness_histogram_us"][0][0], 20);
    assert!(
        slow.to_string().contains("\ncalled late by 130 us "),
        "{slow}"
    );
    assert!(!fast.to_string().contains("called"));
    let json = fast.to_reproducible_json().unwrap();
    assert_eq!(json, slow.to_reproducible_json().unwrap());
    assert!(!json.contains("wall"));
    slow.robots[0].faults = 1;
    assert_ne!(json, slow.to_reproducible_json().unwrap());
}

#[test]
fn the_tables_are_aligned_and_have_units() {
    let expected = "\
Two arms: ok
62.500 s of bus time, seed 2010, 0.250 s on the wall: 250× real time

robot                    servo  steps      following error  set-point path error  actual path error  limits broken  faults
irp6-track      drive-position  31250  0.0123 rad (axis 3)              0.002 µm         225.000 µm              0       0
irp6-postument        original      0                    –                     –                  –              0       0

bus  frames  mean load         max load  max latency
mp   123456      6.1 %  25.0 % in 10 ms       250 µs

step        began     took
home both  0.00 s  12.00 s  ok
";
    assert_eq!(example().to_string(), expected);
}

#[test]
fn a_path_has_a_table_and_a_key_of_its_own() {
    let mut summary = example();
    assert!(!summary.to_json().unwrap().contains("feed_max_m_s"));
    summary.steps.push(StepSummary {
        name: "rose".into(),
        start_s: 12.0,
        duration_s: 80.0,
        ok: true,
        path: Some(PathSummary {
            points: 1500,
            length_m: 4.25,
            moving_s: Some(79.5),
            feed_mean_m_s: Some(0.0487),
            feed_max_m_s: Some(0.05),
            setpoint_path_error_max_m: None,
        }),
    });
    let value: serde_json::Value = serde_json::from_str(&summary.to_json().unwrap()).unwrap();
    assert_eq!(value["steps"][1]["path"]["points"], 1500);
    assert_eq!(
        value["steps"][1]["path"]["setpoint_path_error_max_m"],
        serde_json::Value::Null
    );
    let expected = "
path  points   length    moved  mean feed   max feed  set-point path error
rose    1500  4.250 m  79.50 s  48.7 mm/s  50.0 mm/s                     –
";
    assert!(summary.to_string().ends_with(expected), "{summary}");
}

#[test]
fn a_failure_is_said_first() {
    let mut summary = example();
    summary.ok = false;
    summary.error = Some("step 3: irp6-track: fault".into());
    summary.machine = MachinePart::default();
    let text = summary.to_string();
    assert!(
        text.starts_with(
            "Two arms: failed: step 3: irp6-track: fault\n62.500 s of bus time, seed 2010\n"
        ),
        "{text}"
    );
}
