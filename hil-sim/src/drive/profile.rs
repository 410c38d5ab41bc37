//! The modes in which the drive makes its way itself: profile position (pp) and profile velocity (pv).
//!
//! ```text
//!  controlword bit 4 ──┐     ┌──────┐          a new set-point with each rising edge
//!                      └─────┘      └────
//!  statusword bit 12   ──┐      ┌─────┐        it was taken; low again: the next one may come
//!                        └──────┘     └──
//! ```
//! One set-point is on its way and one may wait, unless bit 5 says that the new one counts at once.

use core::f64::consts::TAU;

use protocol::canopen::cia402::{Controlword, Mode};

use super::parameters::MS;
use super::servo::{Profile, Setpoint};
use super::{SimDrive, slots};

/// What pp and pv remember.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Way {
    /// The set-point on its way, drive units.
    target: Option<i64>,
    /// The set-point behind it.
    next: Option<i64>,
    /// Was a set-point taken since bit 4 rose?
    taken: bool,
    /// Is bit 4 high?
    asked: bool,
    /// The velocity without the noise of the encoder's increments, rad/s.
    smooth_rad_s: f64,
    /// Since when the axis is within the window of its target, ns.
    within_since_ns: Option<u64>,
    /// Since when it stands, ns.
    standing_since_ns: Option<u64>,
}

/// Time constant of the velocity that is compared with a window, s. ASSUMED.
const SMOOTHING_S: f64 = 0.02;

impl Way {
    /// Statusword bit 12 in pp: the set-point was taken, or none can be taken yet.
    pub(super) const fn acknowledges(&self) -> bool {
        self.taken && (self.asked || self.next.is_some())
    }
}

impl SimDrive {
    /// A controlword in pp.
    pub(super) fn ask(&mut self, word: Controlword, before: Controlword) {
        self.way.asked = word.has(Controlword::OPERATION_4);
        if !word.rises(before, Controlword::OPERATION_4) {
            if !self.way.asked && self.way.next.is_none() {
                self.way.taken = false;
            }
            return;
        }
        if self.way.next.is_some() && !word.has(Controlword::CHANGE_AT_ONCE) {
            // no room: bit 12 said so
            return;
        }
        let wanted = i64::from(self.od.signed(slots::TARGET_POSITION));
        let wanted = if word.has(Controlword::RELATIVE) {
            let from = self.way.next.or(self.way.target);
            from.unwrap_or_else(|| self.position_units()) + wanted
        } else {
            wanted
        };
        let (target, cut) = self.within_soft_limits(wanted);
        self.cut = cut;
        self.way.taken = true;
        let on_its_way = self.way.target.is_some() && !self.has_arrived();
        if on_its_way && !word.has(Controlword::CHANGE_AT_ONCE) {
            self.way.next = Some(target);
        } else {
            self.way.next = None;
            self.set_out(target);
        }
    }

    fn set_out(&mut self, target: i64) {
        self.way.target = Some(target);
        self.way.within_since_ns = None;
        let units = self.scale.units_per_rad;
        let of = |slot| f64::from(self.od.get(slot)) / units;
        let profile = Profile {
            target_rad: self.scale.rad_of_units(target),
            rad_s: self.greatest_rad_s(of(slots::PROFILE_VELOCITY)),
            accelerate_rad_s2: of(slots::PROFILE_ACCELERATION),
            decelerate_rad_s2: of(slots::PROFILE_DECELERATION),
        };
        self.servo.go(profile);
    }

    /// `wanted`, at most what 607F and 6080 allow, rad/s.
    fn greatest_rad_s(&self, wanted: f64) -> f64 {
        let profile =
            f64::from(self.od.get(slots::MAX_PROFILE_VELOCITY)) / self.scale.units_per_rad;
        let motor = f64::from(self.od.get(slots::MAX_SPEED)) * TAU / 60.0;
        wanted.clamp(-profile, profile).clamp(-motor, motor)
    }

    /// The position of a target within the software limits, and whether they cut it.
    pub(super) fn within_soft_limits(&self, wanted: i64) -> (i64, bool) {
        let low = i64::from(self.od.signed(slots::SOFT_LIMIT_LOW));
        let high = i64::from(self.od.signed(slots::SOFT_LIMIT_HIGH));
        if low >= high {
            return (wanted, false);
        }
        let target = wanted.clamp(low, high);
        (target, target != wanted)
    }

    /// Would this velocity, slowed down at 6084, carry the axis over a software limit?
    pub(super) fn runs_over(&self, rad_s: f64) -> bool {
        let Some(limit) = self.limit_towards(rad_s).filter(|_| rad_s != 0.0) else {
            return false;
        };
        let room = self.scale.rad_of_units(limit) - self.scale.rad(self.sensed.count);
        let room = if rad_s < 0.0 { -room } else { room };
        let slow_down =
            f64::from(self.od.get(slots::PROFILE_DECELERATION)) / self.scale.units_per_rad;
        rad_s * rad_s >= 2.0 * slow_down * room.clamp(0.0, f64::INFINITY)
    }

    /// One substep of pp and pv.
    pub(super) fn make_way(&mut self) {
        match self.mode {
            Mode::Pp => {
                // after a halt or a quick stop that stood: on towards the target
                if let (Some(target), false) = (
                    self.way.target,
                    matches!(self.servo.setpoint(), Setpoint::Profile(_)),
                ) {
                    self.set_out(target);
                }
                if self.has_arrived()
                    && let Some(next) = self.way.next.take()
                {
                    self.way.taken = self.way.asked;
                    self.set_out(next);
                }
            }
            Mode::Pv => {
                let units = self.scale.units_per_rad;
                let wanted = f64::from(self.od.signed(slots::TARGET_VELOCITY)) / units;
                let allowed = self.greatest_rad_s(wanted);
                // exact: a clamp returns its argument or a bound
                #[expect(clippy::float_cmp, reason = "see above")]
                let cut = allowed != wanted;
                self.cut = cut || self.runs_over(allowed);
                self.speed_up_to(allowed);
            }
            Mode::None | Mode::Homing | Mode::Csp | Mode::Csv | Mode::Cst => return,
        }
        self.time_windows();
    }

    /// pv: towards a velocity; where there are software limits, on a way that ends at them.
    fn speed_up_to(&mut self, rad_s: f64) {
        let units = self.scale.units_per_rad;
        let of = |slot| f64::from(self.od.get(slot)) / units;
        let (accelerate, decelerate) = (
            of(slots::PROFILE_ACCELERATION),
            of(slots::PROFILE_DECELERATION),
        );
        let now = self.servo.demand_rad_s();
        let limit = self.limit_towards(rad_s).filter(|_| rad_s != 0.0);
        let Some(limit) = limit else {
            let slower = rad_s.abs() < now.abs() || rad_s * now < 0.0;
            let ramp = if slower { decelerate } else { accelerate };
            self.servo.jog(rad_s, ramp);
            return;
        };
        let target_rad = self.scale.rad_of_units(limit);
        let beyond = (target_rad - self.demand_rad()) * rad_s <= 0.0;
        if beyond {
            self.servo.jog(0.0, decelerate);
            return;
        }
        self.servo.go(Profile {
            target_rad,
            rad_s: rad_s.abs(),
            accelerate_rad_s2: accelerate,
            decelerate_rad_s2: decelerate,
        });
    }

    /// The software limit in the direction of a velocity, drive units.
    fn limit_towards(&self, rad_s: f64) -> Option<i64> {
        let low = i64::from(self.od.signed(slots::SOFT_LIMIT_LOW));
        let high = i64::from(self.od.signed(slots::SOFT_LIMIT_HIGH));
        (low < high).then_some(if rad_s < 0.0 { low } else { high })
    }

    /// Has the reference come to the target?
    fn has_arrived(&self) -> bool {
        match (self.servo.setpoint(), self.way.target) {
            (Setpoint::Profile(profile), Some(_)) => {
                let left = profile.target_rad - self.servo.reference_rad;
                left.abs() < 1e-9 && self.servo.demand_rad_s().abs() < 1e-9
            }
            (_, _) => false,
        }
    }

    fn time_windows(&mut self) {
        let units = self.scale.units_per_rad;
        let noise = self.servo.velocity_rad_s() - self.way.smooth_rad_s;
        self.way.smooth_rad_s += noise * self.servo.dt_s() / SMOOTHING_S;
        let velocity = self.way.smooth_rad_s * units;
        let within = match self.mode {
            Mode::Pp => self.way.target.is_some_and(|target| {
                let away = (target - self.position_units()).unsigned_abs();
                self.has_arrived() && away <= u64::from(self.od.get(slots::POSITION_WINDOW))
            }),
            Mode::Pv => {
                let away = f64::from(self.od.signed(slots::TARGET_VELOCITY)) - velocity;
                away.abs() <= f64::from(self.od.get(slots::VELOCITY_WINDOW))
            }
            Mode::None | Mode::Homing | Mode::Csp | Mode::Csv | Mode::Cst => false,
        };
        let stands = velocity.abs() < f64::from(self.od.get(slots::VELOCITY_THRESHOLD));
        let now = self.now_ns;
        let since = |on: bool, since: Option<u64>| on.then(|| since.unwrap_or(now));
        self.way.within_since_ns = since(within, self.way.within_since_ns);
        self.way.standing_since_ns = since(stands, self.way.standing_since_ns);
    }

    /// Is the target reached for as long as the window's time?
    pub(super) fn has_reached(&self) -> bool {
        let slot = match self.mode {
            Mode::Pp => slots::POSITION_WINDOW_TIME,
            Mode::Pv => slots::VELOCITY_WINDOW_TIME,
            Mode::None | Mode::Homing | Mode::Csp | Mode::Csv | Mode::Cst => return false,
        };
        self.lasted(self.way.within_since_ns, slot) && self.way.next.is_none()
    }

    /// pv: does the axis stand?
    pub(super) fn is_slow(&self) -> bool {
        self.lasted(self.way.standing_since_ns, slots::VELOCITY_THRESHOLD_TIME)
    }

    fn lasted(&self, since: Option<u64>, slot: usize) -> bool {
        since.is_some_and(|since| self.now_ns - since >= u64::from(self.od.get(slot)) * MS)
    }
}
