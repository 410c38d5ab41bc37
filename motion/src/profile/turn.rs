//! Motions that would leave the range of positions: they turn at its end instead.
//!
//! The fastest motion that stays in a range either does so by itself, or touches the end that it would
//! leave by: there its velocity is zero and its acceleration points back. That acceleration is the one
//! unknown; before and after the touch the motion is the fastest between its ends. Given more time than
//! that takes, the turn is softer, and at last the axis rests there.

use super::blend::{Pen, Phases};
use super::brake::Brake;
use super::earliest::{Arrival, Between, Verdict};
use super::farthest::Task;
use super::{AxisBounds, Boundary};
use crate::scalar::{larger, smaller};

/// Accelerations tried first, evenly from none to the most.
const GRID: u32 = 16;
/// Golden sections around the best, or halvings towards a given time: to 1e-9 of the acceleration.
const REFINEMENTS: u32 = 44;

/// What may be left of a range by rounding, relative to the positions: a tenth of what the checker allows.
pub(super) const SPARE: f64 = 1e-13;

/// By which end a motion leaves its range.
pub(super) fn leaves(phases: &Phases, bounds: &AxisBounds) -> Option<End> {
    let (low, high) = phases.reach();
    let spare = SPARE * larger(low.abs(), high.abs());
    if high > bounds.p_max + spare {
        Some(End::Upper)
    } else if low < bounds.p_min - spare {
        Some(End::Lower)
    } else {
        None
    }
}

/// An end of the range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum End {
    Lower,
    Upper,
}

/// A motion to be turned at an end of the range.
pub(super) struct Turn<'a> {
    pub(super) task: &'a Task,
    pub(super) start: &'a Boundary,
    pub(super) end: &'a Boundary,
    pub(super) bounds: &'a AxisBounds,
    pub(super) at: End,
}

/// One of the two parts.
struct Leg {
    brake: Brake,
    arrival: Arrival,
    between: Between,
    time: f64,
}

impl Leg {
    fn fastest(task: &Task) -> Option<Self> {
        let brake = Brake::of(task);
        let arrival = Arrival::new(brake.applied(task));
        let time = arrival.earliest()?;
        let Verdict::Possible(between) = arrival.at(time) else {
            return None;
        };
        let time = time + brake.duration();
        time.is_finite().then_some(Self {
            brake,
            arrival,
            between,
            time,
        })
    }

    fn draw(&self, pen: &mut Pen<'_>) {
        pen.arrive(&self.brake, &self.arrival, &self.between);
    }
}

impl Turn<'_> {
    /// The shortest time, or nothing if the axis cannot stay in its range so.
    pub(super) fn earliest(&self) -> Option<f64> {
        self.best().map(|(_, time)| time)
    }

    /// Draws the motion that takes `time`, not below the [earliest](Self::earliest).
    pub(super) fn draw(&self, out: &mut Phases, time: f64) -> Option<()> {
        let (hardest, least) = self.best()?;
        let mut a = 0.0;
        if let Some(resting) = self.time(0.0).filter(|resting| time >= *resting) {
            return self.write(out, 0.0, time - resting);
        }
        if time > least {
            // the time grows as the turn gets softer
            let (mut soft, mut hard) = (0.0, hardest);
            for _ in 0..REFINEMENTS {
                a = 0.5 * (soft + hard);
                if self.time(a).is_none_or(|t| t > time) {
                    soft = a;
                } else {
                    hard = a;
                }
            }
            a = hard;
            let taken = self.time(a)?;
            return self.write(out, a, larger(time - taken, 0.0));
        }
        a = larger(hardest, a);
        self.write(out, a, 0.0)
    }

    /// The magnitude of the acceleration at the touch with the shortest time.
    fn best(&self) -> Option<(f64, f64)> {
        let most = self.most();
        let step = most / f64::from(GRID);
        let mut best = None;
        let consider = |best: &mut Option<(f64, f64)>, a: f64| {
            let found = self.time(a);
            if let Some(time) = found
                && best.is_none_or(|(_, least)| time < least)
            {
                *best = Some((a, time));
            }
            found.unwrap_or(f64::INFINITY)
        };
        for i in 0..=GRID {
            consider(&mut best, step * f64::from(i));
        }
        let (middle, _) = best?;
        let (mut from, mut to) = (larger(middle - step, 0.0), smaller(middle + step, most));
        for _ in 0..REFINEMENTS {
            let (left, right) = (to - GOLDEN * (to - from), from + GOLDEN * (to - from));
            if consider(&mut best, left) < consider(&mut best, right) {
                to = right;
            } else {
                from = left;
            }
        }
        best
    }

    /// The hardest turn within the limits of acceleration and velocity before and after it.
    fn most(&self) -> f64 {
        let Task {
            v_up,
            v_down,
            a_up,
            a_down,
            ..
        } = *self.task;
        let limit = match self.at {
            End::Upper => a_down,
            End::Lower => a_up,
        };
        smaller(limit, libm::sqrt(2.0 * smaller(v_up, v_down)))
    }

    fn legs(&self, a: f64) -> Option<[Leg; 2]> {
        let (bound, a) = match self.at {
            End::Upper => (self.bounds.p_max, -a),
            End::Lower => (self.bounds.p_min, a),
        };
        let to = (bound - self.start.p) / self.bounds.j_max;
        let first = Leg::fastest(&Task {
            v1: 0.0,
            a1: a,
            distance: to,
            ..*self.task
        })?;
        let second = Leg::fastest(&Task {
            v0: 0.0,
            a0: a,
            distance: self.task.distance - to,
            ..*self.task
        })?;
        Some([first, second])
    }

    /// How long it takes with this acceleration at the touch; nothing if that leaves the range.
    fn time(&self, a: f64) -> Option<f64> {
        let legs = self.legs(a)?;
        let mut scratch = Phases::new();
        let mut pen = scratch.pen(self.start, self.end, self.bounds.j_max);
        for leg in &legs {
            leg.draw(&mut pen);
        }
        leaves(&scratch, self.bounds)
            .is_none()
            .then_some(legs.iter().map(|leg| leg.time).sum())
    }

    fn write(&self, out: &mut Phases, a: f64, wait: f64) -> Option<()> {
        let [first, second] = self.legs(a)?;
        let mut pen = out.pen(self.start, self.end, self.bounds.j_max);
        first.draw(&mut pen);
        // with an acceleration at the touch, only rounding is left to wait for
        if a <= 0.0 {
            pen.wait(wait);
        }
        second.draw(&mut pen);
        Some(())
    }
}

/// The golden section, (√5 − 1)/2.
const GOLDEN: f64 = 0.618_033_988_749_894_9;
