//! What all samples that bear on a cell allow together.

use super::gauge::{Chord, Span};
use super::polygon::{LINES, Polygon};
use super::sample::Allowed;
use super::window::Window;
use crate::scalar::smaller;
use core::ops::RangeInclusive;

/// ṡ² up to which [`Bounds`] have lines, in units of the largest one: how far a chord that ends within
/// limits may rise beyond, in a macrostep.
const HEADROOM: f32 = 2.0;
/// By how many samples the ranges of cells may go on until what they have in common is found anew. For a
/// range of n samples, a cell costs n/SHIFT + 1 + SHIFT/2 of them.
const SHIFT: usize = 8;

/// What holds in all samples that bear on a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    pub(super) least: Least,
    /// line·(u, x) ≤ 1; those not needed are 0.
    lines: [[f32; 2]; LINES],
}

/// The least bounds of |u|, of x, and of x with u = 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Least {
    pub(super) most_u: f32,
    pub(super) most_x: f32,
    pub(super) coast_x: f32,
}

impl Bounds {
    /// Cuts off what is not allowed, all limits of acceleration multiplied by `limit`.
    pub(super) fn clip(&self, chords: &[Chord; 2], limit: f32, span: &mut Span) {
        for [by_u, by_x] in &self.lines {
            for Chord {
                u: [u0, u1],
                x: [x0, x1],
            } in chords
            {
                span.half_plane(by_u * u0 + by_x * x0, by_u * u1 + by_x * x1, limit);
            }
        }
    }
}

impl Least {
    const NONE: Self = Self {
        most_u: f32::INFINITY,
        most_x: f32::INFINITY,
        coast_x: f32::INFINITY,
    };

    fn and<const N: usize>(&self, allowed: &Allowed<N>) -> Self {
        Self {
            most_u: smaller(self.most_u, allowed.most_u),
            most_x: smaller(self.most_x, allowed.most_x),
            coast_x: smaller(self.coast_x, allowed.coast_x),
        }
    }
}

/// The intersection of what some samples allow, or a polygon in it.
#[derive(Clone, Debug)]
struct Region {
    least: Least,
    polygon: Polygon,
}

impl Region {
    fn add<const N: usize>(&mut self, allowed: &Allowed<N>) {
        self.least = self.least.and(allowed);
        allowed.cut(&mut self.polygon);
    }

    fn bounds(mut self) -> Bounds {
        let Least { most_u, most_x, .. } = self.least;
        let top = HEADROOM * most_x;
        for (line, limit) in [
            ([1.0, 0.0], most_u),
            ([-1.0, 0.0], most_u),
            ([0.0, 1.0], top),
        ] {
            self.polygon.cut_if_needed(line, limit);
        }
        let polygon = self.polygon.without_short_sides([most_u, top]);
        let mut lines = [[0.0; 2]; LINES];
        for (out, line) in lines.iter_mut().zip(polygon.lines()) {
            *out = line;
        }
        Bounds {
            least: self.least,
            lines,
        }
    }
}

/// What the samples allow that the ranges of several cells, one after the other, have in common.
#[derive(Clone, Debug)]
pub(super) struct Common {
    /// The first of them, and the first one after them.
    from: usize,
    until: usize,
    region: Region,
}

impl Common {
    /// The oldest sample is no more: the others have a smaller index.
    pub(super) fn renumber(&mut self) {
        self.from = self.from.saturating_sub(1);
        self.until = self.until.saturating_sub(1);
    }
}

impl<const N: usize, const W: usize> Window<N, W> {
    /// Of some samples; with each call, samples at the start may be left out, and some come at the end.
    ///
    /// If the end should go back, samples beyond it still count: that is on the safe side.
    pub(super) fn bounds(&mut self, range: &RangeInclusive<usize>) -> Bounds {
        let (start, end) = (*range.start(), *range.end());
        let known = self.common.take().filter(|common| start <= common.from);
        let mut common = known.unwrap_or_else(|| {
            let from = start.saturating_add(SHIFT).min(end);
            self.first_common(from, end)
        });
        for r in (common.until..=end).filter_map(|i| self.get(i)) {
            common.region.add(&r.allowed);
        }
        common.until = common.until.max(end.saturating_add(1));
        let mut own = common.region.clone();
        for r in (start..common.from).filter_map(|i| self.get(i)) {
            own.add(&r.allowed);
        }
        self.common = Some(common);
        own.bounds()
    }

    /// Nothing of it yet but a rectangle that contains it.
    fn first_common(&self, from: usize, end: usize) -> Common {
        let all = (from..=end).filter_map(|i| self.get(i));
        let least = all.fold(Least::NONE, |least, r| least.and(&r.allowed));
        Common {
            from,
            until: from,
            region: Region {
                least,
                polygon: Polygon::rectangle(least.most_u, HEADROOM * least.most_x),
            },
        }
    }
}

#[cfg(test)]
#[expect(clippy::cast_precision_loss, reason = "small indices")]
mod tests {
    extern crate std;
    use super::*;
    use crate::scalar::larger;
    use proptest::prelude::*;
    use std::vec::Vec;

    /// The largest part of a limit that (u, x) takes.
    fn taken(allowed: &Allowed<2>, [u, x]: [f32; 2]) -> f32 {
        let mut most = larger(u.abs() / allowed.most_u, 0.0);
        for (first, second) in allowed.first.iter().zip(&allowed.second) {
            most = larger(most, (first * u + second * x).abs());
        }
        for [bb, bc, cc] in &allowed.tool {
            let square = bb * u * u + 2.0 * bc * u * x + cc * x * x;
            most = larger(most, libm::sqrtf(larger(square, 0.0)));
        }
        larger(most, allowed.mixed[0] * u.abs() + allowed.mixed[1] * x)
    }

    /// As it changes along a path.
    fn allowed(seed: f32, s: f32) -> Allowed<2> {
        let wave = |k: f32| libm::sinf(seed * (3.0 + k) + s * (0.3 + 0.1 * k) + k);
        let ellipse = |k: f32| {
            let ([b0, b1], [c0, c1]) = (
                [0.9 * wave(k), 0.4 * wave(k + 1.0)],
                [1.5 * wave(k + 2.0), 1.5 * wave(k + 3.0)],
            );
            [b0 * b0 + b1 * b1, b0 * c0 + b1 * c1, c0 * c0 + c1 * c1]
        };
        Allowed {
            first: [wave(0.5), wave(1.5)],
            second: [2.0 * wave(2.5), 2.0 * wave(3.5)],
            tool: [ellipse(4.0), ellipse(9.0)],
            mixed: [0.6 + 0.3 * wave(5.5), 0.8 + 0.3 * wave(6.5)],
            most_u: 0.9,
            most_x: 1.0 + 0.5 * wave(7.5),
            coast_x: 1.0,
            nominal: 1.0,
        }
    }

    proptest! {
        #[test]
        fn leaving_out_limits_that_others_imply_changes_nothing(
            seed in 0.0..10.0f32, u in -0.9..0.9f32, x in 0.0..16.0f32,
        ) {
            let full = allowed(seed, 0.0);
            let reduced = full.reduced();
            let x = x * full.most_x;
            let (before, after) = (taken(&full, [u, x]), taken(&reduced, [u, x]));
            // what touches within 1e-5 counts as needed; where it is 1 to some roundings either may be
            prop_assert!((before <= 1.0) == (after <= 1.0) || (before - 1.0).abs() < 2e-5, "{} {}", before, after);
            prop_assert!(after <= before);
        }

        #[test]
        fn what_is_left_of_a_range_is_allowed_by_all_its_samples_and_hardly_less(
            seed in 0.0..10.0f32, slope in -1.0..1.0f32, length in 3usize..20,
        ) {
            let mut window = Window::<2, 64>::new();
            let all: Vec<_> = (0..64u8).map(|i| allowed(seed, 0.02 * f32::from(i))).collect();
            for (i, allowed) in all.iter().enumerate() {
                window.push(0.1 * i as f64, *allowed, i == 0, false);
            }
            for start in 0..64 - length {
                let bounds = window.bounds(&(start..=start + length));
                // along u = slope·r, x = r: where the polygon ends, and where the samples do
                let ray = [slope, 1.0];
                let steepest = bounds.lines.iter().map(|l| l[0] * ray[0] + l[1] * ray[1]);
                let polygon = 1.0 / steepest.fold(0.0, larger);
                let samples = all.iter().skip(start).take(length + 1);
                let exact = 1.0 / samples.clone().map(|a| taken(a, ray)).fold(0.0, larger);
                let top = samples.fold(f32::INFINITY, |least, a| smaller(least, a.most_x));
                let exact = smaller(exact, HEADROOM * top);
                prop_assert!(polygon <= exact * (1.0 + 1e-5), "{} {}", polygon, exact);
                // cut deeper by 0.1 or 0.4 %; one sample more for each of up to SHIFT cells, in which waves
                // change by 1 %; and corners that there was no place for
                prop_assert!(polygon >= 0.9 * exact, "{} {}", polygon, exact);
            }
        }
    }
}
