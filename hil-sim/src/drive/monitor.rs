//! What stops the axis without the node: receptors, SYNC, set-points, current, following error.

use protocol::canopen::cia402::{AbortConnection, Command, Event, Power, Stop};
use protocol::canopen::emcy::{Emergency, ErrorCode};

use crate::plant::axis::Sensed;

use super::parameters::MS;
use super::servo::Setpoint;
use super::{SimDrive, slots};

/// After so many cycles without SYNC or set-point the drive stops by itself.
pub(super) const PATIENCE: u8 = 3;

/// The index may lie this part of a turn beside where it was. ASSUMED: 11°, wider than an index and its switching.
const LINES_TOLERANCE: i64 = 32;

/// How long the home switch must rest to count inside the drive.
const DEBOUNCE_NS: u64 = 2 * MS;

impl SimDrive {
    /// Takes what the axis senses.
    #[inline]
    pub(super) fn sense(&mut self, sensed: &Sensed) {
        let changed = sensed.home != self.sensed.home
            || sensed.negative_limit != self.sensed.negative_limit
            || sensed.positive_limit != self.sensed.positive_limit;
        self.sensed = *sensed;
        if let Some(count) = sensed.index {
            self.check_lines(count);
        }
        let latched = self.probe();
        if changed || latched {
            self.poll_at_ns = 0;
        }
        if sensed.home == self.home.level {
            self.home.differs_since_ns = None;
        } else {
            let since = *self.home.differs_since_ns.get_or_insert(self.now_ns);
            if self.now_ns - since >= DEBOUNCE_NS {
                self.home.level = sensed.home;
                self.home.differs_since_ns = None;
            }
        }
        if let Some(code) = self.injected
            && self.errors.code != code
        {
            self.fail(code);
        }
    }

    /// Between two index pulses lie whole turns of the encoder, or its lines are not counted right.
    fn check_lines(&mut self, count: i64) {
        let turn = i64::from(self.p.increments_per_turn);
        let here = count.rem_euclid(turn);
        let first = *self.index.get_or_insert(here);
        let off = (here - first).rem_euclid(turn);
        let tolerance = turn / LINES_TOLERANCE;
        if off > tolerance && turn - off > tolerance && !self.has_failed() {
            self.fail(ErrorCode::ENCODER);
        }
    }

    /// Watches an axis that has torque.
    #[inline]
    pub(super) fn watch(&mut self) {
        if self.power == Power::Enabled && self.mode.is_cyclic() && self.period_ns > 0 {
            // Half a period of grace: SYNC itself may be delayed by a frame on the wire.
            let limit = self.period_ns * u64::from(PATIENCE) + self.period_ns / 2;
            let late = |last| self.now_ns.saturating_sub(last) > limit;
            if self.last_sync_ns.is_some_and(late) {
                self.last_sync_ns = None;
                self.connection_lost(ErrorCode::SYNC_LOST);
            }
        }
        self.watch_tightly();
        let over = self.sensed.current_a.abs() > self.p.over_current_a;
        if over {
            let since = *self.over_current_since_ns.get_or_insert(self.now_ns);
            if self.now_ns - since >= self.p.over_current_ns && !self.has_failed() {
                self.fail(ErrorCode::OVER_CURRENT);
            }
        } else {
            self.over_current_since_ns = None;
        }
        self.watch_following();
    }

    fn watch_following(&mut self) {
        let (window, timeout) = self.following_window;
        let error = match self.servo.setpoint() {
            Setpoint::Line { .. } | Setpoint::Profile(_) => {
                self.demand_rad() - self.scale.rad(self.sensed.count)
            }
            Setpoint::Free
            | Setpoint::Speed { .. }
            | Setpoint::Torque { .. }
            | Setpoint::Brake { .. }
            | Setpoint::Jog { .. } => 0.0,
        };
        if error.abs() <= window {
            self.following_since_ns = None;
            return;
        }
        let since = *self.following_since_ns.get_or_insert(self.now_ns);
        if self.now_ns - since >= timeout && !self.has_failed() {
            self.fail(ErrorCode::FOLLOWING_ERROR);
        }
    }

    const fn has_failed(&self) -> bool {
        match self.power {
            Power::FaultReaction | Power::Fault => true,
            Power::NotReady
            | Power::Disabled
            | Power::Ready
            | Power::SwitchedOn
            | Power::Enabled
            | Power::Leaving { .. }
            | Power::QuickStop { .. } => false,
        }
    }

    /// A fault: told, kept, and reacted to. Without an encoder no ramp can be followed: torque off at once.
    pub(super) fn fail(&mut self, code: ErrorCode) {
        self.report(code);
        let reaction = self.options;
        if code == ErrorCode::ENCODER {
            self.options.fault = Stop::Coast;
        }
        self.transition(Event::Fault);
        self.options = reaction;
    }

    /// Tells and keeps an error.
    pub(super) fn report(&mut self, code: ErrorCode) {
        self.errors.code = code;
        self.errors.register.0 |= code.register().0;
        self.history.push(code, 0);
        self.publish_history();
        let register = self.errors.register;
        self.announce(Emergency {
            code,
            register,
            detail: [0; 5],
        });
    }

    /// Writes the errors that happened into object 1003.
    pub(super) fn publish_history(&mut self) {
        self.od
            .set(slots::ERROR_COUNT, u32::from(self.history.len()));
        for (place, sub) in (0..4).zip(1..) {
            let error = self.history.get(sub).unwrap_or(0);
            self.od.set(slots::ERROR_NEWEST + place, error);
        }
    }

    /// The node is lost (object 6007 says what to do), or left us on purpose (`NONE`).
    ///
    /// Without torque there is nothing to stop and nothing to report.
    pub(super) fn connection_lost(&mut self, code: ErrorCode) {
        match self.power {
            Power::Enabled | Power::Leaving { .. } | Power::QuickStop { stand: true } => {}
            Power::NotReady
            | Power::Disabled
            | Power::Ready
            | Power::SwitchedOn
            | Power::QuickStop { stand: false }
            | Power::FaultReaction
            | Power::Fault => return,
        }
        if code != ErrorCode::NONE {
            self.report(code);
        }
        match self.abort_connection {
            AbortConnection::Nothing => {}
            AbortConnection::Fault => self.transition(Event::Fault),
            AbortConnection::DisableVoltage => {
                self.transition(Event::Command(Command::DisableVoltage));
            }
            AbortConnection::QuickStop => self.stop_quickly(),
        }
    }
}
