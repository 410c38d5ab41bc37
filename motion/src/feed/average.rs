//! The mean over the last τ: what makes the acceleration continuous.

use super::inner::InnerStep;
use super::limits::{Plan, float};
use crate::profile::{Phase, State};

/// The last macrosteps of the unsmoothed motion.
#[derive(Clone, Debug)]
pub(super) struct Average<const M: usize> {
    last: [InnerStep; M],
    oldest: usize,
    end: State,
}

impl<const M: usize> Average<M> {
    /// At rest at s = 0.
    pub(super) const fn new() -> Self {
        Self {
            last: [InnerStep::REST; M],
            oldest: 0,
            end: State::REST,
        }
    }

    /// Where the smoothed motion is.
    pub(super) fn end(&self) -> State {
        self.end
    }

    /// The same if the unsmoothed motion has not gone against `side` (±1) in the last τ.
    pub(super) fn behind<const N: usize>(&self, side: f64, plan: &Plan<N>) -> Option<f64> {
        let mut last = self.last.iter().take(plan.averaged);
        last.all(|step| side * step.v >= 0.0).then_some(self.end.p)
    }

    /// Puts in one macrostep: the cubic that the mean makes of it.
    ///
    /// The mean of a piecewise constant acceleration over m steps changes linearly, by
    /// `(a_k − a_(k−m))/τ`: jerk is constant in a macrostep and s a cubic. Sums are made anew each time,
    /// relative to the present position, so that rounding does not add up and rest is exact.
    pub(super) fn step<const N: usize>(
        &mut self,
        now: InnerStep,
        after_s: f64,
        after_v: f64,
        plan: &Plan<N>,
    ) -> Phase {
        let h = plan.step;
        let from = self.end;
        let mut phase = Phase {
            t: h,
            j: 0.0,
            a0: from.a,
            v0: from.v,
            p0: from.p,
        };
        if plan.averaged == 0 {
            phase.a0 = now.a;
            self.end = State {
                p: after_s,
                v: after_v,
                a: now.a,
                j: 0.0,
            };
            return phase;
        }
        if let Some(slot) = self.last.get_mut(self.oldest) {
            phase.j = (now.a - slot.a) / plan.tau;
            *slot = now;
        }
        self.oldest = self.oldest.saturating_add(1);
        if self.oldest >= plan.averaged {
            self.oldest = 0;
        }
        let (mut p, mut v, mut a) = (0.0, 0.0, 0.0);
        for step in self.last.iter().take(plan.averaged) {
            p += step.s - after_s + h * (0.5 * step.v + h * step.a / 6.0);
            v += step.v + 0.5 * h * step.a;
            a += step.a;
        }
        let m = float(plan.averaged);
        self.end = State {
            p: after_s + p / m,
            v: v / m,
            a: a / m,
            j: phase.j,
        };
        phase
    }
}
