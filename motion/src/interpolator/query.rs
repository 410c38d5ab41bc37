//! What can be known of a path under way.

use super::{Interpolator, Mode, StopTail, Tip};
use crate::knot::Setpoint;

impl<const N: usize, const Q: usize> Interpolator<N, Q> {
    /// Whether the set-point stands, and no command but [`start`](Self::start),
    /// [`resume`](Self::resume) or [`set_override`](Self::set_override) (or the start time) moves it.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        match self.mode {
            Mode::Idle | Mode::Waiting { .. } | Mode::Stopped { .. } => true,
            Mode::OnPath | Mode::OnTail => self.clock.stands(),
            Mode::OffPath => false,
        }
    }

    /// Whether there is no path, and nothing stops one from being started.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        matches!(self.mode, Mode::Idle)
    }

    /// Whether there will be no path after the [step](Self::step) at this time, if nothing comes in between.
    #[must_use]
    pub fn is_idle_by(&self, at_us: u64) -> bool {
        match self.mode {
            Mode::Idle => true,
            Mode::Waiting { .. } | Mode::OnPath => {
                self.end.is_at_rest() && self.clock.at(at_us).is_after(self.end.at_us)
            }
            Mode::OnTail | Mode::OffPath | Mode::Stopped { .. } => false,
        }
    }

    /// Whether the path, as far as it is known, ends at rest: it needs neither a further knot nor its tail.
    #[must_use]
    pub fn ends_at_rest(&self) -> bool {
        match self.mode {
            Mode::Waiting { .. } | Mode::OnPath => self.end.is_at_rest(),
            Mode::OnTail | Mode::OffPath => false,
            Mode::Idle | Mode::Stopped { .. } => true,
        }
    }

    /// The last set-point given.
    #[must_use]
    pub fn setpoint(&self) -> &Setpoint<N> {
        &self.setpoint
    }

    /// Path time at `now_us`, whole µs: what knot times are compared with. Without a path, `now_us`.
    #[must_use]
    pub fn path_time_us(&self, now_us: u64) -> u64 {
        match self.mode {
            Mode::Waiting { .. } | Mode::OnPath | Mode::OnTail => {
                self.clock.at(now_us.max(self.now_us)).us
            }
            Mode::Idle | Mode::OffPath | Mode::Stopped { .. } => now_us,
        }
    }

    /// Path time left until the last knot, µs; 0 without a path and on the stop tail.
    #[must_use]
    pub fn horizon_us(&self, now_us: u64) -> u64 {
        match self.mode {
            Mode::Waiting { .. } | Mode::OnPath => {
                self.end.at_us.saturating_sub(self.path_time_us(now_us))
            }
            Mode::Idle | Mode::OnTail | Mode::OffPath | Mode::Stopped { .. } => 0,
        }
    }

    /// How many more knots fit.
    #[must_use]
    pub fn room(&self) -> usize {
        Q.saturating_sub(self.queue.len())
    }

    /// The stop that happens if no other knot comes, verified when the last one was pushed; `None`
    /// without a path.
    #[must_use]
    pub fn stop_tail(&self) -> Option<StopTail<N>> {
        match self.mode {
            Mode::Waiting { .. } | Mode::OnPath | Mode::OnTail => {
                let position = self.tail.rest_position();
                Some(StopTail {
                    position,
                    at_us: self.end.at_us.saturating_add(self.tail.duration_us()),
                })
            }
            Mode::Idle | Mode::OffPath | Mode::Stopped { .. } => None,
        }
    }

    /// How long a feed hold takes from rate 1, s: a constant of the limits. The path goes on for half of
    /// it, in path time.
    #[must_use]
    pub fn hold_duration_s(&self) -> f64 {
        self.braking.hold_s
    }

    /// Where the path ends, as far as it is known: what the next [piece](super::PathLimits::piece) is made from.
    #[must_use]
    pub fn tip(&self) -> Tip<N> {
        Tip {
            generation: self.generation,
            end: self.end,
        }
    }
}
