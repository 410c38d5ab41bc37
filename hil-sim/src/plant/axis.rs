//! One motor with its receptors, and with a load of its own where it has one.

use core::f64::consts::TAU;

use super::random::SplitMix64;

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
    /// Holding torque of the closed brake, N·m.
    pub brake_nm: f64,
    /// Greatest current of the power stage, A.
    pub current_limit_a: f64,
    /// Time constant of the current loop, s.
    pub current_time_s: f64,
    /// Encoder increments per motor turn.
    pub increments_per_turn: u32,
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

/// What the drive receives from its axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sensed {
    /// Encoder count since power-up, or from motor angle 0 of an absolute encoder.
    pub count: i64,
    /// The count at an index pulse that passed in this substep.
    pub index: Option<i64>,
    /// Home switch.
    pub home: bool,
    /// Negative limit switch.
    pub negative_limit: bool,
    /// Positive limit switch.
    pub positive_limit: bool,
    /// Motor current, A.
    pub current_a: f64,
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

/// Faults of the axis' receptors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Broken {
    /// The encoder count is frozen.
    pub encoder: bool,
    /// The home switch is stuck at this level.
    pub switch: Option<bool>,
    /// No index pulse is reported.
    pub index: bool,
}

/// One motor, moved on in fixed substeps.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisPlant {
    parameters: PlantParameters,
    step: Step,
    angle_rad: f64,
    velocity_rad_s: f64,
    current_a: f64,
    brake: Brake,
    /// The encoder count is `floor(angle · increments / 2π − phase)`.
    phase: f64,
    /// Motor angles at which the next index pulses lie, below and above.
    index_rad: [f64; 2],
    bounce_left_s: f64,
    switch: bool,
    random: SplitMix64,
    broken: Broken,
    sensed: Sensed,
}

/// Constants of one substep.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Step {
    dt_s: f64,
    /// Velocity per torque, with the viscous friction taken at the end of the substep.
    velocity_per_torque: f64,
    /// Velocity kept over a substep by viscous friction.
    kept: f64,
    /// Part of the distance to its demand the current covers.
    current_part: f64,
    /// Increments per radian.
    increments_per_rad: f64,
}

impl Step {
    fn new(p: &PlantParameters, dt_s: f64) -> Self {
        let kept = 1.0 / (1.0 + dt_s * p.viscous_nms_rad / p.inertia_kg_m2);
        let current_part = if p.current_time_s > 0.0 {
            1.0 - libm::exp(-dt_s / p.current_time_s)
        } else {
            1.0
        };
        Self {
            dt_s,
            velocity_per_torque: dt_s / p.inertia_kg_m2 * kept,
            kept,
            current_part,
            increments_per_rad: f64::from(p.increments_per_turn) / TAU,
        }
    }
}

impl AxisPlant {
    /// A plant at rest at motor angle `start_rad`, braked, integrated in substeps of `dt_s`.
    #[must_use]
    pub fn new(parameters: PlantParameters, start_rad: f64, dt_s: f64, random: SplitMix64) -> Self {
        let step = Step::new(&parameters, dt_s);
        let turn = libm::floor(start_rad / TAU);
        let switch = start_rad < parameters.switch_rad;
        let mut plant = Self {
            parameters,
            step,
            angle_rad: start_rad,
            velocity_rad_s: 0.0,
            current_a: 0.0,
            brake: Brake::Closed,
            phase: if parameters.absolute {
                0.0
            } else {
                start_rad * step.increments_per_rad
            },
            index_rad: [turn * TAU, (turn + 1.0) * TAU],
            bounce_left_s: 0.0,
            switch,
            random,
            broken: Broken::default(),
            sensed: Sensed::default(),
        };
        plant.sense();
        plant
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
        &self.sensed
    }

    /// Breaks or mends receptors.
    pub const fn set_broken(&mut self, broken: Broken) {
        self.broken = broken;
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
        let limit = self.parameters.current_limit_a;
        let wanted = command.torque_nm / self.parameters.torque_constant_nm_a;
        let wanted = if wanted.is_nan() {
            0.0
        } else {
            wanted.clamp(-limit, limit)
        };
        self.current_a += self.step.current_part * (wanted - self.current_a);
        let held = self.turn_brake(command.release_brake);
        Effort {
            torque_nm: self.current_a * self.parameters.torque_constant_nm_a,
            dry_nm: self.parameters.coulomb_nm + held,
        }
    }

    /// The shaft is at this angle, rad, and velocity, rad/s, at the end of the substep.
    #[inline]
    pub(crate) fn moved(&mut self, angle_rad: f64, velocity_rad_s: f64) {
        (self.angle_rad, self.velocity_rad_s) = (angle_rad, velocity_rad_s);
        self.sense();
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

    fn sense(&mut self) {
        let count = floor(self.angle_rad * self.step.increments_per_rad - self.phase);
        self.sensed.index = None;
        let [below, above] = self.index_rad;
        if self.angle_rad < below {
            self.pass_index(below, [below - TAU, below]);
        } else if self.angle_rad >= above {
            self.pass_index(above, [above, above + TAU]);
        }
        if !self.broken.encoder {
            self.sensed.count = count;
        }
        let [low, high] = self.parameters.limit_rad;
        self.sensed.negative_limit = self.angle_rad < low;
        self.sensed.positive_limit = self.angle_rad > high;
        self.sensed.current_a = self.current_a;
        self.sense_switch();
    }

    /// The pulse at `at` passed; `between` are the next ones.
    fn pass_index(&mut self, at: f64, between: [f64; 2]) {
        self.index_rad = between;
        if !self.broken.index && !self.broken.encoder {
            self.sensed.index = Some(floor(at * self.step.increments_per_rad - self.phase));
        }
    }

    fn sense_switch(&mut self) {
        let p = &self.parameters;
        let edge = p.switch_rad
            + if self.switch {
                p.switch_hysteresis_rad
            } else {
                0.0
            };
        let active = self.angle_rad < edge;
        if active != self.switch {
            self.switch = active;
            self.bounce_left_s = p.bounce_s;
        }
        self.sensed.home = if let Some(stuck) = self.broken.switch {
            stuck
        } else if self.bounce_left_s > 0.0 {
            self.bounce_left_s -= self.step.dt_s;
            self.random.coin()
        } else {
            self.switch
        };
    }
}

/// The greatest integer not above `x`; much faster than `libm::floor`, for numbers below 2⁶³.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    reason = "encoder counts stay far below 2^53"
)]
#[inline]
fn floor(x: f64) -> i64 {
    let cut = x as i64;
    if cut as f64 > x { cut - 1 } else { cut }
}

#[cfg(test)]
mod tests;
