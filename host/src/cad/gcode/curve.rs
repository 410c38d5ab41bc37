//! G2, G3 and the splines: shapes from the words of a line.

use super::block::Block;
use super::cursor::Cursor;
use super::expression::whole;
use super::machine::{out_of_range, same};
use crate::cad::nurbs::Nurbs;
use crate::cad::step::{Keeping, Move, Shape, Speed, get, set};
use crate::input::{DataError, Problem};
use core::f64::consts::PI;
use std::sync::Arc;

/// Radii at both ends of an arc may differ by this, m, and this share of them, but for 5 µm: what
/// `LinuxCNC` admits.
const RADII_APART: (f64, f64, f64) = (0.5e-3, 1e-3, 5e-6);

/// What an arc depends on.
pub(super) struct Modes {
    pub(super) unit_m: f64,
    pub(super) plane: [usize; 3],
    pub(super) absolute: bool,
}

/// An arc in the plane, or a helix about the axis across.
pub(super) fn arc(
    block: &mut Block<'_>,
    modes: &Modes,
    clockwise: bool,
    from: &[f64; 3],
    to: &[f64; 3],
    place: &Cursor<'_>,
) -> Result<Shape, DataError> {
    let [a, b, n] = modes.plane;
    let turns = match block.value(b'p') {
        None => 1.0,
        Some((turns, cursor)) => match whole(turns) {
            Some(turns) if (1..=10_000).contains(&turns) => f64::from(turns),
            _ => return Err(out_of_range(&cursor, "turns", "1 to 10000", turns)),
        },
    };
    let plane = |point: &[f64; 3]| [get(point, a), get(point, b)];
    let (start, end) = (plane(from), plane(to));
    let middle = if let Some((radius, cursor)) = block.value(b'r') {
        for letter in *b"ijk" {
            if let Some((_, cursor)) = block.value(letter) {
                return Err(cursor.wrong("an arc", "a centre or a radius, not both"));
            }
        }
        by_radius(start, end, radius * modes.unit_m, clockwise, &cursor)?
    } else {
        by_centre(block, modes, start, place)?
    };
    let arm = |point: [f64; 2]| [point[0] - middle[0], point[1] - middle[1]];
    let (first, last) = (arm(start), arm(end));
    let (r, other) = (
        libm::hypot(first[0], first[1]),
        libm::hypot(last[0], last[1]),
    );
    let apart = (r - other).abs();
    let (most, share, free) = RADII_APART;
    if apart > most || (apart > free && apart > share * r) {
        return Err(place.error(
            Problem::Conflict,
            "an arc that does not end on its circle",
            format!("an end {r:.6} m from the centre"),
            format!("{other:.6} m"),
        ));
    }
    if r < 1e-7 {
        return Err(place.wrong("an arc without a radius", "a centre away from its ends"));
    }
    // the centre of the circle through both ends that is nearest to the one said
    let chord = [end[0] - start[0], end[1] - start[1]];
    let across = chord[0] * chord[0] + chord[1] * chord[1];
    let full = across <= 1e-14;
    let middle = if full {
        middle
    } else {
        let half = [0.5 * (start[0] + end[0]), 0.5 * (start[1] + end[1])];
        let off = [middle[0] - half[0], middle[1] - half[1]];
        let along = (off[0] * chord[0] + off[1] * chord[1]) / across;
        [middle[0] - along * chord[0], middle[1] - along * chord[1]]
    };
    let angle_at = |point: [f64; 2]| libm::atan2(point[1] - middle[1], point[0] - middle[0]);
    let mut angle = if full {
        0.0
    } else {
        angle_at(end) - angle_at(start)
    };
    if clockwise {
        angle = -angle;
    }
    while angle <= 0.0 {
        angle += 2.0 * PI;
    }
    while angle > 2.0 * PI {
        angle -= 2.0 * PI;
    }
    angle += 2.0 * PI * (turns - 1.0);
    let mut centre_m = *from;
    set(&mut centre_m, a, middle[0]);
    set(&mut centre_m, b, middle[1]);
    Ok(Shape::Arc {
        centre_m,
        plane: [a, b, n],
        angle_rad: if clockwise { -angle } else { angle },
    })
}

/// The centre by I, J, K.
fn by_centre(
    block: &mut Block<'_>,
    modes: &Modes,
    start: [f64; 2],
    place: &Cursor<'_>,
) -> Result<[f64; 2], DataError> {
    let [a, b, n] = modes.plane;
    let letter = |axis: usize| b"ijk".get(axis).copied().unwrap_or(b'i');
    if let Some((_, cursor)) = block.value(letter(n)) {
        return Err(cursor.wrong("the centre of an arc", "one in the plane of the arc"));
    }
    let offsets = [block.value(letter(a)), block.value(letter(b))];
    let given = offsets.iter().flatten().count();
    if given == 0 || (modes.absolute && given < 2) {
        let expected = if modes.absolute {
            "both words of the centre, as G90.1 wants them"
        } else {
            "R, or I, J, K of the plane"
        };
        return Err(place.wrong("an arc", expected));
    }
    let mut middle = if modes.absolute { [0.0; 2] } else { start };
    for (axis, offset) in middle.iter_mut().zip(offsets) {
        *axis += offset.map_or(0.0, |(value, _)| value * modes.unit_m);
    }
    if middle.iter().any(|x| x.abs() > 1e4) {
        return Err(place.wrong("the centre of an arc", "one within 10 km"));
    }
    Ok(middle)
}

/// The centre of an arc of a radius; of one that is negative, of the longer arc.
fn by_radius(
    start: [f64; 2],
    end: [f64; 2],
    radius: f64,
    clockwise: bool,
    cursor: &Cursor<'_>,
) -> Result<[f64; 2], DataError> {
    let chord = [end[0] - start[0], end[1] - start[1]];
    let length = libm::hypot(chord[0], chord[1]);
    if length < 1e-7 {
        return Err(cursor.wrong(
            "an arc to where it begins",
            "I, J, K: a radius does not say which",
        ));
    }
    let r = radius.abs();
    let over = 0.5 * length - r;
    let (_, share, free) = RADII_APART;
    if !(over <= free || over <= share * r) || r > 1e4 {
        return Err(cursor.error(
            Problem::OutOfRange,
            "the radius of an arc",
            format!(
                "at least half the distance of its ends, {:.6} m",
                0.5 * length
            ),
            format!("{r:.6} m"),
        ));
    }
    let square = r * r - 0.25 * length * length;
    let height = if square > 0.0 {
        libm::sqrt(square)
    } else {
        0.0
    };
    // to the left of the chord, where the shorter arc goes counterclockwise
    let side = if clockwise == (radius > 0.0) {
        -height
    } else {
        height
    };
    Ok([
        0.5 * (start[0] + end[0]) - side * chord[1] / length,
        0.5 * (start[1] + end[1]) + side * chord[0] / length,
    ])
}

/// Two words that are offsets in the plane XY, m.
fn offsets(
    block: &mut Block<'_>,
    letters: [u8; 2],
    unit_m: f64,
    place: &Cursor<'_>,
) -> Result<Option<[f64; 2]>, DataError> {
    match letters.map(|letter| block.value(letter)) {
        [Some((x, _)), Some((y, _))] => Ok(Some([x * unit_m, y * unit_m])),
        [None, None] => Ok(None),
        _ => Err(place.wrong("a spline", "both of I and J, both of P and Q")),
    }
}

fn flat(from: &[f64; 3], to: &[f64; 3], place: &Cursor<'_>) -> Result<(), DataError> {
    if (get(from, 2) - get(to, 2)).abs() <= 0.0 {
        Ok(())
    } else {
        Err(place.wrong("a spline that leaves its plane", "no Z"))
    }
}

fn beside(point: &[f64; 3], [x, y]: [f64; 2]) -> [f64; 3] {
    [get(point, 0) + x, get(point, 1) + y, get(point, 2)]
}

/// G5: I, J from the start to the first control point, P, Q from the end to the second. Without I and J
/// it goes on smoothly from a cubic before it. The second: that control point, mirrored at the end.
pub(super) fn cubic(
    block: &mut Block<'_>,
    unit_m: f64,
    smooth: Option<[f64; 3]>,
    from: &[f64; 3],
    to: &[f64; 3],
    place: &Cursor<'_>,
) -> Result<(Shape, [f64; 3]), DataError> {
    flat(from, to, place)?;
    let first = match (offsets(block, *b"ij", unit_m, place)?, smooth) {
        (Some(offset), _) => beside(from, offset),
        (None, Some(point)) => point,
        (None, None) => return Err(place.wrong("the first of cubic splines", "I and J")),
    };
    let Some(offset) = offsets(block, *b"pq", unit_m, place)? else {
        return Err(place.wrong("a cubic spline", "P and Q"));
    };
    let shape = Nurbs::bezier([*from, first, beside(to, offset), *to]);
    let shape = shape.map_err(|error| place.wrong("a spline", &error.to_string()))?;
    let mirrored = beside(to, offset.map(|x| -x));
    Ok((Shape::Nurbs(Arc::new(shape)), mirrored))
}

/// G5.1: I, J from the start to the control point.
pub(super) fn quadratic(
    block: &mut Block<'_>,
    unit_m: f64,
    from: &[f64; 3],
    to: &[f64; 3],
    place: &Cursor<'_>,
) -> Result<Shape, DataError> {
    flat(from, to, place)?;
    let Some(offset) = offsets(block, *b"ij", unit_m, place)? else {
        return Err(place.wrong("a quadratic spline", "I and J"));
    };
    let control = [*from, beside(from, offset), *to].map(|point| (point, 1.0));
    let shape = Nurbs::clamped(3, control);
    let shape = shape.map_err(|error| place.wrong("a spline", &error.to_string()))?;
    Ok(Shape::Nurbs(Arc::new(shape)))
}

/// G5.2 to G5.3, with the knots of `LinuxCNC`; its speed is the caller's.
pub(super) fn nurbs(
    order: usize,
    control: Vec<([f64; 3], f64)>,
    place: &Cursor<'_>,
) -> Result<Move, DataError> {
    let ends = control.first().zip(control.last());
    let Some(((from_m, _), (to_m, _))) = ends.map(|(a, b)| (*a, *b)) else {
        return Err(place.wrong("a spline", "control points"));
    };
    if control.iter().all(|(point, _)| same(point, &from_m)) {
        return Err(place.wrong("a spline", "control points that differ"));
    }
    let curve = Nurbs::clamped(order, control);
    let curve = curve.map_err(|error| place.wrong("a spline", &error.to_string()))?;
    Ok(Move {
        from_m,
        to_m,
        shape: Shape::Nurbs(Arc::new(curve)),
        speed: Speed::Rapid,
        keeping: Keeping::Task,
    })
}
