//! The shapes as PNG.

use super::drawing::{Anchor, Colour, Drawing, Raster, Shape, Stroke, Text};
use super::font;
use crate::error::Error;
use tiny_skia::{
    ColorU8, FillRule, FilterQuality, LineJoin, Paint, PathBuilder, Pixmap, PixmapPaint, Rect,
    StrokeDash, Transform,
};
use ttf_parser::{Face, OutlineBuilder};

/// Pixels per unit of the drawing.
pub(super) const SCALE: f32 = 1.5;

/// The tallest picture, in units of the drawing.
const TALLEST: f64 = 20_000.0;

pub(super) fn write(drawing: &Drawing) -> Result<Vec<u8>, Error> {
    let face =
        font::face().ok_or_else(|| Error::Internal("the built-in font is damaged".into()))?;
    let height = if drawing.height < TALLEST {
        drawing.height
    } else {
        TALLEST
    };
    let mut map = Pixmap::new(
        pixels(SCALE * narrow(drawing.width)),
        pixels(SCALE * narrow(height)),
    )
    .ok_or_else(|| Error::Internal("a picture without size".into()))?;
    let whole = Transform::from_scale(SCALE, SCALE);
    for shape in &drawing.shapes {
        match shape {
            Shape::Line(points, stroke) => line(&mut map, points, *stroke, whole),
            Shape::Rect([x, y, width, height], fill) => {
                let [x, y, width, height] = [*x, *y, *width, *height].map(narrow);
                if let Some(rect) = Rect::from_xywh(x, y, width, height) {
                    map.fill_rect(rect, &paint(*fill), whole, None);
                }
            }
            Shape::Disc([x, y], radius, fill) => {
                let disc = PathBuilder::from_circle(narrow(*x), narrow(*y), narrow(*radius));
                if let Some(path) = disc {
                    map.fill_path(&path, &paint(*fill), FillRule::Winding, whole, None);
                }
            }
            Shape::Text(text) => label(&mut map, &face, text, whole),
            Shape::Raster(place, raster) => pixels_at(&mut map, *place, raster, whole),
        }
    }
    map.encode_png()
        .map_err(|error| Error::Internal(format!("cannot encode the picture: {error}")))
}

/// Pixels alone as PNG; none if there are none.
pub(super) fn encode(raster: &Raster) -> Option<Vec<u8>> {
    opaque(raster)?.encode_png().ok()
}

fn opaque(raster: &Raster) -> Option<Pixmap> {
    let mut map = Pixmap::new(raster.columns, raster.rows)?;
    for (pixel, [r, g, b]) in map.pixels_mut().iter_mut().zip(&raster.pixels) {
        *pixel = ColorU8::from_rgba(*r, *g, *b, u8::MAX).premultiply();
    }
    Some(map)
}

fn pixels_at(map: &mut Pixmap, [x, y, width, height]: [f64; 4], raster: &Raster, whole: Transform) {
    let Some(image) = opaque(raster) else {
        return;
    };
    let place = whole.pre_translate(narrow(x), narrow(y)).pre_scale(
        narrow(width / f64::from(raster.columns)),
        narrow(height / f64::from(raster.rows)),
    );
    let paint = PixmapPaint {
        quality: FilterQuality::Bilinear,
        ..PixmapPaint::default()
    };
    map.draw_pixmap(0, 0, image.as_ref(), &paint, place, None);
}

fn line(map: &mut Pixmap, points: &[[f64; 2]], stroke: Stroke, whole: Transform) {
    let mut builder = PathBuilder::new();
    for (index, [x, y]) in points.iter().enumerate() {
        if index == 0 {
            builder.move_to(narrow(*x), narrow(*y));
        } else {
            builder.line_to(narrow(*x), narrow(*y));
        }
    }
    let Some(path) = builder.finish() else {
        return;
    };
    let style = tiny_skia::Stroke {
        width: narrow(stroke.width),
        line_join: LineJoin::Round,
        dash: stroke
            .dashed
            .then(|| StrokeDash::new(vec![5.0, 3.0], 0.0))
            .flatten(),
        ..tiny_skia::Stroke::default()
    };
    map.stroke_path(&path, &paint(stroke.colour), &style, whole, None);
}

fn label(map: &mut Pixmap, face: &Face<'_>, text: &Text, whole: Transform) {
    let width = narrow(font::width(&text.words, text.size));
    let start = match text.anchor {
        Anchor::Start => 0.0,
        Anchor::Middle => -0.5 * width,
        Anchor::End => -width,
    };
    let [x, y] = text.at.map(narrow);
    let mut place = whole.pre_translate(x, y);
    if text.upwards {
        place = place.pre_rotate(-90.0);
    }
    let scale = narrow(text.size) / f32::from(face.units_per_em());
    // fonts count upwards
    place = place.pre_translate(start, 0.0).pre_scale(scale, -scale);
    let mut outline = Outline {
        builder: PathBuilder::new(),
        at: 0.0,
    };
    for c in text.words.chars() {
        let glyph = face.glyph_index(c).unwrap_or_default();
        face.outline_glyph(glyph, &mut outline);
        outline.at += f32::from(face.glyph_hor_advance(glyph).unwrap_or(0));
    }
    if let Some(path) = outline.builder.finish() {
        map.fill_path(&path, &paint(text.colour), FillRule::Winding, place, None);
    }
}

/// Glyphs one after the other in one path.
struct Outline {
    builder: PathBuilder,
    /// Where the present glyph begins, font units.
    at: f32,
}

impl OutlineBuilder for Outline {
    fn move_to(&mut self, x: f32, y: f32) {
        self.builder.move_to(self.at + x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.builder.line_to(self.at + x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        self.builder.quad_to(self.at + x1, y1, self.at + x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        self.builder
            .cubic_to(self.at + x1, y1, self.at + x2, y2, self.at + x, y);
    }

    fn close(&mut self) {
        self.builder.close();
    }
}

fn paint(colour: Colour) -> Paint<'static> {
    let [r, g, b] = colour.rgb;
    let mut paint = Paint::default();
    paint.set_color_rgba8(r, g, b, byte(255.0 * colour.opacity));
    paint.anti_alias = true;
    paint
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "pixels need no more than 24 bits"
)]
fn narrow(value: f64) -> f32 {
    value as f32
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "bounded by the layout; `as` saturates"
)]
fn pixels(value: f32) -> u32 {
    value as u32
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "0 to 255; `as` saturates"
)]
fn byte(value: f32) -> u8 {
    value as u8
}
