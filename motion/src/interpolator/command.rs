//! What may be asked of a path under way: another feed rate, a stop, to forget knots.

use super::rate::FeedRate;
use super::report::Moving;
use super::stop::AxisStop;
use super::tail::states;
use super::{Interpolator, Mode, QuickStop, Status, StopCause};

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
        self.feed_override = FeedRate::of(rate);
        self.change_rate();
    }

    pub(super) fn rate_asked(&self) -> FeedRate {
        if self.hold {
            FeedRate::ZERO
        } else {
            self.feed_override
        }
    }

    fn change_rate(&mut self) {
        let rate = self.rate_asked();
        match self.mode {
            Mode::Waiting { starts_at_us } => self.clock.start(starts_at_us, rate),
            Mode::OnPath | Mode::OnTail => self.clock.change_to(rate, self.now_us),
            Mode::Idle | Mode::OffPath | Mode::Stopped { .. } => {}
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
            Mode::OffPath => return QuickStop::OffPath,
            Mode::Waiting { .. } => {}
            Mode::OnPath | Mode::OnTail if self.clock.stands() => {}
            Mode::OnPath | Mode::OnTail => return self.leave_path(),
        }
        let position = self.setpoint.position;
        self.rest(position, Mode::Stopped { cause }, Status::Stopped { cause });
        QuickStop::AtRest
    }

    fn leave_path(&mut self) -> QuickStop {
        if !self.find_way_off_path() {
            self.feed_hold();
            return QuickStop::OnPath;
        }
        self.queue.clear();
        self.mode = Mode::OffPath;
        QuickStop::OffPath
    }

    /// A quick stop inside the position limits, if there is one that integers reach; made where it stays.
    fn find_way_off_path(&mut self) -> bool {
        let off = &mut self.off_path;
        (off.since_us, off.duration_us) = (self.now_us, 0);
        off.from = self.setpoint.position;
        let limits = self.braking.axes.iter().zip(&self.reach);
        let axes = off.axes.iter_mut().zip(states(&self.setpoint));
        for ((axis, (p, v, a)), (braking, (lower, upper))) in axes.zip(limits) {
            let most = braking.stop.a;
            let a = if a > most { most } else { a };
            let a = if a < -most { -most } else { a };
            let Some((stop, (back, forth))) = AxisStop::new(v, a, braking.stop) else {
                return false;
            };
            if p.plus(back) < *lower || p.plus(forth) > *upper {
                return false;
            }
            off.duration_us = off.duration_us.max(stop.duration_us());
            *axis = stop;
        }
        true
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
