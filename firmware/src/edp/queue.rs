//! From the ECP's plan to knots of the set-point queue, and to rest.

use super::Edp;
use crate::ecp::MotorKnot;
use crate::ecp::plan::When;
use motion::interpolator::PushError;
use motion::{Angle, Knot};
use protocol::clock::Clock;
use protocol::fault::{Quantity, Refusal};
use protocol::message::NodeState;
use protocol::time::Micros;
use robots::{Motors, Robot};

impl<R: Robot<N> + Copy, const N: usize> Edp<R, N> {
    /// A knot of the ECP's plan comes into the set-point queue; `clock` tells local time from the bus'.
    ///
    /// # Errors
    /// Why it was refused; it is not in the queue then.
    // a frame of its own: what else its caller does must not lie below it on the stack
    #[inline(never)]
    pub fn queue(
        &mut self,
        now: Micros,
        knot: &MotorKnot<N>,
        clock: &Clock,
    ) -> Result<(), Refusal> {
        let macrostep = self.setup.macrostep;
        let Some(interpolator) = self.interpolator.get_mut() else {
            return Err(Refusal::WrongState {
                state: self.mode.into(),
            });
        };
        let before = if interpolator.is_idle() {
            // one macrostep of lead, so that the queue never runs dry between two of them
            let start = match knot.when {
                When::At(at) => {
                    let at = clock.to_local(at);
                    if at.since(now) > macrostep {
                        Micros(at.0.saturating_sub(macrostep.0))
                    } else {
                        now
                    }
                }
                When::Half | When::Rest | When::Whole => now + macrostep,
            };
            interpolator
                .start(start.0)
                .map_err(|_| Refusal::WrongState {
                    state: self.mode.into(),
                })?;
            start
        } else {
            self.last_knot_at
        };
        let at = knot.when.after(before, macrostep, clock);
        let MotorKnot {
            motion,
            has_acceleration,
            ..
        } = knot;
        let next = Knot {
            at_us: at.0,
            position: motion.position.0,
            velocity: motion.velocity,
            acceleration: has_acceleration.then_some(motion.acceleration),
        };
        let accepted = interpolator
            .push(next, now.0)
            .map_err(|e| from_push(&e, self.mode.into()))?;
        if !has_acceleration {
            for step in accepted.acceleration_step {
                if step > self.acceleration_step {
                    self.acceleration_step = step;
                }
            }
        }
        self.last_knot_at = at;
        self.queue_end = motion.position;
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

fn from_push(error: &PushError, state: NodeState) -> Refusal {
    let axis_of = |axis: usize| u8::try_from(axis).unwrap_or(u8::MAX);
    match *error {
        PushError::NotStarted | PushError::Stopped { .. } => Refusal::WrongState { state },
        PushError::Full => Refusal::QueueFull,
        PushError::NotMonotone { .. } => Refusal::NotMonotone,
        PushError::Late { .. } => Refusal::Late,
        PushError::NotFinite { axis } => Refusal::NotFinite {
            index: axis_of(axis),
        },
        PushError::Limit {
            axis,
            quantity,
            value,
            limit,
        } => Refusal::Limit {
            axis: axis_of(axis),
            quantity: match quantity {
                motion::knot::Quantity::Position => Quantity::MotorPosition,
                motion::knot::Quantity::Velocity => Quantity::Velocity,
                motion::knot::Quantity::Acceleration => Quantity::Acceleration,
                motion::knot::Quantity::Jerk => Quantity::Jerk,
            },
            value,
            limit,
        },
        PushError::Long => Refusal::OutOfRange {
            index: 0,
            value: f32::INFINITY,
            lower: 0.0,
            upper: 4294.0,
        },
        PushError::NoRoomToStop { axis, value, limit } | PushError::Far { axis, value, limit } => {
            Refusal::Limit {
                axis: axis_of(axis),
                quantity: Quantity::MotorPosition,
                value,
                limit,
            }
        }
        PushError::AccelerationStep { axis, value, limit } => Refusal::Limit {
            axis: axis_of(axis),
            quantity: Quantity::Acceleration,
            value,
            limit,
        },
    }
}
