//! What a sweep of a tool must say of itself so that a board can be lowered to it.

/// The solid swept in one move, seen from below: heights in the board frame, m.
pub(super) trait Sweep {
    /// The range of y outside which nothing is swept below the top of the board, m.
    fn rows(&self) -> Row;
    /// The range of x outside which nothing is swept at this y, m.
    fn columns(&self, y: f64) -> Row;
    /// The lowest height that the cutting end reaches above a point, m; infinite where it never is.
    fn cutter(&self, x: f64, y: f64) -> f64;
    /// The lowest height of what must not touch, m; infinite where it never is.
    fn guard(&self, x: f64, y: f64) -> f64;
}

/// A range of coordinates, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Row {
    pub(super) lower: f64,
    pub(super) upper: f64,
}

impl Row {
    /// From one coordinate to another, in either order, and a margin on both sides, m.
    pub(super) fn around(a: f64, b: f64, margin: f64) -> Self {
        let (lower, upper) = if a < b { (a, b) } else { (b, a) };
        Self {
            lower: lower - margin,
            upper: upper + margin,
        }
    }
}
