//! Watching: the drives, the loops, and the joints behind the motors.

use super::{Edp, drives};
use crate::edp::axis::Axis;
use crate::edp::drives::AxisActual;
use crate::edp::encoder_watch::{EncoderWatch, Suspicion};
use crate::edp::mode::{Event, Mode};
use motion::Angle;
use protocol::canopen::cia402::PowerState;
use protocol::fault::Cause;
use protocol::message::ServoLaw;
use protocol::time::Micros;
use robots::{Joints, Motors, Robot};

/// Overcurrent must last so many servo steps: 20 ms at 2 ms.
const OVERCURRENT_STEPS: u8 = 10;
/// Drives that do not follow within this time after "enable" have a fault.
const ENABLE_TIMEOUT: Micros = Micros::from_millis(3000);
/// What stands outside a joint limit may waver by encoder noise while it comes back, rad or m.
const JOINT_TOLERANCE: f64 = 1e-4;

impl<R: Robot<N> + Copy, const N: usize> Edp<R, N> {
    pub(super) fn measure(&mut self, now: Micros) {
        let mut jump = None;
        let links = self
            .drives
            .links()
            .iter()
            .map(|link| (link.is_ready(), link.actual()));
        for (k, (axis, (ready, actual))) in (0..N).zip(self.axes.iter_mut().zip(links)) {
            let AxisActual {
                position,
                torque,
                fresh,
                ..
            } = actual;
            if ready && fresh && !axis.measure(position, torque) {
                jump = Some(k);
            }
        }
        if let Some(axis) = jump {
            // where it stands is no longer known
            if let Some(axis) = self.axes.get_mut(axis) {
                axis.homed = false;
            }
            self.raise(now, Cause::EncoderJump, Some(axis));
        }
    }

    /// Faults of the drives and of the loops.
    pub(super) fn supervise(&mut self, now: Micros, currents_ma: &[f32; N]) {
        match self.mode {
            Mode::Configuring if self.drives.ready() => {
                let _ = self.on(now, Event::DrivesConfigured);
            }
            Mode::Enabling { .. } => {
                let states = self.drives.links().iter().map(drives::DriveLink::state);
                if states
                    .clone()
                    .all(|s| s == Some(PowerState::OperationEnabled))
                {
                    let _ = self.on(now, Event::Enabled);
                } else if now.since(self.enabling_since) > ENABLE_TIMEOUT {
                    let late = (0..N)
                        .zip(states)
                        .find(|(_, s)| *s != Some(PowerState::OperationEnabled))
                        .map(|(k, _)| k);
                    self.raise(now, Cause::DriveDisabled, late);
                }
            }
            _ => {}
        }
        let latched = matches!(self.mode, Mode::Faulted { .. });
        // While enabling, the drives' old faults are being reset.
        let resetting = matches!(self.mode, Mode::Enabling { .. } | Mode::Disabled)
            && now.since(self.enabling_since) < ENABLE_TIMEOUT;
        if let Some((axis, cause)) = self.drives.fault()
            && !latched
            && !(resetting && cause == Cause::DriveFault)
        {
            self.raise(now, cause, Some(axis));
            return;
        }
        if !self.mode.torque() || matches!(self.mode, Mode::Enabling { .. }) {
            self.encoders.iter_mut().for_each(EncoderWatch::reset);
            return;
        }
        if let Some((cause, axis)) = self.wrong_axis(currents_ma)
            && !latched
        {
            if cause == Cause::Runaway
                && let Some(axis) = self.axes.get_mut(axis)
            {
                // what its encoder tells cannot be trusted
                axis.homed = false;
            }
            self.raise(now, cause, Some(axis));
        }
    }

    /// The axis whose loop is wrong, and how: one that runs away, else the first.
    fn wrong_axis(&mut self, currents_ma: &[f32; N]) -> Option<(Cause, usize)> {
        let velocity = self
            .interpolator
            .get()
            .map_or([0.0; N], |i| i.setpoint().velocity);
        let mut found = None;
        for (k, link) in (0..N).zip(self.drives.links()) {
            let over = libm::fabsf(currents_ma.get(k).copied().unwrap_or(f32::INFINITY))
                > self.setup.overcurrent_ma.get(k).copied().unwrap_or(0.0);
            let (Some(axis), Some(count), Some(encoder), Some(v)) = (
                self.axes.get(k),
                self.overcurrent.get_mut(k),
                self.encoders.get_mut(k),
                velocity.get(k),
            ) else {
                continue;
            };
            *count = if over { count.saturating_add(1) } else { 0 };
            let in_drive = axis.law() == ServoLaw::DrivePosition;
            let (measured, demanded) = (axis.actual_from_zero(), axis.demand_from_zero());
            // an answer that has not come says nothing of the encoder: see DriveSilent
            let wrong = if link.actual().fresh {
                encoder.step(measured, demanded, axis.window_at_rest(), in_drive)
            } else {
                None
            };
            let cause = if wrong == Some(Suspicion::Away) {
                Cause::Runaway
            } else if link.state() != Some(PowerState::OperationEnabled) {
                Cause::DriveDisabled
            } else if *count >= OVERCURRENT_STEPS {
                Cause::OverCurrent
            } else if wrong.is_some() || axis.beyond_window(*v) {
                Cause::FollowingError
            } else {
                continue;
            };
            // one that runs away is not to wait for another that is only late
            if cause == Cause::Runaway || found.is_none() {
                found = Some((cause, k));
            }
        }
        found
    }

    /// Joint limits, once homed.
    pub(super) fn joints_inside(&self, positions: &[Angle; N]) -> Result<(), (Cause, usize)> {
        if !self.homed() || self.guard.accepts(positions) {
            return Ok(());
        }
        let checked = self
            .robot
            .joints(&Motors(positions.map(Angle::to_f64)))
            .and_then(|q| {
                // what stands outside already may come back
                let inside = self.robot.check_joints(&q);
                inside.or_else(|e| if self.closer(&q) { Ok(()) } else { Err(e) })
            });
        checked.map_err(|e| match e {
            robots::KinematicError::Limit { axis, .. } => (Cause::PositionLimit, axis),
            _ => (Cause::Unreachable, 0),
        })
    }

    /// Is every joint that is outside its range no farther outside than where the axis stands?
    pub(super) fn closer(&self, q: &Joints<N>) -> bool {
        let here = Motors(self.axes.each_ref().map(Axis::actual_rad));
        let Ok(here) = self.robot.joints(&here) else {
            return false;
        };
        let ranges = self
            .robot
            .description()
            .axes
            .iter()
            .map(|a| a.joint_position);
        q.0.iter()
            .zip(&here.0)
            .zip(ranges)
            .all(|((q, here), range)| {
                range.contains(*q)
                    || (*q > range.upper && *q <= *here + JOINT_TOLERANCE)
                    || (*q < range.lower && *q >= *here - JOINT_TOLERANCE)
            })
    }
}
