//! Where a program is on the board, and how large.
//!
//! The frame of the board has its x and y along two edges from the corner at its origin, and z out of
//! the surface that is engraved. `fit` makes the cuts of the program as large as the board without its margins
//! admits, never larger than they are unless asked, and centres them; a scale of the task's leaves the
//! program's origin in that of the board. Across the surface there is a scale of its own.

use super::Options;
use super::step::get;
use serde::Serialize;

/// How large the program becomes, and where it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Placement {
    /// So many times as large; the program's origin is that of the board.
    Scale(f64),
    /// Within a board.
    Fit {
        /// Width and height of the board, m.
        board_m: [f64; 2],
        /// What stays free along every edge, m.
        margin_m: f64,
        /// Also larger than it is.
        enlarge: bool,
    },
}

/// The scale across the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ZRule {
    /// That of the plane.
    AsPlane,
    /// So many times.
    Scale(f64),
    /// The deepest cut is so many metres deep: cuts below the surface are scaled; a program that cuts at z of the
    /// surface is lowered, and z scaled as the plane.
    Depth(f64),
}

/// A box along the axes; empty, until something is in it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Extent {
    /// The least coordinates, m.
    pub least_m: [f64; 3],
    /// The greatest, m.
    pub greatest_m: [f64; 3],
}

impl Extent {
    /// Around nothing.
    pub const EMPTY: Self = Self {
        least_m: [f64::INFINITY; 3],
        greatest_m: [f64::NEG_INFINITY; 3],
    };

    /// Holds a point too.
    pub fn add(&mut self, point: &[f64; 3]) {
        let ends = self.least_m.iter_mut().zip(&mut self.greatest_m);
        for ((least, greatest), x) in ends.zip(point) {
            if *x < *least {
                *least = *x;
            }
            if *x > *greatest {
                *greatest = *x;
            }
        }
    }

    /// Does it hold anything?
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.least_m
            .iter()
            .zip(&self.greatest_m)
            .any(|(a, b)| a > b)
    }

    fn size(&self, axis: usize) -> f64 {
        get(&self.greatest_m, axis) - get(&self.least_m, axis)
    }
}

/// From the program to the board.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Place {
    /// Times x and y.
    pub scale: f64,
    /// Times z.
    pub z_scale: f64,
    /// Then so much is added, m.
    pub offset_m: [f64; 3],
}

/// A thinner board, or a lower program, counts as this, m.
const NOTHING_M: f64 = 1e-9;

impl Place {
    /// The place of a program whose cuts are in a box.
    pub(super) fn of(cuts: &Extent, options: &Options) -> Self {
        let (scale, centre) = match options.placement {
            Placement::Scale(scale) => (scale, None),
            Placement::Fit {
                board_m,
                margin_m,
                enlarge,
            } => {
                let mut scale = if enlarge { f64::INFINITY } else { 1.0 };
                for (axis, edge) in board_m.iter().enumerate() {
                    let (free, size) = (edge - 2.0 * margin_m, cuts.size(axis));
                    if size > NOTHING_M && free / size < scale {
                        scale = free / size;
                    }
                }
                (if scale.is_finite() { scale } else { 1.0 }, Some(board_m))
            }
        };
        let deepest = options.surface_m - get(&cuts.least_m, 2);
        let z_scale = match options.z {
            ZRule::Scale(scale) => scale,
            ZRule::Depth(depth) if deepest > NOTHING_M => depth / deepest,
            ZRule::AsPlane | ZRule::Depth(_) => scale,
        };
        let lowered = match options.z {
            ZRule::Depth(depth) if deepest <= NOTHING_M => depth - z_scale * deepest,
            _ => 0.0,
        };
        let mut offset_m = [0.0, 0.0, -z_scale * options.surface_m - lowered];
        if let Some(board) = centre.filter(|_| !cuts.is_empty()) {
            for (axis, (offset, edge)) in offset_m.iter_mut().zip(board).enumerate() {
                let middle = 0.5 * (get(&cuts.least_m, axis) + get(&cuts.greatest_m, axis));
                *offset = 0.5 * edge - scale * middle;
            }
        }
        Self {
            scale,
            z_scale,
            offset_m,
        }
    }

    /// A point of the program on the board, m.
    #[must_use]
    pub fn map(&self, point: &[f64; 3]) -> [f64; 3] {
        let [x, y, z] = *point;
        let [dx, dy, dz] = self.offset_m;
        [
            self.scale * x + dx,
            self.scale * y + dy,
            self.z_scale * z + dz,
        ]
    }

    /// A box of the program on the board.
    #[must_use]
    pub fn extent(&self, of: &Extent) -> Extent {
        if of.is_empty() {
            return Extent::EMPTY;
        }
        Extent {
            least_m: self.map(&of.least_m),
            greatest_m: self.map(&of.greatest_m),
        }
    }

    /// Do circles of this plane stay circles?
    pub(super) fn keeps_circles(&self, across: usize) -> bool {
        across == 2 || (self.scale - self.z_scale).abs() <= 1e-12 * self.scale
    }
}

#[cfg(test)]
mod test {
    use super::*;

    /// Cuts between two heights of the program, m.
    fn between(least: f64, greatest: f64) -> Extent {
        Extent {
            least_m: [0.0, 0.0, least],
            greatest_m: [0.1, 0.1, greatest],
        }
    }

    #[test]
    fn the_deepest_cut_is_as_deep_as_asked_wherever_the_program_has_its_zero() {
        for (least, greatest, surface) in [
            (-0.003, 0.0, 0.0),
            (0.0, 0.0, 0.0),
            (0.027, 0.053, 0.0),
            (0.036, 0.053, 0.0508),
        ] {
            let options = Options {
                z: ZRule::Depth(4e-4),
                surface_m: surface,
                ..Options::default()
            };
            let cuts = between(least, greatest);
            let board = Place::of(&cuts, &options).extent(&cuts);
            // roundings of centimetres
            assert!(
                (get(&board.least_m, 2) + 4e-4).abs() < 1e-16,
                "{least} {surface}"
            );
        }
    }
}
