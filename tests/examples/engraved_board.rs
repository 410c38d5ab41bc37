//! A board with a name, a spiral and a frame, cut by a V-bit behind a lagging machine, and its picture.
//!
//! `cargo run --release -p mrroc-tests --example engraved_board -- board.png` (or `.svg`)

use hil_sim::workpiece::{Board, CELL_M, Cutter, Shank, Tool};
use host::plot::{BoardPicture, PathError, Picture, ProgrammedLine};
use motion::Pose;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_3, PI, TAU};
use std::path::Path;

/// The board, m.
const SIZE_M: [f64; 2] = [0.188, 0.1];
/// A millimetre, m.
const MM: f64 = 1e-3;
/// A step of the machine, s.
const STEP_S: f64 = 1e-3;
/// Speeds in the wood and above it, m/s.
const FEED: f64 = 0.03;
const RAPID: f64 = 0.15;
/// Above the board, mm.
const CLEAR: f64 = 3.0;
/// The machine follows like a damped mass on a spring: its natural frequency (rad/s) and damping, ASSUMED.
const NATURAL: f64 = 60.0;
const DAMPING: f64 = 0.5;
/// Part of the programmed path, in steps, within which the tool is looked for.
const LATE: usize = 60;

/// Points x, y, z in mm.
type Stroke = Vec<[f64; 3]>;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let name = std::env::args_os()
        .nth(1)
        .ok_or("expected the name of a picture, .png or .svg")?;
    let path = Path::new(&name);
    host::plot::check_name(path)?;
    let cutter = Cutter::V {
        tip_m: 0.1 * MM,
        angle_rad: FRAC_PI_3,
    };
    let shank = Shank {
        cutting_length_m: 5.0 * MM,
        diameter_m: 6.0 * MM,
        stick_out_m: 30.0 * MM,
        holder_diameter_m: 40.0 * MM,
    };
    let tool = Tool::new(cutter, shank)?;
    let mut board = Board::new(SIZE_M, 15.0 * MM, CELL_M)?;
    let strokes = drawing();
    let programmed = program(&strokes);
    let (actual, errors) = follow(&timed(&strokes));
    let mut deepest = 0.0;
    for pair in actual.windows(2) {
        if let [from, to] = pair {
            let cut = board.cut(&tool, &upright(*from), &upright(*to))?;
            deepest = if cut.depth_m > deepest {
                cut.depth_m
            } else {
                deepest
            };
            if let Some(contact) = cut.collision.or(cut.through) {
                return Err(format!("the tool touches what it must not: {contact:?}").into());
            }
        }
    }
    let length: f64 = strokes.iter().flat_map(|s| s.windows(2)).map(way).sum();
    let summary = vec![
        format!(
            "V-bit 60°, tip 0.1 mm  ·  {} strokes, {:.2} m in the wood at {:.0} mm/s  ·  {:.0} s",
            strokes.len(),
            length * MM,
            FEED / MM,
            STEP_S * f64::from(u32::try_from(actual.len())?),
        ),
        format!(
            "{:.2} cm³ removed, {:.2} mm deep  ·  map {:016x}",
            board.removed_m3() * 1e6,
            deepest / MM,
            board.digest()
        ),
    ];
    let picture = BoardPicture {
        title: "An engraved board".into(),
        summary,
        size_m: board.size_m(),
        heights_m: board.heights(),
        columns: board.columns(),
        programmed: &programmed,
        errors: &errors,
    };
    host::plot::save(&Picture::from(&picture), path)?;
    Ok(())
}

/// What is engraved: a frame, a spiral that breathes, five letters, and waves below them.
fn drawing() -> Vec<Stroke> {
    let mut strokes = vec![frame()];
    strokes.push(curve(1600, |s| {
        let turned = 8.0 * TAU * s;
        let radius = 3.0 + 25.0 * s;
        let depth = 0.9 + 0.5 * libm::sin(7.0 * turned);
        let (sin, cos) = libm::sincos(turned);
        [46.0 + radius * cos, 50.0 + radius * sin, -depth]
    }));
    let (base, depth) = (50.0, 1.6);
    let line =
        |x: f64, low: f64, high: f64| curve(60, |s| [x, base + high - (high - low) * s, -depth]);
    // parts of circles: middle, radius, angles
    let arc = |x: f64, y: f64, r: f64, from: f64, to: f64| {
        curve(160, |s| {
            let (sin, cos) = libm::sincos(from + (to - from) * s);
            [x + r * cos, base + y + r * sin, -depth]
        })
    };
    let then = |mut a: Stroke, b: Stroke| {
        a.extend(b);
        a
    };
    strokes.push(line(90.0, 0.0, 17.0));
    strokes.push(then(arc(95.0, 12.0, 5.0, PI, 0.0), line(100.0, 0.0, 12.0)));
    strokes.push(then(arc(105.0, 12.0, 5.0, PI, 0.0), line(110.0, 0.0, 12.0)));
    for x in [116.0, 126.0] {
        strokes.push(line(x, 0.0, 17.0));
        strokes.push(arc(x + 6.0, 11.0, 6.0, PI, 0.30 * PI));
    }
    strokes.push(arc(144.0, 8.5, 8.5, FRAC_PI_2, FRAC_PI_2 + TAU));
    strokes.push(arc(164.0, 8.5, 8.5, 0.27 * PI, 1.73 * PI));
    for row in 0..3 {
        let row = f64::from(row);
        strokes.push(curve(700, |s| {
            let x = 88.0 + 82.0 * s;
            let y = 36.0 - 6.0 * row + 2.2 * libm::sin(0.33 * x + row);
            // out of the wood at both ends
            [x, y, -1.3 * libm::sin(PI * s) - 0.02]
        }));
    }
    strokes
}

/// A rounded rectangle 6 mm from the edges.
fn frame() -> Stroke {
    let (right, top) = (SIZE_M[0] / MM - 6.0, SIZE_M[1] / MM - 6.0);
    let (edge, radius) = (6.0, 8.0);
    let mut points = Vec::new();
    let corners = [
        ([right - radius, edge + radius], -FRAC_PI_2),
        ([right - radius, top - radius], 0.0),
        ([edge + radius, top - radius], FRAC_PI_2),
        ([edge + radius, edge + radius], PI),
    ];
    for ([x, y], begin) in corners {
        points.extend(curve(40, |s| {
            let (sin, cos) = libm::sincos(begin + FRAC_PI_2 * s);
            [x + radius * cos, y + radius * sin, -0.8]
        }));
    }
    points.extend(points.first().copied());
    points
}

fn curve(count: u32, at: impl Fn(f64) -> [f64; 3]) -> Stroke {
    (0..=count)
        .map(|k| at(f64::from(k) / f64::from(count)))
        .collect()
}

/// The way between two points, mm.
fn way(pair: &[[f64; 3]]) -> f64 {
    match pair {
        [a, b] => libm::hypot(libm::hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]),
        _ => 0.0,
    }
}

/// The strokes and the ways between them, as the picture wants them.
fn program(strokes: &[Stroke]) -> Vec<ProgrammedLine> {
    let flat = |p: &[f64; 3]| [p[0] * MM, p[1] * MM];
    let mut lines = Vec::new();
    for (number, stroke) in strokes.iter().enumerate() {
        lines.push(ProgrammedLine {
            points_m: stroke.iter().map(flat).collect(),
            cutting: true,
        });
        let next = strokes.get(number + 1).and_then(|s| s.first());
        if let (Some(end), Some(next)) = (stroke.last(), next) {
            lines.push(ProgrammedLine {
                points_m: vec![flat(end), flat(next)],
                cutting: false,
            });
        }
    }
    lines
}

/// A set-point a step, mm, and whether it cuts: each piece begins and ends at rest, as s² (3 − 2s).
fn timed(strokes: &[Stroke]) -> Vec<([f64; 3], bool)> {
    let mut points = Vec::new();
    let mut at = [0.0, 0.0, CLEAR];
    for stroke in strokes {
        let (Some(first), Some(last)) = (stroke.first(), stroke.last()) else {
            continue;
        };
        let above = |p: &[f64; 3]| [p[0], p[1], CLEAR];
        move_along(&[at, above(first)], RAPID, false, &mut points);
        move_along(&[above(first), *first], FEED, false, &mut points);
        move_along(stroke, FEED, true, &mut points);
        move_along(&[*last, above(last)], RAPID, false, &mut points);
        at = above(last);
    }
    points
}

fn move_along(line: &[[f64; 3]], speed: f64, cutting: bool, out: &mut Vec<([f64; 3], bool)>) {
    let length: f64 = line.windows(2).map(way).sum();
    // twice as slow as the fastest part of a cubic needs, on short ways
    let duration = length * MM / speed + 0.15;
    let mut steps = 0_u32;
    let mut pieces = line.windows(2);
    let (mut piece, mut passed) = (pieces.next(), 0.0);
    while f64::from(steps) * STEP_S < duration {
        steps += 1;
        let t = f64::from(steps) * STEP_S / duration;
        let t = if t < 1.0 { t } else { 1.0 };
        // at rest at both ends, at speed between: smooth over the first and last 0.15 s
        let ease = 0.15 / duration;
        let share = eased(t, ease);
        let target = share * length;
        while let Some(pair) = piece {
            if passed + way(pair) >= target {
                break;
            }
            passed += way(pair);
            piece = pieces.next();
        }
        let at = match piece {
            Some([a, b]) => {
                let within = (target - passed) / way(&[*a, *b]);
                let of = |k: usize| a[k] + (b[k] - a[k]) * within;
                [of(0), of(1), of(2)]
            }
            _ => line.last().copied().unwrap_or_default(),
        };
        out.push((at, cutting));
    }
}

/// From 0 to 1, with the rate growing evenly during the first part `e` of the time and falling during the last.
fn eased(t: f64, e: f64) -> f64 {
    let e = if e < 0.5 { e } else { 0.5 };
    let rate = 1.0 / (1.0 - e);
    if t < e {
        0.5 * rate * t * t / e
    } else if t > 1.0 - e {
        1.0 - 0.5 * rate * (1.0 - t) * (1.0 - t) / e
    } else {
        rate * (t - 0.5 * e)
    }
}

/// Where the machine is, m, and how far from the programmed path while it cuts.
fn follow(demand: &[([f64; 3], bool)]) -> (Vec<[f64; 3]>, Vec<PathError>) {
    let first = demand.first().map_or([0.0; 3], |(p, _)| *p);
    let (mut at, mut speed) = (first, [0.0; 3]);
    let (mut actual, mut errors) = (Vec::new(), Vec::new());
    for (number, (target, cutting)) in demand.iter().enumerate() {
        for k in 0..3 {
            let pull = NATURAL * NATURAL * (target[k] - at[k]) - 2.0 * DAMPING * NATURAL * speed[k];
            speed[k] += STEP_S * pull;
            at[k] += STEP_S * speed[k];
        }
        actual.push(at.map(|v| v * MM));
        let late = demand
            .get(number.saturating_sub(LATE)..=number)
            .unwrap_or_default();
        let error_m = if *cutting {
            late.windows(2)
                .map(|pair| beside(at, pair) * MM)
                .fold(f64::INFINITY, |a, b| if b < a { b } else { a })
        } else {
            f64::NAN
        };
        errors.push(PathError {
            at_m: [at[0] * MM, at[1] * MM],
            error_m,
        });
    }
    (actual, errors)
}

/// The distance over the board of a point from a piece of the path, mm.
fn beside(p: [f64; 3], pair: &[([f64; 3], bool)]) -> f64 {
    let [(a, _), (b, _)] = pair else {
        return f64::INFINITY;
    };
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let square = dx * dx + dy * dy;
    let along = (p[0] - a[0]) * dx + (p[1] - a[1]) * dy;
    let share = if square > 0.0 {
        (along / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    libm::hypot(p[0] - a[0] - share * dx, p[1] - a[1] - share * dy)
}

/// A tool that stands on the board with its tip at a point.
fn upright(tip_m: [f64; 3]) -> Pose {
    let mut pose = Pose::identity();
    [pose.position.x, pose.position.y, pose.position.z] = tip_m;
    pose.rotation.m22 = -1.0;
    pose.rotation.m33 = -1.0;
    pose
}
