//! The main job by the operator's command: its summary, its record, its drawings.

use bus::candump::Reader;
use mrroc_tests::binary::{self, Output, Scratch};
use serde_json::Value;
use std::io::BufReader;
use std::sync::OnceLock;

const ROBOTS: [&str; 2] = ["irp6-track", "irp6-postument"];

struct Job {
    output: Output,
    files: Scratch,
}

/// The main job, run once for all tests here.
fn job() -> &'static Job {
    static JOB: OnceLock<Job> = OnceLock::new();
    JOB.get_or_init(|| {
        let files = Scratch::new("summary");
        let mut arguments: Vec<std::ffi::OsString> =
            vec!["run".into(), "tasks/two-arms.toml".into()];
        arguments.extend(["--json", "-q"].map(Into::into));
        for (flag, name) in [
            ("--plot", "job.svg"),
            ("--plot", "job.png"),
            ("--record", "job.log"),
        ] {
            arguments.extend([flag.into(), files.path(name).into()]);
        }
        Job {
            output: binary::run(arguments),
            files,
        }
    })
}

fn number(value: &Value, key: &str) -> f64 {
    value[key]
        .as_f64()
        .unwrap_or_else(|| panic!("{key}: {value}"))
}

#[test]
fn the_summary_says_all_that_matters() {
    let output = &job().output;
    assert_eq!(output.code, Some(0), "{output:?}");
    assert_eq!(output.stderr, "");
    let summary = output.json();
    assert_eq!(summary["ok"], true);
    assert_eq!(summary["error"], Value::Null);
    assert_eq!(summary["seed"], 2010);
    let duration_s = number(&summary, "duration_s");
    assert!((60.0..300.0).contains(&duration_s), "{duration_s}");
    let factor = number(&summary, "realtime_factor");
    assert!(factor > 0.0);
    assert!((factor * number(&summary, "wall_s") / duration_s - 1.0).abs() < 1e-6);

    let robots = summary["robots"].as_array().unwrap();
    assert_eq!(robots.len(), ROBOTS.len());
    for (robot, name) in robots.iter().zip(ROBOTS) {
        assert_eq!(robot["name"], name);
        assert_eq!(
            (&robot["faults"], &robot["limit_violations"]),
            (&0.into(), &0.into()),
            "{robot}"
        );
        // a servo step is 2 ms; the last feedback is at most a few macrosteps old
        let steps = number(robot, "servo_steps") * number(robot, "servo_step_s");
        assert!(
            (steps - duration_s).abs() < 0.2,
            "{steps} s of {duration_s} s"
        );
        let error = number(robot, "following_error_max");
        assert!(error > 0.0 && error < 1.0, "{robot}");
        // set-points are the planned line but for their resolution: 1.6 µrad of a motor, far
        // below a micrometre, and the interpolation between knots of a line
        let setpoint = number(robot, "setpoint_path_error_max_m");
        assert!(setpoint > 0.0 && setpoint < 1e-5, "{robot}");
        let actual = number(robot, "actual_path_error_max_m");
        assert!(actual > 0.0 && actual < 1e-3, "{robot}");
    }

    let buses = summary["buses"].as_array().unwrap();
    let names: Vec<&str> = buses
        .iter()
        .map(|bus| bus["name"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["mp", "track-arm", "track-wrist", "postument"]);
    for bus in buses {
        assert!(number(bus, "frames") > 1000.0, "{bus}");
        let (mean, most) = (number(bus, "load_mean"), number(bus, "load_max"));
        assert!(0.0 < mean && mean <= most && most < 1.0, "{bus}");
    }
    assert_eq!(summary["steps"].as_array().unwrap().len(), 12);
    assert!(
        summary["steps"]
            .as_array()
            .unwrap()
            .iter()
            .all(|step| step["ok"] == true)
    );
}

#[test]
fn the_record_is_a_candump_log_of_every_frame() {
    let summary = job().output.json();
    let file = std::fs::File::open(job().files.path("job.log")).unwrap();
    let buses = summary["buses"].as_array().unwrap();
    let mut counted = vec![0_u64; buses.len()];
    for entry in Reader::new(BufReader::new(file)) {
        let entry = entry.unwrap();
        let bus = buses
            .iter()
            .position(|bus| bus["name"] == entry.channel.as_str());
        counted[bus.unwrap()] += 1;
    }
    for (bus, counted) in buses.iter().zip(counted) {
        assert_eq!(bus["frames"], counted, "{bus}");
    }
}

#[test]
fn the_drawings_can_be_opened() {
    let read = |name| std::fs::read(job().files.path(name)).unwrap();
    let svg = String::from_utf8(read("job.svg")).unwrap();
    well_formed(&svg);
    for word in ["irp6-track", "irp6-postument", "column", "home"] {
        assert!(svg.contains(word), "{word}");
    }
    let png = read("job.png");
    let chunks = png_chunks(&png);
    assert_eq!(chunks.first().map(String::as_str), Some("IHDR"));
    assert_eq!(chunks.last().map(String::as_str), Some("IEND"));
    assert!(chunks.iter().any(|chunk| chunk == "IDAT"));
}

/// The names of the chunks of a PNG (ISO/IEC 15948), each with its length; nothing is left over.
fn png_chunks(png: &[u8]) -> Vec<String> {
    let mut rest = png
        .strip_prefix(b"\x89PNG\r\n\x1a\n")
        .expect("the signature of PNG");
    let mut names = Vec::new();
    while let Some((head, tail)) = rest.split_at_checked(8) {
        let length = u32::from_be_bytes(head[..4].try_into().unwrap());
        names.push(String::from_utf8(head[4..].to_vec()).unwrap());
        rest = &tail[usize::try_from(length).unwrap() + 4..];
    }
    assert!(rest.is_empty());
    names
}

/// Every element of an XML text is closed in its turn.
fn well_formed(text: &str) {
    let mut open = Vec::new();
    let mut elements = 0;
    for part in text.split('<').skip(1) {
        let (tag, content) = part.split_once('>').expect("a tag that ends");
        assert!(!content.contains('>'), "a bare > after {tag}");
        elements += 1;
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name), "closed out of turn");
        } else if !tag.ends_with('/') && !tag.starts_with(['?', '!']) {
            open.push(tag.split_whitespace().next().unwrap());
        }
    }
    assert!(
        open.is_empty() && elements > 100,
        "{elements} elements, open: {open:?}"
    );
}
