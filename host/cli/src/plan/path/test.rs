//! What `mrroc plan path` prints, draws and refuses.

use clap::Parser;
use serde_json::Value;

use crate::plan::{Plan, PlanError};

#[derive(Parser)]
struct Shell {
    #[command(flatten)]
    plan: Plan,
}

const ROSE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tasks/rose.csv");
/// Where `tasks/rose.toml` begins the rose.
const FROM: &str = "--from 0.0,-1.60,0.10,1.30,1.39,-1.84";

fn path(arguments: &str) -> (String, Result<(), PlanError>) {
    let words = format!("plan path {arguments}");
    let shell = Shell::try_parse_from(words.split_whitespace()).unwrap();
    let mut out = Vec::new();
    let result = shell.plan.run(&mut out, &mut std::io::empty());
    (String::from_utf8(out).unwrap(), result)
}

fn numbers(value: &Value) -> Vec<f64> {
    let list = value.as_array().unwrap().iter();
    list.map(|x| x.as_f64().unwrap()).collect()
}

#[test]
fn the_rose_is_planned_within_all_limits() {
    let (out, result) = path(&format!("irp6-postument {ROSE} --relative {FROM} --json"));
    result.unwrap();
    let ride: Value = serde_json::from_str(&out).unwrap();
    let [t, s, v, a] = ["t_s", "s_m", "v_m_s", "a_m_s2"].map(|key| numbers(&ride[key]));
    // the feed travels as f32: 1e-7 of it; the motion keeps it to rounding
    assert!(v.iter().all(|v| (-1e-9..=0.05 * (1.0 + 1e-6)).contains(v)));
    assert!(ride["feed_peak_m_s"].as_f64().unwrap() > 0.9 * 0.05);
    assert_eq!((v[0], s[0], v[v.len() - 1]), (0.0, 0.0, 0.0));
    assert!(s.windows(2).all(|pair| pair[0] <= pair[1]));
    for joint in ride["joints"].as_array().unwrap() {
        for key in ["velocity_share", "acceleration_share"] {
            let shares = numbers(&joint[key]);
            assert_eq!(shares.len(), t.len());
            assert!(
                shares.iter().all(|share| (0.0..=1.01).contains(share)),
                "{joint}"
            );
        }
    }
    // the speed is the integral of the acceleration: s̈ is linear in a macrostep, the rest is what the
    // trapezoid leaves of the curve's own terms, some 1e-6 m/s
    let mut speed = 0.0;
    for k in 1..t.len() {
        speed += 0.5 * (a[k - 1] + a[k]) * (t[k] - t[k - 1]);
        assert!((speed - v[k]).abs() < 1e-5, "{k}: {speed} {}", v[k]);
    }
    // and the way that of the speed, which begins and ends at rest with its acceleration: nearly exact
    let way: f64 = v.iter().sum::<f64>() * 0.02;
    let length = ride["length_m"].as_f64().unwrap();
    assert!((way / length - 1.0).abs() < 1e-6, "{way} {length}");
}

#[test]
fn the_picture_and_the_table_name_every_joint() {
    let picture = std::env::temp_dir().join(format!("mrroc-path-{}.svg", std::process::id()));
    let place = picture.display();
    let (out, result) = path(&format!(
        "irp6-postument {ROSE} --relative {FROM} --plot {place}"
    ));
    result.unwrap();
    let svg = std::fs::read_to_string(&picture).unwrap();
    std::fs::remove_file(&picture).unwrap();
    // five lines, an empty one, the head, six joints
    assert_eq!(out.lines().count(), 5 + 1 + 1 + 6, "{out}");
    for words in [
        "feed [m/s]",
        "curvature [1/m]",
        "velocity [share]",
        "acceleration [share]",
    ] {
        assert!(svg.contains(&format!(">{words}</text>")), "{words}");
    }
    for line in out.lines().skip(7) {
        let name = line.split("  ").next().unwrap();
        assert!(svg.contains(&format!(">{name}</text>")), "{name}");
    }
}

#[test]
fn what_cannot_be_ends_in_one_line() {
    for (arguments, code) in [
        ("irp6-postument /nowhere/rose.csv".to_owned(), 66),
        // its first point is the origin of the base frame
        (format!("irp6-postument {ROSE} {FROM}"), 11),
        (format!("irp6-postument {ROSE} --from 0,1"), 64),
        (format!("irp6-postument {ROSE} --from 9,9,9,9,9,9"), 11),
        (format!("irp6-none {ROSE}"), 64),
        (format!("irp6-postument {ROSE} {FROM} --plot a.gif"), 64),
    ] {
        let (out, result) = path(&arguments);
        let error = result.unwrap_err();
        assert_eq!((out.as_str(), error.exit_code()), ("", code), "{error}");
        assert_eq!(error.to_string().lines().count(), 1, "{error}");
    }
}

#[test]
fn a_refusal_is_json_too_and_says_the_point() {
    let (out, result) = path(&format!("irp6-postument {ROSE} --relative --json"));
    let told = result.unwrap_err().to_string();
    let answer: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(answer["error"], "refused");
    assert_eq!(answer["message"], told.as_str());
    assert!(told.contains("on the way to point "), "{told}");
}

/// A file that is gone when the test is over.
struct Scratch(std::path::PathBuf);

impl Scratch {
    fn new(name: &str, text: &str) -> Self {
        let name = format!("mrroc-{}-{name}", std::process::id());
        let path = std::env::temp_dir().join(name);
        std::fs::write(&path, text).unwrap();
        Self(path)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

fn cad(arguments: &str) -> (String, Result<(), PlanError>) {
    let words = format!("plan cad {arguments}");
    let shell = Shell::try_parse_from(words.split_whitespace()).unwrap();
    let mut out = Vec::new();
    let result = shell.plan.run(&mut out, &mut std::io::empty());
    (String::from_utf8(out).unwrap(), result)
}

const SQUARE: &str = "G21 G0 X0 Y0 Z1\nM3 S1200\nG1 Z-1 F60\nF1200 X20\nY20\nX0\nY0\nG0 Z1\nM2\n";

#[test]
fn a_program_is_summed_up_and_planned_at_its_feeds() {
    let file = Scratch::new("square.ngc", SQUARE);
    let place = file.0.display();
    let (out, result) = cad(&format!(
        "{place} --fit 0.012,0.012 --margin 0.001 --depth 0.0005 --json"
    ));
    result.unwrap();
    let told: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(
        (told["lines"].as_u64(), told["sections"].as_u64()),
        (Some(5), Some(4))
    );
    assert_eq!(numbers(&told["feed_m_s"]), [1e-3, 0.02]);
    for (place, wanted) in told["on_board"]["greatest_m"]
        .as_array()
        .unwrap()
        .iter()
        .zip([0.011, 0.011, 0.0005])
    {
        assert!((place.as_f64().unwrap() - wanted).abs() < 1e-12, "{told}");
    }
    assert!((told["place"]["scale"].as_f64().unwrap() - 0.5).abs() < 1e-12);
    let (out, result) = cad(&format!("{place}"));
    result.unwrap();
    assert!(
        out.contains("scale 1.000000") && out.contains("unit mm (the program's)"),
        "{out}"
    );
    // 1 mm up to where it begins, 2 mm down, then the square; what the instruction admits is five times as fast
    let (out, result) = path(&format!(
        "irp6-postument {place} --relative {FROM} --feed 0.1 --json"
    ));
    result.unwrap();
    let ride: Value = serde_json::from_str(&out).unwrap();
    let [s, v] = ["s_m", "v_m_s"].map(|key| numbers(&ride[key]));
    let fastest = |from: f64, to: f64| {
        let within = s.iter().zip(&v).filter(|(s, _)| (from..to).contains(*s));
        within.fold(0.0_f64, |most, (_, v)| if *v > most { *v } else { most })
    };
    // the feed travels as f32; it is reached but for the smoothing
    for (from, to, feed) in [(0.0011, 0.003, 1e-3), (0.0011, 0.083, 0.02)] {
        let got = fastest(from, to);
        assert!((0.98 * feed..1.001 * feed).contains(&got), "{got} {feed}");
    }
}

#[test]
fn a_program_that_is_not_understood_ends_in_one_line_with_its_place() {
    let file = Scratch::new("wrong.ngc", "G21 G0 X0 Y0 Z1\nG28\n");
    let place = file.0.display();
    for (arguments, code, words) in [
        (
            format!("{place}"),
            65,
            "wrong.ngc:2:1: error: a G code that cannot be done",
        ),
        ("/nowhere/a.svg".to_owned(), 66, "no such file"),
        (format!("{place} --fit 0.1"), 64, "--fit"),
        (format!("{place} --fit 0.1,0.1 --margin 0.06"), 64, "--fit"),
    ] {
        let (out, result) = cad(&arguments);
        let error = result.unwrap_err();
        assert_eq!((out.as_str(), error.exit_code()), ("", code), "{error}");
        assert!(error.to_string().contains(words), "{error}");
        assert_eq!(error.to_string().lines().count(), 1, "{error}");
    }
}
