//! The stream of samples.

use super::Feed;
use super::inner::Heading;
use super::sample::{Allowed, Between, PushError, Sample, Short};
use crate::scalar::narrow;

#[derive(Clone, Copy, Debug)]
pub(super) struct Pending<const N: usize> {
    sample: Short<N>,
    /// In the cell before it.
    between: Between<N>,
    s: f64,
}

impl<const N: usize, const W: usize, const M: usize> Feed<N, W, M> {
    /// How many samples will be taken now.
    #[must_use]
    pub fn room(&self) -> usize {
        W.saturating_sub(self.window.len())
            .saturating_add(self.droppable())
    }

    /// The smallest s to which the motion can go back.
    #[must_use]
    pub fn retained_from(&self) -> f64 {
        self.window.get(0).map_or(0.0, |r| r.s)
    }

    /// Forgets what lies before s, as far as no step can need it; nothing while going back. For a caller that
    /// has no room for the path itself.
    pub fn discard_before(&mut self, s: f64) {
        if self.inner.heading == Heading::Backward {
            return;
        }
        for _ in 0..W {
            let needed = *self.window.range(self.inner.cell).start();
            let old = self.window.get(1).is_some_and(|next| next.s <= s);
            if needed == 0 || !old {
                return;
            }
            self.drop_oldest();
        }
    }

    fn drop_oldest(&mut self) {
        self.window.drop_oldest();
        self.inner.cell = self.inner.cell.saturating_sub(1);
        self.first = self.first.saturating_sub(1);
        self.front = self.front.saturating_sub(1);
    }

    /// Records that no step can need any more: not those that bear on the present cell, nor a quarter
    /// of the window behind it, kept for going back; none while going back.
    fn droppable(&self) -> usize {
        match self.inner.heading {
            Heading::Forward => self
                .window
                .range(self.inner.cell)
                .start()
                .saturating_sub(W / 4),
            Heading::Backward => 0,
        }
    }

    /// The next sample, at a grid step from the one before; the first of a piece at the end of the
    /// piece before.
    ///
    /// # Errors
    /// [`PushError`].
    pub fn push(&mut self, sample: &Sample<N>) -> Result<(), PushError> {
        self.accept(sample)?;
        let sample = sample.short();
        let Some(pending) = self.pending else {
            Allowed::new(&sample, &Between::NOTHING, &self.plan)?;
            let s = self.next_s;
            self.pending = Some(Pending {
                sample,
                between: Between::NOTHING,
                s,
            });
            return Ok(());
        };
        let between = Between::new(&pending.sample, &sample, narrow(self.plan.grid));
        Allowed::new(&sample, &between, &self.plan)?;
        let allowed = Allowed::new(&pending.sample, &pending.between.or(&between), &self.plan)?;
        self.put(pending.s, allowed, false);
        let s = pending.s + self.plan.grid;
        self.pending = Some(Pending { sample, between, s });
        Ok(())
    }

    /// The last sample of a piece, `fraction` ∈ (0, 1] of a grid step from the one before: the motion
    /// comes to rest there. What is pushed next begins another piece at the same s.
    ///
    /// # Errors
    /// [`PushError`].
    pub fn end_piece(&mut self, sample: &Sample<N>, fraction: f64) -> Result<(), PushError> {
        self.accept(sample)?;
        if self.room() < 2 {
            return Err(PushError::Full);
        }
        let Some(pending) = self.pending else {
            return Err(PushError::Fraction);
        };
        if !(fraction > 0.0 && fraction <= 1.0) {
            return Err(PushError::Fraction);
        }
        let length = fraction * self.plan.grid;
        let sample = sample.short();
        let between = Between::new(&pending.sample, &sample, narrow(length));
        let last = Allowed::new(&sample, &between, &self.plan)?;
        let allowed = Allowed::new(&pending.sample, &pending.between.or(&between), &self.plan)?;
        self.put(pending.s, allowed, false);
        self.next_s = pending.s + length;
        self.put(self.next_s, last, true);
        self.pending = None;
        Ok(())
    }

    /// No more will come: where the last piece ends, the path does.
    ///
    /// # Errors
    /// [`PushError::Finished`] inside a piece.
    pub fn finish(&mut self) -> Result<(), PushError> {
        if self.pending.is_some() {
            return Err(PushError::Finished);
        }
        self.finished = true;
        Ok(())
    }

    fn accept(&self, sample: &Sample<N>) -> Result<(), PushError> {
        if self.finished {
            return Err(PushError::Finished);
        }
        if self.room() == 0 {
            return Err(PushError::Full);
        }
        sample.validate()
    }

    fn put(&mut self, s: f64, allowed: Allowed<N>, ends: bool) {
        if self.window.len() == W && self.droppable() > 0 {
            self.drop_oldest();
        }
        self.window.push(s, allowed, self.begins, ends);
        self.begins = ends;
    }
}
