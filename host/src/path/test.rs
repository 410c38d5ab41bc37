use super::*;
use crate::input::{DataError, Problem};
use motion::path::{Curve, MovingSegment};
use proptest::prelude::*;

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::from_rotation_vector(Vector3::new(x, y, z), Vector3::zeros())
}

fn wrong(text: &str) -> DataError {
    csv::parse(text).expect_err(text)
}

#[test]
fn points_runs_and_comments_are_read() {
    let text =
        "# a square\nx,y,z\n1, 2,3 # here\n\t4,5 ,6\n# not blank\n7,8,9\n \n\n-1e-1,0,+.5\n1,1,1\n";
    let read = csv::parse(text).unwrap();
    let lines: Vec<u32> = read.marks.iter().map(|mark| mark.line).collect();
    assert_eq!(lines, [3, 4, 6, 9, 10]);
    let begins: Vec<bool> = read
        .marks
        .iter()
        .map(|mark| mark.way == Way::Line { corner: SHARP })
        .collect();
    assert_eq!(begins, [true, false, false, true, false]);
    assert!(read.marks[1..3].iter().all(|mark| mark.way == Way::Through));
    let to = Goal {
        position_m: [-0.1, 0.0, 0.5],
        rotation_rad: None,
    };
    assert_eq!(read.marks[3].to, to);
    let turned = csv::parse("1,2,3,0.1,0.2,0.3\n1,2,4,0,0,0").unwrap();
    assert_eq!(turned.marks[0].to.rotation_rad, Some([0.1, 0.2, 0.3]));
}

#[test]
fn what_is_wrong_has_its_place() {
    for (text, line, column, problem, got) in [
        ("1,2,3\n1,2\n", 2, 3, Problem::WrongCount, "2"),
        ("1,2,3\n1,2,3,4,5,6\n", 2, 7, Problem::WrongCount, "6"),
        ("1,2,3,4\n", 1, 7, Problem::WrongCount, "4"),
        ("1,2,3,4,5,6,7\n", 1, 13, Problem::WrongCount, "7"),
        ("x,y,z\n1,2,3,4,5,6\n", 2, 7, Problem::WrongCount, "6"),
        ("1,2,3\n1, nan,3\n", 2, 4, Problem::NotFinite, "`nan`"),
        ("1,2,inf\n", 1, 5, Problem::NotFinite, "`inf`"),
        ("nan,2,3\n", 1, 1, Problem::NotFinite, "`nan`"),
        ("1,2,3\n1,,3\n", 2, 3, Problem::WrongType, "``"),
        ("1,2,3\n1;2,2,3\n", 2, 1, Problem::WrongType, "`1;2`"),
        ("1,2,3\n1,2,3 m\n", 2, 5, Problem::WrongType, "`3 m`"),
        ("x,z,y\n", 1, 3, Problem::UnknownName, "`z`"),
        ("1,2,3\nx,y,z\n", 2, 1, Problem::Conflict, "`x,y,z`"),
        ("x,y,z\n1,2,3\n\n#\n", 4, 1, Problem::WrongCount, "1"),
        ("", 1, 1, Problem::WrongCount, "0"),
    ] {
        let error = wrong(text);
        assert_eq!(
            (error.line, error.column, error.problem, &*error.got),
            (line, column, problem, got),
            "{text:?}: {error}"
        );
        assert!(!error.to_string().contains('\n'));
        assert!(!error.expected.is_empty());
    }
    let long = format!("1,2,3\n{}1,2,3\n", " ".repeat(5000));
    assert_eq!(wrong(&long).problem, Problem::TooLong);
}

#[test]
fn the_most_points_are_exact() {
    let text = |points: usize| "1,2,3\n".repeat(points);
    assert_eq!(
        csv::parse(&text(MOST_POINTS)).unwrap().marks.len(),
        MOST_POINTS
    );
    let error = wrong(&text(MOST_POINTS + 1));
    assert_eq!((error.line, error.problem), (100_001, Problem::WrongCount));
}

/// Points of one run, relative to the start, the first of them where the tool is.
fn run(points: &[[f64; 3]]) -> ToolPath {
    let marks = points.iter().zip(1..).map(|(position_m, line)| Mark {
        line,
        way: if line == 1 {
            Way::Line { corner: SHARP }
        } else {
            Way::Through
        },
        to: Goal {
            position_m: *position_m,
            rotation_rad: None,
        },
        feed_m_s: None,
    });
    ToolPath {
        file: None,
        marks: marks.collect(),
    }
}

#[test]
fn a_line_to_where_the_tool_is_and_repeated_points_are_left_out() {
    let path = run(&[[0.0; 3], [0.1, 0.0, 0.0], [0.1, 0.0, 0.0], [0.2, 0.1, 0.0]]);
    let start = Pose::from_rotation_vector(Vector3::new(1.0, 2.0, 3.0), Vector3::x());
    let streamed = path.from(&start, Reference::Start).unwrap();
    assert_eq!(streamed.marks, [1, 3]);
    assert_eq!(streamed.elements.len(), 3);
    assert_eq!(streamed.elements[2], PathElement::End);
    let PathElement::Through(first) = streamed.elements[0] else {
        panic!("{:?}", streamed.elements);
    };
    let way = pose(&first).position - start.position;
    assert!((way - Vector3::new(0.1, 0.0, 0.0)).norm() < 1e-15);
    // kept from the start
    assert!((first.rotation_rad[0] - 1.0).abs() < 1e-12);
    // from elsewhere there is a line to the first point
    let away = path.from(&at(0.0, 0.0, 1e-3), Reference::Base).unwrap();
    assert_eq!(away.marks, [0, 1, 3]);
    assert!(matches!(away.elements[0], PathElement::Line { corner, .. } if corner == SHARP));
}

#[test]
fn offsets_turn_the_tool_about_axes_of_the_base() {
    let quarter = core::f64::consts::FRAC_PI_2;
    let mut path = run(&[[0.0; 3], [0.1, 0.0, 0.0]]);
    path.marks[1].way = Way::Line { corner: SHARP };
    path.marks[1].to.rotation_rad = Some([0.0, 0.0, quarter]);
    let start = Pose::from_rotation_vector(Vector3::zeros(), Vector3::new(quarter, 0.0, 0.0));
    let streamed = path.from(&start, Reference::Start).unwrap();
    let end = streamed
        .course
        .at(streamed.course.end())
        .unwrap()
        .pose
        .rotation;
    let expected = exp(Vector3::z() * quarter) * start.rotation;
    assert!((end - expected).norm() < 1e-12);
}

#[test]
fn a_wrong_element_is_told_by_its_mark() {
    use PathProblem::{Corner as WrongCorner, NoLength, NotAnArc, NotFinite, TurnTooLarge};
    let fault = |marks: Vec<Mark>| {
        let path = ToolPath { file: None, marks };
        path.from(&at(0.0, 0.0, 0.0), Reference::Base).unwrap_err()
    };
    let mark = |way, position_m, rotation_rad| Mark {
        line: 1,
        way,
        to: Goal {
            position_m,
            rotation_rad,
        },
        feed_m_s: None,
    };
    let line = Way::Line { corner: SHARP };
    let first = mark(line, [0.1, 0.0, 0.0], None);
    let corner = |metres, radians| Way::Line {
        corner: Corner { metres, radians },
    };
    let arc = Way::Arc {
        via_m: [0.2, 0.0, 0.0],
        corner: SHARP,
    };
    for (second, problem) in [
        (mark(line, [0.1, f64::NAN, 0.0], None), NotFinite),
        (mark(arc, [0.3, 0.0, 0.0], None), NotAnArc),
        (
            mark(Way::Through, [0.1, 0.1, 0.0], Some([0.0, 0.0, 1.5])),
            TurnTooLarge,
        ),
        (mark(corner(-1.0, 0.1), [0.1, 0.1, 0.0], None), WrongCorner),
        (
            mark(corner(f32::NAN, 0.1), [0.1, 0.1, 0.0], None),
            WrongCorner,
        ),
    ] {
        let told = fault(vec![first, second]);
        assert_eq!(told, PathFault { mark: 1, problem }, "{second:?}");
        assert!(!told.to_string().is_empty());
    }
    let nothing = mark(line, [0.0; 3], None);
    assert_eq!(
        fault(vec![nothing, nothing]),
        PathFault {
            mark: 0,
            problem: NoLength
        }
    );
}

/// A square with rounded corners and a half circle, as elements.
fn shapes(tolerance: f32) -> ToolPath {
    let corner = Corner {
        metres: tolerance,
        radians: 0.1,
    };
    let mark = |way, position_m, line| Mark {
        line,
        way,
        to: Goal {
            position_m,
            rotation_rad: None,
        },
        feed_m_s: None,
    };
    ToolPath {
        file: None,
        marks: vec![
            mark(Way::Line { corner }, [0.1, 0.0, 0.0], 1),
            mark(Way::Line { corner }, [0.1, 0.1, 0.0], 2),
            mark(
                Way::Arc {
                    via_m: [0.05, 0.15, 0.0],
                    corner,
                },
                [0.0, 0.1, 0.0],
                3,
            ),
            mark(Way::Line { corner: SHARP }, [0.0, 0.0, 0.0], 4),
        ],
    }
}

#[test]
fn lines_and_arcs_have_their_length_and_rounded_corners_are_shorter() {
    let sharp = shapes(0.0)
        .from(&at(0.0, 0.0, 0.0), Reference::Base)
        .unwrap();
    let whole = 0.3 + core::f64::consts::PI * 0.05;
    // closed forms
    assert!((sharp.course.length_m() - whole).abs() < 1e-9);
    let round = shapes(2e-3)
        .from(&at(0.0, 0.0, 0.0), Reference::Base)
        .unwrap();
    let saved = whole - round.course.length_m();
    // a corner of 90° rounded within 2 mm saves at most twice the 2 mm of its diagonal and 1.2 mm of d
    assert!((1e-4..8e-3).contains(&saved), "{saved}");
    let off = |s: f64| {
        let tool = round.course.at(s).unwrap().pose;
        let all = sharp.course.samples(1e-4);
        all.map(|s| apart(&tool, &sharp.course.at(s).unwrap().pose).0)
            .fold(f64::INFINITY, |a, b| if b < a { b } else { a })
    };
    let worst = round.course.samples(1e-3).map(off);
    let worst = worst.fold(0.0, |a, b| if b > a { b } else { a });
    // within the tolerance, and most of it is used (the nearest of points 0.1 mm apart)
    assert!((1e-3..2.01e-3).contains(&worst), "{worst}");
}

#[test]
fn a_curve_is_the_one_of_the_moving_segment() {
    let points: Vec<[f64; 3]> = (0..30)
        .map(|k| {
            let t = 0.2 * f64::from(k);
            [0.05 * t, 0.03 * libm::sin(t), 0.01 * libm::cos(t) - 0.01]
        })
        .collect();
    let start = at(0.0, 0.0, 0.0);
    let streamed = run(&points).from(&start, Reference::Base).unwrap();
    let mut segment = MovingSegment::new();
    let mut spans = Vec::new();
    for [x, y, z] in points {
        spans.extend(segment.push(at(x, y, z)).unwrap());
    }
    while let Some(span) = segment.finish() {
        spans.push(span);
    }
    let mut s = 0.0;
    for (element, span) in spans.iter().enumerate() {
        for share in [0.0, 0.3, 0.9] {
            let local = share * span.length();
            let (a, b) = (streamed.course.at(s + local).unwrap().pose, span.at(local));
            // poses travel as rotation vectors; rounding of s
            assert!(apart(&a, &b.pose).0 < 1e-14);
            assert_eq!(streamed.course.element(s + local + 1e-9), element);
        }
        s += span.length();
    }
    assert!((streamed.course.end() - s).abs() < 1e-12);
    assert_eq!(streamed.marks.len(), spans.len());
}

#[test]
fn a_run_that_begins_where_the_one_before_ended_is_a_corner() {
    let text = "0,0,0\n0.1,0,0\n\n0.1,0,0\n0.1,0.1,0\n";
    let path = csv::parse(text).unwrap();
    let streamed = path.from(&at(0.0, 0.0, 0.0), Reference::Base).unwrap();
    // the end of a curve must be said, or one curve would go on
    assert_eq!(streamed.marks, [1, 2, 3]);
    let course = &streamed.course;
    assert!((course.length_m() - 0.2).abs() < 1e-12);
    assert_eq!((course.element(0.05), course.element(0.15)), (0, 2));
    let before = course.at(0.1 - 1e-9).unwrap().first.linear;
    let after = course.at(0.1 + 1e-9).unwrap().first.linear;
    assert!(before.dot(&after).abs() < 1e-9);
}

#[test]
fn samples_end_where_pieces_end() {
    let course = shapes(0.0)
        .from(&at(0.0, 0.0, 0.0), Reference::Base)
        .unwrap()
        .course;
    let samples: Vec<f64> = course.samples(0.03).collect();
    // 4 + 4 + 6 (half a circle of 157 mm) + 4
    assert_eq!(samples.len(), 18);
    assert!((samples[3] - 0.1).abs() < 1e-12 && (samples[17] - course.end()).abs() < 1e-12);
    assert!(
        samples
            .windows(2)
            .all(|w| w[1] > w[0] && w[1] - w[0] <= 0.03)
    );
}

#[test]
fn a_tool_is_found_again_where_the_curve_turns_back_and_on_the_spot() {
    let mark = |position_m, turn| Mark {
        line: 1,
        way: Way::Line { corner: SHARP },
        to: Goal {
            position_m,
            rotation_rad: Some([0.0, 0.0, turn]),
        },
        feed_m_s: None,
    };
    let path = ToolPath {
        file: None,
        marks: vec![
            mark([0.1, 0.0, 0.0], 0.0),
            // back at an angle of 20°, a turn on the spot, away
            mark([0.006, 0.0342, 0.0], 0.0),
            mark([0.006, 0.0342, 0.0], 2.0),
            mark([0.006, 0.1, 0.0], 2.0),
        ],
    };
    let start = Pose::from_rotation_vector(Vector3::zeros(), Vector3::zeros());
    let course = path.from(&start, Reference::Base).unwrap().course;
    let mut last = 0.0;
    for k in 0..=4000 {
        let s = course.end() * f64::from(k) / 4000.0;
        let mut tool = course.at(s).unwrap().pose;
        let (found, distance) = course.nearest(&tool, last, 5e-3).unwrap();
        assert!(distance < 1e-9, "{s}: {found} {distance}");
        // beside the curve: off by 50 µm along z, where it has no part
        tool.position.z += 5e-5;
        let (_, off) = course.nearest(&tool, last, 5e-3).unwrap();
        assert!((off - 5e-5).abs() < 1e-8, "{s}: {off}");
        last = found;
    }
    assert!((course.end() - last).abs() < 1e-6);
}

#[test]
fn a_tool_that_comes_to_rest_in_a_corner_is_on_the_curve() {
    let text =
        "0,0,0\n-0.01,0.01,0\n-0.02,0.03,0\n-0.02,0.05,0.01\n\n-0.02,0.05,0.01\n-0.02,0.02,0.02\n";
    let path = csv::parse(text).unwrap();
    let course = path
        .from(&at(0.0, 0.0, 0.0), Reference::Base)
        .unwrap()
        .course;
    let corner = course.end() - libm::sqrt(0.03 * 0.03 + 0.01 * 0.01);
    // whoever looks on remembers the place of another tool, a little behind or ahead
    for ahead in [-3e-4, -2e-5, 0.0, 2e-5, 3e-4] {
        for k in -100..=100 {
            let s = corner + 1e-6 * f64::from(k);
            let tool = course.at(s).unwrap().pose;
            let (found, distance) = course.nearest(&tool, s + ahead, 5e-3).unwrap();
            // what Newton's method leaves when a step is below 1e-12 m or its rounds are over
            assert!(distance < 1e-10, "{k} {ahead}: {found} {distance}");
        }
    }
}

proptest! {
    #[test]
    fn no_text_breaks_the_reader(text in "[-0-9.,#xyz \ne]{0,80}") {
        if let Ok(read) = csv::parse(&text) {
            prop_assert!(read.marks.len() >= 2);
            let line = matches!(read.marks[0].way, Way::Line { .. });
            prop_assert!(line);
        }
    }

    #[test]
    fn what_is_written_is_read(points in prop::collection::vec(prop::array::uniform6(-3.0..3.0f64), 2..20)) {
        let lines = points.iter().map(|[x, y, z, a, b, c]| format!("{x},{y},{z},{a},{b},{c}"));
        let text = lines.collect::<Vec<_>>().join("\n");
        let read = csv::parse(&text).unwrap();
        for (mark, [x, y, z, a, b, c]) in read.marks.iter().zip(points) {
            let to = Goal { position_m: [x, y, z], rotation_rad: Some([a, b, c]) };
            prop_assert_eq!(mark.to, to);
        }
    }

    #[test]
    fn the_nearest_point_of_a_walk_is_found(steps in prop::collection::vec(prop::array::uniform3(-0.01..0.01f64), 4..20)) {
        let mut last = [0.0; 3];
        let mut points = vec![last];
        for step in steps {
            last = [last[0] + step[0] + 0.02, last[1] + step[1], last[2] + step[2]];
            points.push(last);
        }
        let course = run(&points).from(&at(0.0, 0.0, 0.0), Reference::Base).unwrap().course;
        let mut near = 0.0;
        for k in 0..=500 {
            let s = course.end() * f64::from(k) / 500.0;
            let tool = course.at(s).unwrap().pose;
            let (found, distance) = course.nearest(&tool, near, 5e-3).unwrap();
            prop_assert!(distance < 1e-8, "{} {} {}", s, found, distance);
            near = found;
        }
    }
}
