//! Where everything goes: a title, a row of four diagrams per robot, the names of the steps.

use super::drawing::{Anchor, Drawing, INK, SOFT_INK, Shape, Stroke, axis_colour};
use super::panel::Panel;
use super::scale::{Range, finite};
use super::{AxisPlot, PlotData, RobotPlot, StepMark, font};

const WIDTH: f64 = 1720.0;
const TITLE_HEIGHT: f64 = 50.0;
const ROW_HEIGHT: f64 = 470.0;
const LINE_HEIGHT: f64 = 18.0;
/// From the top of a row to its diagrams: name, legend, titles.
const HEAD: f64 = 92.0;
const PANEL_HEIGHT: f64 = 310.0;
/// Left edge and width of the four diagrams.
const JOINTS: (f64, f64) = (72.0, 540.0);
const ERRORS: (f64, f64) = (694.0, 350.0);
const TOP_VIEW: (f64, f64) = (1122.0, 250.0);
const SIDE_VIEW: (f64, f64) = (1450.0, 250.0);

pub(super) fn lay_out(data: &PlotData) -> Drawing {
    let names = step_lines(&data.steps);
    let rows = f64::from(u16::try_from(data.robots.len()).unwrap_or(u16::MAX));
    let lines = f64::from(u16::try_from(names.len()).unwrap_or(u16::MAX));
    let mut drawing = Drawing {
        width: WIDTH,
        height: TITLE_HEIGHT + rows * ROW_HEIGHT + lines * LINE_HEIGHT + 16.0,
        shapes: Vec::new(),
    };
    drawing.shapes.push(Shape::Rect(
        [0.0, 0.0, drawing.width, drawing.height],
        super::drawing::Colour::new(0xFF_FFFF),
    ));
    drawing.title(&data.title);
    let mut top = TITLE_HEIGHT;
    for robot in &data.robots {
        row(&mut drawing, top, robot, &data.steps);
        top += ROW_HEIGHT;
    }
    for line in names {
        drawing.text([24.0, top + 8.0], 12.0, Anchor::Start, SOFT_INK, line);
        top += LINE_HEIGHT;
    }
    drawing
}

/// The names of the steps by their numbers, in lines of the paper's width.
fn step_lines(steps: &[StepMark]) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for (number, step) in (1..).zip(steps) {
        let name: String = step.name.chars().take(80).collect();
        let entry = format!("{number} {name} ({:.1} s)", step.time_s);
        match lines.last_mut() {
            Some(line) if font::width(line, 12.0) + font::width(&entry, 12.0) < WIDTH - 90.0 => {
                line.push_str("   ·   ");
                line.push_str(&entry);
            }
            _ => lines.push(if lines.is_empty() {
                format!("Steps:  {entry}")
            } else {
                entry
            }),
        }
    }
    lines
}

/// The diagrams of a robot, placed in its row.
struct Row<'a> {
    robot: &'a RobotPlot,
    steps: &'a [StepMark],
    top: f64,
}

fn row(drawing: &mut Drawing, top: f64, robot: &RobotPlot, steps: &[StepMark]) {
    drawing.text(
        [24.0, top + 20.0],
        16.0,
        Anchor::Start,
        INK,
        robot.name.clone(),
    );
    legend(drawing, top + 44.0, robot);
    let row = Row { robot, steps, top };
    row.joints(drawing);
    row.errors(drawing);
    let names = ("Tool from above", "x [m]", "y [m]");
    row.view(drawing, TOP_VIEW, names, [0, 1]);
    let names = ("Tool from the side", "x [m]", "z [m]");
    row.view(drawing, SIDE_VIEW, names, [0, 2]);
}

impl Row<'_> {
    fn panel(&self, (left, width): (f64, f64), x: Range, y: Range) -> Panel {
        Panel {
            left,
            top: self.top + HEAD,
            width,
            height: PANEL_HEIGHT,
            x,
            y,
        }
    }

    fn time(&self) -> Range {
        Range::of(self.robot.time_s.iter().copied()).padded(0.0, 0.1)
    }

    fn every(&self, pick: fn(&AxisPlot) -> &Vec<f64>) -> impl Iterator<Item = f64> {
        let axes = self.robot.axes.iter();
        axes.flat_map(move |axis| pick(axis).iter().copied())
    }

    fn joints(&self, drawing: &mut Drawing) {
        let range = Range::of(self.every(|a| &a.setpoint).chain(self.every(|a| &a.actual)));
        let panel = self.panel(JOINTS, self.time(), range.padded(0.05, 0.01));
        let metres = self.robot.axes.iter().any(|a| a.name.contains("[m]"));
        let name = if metres {
            "position [rad, m]"
        } else {
            "position [rad]"
        };
        panel.axes(drawing, "Joints", "time [s]", name);
        marks(drawing, &panel, self.steps);
        for (number, axis) in self.robot.axes.iter().enumerate() {
            let colour = axis_colour(number);
            for (values, stroke) in [
                (&axis.setpoint, Stroke::solid(colour.faint(0.5), 2.4)),
                (&axis.actual, Stroke::dashed(colour, 1.1)),
            ] {
                let points = self.robot.time_s.iter().zip(values);
                panel.line(drawing, points.map(|(t, v)| [*t, *v]), stroke);
            }
        }
    }

    fn errors(&self, drawing: &mut Drawing) {
        let range = Range::of(self.every(|a| &a.following_error_rad)).padded(0.08, 1e-6);
        let greatest = if -range.lower > range.upper {
            -range.lower
        } else {
            range.upper
        };
        // the unit that gives numbers of few digits
        let (factor, unit) = if greatest < 0.5e-3 {
            (1e6, "µrad")
        } else if greatest < 0.5 {
            (1e3, "mrad")
        } else {
            (1.0, "rad")
        };
        let scaled = Range {
            lower: factor * range.lower,
            upper: factor * range.upper,
        };
        let panel = self.panel(ERRORS, self.time(), scaled);
        let name = format!("at the motor shaft [{unit}]");
        panel.axes(drawing, "Following error", "time [s]", &name);
        marks(drawing, &panel, self.steps);
        for (number, axis) in self.robot.axes.iter().enumerate() {
            let points = self.robot.time_s.iter().zip(&axis.following_error_rad);
            let stroke = Stroke::solid(axis_colour(number), 1.1);
            panel.line(drawing, points.map(|(t, v)| [*t, factor * v]), stroke);
        }
    }
}

/// The names of the axes in their colours, then what the lines mean.
fn legend(drawing: &mut Drawing, y: f64, robot: &RobotPlot) {
    let mut x = 24.0;
    for (number, axis) in robot.axes.iter().enumerate() {
        let name: String = axis.name.chars().take(24).collect();
        drawing.line(
            vec![[x, y - 4.0], [x + 22.0, y - 4.0]],
            Stroke::solid(axis_colour(number), 3.0),
        );
        let label = format!("{} {name}", number + 1);
        x += 28.0;
        let width = font::width(&label, 12.0);
        drawing.text([x, y], 12.0, Anchor::Start, INK, label);
        x += width + 20.0;
    }
    x += 12.0;
    for (stroke, label) in [
        (Stroke::solid(INK.faint(0.5), 2.4), "set-point"),
        (Stroke::dashed(INK, 1.1), "actual"),
    ] {
        drawing.line(vec![[x, y - 4.0], [x + 30.0, y - 4.0]], stroke);
        drawing.text([x + 36.0, y], 12.0, Anchor::Start, INK, label);
        x += 56.0 + font::width(label, 12.0);
    }
}

/// Numbered lines where steps begin; a number is left out where it would cover the one before.
fn marks(drawing: &mut Drawing, panel: &Panel, steps: &[StepMark]) {
    let mut free_from = f64::MIN;
    for (number, step) in (1..).zip(steps) {
        let label = format!("{number}");
        let [x, _] = panel.place([step.time_s, 0.0]);
        let half = 0.5 * font::width(&label, 10.0);
        let fits = x - half > free_from;
        panel.mark(drawing, step.time_s, fits.then_some(label.as_str()));
        if fits {
            free_from = x + half + 2.0;
        }
    }
}

impl Row<'_> {
    /// The tool's path, seen along an axis of the base frame.
    fn view(
        &self,
        drawing: &mut Drawing,
        place: (f64, f64),
        (title, x_name, y_name): (&str, &str, &str),
        [across, up]: [usize; 2],
    ) {
        let project = |point: &[f64; 3]| -> [f64; 2] {
            [across, up].map(|axis| point.get(axis).copied().unwrap_or_default())
        };
        let setpoints = &self.robot.tool_setpoint_m;
        let actuals = &self.robot.tool_actual_m;
        let all = || setpoints.iter().chain(actuals).map(project);
        let x = Range::of(all().map(|[x, _]| x)).padded(0.08, 0.01);
        let y = Range::of(all().map(|[_, y]| y)).padded(0.08, 0.01);
        let panel = self.panel(place, x, y).with_equal_scales();
        panel.axes(drawing, title, x_name, y_name);
        let wide = Stroke::solid(axis_colour(0).faint(0.5), 2.4);
        panel.line(drawing, setpoints.iter().map(project), wide);
        let thin = Stroke::dashed(INK, 1.0);
        panel.line(drawing, actuals.iter().map(project), thin);
        let mut taken: Option<f64> = None;
        for (point, label, colour) in [
            (setpoints.first(), "begin", axis_colour(2)),
            (setpoints.last(), "end", axis_colour(1)),
        ] {
            let at = point.map(project);
            let Some(at) = at.filter(|p| p.iter().all(|v| finite(*v))) else {
                continue;
            };
            let [x, y] = panel.place(at);
            drawing.shapes.push(Shape::Disc([x, y], 4.0, colour));
            // the two names must not cover each other, nor leave the frame
            let y = match taken {
                Some(other) if (y - other).abs() < 13.0 => other + 13.0,
                _ => y,
            };
            taken = Some(y);
            if x + 45.0 > panel.left + panel.width {
                drawing.text([x - 7.0, y + 4.0], 11.0, Anchor::End, INK, label);
            } else {
                drawing.text([x + 7.0, y + 4.0], 11.0, Anchor::Start, INK, label);
            }
        }
    }
}
