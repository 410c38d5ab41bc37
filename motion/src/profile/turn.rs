//! Motions that would leave the range of positions: they turn at its end instead.
//!
//! The fastest motion that stays in a range either does so by itself, or touches the end that it would
//! leave by: there its velocity is zero and its acceleration points back. That acceleration is the one
//! unknown; before and after the touch the motion is the fastest between its ends. Given more time than
//! that takes, the turn is softer, and at last the axis rests there.
//!
//! Not every turn stays inside: before a hard one the run-up may leave the range by its other end, after a soft one
//! the axis may leave it by the same end once more. What is left between can be narrow: where nothing is inside, the
//! search goes to where it is farthest from leaving.

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
/// What halvings leave of a time, relative.
const TIMELY: f64 = 1e-9;

/// What may be left of a range by rounding, relative to the positions: a tenth of what the checker allows.
pub(super) const SPARE: f64 = 1e-13;

/// By which end a motion leaves its range.
pub(super) fn leaves(phases: &Phases, bounds: &AxisBounds) -> Option<End> {
    let [below, above] = beyond(phases, bounds);
    if above > 0.0 {
        Some(End::Upper)
    } else if below > 0.0 {
        Some(End::Lower)
    } else {
        None
    }
}

/// How far a motion goes beyond the lower and the upper end of the range; not positive inside.
fn beyond(phases: &Phases, bounds: &AxisBounds) -> [f64; 2] {
    let (low, high) = phases.reach();
    let spare = SPARE * larger(low.abs(), high.abs());
    [bounds.p_min - spare - low, high - (bounds.p_max + spare)]
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

/// What comes of an acceleration at the touch.
#[derive(Clone, Copy)]
struct Tried {
    a: f64,
    /// How far beyond the range it leads; 0 inside.
    excess: f64,
    /// How long it takes, s.
    time: f64,
}

impl Tried {
    /// Less far out of the range, or sooner there.
    fn is_better(&self, other: &Self) -> bool {
        self.excess < other.excess || self.excess <= other.excess && self.time < other.time
    }
}

impl Turn<'_> {
    /// The shortest time, or nothing if the axis cannot stay in its range so.
    pub(super) fn earliest(&self) -> Option<f64> {
        self.best().map(|best| best.time)
    }

    /// Draws the motion that takes `time`, not below the [earliest](Self::earliest).
    pub(super) fn draw(&self, out: &mut Phases, time: f64) -> Option<()> {
        let best = self.best()?;
        if let Some(resting) = self.time(0.0).filter(|resting| time >= *resting) {
            return self.write(out, 0.0, time - resting);
        }
        let mut found = best;
        if time > best.time {
            // the time grows as the turn gets softer
            let mut soft = 0.0;
            for _ in 0..REFINEMENTS {
                let a = 0.5 * (soft + found.a);
                let tried = self.tried(a);
                if tried.excess > 0.0 || tried.time > time {
                    soft = a;
                } else {
                    found = tried;
                }
            }
        }
        self.write(out, found.a, larger(time - found.time, 0.0))
    }

    /// The turn with the shortest time.
    fn best(&self) -> Option<Tried> {
        let most = self.most();
        let step = most / f64::from(GRID);
        let mut best = self.tried(0.0);
        let mut consider = |a: f64| {
            let tried = self.tried(a);
            if tried.is_better(&best) {
                best = tried;
            }
            (tried, best)
        };
        let mut middle = 0.0;
        for i in 1..=GRID {
            middle = consider(step * f64::from(i)).1.a;
        }
        let (mut from, mut to) = (larger(middle - step, 0.0), smaller(middle + step, most));
        for _ in 0..REFINEMENTS {
            let (left, right) = (to - GOLDEN * (to - from), from + GOLDEN * (to - from));
            if consider(left).0.is_better(&consider(right).0) {
                to = right;
            } else {
                from = left;
            }
        }
        (best.excess <= 0.0 && best.time.is_finite()).then_some(best)
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

    /// What comes of this acceleration at the touch.
    fn tried(&self, a: f64) -> Tried {
        let Some(legs) = self.legs(a) else {
            return Tried {
                a,
                excess: f64::INFINITY,
                time: f64::INFINITY,
            };
        };
        let mut scratch = Phases::new();
        let mut pen = scratch.pen(self.start, self.end, self.bounds.j_max);
        for leg in &legs {
            leg.draw(&mut pen);
        }
        let [below, above] = beyond(&scratch, self.bounds);
        Tried {
            a,
            excess: larger(larger(below, above), 0.0),
            time: legs.iter().map(|leg| leg.time).sum(),
        }
    }

    /// How long it takes with this acceleration at the touch; nothing if that leaves the range.
    fn time(&self, a: f64) -> Option<f64> {
        let tried = self.tried(a);
        (tried.excess <= 0.0).then_some(tried.time)
    }

    /// Nothing if there is time left to wait, and nowhere to.
    fn write(&self, out: &mut Phases, a: f64, wait: f64) -> Option<()> {
        let [first, second] = self.legs(a)?;
        let rests = |state: &Boundary| libm::fabs(state.v) + libm::fabs(state.a) <= 0.0;
        // with an acceleration at the touch there is rest at an end of the motion at best; else only rounding is left
        let waits = [a <= 0.0, rests(self.start), rests(self.end)];
        let at = waits.iter().position(|rests| *rests);
        if at.is_none() && wait > TIMELY * (first.time + second.time) {
            return None;
        }
        let mut pen = out.pen(self.start, self.end, self.bounds.j_max);
        let wait_at = |pen: &mut Pen<'_>, place: usize| {
            if at == Some(place) {
                pen.wait(wait);
            }
        };
        wait_at(&mut pen, 1);
        first.draw(&mut pen);
        wait_at(&mut pen, 0);
        second.draw(&mut pen);
        wait_at(&mut pen, 2);
        Some(())
    }
}

/// The golden section, (√5 − 1)/2.
const GOLDEN: f64 = 0.618_033_988_749_894_9;
