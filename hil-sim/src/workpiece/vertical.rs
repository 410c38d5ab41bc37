//! The surface that a tool with a vertical axis sweeps on a straight line, in closed form.
//!
//! Above a point at the distance w beside the line, the tip that has passed it by q is at the
//! height z(q) = const − s·q, s the slope of the line, and the surface of the tool is at
//! g(q) = −s·q + h(√(q² + w²)) above it. The profile h is convex and does not fall, so g is convex:
//! its least value on the part of the line that reaches the point is at the free minimum moved into it.
//!
//! - flat: h = 0, so the end of the part towards which the line falls.
//! - ball: q/√(R² − w² − q²) = s, so q = s·√((R² − w²)/(1 + s²)).
//! - V with the slope k: k·q/√(q² + w²) = s, so q = s·w/√(k² − s²); not before the edge of the flat tip,
//!   √(r₀² − w²), and never if |s| ≥ k.

use super::sweep::{Row, Sweep};
use super::tool::{Profile, Tool};

/// Shorter lines are points, m.
const SHORT_M: f64 = 1e-9;

/// A straight move of a tool with a vertical axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct VerticalSweep<'a> {
    tool: &'a Tool,
    from: [f64; 3],
    /// Direction over the board; zero for a plunge.
    along: [f64; 2],
    /// Length over the board, m.
    length: f64,
    /// Rise from end to end, m.
    rise: f64,
    /// Distance from the line within which there is anything to do, m.
    reach: f64,
    /// Is the shank, at the higher end, below the top of the board?
    guards: bool,
}

impl<'a> VerticalSweep<'a> {
    /// The move of the tip between two points of the board frame, m; none if it stays above the board.
    pub(super) fn new(tool: &'a Tool, from: [f64; 3], to: [f64; 3]) -> Option<Self> {
        let [dx, dy, rise] = [to[0] - from[0], to[1] - from[1], to[2] - from[2]];
        let lowest = from[2] + if rise < 0.0 { rise } else { 0.0 };
        if lowest >= 0.0 {
            return None;
        }
        let length = libm::sqrt(dx * dx + dy * dy);
        let (length, along) = if length < SHORT_M {
            (0.0, [0.0, 0.0])
        } else {
            (length, [dx / length, dy / length])
        };
        let highest = from[2] + if rise > 0.0 { rise } else { 0.0 };
        let shank = &tool.shank;
        let mut reach = tool.radius_at_m(-lowest);
        let guards = highest + shank.cutting_length_m < 0.0;
        for (height, diameter) in [
            (shank.cutting_length_m, shank.diameter_m),
            (shank.stick_out_m, shank.holder_diameter_m),
        ] {
            if highest + height < 0.0 && 0.5 * diameter > reach {
                reach = 0.5 * diameter;
            }
        }
        Some(Self {
            tool,
            from,
            along,
            length,
            rise,
            reach,
            guards,
        })
    }

    /// How far along the line a point lies, and its distance from the line, squared.
    fn place(&self, x: f64, y: f64) -> (f64, f64) {
        let (dx, dy) = (x - self.from[0], y - self.from[1]);
        let [ax, ay] = self.along;
        let u = dx * ax + dy * ay;
        if self.length == 0.0 {
            return (0.0, dx * dx + dy * dy);
        }
        let w = dx * ay - dy * ax;
        (u, w * w)
    }

    /// By how much the tip has passed the point where the surface above it is least, unbounded.
    fn best(&self, w2: f64, slope: f64) -> f64 {
        let r2 = self.tool.radius_m * self.tool.radius_m;
        if slope == 0.0 {
            return 0.0;
        }
        match self.tool.profile {
            Profile::Flat => slope * f64::INFINITY,
            Profile::Ball => slope * libm::sqrt((r2 - w2) / (1.0 + slope * slope)),
            Profile::V {
                tip_radius_m,
                slope: k,
            } => {
                let steep = k * k - slope * slope;
                if steep <= 0.0 {
                    return slope * f64::INFINITY;
                }
                let cone = slope.abs() * libm::sqrt(w2 / steep);
                let tip2 = tip_radius_m * tip_radius_m - w2;
                let tip = if tip2 > 0.0 { libm::sqrt(tip2) } else { 0.0 };
                libm::copysign(if tip > cone { tip } else { cone }, slope)
            }
        }
    }

    /// The squared distance of a point from the line between its ends.
    fn distance2(&self, x: f64, y: f64) -> f64 {
        let (u, w2) = self.place(x, y);
        let beyond = if u < 0.0 {
            u
        } else if u > self.length {
            u - self.length
        } else {
            0.0
        };
        w2 + beyond * beyond
    }
}

impl Sweep for VerticalSweep<'_> {
    fn rows(&self) -> Row {
        let end = self.from[1] + self.along[1] * self.length;
        Row::around(self.from[1], end, self.reach)
    }

    fn columns(&self, y: f64) -> Row {
        let [ax, ay] = self.along;
        let (mut first, mut last) = (0.0, self.length);
        // the part of the line that is near enough to this row
        if ay.abs() > 1e-6 {
            let a = (y - self.reach - self.from[1]) / ay;
            let b = (y + self.reach - self.from[1]) / ay;
            let (a, b) = if a < b { (a, b) } else { (b, a) };
            first = if a > first { a } else { first };
            last = if b < last { b } else { last };
        }
        Row::around(
            self.from[0] + ax * first,
            self.from[0] + ax * last,
            self.reach,
        )
    }

    fn cutter(&self, x: f64, y: f64) -> f64 {
        let (u, w2) = self.place(x, y);
        let radius = self.tool.radius_m;
        let room = radius * radius - w2;
        if room < 0.0 {
            return f64::INFINITY;
        }
        let room = libm::sqrt(room);
        let (mut least, mut most) = (-room, room);
        if u - self.length > least {
            least = u - self.length;
        }
        if u < most {
            most = u;
        }
        if self.length == 0.0 {
            let lower = if self.rise < 0.0 { self.rise } else { 0.0 };
            return self.from[2] + lower + self.tool.height_m(libm::sqrt(w2)).unwrap_or(0.0);
        }
        if least > most {
            return f64::INFINITY;
        }
        let free = self.best(w2, self.rise / self.length);
        let q = if free < least {
            least
        } else if free > most {
            most
        } else {
            free
        };
        let tip = self.from[2] + self.rise * ((u - q) / self.length);
        let r = libm::sqrt(q * q + w2);
        // at the rim, rounding may put the point beyond it
        let r = if r > radius { radius } else { r };
        tip + self.tool.height_m(r).unwrap_or(0.0)
    }

    fn guard(&self, x: f64, y: f64) -> f64 {
        if !self.guards {
            return f64::INFINITY;
        }
        let shank = &self.tool.shank;
        let highest = self.from[2] + if self.rise > 0.0 { self.rise } else { 0.0 };
        let distance2 = 4.0 * self.distance2(x, y);
        if distance2 <= shank.diameter_m * shank.diameter_m {
            highest + shank.cutting_length_m
        } else if distance2 <= shank.holder_diameter_m * shank.holder_diameter_m {
            highest + shank.stick_out_m
        } else {
            f64::INFINITY
        }
    }
}
