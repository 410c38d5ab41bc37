//! A board as a map of heights, and what a cutter that is moved through it leaves.
//!
//! The frame of the board has its origin at the lower left corner of the board's top, x and y along its edges
//! and z up: the top is z = 0, the bottom z = −thickness. The z axis of a tool's frame points out of the
//! spindle towards the tip, which is its origin: a tool that stands upright on the board has the z axis (0, 0, −1).
//!
//! A cell of the map is the height at the cell's centre, exact to the rounding of `f32` (0.5 nm at a
//! depth of 8 mm): so an edge of a cut is known to half a cell. Cutting takes the least of heights,
//! so the order of cuts does not matter. Nothing here reads a clock or a random source.

mod sweep;
#[cfg(test)]
mod test;
mod tilted;
mod tool;
mod vertical;

pub use self::tool::{Cutter, LARGEST_M, Shank, Tool, ToolError};

use self::sweep::{Row, Sweep};
use self::tilted::TiltedTool;
use self::vertical::VerticalSweep;
use motion::Pose;

/// The usual size of a cell, m.
pub const CELL_M: f64 = 1e-4;
/// The smallest cell, m.
pub const SMALLEST_CELL_M: f64 = 2e-5;
/// The most cells of a board: at 4 bytes each, 128 MiB. 500 × 600 mm at the usual size are 30 million.
pub const MAX_CELLS: usize = 1 << 25;
/// The greatest thickness of a board, m.
pub const THICKEST_M: f64 = 1.0;
/// Tools farther than this from the origin of the board, along any axis, are a mistake, m.
pub const FARTHEST_M: f64 = 10.0;
/// Below this tilt, its sine, a tool is taken as vertical, with its true tip: 1°.
const UPRIGHT: f64 = 0.017_452;
/// The greatest tilt of a tool that touches the board, as its cosine: 60°.
const LEANING: f64 = 0.5;
/// A plunge is taken in pieces no deeper than this, m: contact of the shank is found to this depth.
const PIECE_M: f64 = 1e-4;
/// The most pieces of a plunge: 2·[`FARTHEST_M`] of depth.
const MAX_PIECES: u32 = 200_000;
/// The most poses of a tilted move: 2·√3·[`FARTHEST_M`] at half the smallest cell, and a turn.
const MAX_POSES: u32 = 1 << 22;
/// What a rounding may make of touching, m.
const TOUCH_M: f64 = 1e-6;
/// An axis of a rotation is this nearly a unit vector, or no axis.
const UNIT: f64 = 1e-3;

/// A rectangular board.
#[derive(Clone, Debug, PartialEq)]
pub struct Board {
    columns: usize,
    rows: usize,
    cell_m: f64,
    thickness_m: f64,
    heights: Vec<f32>,
}

/// Why there is no such board.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum BoardError {
    /// The length of a cell.
    #[error("cell of a board: expected {SMALLEST_CELL_M} to 0.1 m, got {0} m")]
    Cell(f64),
    /// The thickness.
    #[error("thickness of a board: expected more than 0 and at most {THICKEST_M} m, got {0} m")]
    Thickness(f64),
    /// A side is shorter than half a cell, or is no length, or there are too many cells.
    #[error(
        "size of a board: expected at least a cell, and at most {MAX_CELLS} cells, got {size_m:?} m in cells of {cell_m} m"
    )]
    Size {
        /// Sides along x and y, m.
        size_m: [f64; 2],
        /// Side of a cell, m.
        cell_m: f64,
    },
}

/// Why a move cannot be simulated; the board is as it was.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CutError {
    /// A number of a pose is not finite.
    #[error("pose of a tool: expected finite numbers")]
    NotFinite,
    /// The tip is too far away.
    #[error("pose of a tool: expected at most {FARTHEST_M} m from the origin of the board")]
    TooFar,
    /// The third column of the rotation is no unit vector.
    #[error("pose of a tool: expected a rotation")]
    NotARotation,
    /// The tool leans by more than 60°, near enough to the board to touch it.
    #[error("tilt of a tool in the board: expected at most 60°")]
    Tilt,
}

/// What a move did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cut {
    /// Volume of the board that is gone now and was not before, m³.
    pub removed_m3: f64,
    /// How far below the top of the board the cutting end was at its deepest over the board, m; 0 if nowhere.
    pub depth_m: f64,
    /// How many cells were looked at.
    pub cells: u64,
    /// The cutting end was below the bottom of the board: where by most.
    pub through: Option<Contact>,
    /// The shank or the holder was in the board: where by most.
    pub collision: Option<Contact>,
}

/// Where something was that should not have been.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The lowest point of the tool over the cell's centre, board frame, m.
    pub at_m: [f64; 3],
    /// By how much, m.
    pub overlap_m: f64,
}

impl Board {
    /// An uncut board. The sides are rounded to whole cells; it takes 4 bytes a cell.
    ///
    /// # Errors
    /// [`BoardError`]
    pub fn new(size_m: [f64; 2], thickness_m: f64, cell_m: f64) -> Result<Self, BoardError> {
        if !(SMALLEST_CELL_M..=0.1).contains(&cell_m) {
            return Err(BoardError::Cell(cell_m));
        }
        if !(thickness_m > 0.0 && thickness_m <= THICKEST_M) {
            return Err(BoardError::Thickness(thickness_m));
        }
        let wrong = BoardError::Size { size_m, cell_m };
        let [columns, rows] = size_m.map(|side| whole(libm::round(side / cell_m)));
        let cells = columns.checked_mul(rows).ok_or(wrong)?;
        if cells == 0 || cells > MAX_CELLS {
            return Err(wrong);
        }
        Ok(Self {
            columns,
            rows,
            cell_m,
            thickness_m,
            heights: vec![0.0; cells],
        })
    }

    /// Sides along x and y, m.
    #[must_use]
    pub fn size_m(&self) -> [f64; 2] {
        [self.columns, self.rows].map(|n| number(n) * self.cell_m)
    }

    /// Thickness, m.
    #[must_use]
    pub const fn thickness_m(&self) -> f64 {
        self.thickness_m
    }

    /// Side of a cell, m.
    #[must_use]
    pub const fn cell_m(&self) -> f64 {
        self.cell_m
    }

    /// How many cells there are along x.
    #[must_use]
    pub const fn columns(&self) -> usize {
        self.columns
    }

    /// Heights at the centres of the cells, m: 0 where it is uncut, −thickness where nothing is left. Row after row, x
    /// growing within a row and y from row to row; the first is the cell at the origin.
    #[must_use]
    pub fn heights(&self) -> &[f32] {
        &self.heights
    }

    /// Volume that is gone, m³.
    #[must_use]
    pub fn removed_m3(&self) -> f64 {
        let depth: f64 = self.heights.iter().map(|h| -f64::from(*h)).sum();
        depth * self.cell_m * self.cell_m
    }

    /// The map as one number, FNV-1a of 64 bits over columns and heights: equal maps have equal
    /// numbers on every machine; it is no defence against anybody.
    #[must_use]
    pub fn digest(&self) -> u64 {
        let columns = u64::try_from(self.columns).unwrap_or(u64::MAX);
        let heights = self.heights.iter().flat_map(|h| h.to_le_bytes());
        let bytes = columns.to_le_bytes().into_iter().chain(heights);
        bytes.fold(0xCBF2_9CE4_8422_2325, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01B3)
        })
    }

    /// Lowers the map to the surface that the tool sweeps from one pose to the next, both in the board frame.
    ///
    /// The tip moves on the straight line between them. While the axis stays within 1° of vertical it is
    /// taken as vertical, and the surface is the exact minimum over the move; beyond, it is the exact
    /// minimum over poses no more than half a cell of any point of the cutting end apart, the axis turning
    /// in proportion. What is beyond the edges of the board is ignored, and so is a tool above it.
    /// Contact of shank and holder is found to 0.1 mm of depth of a vertical tool, to a cell of a tilted one.
    ///
    /// # Errors
    /// [`CutError`]; the board is as it was.
    pub fn cut(&mut self, tool: &Tool, from: &Pose, to: &Pose) -> Result<Cut, CutError> {
        let (from, to) = (Stance::of(from)?, Stance::of(to)?);
        let mut cut = Cut::default();
        if from.tilt() <= UPRIGHT && to.tilt() <= UPRIGHT && from.up[2] > 0.0 && to.up[2] > 0.0 {
            self.cut_upright(tool, from.tip, to.tip, &mut cut);
        } else if from.up[2] >= LEANING && to.up[2] >= LEANING {
            self.cut_tilted(tool, &from, &to, &mut cut);
        } else {
            let lowest = if to.tip[2] < from.tip[2] {
                to.tip[2]
            } else {
                from.tip[2]
            };
            // nothing of a tool is farther from its tip than its own size
            if lowest < tool.reach_m() {
                return Err(CutError::Tilt);
            }
        }
        Ok(cut)
    }

    fn cut_upright(&mut self, tool: &Tool, from: [f64; 3], to: [f64; 3], cut: &mut Cut) {
        let lower = if to[2] < from[2] { to[2] } else { from[2] };
        let upper = if to[2] < from[2] { from[2] } else { to[2] };
        // only where the shank can be below the top does it matter in which order the move cuts
        let watched = lower + tool.shank.cutting_length_m < 0.0;
        let pieces = if watched {
            count(libm::ceil((upper - lower) / PIECE_M), MAX_PIECES)
        } else {
            1
        };
        let at = |k: u32| blend(from, to, f64::from(k) / f64::from(pieces));
        for k in 0..pieces {
            if let Some(sweep) = VerticalSweep::new(tool, at(k), at(k + 1)) {
                self.lower(&sweep, TOUCH_M, cut);
            }
        }
    }

    fn cut_tilted(&mut self, tool: &Tool, from: &Stance, to: &Stance, cut: &mut Cut) {
        let turn = distance(from.up, to.up) * (tool.shank.cutting_length_m + tool.radius_m);
        let way = distance(from.tip, to.tip) + turn;
        let steps = count(libm::ceil(2.0 * way / self.cell_m), MAX_POSES);
        for k in 0..=steps {
            let share = f64::from(k) / f64::from(steps);
            let up = blend(from.up, to.up, share);
            let length = distance(up, [0.0; 3]);
            let up = up.map(|v| v / length);
            let tip = blend(from.tip, to.tip, share);
            if let Some(sweep) = TiltedTool::new(tool, tip, up) {
                self.lower(&sweep, self.cell_m, cut);
            }
        }
    }

    /// The map becomes the least of itself and the sweep; `slack` is what a guard may be inside it.
    fn lower(&mut self, sweep: &impl Sweep, slack: f64, cut: &mut Cut) {
        let (cell, bottom) = (self.cell_m, -self.thickness_m);
        let rows = cells(sweep.rows(), cell, self.rows);
        for row in rows {
            let y = (number(row) + 0.5) * cell;
            let columns = cells(sweep.columns(y), cell, self.columns);
            let first = columns.start;
            let begin = row * self.columns;
            let Some(heights) = self.heights.get_mut(begin + first..begin + columns.end) else {
                continue;
            };
            cut.cells += u64::try_from(heights.len()).unwrap_or(0);
            for (column, height) in (first..).zip(heights) {
                let x = (number(column) + 0.5) * cell;
                let before = f64::from(*height);
                let guard = sweep.guard(x, y);
                deepest(&mut cut.collision, [x, y, guard], before - guard, slack);
                let surface = sweep.cutter(x, y);
                if -surface > cut.depth_m {
                    cut.depth_m = -surface;
                }
                if surface >= before {
                    continue;
                }
                deepest(&mut cut.through, [x, y, surface], bottom - surface, TOUCH_M);
                *height = narrow(if surface > bottom { surface } else { bottom });
                cut.removed_m3 += (before - f64::from(*height)) * cell * cell;
            }
        }
    }
}

/// Keeps the contact that overlaps most, the first of equals.
fn deepest(known: &mut Option<Contact>, at_m: [f64; 3], overlap_m: f64, slack: f64) {
    if overlap_m > known.map_or(slack, |contact| contact.overlap_m) {
        *known = Some(Contact { at_m, overlap_m });
    }
}

/// A pose of a tool: where its tip is, and where its shank.
#[derive(Clone, Copy, Debug)]
struct Stance {
    tip: [f64; 3],
    /// Unit vector from the tip to the shank.
    up: [f64; 3],
}

impl Stance {
    fn of(pose: &Pose) -> Result<Self, CutError> {
        let (p, r) = (&pose.position, &pose.rotation);
        let (tip, axis) = ([p.x, p.y, p.z], [-r.m13, -r.m23, -r.m33]);
        if tip.iter().chain(&axis).any(|v| !v.is_finite()) {
            return Err(CutError::NotFinite);
        }
        if tip.iter().any(|v| v.abs() > FARTHEST_M) {
            return Err(CutError::TooFar);
        }
        let length = distance(axis, [0.0; 3]);
        if (length - 1.0).abs() > UNIT {
            return Err(CutError::NotARotation);
        }
        let up = axis.map(|v| v / length);
        Ok(Self { tip, up })
    }

    /// The sine of the tilt of the axis.
    fn tilt(&self) -> f64 {
        libm::sqrt(self.up[0] * self.up[0] + self.up[1] * self.up[1])
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let [x, y, z] = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    libm::sqrt(x * x + y * y + z * z)
}

fn blend(a: [f64; 3], b: [f64; 3], share: f64) -> [f64; 3] {
    let of = |a: f64, b: f64| a * (1.0 - share) + b * share;
    [of(a[0], b[0]), of(a[1], b[1]), of(a[2], b[2])]
}

/// The cells whose centres are in a range, of `all` from 0.
fn cells(range: Row, cell: f64, all: usize) -> core::ops::Range<usize> {
    // centres are at (n + ½)·cell
    let first = whole(libm::ceil(range.lower / cell - 0.5));
    let end = whole(libm::floor(range.upper / cell - 0.5) + 1.0);
    let end = if end < all { end } else { all };
    (if first < end { first } else { end })..end
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "`as` saturates: what is below 0 or no number becomes 0"
)]
fn whole(value: f64) -> usize {
    value as usize
}

/// At least 1 and at most `most`.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "`as` saturates: what is below 0 or no number becomes 0"
)]
fn count(value: f64, most: u32) -> u32 {
    (value as u32).clamp(1, most)
}

#[expect(
    clippy::cast_precision_loss,
    reason = "at most MAX_CELLS, far below 2^53"
)]
fn number(value: usize) -> f64 {
    value as f64
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "heights of at most a metre, to 24 bits"
)]
fn narrow(value: f64) -> f32 {
    value as f32
}
