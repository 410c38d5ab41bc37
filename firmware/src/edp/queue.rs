//! From the ECP's plan to the set-point queue, and to rest.

use super::Edp;
use crate::ecp::plan::{Ahead, PlannedPiece};
use crate::ecp::refusal;
use motion::Angle;
use motion::interpolator::{StartError, Tip};
use protocol::clock::Line;
use protocol::fault::Refusal;
use protocol::time::Micros;
use robots::{Motors, Robot};

impl<R: Robot<N> + Copy, const N: usize> Edp<R, N> {
    /// What there is to know of the set-point queue for a plan that is ordered now and taken so many servo steps later;
    /// `line` tells local time from the bus'.
    pub fn ahead(&self, now: Micros, steps: u32, line: Line) -> Ahead<N> {
        let period = self.setup.period;
        let taken_at = now + Micros(period.0.saturating_mul(u64::from(steps)));
        // a path that has come to its end in the step before is none any more
        let before = Micros(taken_at.0.saturating_sub(period.0));
        let (tip, begins) = match self.interpolator.get() {
            Some(path) => (path.tip(), path.is_idle_by(before.0)),
            None => (Tip::nowhere(), true),
        };
        Ahead {
            tip,
            begins,
            homed: self.ranges_homed,
            taken_at,
            macrostep: self.setup.macrostep,
            line,
        }
    }

    /// A piece of the ECP's plan comes into the set-point queue.
    ///
    /// # Errors
    /// Why it was refused; it is not in the queue then.
    // a frame of its own: what else its caller does must not lie below it on the stack
    #[inline(never)]
    pub fn queue(&mut self, now: Micros, planned: &PlannedPiece<N>) -> Result<(), Refusal> {
        let state = self.mode.into();
        let PlannedPiece {
            piece,
            timed,
            acceleration_step,
        } = planned;
        let Some(interpolator) = self.interpolator.get_mut() else {
            return Err(Refusal::WrongState { state });
        };
        if interpolator.is_idle() {
            // one macrostep of lead, so that the queue never runs dry between two of them
            let start = if *timed {
                piece.begins_us()
            } else {
                now.0.saturating_add(self.setup.macrostep.0)
            };
            interpolator.start(start).map_err(|error| match error {
                StartError::NotIdle => Refusal::WrongState { state },
                StartError::Late => Refusal::Late,
            })?;
        }
        let pushed = if *timed {
            interpolator.push(piece, now.0)
        } else {
            interpolator.push_whenever(piece, now.0)
        };
        pushed.map_err(|e| refusal::from_push(&e, state))?;
        if *acceleration_step > self.acceleration_step {
            self.acceleration_step = *acceleration_step;
        }
        self.queue_end = Motors(*piece.end());
        Ok(())
    }

    /// The instruction has ended, perhaps in the middle of a motion: come to rest on the path.
    pub fn come_to_rest(&mut self) {
        if let Some(interpolator) = self.interpolator.get_mut()
            && !interpolator.ends_at_rest()
        {
            interpolator.feed_hold();
            self.coming_to_rest = true;
        }
    }

    /// The instruction has ended and nothing of its path is wanted any more: from this servo step on every axis stops as fast
    /// as its limits allow. The path that is queued would go on for 20 to 40 ms.
    pub fn stop_here(&mut self) {
        if let Some(interpolator) = self.interpolator.get_mut() {
            interpolator.quick_stop();
            self.coming_to_rest = true;
        }
    }

    /// Have the set-points come to rest, with nothing left to do?
    pub fn at_rest(&self, now: Micros) -> bool {
        self.interpolator.get().is_none_or(|interpolator| {
            interpolator.is_at_rest()
                && (self.coming_to_rest || interpolator.horizon_us(now.0) == 0)
        })
    }

    /// Drop what is left of a path that was held or stopped.
    pub fn flush(&mut self) {
        if let Some(interpolator) = self.interpolator.get_mut()
            && interpolator.flush().is_ok()
        {
            interpolator.resume();
            self.coming_to_rest = false;
            self.queue_end = Motors(interpolator.setpoint().position.map(Angle::to_f64));
        }
    }
}
