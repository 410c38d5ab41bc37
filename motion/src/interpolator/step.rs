//! One servo step: which set-point comes next.

use super::rate::PathTime;
use super::{Interpolator, Mode, OffPath, Output, Status, StopCause};
use crate::angle::Angle;
use crate::knot::Setpoint;
use crate::scalar::{US_PER_S, float_us, narrow};

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
                let position = self.end.position.map(Angle::bound);
                return self.rest(position, Mode::Idle, Status::Idle);
            }
            return self.step_tail(path);
        }
        if let Some(segment) = self.queue.front() {
            if path.us < segment.end_us() {
                timed(&mut self.setpoint, segment.at(path), path, &self.reach);
            } else {
                // the last knot itself
                let states = self.end.axes().map(|[p, v, a]| (p, narrow(v), narrow(a)));
                let states = angles(states);
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
        let after_s = path.since_us(self.end.at_us) / US_PER_S;
        if after_s >= self.tail.duration() {
            let position = self.tail.rest_position(&self.end).map(Angle::bound);
            return self.rest(position, Mode::Stopped { cause }, Status::Stopped { cause });
        }
        self.mode = Mode::OnTail;
        let states = angles(self.tail.at(&self.end, after_s));
        timed(&mut self.setpoint, states, path, &self.reach);
        Status::Stopping { cause }
    }

    fn step_off_path(&mut self, stop: &OffPath<N>) -> Status {
        let cause = StopCause::QuickStop;
        let t = float_us(self.now_us.saturating_sub(stop.since_us)) / US_PER_S;
        let axes = stop.from.iter().zip(&stop.velocity).zip(&self.reach);
        for ((p, (v, a)), ((from, ramp), (lower, upper))) in axes_mut(&mut self.setpoint).zip(axes)
        {
            let state = ramp.at(t);
            let further = from.plus(Angle::bound(state.integral).quanta());
            // takes away rounding only: the end was checked
            *p = further.within(*lower, *upper);
            (*v, *a) = (narrow(state.x), narrow(state.dx));
        }
        if t < stop.duration {
            return Status::Stopping { cause };
        }
        let position = self.setpoint.position;
        self.rest(position, Mode::Stopped { cause }, Status::Stopped { cause })
    }

    pub(super) fn rest(&mut self, position: [Angle; N], mode: Mode<N>, status: Status) -> Status {
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

/// With positions as a set-point has them.
fn angles(
    states: impl Iterator<Item = (f64, f32, f32)>,
) -> impl Iterator<Item = (Angle, f32, f32)> {
    states.map(|(p, v, a)| (Angle::bound(p), v, a))
}

/// Derivatives with respect to path time become derivatives with respect to time.
#[inline]
fn timed<const N: usize>(
    setpoint: &mut Setpoint<N>,
    states: impl Iterator<Item = (Angle, f32, f32)>,
    path: PathTime,
    reach: &[(Angle, Angle); N],
) {
    let (rate, change) = (narrow(path.rate), narrow(path.change));
    let square = rate * rate;
    for (((p, (v, a)), (s, ds, dds)), (lower, upper)) in axes_mut(setpoint).zip(states).zip(reach) {
        // takes away rounding only: the extrema were checked
        *p = s.within(*lower, *upper);
        *v = ds * rate;
        *a = dds * square + ds * change;
    }
}
