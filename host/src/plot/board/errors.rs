//! Errors along a path, as a line in colours, and the bar that says what the colours mean.

use super::super::drawing::{Anchor, Colour, Drawing, FRAME, INK, SOFT_INK, Shape, Stroke};
use super::super::panel::Panel;
use super::super::scale::{Range, finite};
use super::{MM, PathError};

/// From small to great: ever darker, so they keep their order in grey and for any colour vision.
const COLOURS: [[u8; 3]; 6] = [
    [0x6F, 0xC8, 0xC0],
    [0x3D, 0x9F, 0xC9],
    [0x4A, 0x6F, 0xC4],
    [0x7A, 0x45, 0xA8],
    [0xA8, 0x1F, 0x6E],
    [0xD0, 0x10, 0x2A],
];
/// So many shades are told apart: neighbours in one shade are one line.
const SHADES: u8 = 40;
/// Points nearer than this on the paper are one, with the greatest of their errors.
const NEAR: f64 = 0.7;
const WIDTH: f64 = 1.9;
const BAR_WIDTH: f64 = 16.0;
/// The bar ends at a round number that this share of the errors does not exceed.
const SHARE: f64 = 0.995;
/// Micrometres in a metre.
const UM: f64 = 1e6;

/// Errors, and the number at the end of their bar.
#[derive(Clone, Copy, Debug)]
pub(super) struct Errors<'a> {
    samples: &'a [PathError],
    /// m
    end: f64,
    /// m; none if there are no errors.
    greatest: Option<f64>,
}

impl<'a> Errors<'a> {
    pub(super) fn new(samples: &'a [PathError]) -> Self {
        let mut sizes: Vec<f64> = samples
            .iter()
            .filter(|s| good(s))
            .map(|s| s.error_m.abs())
            .collect();
        sizes.sort_unstable_by(f64::total_cmp);
        let most = sizes.get(share(sizes.len())).copied().unwrap_or(0.0);
        Self {
            samples,
            end: round_above(most * UM) / UM,
            greatest: sizes.last().copied(),
        }
    }

    fn shade(&self, error_m: f64) -> u8 {
        let share = error_m.abs() / self.end * f64::from(SHADES);
        (0..SHADES - 1)
            .find(|shade| share < f64::from(*shade) + 1.0)
            .unwrap_or(SHADES - 1)
    }

    /// The samples as lines, each of one shade.
    pub(super) fn draw(&self, drawing: &mut Drawing, panel: &Panel) {
        let mut line: Vec<[f64; 2]> = Vec::new();
        let mut shade = 0;
        let mut worst: f64 = 0.0;
        let mut flush = |line: &mut Vec<[f64; 2]>, shade: u8| {
            drawing.line(core::mem::take(line), Stroke::solid(colour(shade), WIDTH));
        };
        let mut end = None;
        for sample in self.samples {
            if !good(sample) {
                line.extend(end.take());
                flush(&mut line, shade);
                worst = 0.0;
                continue;
            }
            let at = panel.place(sample.at_m.map(|v| v * MM));
            if sample.error_m.abs() > worst {
                worst = sample.error_m.abs();
            }
            let Some(before) = line.last().copied() else {
                (line, shade) = (vec![at], self.shade(worst));
                continue;
            };
            end = Some(at);
            if libm::hypot(at[0] - before[0], at[1] - before[1]) < NEAR {
                continue;
            }
            let now = self.shade(worst);
            if now != shade && line.len() > 1 {
                flush(&mut line, shade);
                line.push(before);
            }
            shade = now;
            line.push(at);
            (worst, end) = (0.0, None);
        }
        line.extend(end);
        flush(&mut line, shade);
    }

    /// The colours and what they mean, in a column of this height.
    pub(super) fn bar(&self, drawing: &mut Drawing, left: f64, top: f64, height: f64) {
        let Some(greatest) = self.greatest else {
            return;
        };
        let pitch = height / f64::from(SHADES);
        for shade in 0..SHADES {
            let y = top + height - pitch * (f64::from(shade) + 1.0);
            // a little taller, so that no paper shows between two
            let extra = if shade > 0 { 0.5 } else { 0.0 };
            let place = [left, y, BAR_WIDTH, pitch + extra];
            drawing.shapes.push(Shape::Rect(place, colour(shade)));
        }
        let right = left + BAR_WIDTH;
        let corners = [
            [left, top],
            [right, top],
            [right, top + height],
            [left, top + height],
            [left, top],
        ];
        drawing.line(corners.to_vec(), Stroke::solid(FRAME, 1.0));
        let range = Range {
            lower: 0.0,
            upper: self.end * UM,
        };
        let cut_off = greatest > self.end * (1.0 + 1e-9);
        for (value, label) in range.ticks(5) {
            let y = top + height * (1.0 - value / range.upper);
            drawing.line(
                vec![[right, y], [right + 4.0, y]],
                Stroke::solid(FRAME, 1.0),
            );
            let last = value > range.upper * (1.0 - 1e-9);
            let label = if last && cut_off {
                format!("≥ {label}")
            } else {
                label
            };
            drawing.text([right + 8.0, y + 4.0], 11.0, Anchor::Start, SOFT_INK, label);
        }
        drawing.text([left, top - 22.0], 12.0, Anchor::Start, INK, "[µm]");
        let words = format!("max {} µm", rounded(greatest * UM));
        let at = [left, top + height + 15.0];
        drawing.text(at, 11.0, Anchor::Start, SOFT_INK, words);
    }
}

/// Are all its numbers ones to draw?
fn good(sample: &PathError) -> bool {
    finite(sample.at_m[0]) && finite(sample.at_m[1]) && finite(sample.error_m)
}

/// Three digits, as many as anybody can tell apart.
fn rounded(value: f64) -> String {
    if value < 1.0 {
        format!("{value:.3}")
    } else if value < 100.0 {
        format!("{value:.1}")
    } else {
        format!("{value:.0}")
    }
}

/// The least round number that is not less: few digits, and ticks of their own; 1 for what is less
/// than a millionth of it.
fn round_above(value: f64) -> f64 {
    if value <= 1e-6 {
        return 1.0;
    }
    let decade = libm::pow(10.0, libm::floor(libm::log10(value)));
    [1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0]
        .into_iter()
        .map(|digit| digit * decade)
        .find(|round| *round >= value * (1.0 - 1e-9))
        .unwrap_or(10.0 * decade)
}

/// The colour in the middle of a shade.
fn colour(shade: u8) -> Colour {
    let last = 5.0;
    let at = (f64::from(shade) + 0.5) / f64::from(SHADES) * last;
    let mut rgb = COLOURS[0];
    for (n, pair) in (0u8..).zip(COLOURS.windows(2)) {
        let (&[low, high], within) = (pair, at - f64::from(n)) else {
            continue;
        };
        if (0.0..=1.0).contains(&within) {
            rgb = [0, 1, 2].map(|k| {
                let mixed = f64::from(low[k]) * (1.0 - within) + f64::from(high[k]) * within;
                super::wood::byte(mixed)
            });
        }
    }
    let [r, g, b] = rgb.map(u32::from);
    Colour::new(r << 16 | g << 8 | b)
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::cast_precision_loss,
    reason = "an index below the length, far below 2^53"
)]
fn share(length: usize) -> usize {
    (SHARE * length.saturating_sub(1) as f64) as usize
}
