//! How a cut board looks: wood, lit from the upper left, darker where it is deep and where no light comes.

/// Towards the light: from the left, from above on the paper, out of the paper. Not normalised.
const LIGHT: [f64; 3] = [-0.55, 0.62, 0.9];
/// What a face turned away from the light still gets.
const AMBIENT: f64 = 0.46;
/// What of the light is kept in a shadow.
const SHADOW: f64 = 0.66;
/// Steps towards the light in which a shadow is looked for.
const SHADOW_STEPS: u8 = 14;
/// Samples along a side of a pixel, at most: cells are averaged, not missed.
const SAMPLES: u8 = 3;
/// Wood across: two colours of the grain, and of what the cutter left.
const LIGHT_WOOD: [f64; 3] = [233.0, 199.0, 148.0];
const DARK_WOOD: [f64; 3] = [206.0, 160.0, 104.0];
const FRESH_CUT: [f64; 3] = [204.0, 146.0, 90.0];
const DEEP_CUT: [f64; 3] = [118.0, 68.0, 34.0];

/// A map of heights to look at.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surface<'a> {
    heights: &'a [f32],
    columns: usize,
    rows: usize,
    size_m: [f64; 2],
    /// m, 0 or more.
    deepest: f64,
}

impl<'a> Surface<'a> {
    pub(super) fn new(heights: &'a [f32], columns: usize, size_m: [f64; 2]) -> Self {
        let rows = heights.len().checked_div(columns).unwrap_or(0);
        let deepest = heights
            .iter()
            .map(|h| -f64::from(*h))
            .filter(|depth| depth.is_finite())
            .fold(0.0, |a, b| if b > a { b } else { a });
        Self {
            heights,
            columns,
            rows,
            size_m,
            deepest,
        }
    }

    /// How far below the top, m.
    pub(super) fn deepest_m(&self) -> f64 {
        self.deepest
    }

    /// The colours of a picture of the whole board, row after row from above.
    pub(super) fn pixels(&self, columns: u32, rows: u32) -> Vec<[u8; 3]> {
        let step = [
            self.size_m[0] / f64::from(columns),
            self.size_m[1] / f64::from(rows),
        ];
        let samples = self.samples(columns);
        let share = 1.0 / f64::from(samples);
        let mut pixels = Vec::new();
        for row in 0..rows {
            for column in 0..columns {
                let middle = [column, row].map(|k| f64::from(k) + 0.5);
                // the grain is coarser than a pixel
                let wood = self.wood(step[0] * middle[0], self.size_m[1] - step[1] * middle[1]);
                let mut sum = [0.0; 3];
                for part in 0..samples * samples {
                    let (i, j) = (f64::from(part % samples), f64::from(part / samples));
                    let x = (f64::from(column) + (i + 0.5) * share) * step[0];
                    let y = self.size_m[1] - (f64::from(row) + (j + 0.5) * share) * step[1];
                    let colour = self.colour(wood, [x, y], step[0] * share);
                    for (sum, part) in sum.iter_mut().zip(colour) {
                        *sum += part * share * share;
                    }
                }
                pixels.push(sum.map(byte));
            }
        }
        pixels
    }

    /// Samples along a side of a pixel: one per cell, but no fewer than 2, so that edges are smooth.
    fn samples(&self, columns: u32) -> u8 {
        let cells = self.columns / usize::try_from(columns.max(1)).unwrap_or(1) + 1;
        u8::try_from(cells).unwrap_or(SAMPLES).clamp(2, SAMPLES)
    }

    /// The colour of the board, of this wood, at a place (m) seen through a sample of this size (m).
    fn colour(&self, wood: [f64; 3], [x, y]: [f64; 2], size: f64) -> [f64; 3] {
        let height = self.height(x, y);
        let cell = self.cell_m();
        let over = if cell[0] > size { cell[0] } else { size };
        // slopes by differences over the size of a cell or sample
        let dx = (self.height(x + over, y) - self.height(x - over, y)) / (2.0 * over);
        let dy = (self.height(x, y + over) - self.height(x, y - over)) / (2.0 * over);
        let [lx, ly, lz] = LIGHT;
        let length = libm::sqrt(lx * lx + ly * ly + lz * lz);
        let facing = (lz - dx * lx - dy * ly) / (length * libm::sqrt(1.0 + dx * dx + dy * dy));
        let facing = if facing > 0.0 { facing } else { 0.0 };
        // a flat board has the colour of its wood
        let mut light = AMBIENT + (1.0 - AMBIENT) * facing * length / lz;
        let depth = -height;
        let share = if self.deepest > 0.0 {
            depth / self.deepest
        } else {
            0.0
        };
        let mut colour = wood;
        if depth > 1e-6 {
            light *= SHADOW + (1.0 - SHADOW) * self.lit(x, y, height, over);
            // a thin cut is pale, a deep one dark; neither hides the grain
            let cut = mix(FRESH_CUT, DEEP_CUT, share);
            let presence = depth / (depth + 0.15 * over);
            colour = mix(colour, cut, 0.82 * presence);
        }
        colour.map(|part| part * light)
    }

    /// How much of the light comes to a point below the top: 1 all, 0 none.
    fn lit(&self, x: f64, y: f64, height: f64, over: f64) -> f64 {
        let [lx, ly, lz] = LIGHT;
        // so far over the board until the ray is above the top
        let way = -height / lz;
        let mut lit = 1.0;
        for step in 1..=SHADOW_STEPS {
            let share = f64::from(step) / f64::from(SHADOW_STEPS);
            let along = way * share;
            let ray = height + lz * along;
            let wall = self.height(x + lx * along, y + ly * along);
            // over a cell, from lit to dark: a soft edge
            let clear = 1.0 - (wall - ray) / (0.5 * over);
            let clear = clear.clamp(0.0, 1.0);
            if clear < lit {
                lit = clear;
            }
        }
        lit
    }

    /// Boards of maple: long grain along x, uneven, with fine pores.
    fn wood(&self, x: f64, y: f64) -> [f64; 3] {
        // in shares of the longer side, so that a board of any size looks like wood
        let side = if self.size_m[0] > self.size_m[1] {
            self.size_m[0]
        } else {
            self.size_m[1]
        };
        let (u, v) = (x / side, y / side);
        let bend = 0.06 * noise(1.6 * u, 3.0 * v, 1) + 0.012 * noise(5.0 * u, 14.0 * v, 2);
        let rings = libm::sin(120.0 * (v + bend) + 9.0 * noise(0.7 * u, 4.0 * v, 3));
        let broad = noise(1.1 * u, 7.0 * v, 4);
        let pores = noise(24.0 * u, 700.0 * v, 5) * noise(60.0 * u, 330.0 * v, 6);
        let dark = 0.34 + 0.20 * rings + 0.34 * (broad - 0.5) + 0.30 * (pores - 0.25);
        mix(LIGHT_WOOD, DARK_WOOD, dark.clamp(0.0, 1.0))
    }

    fn cell_m(&self) -> [f64; 2] {
        [
            self.size_m[0] / real(self.columns),
            self.size_m[1] / real(self.rows),
        ]
    }

    /// The height at a place (m) between the centres of cells; that of the edge beyond it.
    fn height(&self, x: f64, y: f64) -> f64 {
        let cell = self.cell_m();
        let (column, a) = between(x / cell[0] - 0.5, self.columns);
        let (row, b) = between(y / cell[1] - 0.5, self.rows);
        let at = |i: usize, j: usize| {
            let height = self.heights.get(j * self.columns + i).copied();
            let height = height.map_or(0.0, f64::from);
            // what is above the top is dust
            if height < 0.0 && height.is_finite() {
                height
            } else {
                0.0
            }
        };
        let low = at(column, row) * (1.0 - a) + at(column + 1, row) * a;
        let high = at(column, row + 1) * (1.0 - a) + at(column + 1, row + 1) * a;
        low * (1.0 - b) + high * b
    }
}

/// The cell before a place counted in cells, and how far beyond its centre it is; the last has no next one.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "`as` saturates, and a floor below 0 has been sent away"
)]
fn between(place: f64, cells: usize) -> (usize, f64) {
    let floor = libm::floor(place);
    let last = cells.saturating_sub(1);
    if floor < 0.0 {
        (0, 0.0)
    } else if floor < real(last) {
        (floor as usize, place - floor)
    } else {
        (last, 0.0)
    }
}

/// Noise between 0 and 1 on a grid of unit squares, smooth between its corners.
fn noise(u: f64, v: f64, seed: i64) -> f64 {
    let (i, j) = (libm::floor(u), libm::floor(v));
    let smooth = |t: f64| t * t * (3.0 - 2.0 * t);
    let (a, b) = (smooth(u - i), smooth(v - j));
    let (i, j) = (cell(i), cell(j));
    let low = hash(i, j, seed) * (1.0 - a) + hash(i + 1, j, seed) * a;
    let high = hash(i, j + 1, seed) * (1.0 - a) + hash(i + 1, j + 1, seed) * a;
    low * (1.0 - b) + high * b
}

#[expect(clippy::cast_possible_truncation, reason = "`as` saturates")]
fn cell(value: f64) -> i64 {
    (value as i64).clamp(-1_000_000, 1_000_000)
}

/// 0 to 1, the same for the same corner: a round of the finaliser of `splitmix64` (Steele, Lea and Flood, 2014).
fn hash(i: i64, j: i64, seed: i64) -> f64 {
    let mut z = (i * 0x1F_1F1F + j * 0x3_5D79 + seed * 0x51_2D3B).cast_unsigned();
    z = z.wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    let top = u32::try_from((z ^ (z >> 31)) >> 32).unwrap_or(0);
    f64::from(top) / f64::from(u32::MAX)
}

fn mix(a: [f64; 3], b: [f64; 3], share: f64) -> [f64; 3] {
    let [p, q, r] = a;
    let [s, t, u] = b;
    let of = |a: f64, b: f64| a + (b - a) * share;
    [of(p, s), of(q, t), of(r, u)]
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "0 to 255; `as` saturates"
)]
pub(super) fn byte(value: f64) -> u8 {
    libm::round(value) as u8
}

#[expect(
    clippy::cast_precision_loss,
    reason = "cells of a side, far below 2^53"
)]
fn real(value: usize) -> f64 {
    value as f64
}
