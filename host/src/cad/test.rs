//! Files from end to end: what a program becomes on a board.

mod drawings;

use super::place::{Extent, Placement, ZRule};
use super::section::{PathSection, Work};
use super::step::{Action, distance};
use super::*;
use crate::mp::generator::PathSource;
use crate::path::{Course, Mark};
use motion::Pose;
use motion::path::{Arc as Circular, Join, MovingSegment, Path as Pieces, Straight, Tolerance};
use proptest::prelude::*;
use protocol::message::PathElement;
use std::fmt::Write as _;
use std::path::PathBuf;

/// A real file of others, if it is there: where `MRROC_GCODE` says.
pub(super) fn real(name: &str) -> Option<PathBuf> {
    let path = Path::new(&std::env::var_os("MRROC_GCODE")?).join(name);
    path.exists().then_some(path)
}

fn fitted() -> Options {
    Options {
        placement: Placement::Fit {
            board_m: [0.12, 0.1],
            margin_m: 0.01,
            enlarge: true,
        },
        z: ZRule::Depth(2e-4),
        ..Options::default()
    }
}

fn program(text: &str, options: &Options) -> Program {
    Program::read(text.to_owned(), Format::Gcode, options).unwrap()
}

fn paths(program: &Program) -> Vec<PathSection> {
    let paths = program.sections().filter_map(|section| match section.what {
        Work::Path(path) => Some(*path),
        Work::Action(_) => None,
    });
    paths.collect()
}

fn elements(path: &PathSection) -> Vec<PathElement> {
    path.clone()
        .on(Pose::identity(), Pose::identity())
        .elements()
        .collect()
}

fn course(path: &PathSection) -> Course {
    Course::new(Pose::identity(), &elements(path)).unwrap()
}

/// How often the tool has to rest, as the pieces of a node say; the beginning is not counted.
fn stops(elements: &[PathElement]) -> usize {
    let (mut path, mut at, mut curve) = (Pieces::<32>::new(), Pose::identity(), None);
    let mut stops = 0;
    let mut count = |join: Result<Join, motion::path::QueueError>| {
        stops += usize::from(join.unwrap() == Join::Stop);
    };
    for element in elements {
        path.discard_before(path.end() - 1e-9);
        if let PathElement::Through(to) = element {
            let segment = curve.get_or_insert_with(|| {
                let mut segment = MovingSegment::new();
                segment.push(at).unwrap();
                segment
            });
            at = crate::path::pose(to);
            if let Some(span) = segment.push(at).unwrap() {
                count(path.push(span));
            }
            continue;
        }
        if let Some(mut segment) = curve.take() {
            while let Some(span) = segment.finish() {
                count(path.push(span));
            }
        }
        let (to, corner, arc) = match element {
            PathElement::Line { to, corner } => (to, corner, None),
            PathElement::Arc { via_m, to, corner } => (to, corner, Some(*via_m)),
            _ => continue,
        };
        let to = crate::path::pose(to);
        let piece: motion::path::Piece = match arc {
            Some(via) => Circular::through(at, via.into(), to).unwrap().into(),
            None => match Straight::new(at, to) {
                Ok(line) => line.into(),
                Err(_) => continue,
            },
        };
        at = to;
        let metres = f64::from(corner.metres);
        let radians = f64::from(corner.radians);
        count(if metres > 0.0 {
            path.push_blended(piece, &Tolerance { metres, radians })
        } else {
            path.push(piece)
        });
    }
    stops - 1
}

/// Points of the whole curve, at most so far apart, m.
fn points(course: &Course, step: f64) -> Vec<[f64; 3]> {
    let all = core::iter::once(0.0).chain(course.samples(step));
    let points = all.filter_map(|s| course.at(s));
    points.map(|point| point.pose.position.into()).collect()
}

/// The distance of a point from a polygon.
fn off(point: &[f64; 3], polygon: &[[f64; 3]]) -> f64 {
    let mut least = f64::INFINITY;
    for pair in polygon.windows(2) {
        let side: Vec<f64> = (0..3).map(|k| pair[1][k] - pair[0][k]).collect();
        let square: f64 = side.iter().map(|x| x * x).sum();
        let along: f64 = (0..3).map(|k| side[k] * (point[k] - pair[0][k])).sum();
        let share = if square > 0.0 {
            (along / square).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let nearest = step::mix(&pair[0], &pair[1], share);
        let off = distance(point, &nearest);
        least = if off < least { off } else { least };
    }
    least
}

#[test]
fn real_programs_become_paths_that_a_node_takes_on_their_board() {
    for name in [
        "arcspiral.ngc",
        "butterfly-xy.ngc",
        "cds.ngc",
        "flowsnake.ngc",
    ] {
        let Some(file) = real(name) else {
            continue;
        };
        let surface_m = if name == "cds.ngc" { 0.0508 } else { 0.0 };
        let options = Options {
            surface_m,
            ..fitted()
        };
        let program = Program::open(&file, &Files::on_disk(), &options).unwrap();
        let Extent {
            least_m,
            greatest_m,
        } = program.summary().on_board;
        // one pair of edges is touched, the other within
        assert!((least_m[2] + 2e-4).abs() < 1e-9, "{name} {least_m:?}");
        let tight = (greatest_m[0] - least_m[0] - 0.1).abs() < 1e-9
            || (greatest_m[1] - least_m[1] - 0.08).abs() < 1e-9;
        assert!(tight, "{name} {least_m:?} {greatest_m:?}");
        for path in paths(&program) {
            let elements = elements(&path);
            let Some(PathElement::Line { to, .. }) = elements.get(1) else {
                panic!("{name}: {:?}", elements.first());
            };
            let course = Course::new(crate::path::pose(to), &elements).unwrap();
            // rounding of corners is inwards; curves leave their polygons by the tolerance at most
            for point in points(&course, 1e-4) {
                let inside =
                    |k: usize, low: f64, high: f64| point[k] > low - 3e-5 && point[k] < high + 3e-5;
                let down = point[2] < 1e-6;
                assert!(
                    !down || (inside(0, 0.01, 0.11) && inside(1, 0.01, 0.09)),
                    "{name} {point:?}"
                );
            }
        }
    }
}

#[test]
fn a_circle_of_short_lines_between_long_ones_is_passed_without_a_stop() {
    let mut text = "G0 X-20 Y0 Z0\nF600 G1 X0\n".to_owned();
    // half a circle of 20 mm, sides of 0.63 mm, which leave it by 2.5 µm
    for k in 1..=100 {
        let angle = core::f64::consts::PI * f64::from(k) / 100.0;
        let (x, y) = (20.0 * libm::sin(angle), 20.0 * (1.0 - libm::cos(angle)));
        writeln!(text, "X{x:.6} Y{y:.6}").unwrap();
    }
    text += "X-20\n";
    let program = program(&text, &Options::default());
    let path = &paths(&program)[0];
    let elements = elements(path);
    let through = elements
        .iter()
        .filter(|e| matches!(e, PathElement::Through(_)))
        .count();
    assert!(through >= 100, "{through}");
    // one: where the lead-in ends
    assert_eq!(stops(&elements), 1);
    for point in points(&course(path), 1e-4) {
        if point[0] > 0.0 {
            let radius = libm::hypot(point[0], point[1] - 0.02);
            assert!((radius - 0.02).abs() < 2e-5, "{point:?}");
        }
    }
}

#[test]
fn what_the_program_keeps_exactly_has_stops_and_nothing_else_has() {
    let corner = "G0 X0 Y0 Z0 F600\nG1 X10\nY10\nX0\nY0\n";
    for (mode, count) in [("G64 P0.1", 0), ("G64", 0), ("G61", 3), ("G64 P0", 3)] {
        let program = program(&format!("{mode}\n{corner}"), &Options::default());
        assert_eq!(stops(&elements(&paths(&program)[0])), count, "{mode}");
    }
}

#[test]
fn feeds_are_said_where_they_change_and_actions_part_the_paths() {
    let text =
        "G0 X0 Y0 Z1\nM3 S60\nG1 F60 Z0\nX10\nF120 X20\nG0 Z1\nG4 P2\nM5\nT3 M6\nG0 X0\nM0\nM2\n";
    let program = program(text, &Options::default());
    let kinds: Vec<_> = program
        .sections()
        .map(|section| match section.what {
            Work::Path(path) => {
                let feeds: Vec<_> = path.marks().filter_map(|mark| mark.feed_m_s).collect();
                (section.line, format!("{feeds:.3?}"))
            }
            Work::Action(Action::Spindle { clockwise, .. }) => {
                (section.line, format!("{clockwise:?}"))
            }
            Work::Action(action) => (section.line, format!("{action:?}")),
        })
        .collect();
    let wanted = [
        (1, "[0.100]"),
        (2, "Some(true)"),
        (3, "[0.100, 0.001, 0.002, 0.100]"),
        (7, "Dwell(2.0)"),
        (8, "None"),
        (9, "Tool(3)"),
        (10, "[0.100]"),
        (11, "Stop { optional: false }"),
        (12, "None"),
    ];
    assert_eq!(kinds, wanted.map(|(line, what)| (line, what.to_owned())));
    let summary = program.summary();
    assert_eq!(
        (
            summary.rapids,
            summary.lines,
            summary.actions,
            summary.stops
        ),
        (3, 3, 6, 2)
    );
    // 1 mm and 10 mm at 1 mm/s, 10 mm at 2 mm/s, 1 mm and 20 mm at 0.1 m/s, and the dwell
    let seconds = 11.0 + 5.0 + 0.021 / 0.1 + 2.0;
    assert!(
        (summary.estimate_s - seconds).abs() < 1e-9,
        "{}",
        summary.estimate_s
    );
}

#[test]
fn a_path_is_the_same_whenever_it_is_gone_through() {
    let text = "G0 X0 Y0 Z0 F600\n#1=0\no1 repeat [5000]\n#1=[#1+1]\nG1 X[#1*0.3] Y[sin[#1*3]]\no1 endrepeat\nM0\nG1 X1\n";
    let program = program(text, &Options::default());
    let [first, second] = &paths(&program)[..] else {
        panic!("two paths");
    };
    let once: Vec<Mark> = first.marks().collect();
    assert_eq!(once, first.marks().collect::<Vec<_>>());
    assert!(once.len() > 4000 && once.iter().all(|mark| mark.line <= 5));
    assert!(second.marks().all(|mark| mark.line == 8));
    // 2 mm in ripples of 120 steps: one curve, however its vertices are looked at together
    assert_eq!(stops(&elements(first)), 0);
}

#[test]
fn the_depth_and_the_place_are_those_of_the_rule() {
    let cut = "G0 X10 Y10 Z5\nF60 G1 Z-2\nX30 Y20\n";
    let place = |placement, z, surface_m| {
        let options = Options {
            placement,
            z,
            surface_m,
            ..Options::default()
        };
        let got = program(cut, &options).summary().on_board;
        [got.least_m, got.greatest_m].map(|end| end.map(|x| libm::round(x * 1e7) / 1e4))
    };
    let fit = |edge, enlarge| Placement::Fit {
        board_m: [edge, edge],
        margin_m: 1e-3,
        enlarge,
    };
    assert_eq!(
        place(Placement::Scale(2.0), ZRule::AsPlane, 0.0),
        [[20.0, 20.0, -4.0], [60.0, 40.0, 10.0]]
    );
    // half as large, in the middle
    assert_eq!(
        place(fit(0.012, false), ZRule::Scale(1.0), 0.0),
        [[1.0, 3.5, -2.0], [11.0, 8.5, 5.0]]
    );
    assert_eq!(
        place(fit(0.042, false), ZRule::Depth(1e-3), 0.0),
        [[11.0, 16.0, -1.0], [31.0, 26.0, 2.5]]
    );
    assert_eq!(
        place(fit(0.042, true), ZRule::Depth(1e-3), 0.006),
        [[1.0, 11.0, -1.0], [41.0, 31.0, -0.125]]
    );
    // nothing below the surface: lowered
    assert_eq!(
        place(Placement::Scale(1.0), ZRule::Depth(1e-3), -0.002),
        [[10.0, 10.0, -1.0], [30.0, 20.0, 6.0]]
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn the_tool_stays_within_the_tolerance_of_any_polygon(
        sides in prop::collection::vec((0.02_f64..2.0, -0.8_f64..0.8), 2..120),
        tolerance in prop::sample::select(vec![2e-6, 2e-5, 2e-4]),
    ) {
        let mut text = "G0 X0 Y0 Z0 F600 G1\n".to_owned();
        let (mut at, mut way) = ([0.0; 3], 0.0);
        let mut polygon = vec![at];
        for (length, turn) in sides {
            way += turn * turn * turn;
            at[0] += 1e-3 * length * libm::cos(way);
            at[1] += 1e-3 * length * libm::sin(way);
            let mm = at.map(|x| 1e3 * x);
            writeln!(text, "X{:.9} Y{:.9}", mm[0], mm[1]).unwrap();
            polygon.push(at);
        }
        let options = Options { tolerance_m: tolerance, ..Options::default() };
        let text = text.replacen(" G1\n", "\nG1\n", 1);
        let program = program(&text, &options);
        let points = points(&course(&paths(&program)[0]), 1e-5);
        // nine digits of mm; what lies between compared points, and f32 of the tolerance
        for point in &points {
            prop_assert!(off(point, &polygon) <= 1.02 * tolerance + 1e-9);
        }
        for vertex in &polygon {
            // the points are 10 µm apart on curves of 0.01 mm and more
            prop_assert!(off(vertex, &points) <= 1.02 * tolerance + 2e-6, "{vertex:?}");
        }
    }

    #[test]
    fn splines_and_helices_are_kept_to_a_micrometre(
        control in prop::collection::vec([0.0_f64..20.0, 0.0..20.0], 3..8), rise in -3.0_f64..3.0,
    ) {
        prop_assume!(control.iter().any(|[x, y]| x + y > 1.0));
        let mut text = "G0 X0 Y0 Z0 F600\n".to_owned();
        for (k, [x, y]) in control.iter().enumerate() {
            let begin = if k == 0 { "G5.2 " } else { "" };
            writeln!(text, "{begin}X{x:.3} Y{y:.3}").unwrap();
        }
        writeln!(text, "G5.3\nG91 G3 X0 Y0 I5 Z{rise:.3}").unwrap();
        let program = program(&text, &Options::default());
        let made: Vec<_> = program.source.steps(&program.options).map(|step| match step.unwrap().what {
            step::What::Move(made) => made,
            step::What::Action(_) => unreachable!(),
        }).collect();
        let course = course(&paths(&program)[0]);
        let wanted: Vec<[f64; 3]> = made.iter().skip(1)
            .flat_map(|made| (0..=1500).map(|k| made.at(f64::from(k) / 1500.0)))
            .collect();
        // corners between them are rounded by 20 µm: those of lines that stand in for sharp bends, too
        let mut far = 0;
        let points = points(&course, 1e-4);
        for point in &points {
            let off = off(point, &wanted);
            prop_assert!(off <= 2.1e-5, "{off}");
            far += usize::from(off > 1.1e-6);
        }
        prop_assert!(far * 10 <= points.len(), "{far} of {}", points.len());
    }

    #[test]
    fn any_drawing_is_outlines_or_one_line_about_it(text in "(?s).{0,200}") {
        for format in [Format::Svg, Format::Dxf] {
            if let Err(error) = Program::read(text.clone(), format, &Options::default()) {
                prop_assert_eq!(error.to_string().lines().count(), 1);
            }
        }
    }
}
