//! One diagram: frame, grid, ticks and lines.

use super::decimate::decimate;
use super::drawing::{Anchor, Drawing, FRAME, GRID, INK, MARK, SOFT_INK, Shape, Stroke, Text};
use super::scale::Range;

const SMALL: f64 = 11.0;
/// About how many pixels a labelled grid line needs.
const ROOM_X: f64 = 60.0;
const ROOM_Y: f64 = 36.0;

/// Where a diagram lies and what it spans.
#[derive(Clone, Copy, Debug)]
pub(super) struct Panel {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) width: f64,
    pub(super) height: f64,
    pub(super) x: Range,
    pub(super) y: Range,
}

impl Panel {
    /// Widens a range so that both axes have one scale.
    pub(super) fn with_equal_scales(mut self) -> Self {
        let (x, y) = (self.x.span() / self.width, self.y.span() / self.height);
        if x > y {
            self.y = self.y.to_span(x * self.height);
        } else {
            self.x = self.x.to_span(y * self.width);
        }
        self
    }

    pub(super) fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [
            self.left + self.width * (x - self.x.lower) / self.x.span(),
            self.top + self.height * (self.y.upper - y) / self.y.span(),
        ]
    }

    /// Grid, frame, numbers and names of the axes; where x has no name it has no numbers either,
    /// because the diagram below has them.
    pub(super) fn axes(&self, drawing: &mut Drawing, title: &str, x_name: &str, y_name: &str) {
        let (right, bottom) = (self.left + self.width, self.top + self.height);
        for (value, label) in self.x.ticks(count(self.width / ROOM_X)) {
            let [x, _] = self.place([value, self.y.lower]);
            drawing.line(vec![[x, self.top], [x, bottom]], Stroke::solid(GRID, 1.0));
            if !x_name.is_empty() {
                drawing.text([x, bottom + 15.0], SMALL, Anchor::Middle, SOFT_INK, label);
            }
        }
        for (value, label) in self.y.ticks(count(self.height / ROOM_Y)) {
            let [_, y] = self.place([self.x.lower, value]);
            drawing.line(vec![[self.left, y], [right, y]], Stroke::solid(GRID, 1.0));
            drawing.text(
                [self.left - 6.0, y + 4.0],
                SMALL,
                Anchor::End,
                SOFT_INK,
                label,
            );
        }
        let corners = [
            [self.left, self.top],
            [right, self.top],
            [right, bottom],
            [self.left, bottom],
            [self.left, self.top],
        ];
        drawing.line(corners.to_vec(), Stroke::solid(FRAME, 1.0));
        drawing.text(
            [self.left, self.top - 22.0],
            13.0,
            Anchor::Start,
            INK,
            title,
        );
        drawing.text(
            [self.left + 0.5 * self.width, bottom + 33.0],
            12.0,
            Anchor::Middle,
            INK,
            x_name,
        );
        drawing.shapes.push(Shape::Text(Text {
            at: [self.left - 50.0, self.top + 0.5 * self.height],
            size: 12.0,
            anchor: Anchor::Middle,
            colour: INK,
            upwards: true,
            words: y_name.to_owned(),
        }));
    }

    /// A light vertical line at x with a short label above the frame.
    pub(super) fn mark(&self, drawing: &mut Drawing, x: f64, label: Option<&str>) {
        if !(self.x.lower..=self.x.upper).contains(&x) {
            return;
        }
        let [x, _] = self.place([x, 0.0]);
        drawing.line(
            vec![[x, self.top], [x, self.top + self.height]],
            Stroke::solid(MARK, 1.0),
        );
        if let Some(label) = label {
            drawing.text([x, self.top - 5.0], 10.0, Anchor::Middle, SOFT_INK, label);
        }
    }

    pub(super) fn line(
        &self,
        drawing: &mut Drawing,
        points: impl Iterator<Item = [f64; 2]>,
        stroke: Stroke,
    ) {
        let points = decimate(points);
        drawing.line(points.into_iter().map(|p| self.place(p)).collect(), stroke);
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a handful of grid lines"
)]
fn count(room: f64) -> u32 {
    if room > 2.0 { room as u32 } else { 2 }
}
