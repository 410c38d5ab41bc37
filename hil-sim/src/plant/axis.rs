//! One motor with its receptors, and with a load of its own where it has one.

use super::motor::{Motor, Winding};
use super::random::SplitMix64;
use super::receptors::Receptors;
pub use super::receptors::{Broken, EncoderFault, Sensed};

/// The physics of one axis, referred to the motor shaft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlantParameters {
    /// Torque per current, N·m/A.
    pub torque_constant_nm_a: f64,
    /// Rotor and mean reflected load, kg·m²: what the axis moves where no other moves it.
    pub inertia_kg_m2: f64,
    /// Viscous friction, N·m·s/rad.
    pub viscous_nms_rad: f64,
    /// Coulomb friction, N·m.
    pub coulomb_nm: f64,
    /// What friction at rest is more than that, N·m; 0 where nobody knows it.
    pub stiction_nm: f64,
    /// Velocity over which that falls by e, rad/s (Stribeck).
    pub stribeck_rad_s: f64,
    /// Holding torque of the closed brake, N·m.
    pub brake_nm: f64,
    /// Greatest current of the power stage, A.
    pub current_limit_a: f64,
    /// Time constant of the current loop, s.
    pub current_time_s: f64,
    /// Its electrics and heat; none where nobody knows them: then the supply gives what is wanted.
    pub winding: Option<Winding>,
    /// Encoder increments per motor turn.
    pub increments_per_turn: u32,
    /// Increments during which the index is active, from the one at motor angle 0 on; 1 for an index that is gated
    /// with the increments.
    pub index_increments: u32,
    /// The encoder counts from motor angle 0, turns included, and not from power-up.
    pub absolute: bool,
    /// The home switch is active below this motor angle, rad.
    pub switch_rad: f64,
    /// The home switch releases this much above, rad.
    pub switch_hysteresis_rad: f64,
    /// After a change the home switch bounces for so long, s.
    pub bounce_s: f64,
    /// Limit switches: active below the first, above the second motor angle, rad.
    pub limit_rad: [f64; 2],
    /// Hard stops, rad.
    pub stop_rad: [f64; 2],
    /// From the release to the open brake, s.
    pub brake_open_s: f64,
    /// From the command to the closed brake, s.
    pub brake_close_s: f64,
}

/// What the drive commands.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Drive {
    /// Torque demanded of the motor, N·m.
    pub torque_nm: f64,
    /// Is the brake energised, that is, to be open?
    pub release_brake: bool,
}

/// What acts on a motor shaft in one substep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Effort {
    /// Torque of the motor, N·m.
    pub(crate) torque_nm: f64,
    /// Dry friction and holding torque of the brake, N·m.
    pub(crate) dry_nm: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Brake {
    Closed,
    /// Opens when the time left is over, s.
    Opening(f64),
    Open,
    /// Closes when the time left is over, s.
    Closing(f64),
}

/// One motor, moved on in fixed substeps.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisPlant {
    parameters: PlantParameters,
    step: Step,
    angle_rad: f64,
    velocity_rad_s: f64,
    motor: Motor,
    brake: Brake,
    receptors: Receptors,
}

/// Constants of one substep.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Step {
    dt_s: f64,
    /// Velocity per torque, with the viscous friction taken at the end of the substep.
    velocity_per_torque: f64,
    /// Velocity kept over a substep by viscous friction.
    kept: f64,
}

impl Step {
    fn new(p: &PlantParameters, dt_s: f64) -> Self {
        let kept = 1.0 / (1.0 + dt_s * p.viscous_nms_rad / p.inertia_kg_m2);
        Self {
            dt_s,
            velocity_per_torque: dt_s / p.inertia_kg_m2 * kept,
            kept,
        }
    }
}

impl AxisPlant {
    /// A plant at rest at motor angle `start_rad`, braked, integrated in substeps of `dt_s`.
    #[must_use]
    pub fn new(parameters: PlantParameters, start_rad: f64, dt_s: f64, random: SplitMix64) -> Self {
        let motor = Motor::new(
            parameters.torque_constant_nm_a,
            parameters.current_limit_a,
            parameters.current_time_s,
            parameters.winding,
            dt_s,
        );
        Self {
            parameters,
            step: Step::new(&parameters, dt_s),
            angle_rad: start_rad,
            velocity_rad_s: 0.0,
            motor,
            brake: Brake::Closed,
            receptors: Receptors::new(&parameters, start_rad, random),
        }
    }

    /// The true motor angle, rad: 0 where homing ends.
    #[must_use]
    pub const fn angle_rad(&self) -> f64 {
        self.angle_rad
    }

    /// The true motor velocity, rad/s.
    #[must_use]
    pub const fn velocity_rad_s(&self) -> f64 {
        self.velocity_rad_s
    }

    /// Is the brake closed?
    #[must_use]
    pub fn is_braked(&self) -> bool {
        self.brake == Brake::Closed
    }

    /// What the receptors say after the last substep.
    #[must_use]
    pub const fn sensed(&self) -> &Sensed {
        &self.receptors.sensed
    }

    /// Breaks or mends receptors.
    pub fn set_broken(&mut self, broken: Broken) {
        self.receptors.set_broken(broken);
    }

    /// What is wrong with its receptors.
    #[must_use]
    pub const fn broken(&self) -> Broken {
        self.receptors.broken()
    }

    /// Temperature of the motor's winding, °C, where it is known.
    #[must_use]
    pub fn winding_c(&self) -> Option<f64> {
        self.motor.winding_c()
    }

    /// Is the thermal switch in the motor's winding open?
    #[must_use]
    pub fn is_hot(&self) -> bool {
        self.motor.is_hot()
    }

    /// Its constants.
    #[must_use]
    pub(crate) const fn parameters(&self) -> &PlantParameters {
        &self.parameters
    }

    /// One substep of an axis with a load of its own, under the drive's command and a load torque, N·m,
    /// on the motor shaft.
    ///
    /// Semi-implicit Euler; friction is taken implicitly, so that it never turns the motion round.
    #[inline]
    pub fn step(&mut self, command: Drive, load_nm: f64) {
        let Effort { torque_nm, dry_nm } = self.actuate(command);
        let torque = torque_nm + load_nm;
        let free = self.velocity_rad_s * self.step.kept + torque * self.step.velocity_per_torque;
        let friction = dry_nm * self.step.velocity_per_torque;
        let velocity = if free > friction {
            free - friction
        } else if free < -friction {
            free + friction
        } else {
            0.0
        };
        let angle = self.angle_rad + velocity * self.step.dt_s;
        let [low, high] = self.parameters.stop_rad;
        if angle < low {
            self.moved(low, 0.0);
        } else if angle > high {
            self.moved(high, 0.0);
        } else {
            self.moved(angle, velocity);
        }
    }

    /// Current loop and brake, one substep on: what then acts on the shaft. A command that is no number
    /// is no torque.
    #[inline]
    pub(crate) fn actuate(&mut self, command: Drive) -> Effort {
        let torque_nm = self.motor.step(command.torque_nm, self.velocity_rad_s);
        let held = self.turn_brake(command.release_brake);
        Effort {
            torque_nm,
            dry_nm: self.friction_nm() + held,
        }
    }

    /// Dry friction at the velocity at the beginning of the substep, N·m.
    #[inline]
    fn friction_nm(&self) -> f64 {
        let p = &self.parameters;
        if p.stiction_nm > 0.0 {
            let x = self.velocity_rad_s / p.stribeck_rad_s;
            p.coulomb_nm + p.stiction_nm * libm::exp(-x * x)
        } else {
            p.coulomb_nm
        }
    }

    /// The shaft is at this angle, rad, and velocity, rad/s, at the end of the substep.
    #[inline]
    pub(crate) fn moved(&mut self, angle_rad: f64, velocity_rad_s: f64) {
        (self.angle_rad, self.velocity_rad_s) = (angle_rad, velocity_rad_s);
        let current_a = self.motor.current_a();
        self.receptors
            .sense(&self.parameters, angle_rad, current_a, self.step.dt_s);
    }

    /// Moves the brake on; the torque it holds with, N·m.
    fn turn_brake(&mut self, release: bool) -> f64 {
        let dt = self.step.dt_s;
        self.brake = match (self.brake, release) {
            (Brake::Open, true) => return 0.0,
            (Brake::Closed, false) => return self.parameters.brake_nm,
            (Brake::Closed | Brake::Closing(_), true) => {
                Brake::Opening(self.parameters.brake_open_s)
            }
            (Brake::Open | Brake::Opening(_), false) => {
                Brake::Closing(self.parameters.brake_close_s)
            }
            (Brake::Opening(left), true) if left > dt => Brake::Opening(left - dt),
            (Brake::Opening(_), true) => Brake::Open,
            (Brake::Closing(left), false) if left > dt => Brake::Closing(left - dt),
            (Brake::Closing(_), false) => Brake::Closed,
        };
        match self.brake {
            Brake::Closed | Brake::Opening(_) => self.parameters.brake_nm,
            Brake::Open | Brake::Closing(_) => 0.0,
        }
    }
}

#[cfg(test)]
mod tests;
