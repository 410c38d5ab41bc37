//! One servo step: which set-point comes next.

use super::rate::PathTime;
use super::tail::states;
use super::{Interpolator, Mode, Output, Status, StopCause};
use crate::angle::Angle;
use crate::knot::Setpoint;

impl<const N: usize, const Q: usize> Interpolator<N, Q> {
    /// The set-point for `now_us`. Called once every servo step; time never goes back.
    // a function of its own, so that what it costs can be counted
    #[inline(never)]
    pub fn step(&mut self, now_us: u64) -> Output<N> {
        self.now_us = self.now_us.max(now_us);
        if let Mode::Waiting { starts_at_us } = self.mode
            && self.now_us > starts_at_us
        {
            self.mode = Mode::OnPath;
        }
        let status = match self.mode {
            Mode::Idle => Status::Idle,
            Mode::Waiting { starts_at_us } => Status::Waiting { starts_at_us },
            Mode::OnPath | Mode::OnTail => self.step_path(),
            Mode::OffPath => self.step_off_path(),
            Mode::Stopped { cause } => Status::Stopped { cause },
        };
        Output {
            setpoint: self.setpoint,
            status,
        }
    }

    fn step_path(&mut self) -> Status {
        let path = self.clock.step(self.now_us);
        self.queue.drop_passed(path.us);
        if path.is_after(self.end.at_us) {
            if self.end.is_at_rest() {
                let position = self.tail.from().position;
                let status = self.rest(position, Mode::Idle, Status::Idle);
                // so that a path that begins here begins where the set-point is
                self.end.position = position.map(Angle::to_f64);
                return status;
            }
            return self.step_tail(path);
        }
        if let Some(segment) = self.queue.front() {
            if let Some(states) = segment.at(path) {
                timed(&mut self.setpoint, states, path, &self.reach);
            } else {
                // the last knot itself
                let states = states(self.tail.from());
                timed(&mut self.setpoint, states, path, &self.reach);
            }
        }
        match self.clock.changing_to() {
            Some(target) => Status::Changing {
                rate: path.rate,
                target,
            },
            None if path.rate > 0.0 => Status::Following { rate: path.rate },
            None => Status::Held,
        }
    }

    fn step_tail(&mut self, path: PathTime) -> Status {
        let cause = StopCause::Underrun;
        let since_us = path.us.saturating_sub(self.end.at_us);
        if since_us >= self.tail.duration_us() {
            let position = self.tail.rest_position();
            return self.rest(position, Mode::Stopped { cause }, Status::Stopped { cause });
        }
        self.mode = Mode::OnTail;
        let fades = self.braking.axes.iter().map(|axis| &axis.fade);
        let states = self.tail.at(fades, (since_us, path.fraction));
        timed(&mut self.setpoint, states, path, &self.reach);
        Status::Stopping { cause }
    }

    fn step_off_path(&mut self) -> Status {
        let cause = StopCause::QuickStop;
        let off = &self.off_path;
        let since_us = self.now_us.saturating_sub(off.since_us);
        let axes = off.from.iter().zip(&off.axes).zip(&self.reach);
        for ((p, (v, a)), ((from, stop), (lower, upper))) in axes_mut(&mut self.setpoint).zip(axes)
        {
            let (way, velocity, acceleration) = stop.at(since_us);
            // takes away rounding only: the end was checked
            *p = from.plus(way).within(*lower, *upper);
            (*v, *a) = (velocity, acceleration);
        }
        if since_us < off.duration_us {
            return Status::Stopping { cause };
        }
        let position = self.setpoint.position;
        self.rest(position, Mode::Stopped { cause }, Status::Stopped { cause })
    }

    pub(super) fn rest(&mut self, position: [Angle; N], mode: Mode, status: Status) -> Status {
        self.setpoint = Setpoint::at_rest(position);
        self.queue.clear();
        self.mode = mode;
        status
    }
}

fn axes_mut<const N: usize>(
    setpoint: &mut Setpoint<N>,
) -> impl Iterator<Item = (&mut Angle, (&mut f32, &mut f32))> {
    let derivatives = setpoint.velocity.iter_mut().zip(&mut setpoint.acceleration);
    setpoint.position.iter_mut().zip(derivatives)
}

/// Derivatives with respect to path time become derivatives with respect to time.
#[inline]
fn timed<const N: usize>(
    setpoint: &mut Setpoint<N>,
    states: impl Iterator<Item = (Angle, f32, f32)>,
    path: PathTime,
    reach: &[(Angle, Angle); N],
) {
    let PathTime { rate, change, .. } = path;
    let square = rate * rate;
    for (((p, (v, a)), (s, ds, dds)), (lower, upper)) in axes_mut(setpoint).zip(states).zip(reach) {
        // takes away rounding only: the extrema were checked
        *p = s.within(*lower, *upper);
        *v = ds * rate;
        *a = dds * square + ds * change;
    }
}
