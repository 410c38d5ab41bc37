//! DXF drawings (ASCII): the outlines among the entities of the model.
//!
//! `LINE`, `LWPOLYLINE` and `POLYLINE` with bulges, `ARC`, `CIRCLE`, `ELLIPSE`, `SPLINE`; an entity that begins where
//! the one before ends goes on with its outline. Everything lies in the plane z = 0. Our own reader: an
//! entity here is a dozen pairs of lines, and crate `dxf` 0.6 keeps no line to tell where a mistake is.

use super::nurbs::{Nurbs, ellipse};
use super::outline::{Outline, bulged};
use super::step::{Shape, distance};
use crate::input::{DataError, Problem, shown};
use core::f64::consts::PI;
use std::sync::Arc;

/// Ends this near to each other are one, m.
const SAME_M: f64 = 1e-6;
/// The greatest coordinate, m.
const LARGEST_M: f64 = 1e4;

/// A group: its code, and what it says.
#[derive(Clone, Copy, Debug)]
struct Group<'a> {
    code: i32,
    value: &'a str,
    /// Of the value.
    line: u32,
}

impl Group<'_> {
    fn error(&self, problem: Problem, what: &str, expected: &str) -> DataError {
        DataError::at((self.line, 1), problem, what, expected, shown(self.value))
    }

    fn number(&self) -> Result<f64, DataError> {
        match self.value.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            _ => Err(self.error(Problem::WrongType, "a value", "a finite number")),
        }
    }
}

/// Groups, up to the first mistake.
fn groups(text: &str) -> impl Iterator<Item = Result<Group<'_>, DataError>> {
    let mut lines = (1_u32..).zip(text.lines());
    core::iter::from_fn(move || {
        let (line, code) = lines.next()?;
        let Ok(code) = code.trim().parse::<i32>() else {
            if code.trim().is_empty() && lines.clone().all(|(_, rest)| rest.trim().is_empty()) {
                return None;
            }
            let expected = "the code of a group";
            let error = DataError::at(
                (line, 1),
                Problem::Syntax,
                "a DXF drawing",
                expected,
                shown(code),
            );
            return Some(Err(error));
        };
        let Some((line, value)) = lines.next() else {
            let got = "the end of the file";
            let error = DataError::at((line, 1), Problem::Missing, "a group", "its value", got);
            return Some(Err(error));
        };
        let value = value.trim();
        Some(Ok(Group { code, value, line }))
    })
}

/// Reads the outlines of a drawing; `unit_m` metres are a unit if the drawing does not say.
///
/// # Errors
/// The first mistake, or an entity that is no outline.
pub fn read(text: &str, unit_m: f64) -> Result<Vec<Outline>, DataError> {
    let mut reader = Reader {
        unit_m,
        outlines: Vec::new(),
        polyline: None,
    };
    let (mut section, mut variable) = ("", "");
    let mut entity: Option<Entity<'_>> = None;
    let mut named = false;
    for group in groups(text) {
        let group = group?;
        if group.code == 0 {
            if let Some(entity) = entity.take() {
                reader.take(&entity)?;
            }
            match group.value {
                "SECTION" => named = true,
                "ENDSEC" => section = "",
                "EOF" => return reader.end(),
                _ if section == "ENTITIES" => {
                    entity = Some(Entity {
                        kind: group,
                        groups: Vec::new(),
                    });
                }
                _ => {}
            }
        } else if named && group.code == 2 {
            (section, named) = (group.value, false);
        } else if section == "HEADER" && group.code == 9 {
            variable = group.value;
        } else if section == "HEADER" && variable == "$INSUNITS" && group.code == 70 {
            reader.unit(&group)?;
        } else if let Some(entity) = &mut entity {
            entity.groups.push(group);
        }
    }
    let lines = u32::try_from(text.lines().count()).unwrap_or(u32::MAX);
    let got = "the end of the file";
    Err(DataError::at(
        (lines.max(1), 1),
        Problem::Missing,
        "a DXF drawing",
        "`EOF` at its end",
        got,
    ))
}

/// An entity and its groups.
struct Entity<'a> {
    kind: Group<'a>,
    groups: Vec<Group<'a>>,
}

impl Entity<'_> {
    /// All values of a code.
    fn all(&self, code: i32) -> Result<Vec<f64>, DataError> {
        let of_code = self.groups.iter().filter(|group| group.code == code);
        of_code.map(Group::number).collect()
    }

    fn get(&self, code: i32) -> Result<Option<f64>, DataError> {
        let group = self.groups.iter().find(|group| group.code == code);
        group.map(Group::number).transpose()
    }

    fn need(&self, code: i32) -> Result<f64, DataError> {
        let expected = format!("a group {code}");
        self.get(code)?.ok_or_else(|| {
            self.kind
                .error(Problem::Missing, "an entity that lacks a value", &expected)
        })
    }

    fn flag(&self, bit: u32) -> Result<bool, DataError> {
        let flags = self.get(70)?.unwrap_or_default();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "flags; the conversion saturates"
        )]
        let flags = flags as u32;
        Ok(flags & bit != 0)
    }

    /// In the plane z = 0, seen from above.
    fn is_flat(&self) -> Result<(), DataError> {
        for group in &self.groups {
            let wanted = match group.code {
                30..=33 | 38 | 39 | 210 | 220 => 0.0,
                230 => 1.0,
                _ => continue,
            };
            if (group.number()? - wanted).abs() > 1e-9 {
                let expected = "z = 0, no thickness, and 0, 0, 1 as its normal";
                return Err(group.error(
                    Problem::OutOfRange,
                    "an entity out of the plane",
                    expected,
                ));
            }
        }
        Ok(())
    }
}

/// A point of a polyline, m, and its bulge.
type Bulged = ([f64; 3], f64);

struct Reader {
    unit_m: f64,
    outlines: Vec<Outline>,
    /// A `POLYLINE` whose `SEQEND` has not come: its line, whether it is closed, its points.
    polyline: Option<(u32, bool, Vec<Bulged>)>,
}

impl Reader {
    fn end(self) -> Result<Vec<Outline>, DataError> {
        match self.polyline {
            None => Ok(self.outlines),
            Some((line, ..)) => {
                let (what, got) = ("`POLYLINE`", "the end of the file");
                Err(DataError::at(
                    (line, 1),
                    Problem::Missing,
                    what,
                    "`SEQEND`",
                    got,
                ))
            }
        }
    }

    fn unit(&mut self, group: &Group<'_>) -> Result<(), DataError> {
        self.unit_m = match group.value {
            "0" => return Ok(()),
            "1" => 0.0254,
            "2" => 0.3048,
            "4" => 1e-3,
            "5" => 1e-2,
            "6" => 1.0,
            "8" => 0.0254e-6,
            "9" => 0.0254e-3,
            "10" => 0.9144,
            "13" => 1e-6,
            "14" => 0.1,
            _ => {
                let expected = "inches (1), feet (2), mm (4), cm (5), m (6)";
                return Err(group.error(Problem::UnknownName, "`$INSUNITS`", expected));
            }
        };
        Ok(())
    }

    fn point(&self, kind: &Group<'_>, x: f64, y: f64) -> Result<[f64; 3], DataError> {
        let point = [x * self.unit_m, y * self.unit_m, 0.0];
        if point.iter().all(|x| x.abs() <= LARGEST_M) {
            Ok(point)
        } else {
            Err(kind.error(
                Problem::OutOfRange,
                "an entity that is too far away",
                "within 10 km",
            ))
        }
    }

    /// Points of two codes, those of x and of y.
    fn points(&self, entity: &Entity<'_>, x: i32) -> Result<Vec<[f64; 3]>, DataError> {
        let (xs, ys) = (entity.all(x)?, entity.all(x + 10)?);
        if xs.len() != ys.len() {
            let expected = "as many x as y";
            return Err(entity
                .kind
                .error(Problem::WrongCount, "points of an entity", expected));
        }
        let points = xs.into_iter().zip(ys);
        points
            .map(|(x, y)| self.point(&entity.kind, x, y))
            .collect()
    }

    fn first(&self, entity: &Entity<'_>, x: i32) -> Result<[f64; 3], DataError> {
        self.point(&entity.kind, entity.need(x)?, entity.need(x + 10)?)
    }

    fn take(&mut self, entity: &Entity<'_>) -> Result<(), DataError> {
        let line = entity.kind.line;
        if !matches!(entity.kind.value, "VERTEX" | "SEQEND") && self.polyline.is_some() {
            return Err(entity
                .kind
                .error(Problem::Conflict, "`POLYLINE`", "`VERTEX` or `SEQEND`"));
        }
        if entity.kind.value != "POINT" {
            entity.is_flat()?;
        }
        match entity.kind.value {
            // nothing to follow
            "POINT" => {}
            "LINE" => {
                let (mut from, mut to) = (self.first(entity, 10)?, self.first(entity, 11)?);
                let end = self.outlines.last().map(Outline::end);
                if end.is_some_and(|end| {
                    distance(&end, &to) <= SAME_M && distance(&end, &from) > SAME_M
                }) {
                    core::mem::swap(&mut from, &mut to);
                }
                let mut outline = Outline::new(line, from);
                outline.line_to(to);
                self.add(outline);
            }
            "LWPOLYLINE" => {
                let closed = entity.flag(1)?;
                let points = self.bulges(entity)?;
                self.polygon(line, closed, &points);
            }
            "POLYLINE" => {
                if entity.flag(0x78)? {
                    let expected = "a line in the plane, not a mesh or a line in space";
                    return Err(entity
                        .kind
                        .error(Problem::UnknownName, "`POLYLINE`", expected));
                }
                self.polyline = Some((line, entity.flag(1)?, Vec::new()));
            }
            "VERTEX" => {
                let point = self.first(entity, 10)?;
                let bulge = entity.get(42)?.unwrap_or_default();
                // points of the frame of a spline are not on it
                let frame = entity.flag(16)?;
                let Some((.., points)) = &mut self.polyline else {
                    return Err(entity.kind.error(
                        Problem::Conflict,
                        "`VERTEX`",
                        "`POLYLINE` before it",
                    ));
                };
                if !frame {
                    points.push((point, bulge));
                }
            }
            "SEQEND" => {
                if let Some((line, closed, points)) = self.polyline.take() {
                    self.polygon(line, closed, &points);
                }
            }
            "CIRCLE" | "ARC" => self.arc(entity)?,
            "ELLIPSE" => self.ellipse(entity)?,
            "SPLINE" => self.spline(entity)?,
            _ => {
                let expected = "LINE, LWPOLYLINE, POLYLINE, ARC, CIRCLE, ELLIPSE, SPLINE: explode blocks and text";
                return Err(entity.kind.error(
                    Problem::UnknownName,
                    "an entity that is no outline",
                    expected,
                ));
            }
        }
        Ok(())
    }

    /// The points of an `LWPOLYLINE`: a bulge belongs to the point before it.
    fn bulges(&self, entity: &Entity<'_>) -> Result<Vec<Bulged>, DataError> {
        let mut points: Vec<Bulged> = self
            .points(entity, 10)?
            .into_iter()
            .map(|at| (at, 0.0))
            .collect();
        let mut count = 0_usize;
        for group in &entity.groups {
            match group.code {
                10 => count += 1,
                42 => {
                    if let Some((_, bulge)) = count.checked_sub(1).and_then(|k| points.get_mut(k)) {
                        *bulge = group.number()?;
                    }
                }
                _ => {}
            }
        }
        Ok(points)
    }

    fn polygon(&mut self, line: u32, closed: bool, points: &[Bulged]) {
        let Some((first, _)) = points.first() else {
            return;
        };
        let mut outline = Outline::new(line, *first);
        let ends = points
            .iter()
            .skip(1)
            .chain(points.first().filter(|_| closed));
        for ((from, bulge), (to, _)) in points.iter().zip(ends) {
            if distance(from, to) > 0.0 {
                outline.parts.push((*to, bulged(from, to, *bulge)));
            }
        }
        self.add(outline);
    }

    /// An outline, or more of the one before.
    fn add(&mut self, outline: Outline) {
        if outline.parts.is_empty() {
            return;
        }
        match self.outlines.last_mut() {
            Some(last) if distance(&last.end(), &outline.from_m) <= SAME_M => {
                last.parts.extend(outline.parts);
            }
            _ => self.outlines.push(outline),
        }
    }

    fn radius(&self, entity: &Entity<'_>) -> Result<f64, DataError> {
        let radius = entity.need(40)? * self.unit_m;
        if radius > 0.0 && radius <= LARGEST_M {
            Ok(radius)
        } else {
            Err(entity.kind.error(
                Problem::OutOfRange,
                "a radius",
                "greater than 0, at most 10 km",
            ))
        }
    }

    fn arc(&mut self, entity: &Entity<'_>) -> Result<(), DataError> {
        let centre_m = self.first(entity, 10)?;
        let radius = self.radius(entity)?;
        let (from, angle) = if entity.kind.value == "CIRCLE" {
            (0.0, 2.0 * PI)
        } else {
            let (from, to) = (entity.need(50)?, entity.need(51)?);
            let degrees = counterclockwise(to - from, 360.0);
            (from * PI / 180.0, degrees * PI / 180.0)
        };
        let [x, y, _] = centre_m;
        let at = |angle| {
            [
                x + radius * libm::cos(angle),
                y + radius * libm::sin(angle),
                0.0,
            ]
        };
        let mut outline = Outline::new(entity.kind.line, at(from));
        let shape = Shape::Arc {
            centre_m,
            plane: [0, 1, 2],
            angle_rad: angle,
        };
        let to = if angle >= 2.0 * PI {
            at(from)
        } else {
            at(from + angle)
        };
        outline.parts.push((to, shape));
        self.add(outline);
        Ok(())
    }

    fn ellipse(&mut self, entity: &Entity<'_>) -> Result<(), DataError> {
        let centre = self.first(entity, 10)?;
        let [x, y, _] = self.first(entity, 11)?;
        let ratio = entity.need(40)?;
        if !(ratio > 0.0 && ratio <= 1e6) || libm::hypot(x, y) <= 0.0 {
            return Err(entity.kind.error(
                Problem::OutOfRange,
                "an ellipse",
                "axes that are longer than 0",
            ));
        }
        let from = entity.get(41)?.unwrap_or_default();
        let to = entity.get(42)?.unwrap_or(2.0 * PI);
        let angle = counterclockwise(to - from, 2.0 * PI);
        let curves = ellipse(
            &centre,
            &[x, y, 0.0],
            &[-y * ratio, x * ratio, 0.0],
            from,
            angle,
        );
        let curves = curves.map_err(|error| {
            entity
                .kind
                .error(Problem::NotFinite, "an ellipse", &error.to_string())
        })?;
        let Some(first) = curves.first() else {
            return Ok(());
        };
        let mut outline = Outline::new(entity.kind.line, first.at(0.0));
        for curve in curves {
            outline.curve(curve);
        }
        self.add(outline);
        Ok(())
    }

    fn spline(&mut self, entity: &Entity<'_>) -> Result<(), DataError> {
        let wrong =
            |expected: &str| Err(entity.kind.error(Problem::WrongCount, "a spline", expected));
        let degree = entity.need(71)?;
        if !(1.0..=11.0).contains(&degree) {
            return wrong("a degree from 1 to 11");
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "from 1 to 11"
        )]
        let order = degree as usize + 1;
        let control = self.points(entity, 10)?;
        if control.is_empty() {
            return wrong("control points, not only points that it goes through");
        }
        let mut weights = entity.all(41)?;
        if weights.is_empty() {
            weights = vec![1.0; control.len()];
        } else if weights.len() != control.len() {
            return wrong("as many weights as control points, or none");
        }
        let curve = Nurbs::new(order, control.into_iter().zip(weights), entity.all(40)?);
        let curve = curve.map_err(|error| {
            entity
                .kind
                .error(Problem::OutOfRange, "a spline", &error.to_string())
        })?;
        let mut outline = Outline::new(entity.kind.line, curve.at(0.0));
        outline
            .parts
            .push((curve.at(1.0), Shape::Nurbs(Arc::new(curve))));
        self.add(outline);
        Ok(())
    }
}

/// An angle from above 0 to a whole turn.
fn counterclockwise(angle: f64, turn: f64) -> f64 {
    let rest = angle - turn * libm::floor(angle / turn);
    if rest <= 1e-9 * turn { turn } else { rest }
}
