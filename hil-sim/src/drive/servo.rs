//! The drive's own loops: set-point generation, velocity observer, position and velocity control.
//!
//! ```text
//! target at SYNC ──▶ interpolation ──▶ P ──▶ + ──▶ PI ──▶ torque limit ──▶ power stage
//!                          └── velocity ─────┘      ▲
//!                                        observer ──┘◀── encoder count
//! ```
//! All in motor radians and newton-metres.

use super::parameters::DriveParameters;

/// Where the set-point comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Setpoint {
    /// None: no torque.
    Free,
    /// csp: a straight line towards the last target, continued until the next comes.
    Line { slope_rad_s: f64 },
    /// csv: a velocity.
    Speed { rad_s: f64 },
    /// cst: a torque.
    Torque { nm: f64 },
    /// A velocity reached by a ramp, with position control: homing, pv, stopping, standing.
    Jog { rad_s: f64, ramp_rad_s2: f64 },
    /// To standstill with the greatest torque (or all that the power stage has), then standing.
    Brake { unlimited: bool },
    /// pp: a trapezoid of velocity to a position.
    Profile(Profile),
}

/// A way to a position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Profile {
    pub(crate) target_rad: f64,
    pub(crate) rad_s: f64,
    pub(crate) accelerate_rad_s2: f64,
    pub(crate) decelerate_rad_s2: f64,
}

impl Profile {
    /// The reference after `dt_s`, from position and velocity.
    ///
    /// The velocity v from which steps of −a·dt end at the target: d = v·dt + (v − a·dt)·dt + … =
    /// v²/2a + v·dt/2, so v = −a·dt/2 + √((a·dt/2)² + 2·a·d).
    fn step(&self, rad: f64, rad_s: f64, dt_s: f64) -> (f64, f64) {
        let way = self.target_rad - rad;
        let sign = if way < 0.0 { -1.0 } else { 1.0 };
        let half = 0.5 * self.decelerate_rad_s2 * dt_s;
        let braking = libm::sqrt(half * half + 2.0 * self.decelerate_rad_s2 * way.abs()) - half;
        let most = self.rad_s.clamp(0.0, way.abs() / dt_s);
        let wanted = sign * braking.clamp(0.0, most);
        // away from the target is slowing down, too
        let slower = wanted.abs() < rad_s.abs() || rad_s * sign < 0.0;
        let change = if slower {
            self.decelerate_rad_s2
        } else {
            self.accelerate_rad_s2
        } * dt_s;
        let next = rad_s + (wanted - rad_s).clamp(-change, change);
        if way.abs() < 1e-9 && next.abs() <= change {
            return (self.target_rad, 0.0);
        }
        (rad + next * dt_s, next)
    }
}

/// The velocity below which the axis counts as standing, rad/s.
const STANDSTILL_RAD_S: f64 = 1.0;

/// The deceleration with which what is left of it is taken up, rad/s².
const HOLD_RAD_S2: f64 = 1000.0;

/// The loops of one drive.
#[derive(Clone, Debug)]
pub(crate) struct Servo {
    p: DriveParameters,
    dt_s: f64,
    setpoint: Setpoint,
    /// Reference position and velocity.
    pub(crate) reference_rad: f64,
    reference_rad_s: f64,
    observer: Observer,
    integral_nm: f64,
    torque_nm: f64,
    /// The offset in the last step with a velocity loop, N·m.
    feed_nm: f64,
    /// Another kind of set-point has begun: the torque is to go on where it is, whatever part of it is an offset.
    taken_over: bool,
    /// Was the torque cut in the last step?
    pub(crate) limited: bool,
}

/// Third-order observer: position, velocity and the acceleration the model does not know
/// (friction, gravity), which would otherwise bias the velocity.
#[derive(Clone, Copy, Debug, Default)]
struct Observer {
    rad: f64,
    rad_s: f64,
    rad_s2: f64,
}

impl Servo {
    pub(crate) fn new(p: DriveParameters, dt_s: f64) -> Self {
        Self {
            p,
            dt_s,
            setpoint: Setpoint::Free,
            reference_rad: 0.0,
            reference_rad_s: 0.0,
            observer: Observer::default(),
            integral_nm: 0.0,
            torque_nm: 0.0,
            feed_nm: 0.0,
            taken_over: false,
            limited: false,
        }
    }

    /// The observed velocity, rad/s.
    pub(crate) const fn velocity_rad_s(&self) -> f64 {
        self.observer.rad_s
    }

    /// The substep, s.
    pub(crate) const fn dt_s(&self) -> f64 {
        self.dt_s
    }

    pub(crate) const fn setpoint(&self) -> Setpoint {
        self.setpoint
    }

    /// No torque from now on.
    pub(crate) const fn free(&mut self) {
        self.setpoint = Setpoint::Free;
    }

    /// Towards `target_rad` within `period_s`, at most as fast as `limit_rad_s`; was it cut?
    pub(crate) fn line(&mut self, target_rad: f64, period_s: f64, limit_rad_s: f64) -> bool {
        self.take_over(false);
        let wanted = (target_rad - self.reference_rad) / period_s;
        let slope_rad_s = wanted.clamp(-limit_rad_s, limit_rad_s);
        self.setpoint = Setpoint::Line { slope_rad_s };
        // Exact test: the clamp either returns its argument or a bound.
        wanted.abs() > limit_rad_s
    }

    /// Follows a velocity.
    pub(crate) fn speed(&mut self, rad_s: f64) {
        self.take_over(false);
        self.setpoint = Setpoint::Speed { rad_s };
    }

    /// Gives a torque.
    pub(crate) const fn torque(&mut self, nm: f64) {
        self.setpoint = Setpoint::Torque { nm };
    }

    /// Ramps to a velocity.
    pub(crate) fn jog(&mut self, rad_s: f64, ramp_rad_s2: f64) {
        self.take_over(true);
        self.setpoint = Setpoint::Jog { rad_s, ramp_rad_s2 };
    }

    /// To standstill as fast as the velocity loop and the torque limit allow.
    pub(crate) fn brake(&mut self, unlimited: bool) {
        self.take_over(true);
        self.setpoint = Setpoint::Brake { unlimited };
    }

    /// Goes to a position.
    pub(crate) fn go(&mut self, profile: Profile) {
        self.take_over(true);
        self.setpoint = Setpoint::Profile(profile);
    }

    /// The velocity of the reference, rad/s.
    pub(crate) const fn demand_rad_s(&self) -> f64 {
        self.reference_rad_s
    }

    /// Starts the position reference where the axis is, unless it is already followed.
    fn take_over(&mut self, keep_speed: bool) {
        match self.setpoint {
            Setpoint::Line { slope_rad_s } => {
                self.reference_rad_s = slope_rad_s;
                self.taken_over |= keep_speed;
            }
            Setpoint::Jog { .. } | Setpoint::Profile(_) => self.taken_over |= !keep_speed,
            Setpoint::Free => {
                self.reference_rad = self.observer.rad;
                self.reference_rad_s = 0.0;
                self.integral_nm = 0.0;
                self.taken_over = false;
            }
            Setpoint::Speed { .. } | Setpoint::Torque { .. } | Setpoint::Brake { .. } => {
                self.reference_rad = self.observer.rad;
                self.reference_rad_s = if keep_speed { self.observer.rad_s } else { 0.0 };
                if matches!(self.setpoint, Setpoint::Torque { .. }) {
                    (self.integral_nm, self.feed_nm) = (self.torque_nm, 0.0);
                    self.taken_over = true;
                }
            }
        }
    }

    /// Does the axis stand, after a ramp to standstill?
    pub(crate) fn stands(&self) -> bool {
        let done = match self.setpoint {
            Setpoint::Jog { .. } | Setpoint::Profile(_) => self.reference_rad_s.abs() < 1e-9,
            Setpoint::Brake { .. } => false,
            Setpoint::Free
            | Setpoint::Line { .. }
            | Setpoint::Speed { .. }
            | Setpoint::Torque { .. } => true,
        };
        done && self.observer.rad_s.abs() < STANDSTILL_RAD_S
    }

    /// One substep: the torque, N·m, at the measured position. `offset_nm` is added in every mode
    /// with torque; the sum is limited to ±`limit_nm`.
    #[inline]
    pub(crate) fn step(&mut self, measured_rad: f64, offset: Offset, limit_nm: f64) -> f64 {
        self.observe(measured_rad);
        if matches!(self.setpoint, Setpoint::Brake { .. })
            && self.observer.rad_s.abs() < STANDSTILL_RAD_S
        {
            self.take_over(false);
            self.setpoint = Setpoint::Jog {
                rad_s: 0.0,
                ramp_rad_s2: HOLD_RAD_S2,
            };
        }
        let (velocity, wanted_nm) = match self.setpoint {
            Setpoint::Free => {
                (self.torque_nm, self.limited) = (0.0, false);
                return 0.0;
            }
            Setpoint::Torque { nm } => return self.limit(nm + offset.nm, limit_nm),
            Setpoint::Speed { rad_s } => (rad_s + offset.rad_s, offset.nm),
            Setpoint::Brake { .. } => (0.0, 0.0),
            Setpoint::Line { slope_rad_s } => {
                self.reference_rad += slope_rad_s * self.dt_s;
                self.reference_rad_s = slope_rad_s;
                (
                    self.position_loop(measured_rad, slope_rad_s + offset.rad_s),
                    offset.nm,
                )
            }
            Setpoint::Jog { rad_s, ramp_rad_s2 } => {
                let most = ramp_rad_s2 * self.dt_s;
                self.reference_rad_s += (rad_s - self.reference_rad_s).clamp(-most, most);
                self.reference_rad += self.reference_rad_s * self.dt_s;
                (self.position_loop(measured_rad, self.reference_rad_s), 0.0)
            }
            Setpoint::Profile(profile) => {
                (self.reference_rad, self.reference_rad_s) =
                    profile.step(self.reference_rad, self.reference_rad_s, self.dt_s);
                (self.position_loop(measured_rad, self.reference_rad_s), 0.0)
            }
        };
        self.velocity_loop(velocity, wanted_nm, limit_nm)
    }

    fn position_loop(&self, measured_rad: f64, feed_rad_s: f64) -> f64 {
        feed_rad_s + self.p.position_bandwidth * (self.reference_rad - measured_rad)
    }

    fn velocity_loop(&mut self, rad_s: f64, feed_nm: f64, limit_nm: f64) -> f64 {
        let gain = self.p.inertia_kg_m2 * self.p.velocity_bandwidth;
        let error = rad_s - self.observer.rad_s;
        if self.taken_over {
            self.integral_nm += self.feed_nm - feed_nm;
            self.taken_over = false;
        }
        self.feed_nm = feed_nm;
        let torque = self.limit(gain * error + self.integral_nm + feed_nm, limit_nm);
        // Anti-windup: no integration further into the limit.
        if !self.limited || error * torque < 0.0 {
            self.integral_nm += gain * self.p.velocity_integral * error * self.dt_s;
            self.integral_nm = self.integral_nm.clamp(-limit_nm, limit_nm);
        }
        torque
    }

    fn limit(&mut self, nm: f64, limit_nm: f64) -> f64 {
        self.limited = nm.abs() > limit_nm;
        self.torque_nm = nm.clamp(-limit_nm, limit_nm);
        self.torque_nm
    }

    fn observe(&mut self, measured_rad: f64) {
        let (w, dt) = (self.p.observer_bandwidth, self.dt_s);
        let o = &mut self.observer;
        let error = measured_rad - o.rad;
        let model = self.torque_nm / self.p.inertia_kg_m2;
        o.rad += dt * (o.rad_s + 3.0 * w * error);
        o.rad_s += dt * (model + o.rad_s2 + 3.0 * w * w * error);
        o.rad_s2 += dt * w * w * w * error;
    }

    /// Puts the observer to rest at a position: power-up.
    pub(crate) fn rest_at(&mut self, rad: f64) {
        self.observer = Observer {
            rad,
            ..Observer::default()
        };
        self.reference_rad = rad;
        self.reference_rad_s = 0.0;
    }
}

/// The offsets the node may add in the cyclic modes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Offset {
    /// Object 60B1.
    pub(crate) rad_s: f64,
    /// Object 60B2.
    pub(crate) nm: f64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const DT: f64 = 0.000_25;

    proptest! {
        #[test]
        fn a_profile_keeps_its_limits_and_ends_at_the_target(
            target in -300.0..300.0_f64, start in -50.0..50.0_f64,
            speed in 1.0..200.0_f64, up in 50.0..2000.0_f64, down in 50.0..2000.0_f64,
        ) {
            let profile = Profile { target_rad: target, rad_s: speed, accelerate_rad_s2: up, decelerate_rad_s2: down };
            let (mut rad, mut rad_s) = (0.0, start);
            let mut ended = false;
            let steepest = if up > down { up } else { down };
            // the slowest: 350 rad at 1 rad/s
            for _ in 0..2_000_000 {
                let before = rad_s;
                (rad, rad_s) = profile.step(rad, rad_s, DT);
                // 1e-9: rounding of one step
                prop_assert!((rad_s - before).abs() <= steepest * DT + 1e-9, "{before} {rad_s}");
                if start.abs() <= speed {
                    prop_assert!(rad_s.abs() <= speed + 1e-9);
                }
                // the last step puts it there exactly
                if rad.total_cmp(&target).is_eq() && rad_s.abs() < f64::MIN_POSITIVE {
                    ended = true;
                    break;
                }
            }
            prop_assert!(ended, "{rad} {rad_s}");
        }
    }
}
