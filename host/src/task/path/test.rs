use super::*;
use crate::task::{Action, Task};

const HEAD: &str = "title = \"t\"\n[[cell.robot]]\nkind = \"irp6-postument\"\n[[step]]\n";

fn read_step(step: &str) -> Result<PathStep, DataError> {
    match Task::parse(&format!("{HEAD}{step}\n"))?.steps[0].action {
        Action::Path(ref step) => Ok(step.clone()),
        ref other => panic!("{other:?}"),
    }
}

/// A path of these elements, with more keys.
fn elements(elements: &str, more: &str) -> String {
    format!("path = {{ robot = \"irp6-postument\", elements = [{elements}]{more} }}")
}

/// The mistake in a step is told on one line, in these words.
fn told(step: &str, what: &str) {
    let error = read_step(step).expect_err(step).to_string();
    assert!(error.contains(what), "{step}: {error}");
    assert!(!error.contains('\n'));
}

const LINE: &str = "{ line = { position_m = [1, 2, 3] } }";

#[test]
fn lines_arcs_corners_and_points_are_read() {
    let step = read_step(&elements(
        "{ line = { position_m = [1, 2, 3], rotation_rad = [0.1, 0, 0] }, corner_m = 0.01 },
         { arc = { via_m = [4, 5, 6], to = { position_m = [7, 8, 9] } }, corner_m = 0.5, corner_rad = 0.25 },
         { through = { position_m = [0, 0, 1] } },
         { line = { position_m = [0, 0, 2] } }",
        ", feed_m_s = 0.25, angular_acceleration_rad_s2 = 4, relative_to = \"start\", overrides = [[1, 0], [2.5, 1]]",
    ))
    .unwrap();
    assert_eq!((step.robot, step.reference), (0, Reference::Start));
    assert_eq!(step.overrides, [(1.0, 0.0), (2.5, 1.0)]);
    let speeds = PoseSpeeds {
        velocity_m_s: 0.25,
        angular_velocity_rad_s: 0.5,
        acceleration_m_s2: 0.5,
        angular_acceleration_rad_s2: 4.0,
    };
    assert_eq!(step.speeds, speeds);
    let marks = &step.path.marks;
    let lines: Vec<u32> = marks.iter().map(|mark| mark.line).collect();
    assert_eq!(lines, [5, 6, 7, 8]);
    let corner = |metres, radians| Corner { metres, radians };
    assert_eq!(
        marks[0].way,
        Way::Line {
            corner: corner(0.01, 0.1)
        }
    );
    assert_eq!(marks[0].to.rotation_rad, Some([0.1, 0.0, 0.0]));
    assert_eq!(
        marks[1].way,
        Way::Arc {
            via_m: [4.0, 5.0, 6.0],
            corner: corner(0.5, 0.25)
        }
    );
    assert_eq!(
        (marks[2].way, marks[2].to.rotation_rad),
        (Way::Through, None)
    );
    assert_eq!(marks[3].way, Way::Line { corner: SHARP });
}

#[test]
fn what_is_wrong_with_an_element_is_told() {
    for (step, what) in [
        (elements("", ""), "wrong number of elements"),
        (
            elements("{ line = { } }", ""),
            "a goal without `position_m`",
        ),
        (
            elements("{ line = { position_m = [1, 2] } }", ""),
            "expected 3 numbers, got 2",
        ),
        (
            elements("{ line = { position_m = [1, 2, inf] } }", ""),
            "is not finite",
        ),
        (
            elements(
                "{ through = { position_m = [1, 2, 3] }, corner_m = 0.1 }",
                "",
            ),
            "a corner of a smooth curve",
        ),
        (
            elements(
                "{ line = { position_m = [1, 2, 3] }, corner_rad = 0.1 }",
                "",
            ),
            "`corner_rad` without `corner_m`",
        ),
        (
            elements("{ line = { position_m = [1, 2, 3] }, corner_m = -0.1 }", ""),
            "expected 0 to 1, got `-0.1`",
        ),
        (
            elements("{ arc = { to = { position_m = [1, 2, 3] } } }", ""),
            "an arc without `via_m`",
        ),
        (
            elements("{ spline = { position_m = [1, 2, 3] } }", ""),
            "unknown key in an element of a path",
        ),
    ] {
        told(&step, what);
    }
}

#[test]
fn what_is_wrong_with_a_step_is_told() {
    for (step, what) in [
        (elements(LINE, ", feed_m_s = 0"), "`feed_m_s` out of range"),
        (
            elements(LINE, ", feed_m_s = 5.1"),
            "`feed_m_s` out of range",
        ),
        (
            elements(LINE, ", relative_to = \"tool\""),
            "expected `base` or `start`",
        ),
        (
            elements(LINE, ", file = \"x.csv\""),
            "a path that says two things",
        ),
        (
            elements(LINE, ", overrides = [[1, 0]]"),
            "expected a last share above 0",
        ),
        (
            elements(LINE, ", overrides = [[1, 0], [1, 1]]"),
            "later than the one before",
        ),
        (
            elements(LINE, ", overrides = [[1, 1.5]]"),
            "expected -1 to 1",
        ),
        (
            elements(LINE, ", overrides = [[1]]"),
            "expected [time in s, share]",
        ),
        (
            "path = { robot = \"irp6-postument\", file = \"nowhere.csv\" }".to_owned(),
            "cannot read the path",
        ),
        (
            "path = { robot = \"irp6-track\", elements = [] }".to_owned(),
            "unknown robot",
        ),
    ] {
        told(&step, what);
    }
}

#[test]
fn a_path_file_is_points_or_elements() {
    let folder = std::env::temp_dir().join(format!("mrroc-path-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let (csv, toml) = (folder.join("a.csv"), folder.join("b.path.toml"));
    std::fs::write(&csv, "0,0,0\n0.1,0,0\n").unwrap();
    std::fs::write(&toml, format!("elements = [\n{LINE},\n{LINE}]\n")).unwrap();
    assert_eq!(
        load(&csv, &Files::on_disk()).unwrap().file,
        Some(csv.clone())
    );
    let read = load(&toml, &Files::on_disk()).unwrap();
    assert_eq!((read.file, read.marks[1].line), (Some(toml.clone()), 3));
    std::fs::write(&csv, "0,0,0\n0.1,0,zero\n").unwrap();
    let error = load(&csv, &Files::on_disk()).unwrap_err().to_string();
    assert!(error.ends_with(
        "a.csv:2:7: error: `z` is no number (expected a finite number of m, got `zero`)"
    ));
    std::fs::write(&toml, "element = []\n").unwrap();
    assert!(
        load(&toml, &Files::on_disk())
            .unwrap_err()
            .to_string()
            .contains(":1:1: error: unknown key in a path")
    );
    std::fs::remove_dir_all(&folder).unwrap();
}
