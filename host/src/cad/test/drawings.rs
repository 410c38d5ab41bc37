//! Drawings from end to end.

use super::*;

fn svg(body: &str) -> String {
    format!(
        "<svg xmlns='http://www.w3.org/2000/svg' width='100mm' height='50mm' viewBox='0 0 200 100'>\n{body}\n</svg>"
    )
}

fn drawing(text: String, format: Format) -> Program {
    Program::read(text, format, &Options::default()).unwrap()
}

/// Length of the outlines of a drawing without what goes down, mm, and its box, mm.
fn drawn(program: &Program) -> (f64, [f64; 4]) {
    let summary = program.summary();
    let outlines = f64::from(u32::try_from(summary.rapids / 2).unwrap());
    let down = Options::default().engrave.clearance_m + Options::default().engrave.depth_m;
    let (least, greatest) = (summary.cuts.least_m, summary.cuts.greatest_m);
    let ends = [least[0], least[1], greatest[0], greatest[1]];
    (
        1e3 * (summary.cut_m - outlines * down),
        ends.map(|x| libm::round(1e6 * x) / 1e3),
    )
}

#[test]
fn shapes_and_paths_of_svg_have_their_lengths_and_places() {
    use core::f64::consts::PI;
    // half a millimetre is a unit, y points upwards
    for (body, length, ends) in [
        (
            "<line x1='10' y1='10' x2='50' y2='40'/>",
            25.0,
            [5.0, 30.0, 25.0, 45.0],
        ),
        (
            "<rect x='0' y='0' width='20' height='10'/>",
            30.0,
            [0.0, 45.0, 10.0, 50.0],
        ),
        (
            "<rect width='20' height='10' rx='2'/>",
            30.0 - 8.0 + 2.0 * PI,
            [0.0, 45.0, 10.0, 50.0],
        ),
        (
            "<circle cx='100' cy='50' r='20'/>",
            20.0 * PI,
            [40.0, 15.0, 60.0, 35.0],
        ),
        (
            "<polyline points='0,0 20,0 20,20'/>",
            20.0,
            [0.0, 40.0, 10.0, 50.0],
        ),
        (
            "<polygon points='0,0 30,0 30,40'/>",
            60.0,
            [0.0, 30.0, 15.0, 50.0],
        ),
        ("<path d='M0 0h20v20H0z'/>", 40.0, [0.0, 40.0, 10.0, 50.0]),
        (
            "<path d='m10 10l10 0m0 10l10 0'/>",
            10.0,
            [5.0, 40.0, 15.0, 45.0],
        ),
        (
            "<path d='M0 50A50 50 0 0 1 100 50'/>",
            25.0 * PI,
            [0.0, 25.0, 50.0, 50.0],
        ),
        (
            "<path d='M0 50A50 50 0 1 0 50 0'/>",
            37.5 * PI,
            [0.0, 0.0, 50.0, 50.0],
        ),
        (
            "<path d='M0 0C0 0 20 0 20 0S40 0 40 0Q50 0 60 0T80 0'/>",
            40.0,
            [0.0, 50.0, 40.0, 50.0],
        ),
        (
            "<g transform='translate(10 0) scale(2)'><circle r='5' cx='5' cy='5'/></g>",
            10.0 * PI,
            [5.0, 40.0, 15.0, 50.0],
        ),
        (
            "<defs><text/></defs><line x2='2' display='none'/><line style='display: none' x2='9'/><line x2='20mm'/>",
            37.795,
            [0.0, 50.0, 37.795, 50.0],
        ),
    ] {
        let (got, place) = drawn(&drawing(svg(body), Format::Svg));
        // the length of a spline is that of a polygon of 32 sides or more: 1e-3 of it; splines' boxes as well
        assert!(
            (got - length).abs() < 1e-3 * length,
            "{body}: {got} {length}"
        );
        for (got, wanted) in place.iter().zip(ends) {
            assert!((got - wanted).abs() < 0.02, "{body}: {place:?}");
        }
    }
}

#[test]
fn a_drawing_is_as_deep_as_the_task_says_however_large_it_is() {
    for (z, depth) in [
        (ZRule::AsPlane, 2e-4),
        (ZRule::Scale(9.0), 2e-4),
        (ZRule::Depth(1e-3), 1e-3),
    ] {
        let options = Options { z, ..fitted() };
        let circle = svg("<circle r='1'/>");
        let program = Program::read(circle, Format::Svg, &options).unwrap();
        let board = program.summary().on_board;
        let ends = [board.least_m, board.greatest_m];
        // 80 mm in the middle of 120 by 100
        for (got, wanted) in ends
            .iter()
            .flatten()
            .zip([0.02, 0.01, -depth, 0.1, 0.09, 2e-3])
        {
            assert!((got - wanted).abs() < 1e-9, "{board:?}");
        }
    }
}

fn dxf(entities: &str) -> String {
    let groups = entities.split_whitespace().collect::<Vec<_>>().join("\n");
    format!(
        "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n4\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n{groups}\n0\nENDSEC\n0\nEOF\n"
    )
}

#[test]
fn entities_of_dxf_have_their_lengths_and_places() {
    use core::f64::consts::PI;
    for (entities, length, ends) in [
        ("0 LINE 10 0 20 0 11 3 21 4", 5.0, [0.0, 0.0, 3.0, 4.0]),
        (
            "0 LINE 10 0 20 0 11 3 21 4 0 LINE 10 9 20 4 11 3 21 4",
            11.0,
            [0.0, 0.0, 9.0, 4.0],
        ),
        (
            "0 LWPOLYLINE 90 3 70 1 10 0 20 0 10 3 20 0 10 3 20 4",
            12.0,
            [0.0, 0.0, 3.0, 4.0],
        ),
        (
            "0 LWPOLYLINE 90 2 70 1 10 0 20 0 42 1 10 2 20 0 42 1",
            2.0 * PI,
            [0.0, -1.0, 2.0, 1.0],
        ),
        (
            "0 POLYLINE 70 0 0 VERTEX 10 0 20 0 42 -1 0 VERTEX 10 2 20 0 0 SEQEND",
            PI,
            [0.0, 0.0, 2.0, 1.0],
        ),
        ("0 CIRCLE 10 5 20 5 40 2", 4.0 * PI, [3.0, 3.0, 7.0, 7.0]),
        (
            "0 ARC 10 0 20 0 40 2 50 270 51 90",
            2.0 * PI,
            [0.0, -2.0, 2.0, 2.0],
        ),
        (
            "0 ELLIPSE 10 0 20 0 11 2 21 0 40 1 41 0 42 3.141592653589793",
            2.0 * PI,
            [-2.0, 0.0, 2.0, 2.0],
        ),
        (
            "0 SPLINE 70 8 71 1 40 0 40 0 40 1 40 1 10 0 20 0 10 6 20 8",
            10.0,
            [0.0, 0.0, 6.0, 8.0],
        ),
        (
            "0 POINT 10 1 20 1 0 LINE 10 0 20 0 11 3 21 4",
            5.0,
            [0.0, 0.0, 3.0, 4.0],
        ),
    ] {
        let (got, place) = drawn(&drawing(dxf(entities), Format::Dxf));
        assert!(
            (got - length).abs() < 1e-3 * length,
            "{entities}: {got} {length}"
        );
        for (got, wanted) in place.iter().zip(ends) {
            assert!((got - wanted).abs() < 1e-3, "{entities}: {place:?}");
        }
    }
}

#[test]
fn drawings_that_are_no_outlines_are_refused_with_their_place() {
    let options = Options::default();
    let mut refused = Vec::new();
    for body in [
        "<text>a</text>",
        "<use href='#a'/>",
        "<image/>",
        "<path d='M0 0 L'/>",
        "<rect width='1em' height='2'/>",
        "<g transform='spin(2)'/>",
        "<line x2='1e9' transform='scale(1e200)'/>",
        "<g></h>",
        "",
    ] {
        refused.push((
            body,
            Program::read(svg(body), Format::Svg, &options).unwrap_err(),
        ));
    }
    for entities in [
        "0 TEXT 1 a",
        "0 LINE 10 0 20 0 11 1",
        "0 LINE 10 0 20 0 30 5 11 1 21 1",
        "0 CIRCLE 10 0 20 0 40 0",
        "0 CIRCLE 10 x 20 0 40 1",
        "0 SPLINE 71 3 11 0 21 0",
        "0 SPLINE 71 3 40 0 10 0 20 0",
        "0 POLYLINE 70 64",
        "0 POLYLINE 70 0",
        "0 VERTEX 10 0 20 0",
        "x",
        "0 ARC 10 0 20 0 40 1 50 0 51 90 230 -1",
    ] {
        refused.push((
            entities,
            Program::read(dxf(entities), Format::Dxf, &options).unwrap_err(),
        ));
    }
    let mut told = String::new();
    for (text, error) in refused {
        writeln!(told, "{text:?}\n    {error}").unwrap();
    }
    gcode::golden("drawings.txt", &told);
}

#[test]
fn files_of_other_kinds_are_refused_by_name() {
    let error = Program::open(Path::new("a.step"), &Files::on_disk(), &Options::default())
        .unwrap_err()
        .to_string();
    assert_eq!(
        error,
        "a.step:1:1: error: a file of another kind (expected .ngc, .nc, .gcode, .tap, .dxf or .svg, got `step`)"
    );
}
