//! Homing the axes of a robot one after the other.

use super::{Edp, HomingProgress};
use crate::edp::drives::Task;
use crate::edp::homing::{Action, AxisHoming, Inputs};
use crate::edp::mode::{Event, Mode};
use crate::edp::servo::narrow;
use motion::Angle;
use protocol::fault::Cause;
use protocol::message::HomingPhase;
use protocol::time::Micros;
use robots::Robot;

/// Homing in progress.
#[derive(Debug)]
pub(super) struct HomingRun {
    /// Position in the robot's homing order.
    turn: usize,
    axis: usize,
    pub(super) run: AxisHoming,
    reported: Option<HomingPhase>,
    /// The other axes' switches when this axis began: they must not change.
    switches: u8,
}

impl<R: Robot<N> + Copy, const N: usize> Edp<R, N> {
    /// Begin homing the next axis in the robot's order, from `turn` on.
    pub(super) fn home_next(&mut self, turn: usize) {
        let order = self.robot.description().homing.order;
        let next = (0..order.len())
            .zip(&order)
            .skip(turn)
            .find(|(_, k)| self.axes.get(**k).is_some_and(|axis| !axis.homed));
        let Some((turn, axis)) = next else {
            self.homing = None;
            return;
        };
        let (Some(parameters), Some(position), Some(link)) = (
            self.setup.homing.get(*axis).copied(),
            self.setpoint().get(*axis).copied().map(Angle::to_f64),
            self.drives.links().get(*axis),
        ) else {
            return;
        };
        let switches = self.switches();
        let run = AxisHoming::new(parameters, position, link.home_switch());
        self.homing = Some(HomingRun {
            turn,
            axis: *axis,
            run,
            reported: None,
            switches,
        });
    }

    /// One bit per axis.
    pub(super) fn switches(&self) -> u8 {
        let links = self.drives.links().iter();
        (0..N).zip(links).fold(0, |bits, (k, link)| {
            bits | u8::from(link.home_switch()) << (k & 7)
        })
    }

    #[expect(
        clippy::too_many_lines,
        reason = "one step of the sequence, told in order"
    )]
    pub(super) fn homing_setpoint(&mut self, now: Micros) -> motion::Setpoint<N> {
        let mut setpoint = motion::Setpoint::at_rest(self.gate.positions());
        let switches = self.switches();
        let Some(homing) = &mut self.homing else {
            return setpoint;
        };
        let k = homing.axis;
        let (Some(axis), Some(link)) = (self.axes.get(k), self.drives.links().get(k)) else {
            return setpoint;
        };
        let foreign = (switches ^ homing.switches) & !(1_u8 << (k & 7)) != 0;
        let inputs = Inputs {
            switch: link.home_switch(),
            index_rad: link.index().map(|units| axis.rad(axis.unwrapped(units))),
            origin_rad: axis.rad(0),
        };
        let result = if foreign && self.mode == Mode::Synchronising {
            Err(Cause::HomingForeignSwitch)
        } else {
            homing.run.step(inputs, self.setup.servo_step_s)
        };
        if homing.reported != Some(homing.run.phase()) {
            homing.reported = Some(homing.run.phase());
            self.homing_report = Some(HomingProgress {
                axis: u8::try_from(k).unwrap_or(u8::MAX),
                phase: homing.run.phase(),
            });
        }
        let out = match result {
            Ok(out) => out,
            Err(cause) => {
                // `raise` makes the axis slow down; this step it goes on as it was
                self.raise(now, cause, Some(k));
                let Some(homing) = &mut self.homing else {
                    return setpoint;
                };
                match homing.run.step(Inputs::default(), self.setup.servo_step_s) {
                    Ok(out) => out,
                    Err(_) => return setpoint,
                }
            }
        };
        let (Some(axis), Some(link)) = (self.axes.get_mut(k), self.drives.link_mut(k)) else {
            return setpoint;
        };
        let mut finished = false;
        match out.action {
            Action::None => {}
            Action::ArmIndex => link.request(Task::ArmIndex),
            Action::SetZero { index_rad } => {
                let zero = axis.units(Angle::bound(index_rad));
                let shift = axis.angle(zero).quanta();
                axis.set_zero(zero);
                self.gate.shift(k, shift.saturating_neg());
                for (p, past) in setpoint.position.iter_mut().zip(self.gate.positions()) {
                    *p = past;
                }
            }
            Action::Finished => finished = true,
        }
        let mut refused = None;
        let axes = setpoint.position.iter_mut().zip(&mut setpoint.velocity);
        if let Some(((p, v), a)) = axes.zip(&mut setpoint.acceleration).nth(k) {
            match Angle::nearest(out.position) {
                Some(position) => *p = position,
                None => refused = Some((Cause::NotFinite, k)),
            }
            (*v, *a) = (narrow(out.velocity), narrow(out.acceleration));
        }
        if refused.is_none()
            && let Err(violation) = self.gate.pass(&setpoint.position)
        {
            refused = Some((violation.cause(), violation.axis));
        }
        if let Some((cause, axis)) = refused {
            self.violations = self.violations.saturating_add(1);
            self.raise(now, cause, Some(axis));
            setpoint = motion::Setpoint::at_rest(self.gate.positions());
        }
        if matches!(self.mode, Mode::Stopping { .. }) && self.at_rest_after_stop() {
            self.homing = None;
            self.hold_at(setpoint.position);
            let _ = self.on(now, Event::AtRest);
        } else if finished {
            let turn = self.homing.as_ref().map_or(0, |h| h.turn);
            self.hold_at(setpoint.position);
            self.home_next(turn.saturating_add(1));
            if self.homing.is_none() {
                let _ = self.on(now, Event::Synchronised);
                self.hold_at(setpoint.position);
            }
        }
        setpoint
    }
}
