//! A planned motion over time: position, velocity, acceleration and jerk, one below the other.

use super::drawing::{Anchor, Colour, Drawing, INK, SOFT_INK, Shape, Stroke, axis_colour};
use super::font;
use super::panel::Panel;
use super::scale::{Range, finite};
use ::motion::profile::{AxisBounds, Phase, State};

#[cfg(test)]
mod test;

/// What to draw of a planned motion.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MotionPlot {
    /// Above everything.
    pub title: String,
    /// The unit of positions, as it is printed: `rad`.
    pub unit: String,
    /// One per axis.
    pub axes: Vec<AxisMotion>,
}

/// The motion of one axis.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisMotion {
    /// Its name.
    pub name: String,
    /// Its phases in order, the first at time 0.
    pub phases: Vec<Phase>,
    /// Its limits: drawn as thin lines where the motion comes near them.
    pub bounds: AxisBounds,
}

pub(super) const WIDTH: f64 = 1120.0;
pub(super) const LEFT: f64 = 92.0;
/// Right of the diagrams is room for the values of the limits.
pub(super) const PANEL_WIDTH: f64 = 936.0;
pub(super) const PANEL_HEIGHT: f64 = 172.0;
pub(super) const PITCH: f64 = 190.0;
const LEGEND_TOP: f64 = 62.0;
const LEGEND_PITCH: f64 = 20.0;
/// A limit this many times as far away as the motion ever comes would make the motion flat.
const NEAR: f64 = 2.0;
/// Height of a line of small print.
const SMALL_LINE: f64 = 12.0;
/// Points of a curve over the whole width, and least within a phase.
const POINTS: f64 = 400.0;
const POINTS_OF_A_PHASE: u16 = 8;

/// One of the four diagrams.
struct Quantity {
    name: &'static str,
    per: &'static str,
    of: fn(&State) -> f64,
    limits: fn(&AxisBounds) -> [f64; 2],
}

const QUANTITIES: [Quantity; 4] = [
    Quantity {
        name: "position",
        per: "",
        of: |state| state.p,
        limits: |bounds| [bounds.p_min, bounds.p_max],
    },
    Quantity {
        name: "velocity",
        per: "/s",
        of: |state| state.v,
        limits: |bounds| [bounds.v_min, bounds.v_max],
    },
    Quantity {
        name: "acceleration",
        per: "/s²",
        of: |state| state.a,
        limits: |bounds| [bounds.a_min, bounds.a_max],
    },
    Quantity {
        name: "jerk",
        per: "/s³",
        of: |state| state.j,
        limits: |bounds| [-bounds.j_max, bounds.j_max],
    },
];

pub(super) fn lay_out(data: &MotionPlot) -> Drawing {
    let mut drawing = Drawing {
        width: WIDTH,
        ..Drawing::default()
    };
    drawing.title(&data.title);
    let names = data.axes.iter().map(|axis| axis.name.as_str());
    let mut top = legend(&mut drawing, names, true) + 20.0;
    let curves: Vec<Vec<(f64, State)>> = data.axes.iter().map(curve).collect();
    let ends = curves.iter().flatten().map(|(t, _)| *t);
    let time = Range::of(ends.chain([0.0])).padded(0.0, 1e-6);
    for (number, quantity) in QUANTITIES.iter().enumerate() {
        let diagram = Diagram {
            data,
            curves: &curves,
            quantity,
        };
        diagram.draw(&mut drawing, top, time, number + 1 == QUANTITIES.len());
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

/// Eight colours, and dashes where they come round again.
pub(super) fn stroke(axis: usize) -> Stroke {
    let colour = axis_colour(axis);
    if axis < 8 {
        Stroke::solid(colour, 2.0)
    } else {
        Stroke::dashed(colour, 2.0)
    }
}

/// The names of the axes, and what a thin line is if there are any; the bottom of it all.
pub(super) fn legend<'a>(
    drawing: &mut Drawing,
    names: impl Iterator<Item = &'a str>,
    limits: bool,
) -> f64 {
    let limit = Stroke::dashed(SOFT_INK, 0.9);
    let names = names.enumerate();
    let entries = names.map(|(number, name)| (stroke(number), name.chars().take(24).collect()));
    let thin = limits.then(|| (limit, "limit".into()));
    let entries: Vec<(Stroke, String)> = entries.chain(thin).collect();
    let (mut x, mut y) = (LEFT, LEGEND_TOP);
    for (stroke, label) in entries {
        let width = 30.0 + font::width(&label, 12.0);
        if x > LEFT && x + width > LEFT + PANEL_WIDTH {
            (x, y) = (LEFT, y + LEGEND_PITCH);
        }
        drawing.line(vec![[x, y - 4.0], [x + 24.0, y - 4.0]], stroke);
        drawing.text([x + 30.0, y], 12.0, Anchor::Start, INK, label);
        x += width + 22.0;
    }
    y
}

/// States along a motion, both ends of every phase among them.
fn curve(axis: &AxisMotion) -> Vec<(f64, State)> {
    let duration: f64 = axis.phases.iter().map(|phase| phase.t).sum();
    let mut states = Vec::new();
    let mut begin = 0.0;
    for phase in &axis.phases {
        let pieces = pieces(phase.t / duration);
        for piece in 0..=pieces {
            let tau = phase.t * f64::from(piece) / f64::from(pieces);
            states.push((begin + tau, phase.at(tau)));
        }
        begin += phase.t;
    }
    states
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "at most POINTS; `as` saturates"
)]
fn pieces(share: f64) -> u16 {
    POINTS_OF_A_PHASE + (POINTS * share) as u16
}

struct Diagram<'a> {
    data: &'a MotionPlot,
    curves: &'a [Vec<(f64, State)>],
    quantity: &'a Quantity,
}

impl Diagram<'_> {
    fn draw(&self, drawing: &mut Drawing, top: f64, time: Range, last: bool) {
        let Quantity { name, per, of, .. } = self.quantity;
        let reached = Range::of(self.curves.iter().flatten().map(|(_, state)| of(state)));
        let limits = self.limits(reached);
        let all = [reached.lower, reached.upper].into_iter();
        let range = Range::of(all.chain(limits.iter().map(|(value, _)| *value)));
        let panel = Panel {
            left: LEFT,
            top,
            width: PANEL_WIDTH,
            height: PANEL_HEIGHT,
            x: time,
            y: visible(range),
        };
        let y_name = format!("{name} [{}{per}]", self.data.unit);
        panel.axes(drawing, "", if last { "time [s]" } else { "" }, &y_name);
        thin_lines(drawing, &panel, &limits);
        if let [axis] = self.data.axes.as_slice() {
            let mut end = 0.0;
            // the last ends where the frame does
            let inner = axis.phases.split_last().map_or(&[][..], |(_, inner)| inner);
            for phase in inner {
                end += phase.t;
                panel.mark(drawing, end, None);
            }
        }
        for (number, curve) in self.curves.iter().enumerate() {
            let points = curve.iter().map(|(t, state)| [*t, of(state)]);
            panel.line(drawing, points, stroke(number));
            if let Some((t, state)) = curve.last().filter(|(t, s)| finite(*t) && finite(of(s))) {
                let at = panel.place([*t, of(state)]);
                drawing
                    .shapes
                    .push(Shape::Disc(at, 3.0, axis_colour(number)));
            }
        }
    }

    /// Every limit near the motion once, from above: in grey, or in the colour of the one axis of several
    /// that has it.
    fn limits(&self, reached: Range) -> Vec<(f64, Colour)> {
        let room = NEAR * visible(reached).span();
        let near = |value: f64| value < reached.upper + room && value > reached.lower - room;
        let mut limits: Vec<(f64, Colour)> = Vec::new();
        let alone = self.data.axes.len() == 1;
        for (number, axis) in self.data.axes.iter().enumerate() {
            let own = if alone { SOFT_INK } else { axis_colour(number) };
            for value in (self.quantity.limits)(&axis.bounds) {
                let same = limits
                    .iter_mut()
                    .find(|(other, _)| other.to_bits() == value.to_bits());
                match same {
                    Some((_, colour)) => *colour = SOFT_INK,
                    None if finite(value) && near(value) => {
                        limits.push((value, own));
                    }
                    None => {}
                }
            }
        }
        limits.sort_by(|(a, _), (b, _)| b.total_cmp(a));
        limits
    }
}

/// The limits, and their values beside the frame where there is room for them.
pub(super) fn thin_lines(drawing: &mut Drawing, panel: &Panel, limits: &[(f64, Colour)]) {
    let mut free_from = f64::MIN;
    for (value, colour) in limits {
        let [x, y] = panel.place([panel.x.upper, *value]);
        let line = vec![[panel.left, y], [x, y]];
        drawing.line(line, Stroke::dashed(*colour, 0.9));
        if y >= free_from {
            let label = format!("{value}").replace('-', "−");
            let label: String = label.chars().take(12).collect();
            drawing.text([x + 8.0, y + 4.0], 10.0, Anchor::Start, *colour, label);
            free_from = y + SMALL_LINE;
        }
    }
}

/// With some room around it, and wide enough to have ticks where nothing changes.
pub(super) fn visible(range: Range) -> Range {
    let greatest = if -range.lower > range.upper {
        -range.lower
    } else {
        range.upper
    };
    let least = if greatest > 0.0 { 1e-3 * greatest } else { 1.0 };
    range.padded(0.07, least)
}
