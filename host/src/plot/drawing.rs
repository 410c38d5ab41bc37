//! The list of shapes between layout and file.

use super::font;

const TITLE_LEFT: f64 = 24.0;
const TITLE_SIZE: f64 = 20.0;

/// Red, green, blue, opacity 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Colour {
    pub(super) rgb: [u8; 3],
    pub(super) opacity: f32,
}

impl Colour {
    pub(super) const fn new(rgb: u32) -> Self {
        let [_, r, g, b] = rgb.to_be_bytes();
        Self {
            rgb: [r, g, b],
            opacity: 1.0,
        }
    }

    pub(super) const fn faint(mut self, opacity: f32) -> Self {
        self.opacity = opacity;
        self
    }
}

pub(super) const INK: Colour = Colour::new(0x22_2222);
pub(super) const SOFT_INK: Colour = Colour::new(0x66_6666);
pub(super) const GRID: Colour = Colour::new(0xE4_E4E4);
pub(super) const FRAME: Colour = Colour::new(0x99_9999);
pub(super) const MARK: Colour = Colour::new(0xB8_B0D8);

/// One per axis: told apart by people with any colour vision as far as eight colours can be.
const AXES: [Colour; 8] = [
    Colour::new(0x00_72B2),
    Colour::new(0xD5_5E00),
    Colour::new(0x00_9E73),
    Colour::new(0xCC_79A7),
    Colour::new(0xB8_8600),
    Colour::new(0x40_A8E0),
    Colour::new(0x6A_3D9A),
    Colour::new(0x44_4444),
];

pub(super) fn axis_colour(axis: usize) -> Colour {
    AXES.get(axis % AXES.len()).copied().unwrap_or(INK)
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stroke {
    pub(super) colour: Colour,
    pub(super) width: f64,
    pub(super) dashed: bool,
}

impl Stroke {
    pub(super) const fn solid(colour: Colour, width: f64) -> Self {
        Self {
            colour,
            width,
            dashed: false,
        }
    }

    pub(super) const fn dashed(colour: Colour, width: f64) -> Self {
        Self {
            colour,
            width,
            dashed: true,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct Text {
    /// Left, middle or right end of the base line, as the anchor says.
    pub(super) at: [f64; 2],
    pub(super) size: f64,
    pub(super) anchor: Anchor,
    pub(super) colour: Colour,
    /// Turned to read upwards?
    pub(super) upwards: bool,
    pub(super) words: String,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Shape {
    /// A line through points.
    Line(Vec<[f64; 2]>, Stroke),
    /// A filled rectangle: left, top, width, height.
    Rect([f64; 4], Colour),
    /// A disc: centre, radius.
    Disc([f64; 2], f64, Colour),
    Text(Text),
    /// Pixels in a rectangle: left, top, width, height.
    Raster([f64; 4], Raster),
}

/// Pixels, row after row from above.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Raster {
    pub(super) columns: u32,
    pub(super) rows: u32,
    /// Red, green, blue; as many as columns times rows.
    pub(super) pixels: Vec<[u8; 3]>,
}

/// Shapes on white paper; x to the right, y down.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Drawing {
    pub(super) width: f64,
    pub(super) height: f64,
    pub(super) shapes: Vec<Shape>,
}

impl Drawing {
    pub(super) fn line(&mut self, points: Vec<[f64; 2]>, stroke: Stroke) {
        if points.len() > 1 {
            self.shapes.push(Shape::Line(points, stroke));
        }
    }

    /// The words above everything, smaller if they are many: at most as wide as the paper.
    pub(super) fn title(&mut self, words: &str) {
        let room = self.width - 2.0 * TITLE_LEFT;
        let wide = font::width(words, TITLE_SIZE);
        let size = if wide > room {
            TITLE_SIZE * (room / wide)
        } else {
            TITLE_SIZE
        };
        self.text([TITLE_LEFT, 34.0], size, Anchor::Start, INK, words);
    }

    pub(super) fn text(
        &mut self,
        at: [f64; 2],
        size: f64,
        anchor: Anchor,
        colour: Colour,
        words: impl Into<String>,
    ) {
        let words = words.into();
        if words.is_empty() {
            return;
        }
        self.shapes.push(Shape::Text(Text {
            at,
            size,
            anchor,
            colour,
            upwards: false,
            words,
        }));
    }
}
