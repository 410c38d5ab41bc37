//! SVG drawings: every shape and path is an outline, whatever its colours.
//!
//! `roxmltree` reads the XML, `svgtypes` numbers, lengths, transforms and path data: both keep positions and 64
//! bits, where `usvg` has neither lines of the file nor more than 32 bits. Lengths without a unit are
//! 1/96 inch; y points upwards here. Text, images and references are refused: they have to be converted to paths.

mod pen;

use super::nurbs::{NurbsError, ellipse};
use super::outline::Outline;
use crate::input::{DataError, Problem, shown};
use core::f64::consts::{FRAC_PI_2, PI};
use pen::Pen;
use roxmltree::{Document, Node, ParsingOptions};
use svgtypes::{Length, LengthUnit, PathParser, PathSegment, PointsParser, Transform, ViewBox};

/// The most elements, attributes and texts of a file.
const MOST_NODES: u32 = 1_000_000;
/// Groups within groups.
const DEEPEST: u32 = 64;
/// Metres in a length without a unit.
const PIXEL_M: f64 = 0.0254 / 96.0;
/// The largest drawing, m.
const LARGEST_M: f64 = 1e4;

/// x' = a·x + c·y + e, y' = b·x + d·y + f, with the names of SVG.
#[derive(Clone, Copy, Debug)]
struct Affine([f64; 6]);

impl Affine {
    fn point(&self, x: f64, y: f64) -> [f64; 3] {
        let Self([a, b, c, d, e, f]) = self;
        [a * x + c * y + e, b * x + d * y + f, 0.0]
    }

    fn vector(&self, x: f64, y: f64) -> [f64; 3] {
        let Self([a, b, c, d, ..]) = self;
        [a * x + c * y, b * x + d * y, 0.0]
    }

    fn then_inner(&self, inner: &Transform) -> Self {
        let Self([a, b, c, d, ..]) = *self;
        let [e, f, _] = self.point(inner.e, inner.f);
        Self([
            a * inner.a + c * inner.b,
            b * inner.a + d * inner.b,
            a * inner.c + c * inner.d,
            b * inner.c + d * inner.d,
            e,
            f,
        ])
    }
}

/// Reads the outlines of a drawing.
///
/// # Errors
/// The first mistake, or what is not an outline.
pub fn read(text: &str) -> Result<Vec<Outline>, DataError> {
    let options = ParsingOptions {
        allow_dtd: true,
        nodes_limit: MOST_NODES,
        ..ParsingOptions::default()
    };
    let document = Document::parse_with_options(text, options).map_err(|error| {
        let at = (error.pos().row, error.pos().col);
        let what = "not an SVG drawing";
        DataError::at(at, Problem::Syntax, what, "XML", shown(&error.to_string()))
    })?;
    let starts = text.match_indices('\n').map(|(at, _)| at + 1);
    let mut reader = Reader {
        text,
        starts: core::iter::once(0).chain(starts).collect(),
        outlines: Vec::new(),
    };
    let root = document.root_element();
    if root.tag_name().name() != "svg" {
        let got = shown(root.tag_name().name());
        return Err(reader.error(
            root,
            Problem::UnknownName,
            "not an SVG drawing",
            "`svg`",
            got,
        ));
    }
    let to_metres = reader.frame(root)?;
    reader.group(root, &to_metres, 0)?;
    Ok(reader.outlines)
}

struct Reader<'a> {
    text: &'a str,
    /// Where lines begin.
    starts: Vec<usize>,
    outlines: Vec<Outline>,
}

type Element<'a> = Node<'a, 'a>;

impl Reader<'_> {
    fn place(&self, node: Node<'_, '_>) -> (u32, u32) {
        let offset = node.range().start;
        let line = self.starts.partition_point(|start| *start <= offset);
        let start = line.checked_sub(1).and_then(|k| self.starts.get(k));
        let before = self.text.get(start.copied().unwrap_or_default()..offset);
        let column = before.unwrap_or_default().chars().count() + 1;
        let narrow = |k| u32::try_from(k).unwrap_or(u32::MAX);
        (narrow(line), narrow(column))
    }

    fn error(
        &self,
        node: Node<'_, '_>,
        problem: Problem,
        what: &str,
        expected: &str,
        got: String,
    ) -> DataError {
        DataError::at(self.place(node), problem, what, expected, got)
    }

    /// From units of the drawing to metres, with y upwards.
    fn frame(&self, root: Node<'_, '_>) -> Result<Affine, DataError> {
        let size = |name| -> Result<Option<f64>, DataError> {
            let Some(value) = root.attribute(name).filter(|value| !value.ends_with('%')) else {
                return Ok(None);
            };
            let length = self.length(root, name, value)?;
            if length > 0.0 {
                Ok(Some(length))
            } else {
                let expected = "a length greater than 0";
                Err(self.error(
                    root,
                    Problem::OutOfRange,
                    "the size of a drawing",
                    expected,
                    shown(value),
                ))
            }
        };
        let (width, height) = (size("width")?, size("height")?);
        let Some(view) = root.attribute("viewBox") else {
            // y downwards from the upper edge
            let top = height.unwrap_or_default() * PIXEL_M;
            return Ok(Affine([PIXEL_M, 0.0, 0.0, -PIXEL_M, 0.0, top]));
        };
        let parsed = view.parse::<ViewBox>().map_err(|_| {
            let expected = "four numbers, the last two greater than 0";
            self.error(root, Problem::Syntax, "`viewBox`", expected, shown(view))
        })?;
        let x = width.map(|width| width / parsed.w);
        let y = height.map(|height| height / parsed.h);
        let none = root.attribute("preserveAspectRatio");
        if none.is_some_and(|how| how.trim_start().starts_with("none")) {
            let what = "a drawing that is stretched";
            let expected = "`preserveAspectRatio` that keeps it as it is";
            return Err(self.error(root, Problem::Conflict, what, expected, "`none`".to_owned()));
        }
        let scale = match (x, y) {
            (Some(x), Some(y)) if y < x => y,
            (Some(x), _) => x,
            (None, y) => y.unwrap_or(1.0),
        } * PIXEL_M;
        Ok(Affine([
            scale,
            0.0,
            0.0,
            -scale,
            -scale * parsed.x,
            scale * (parsed.y + parsed.h),
        ]))
    }

    /// A length in pixels.
    fn length(&self, node: Node<'_, '_>, name: &str, value: &str) -> Result<f64, DataError> {
        let wrong = |expected| {
            let what = format!("`{name}`");
            self.error(node, Problem::WrongType, &what, expected, shown(value))
        };
        let length: Length = value.trim().parse().map_err(|_| wrong("a length"))?;
        let pixels = match length.unit {
            LengthUnit::None | LengthUnit::Px => 1.0,
            LengthUnit::In => 96.0,
            LengthUnit::Cm => 96.0 / 2.54,
            LengthUnit::Mm => 96.0 / 25.4,
            LengthUnit::Pt => 96.0 / 72.0,
            LengthUnit::Pc => 16.0,
            LengthUnit::Percent | LengthUnit::Em | LengthUnit::Ex => {
                return Err(wrong("a length in px, mm, cm, in, pt or pc"));
            }
        };
        let number = length.number * pixels;
        if number.abs() <= 1e9 {
            Ok(number)
        } else {
            Err(wrong("a length of at most 1e9"))
        }
    }

    /// The length of an attribute, in pixels; without it, 0.
    fn attribute(&self, node: Node<'_, '_>, name: &str) -> Result<f64, DataError> {
        node.attribute(name)
            .map_or(Ok(0.0), |value| self.length(node, name, value))
    }

    fn group(&mut self, group: Node<'_, '_>, to: &Affine, depth: u32) -> Result<(), DataError> {
        if depth > DEEPEST {
            let expected = format!("at most {DEEPEST}");
            let what = "groups within groups";
            return Err(self.error(
                group,
                Problem::OutOfRange,
                what,
                &expected,
                "more".to_owned(),
            ));
        }
        for node in group.children().filter(Node::is_element) {
            let namespace = node.tag_name().namespace();
            let foreign = namespace.is_some_and(|uri| uri != "http://www.w3.org/2000/svg");
            if foreign || hidden(node) {
                continue;
            }
            let to = match node.attribute("transform") {
                None => *to,
                Some(text) => {
                    let inner = text.parse::<Transform>().map_err(|error| {
                        let (what, got) = ("`transform`", shown(&error.to_string()));
                        self.error(node, Problem::Syntax, what, "transforms of SVG", got)
                    })?;
                    to.then_inner(&inner)
                }
            };
            match node.tag_name().name() {
                "g" | "a" => self.group(node, &to, depth + 1)?,
                "defs" | "title" | "desc" | "metadata" | "style" | "symbol" | "clipPath"
                | "mask" | "marker" | "pattern" | "linearGradient" | "radialGradient"
                | "filter" => {}
                name => {
                    let before = self.outlines.len();
                    self.shape(node, name, &to)?;
                    self.check(node, before)?;
                }
            }
        }
        Ok(())
    }

    /// Numbers may overflow in transforms.
    fn check(&self, node: Node<'_, '_>, from: usize) -> Result<(), DataError> {
        let far = |point: &[f64; 3]| !point.iter().all(|x| x.abs() <= LARGEST_M);
        let outlines = self.outlines.iter().skip(from);
        let mut points = outlines.flat_map(|outline| {
            let parts = outline.parts.iter().map(|(to, _)| to);
            core::iter::once(&outline.from_m).chain(parts)
        });
        if points.any(far) {
            let got = "a point beyond".to_owned();
            let what = "a drawing that is too large";
            return Err(self.error(node, Problem::OutOfRange, what, "at most 10 km", got));
        }
        Ok(())
    }

    fn shape(&mut self, node: Node<'_, '_>, name: &str, to: &Affine) -> Result<(), DataError> {
        let line = self.place(node).0;
        let number = |name| self.attribute(node, name);
        let outlines = match name {
            "path" => self.path(node, to)?,
            "line" => {
                let mut outline = Outline::new(line, to.point(number("x1")?, number("y1")?));
                outline.line_to(to.point(number("x2")?, number("y2")?));
                vec![outline]
            }
            "polyline" | "polygon" => {
                let text = node.attribute("points").unwrap_or_default();
                let mut points = PointsParser::from(text).map(|(x, y)| to.point(x, y));
                let Some(first) = points.next() else {
                    return Ok(());
                };
                let mut outline = Outline::new(line, first);
                points.for_each(|point| outline.line_to(point));
                if name == "polygon" {
                    outline.line_to(first);
                }
                vec![outline]
            }
            "circle" | "ellipse" => {
                let (rx, ry) = if name == "circle" {
                    (number("r")?, number("r")?)
                } else {
                    (number("rx")?, number("ry")?)
                };
                let mut outline = Outline::new(line, to.point(number("cx")? + rx, number("cy")?));
                if rx > 0.0 && ry > 0.0 {
                    let centre = to.point(number("cx")?, number("cy")?);
                    self.bend(node, &mut outline, to, &centre, [rx, ry], (0.0, 2.0 * PI))?;
                }
                vec![outline]
            }
            "rect" => vec![self.rectangle(node, to)?],
            _ => {
                let expected = "paths and shapes: convert text, clones and the like to paths";
                let got = shown(name);
                let what = "an element that is no outline";
                return Err(self.error(node, Problem::UnknownName, what, expected, got));
            }
        };
        let all = outlines
            .into_iter()
            .filter(|outline| !outline.parts.is_empty());
        self.outlines.extend(all);
        Ok(())
    }

    /// A part of an ellipse whose axes are those of the element.
    fn bend(
        &self,
        node: Node<'_, '_>,
        outline: &mut Outline,
        to: &Affine,
        centre: &[f64; 3],
        [rx, ry]: [f64; 2],
        (from, angle): (f64, f64),
    ) -> Result<(), DataError> {
        let curves = ellipse(
            centre,
            &to.vector(rx, 0.0),
            &to.vector(0.0, ry),
            from,
            angle,
        );
        for curve in curves.map_err(|error| self.curve(node, error))? {
            outline.curve(curve);
        }
        Ok(())
    }

    fn curve(&self, node: Node<'_, '_>, error: NurbsError) -> DataError {
        let got = "another".to_owned();
        self.error(node, Problem::NotFinite, "a curve", &error.to_string(), got)
    }

    fn rectangle(&self, node: Node<'_, '_>, to: &Affine) -> Result<Outline, DataError> {
        let number = |name| self.attribute(node, name);
        let (x, y, w, h) = (
            number("x")?,
            number("y")?,
            number("width")?,
            number("height")?,
        );
        let radius = |name: &str, other: &str| -> Result<f64, DataError> {
            let name = if node.has_attribute(name) {
                name
            } else {
                other
            };
            self.attribute(node, name)
        };
        let (mut rx, mut ry) = (radius("rx", "ry")?, radius("ry", "rx")?);
        rx = rx.clamp(0.0, (0.5 * w).abs());
        ry = ry.clamp(0.0, (0.5 * h).abs());
        let mut outline = Outline::new(self.place(node).0, to.point(x + rx, y));
        if !(w > 0.0 && h > 0.0) {
            return Ok(outline);
        }
        let corners = [
            (x + w - rx, y, x + w - rx, y + ry, -FRAC_PI_2),
            (x + w, y + h - ry, x + w - rx, y + h - ry, 0.0),
            (x + rx, y + h, x + rx, y + h - ry, FRAC_PI_2),
            (x, y + ry, x + rx, y + ry, PI),
        ];
        for (ex, ey, cx, cy, from) in corners {
            outline.line_to(to.point(ex, ey));
            if rx > 0.0 && ry > 0.0 {
                let centre = to.point(cx, cy);
                self.bend(node, &mut outline, to, &centre, [rx, ry], (from, FRAC_PI_2))?;
            }
        }
        outline.line_to(outline.from_m);
        Ok(outline)
    }

    fn path(&self, node: Node<'_, '_>, to: &Affine) -> Result<Vec<Outline>, DataError> {
        let line = self.place(node).0;
        let mut pen = Pen {
            at: [0.0; 2],
            start: [0.0; 2],
            mirror: None,
            quadratic: false,
        };
        let mut outlines: Vec<Outline> = Vec::new();
        let mut closed = true;
        for segment in PathParser::from(node.attribute("d").unwrap_or_default()) {
            let segment = segment.map_err(|error| {
                let got = shown(&error.to_string());
                self.error(node, Problem::Syntax, "`d`", "path data of SVG", got)
            })?;
            if let PathSegment::MoveTo { abs, x, y } = segment {
                pen.at = pen.to(abs, x, y);
                pen.start = pen.at;
                pen.mirror = None;
                closed = true;
                continue;
            }
            if closed {
                outlines.push(Outline::new(line, to.point(pen.at[0], pen.at[1])));
                closed = false;
            }
            if let Some(outline) = outlines.last_mut() {
                pen.draw(segment, outline, to)
                    .map_err(|error| self.curve(node, error))?;
            }
            closed |= matches!(segment, PathSegment::ClosePath { .. });
        }
        Ok(outlines)
    }
}

fn hidden(node: Element<'_>) -> bool {
    let style = node.attribute("style").unwrap_or_default();
    let said = |text: &str| text.trim() == "none";
    let in_style = style.split(';').filter_map(|part| part.split_once(':'));
    node.attribute("display").is_some_and(said)
        || in_style
            .into_iter()
            .any(|(key, value)| key.trim() == "display" && said(value))
}
