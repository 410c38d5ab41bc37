//! A board that was cut: as it looks on the left, the programmed path and the errors along it on the right.

use super::drawing::{Anchor, Colour, Drawing, FRAME, INK, Raster, SOFT_INK, Shape, Stroke};
use super::panel::Panel;
use super::scale::{Range, finite};
use errors::Errors;
use wood::Surface;

mod errors;
#[cfg(test)]
mod test;
mod wood;

/// What to draw: a map of heights and paths over it, in the frame of the board: origin at its lower
/// left corner, x to the right, y up.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BoardPicture<'a> {
    /// Above everything.
    pub title: String,
    /// Below it, a line each.
    pub summary: Vec<String>,
    /// Sides along x and y, m.
    pub size_m: [f64; 2],
    /// Heights at the centres of square cells, m: 0 where uncut, negative below. Row after row from y = 0, x growing within
    /// a row; an incomplete last row is left out, and what is not finite counts as 0.
    pub heights_m: &'a [f32],
    /// Cells in a row.
    pub columns: usize,
    /// Where the tool was to go.
    pub programmed: &'a [ProgrammedLine],
    /// Where it was and how wrong, in the order of time. A sample with a number that is not finite
    /// parts the line.
    pub errors: &'a [PathError],
}

/// A part of the programmed path.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ProgrammedLine {
    /// Through these points over the board, m.
    pub points_m: Vec<[f64; 2]>,
    /// In the wood, or above it on the way to where it cuts again?
    pub cutting: bool,
}

/// How far from the programmed path the tool was.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PathError {
    /// Where, over the board, m.
    pub at_m: [f64; 2],
    /// How far, m; the sign does not matter.
    pub error_m: f64,
}

const MARGIN: f64 = 24.0;
/// Left of a diagram, for the numbers and the name of its axis.
const AXIS_ROOM: f64 = 62.0;
const BOARD_LEFT: f64 = MARGIN + AXIS_ROOM;
/// Between the diagrams, the axis of the right one included.
const GAP: f64 = 96.0;
/// The largest diagram.
const WIDEST: f64 = 640.0;
const TALLEST: f64 = 640.0;
/// The narrowest: names and numbers must fit below it.
const NARROWEST: f64 = 200.0;
/// The colour bar with its numbers.
const BAR_ROOM: f64 = 110.0;
const TITLE_HEIGHT: f64 = 44.0;
const SUMMARY_LINE: f64 = 19.0;
const BELOW: f64 = 58.0;
/// From the summary to the diagrams: their titles.
const HEAD: f64 = 44.0;
/// Millimetres in a metre.
const MM: f64 = 1e3;

const PAPER: Colour = Colour::new(0xFF_FFFF);
const PATH: Colour = Colour::new(0x9A_A3AD);
const RAPID: Colour = Colour::new(0xB4_BCC8);
const BACKGROUND: Colour = Colour::new(0xFA_FAF8);

/// Rows of the shadow of the board on the paper.
const SHADOW: u8 = 10;

pub(super) fn lay_out(data: &BoardPicture<'_>) -> Drawing {
    let (width, height) = diagram(data.size_m);
    let lines = f64::from(u16::try_from(data.summary.len()).unwrap_or(u16::MAX));
    let top = TITLE_HEIGHT + lines * SUMMARY_LINE + HEAD;
    let right = BOARD_LEFT + width + GAP;
    let mut drawing = Drawing {
        width: libm::ceil(right + width + BAR_ROOM + MARGIN),
        height: libm::ceil(top + height + BELOW),
        shapes: Vec::new(),
    };
    let paper = [0.0, 0.0, drawing.width, drawing.height];
    drawing.shapes.push(Shape::Rect(paper, PAPER));
    drawing.text([MARGIN, 36.0], 20.0, Anchor::Start, INK, data.title.clone());
    let mut base = TITLE_HEIGHT + 16.0;
    for line in &data.summary {
        drawing.text([MARGIN, base], 13.0, Anchor::Start, SOFT_INK, line.clone());
        base += SUMMARY_LINE;
    }
    let side = |side: f64| Range {
        lower: 0.0,
        upper: if side > 0.0 && finite(side) {
            side * MM
        } else {
            1.0
        },
    };
    let panel = |left| Panel {
        left,
        top,
        width,
        height,
        x: side(data.size_m[0]),
        y: side(data.size_m[1]),
    };
    workpiece(&mut drawing, &panel(BOARD_LEFT), data);
    path(&mut drawing, &panel(right), data);
    drawing
}

/// The size of a diagram of a board.
fn diagram([x, y]: [f64; 2]) -> (f64, f64) {
    let ratio = if x > 0.0 && y > 0.0 { y / x } else { 1.0 };
    let least = NARROWEST / WIDEST;
    let (width, height) = if ratio * WIDEST > TALLEST {
        (TALLEST / ratio, TALLEST)
    } else {
        (WIDEST, WIDEST * ratio)
    };
    // a strip is drawn wider than it is: better than a line nobody can see
    let at_least = |v: f64| if v > least * WIDEST { v } else { NARROWEST };
    (libm::round(at_least(width)), libm::round(at_least(height)))
}

/// The board as it looks, light from the upper left.
fn workpiece(drawing: &mut Drawing, panel: &Panel, data: &BoardPicture<'_>) {
    panel.axes(drawing, "Workpiece", "x [mm]", "y [mm]");
    for step in 0..SHADOW {
        let by = f64::from(step);
        let place = [panel.left + 2.0 + 0.4 * by, panel.top + 2.0 + 0.4 * by];
        let extent = [panel.width, panel.height].map(|side| side + 4.0 - 0.6 * by);
        let shape = Shape::Rect(
            [place[0], place[1], extent[0], extent[1]],
            Colour::new(0x3A_2A1A).faint(0.035),
        );
        drawing.shapes.push(shape);
    }
    let fine = f64::from(super::png::SCALE);
    let [columns, rows] = [panel.width, panel.height].map(|side| pixels(side * fine));
    let surface = Surface::new(data.heights_m, data.columns, data.size_m);
    let pixels = surface.pixels(columns, rows);
    let place = [panel.left, panel.top, panel.width, panel.height];
    let raster = Raster {
        columns,
        rows,
        pixels,
    };
    drawing.shapes.push(Shape::Raster(place, raster));
    let deepest = surface.deepest_m() * MM;
    if deepest > 0.0 {
        let words = format!("deepest {deepest:.2} mm");
        let at = [panel.left + panel.width, panel.top - 22.0];
        drawing.text(at, 12.0, Anchor::End, SOFT_INK, words);
    }
}

/// The programmed path, and over it the errors in colours, with what they mean.
fn path(drawing: &mut Drawing, panel: &Panel, data: &BoardPicture<'_>) {
    let place = [panel.left, panel.top, panel.width, panel.height];
    drawing.shapes.push(Shape::Rect(place, BACKGROUND));
    panel.axes(drawing, "Path error", "x [mm]", "y [mm]");
    // rapids below, so that they never hide a cut
    for cutting in [false, true] {
        let stroke = if cutting {
            Stroke::solid(PATH, 0.8)
        } else {
            Stroke::dashed(RAPID, 0.7)
        };
        for line in data.programmed.iter().filter(|l| l.cutting == cutting) {
            let inside = line.points_m.iter().map(|p| p.map(|v| v * MM));
            panel.line(drawing, inside, stroke);
        }
    }
    let errors = Errors::new(data.errors);
    errors.draw(drawing, panel);
    errors.bar(
        drawing,
        panel.left + panel.width + 26.0,
        panel.top,
        panel.height,
    );
    legend(drawing, panel, data.programmed);
    let corners = [
        [panel.left, panel.top],
        [panel.left + panel.width, panel.top],
        [panel.left + panel.width, panel.top + panel.height],
        [panel.left, panel.top + panel.height],
        [panel.left, panel.top],
    ];
    drawing.line(corners.to_vec(), Stroke::solid(FRAME, 1.0));
}

/// What a dashed line is, where there is one.
fn legend(drawing: &mut Drawing, panel: &Panel, programmed: &[ProgrammedLine]) {
    if programmed.iter().all(|line| line.cutting) {
        return;
    }
    let (right, base) = (panel.left + panel.width, panel.top - 22.0);
    let left = right - super::font::width("rapid", 12.0);
    drawing.text([right, base], 12.0, Anchor::End, SOFT_INK, "rapid");
    let ends = vec![[left - 32.0, base - 4.0], [left - 6.0, base - 4.0]];
    drawing.line(ends, Stroke::dashed(PATH, 1.0));
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "bounded by the layout; `as` saturates"
)]
fn pixels(side: f64) -> u32 {
    libm::round(side) as u32
}
