//! Real tool paths: the machining files under `../shared/data/gcode`, or where `MRROC_GCODE_SAMPLES` says.
//! Without them there is nothing to test.

use crate::moving_segment::spans;
use crate::support::{at, jumps, straight};
use motion::path::{Arc, Curve, Join, Path, Piece, QueueError, Tolerance};
use nalgebra::Vector3;
use std::path::{Path as FilePath, PathBuf};

/// One motion with its end, m.
#[derive(Clone, Copy, Debug)]
struct Block {
    /// 0, 1, 2, 3, or 5.2 for a line of control points.
    motion: f64,
    to: Vector3<f64>,
    /// The radius of an arc, m.
    radius: Option<f64>,
}

fn sample(name: &str) -> Option<Vec<Block>> {
    let workspace = FilePath::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let folder = std::env::var_os("MRROC_GCODE_SAMPLES")
        .map_or_else(|| workspace.join("../shared/data/gcode"), PathBuf::from);
    let file = folder.join(name);
    let text = std::fs::read_to_string(&file).ok();
    if text.is_none() {
        println!("skipped: no {}", file.display());
    }
    text.map(|text| blocks(&text))
}

/// Words of a letter and a number; modal motions and coordinates; absolute positions only.
fn blocks(text: &str) -> Vec<Block> {
    let (mut motion, mut unit, mut here) = (0.0, 1e-3, Vector3::zeros());
    let mut blocks = Vec::new();
    for line in text.lines() {
        let line = line
            .split([';', '('])
            .next()
            .unwrap()
            .to_lowercase()
            .replace(char::is_whitespace, "");
        if line.starts_with(['o', '#', '%']) {
            continue;
        }
        let starts: Vec<usize> = line
            .char_indices()
            .filter(|(_, c)| c.is_ascii_alphabetic())
            .map(|(i, _)| i)
            .collect();
        let (mut radius, mut moved) = (None, false);
        for (k, start) in starts.iter().enumerate() {
            let end = starts.get(k + 1).copied().unwrap_or(line.len());
            let Ok(value) = line[start + 1..end].parse::<f64>() else {
                continue;
            };
            match (&line[*start..=*start], value) {
                ("g", 20.0) => unit = 0.0254,
                ("g", 21.0) => unit = 1e-3,
                ("g", 0.0 | 1.0 | 2.0 | 3.0 | 5.2) => motion = value,
                ("r", _) => radius = Some(value * unit),
                ("x" | "y" | "z", _) => {
                    here["xyz".find(&line[*start..=*start]).unwrap()] = value * unit;
                    moved = true;
                }
                _ => {}
            }
        }
        if moved {
            blocks.push(Block {
                motion,
                to: here,
                radius,
            });
        }
    }
    blocks
}

/// An arc in the plane x, y by its radius, the shorter way.
fn arc(from: Vector3<f64>, block: &Block) -> Option<Arc> {
    let way = block.to - from;
    let (chord, radius) = (way.xy().norm(), block.radius?);
    let height = (radius * radius - chord * chord / 4.0).max(0.0).sqrt();
    // G3: the centre is to the left of the chord; G2: to the right, and the arc runs about −z
    let side = if block.motion == 3.0 { 1.0 } else { -1.0 };
    let left = Vector3::new(-way.y, way.x, 0.0) / chord;
    let centre = from + way / 2.0 + left * (side * height);
    let pose = |p: Vector3<f64>| at(p.x, p.y, p.z);
    Some(
        Arc::to(
            pose(from),
            pose(block.to),
            centre,
            Vector3::z() * side,
            0,
            1e-9,
        )
        .unwrap(),
    )
}

fn report(name: &str, points: &[Vector3<f64>]) -> [f64; 3] {
    let spans = spans(points.iter().map(|p| at(p.x, p.y, p.z)));
    let (mut least, mut most, mut bent) = (f64::INFINITY, 0.0_f64, 0.0_f64);
    for span in &spans {
        for i in 0..=20 {
            let x = span.at(span.length() * f64::from(i) / 20.0);
            least = least.min(x.first.linear_norm());
            most = most.max(x.first.linear_norm());
            bent = bent.max(x.curvature());
        }
    }
    let mut jump = [0.0_f64; 6];
    for pair in spans.windows(2) {
        let at_join = jumps(&pair[0].at(pair[0].length()), &pair[1].at(0.0));
        for (jump, here) in jump.iter_mut().zip(at_join) {
            *jump = jump.max(here);
        }
    }
    println!(
        "{name}: {} points, |p'| {least:.3} to {most:.3}, curvature to {bent:.0}/m, jumps p' {:.1e} p'' {:.1e}/m p''' {:.1e}/m²",
        points.len(),
        jump[0],
        jump[2],
        jump[4]
    );
    assert!(jump[0] < 1e-9 && jump[2] < 1e-6, "{jump:?}");
    [least, most, bent]
}

#[test]
fn the_outline_of_a_butterfly_is_a_smooth_curve() {
    let Some(blocks) = sample("butterfly-xy.ngc") else {
        return;
    };
    let mut outlines: Vec<Vec<Vector3<f64>>> = Vec::new();
    let mut before = Vector3::zeros();
    for block in &blocks {
        if block.motion == 5.2 {
            if outlines.is_empty() || *outlines.last().unwrap().last().unwrap() != before {
                outlines.push(vec![before]);
            }
            outlines.last_mut().unwrap().push(block.to);
        }
        before = block.to;
    }
    assert!(outlines.len() > 3 && outlines.iter().map(Vec::len).max() > Some(10));
    for points in &outlines {
        let [least, most, _] = report("butterfly", points);
        // a drawing with corners of 90° and chords 1:5; measured 0.59 to 1.47
        if points.len() > 4 {
            assert!(least > 0.3 && most < 2.5, "{least} {most}");
        }
    }
}

#[test]
fn the_ends_of_a_spirals_arcs_give_back_the_arcs() {
    let Some(blocks) = sample("arcspiral.ngc") else {
        return;
    };
    let (mut arcs, mut before) = (Vec::new(), Vector3::zeros());
    for block in &blocks {
        if block.motion == 2.0 {
            arcs.extend(arc(before, block));
        }
        before = block.to;
    }
    let mut points = vec![arcs[0].at(0.0).pose.position];
    points.extend(arcs.iter().map(|arc| arc.at(arc.length()).pose.position));
    assert!(points.len() > 500);
    let [least, most, _] = report("arcspiral", &points);
    // the points are 0.1 rad apart and more towards the middle: measured 1.003
    assert!(least > 0.999 && most < 1.01);
    let spans = spans(points.iter().map(|p| at(p.x, p.y, p.z)));
    // away from the middle: the curve through the ends of the arcs against the arcs
    let mut off = 0.0_f64;
    for (span, arc) in spans.iter().zip(&arcs).take(arcs.len() / 2).skip(3) {
        for i in 0..=10 {
            let u = f64::from(i) / 10.0;
            let way =
                span.at(u * span.length()).pose.position - arc.at(u * arc.length()).pose.position;
            off = off.max(way.norm());
        }
    }
    println!(
        "arcspiral: greatest distance of the curve from the arcs, outer half: {:.3} µm",
        off * 1e6
    );
    // R·θ⁴/500 of 50 mm and 0.1 rad is 0.01 µm; the arcs' radii are rounded to 0.03 µm
    assert!(off < 1e-7);
}

#[test]
fn lines_and_arcs_with_blended_corners_need_no_stop() {
    let Some(blocks) = sample("cds.ngc") else {
        return;
    };
    let tolerance = Tolerance {
        metres: 1e-4,
        radians: 1e-2,
    };
    let mut path = Path::<512>::new();
    let (mut before, mut pieces, mut corners) = (Vector3::zeros(), 0, 0);
    for block in &blocks {
        let (from, to) = (before, block.to);
        before = to;
        if (to - from).norm() < 1e-6 {
            continue;
        }
        let line = || straight(at(from.x, from.y, from.z), at(to.x, to.y, to.z)).into();
        let piece: Piece = arc(from, block).map_or_else(line, Into::into);
        pieces += 1;
        match path.push_blended(piece, &tolerance) {
            Ok(join) => assert!(join == Join::Smooth || pieces == 1, "{block:?}"),
            Err(QueueError::Corner(error)) => {
                println!("{block:?}: {error}");
                corners += 1;
                assert_eq!(path.push(piece), Ok(Join::Stop));
            }
            Err(error) => panic!("{error}"),
        }
    }
    println!(
        "cds: {pieces} pieces, {} with blends, {corners} corners left, {:.3} m",
        path.len(),
        path.end()
    );
    assert!(pieces > 100 && corners == 0);
    assert_eq!(path.stop_after(0.0), None);
}
