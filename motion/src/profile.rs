//! Jerk-limited motion of one axis, and of several together.
//!
//! | | |
//! |---|---|
//! | [`Trajectory`] | several axes from any state to any state in the shortest time; stops; ranges kept |
//! | [`Profile`] | one axis over a distance from rest to rest: small, for a node |
//! | [`PhaseSynchronised`] | several axes from rest to rest on the straight line: small, for a node |
//! | [`check()`] | proves a finished motion from its phases alone, whoever made it |
//!
//! How [`Trajectory`] works: for a given time the reachable distances of an axis form an interval, since
//! motions within limits form a convex set. Both its ends are known in closed form (`farthest`). The
//! earliest arrival is where one of them passes the distance (`earliest`, `search`); an arrival at any other
//! possible time is a mean of the two extremal motions (`blend`), which keeps every limit that both
//! keep. So synchronising axes needs no search, and times that are impossible for an axis show by
//! themselves.

mod blend;
mod brake;
mod check;
mod earliest;
mod farthest;
mod gain;
mod limits;
mod line;
mod rest;
mod search;
mod settle;
mod synchronised;
mod trajectory;
mod turn;

pub use check::{Violation, check};
pub use limits::{AxisBounds, AxisLimits, ProfileError, rest_time};
pub use synchronised::PhaseSynchronised;
pub use trajectory::{Request, Sampler, Synchronisation, Trajectory, TrajectoryError};

use crate::scalar::{SIXTH, cube_root, smaller};

/// Position, velocity, acceleration and jerk of one axis, in the axis' unit, per s, s², s³.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    /// Position.
    pub p: f64,
    /// Velocity.
    pub v: f64,
    /// Acceleration.
    pub a: f64,
    /// Jerk.
    pub j: f64,
}

impl State {
    /// At rest at 0.
    pub const REST: Self = Self {
        p: 0.0,
        v: 0.0,
        a: 0.0,
        j: 0.0,
    };
}

/// Position, velocity and acceleration at an end of a motion, in the axis' unit, per s, s².
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Boundary {
    /// Position.
    pub p: f64,
    /// Velocity.
    pub v: f64,
    /// Acceleration.
    pub a: f64,
}

/// A stretch of time with constant jerk: `p(τ) = p0 + v0·τ + a0·τ²/2 + j·τ³/6`, τ in \[0, t\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Phase {
    /// Length of the phase, s.
    pub t: f64,
    /// Jerk during the phase.
    pub j: f64,
    /// Acceleration at its beginning.
    pub a0: f64,
    /// Velocity at its beginning.
    pub v0: f64,
    /// Position at its beginning.
    pub p0: f64,
}

impl Phase {
    /// The state τ seconds into the phase.
    #[must_use]
    pub fn at(&self, tau: f64) -> State {
        State {
            p: self.p0 + tau * (self.v0 + tau * (0.5 * self.a0 + tau * self.j * SIXTH)),
            v: self.v0 + tau * (self.a0 + tau * 0.5 * self.j),
            a: self.a0 + tau * self.j,
            j: self.j,
        }
    }

    /// The same phase of an axis that moves `k` times as far in the same time.
    fn times(&self, k: f64) -> Self {
        Self {
            t: self.t,
            j: k * self.j,
            a0: k * self.a0,
            v0: k * self.v0,
            p0: k * self.p0,
        }
    }
}

/// The time-optimal jerk-limited motion of one axis over a distance ≥ 0, from rest to rest.
///
/// Seven phases with jerk +j, 0, −j, 0, −j, 0, +j and lengths tj, ta, tj, tv, tj, ta, tj; any of them
/// may have no length. The second half mirrors the first in time, and is computed so: the end is
/// exact, and neither velocity nor acceleration leaves its limit by a rounding error.
///
/// ```
/// use motion::profile::{AxisLimits, Profile};
/// let profile = Profile::new(1.0, &AxisLimits { v: 0.5, a: 1.0, j: 10.0 })?;
/// assert!((profile.duration() - 2.6).abs() < 1e-12); // a/j + v/a + D/v
/// assert_eq!(profile.at(profile.duration()).p, 1.0);
/// # Ok::<(), motion::profile::ProfileError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Profile {
    distance: f64,
    jerk: f64,
    /// Largest acceleration and velocity reached.
    peak_a: f64,
    peak_v: f64,
    /// Lengths of one jerk phase, one phase of constant acceleration, and the cruise.
    tj: f64,
    ta: f64,
    tv: f64,
}

impl Profile {
    /// The fastest motion over `distance` within the limits.
    ///
    /// # Errors
    /// [`ProfileError`]: an argument is not a number or not finite, the distance is negative, a limit
    /// is not positive, or the motion cannot be represented (its duration over- or underflows).
    pub fn new(distance: f64, limits: &AxisLimits) -> Result<Self, ProfileError> {
        limits.validate()?;
        if !distance.is_finite() {
            return Err(ProfileError::NotFinite);
        }
        if distance < 0.0 {
            return Err(ProfileError::NegativeDistance);
        }
        if distance > 0.0 {
            Self::optimal(distance, limits).representable()
        } else {
            Ok(Self::nothing())
        }
    }

    fn nothing() -> Self {
        Self {
            distance: 0.0,
            jerk: 0.0,
            peak_a: 0.0,
            peak_v: 0.0,
            tj: 0.0,
            ta: 0.0,
            tv: 0.0,
        }
    }

    fn optimal(distance: f64, limits: &AxisLimits) -> Self {
        let AxisLimits { v, a, j } = *limits;
        let reaches_a = a / j * a <= v;
        // lengths when the velocity limit is reached
        let (tj, ta) = if reaches_a {
            (a / j, v / a - a / j)
        } else {
            (libm::sqrt(v / j), 0.0)
        };
        let (t_full, peak_full) = (tj + tj + ta, if reaches_a { a } else { smaller(j * tj, a) });
        if distance >= v * t_full {
            return Self {
                distance,
                jerk: j,
                peak_a: peak_full,
                peak_v: v,
                tj,
                ta,
                tv: distance / v - t_full,
            };
        }
        let full = a / j;
        // 2·a·tj²: the distance at which the acceleration limit is just reached
        if reaches_a && distance >= 2.0 * a * full * full {
            let half = 0.5 * (full + libm::sqrt(full * full + 4.0 * (distance / a)));
            let ta = half - 2.0 * full;
            let ta = if ta > 0.0 { ta } else { 0.0 };
            return Self {
                distance,
                jerk: j,
                peak_a: a,
                peak_v: smaller(a * (full + ta), v),
                tj: full,
                ta,
                tv: 0.0,
            };
        }
        let tj = cube_root(0.5 * (distance / j));
        let peak_a = smaller(j * tj, a);
        Self {
            distance,
            jerk: j,
            peak_a,
            peak_v: smaller(peak_a * tj, v),
            tj,
            ta: 0.0,
            tv: 0.0,
        }
    }

    /// Refuses what floating point cannot hold, so that no later evaluation can give a NaN.
    fn representable(self) -> Result<Self, ProfileError> {
        let positive = [self.jerk, self.peak_a, self.peak_v, self.tj];
        let duration = self.duration();
        let held = positive.iter().all(|x| x.is_normal())
            && [self.ta, self.tv].iter().all(|x| x.is_finite())
            && duration.is_finite()
            && (duration * self.peak_v).is_finite();
        if held {
            Ok(self)
        } else {
            Err(ProfileError::NotRepresentable)
        }
    }

    /// Distance covered, in the axis' unit.
    #[must_use]
    pub fn distance(&self) -> f64 {
        self.distance
    }

    /// Length in time, s.
    #[must_use]
    pub fn duration(&self) -> f64 {
        2.0 * self.half() + self.tv
    }

    /// Length of the acceleration, s.
    fn half(&self) -> f64 {
        self.tj + self.ta + self.tj
    }

    /// The state t seconds after the beginning; at rest before it and from the end on.
    #[must_use]
    pub fn at(&self, t: f64) -> State {
        let duration = self.duration();
        if t >= duration {
            return State {
                p: self.distance,
                ..State::default()
            };
        }
        if 2.0 * t <= duration {
            return self.first_half(t);
        }
        let mirrored = self.first_half(duration - t);
        State {
            p: self.distance - mirrored.p,
            v: mirrored.v,
            a: -mirrored.a,
            j: mirrored.j,
        }
    }

    /// The state in the first half of the motion: acceleration and half of the cruise.
    fn first_half(&self, t: f64) -> State {
        let [first, second, third] = self.acceleration();
        let state = if t <= 0.0 || t.is_nan() {
            return State::default();
        } else if t < first.t {
            first.at(t)
        } else if t < first.t + second.t {
            second.at(t - first.t)
        } else if t < self.half() {
            // backwards from the peak, where velocity is known and acceleration is zero
            let left = self.half() - t;
            State {
                p: self.ramp_distance() - left * (self.peak_v - self.jerk * left * left / 6.0),
                v: self.peak_v - 0.5 * self.jerk * left * left,
                a: self.jerk * left,
                j: third.j,
            }
        } else {
            State {
                p: self.ramp_distance() + self.peak_v * (t - self.half()),
                v: self.peak_v,
                ..State::default()
            }
        };
        State {
            v: smaller(state.v, self.peak_v),
            a: smaller(state.a, self.peak_a),
            ..state
        }
    }

    /// Distance covered while accelerating; by symmetry the mean velocity is half the peak.
    fn ramp_distance(&self) -> f64 {
        0.5 * self.peak_v * self.half()
    }

    fn acceleration(&self) -> [Phase; 3] {
        let Self { jerk, tj, ta, .. } = *self;
        let v1 = 0.5 * self.peak_a * tj;
        let p1 = v1 * tj / 3.0;
        let v2 = self.peak_v - v1;
        [
            Phase {
                t: tj,
                j: jerk,
                ..Phase::default()
            },
            Phase {
                t: ta,
                j: 0.0,
                a0: self.peak_a,
                v0: v1,
                p0: p1,
            },
            Phase {
                t: tj,
                j: -jerk,
                a0: self.peak_a,
                v0: v2,
                p0: p1 + 0.5 * (v1 + v2) * ta,
            },
        ]
    }

    /// The seven phases as data, in order: what an independent checker reads.
    #[must_use]
    pub fn phases(&self) -> [Phase; 7] {
        let [first, second, third] = self.acceleration();
        let mirror = |phase: &Phase| {
            let end = phase.at(phase.t);
            Phase {
                t: phase.t,
                j: phase.j,
                a0: -end.a,
                v0: end.v,
                p0: self.distance - end.p,
            }
        };
        let cruise = Phase {
            t: self.tv,
            v0: self.peak_v,
            p0: self.ramp_distance(),
            ..Phase::default()
        };
        [
            first,
            second,
            third,
            cruise,
            mirror(&third),
            mirror(&second),
            mirror(&first),
        ]
    }
}
