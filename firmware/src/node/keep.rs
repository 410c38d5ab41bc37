//! What the keeper of a node needs of it: signals, and the request that waits.

use super::foreground::{Foreground, mp};
use crate::io::Port;
use crate::maintenance::Asked;
use crate::maintenance::black_box::Signals;
use protocol::frame::Frame;
use protocol::id::NodeId;
use protocol::maintenance::{AxisSample, MaintenanceRefusal, MaintenanceReply, MaintenanceRequest};
use protocol::transfer::TransferId;
use protocol::units::{PerAxis, UNITS_PER_INCREMENT};
use robots::Robot;

impl<R: Robot<N> + Copy, const N: usize> Foreground<R, N> {
    /// Servo steps since the start.
    pub const fn servo_step(&self) -> u32 {
        self.edp.servo_step()
    }

    /// The signals of the last servo step.
    pub fn signals(&self) -> Signals {
        let mut axes = PerAxis::new();
        for (axis, ma) in self.edp.axes().iter().zip(self.edp.currents_ma()) {
            let error = axis
                .demand_from_zero()
                .saturating_sub(axis.actual_from_zero());
            // N ≤ MAX_AXES: the push cannot fail
            let _ = axes.push(AxisSample {
                actual: clamped(axis.actual_from_zero() / UNITS_PER_INCREMENT),
                error: within_i16(error / (UNITS_PER_INCREMENT / 10)),
                current_ma: super::report::milliamps(ma),
            });
        }
        Signals {
            step: self.edp.servo_step(),
            state: self.state(),
            fault: self.edp.mode().fault(),
            instruction: self.agenda.progress().0,
            axes,
        }
    }

    /// A maintenance request arrived: it waits for the keeper. One waits at a time; whoever gets no answer asks again.
    // a frame of its own: what else its caller does must not lie below it on the stack
    #[inline(never)]
    pub(super) fn wait_for_keeper(
        &mut self,
        from: NodeId,
        transfer_id: TransferId,
        request: &MaintenanceRequest,
    ) {
        let epoch = request.epoch().unwrap_or(0);
        let allowed = match self.session.authorise(from.get(), epoch) {
            Err(_) => Err(MaintenanceRefusal::NoLease {
                epoch: self.session.epoch(),
            }),
            Ok(()) if self.edp.mode().torque() => Err(MaintenanceRefusal::TorqueOn {
                state: self.state(),
            }),
            Ok(()) => Ok(()),
        };
        self.asked.get_or_insert(Asked {
            from,
            transfer_id,
            allowed,
            request: request.clone(),
        });
    }

    /// The request that waits, if one does.
    pub const fn take_asked(&mut self) -> Option<Asked> {
        self.asked.take()
    }

    /// Sends the keeper's answer.
    pub fn answer(
        &mut self,
        asked: &Asked,
        reply: &MaintenanceReply,
        tx: &mut impl FnMut(Port, Frame),
    ) {
        // a reply that cannot be encoded is lost like any other frame: it is asked for again
        let _ = self
            .link
            .send_maintenance_reply(asked.from, asked.transfer_id, reply, &mut mp(tx));
    }
}

fn clamped(units: i64) -> i32 {
    let end = if units < 0 { i32::MIN } else { i32::MAX };
    i32::try_from(units).unwrap_or(end)
}

fn within_i16(tenths: i64) -> i16 {
    let end = if tenths < 0 { i16::MIN } else { i16::MAX };
    i16::try_from(tenths).unwrap_or(end)
}
