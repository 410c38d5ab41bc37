//! Telemetry of a node: what has happened, and how things stand.

use super::foreground::{Foreground, mp};
use crate::io::Port;
use protocol::cyphal::Heartbeat;
use protocol::frame::Frame;
use protocol::message::{DemandTrace, Event, Feedback};
use protocol::time::Micros;
use protocol::units::PerAxis;
use robots::Robot;

/// Feedback to the MP every so many servo steps: 10 ms at 2 ms.
pub const FEEDBACK_STEPS: u32 = 5;

impl<R: Robot<N> + Copy, const N: usize> Foreground<R, N> {
    /// What is due in this servo step.
    // a frame of its own: what else its caller does must not lie below it on the stack
    #[inline(never)]
    pub(super) fn report(&mut self, now: Micros, tx: &mut impl FnMut(Port, Frame)) {
        self.collect_events();
        if let Some(event) = self.events.pop_front() {
            let _ = self.link.send_event(&event, &mut mp(tx));
        }
        let step = self.edp.servo_step();
        if self.trace_every > 0 && step.is_multiple_of(u32::from(self.trace_every)) {
            let mut demand = PerAxis::new();
            for axis in self.edp.axes() {
                let _ = demand.push(axis.latest_demand_from_zero());
            }
            let _ = self
                .link
                .send_demand_trace(&DemandTrace { step, demand }, &mut mp(tx));
        }
        if step.is_multiple_of(FEEDBACK_STEPS) {
            let feedback = self.feedback(now);
            let _ = self.link.send_feedback(&feedback, &mut mp(tx));
        }
        let state = self.state();
        self.link.poll_heartbeat(
            now,
            |uptime_s| Heartbeat::of_node(uptime_s, state),
            &mut mp(tx),
        );
    }

    fn collect_events(&mut self) {
        // A full queue loses the newest event: the state itself is in every feedback.
        if !self.announced {
            self.announced = true;
            let _ = self.events.push_back(Event::Announce(self.identity()));
        }
        if let Some(axis) = self.edp.take_configured() {
            let _ = self.events.push_back(Event::DriveReady { axis });
        }
        if let Some(event) = self.edp.take_drive_news() {
            let _ = self.events.push_back(event);
        }
        if let Some(progress) = self.edp.take_homing_progress() {
            let _ = self.events.push_back(Event::Homing {
                axis: progress.axis,
                phase: progress.phase,
            });
        }
        if let Some(fault) = self.edp.take_new_fault() {
            let _ = self.events.push_back(Event::Fault(fault));
        }
    }

    fn feedback(&mut self, now: Micros) -> Feedback {
        let (instruction, progress) = self.agenda.progress();
        let mut feedback = Feedback {
            step: self.edp.servo_step(),
            sampled_at: self.clock.to_bus(self.sampled_at),
            state: self.state(),
            fault: self.edp.mode().fault(),
            synchronised: 0,
            epoch: self.session.epoch(),
            instruction,
            progress,
            horizon_us: u32::try_from(self.edp.horizon_us(now)).unwrap_or(u32::MAX),
            actual: PerAxis::new(),
            demand: PerAxis::new(),
            current_ma: PerAxis::new(),
            following_error: PerAxis::new(),
            limit_violations: self.edp.violations(),
            acceleration_step: self.edp.take_acceleration_step(),
            lost: self.session.lost(),
            force_n: self.wrist.force_n(now),
        };
        let currents = self.edp.currents_ma();
        let errors = self.edp.take_following_errors();
        let axes = self.edp.axes().iter().zip(currents).zip(errors);
        for (k, ((axis, ma), error)) in (0..N).zip(axes) {
            feedback.synchronised |= u8::from(axis.homed) << (k & 7);
            // N ≤ MAX_AXES: the pushes cannot fail
            let _ = feedback.actual.push(axis.actual_from_zero());
            let _ = feedback.demand.push(axis.demand_from_zero());
            let _ = feedback.current_ma.push(milliamps(ma));
            let _ = feedback.following_error.push(error);
        }
        feedback
    }
}

#[expect(clippy::cast_possible_truncation, reason = "the conversion saturates")]
pub(super) fn milliamps(ma: f32) -> i16 {
    libm::roundf(ma) as i16
}
