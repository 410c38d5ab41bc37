//! The samples known at present, and how far a step taken at one of them reaches.

use super::erosion::{Bounds, Common};
use super::limits::{Plan, count};
use super::sample::Allowed;
use crate::scalar::{larger, narrow, smaller};
use core::ops::RangeInclusive;

/// Bounds of speed are this much higher than computed: they are sums of some hundred terms in f32, a part in 1e5 at most.
const FAST: f32 = 1.0 + 1e-5;

/// A sample in the window. The cell of a record lies between it and the next one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Record<const N: usize> {
    /// Where on the path.
    pub(super) s: f64,
    pub(super) allowed: Allowed<N>,
    /// First or last sample of a piece: the motion rests here.
    pub(super) begins: bool,
    pub(super) ends: bool,
    /// Bound of ṡ² that no motion within the limits exceeds here, whatever it did before and does after.
    reach: f32,
    /// The same of ṡ inside the cell, and the time that the cell lasts at least, s.
    pub(super) fast: f32,
    lasts: f32,
    /// Largest ṡ² from which the wall ahead can be respected; of the present heading.
    pub(super) envelope: f32,
    /// Samples before and after the cell that bear on a step taken in it.
    before: u16,
    after: u16,
    /// What those allow; `None` until the last of them is known.
    pub(super) bounds: Option<Bounds>,
}

/// At most W records; indices count from the oldest.
#[derive(Clone, Debug)]
pub(super) struct Window<const N: usize, const W: usize> {
    records: heapless::Deque<Record<N>, W>,
    pub(super) common: Option<Common>,
}

impl<const N: usize, const W: usize> Window<N, W> {
    pub(super) const fn new() -> Self {
        Self {
            records: heapless::Deque::new(),
            common: None,
        }
    }

    /// As new, in the same place.
    pub(super) fn clear(&mut self) {
        self.records.clear();
        self.common = None;
    }

    pub(super) fn len(&self) -> usize {
        self.records.len()
    }

    pub(super) fn get(&self, i: usize) -> Option<&Record<N>> {
        self.records.get(i)
    }

    pub(super) fn get_mut(&mut self, i: usize) -> Option<&mut Record<N>> {
        self.records.get_mut(i)
    }

    /// Both records of a cell.
    pub(super) fn cell(&self, i: usize) -> Option<(&Record<N>, &Record<N>)> {
        Some((self.get(i)?, self.get(i.checked_add(1)?)?))
    }

    pub(super) fn drop_oldest(&mut self) {
        if self.records.pop_front().is_some()
            && let Some(common) = &mut self.common
        {
            common.renumber();
        }
    }

    /// Appends a sample; nothing when full, which the caller excludes.
    pub(super) fn push(&mut self, s: f64, allowed: Allowed<N>, begins: bool, ends: bool) {
        let record = Record {
            s,
            reach: if begins || ends { 0.0 } else { allowed.most_x },
            allowed: allowed.reduced(),
            begins,
            ends,
            fast: 0.0,
            lasts: f32::INFINITY,
            envelope: 0.0,
            before: 0,
            after: 0,
            bounds: None,
        };
        if self.records.push_back(record).is_ok() && !begins {
            self.bound(self.len().saturating_sub(1));
        }
    }

    /// Bounds ṡ² by |s̈| from both sides, now that the sample `newest` is there.
    fn bound(&mut self, newest: usize) {
        let Some(last) = newest.checked_sub(1) else {
            return;
        };
        let growth = self.growth(last);
        let before = self.get(last).map_or(0.0, |r| r.reach);
        if let Some(r) = self.get_mut(newest) {
            r.reach = smaller(r.reach, before + growth);
        }
        for i in (0..newest).rev() {
            let growth = self.growth(i);
            let after = self.get(i.saturating_add(1)).map_or(0.0, |r| r.reach);
            let bound = after + growth;
            let lowered = self.get(i).is_some_and(|r| bound < r.reach);
            if lowered && let Some(r) = self.get_mut(i) {
                r.reach = bound;
            }
            self.bound_cell(i, growth);
            if !lowered {
                // the cell before has not changed either
                break;
            }
        }
    }

    /// By how much ṡ² can change in a cell.
    fn growth(&self, i: usize) -> f32 {
        self.cell(i).map_or(0.0, |(a, b)| {
            2.0 * narrow(b.s - a.s) * smaller(a.allowed.most_u, b.allowed.most_u)
        })
    }

    /// Inside, ṡ² may rise from one end and fall to the other.
    fn bound_cell(&mut self, i: usize, growth: f32) {
        let Some((a, b)) = self.cell(i) else { return };
        let peak = 0.5 * (a.reach + b.reach + growth);
        let most = smaller(peak, smaller(a.allowed.most_x, b.allowed.most_x));
        let (length, fast) = (narrow(b.s - a.s), libm::sqrtf(most) * FAST);
        if let Some(r) = self.get_mut(i) {
            (r.fast, r.lasts) = (fast, length / fast);
        }
    }

    /// Finds the samples that bear on a step in this cell, and what they allow; false while not all of
    /// them are known. Samples that come later can only make their number smaller: once is enough.
    ///
    /// While the acceleration chosen in a macrostep is part of the mean, the motion is at the mean of
    /// positions up to h + τ away in time. Nothing moves faster than `fast`, so with D(t) the way made
    /// at that speed, it is at most the mean of D over \[h, h + τ\] away (D(h) for τ = 0).
    pub(super) fn survey(&mut self, i: usize, plan: &Plan<N>) -> bool {
        let Some(after) = self.travel(i, plan, true) else {
            return false;
        };
        let before = self.travel(i, plan, false).unwrap_or(0);
        if let Some(r) = self.get_mut(i) {
            (r.before, r.after) = (before, after);
        }
        let bounds = self.bounds(&self.range(i));
        if let Some(r) = self.get_mut(i) {
            r.bounds = Some(bounds);
        }
        true
    }

    /// Samples from the cell's end to where the mean of D ends; `None` if that is not known yet.
    fn travel(&self, i: usize, plan: &Plan<N>, ahead: bool) -> Option<u16> {
        let [grid, step, tau] = [plan.grid, plan.step, plan.tau].map(narrow);
        let until = step + tau;
        let (mut elapsed, mut way, mut sum, mut cells) = (0.0, 0.0, 0.0, 0u16);
        let mut at = if ahead { i.saturating_add(1) } else { i };
        let mut here = self.get(at)?;
        for _ in 0..W {
            if (ahead && here.ends) || (!ahead && (here.begins || at == 0)) {
                return Some(cells);
            }
            at = if ahead {
                at.saturating_add(1)
            } else {
                at.saturating_sub(1)
            };
            let next = self.get(at)?;
            let lasts = if ahead { here.lasts } else { next.lasts };
            here = next;
            way += grid;
            let counted = smaller(elapsed + lasts, until) - larger(elapsed, step);
            sum += larger(counted, 0.0) * way;
            elapsed += lasts;
            cells = cells.saturating_add(1);
            if elapsed >= until {
                let mean = if plan.averaged > 0 { sum / tau } else { way };
                let whole = count(f64::from(libm::ceilf(mean / grid)));
                return Some(u16::try_from(whole).map_or(cells, |whole| whole.min(cells)));
            }
        }
        None
    }

    /// The samples that bear on a step in this cell, both its ends among them.
    pub(super) fn range(&self, i: usize) -> RangeInclusive<usize> {
        let (before, after) = self.get(i).map_or((0, 0), |r| (r.before, r.after));
        let last = i.saturating_add(1).saturating_add(usize::from(after));
        i.saturating_sub(usize::from(before))..=last
    }

    /// The least bound of |u| in some samples.
    pub(super) fn least_u(&self, range: RangeInclusive<usize>) -> f32 {
        let each = range.filter_map(|i| self.get(i));
        each.fold(f32::INFINITY, |least, r| smaller(least, r.allowed.most_u))
    }

    /// The greatest.
    pub(super) fn loosest_u(&self, range: RangeInclusive<usize>) -> f32 {
        let each = range.filter_map(|i| self.get(i));
        each.fold(0.0, |most, r| larger(most, r.allowed.most_u))
    }

    /// First and last record of the piece that a record is in, as far as known.
    pub(super) fn piece(&self, at: usize) -> (usize, usize) {
        let mut first = at;
        while first > 0 && self.get(first).is_some_and(|r| !r.begins) {
            first = first.saturating_sub(1);
        }
        let mut last = at;
        while last.saturating_add(1) < self.len() && self.get(last).is_some_and(|r| !r.ends) {
            last = last.saturating_add(1);
        }
        (first, last)
    }
}
