use super::*;
use crate::plot::{Picture, png, svg};

/// A board of 60 × 40 mm in cells of 0.5 mm with a groove along y = 20 mm, 2 mm deep, of 45° walls.
fn grooved() -> Vec<f32> {
    (0..80_u8)
        .flat_map(|row| {
            let beside = (f32::from(row) + 0.5) * 0.5e-3 - 20e-3;
            let height = beside.abs() - 2e-3;
            [if height < 0.0 { height } else { 0.0 }; 120]
        })
        .collect()
}

fn sample(x: f64, error_m: f64) -> PathError {
    PathError {
        at_m: [x, 0.02],
        error_m,
    }
}

fn picture<'a>(
    heights_m: &'a [f32],
    programmed: &'a [ProgrammedLine],
    errors: &'a [PathError],
) -> BoardPicture<'a> {
    BoardPicture {
        title: "a <board>".into(),
        summary: vec!["one line".into(), "another".into()],
        size_m: [0.06, 0.04],
        heights_m,
        columns: 120,
        programmed,
        errors,
    }
}

fn raster(drawing: &Drawing) -> &Raster {
    let found = drawing.shapes.iter().find_map(|shape| match shape {
        Shape::Raster(_, raster) => Some(raster),
        _ => None,
    });
    found.unwrap()
}

fn brightness(raster: &Raster, column: u32, row: u32) -> u32 {
    let [r, g, b] = raster.pixels[(row * raster.columns + column) as usize].map(u32::from);
    r + g + b
}

/// Lines of the width that errors are drawn with.
fn coloured(drawing: &Drawing) -> Vec<(Vec<[f64; 2]>, Colour)> {
    let lines = drawing.shapes.iter().filter_map(|shape| match shape {
        Shape::Line(points, stroke) if stroke.width > 1.5 => Some((points.clone(), stroke.colour)),
        _ => None,
    });
    lines.collect()
}

#[test]
fn light_comes_from_the_upper_left() {
    let heights = grooved();
    let drawing = lay_out(&picture(&heights, &[], &[]));
    let raster = raster(&drawing);
    // 640 × 427 units, one and a half pixels each; 16 pixels a millimetre
    assert_eq!((raster.columns, raster.rows), (960, 641));
    let mean = |mm_from_middle: f64| {
        let row = pixels(0.5 * f64::from(raster.rows) + 16.0 * mm_from_middle);
        let sum: u32 = (0..raster.columns)
            .map(|c| brightness(raster, c, row))
            .sum();
        sum / raster.columns
    };
    let (above, upper_wall, lower_wall, below) = (mean(-8.0), mean(-1.0), mean(1.0), mean(8.0));
    // the wall below the middle faces the light, that above it is in the shadow
    assert!(lower_wall > upper_wall + 60, "{lower_wall} {upper_wall}");
    // and a cut is darker than the wood around it, which has no side
    assert!(
        above > lower_wall + 30 && below > lower_wall + 30,
        "{above} {lower_wall} {below}"
    );
    assert!(above.abs_diff(below) < 60, "{above} {below}");
}

#[test]
fn errors_have_their_colours_and_gaps() {
    let line: Vec<PathError> = (0..400_u16)
        .map(|k| {
            let x = 0.01 + f64::from(k) * 1e-4;
            let error = if k < 200 { 1e-6 } else { -40e-6 };
            sample(
                x,
                if (300..310).contains(&k) {
                    f64::NAN
                } else {
                    error
                },
            )
        })
        .collect();
    let drawing = lay_out(&picture(&[], &[], &line));
    let lines = coloured(&drawing);
    // small, great, and great after the gap
    assert_eq!(lines.len(), 3);
    assert_ne!(lines[0].1, lines[1].1);
    assert_eq!(lines[1].1, lines[2].1);
    let x = |mm: f64| BOARD_LEFT + WIDEST + GAP + mm / 60.0 * WIDEST;
    let ends = |n: usize| (lines[n].0[0][0], lines[n].0.last().unwrap()[0]);
    // the points nearest to the ends are kept to 0.7 of a pixel, the ends themselves exactly
    assert!((ends(0).0 - x(10.0)).abs() < 1e-6 && (ends(0).1 - x(30.0)).abs() < 2.0);
    assert!((ends(1).1 - x(39.9)).abs() < 1e-6 && (ends(2).0 - x(41.0)).abs() < 1e-6);
    assert!((ends(2).1 - x(49.9)).abs() < 1e-6);
}

#[test]
fn the_bar_ends_at_a_round_number_and_names_what_is_beyond() {
    let words = |errors: &[PathError]| -> Vec<String> {
        let drawing = lay_out(&picture(&[], &[], errors));
        let texts = drawing.shapes.into_iter().filter_map(|shape| match shape {
            Shape::Text(text) => Some(text.words),
            _ => None,
        });
        texts.collect()
    };
    let has = |words: &[String], label: &str| words.iter().any(|w| w == label);
    let even: Vec<PathError> = (0..1000_u16)
        .map(|k| sample(0.03, f64::from(k) * 33e-9))
        .collect();
    let plain = words(&even);
    assert!(has(&plain, "40") && has(&plain, "max 33.0 µm"), "{plain:?}");
    let mut outlier = even;
    outlier.push(sample(0.03, 900e-6));
    let cut_off = words(&outlier);
    assert!(
        has(&cut_off, "≥ 40") && has(&cut_off, "max 900 µm"),
        "{cut_off:?}"
    );
    assert!(!words(&[]).iter().any(|w| w.starts_with("max")));
    // no error at all has a bar too
    assert!(has(&words(&[sample(0.03, 0.0)]), "max 0.000 µm"));
}

#[test]
fn rapids_are_dashed_and_explained() {
    let points_m = vec![[0.0, 0.0], [0.06, 0.04]];
    let line = |cutting| ProgrammedLine {
        points_m: points_m.clone(),
        cutting,
    };
    let dashes = |programmed: &[ProgrammedLine]| {
        let written = svg(&Picture::from(&picture(&[], programmed, &[])));
        (
            written.matches("stroke-dasharray").count(),
            written.contains(">rapid<"),
        )
    };
    assert_eq!(dashes(&[line(true)]), (0, false));
    assert_eq!(dashes(&[line(true), line(false)]), (2, true));
}

#[test]
fn both_kinds_of_picture_hold_the_board_and_are_the_same_every_time() {
    let heights = grooved();
    let errors = [sample(0.01, 2e-6), sample(0.05, 4e-6)];
    let data = Picture::from(&picture(&heights, &[], &errors));
    let written = svg(&data);
    assert_eq!(written, svg(&data));
    assert!(written.contains("a &lt;board&gt;"));
    assert_eq!(
        written
            .matches("href=\"data:image/png;base64,iVBORw0KGgo")
            .count(),
        1
    );
    assert_eq!(png(&data).unwrap(), png(&data).unwrap());
}

#[test]
fn wrong_numbers_and_odd_boards_make_a_picture_too() {
    let nan = [
        f32::NAN,
        f32::INFINITY,
        -1e-3,
        5.0,
        f32::NEG_INFINITY,
        0.0,
        1.0,
    ];
    let wrong = ProgrammedLine {
        points_m: vec![[f64::NAN, 0.0], [0.0, f64::INFINITY], [0.01, 0.01]],
        cutting: true,
    };
    for size_m in [
        [0.0, 0.0],
        [f64::NAN, 1.0],
        [-1.0, f64::INFINITY],
        [1e-3, 1.0],
        [1e300, 1e-300],
    ] {
        for columns in [0, 3] {
            let data = BoardPicture {
                size_m,
                heights_m: &nan,
                columns,
                programmed: core::slice::from_ref(&wrong),
                errors: &[sample(f64::NAN, 1.0), sample(0.0, f64::INFINITY)],
                ..BoardPicture::default()
            };
            let picture = Picture::from(&data);
            let written = svg(&picture);
            // the digits of pixels may spell anything
            let numbers = written.lines().filter(|l| !l.starts_with("<image"));
            let numbers: String = numbers.collect();
            assert!(
                !numbers.contains("NaN") && !numbers.contains("inf"),
                "{size_m:?} {numbers}"
            );
            assert!(picture.0.width < 1800.0 && picture.0.height < 900.0);
        }
    }
}
