//! The unsmoothed motion: constant acceleration in each macrostep, below the envelope.

use super::gauge::{Chord, Span};
use super::limits::{Plan, count};
use super::window::Window;
use crate::scalar::{larger, narrow, smaller};
use core::ops::RangeInclusive;

/// Where it is going.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Heading {
    Forward,
    Backward,
}

impl Heading {
    pub(super) fn side(self) -> f64 {
        match self {
            Self::Forward => 1.0,
            Self::Backward => -1.0,
        }
    }
}

/// Before a macrostep: position, and velocity and acceleration (of the step) by s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct InnerStep {
    pub(super) s: f64,
    pub(super) v: f64,
    pub(super) a: f64,
}

impl InnerStep {
    /// At s = 0.
    pub(super) const REST: Self = Self {
        s: 0.0,
        v: 0.0,
        a: 0.0,
    };
}

/// Position, speed along the heading, and the cell it is in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Inner {
    pub(super) s: f64,
    pub(super) speed: f64,
    pub(super) heading: Heading,
    pub(super) cell: usize,
}

impl Inner {
    /// At rest at the first sample.
    pub(super) const START: Self = Self {
        s: 0.0,
        speed: 0.0,
        heading: Heading::Forward,
        cell: 0,
    };
}

/// Where the present motion must end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Wall {
    pub(super) record: usize,
}

/// A step that ends this little after a sample ends at it, by rounding.
const BARELY: f64 = 1.0 + 1e-12;
/// Nearer than this part of a cell, at rest, is at the wall: some 1e7 roundings.
const SNAP: f64 = 1e-9;
/// Speeds below this part of what a step can change are rest.
const REST: f64 = 1e-9;

impl Inner {
    /// `behind`: where the smoothed motion is, if the inner one has not turned in the last τ.
    ///
    /// One macrostep with the largest acceleration that is allowed, or the one that leads to the target.
    pub(super) fn step<const N: usize, const W: usize>(
        &mut self,
        window: &Window<N, W>,
        wall: Wall,
        behind: Option<f64>,
        feed_override: f64,
        plan: &Plan<N>,
    ) -> InnerStep {
        let before = InnerStep {
            s: self.s,
            v: self.heading.side() * self.speed,
            a: 0.0,
        };
        let Some(wall_s) = window.get(wall.record).map(|r| r.s) else {
            return before;
        };
        let side = self.heading.side();
        let room = side * (wall_s - self.s);
        if self.speed <= 0.0 && (room <= 0.0 || side * feed_override <= 0.0) {
            return before;
        }
        let h = plan.step;
        let range = self.bearing(window, behind, plan);
        let most_u = window.least_u(range.clone());
        let allowed = self.allowed(window, range, most_u, plan);
        let most_u = f64::from(most_u);
        let mut u = self.wanted(window, f64::from(allowed.high), feed_override, plan);
        u = self.below_envelope(window, u, wall, plan);
        u = larger(u, f64::from(allowed.low));
        // such that the next macrostep can end at the wall exactly, at rest: before all else
        u = smaller(u, (room / h - 1.5 * self.speed) / h);
        u = larger(u, -self.speed / h);
        let mut after = self.speed + u * h;
        if after <= REST * most_u * h {
            after = 0.0;
        }
        let acceleration = (after - self.speed) / h;
        self.s += side * 0.5 * h * (self.speed + after);
        self.speed = after;
        if after <= 0.0 && side * (wall_s - self.s) <= SNAP * plan.grid {
            self.s = wall_s;
        }
        self.find_cell(window, wall);
        InnerStep {
            a: side * acceleration,
            ..before
        }
    }

    /// The samples that the smoothed motion can be at while this step's acceleration is in its mean.
    ///
    /// Turning at once with |u| ≤ U, the inner motion is at s\* + v·w − U·w²/2 after w; the mean of that
    /// over w in \[h, h + τ\] may be behind s\*, and nothing that is averaged is farther behind than
    /// that, or than the smoothed motion is now.
    fn bearing<const N: usize, const W: usize>(
        &self,
        window: &Window<N, W>,
        behind: Option<f64>,
        plan: &Plan<N>,
    ) -> RangeInclusive<usize> {
        let all = window.range(self.cell);
        let (Some(behind), Some((a, b))) = (behind, window.cell(self.cell)) else {
            return all;
        };
        let (h, tau) = (plan.step, plan.tau);
        let squares = h * h + h * tau + tau * tau / 3.0;
        let loosest_u = f64::from(window.loosest_u(all.clone()));
        let back = 0.5 * loosest_u * squares - self.speed * (h + 0.5 * tau);
        let back = larger(back, 0.0);
        match self.heading {
            Heading::Forward => {
                let cells = count(libm::ceil(larger(a.s - behind + back, 0.0) / plan.grid));
                self.cell.saturating_sub(cells).max(*all.start())..=*all.end()
            }
            Heading::Backward => {
                let cells = count(libm::ceil(larger(behind + back - b.s, 0.0) / plan.grid));
                *all.start()
                    ..=self
                        .cell
                        .saturating_add(1)
                        .saturating_add(cells)
                        .min(*all.end())
            }
        }
    }

    /// Accelerations along the heading that all samples bearing on this step allow.
    fn allowed<const N: usize, const W: usize>(
        &self,
        window: &Window<N, W>,
        range: RangeInclusive<usize>,
        most_u: f32,
        plan: &Plan<N>,
    ) -> Span {
        let (h, v) = (narrow(plan.step), narrow(self.speed));
        let x = v * v;
        let mut span = Span {
            low: larger(-most_u, -v / h),
            high: most_u,
        };
        let u = [0.0, narrow(self.heading.side())];
        let chords = [
            Chord { u, x: [x, 0.0] },
            // (v + u·h)² is between x + 2·v·h·u and this chord through (0, x) and its value at most_u
            Chord {
                u,
                x: [x, h * (2.0 * v + most_u * h)],
            },
        ];
        window.clip(range, &chords, &mut span);
        if span.is_empty() {
            let middle = 0.5 * (span.low + span.high);
            let middle = if middle.is_finite() { middle } else { 0.0 };
            return Span {
                low: middle,
                high: middle,
            };
        }
        span
    }

    /// What leads to the speed asked for, if that is less than the most.
    fn wanted<const N: usize, const W: usize>(
        &self,
        window: &Window<N, W>,
        most: f64,
        feed_override: f64,
        plan: &Plan<N>,
    ) -> f64 {
        let share = self.heading.side() * feed_override;
        if share >= 1.0 {
            return most;
        }
        let nominal = window
            .cell(self.cell)
            .map_or(0.0, |(a, b)| smaller(a.allowed.nominal, b.allowed.nominal));
        let nominal = f64::from(nominal);
        smaller(
            most,
            (larger(share, 0.0) * nominal - self.speed) / plan.step,
        )
    }

    /// The largest acceleration up to `u` with which the step stays below the envelope.
    ///
    /// During a step ṡ² is linear in s, and so is the envelope in each cell: a step is below if it is
    /// at every sample it passes and at its end.
    fn below_envelope<const N: usize, const W: usize>(
        &self,
        window: &Window<N, W>,
        most: f64,
        wall: Wall,
        plan: &Plan<N>,
    ) -> f64 {
        let (h, v, x, side) = (
            plan.step,
            self.speed,
            self.speed * self.speed,
            self.heading.side(),
        );
        let mut u = most;
        let mut cell = self.cell;
        for _ in 0..W {
            let Some((a, b)) = window.cell(cell) else {
                break;
            };
            let (near, far) = if side > 0.0 { (a, b) } else { (b, a) };
            let (near_x, far_x) = (f64::from(near.envelope), f64::from(far.envelope));
            let (from, to) = (side * (near.s - self.s), side * (far.s - self.s));
            let way = |u: f64| h * (v + 0.5 * u * h);
            if way(u) > to * BARELY && to > 0.0 {
                let passing = (far_x - x) / (2.0 * to);
                // what does not get to the sample need not be below the envelope there
                let ending = 2.0 * (to - v * h) / (h * h);
                u = smaller(u, larger(passing, ending));
            }
            if way(u) <= to * BARELY {
                // at the end: (v + u·h)² ≤ X + slope·(way − from)
                let slope = (far_x - near_x) / (to - from);
                let linear = 2.0 * v * h - 0.5 * slope * h * h;
                let excess = x - near_x - slope * (v * h - from);
                if u * (u * h * h + linear) + excess > 0.0 {
                    let square = linear * linear - 4.0 * h * h * excess;
                    let root = libm::sqrt(larger(square, 0.0));
                    u = smaller(u, (root - linear) / (2.0 * h * h));
                }
                break;
            }
            let last = if side > 0.0 {
                cell.saturating_add(1) >= wall.record
            } else {
                cell <= wall.record
            };
            if last {
                break;
            }
            cell = if side > 0.0 {
                cell.saturating_add(1)
            } else {
                cell.saturating_sub(1)
            };
        }
        u
    }

    /// Moves on to the cell that contains s, not beyond the wall.
    pub(super) fn find_cell<const N: usize, const W: usize>(
        &mut self,
        window: &Window<N, W>,
        wall: Wall,
    ) {
        for _ in 0..W {
            let Some((a, b)) = window.cell(self.cell) else {
                return;
            };
            match self.heading {
                Heading::Forward if self.s >= b.s && self.cell.saturating_add(1) < wall.record => {
                    self.cell = self.cell.saturating_add(1);
                }
                Heading::Backward if self.s <= a.s && self.cell > wall.record => {
                    self.cell = self.cell.saturating_sub(1);
                }
                Heading::Forward | Heading::Backward => return,
            }
        }
    }
}
