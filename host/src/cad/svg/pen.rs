//! Path data of SVG, segment by segment.

use super::Affine;
use crate::cad::nurbs::{Nurbs, NurbsError, ellipse};
use crate::cad::outline::Outline;
use crate::cad::step::distance;
use core::f64::consts::PI;
use svgtypes::PathSegment;

/// Where a path is, in units of its element.
pub(super) struct Pen {
    pub(super) at: [f64; 2],
    pub(super) start: [f64; 2],
    /// The last control point, mirrored.
    pub(super) mirror: Option<[f64; 2]>,
    /// Of a quadratic, not a cubic.
    pub(super) quadratic: bool,
}

impl Pen {
    pub(super) fn to(&self, absolute: bool, x: f64, y: f64) -> [f64; 2] {
        if absolute {
            [x, y]
        } else {
            [self.at[0] + x, self.at[1] + y]
        }
    }

    pub(super) fn draw(
        &mut self,
        segment: PathSegment,
        outline: &mut Outline,
        to: &Affine,
    ) -> Result<(), NurbsError> {
        let from = self.at;
        let mirror = self.mirror.take();
        let smooth = |quadratic| {
            mirror
                .filter(|_| self.quadratic == quadratic)
                .unwrap_or(from)
        };
        match segment {
            PathSegment::MoveTo { .. } => {}
            PathSegment::LineTo { abs, x, y } => self.line(self.to(abs, x, y), outline, to),
            PathSegment::HorizontalLineTo { abs, x } => {
                let x = if abs { x } else { from[0] + x };
                self.line([x, from[1]], outline, to);
            }
            PathSegment::VerticalLineTo { abs, y } => {
                let y = if abs { y } else { from[1] + y };
                self.line([from[0], y], outline, to);
            }
            PathSegment::CurveTo {
                abs,
                x1,
                y1,
                x2,
                y2,
                x,
                y,
            } => {
                let points = [
                    self.to(abs, x1, y1),
                    self.to(abs, x2, y2),
                    self.to(abs, x, y),
                ];
                self.cubic(points, outline, to)?;
            }
            PathSegment::SmoothCurveTo { abs, x2, y2, x, y } => {
                let points = [smooth(false), self.to(abs, x2, y2), self.to(abs, x, y)];
                self.cubic(points, outline, to)?;
            }
            PathSegment::Quadratic { abs, x1, y1, x, y } => {
                self.parabola(self.to(abs, x1, y1), self.to(abs, x, y), outline, to)?;
            }
            PathSegment::SmoothQuadratic { abs, x, y } => {
                self.parabola(smooth(true), self.to(abs, x, y), outline, to)?;
            }
            PathSegment::EllipticalArc {
                abs,
                rx,
                ry,
                x_axis_rotation,
                large_arc,
                sweep,
                x,
                y,
            } => {
                let arc = Elliptic {
                    radii: [rx.abs(), ry.abs()],
                    turned: x_axis_rotation * PI / 180.0,
                    large: large_arc,
                    sweep,
                };
                self.arc(&arc, self.to(abs, x, y), outline, to)?;
            }
            PathSegment::ClosePath { .. } => self.line(self.start, outline, to),
        }
        Ok(())
    }

    fn line(&mut self, end: [f64; 2], outline: &mut Outline, to: &Affine) {
        self.at = end;
        outline.line_to(to.point(end[0], end[1]));
    }

    fn cubic(
        &mut self,
        [a, b, end]: [[f64; 2]; 3],
        outline: &mut Outline,
        to: &Affine,
    ) -> Result<(), NurbsError> {
        let points = [self.at, a, b, end].map(|[x, y]| to.point(x, y));
        self.at = end;
        self.mirror = Some([2.0 * end[0] - b[0], 2.0 * end[1] - b[1]]);
        self.quadratic = false;
        bend(outline, &points, Nurbs::bezier(points)?);
        Ok(())
    }

    fn parabola(
        &mut self,
        middle: [f64; 2],
        end: [f64; 2],
        outline: &mut Outline,
        to: &Affine,
    ) -> Result<(), NurbsError> {
        let points = [self.at, middle, end].map(|[x, y]| to.point(x, y));
        self.at = end;
        self.mirror = Some([2.0 * end[0] - middle[0], 2.0 * end[1] - middle[1]]);
        self.quadratic = true;
        bend(
            outline,
            &points,
            Nurbs::clamped(3, points.map(|point| (point, 1.0)))?,
        );
        Ok(())
    }

    /// From ends to the centre: SVG 1.1, appendix F.6.5 and F.6.6.
    fn arc(
        &mut self,
        arc: &Elliptic,
        end: [f64; 2],
        outline: &mut Outline,
        to: &Affine,
    ) -> Result<(), NurbsError> {
        let from = self.at;
        let [mut rx, mut ry] = arc.radii;
        let (sin, cos) = (libm::sin(arc.turned), libm::cos(arc.turned));
        let half = [0.5 * (from[0] - end[0]), 0.5 * (from[1] - end[1])];
        let (u, v) = (cos * half[0] + sin * half[1], cos * half[1] - sin * half[0]);
        if !(rx > 0.0 && ry > 0.0) {
            self.line(end, outline, to);
            return Ok(());
        }
        if u.abs() + v.abs() <= 0.0 {
            return Ok(());
        }
        let short = (u / rx) * (u / rx) + (v / ry) * (v / ry);
        if short > 1.0 {
            rx *= libm::sqrt(short);
            ry *= libm::sqrt(short);
        }
        let (p, q) = (u / rx, v / ry);
        let square = p * p + q * q;
        let rest = 1.0 / square - 1.0;
        let side = if rest > 0.0 { libm::sqrt(rest) } else { 0.0 };
        let side = if arc.large == arc.sweep { -side } else { side };
        // the centre, in units of the radii
        let (cx, cy) = (side * q, -side * p);
        let first = libm::atan2(q - cy, p - cx);
        let mut angle = libm::atan2(-q - cy, -p - cx) - first;
        if arc.sweep && angle < 0.0 {
            angle += 2.0 * PI;
        } else if !arc.sweep && angle > 0.0 {
            angle -= 2.0 * PI;
        }
        let middle = [0.5 * (from[0] + end[0]), 0.5 * (from[1] + end[1])];
        let (x, y) = (cx * rx, cy * ry);
        let centre = to.point(middle[0] + cos * x - sin * y, middle[1] + sin * x + cos * y);
        let (a, b) = (
            to.vector(cos * rx, sin * rx),
            to.vector(-sin * ry, cos * ry),
        );
        for curve in ellipse(&centre, &a, &b, first, angle)? {
            outline.curve(curve);
        }
        self.at = end;
        Ok(())
    }
}

/// An arc of an ellipse, as path data have it.
struct Elliptic {
    radii: [f64; 2],
    turned: f64,
    large: bool,
    sweep: bool,
}

/// A curve, unless all of its points are one.
fn bend(outline: &mut Outline, points: &[[f64; 3]], curve: Nurbs) {
    let from = outline.end();
    if points.iter().any(|point| distance(&from, point) > 0.0) {
        outline.curve(curve);
    }
}
