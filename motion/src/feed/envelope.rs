//! The greatest speed from which every wall ahead can still be respected.

use super::gauge::{Chord, Span};
use super::limits::Plan;
use super::window::Window;
use crate::scalar::{larger, narrow, smaller};
use core::ops::RangeInclusive;

/// Part of every limit of acceleration that the envelope leaves to the steps: a macrostep does not end
/// where a cell does, so a step may need a little more than the envelope on its way.
const RESERVE: f32 = 0.01;
/// The same before a wall: two macrosteps that end there exactly need up to 9/8 of the mean, and the
/// samples that bear on a step change the more from cell to cell, the slower it is.
const RESERVE_AT_WALL: f32 = 0.2;
/// How many macrosteps before the wall that is kept.
const STEPS_AT_WALL: f32 = 4.0;

impl<const N: usize, const W: usize> Window<N, W> {
    /// Cuts off what some of these samples does not allow.
    pub(super) fn clip(&self, range: RangeInclusive<usize>, chords: &[Chord; 2], span: &mut Span) {
        for i in range {
            if let Some(r) = self.get(i) {
                for chord in chords {
                    r.allowed.clip(chord, span);
                }
            }
        }
    }

    /// The envelope for motion towards larger s, from the wall at `front` back to the cell `at`.
    ///
    /// Cells before `known` had an envelope; it only grows, and where it does not, the pass is over.
    pub(super) fn envelope_forward(
        &mut self,
        at: usize,
        known: usize,
        front: usize,
        plan: &Plan<N>,
    ) {
        let mut far_was = 0.0;
        for cell in (at..front).rev() {
            let was = self.get(cell).map_or(0.0, |r| r.envelope);
            self.envelope_of(cell, true, far_was, plan);
            let is = self.get(cell).map_or(0.0, |r| r.envelope);
            if cell < known && is <= was {
                break;
            }
            far_was = was;
        }
    }

    /// The same towards smaller s, from the wall at `first` to the cell `at`, all anew.
    pub(super) fn envelope_backward(&mut self, first: usize, at: usize, plan: &Plan<N>) {
        for cell in first..=at {
            self.envelope_of(cell, false, 0.0, plan);
        }
    }

    /// Forgets the envelope of some records.
    pub(super) fn clear_envelope(&mut self, first: usize, last: usize) {
        for i in first..=last {
            if let Some(r) = self.get_mut(i) {
                r.envelope = 0.0;
            }
        }
    }

    /// From the envelope at the far end of a cell to that at its near end.
    ///
    /// The largest t = ṡ² at the near end such that the chord from it to X at the far end has an
    /// acceleration u = (X − t)/2δ that all samples bearing on the cell allow, for ṡ² from one
    /// macrostep before the near end to one after the far one. Because what is allowed is convex and contains
    /// (0, 0), slower motion is allowed with the same chord scaled; and the mean of the accelerations of
    /// several cells, which is what a macrostep across them needs, is allowed too.
    /// Where no chord is allowed, the envelope is level, at what may coast.
    fn envelope_of(&mut self, cell: usize, forward: bool, far_was: f32, plan: &Plan<N>) {
        let Some((a, b)) = self.cell(cell) else {
            return;
        };
        let length = narrow(b.s - a.s);
        let fast = a.fast;
        let Some(bounds) = a.bounds else { return };
        let (near, far, side) = if forward { (a, b, 1.0) } else { (b, a, -1.0) };
        let (was, x) = (near.envelope, far.envelope);
        let two = 2.0 * length;
        let macrostep = narrow(plan.step);
        let close = STEPS_AT_WALL * bounds.least.most_u * macrostep;
        let limit = 1.0
            - if x < close * close {
                RESERVE_AT_WALL
            } else {
                RESERVE
            };
        let growth = two * bounds.least.most_u * limit;
        let v = smaller(fast, libm::sqrtf(x + growth));
        let step = v * macrostep / length;
        let u = [side * x / two, -side / two];
        let chords = [
            Chord {
                u,
                x: [-step * x, 1.0 + step],
            },
            Chord {
                u,
                x: [(1.0 + step) * x, -step],
            },
        ];
        let mut span = Span {
            low: larger(x - growth, 0.0),
            high: smaller(x + growth, bounds.least.most_x),
        };
        bounds.clip(&chords, limit, &mut span);
        let coast_x = bounds.least.coast_x * limit;
        let rises = plan.averaged > 0 && span.high < x && x > coast_x;
        let (near_x, far_x) = if span.is_empty() || rises {
            let level = smaller(x, coast_x);
            (level, larger(level, far_was))
        } else {
            (span.high, x)
        };
        let (near, far) = if forward {
            (cell, cell.saturating_add(1))
        } else {
            (cell.saturating_add(1), cell)
        };
        if let Some(r) = self.get_mut(near) {
            r.envelope = larger(near_x, was);
        }
        if let Some(r) = self.get_mut(far) {
            r.envelope = far_x;
        }
    }
}
