//! One servo step: which set-point comes next.

use super::rate::PathTime;
use super::{Interpolator, Mode, OffPath, Output, Status, StopCause};
use crate::knot::Setpoint;
use crate::scalar::{US_PER_S, float_us, within};

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
            Mode::OffPath(stop) => self.step_off_path(&stop),
            Mode::Stopped { cause } => Status::Stopped { cause },
        };
        Output {
            setpoint: self.setpoint,
            status,
        }
    }

    fn step_path(&mut self) -> Status {
        self.clock.settle(self.now_us);
        let path = self.clock.at(self.now_us);
        self.queue.drop_passed(path.us);
        if path.is_after(self.end.at_us) {
            if self.end.is_at_rest() {
                return self.rest(self.end.position, Mode::Idle, Status::Idle);
            }
            return self.step_tail(path);
        }
        if let Some(segment) = self.queue.front() {
            let since_us = path.since_us(segment.start_us());
            self.setpoint = if path.us >= segment.end.at_us {
                // the knot itself, to the bit
                timed(segment.end.axes(), path, &self.reach)
            } else {
                timed(segment.at(since_us), path, &self.reach)
            };
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
        let after_s = path.since_us(self.end.at_us) / US_PER_S;
        if after_s >= self.tail.duration() {
            let position = self.tail.rest_position(&self.end);
            return self.rest(position, Mode::Stopped { cause }, Status::Stopped { cause });
        }
        self.mode = Mode::OnTail;
        self.setpoint = timed(self.tail.at(&self.end, after_s), path, &self.reach);
        Status::Stopping { cause }
    }

    fn step_off_path(&mut self, stop: &OffPath<N>) -> Status {
        let cause = StopCause::QuickStop;
        let t = float_us(self.now_us.saturating_sub(stop.since_us)) / US_PER_S;
        let mut moving = false;
        let axes = stop.from.iter().zip(&stop.velocity);
        for ((p, (v, a)), (from, ramp)) in axes_mut(&mut self.setpoint).zip(axes) {
            let state = ramp.at(t);
            (*p, *v, *a) = (from + state.integral, state.x, state.dx);
            moving |= t < ramp.duration();
        }
        if moving {
            return Status::Stopping { cause };
        }
        let position = self.setpoint.position;
        self.rest(position, Mode::Stopped { cause }, Status::Stopped { cause })
    }

    pub(super) fn rest(&mut self, position: [f64; N], mode: Mode<N>, status: Status) -> Status {
        self.setpoint = Setpoint::at_rest(position);
        self.queue.clear();
        self.mode = mode;
        status
    }
}

fn axes_mut<const N: usize>(
    setpoint: &mut Setpoint<N>,
) -> impl Iterator<Item = (&mut f64, (&mut f64, &mut f64))> {
    let derivatives = setpoint.velocity.iter_mut().zip(&mut setpoint.acceleration);
    setpoint.position.iter_mut().zip(derivatives)
}

/// Derivatives with respect to path time become derivatives with respect to time.
fn timed<const N: usize>(
    states: impl Iterator<Item = [f64; 3]>,
    path: PathTime,
    reach: &[(f64, f64); N],
) -> Setpoint<N> {
    let mut setpoint = Setpoint::at_rest([0.0; N]);
    let (rate, square) = (path.rate, path.rate * path.rate);
    for (((p, (v, a)), [s, ds, dds]), (lower, upper)) in
        axes_mut(&mut setpoint).zip(states).zip(reach)
    {
        // takes away rounding only: the extrema were checked
        *p = within(s, *lower, *upper);
        *v = ds * rate;
        *a = dds * square + ds * path.change;
    }
    setpoint
}
