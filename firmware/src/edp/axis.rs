//! One axis in the servo loop: positions, regulators, monitors.

use crate::edp::servo::{Demand, FeedForwardGains, FeedForwardState, OriginalGains, OriginalState};
use motion::Angle;
use motion::angle::Ratio;
use protocol::canopen::axis::Target;
use protocol::canopen::cia402::{Goal, Master, PowerState, Statusword};
use protocol::message::ServoLaw;
use protocol::units::{UNITS_PER_INCREMENT, modulo, nearest};

/// Constants of one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisConstants {
    /// Drive units per rad of the motor shaft.
    pub units_per_rad: f64,
    /// Drive units per quantum of a motor angle.
    pub units_per_quantum: Ratio,
    /// Rad of the motor shaft per drive unit.
    pub rad_per_unit: f32,
    /// Torque constant, N·m/A = mN·m/mA.
    pub torque_constant: f32,
    /// The original's regulator.
    pub original: OriginalGains,
    /// The modern regulator.
    pub feed_forward: FeedForwardGains,
    /// Following error at which the axis trips at full speed, drive units.
    pub following_window: f32,
    /// The same at standstill, drive units.
    pub window_at_rest: i64,
    /// Velocity at which the whole window is open, rad/s.
    pub full_speed: f32,
    /// The encoder cannot move farther in one step, drive units.
    pub jump_units: i64,
}

/// The set-point of one axis: position, and what is fed forward, rad of the motor shaft per s and per s².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reference {
    /// Motor angle.
    pub position: Angle,
    /// rad/s
    pub velocity: f32,
    /// rad/s²
    pub acceleration: f32,
}

/// The share of a step in the mean of the torque that holds an axis: of the last 16 steps, about.
const MEAN_SHARE: f32 = 1.0 / 16.0;

/// What is open at standstill of a window of the following error, drive units: two fifths.
pub(super) const fn at_rest(window: i64) -> i64 {
    window.saturating_mul(2) / 5
}

/// The variable state of one axis.
///
/// Positions have 61 bits: an [`Angle`]'s 63 in units that are eight quanta and more. So differences are exact, and do not
/// wrap.
#[derive(Clone, Debug)]
pub struct Axis {
    constants: AxisConstants,
    /// Drive units at motor angle 0.
    zero: i64,
    /// Homed since power-up.
    pub homed: bool,
    /// Towards the drive's power state.
    pub master: Master,
    law: ServoLaw,
    original: OriginalState,
    modern: FeedForwardState,
    actual: i64,
    known: bool,
    /// What has held it in the last steps, ‰: at rest the torque itself shows the encoder's increments.
    mean_torque: f32,
    /// Demands of the last steps, drive units, newest first.
    demands: [i64; 3],
    following_error_max: u32,
    /// The drive is about to change between position and torque: the torque, ‰, that holds the axis.
    handover: Option<i16>,
}

impl Axis {
    /// Nothing known yet.
    #[must_use]
    pub fn new(constants: AxisConstants, law: ServoLaw) -> Self {
        Self {
            constants,
            zero: 0,
            homed: false,
            master: Master::default(),
            law,
            original: OriginalState::default(),
            modern: FeedForwardState::default(),
            actual: 0,
            known: false,
            mean_torque: 0.0,
            demands: [0; 3],
            following_error_max: 0,
            handover: None,
        }
    }

    /// Its constants.
    #[must_use]
    pub const fn constants(&self) -> &AxisConstants {
        &self.constants
    }

    /// Motor angle of a position in drive units.
    #[must_use]
    pub fn angle(&self, units: i64) -> Angle {
        Angle::bound(self.rad(units))
    }

    /// The same, rad.
    #[must_use]
    #[expect(
        clippy::cast_precision_loss,
        reason = "2^53 units are years of turning"
    )]
    pub fn rad(&self, units: i64) -> f64 {
        units.wrapping_sub(self.zero) as f64 / self.constants.units_per_rad
    }

    /// Drive units of a motor angle, rounded to the nearest.
    #[must_use]
    pub const fn units(&self, angle: Angle) -> i64 {
        let units = self.constants.units_per_quantum.of(angle.quanta());
        units.wrapping_add(self.zero)
    }

    /// Measured motor angle, rad.
    #[must_use]
    pub fn actual_rad(&self) -> f64 {
        self.rad(self.actual)
    }

    /// Measured position, drive units.
    #[must_use]
    pub const fn actual(&self) -> i64 {
        self.actual
    }

    /// Measured motor angle.
    #[must_use]
    pub fn actual_angle(&self) -> Angle {
        self.angle(self.actual)
    }

    /// Measured position relative to zero, drive units.
    #[must_use]
    pub const fn actual_from_zero(&self) -> i64 {
        self.actual.wrapping_sub(self.zero)
    }

    /// The demand that belongs to the measured position, relative to zero, drive units.
    ///
    /// In csp the drive attains the target it latched one SYNC earlier; in cst the loop is closed
    /// here, on the demand of this very step.
    #[must_use]
    pub const fn demand_from_zero(&self) -> i64 {
        let [now, _, before] = self.demands;
        let demand = match self.law {
            ServoLaw::DrivePosition => before,
            ServoLaw::Original | ServoLaw::FeedForward | ServoLaw::ComputedTorque => now,
        };
        demand.wrapping_sub(self.zero)
    }

    /// The demand just made, relative to zero, drive units.
    #[must_use]
    pub const fn latest_demand_from_zero(&self) -> i64 {
        let [now, ..] = self.demands;
        now.wrapping_sub(self.zero)
    }

    /// Demand minus actual of the same instant, drive units.
    const fn following_error(&self) -> i64 {
        self.demand_from_zero()
            .wrapping_sub(self.actual_from_zero())
    }

    /// Demand minus actual of the same instant, rad.
    #[must_use]
    pub fn following_error_rad(&self) -> f64 {
        f64::from(float(self.following_error()) * self.constants.rad_per_unit)
    }

    /// Greatest following error since it was last asked for, drive units.
    pub const fn take_following_error(&mut self) -> u32 {
        let worst = self.following_error_max;
        self.following_error_max = 0;
        worst
    }

    /// The position, drive units, that the drive's 32 bits mean: of all that differ by 2³² the one
    /// nearest to the last measured.
    #[must_use]
    pub fn unwrapped(&self, units: i32) -> i64 {
        if self.known {
            nearest(units, self.actual)
        } else {
            i64::from(units)
        }
    }

    /// A new measurement, drive units and ‰ of the rated torque; `false` if the encoder cannot have moved that
    /// far.
    pub fn measure(&mut self, units: i32, torque: i16) -> bool {
        self.mean_torque += (f32::from(torque) - self.mean_torque) * MEAN_SHARE;
        let units = self.unwrapped(units);
        let plausible = !self.known
            || units.wrapping_sub(self.actual).wrapping_abs() <= self.constants.jump_units;
        self.actual = units;
        self.known = true;
        plausible
    }

    /// Hold where the axis stands; regulators start from the torque that holds it now.
    pub fn settle(&mut self, current_ma: f32) {
        self.demands = [self.actual; 3];
        self.original = OriginalState::holding(&self.constants.original, current_ma);
        self.modern = FeedForwardState::holding(&self.constants.feed_forward, current_ma);
    }

    /// Motor angle 0 is at this position from now on.
    pub const fn set_zero(&mut self, units: i64) {
        self.zero = units;
        self.homed = true;
    }

    /// The zero, drive units.
    #[must_use]
    pub const fn zero(&self) -> i64 {
        self.zero
    }

    /// The law in force.
    #[must_use]
    pub const fn law(&self) -> ServoLaw {
        self.law
    }

    /// Change the law; the regulators start from the torque that holds the axis now.
    pub fn select(&mut self, law: ServoLaw, current_ma: f32) {
        self.law = law;
        self.original = OriginalState::holding(&self.constants.original, current_ma);
        self.modern = FeedForwardState::holding(&self.constants.feed_forward, current_ma);
    }

    /// The drive is asked for the other kind of target: its next target is already of that kind, so that it
    /// finds a true one when it changes.
    pub fn hand_over(&mut self) {
        self.handover = Some(per_mille(self.mean_torque));
    }

    /// Mean of the torque in the last steps, ‰ of rated.
    #[must_use]
    pub const fn mean_torque(&self) -> f32 {
        self.mean_torque
    }

    /// Is that target still to be sent?
    #[must_use]
    pub const fn is_handing_over(&self) -> bool {
        self.handover.is_some()
    }

    /// One servo step under torque: the controlword and the target for the drive.
    ///
    /// `computed_ma` is what computed torque gives it, if that is in force and can be; else feed-forward
    /// stands in for it. `offset` is the torque offset that goes with it, ‰. `rated_mnm` is the drive's rated
    /// torque in mN·m, `ts` the servo step in s.
    pub fn servo(
        &mut self,
        demand: Reference,
        computed_ma: Option<f32>,
        offset: Option<i16>,
        state: Option<PowerState>,
        rated_mnm: u32,
        ts: f32,
    ) -> Target {
        let last = self.demands;
        let [previous, before, _] = last;
        let units = self.units(demand.position);
        self.demands = [units, previous, before];
        let follows = state == Some(PowerState::OperationEnabled);
        if follows {
            let error = self.following_error().unsigned_abs();
            let error = u32::try_from(error).unwrap_or(u32::MAX);
            if error > self.following_error_max {
                self.following_error_max = error;
            }
        }
        let handover = self.handover.take();
        let ma = match self.law {
            ServoLaw::DrivePosition => {
                if let Some(torque) = handover {
                    // the offset stays until the drive gets its first target of the new law
                    return Target::Torque(torque.saturating_sub(offset.unwrap_or(0)));
                }
                return Target::Position(modulo(units));
            }
            _ if handover.is_some() => return Target::Position(modulo(units)),
            // torque only once the drive follows, else the integrals wind up
            _ if !follows => 0.0,
            ServoLaw::Original => {
                // The increments since the last step and, in them, what was left of the error.
                let demanded = increments(units.wrapping_sub(previous));
                let measured = increments(self.original.moved(self.actual));
                self.constants
                    .original
                    .step(&mut self.original, demanded, measured)
            }
            ServoLaw::FeedForward | ServoLaw::ComputedTorque => match computed_ma {
                Some(ma) if self.law == ServoLaw::ComputedTorque => {
                    // were it to stand in, feed-forward would go on from here
                    self.modern = FeedForwardState::holding(&self.constants.feed_forward, ma);
                    ma
                }
                _ => {
                    let rad = self.constants.rad_per_unit;
                    let moved = self.modern.moved(self.actual);
                    let demand = Demand {
                        error: float(units.wrapping_sub(self.actual)) * rad,
                        measured_velocity: float(moved) * rad / ts,
                        velocity: demand.velocity,
                        acceleration: demand.acceleration,
                    };
                    self.constants
                        .feed_forward
                        .step(&mut self.modern, &demand, ts)
                }
            },
        };
        let torque = 1000.0 * ma * self.constants.torque_constant / whole(rated_mnm);
        Target::Torque(per_mille(torque))
    }

    /// Without torque the demand follows the axis.
    pub fn idle(&mut self) -> Target {
        self.demands = [self.actual; 3];
        self.handover = None;
        match self.law {
            ServoLaw::DrivePosition => Target::Position(modulo(self.actual)),
            ServoLaw::Original | ServoLaw::FeedForward | ServoLaw::ComputedTorque => {
                Target::Torque(0)
            }
        }
    }

    /// The window of the following error at standstill, drive units.
    #[must_use]
    pub const fn window_at_rest(&self) -> i64 {
        self.constants.window_at_rest
    }

    /// Has the following error left its window? The window opens with speed (rad/s).
    #[must_use]
    pub fn beyond_window(&self, velocity: f32) -> bool {
        let error = libm::fabsf(float(self.following_error()));
        let (window, at_rest) = (
            self.constants.following_window,
            float(self.window_at_rest()),
        );
        let share = libm::fabsf(velocity) / self.constants.full_speed;
        let share = if share > 1.0 { 1.0 } else { share };
        error > at_rest + (window - at_rest) * share
    }

    /// Towards a power state: the controlword.
    pub fn controlword(&mut self, goal: Goal, status: Statusword) -> u16 {
        self.master.set_goal(goal);
        self.master.next(status).0
    }
}

/// Encoder increments of a distance in drive units.
#[expect(clippy::cast_precision_loss, reason = "1000")]
fn increments(units: i64) -> f32 {
    float(units) / UNITS_PER_INCREMENT as f32
}

/// A distance in drive units, which are up to 2³¹: what is longer counts as that.
#[expect(clippy::cast_precision_loss, reason = "24 bits of a distance")]
pub(super) fn float(units: i64) -> f32 {
    let end = if units < 0 { i32::MIN } else { i32::MAX };
    i32::try_from(units).unwrap_or(end) as f32
}

/// A drive's rated torque as a float.
#[expect(clippy::cast_precision_loss, reason = "24 bits are enough")]
pub(super) const fn whole(mnm: u32) -> f32 {
    mnm as f32
}

/// The nearest whole ‰ that fits.
pub(super) fn per_mille(x: f32) -> i16 {
    let bounded = if x > 32_767.0 {
        32_767.0
    } else if x < -32_767.0 {
        -32_767.0
    } else {
        libm::roundf(x)
    };
    #[expect(clippy::cast_possible_truncation, reason = "bounded above")]
    let per_mille = bounded as i16;
    per_mille
}
