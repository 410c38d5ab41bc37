//! The motion of one axis as phases: an extremal motion, or a mean of two.

use super::brake::Brake;
use super::check::turning_points;
use super::earliest::{Arrival, Between};
use super::farthest::{Farthest, Task};
use super::gain::{Change, Paused, Pulse};
use super::rest::RestToRest;
use super::{Boundary, Phase, State};
use crate::scalar::{SIXTH, larger, smaller, within};

/// Two phases of a brake, and the two times seven of a mean merged (13), or seven each before and after
/// a wait at an end of the range.
const CAPACITY: usize = 17;

/// The phases of one axis.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Phases {
    list: [Phase; CAPACITY],
    count: usize,
    end: Boundary,
    duration: f64,
}

/// A stretch of constant jerk: its length and when it ends, its jerk, the acceleration it begins with, and the
/// velocity of a cruise.
#[derive(Clone, Copy)]
struct Stretch {
    length: f64,
    end: f64,
    jerk: f64,
    a0: f64,
    cruise: Option<f64>,
}

type Shape = [Stretch; 7];

/// The stretches of an extremal motion, in the units of [`super::farthest`]; `sign` is -1 for the mirrored axis.
fn shape(farthest: &Farthest, task: &Task, sign: f64) -> Shape {
    let Farthest { peak, valley, .. } = *farthest;
    let (to_top, top, from_top) = if farthest.cruise > 0.0 {
        (peak, 0.0, -valley)
    } else {
        (peak - valley, valley, 0.0)
    };
    let cruise = (farthest.cruise > 0.0).then_some(sign * task.v_up);
    let mut end = 0.0;
    [
        (peak - task.a0, sign, task.a0, None),
        (farthest.hold_peak, 0.0, peak, None),
        (to_top, -sign, peak, None),
        (farthest.cruise, 0.0, top, cruise),
        (from_top, -sign, top, None),
        (farthest.hold_valley, 0.0, valley, None),
        (task.a1 - valley, sign, valley, None),
    ]
    .map(|(length, jerk, a0, cruise)| {
        end += length;
        Stretch {
            length,
            end,
            jerk,
            a0: sign * a0,
            cruise,
        }
    })
}

/// The stretches of a pulse of acceleration; `sign` is -1 for the mirrored axis.
fn pulse(pulse: &Pulse, sign: f64) -> Shape {
    let Pulse { a0, peak, hold, a1 } = *pulse;
    let mut end = 0.0;
    let still = (0.0, 0.0, a1);
    [
        (peak - a0, sign, a0),
        (hold, 0.0, peak),
        (peak - a1, -sign, peak),
        still,
        still,
        still,
        still,
    ]
    .map(|(length, jerk, a0)| {
        end += length;
        Stretch {
            length,
            end,
            jerk,
            a0: sign * a0,
            cruise: None,
        }
    })
}

/// Where the integration of the jerk stands, in units of the jerk limit.
pub(super) struct Pen<'a> {
    out: &'a mut Phases,
    scale: f64,
    from: f64,
    x: f64,
    v: f64,
    a: f64,
}

impl Pen<'_> {
    /// A stretch of `t` with jerk `j`; the acceleration is what it is known to be, not what rounding made of it,
    /// and so is the velocity of a cruise, which may last.
    fn draw(&mut self, t: f64, j: f64, a: f64, cruise: Option<f64>) {
        if t <= 0.0 {
            return;
        }
        self.a = a;
        self.v = cruise.unwrap_or(self.v);
        if let Some(place) = self.out.list.get_mut(self.out.count) {
            *place = Phase {
                t,
                j: j * self.scale,
                a0: self.a * self.scale,
                v0: self.v * self.scale,
                p0: self.from + self.x * self.scale,
            };
            self.out.count += 1;
        }
        self.x += t * (self.v + t * (0.5 * self.a + t * j * SIXTH));
        self.v += t * (self.a + 0.5 * j * t);
        self.a += j * t;
        self.out.duration += t;
    }
}

impl Phases {
    pub(super) const fn new() -> Self {
        const NONE: Phase = Phase {
            t: 0.0,
            j: 0.0,
            a0: 0.0,
            v0: 0.0,
            p0: 0.0,
        };
        Self {
            list: [NONE; CAPACITY],
            count: 0,
            end: Boundary {
                p: 0.0,
                v: 0.0,
                a: 0.0,
            },
            duration: 0.0,
        }
    }

    pub(super) fn as_slice(&self) -> &[Phase] {
        self.list.get(..self.count).unwrap_or(&[])
    }

    pub(super) fn as_mut_slice(&mut self) -> &mut [Phase] {
        self.list.get_mut(..self.count).unwrap_or(&mut [])
    }

    /// The same motion k times as far, from `start` to `end`.
    pub(super) fn times(&self, k: f64, start: f64, end: Boundary) -> Self {
        let mut scaled = Self {
            end,
            ..self.clone()
        };
        for phase in &mut scaled.list {
            *phase = phase.times(k);
            phase.p0 += start;
        }
        scaled
    }

    /// The state at its end.
    pub(super) fn end(&self) -> Boundary {
        self.end
    }

    /// Length in time, s.
    pub(super) fn duration(&self) -> f64 {
        self.duration
    }

    /// Sets its length in time to what was asked: the sum of its phases is that but for rounding.
    pub(super) fn ends_at(&mut self, time: f64) {
        self.duration = time;
    }

    /// The lowest and the highest position, from the start on.
    pub(super) fn reach(&self) -> (f64, f64) {
        let (mut low, mut high) = (self.end.p, self.end.p);
        for phase in self.as_slice() {
            let turns =
                turning_points(phase).map(|tau| tau.filter(|tau| *tau > 0.0 && *tau < phase.t));
            for tau in turns.into_iter().flatten().chain([0.0]) {
                let p = phase.at(tau).p;
                (low, high) = (smaller(low, p), larger(high, p));
            }
        }
        (low, high)
    }

    /// No motion.
    pub(super) fn clear(&mut self) {
        (self.count, self.duration) = (0, 0.0);
    }

    /// Begins a motion from `start` to `end` with this jerk limit.
    pub(super) fn pen(&mut self, start: &Boundary, end: &Boundary, jerk: f64) -> Pen<'_> {
        (self.count, self.duration, self.end) = (0, 0.0, *end);
        Pen {
            out: self,
            scale: jerk,
            from: start.p,
            x: 0.0,
            v: start.v / jerk,
            a: start.a / jerk,
        }
    }

    /// The state t seconds after the beginning.
    pub(super) fn at(&self, t: f64) -> State {
        let mut left = t;
        if t < self.duration {
            for phase in self.as_slice() {
                if left < phase.t {
                    return phase.at(if left > 0.0 { left } else { 0.0 });
                }
                left -= phase.t;
            }
        }
        let Boundary { p, v, a } = self.end;
        let t = t - self.duration;
        let t = if t > 0.0 { t } else { 0.0 };
        State {
            p: p + t * (v + 0.5 * a * t),
            v: v + a * t,
            a,
            j: 0.0,
        }
    }
}

impl Pen<'_> {
    /// The brake, and then a motion between two extremal ones.
    pub(super) fn arrive(&mut self, brake: &Brake, arrival: &Arrival, between: &Between) {
        self.brake(brake);
        let (up, down) = (&arrival.up.task, &arrival.down.task);
        match between {
            Between::Farthest(far) => self.follow(&shape(far, up, 1.0)),
            Between::Nearest(near) => self.follow(&shape(near, down, -1.0)),
            Between::Both(far, near) => {
                let reach = far.distance + near.distance;
                let share = within((up.distance + near.distance) / reach, 0.0, 1.0);
                let (far, near) = (shape(far, up, 1.0), shape(near, down, -1.0));
                let begin = (self.out.count, self.out.duration, self.x, self.v);
                self.mean(&far, &near, share);
                // Far and near can be wide apart: what rounding of them left of the distance is made good.
                let missed = up.distance - (self.x - begin.2);
                if libm::fabs(missed) > 1e-14 * libm::fabs(up.distance) {
                    (self.out.count, self.out.duration, self.x, self.v) = begin;
                    self.mean(&far, &near, within(share + missed / reach, 0.0, 1.0));
                }
            }
        }
    }

    /// Nothing moves for `time`.
    pub(super) fn wait(&mut self, time: f64) {
        self.draw(time, 0.0, 0.0, None);
    }

    /// A change of velocity; the motion ends wherever that leads.
    pub(super) fn gain(&mut self, brake: &Brake, change: &Change) {
        self.brake(brake);
        self.change(change);
    }

    /// The same, with a pause of so much time.
    pub(super) fn gain_after(&mut self, brake: &Brake, paused: &Paused, pause: f64) {
        self.brake(brake);
        self.draw(paused.lasts, paused.jerk, self.a, None);
        self.draw(pause, 0.0, 0.0, None);
        self.change(&paused.change);
    }

    fn brake(&mut self, brake: &Brake) {
        let [first, second] = brake.times;
        self.draw(first, brake.jerk, self.a, None);
        self.draw(second, 0.0, self.a, None);
    }

    fn change(&mut self, change: &Change) {
        let share = change.share;
        let (rising, falling) = (pulse(&change.rising, 1.0), pulse(&change.falling, -1.0));
        if share >= 1.0 {
            self.follow(&rising);
        } else if share <= 0.0 {
            self.follow(&falling);
        } else {
            self.mean(&rising, &falling, share);
        }
        self.draw(change.kept, 0.0, 0.0, None);
        self.out.end.p = self.from + self.x * self.scale;
    }

    /// A motion from rest to rest in a time not below its own: slower by k in time, all limits hold,
    /// since velocity, acceleration and jerk are smaller by k, k² and k³.
    pub(super) fn stretch(&mut self, way: &RestToRest, time: f64) {
        if way.time <= 0.0 {
            self.draw(time, 0.0, 0.0, None);
            return;
        }
        let k = time / way.time;
        let (acceleration, jerk) = (1.0 / (k * k), 1.0 / (k * k * k));
        for stretch in shape(&way.motion, &way.task, way.sign) {
            self.draw(
                k * stretch.length,
                jerk * stretch.jerk,
                acceleration * stretch.a0,
                stretch.cruise.map(|v| v / k),
            );
        }
    }

    fn follow(&mut self, shape: &Shape) {
        for stretch in shape {
            self.draw(stretch.length, stretch.jerk, stretch.a0, stretch.cruise);
        }
    }

    /// The mean of two motions of the same length: it keeps every limit that both keep, since limits
    /// are convex, and comes where the shares put it.
    fn mean(&mut self, far: &Shape, near: &Shape, share: f64) {
        let (mut fars, mut nears) = (far.iter(), near.iter());
        let (Some(mut f), Some(mut n)) = (fars.next(), nears.next()) else {
            return;
        };
        let (mut t, mut f_from, mut n_from) = (0.0, 0.0, 0.0);
        let other = 1.0 - share;
        for _ in 0..14 {
            let end = smaller(f.end, n.end);
            let (f_a, n_a) = (f.a0 + f.jerk * (t - f_from), n.a0 + n.jerk * (t - n_from));
            self.draw(
                end - t,
                share * f.jerk + other * n.jerk,
                share * f_a + other * n_a,
                f.cruise.zip(n.cruise).map(|(f, n)| share * f + other * n),
            );
            t = larger(end, t);
            if f.end <= end {
                f_from = f.end;
                let Some(next) = fars.next() else { return };
                f = next;
            }
            if n.end <= end {
                n_from = n.end;
                let Some(next) = nears.next() else { return };
                n = next;
            }
        }
    }
}
