//! What may be asked of a path under way: another feed rate, a stop, to forget knots.

use super::report::Moving;
use super::stop::AxisStop;
use super::{Interpolator, Mode, OffPath, QuickStop, Status, StopCause};
use crate::scalar::smaller;

impl<const N: usize, const Q: usize> Interpolator<N, Q> {
    /// Brings the feed rate to 0 on the path, from the last set-point on.
    pub fn feed_hold(&mut self) {
        self.hold = true;
        self.change_rate();
    }

    /// Ends a feed hold: brings the feed rate back to the override.
    pub fn resume(&mut self) {
        self.hold = false;
        self.change_rate();
    }

    /// Sets the feed rate in \[0, 1\] that holds whenever there is no feed hold, now and for later paths.
    /// A value outside is moved to the nearer end, and what is not a number counts as 0.
    pub fn set_override(&mut self, rate: f64) {
        self.feed_override = if rate > 0.0 { smaller(rate, 1.0) } else { 0.0 };
        self.change_rate();
    }

    pub(super) fn rate_asked(&self) -> f64 {
        if self.hold { 0.0 } else { self.feed_override }
    }

    fn change_rate(&mut self) {
        let rate = self.rate_asked();
        match self.mode {
            Mode::Waiting { starts_at_us } => self.clock.start(starts_at_us, rate),
            Mode::OnPath | Mode::OnTail => self.clock.change_to(rate, self.now_us),
            Mode::Idle | Mode::OffPath(_) | Mode::Stopped { .. } => {}
        }
    }

    /// Stops every axis as fast as its hard limits allow, leaving the path.
    ///
    /// Velocity goes to zero in the time-optimal way for limited acceleration and jerk. No other
    /// continuation lowers a rising velocity faster, and one that keeps the velocity limit exists: the
    /// path and its tail. So neither does the stop exceed it. Its position is checked here instead.
    pub fn quick_stop(&mut self) -> QuickStop {
        let cause = StopCause::QuickStop;
        match self.mode {
            Mode::Idle | Mode::Stopped { .. } => return QuickStop::AtRest,
            Mode::OffPath(_) => return QuickStop::OffPath,
            Mode::Waiting { .. } => {}
            Mode::OnPath | Mode::OnTail if self.clock.stands() => {}
            Mode::OnPath | Mode::OnTail => return self.leave_path(),
        }
        let position = self.setpoint.position;
        self.rest(position, Mode::Stopped { cause }, Status::Stopped { cause });
        QuickStop::AtRest
    }

    fn leave_path(&mut self) -> QuickStop {
        let Some(stop) = self.way_off_path() else {
            self.feed_hold();
            return QuickStop::OnPath;
        };
        self.queue.clear();
        self.mode = Mode::OffPath(stop);
        QuickStop::OffPath
    }

    /// A quick stop inside the position limits, if there is one that integers reach.
    fn way_off_path(&self) -> Option<OffPath<N>> {
        let mut off = OffPath {
            since_us: self.now_us,
            duration_us: 0,
            from: self.setpoint.position,
            axes: [AxisStop::NONE; N],
        };
        let states = off.from.iter().zip(
            self.setpoint
                .velocity
                .iter()
                .zip(&self.setpoint.acceleration),
        );
        let limits = self.braking.axes.iter().zip(&self.reach);
        for ((axis, (p, (v, a))), (braking, (lower, upper))) in
            off.axes.iter_mut().zip(states).zip(limits)
        {
            let most = braking.stop.a;
            let a = if *a > most { most } else { *a };
            let a = if a < -most { -most } else { a };
            let (stop, (back, forth)) = AxisStop::new(*v, a, braking.stop)?;
            if p.plus(back) < *lower || p.plus(forth) > *upper {
                return None;
            }
            off.duration_us = off.duration_us.max(stop.duration_us());
            *axis = stop;
        }
        Some(off)
    }

    /// Drops the path and acknowledges a stop: idle at the present position. A feed hold stays.
    ///
    /// # Errors
    /// [`Moving`] when not [at rest](Self::is_at_rest).
    pub fn flush(&mut self) -> Result<(), Moving> {
        if !self.is_at_rest() {
            return Err(Moving);
        }
        let position = self.setpoint.position;
        self.rest(position, Mode::Idle, Status::Idle);
        self.begin(self.now_us);
        Ok(())
    }
}
