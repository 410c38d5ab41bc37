//! Curves over one quantity, in diagrams one below the other.

use super::drawing::{Colour, Drawing, INK, SOFT_INK, Shape, Stroke};
use super::motion::{
    LEFT, PANEL_HEIGHT, PANEL_WIDTH, PITCH, WIDTH, legend, stroke, thin_lines, visible,
};
use super::panel::Panel;
use super::scale::{Range, finite};

/// What to draw.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CurvesPlot {
    /// Above everything.
    pub title: String,
    /// Names of the curves of diagrams that have several.
    pub names: Vec<String>,
    /// What all diagrams are over, with its unit.
    pub x_name: String,
    /// From above.
    pub diagrams: Vec<CurveDiagram>,
}

/// One diagram; 0 and the limit are always in it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CurveDiagram {
    /// What it shows, with its unit.
    pub y_name: String,
    /// A thin line, if there is one.
    pub limit: Option<f64>,
    /// Points [x, y] of each curve, x not decreasing; those that are not finite are left out.
    pub curves: Vec<Vec<[f64; 2]>>,
}

pub(super) fn lay_out(data: &CurvesPlot) -> Drawing {
    let mut drawing = Drawing {
        width: WIDTH,
        ..Drawing::default()
    };
    drawing.title(&data.title);
    let limits = data.diagrams.iter().any(|d| d.limit.is_some());
    let names = data.names.iter().map(String::as_str);
    let mut top = legend(&mut drawing, names, limits) + 20.0;
    let points = || data.diagrams.iter().flat_map(|d| d.curves.iter().flatten());
    let x = Range::of(points().map(|[x, _]| *x)).padded(0.0, 1e-6);
    for (number, diagram) in data.diagrams.iter().enumerate() {
        let last = number + 1 == data.diagrams.len();
        let x_name = if last { data.x_name.as_str() } else { "" };
        diagram.draw(&mut drawing, top, x, x_name);
        top += PITCH;
    }
    drawing.height = top + 34.0;
    let paper = Shape::Rect(
        [0.0, 0.0, drawing.width, drawing.height],
        Colour::new(0xFF_FFFF),
    );
    drawing.shapes.insert(0, paper);
    drawing
}

impl CurveDiagram {
    fn draw(&self, drawing: &mut Drawing, top: f64, x: Range, x_name: &str) {
        let values = self.curves.iter().flatten().map(|[_, y]| *y);
        let range = Range::of(values.chain(self.limit).chain([0.0]));
        let panel = Panel {
            left: LEFT,
            top,
            width: PANEL_WIDTH,
            height: PANEL_HEIGHT,
            x,
            y: visible(range),
        };
        panel.axes(drawing, "", x_name, &self.y_name);
        let limits: Vec<(f64, Colour)> = self
            .limit
            .map(|value| (value, SOFT_INK))
            .into_iter()
            .collect();
        thin_lines(drawing, &panel, &limits);
        for (number, curve) in self.curves.iter().enumerate() {
            let points = curve
                .iter()
                .copied()
                .filter(|[x, y]| finite(*x) && finite(*y));
            let stroke = if self.curves.len() == 1 {
                Stroke::solid(INK, 2.0)
            } else {
                stroke(number)
            };
            panel.line(drawing, points, stroke);
        }
    }
}
